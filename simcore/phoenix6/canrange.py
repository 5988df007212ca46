"""Writes the simulated state of a CANrange."""

from __future__ import annotations

from phoenix6.hardware import CANrange

from simcore.errors import require_non_negative

__all__ = ["CANrangeSim"]


class CANrangeSim:
    """A CANrange that looks at something: a piece in a hopper, the carriage above it.

    The device simulates the distance and what its proximity threshold makes of it; signal strength and ambient light
    it does not (26.3).

    Args:
        canrange: The device of the robot code.
    """

    def __init__(self, canrange: CANrange) -> None:
        self._state = canrange.sim_state

    def set_supply(self, volts: float) -> None:
        """Voltage at its terminals [V]."""
        self._state.set_supply_voltage(min(max(volts, 4.0), 16.0))

    def write(self, distance: float) -> None:
        """Say how far away the thing is [m].

        Raises:
            ConfigError: Below zero, or not finite.
        """
        require_non_negative("CANrangeSim", "distance", distance, "m")
        self._state.set_distance(distance)
