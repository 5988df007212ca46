"""Writes the simulated state of a Pigeon 2."""

from __future__ import annotations

import math
from collections.abc import Sequence

from phoenix6.hardware import Pigeon2

from simcore.phoenix6.ownership import own_writer
from simcore.phoenix6.sim_states import sim_state_of

__all__ = ["Pigeon2Sim"]

_MAX_DPS = 2047.0  # the simulated rate wraps at +-2048
_MAX_TURN_DEG = 170.0  # the device takes the short way round: a step of half a turn could go either way


class Pigeon2Sim:
    """A Pigeon 2 on the robot.

    Like the real one it starts at zero wherever the robot looks; `set_yaw` and the swerve drivetrain's resets are the
    device's and the robot code's business and do not come here. Not simulated by the device itself (26.3): quaternion,
    `getRotation3d()`, gravity vector, accelerometer, mount pose.

    Args:
        pigeon: The device of the robot code.
    """

    def __init__(self, pigeon: Pigeon2) -> None:
        self._state = state = sim_state_of(pigeon)
        self._set_yaw = own_writer(state, "set_raw_yaw")
        self._set_pitch = own_writer(state, "set_pitch")
        self._set_roll = own_writer(state, "set_roll")
        self._set_rates = [own_writer(state, f"set_angular_velocity_{axis}") for axis in "xyz"]
        self._yaw_deg = 0.0
        self._set_yaw(0.0)

    def set_supply(self, volts: float) -> None:
        """Voltage at its terminals [V]."""
        self._state.set_supply_voltage(min(max(volts, 4.0), 16.0))

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Say what it measures.

        Args:
            yaw: Since switched on, continuous over turns [rad].
            pitch: Nose down positive, as in WPILib [rad].
            roll: [rad]
            rates: About the robot's x, y, z [rad/s], shape (3,).
        """
        goal = math.degrees(yaw)
        while abs(goal - self._yaw_deg) > _MAX_TURN_DEG:
            self._yaw_deg += math.copysign(_MAX_TURN_DEG, goal - self._yaw_deg)
            self._set_yaw(self._yaw_deg)
        self._yaw_deg = goal
        self._set_yaw(goal)
        self._set_pitch(math.degrees(pitch))
        self._set_roll(math.degrees(roll))
        for set_rate, rate in zip(self._set_rates, rates, strict=True):
            set_rate(min(max(math.degrees(rate), -_MAX_DPS), _MAX_DPS))
