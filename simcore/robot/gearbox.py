"""What drives a mechanism: DC motors behind a gear, and the protocol that every mechanism sim answers."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

from wpimath.system.plant import DCMotor

from simcore.quantities import (
    CURRENT_LIMIT,
    GEARING,
    MOTORS,
    SIGNED_VOLTAGE,
    TORQUE_OR_NONE,
    Quantity,
    require,
    require_fields,
)
from simcore.robot.limited_motor import within

__all__ = ["GearboxConfig", "SimMotor"]

_LIMIT = replace(CURRENT_LIMIT, is_open=True)


@runtime_checkable
class SimMotor(Protocol):
    """A mechanism seen from its motor controller: volts go in, motion and current come out.

    Angles and rates are the mechanism's, after the gears; a rotor turns `gearing` times as far.
    """

    @property
    def gearing(self) -> float:
        """Rotor turns per turn of the mechanism [-]."""
        ...

    @property
    def position(self) -> float:
        """Angle of the mechanism [rad]."""
        ...

    @property
    def velocity(self) -> float:
        """Rate of the mechanism [rad/s]."""
        ...

    @property
    def volts(self) -> float:
        """Voltage asked for, before the battery limits it [V]."""
        ...

    @property
    def current(self) -> float:
        """Stator current of all motors together, mean of the last step [A]."""
        ...

    @property
    def supply_current(self) -> float:
        """Current that all motors took from the battery, mean of the last step; below zero they feed it [A]."""
        ...

    def set_volts(self, volts: float) -> None:
        """Hold this voltage from the next step on; zero volts brake."""
        ...

    def coast(self) -> None:
        """Open the circuit: no current flows until volts are set again."""
        ...

    def step(self, dt: float, battery_voltage: float = 12.0) -> None:
        """Move on by `dt` [s]; the battery can give no more than `battery_voltage` [V] either way."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class GearboxConfig:
    """Motors of one kind that drive one shaft together.

    >>> from wpimath.system.plant import DCMotor
    >>> shooter = GearboxConfig(motor=DCMotor.krakenX60(1), motors=4, gearing=24 / 36)
    >>> round(shooter.free_speed(12.0), 1)  # [rad/s] of the wheels
    947.7
    """

    motor: DCMotor
    """One motor, as wpimath gives it: `DCMotor.krakenX60(1)`."""
    motors: int = 1
    """How many of them share the load."""
    gearing: float
    """Rotor turns per turn of the mechanism; above 1 the mechanism turns slower [-]."""
    stator_current_limit: float = math.inf
    """Of each motor, both ways [A]."""
    supply_current_limit: float = math.inf
    """Of each motor from the battery, drawing and feeding back [A]; kept with the speed at the start of a step."""
    friction_torque: float = 0.0
    """Coulomb friction at the mechanism, against the motion and before it starts [N m]."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            motors=MOTORS,
            gearing=GEARING,
            stator_current_limit=_LIMIT,
            supply_current_limit=_LIMIT,
            friction_torque=TORQUE_OR_NONE,
        )
        for name in ("R", "Kt", "Kv"):
            require("GearboxConfig", f"motor.{name}", getattr(self.motor, name), Quantity("", 0.0, 1e9, is_open=True))

    @property
    def torque_per_amp(self) -> float:
        """Torque at the mechanism for one amp in every motor [N m/A]."""
        return float(self.motors * self.gearing * self.motor.Kt)

    @property
    def volts_per_speed(self) -> float:
        """Back-EMF for one rad/s of the mechanism [V s/rad]; also the feed-forward of a velocity loop."""
        return float(self.gearing / self.motor.Kv)

    @property
    def resistance(self) -> float:
        """Of one motor's winding [ohm]."""
        return float(self.motor.R)

    def varied(self, *, kt: float, resistance: float) -> GearboxConfig:
        """The same with motors that differ from their kind.

        Args:
            kt: Mean factor of torque per current, and of volts per speed [-].
            resistance: Mean factor of the resistance [-].
        """
        if kt == resistance == 1.0:
            return self
        m = self.motor
        free_current = m.freeCurrent / kt
        motor = DCMotor(
            m.nominalVoltage,
            m.stallTorque * kt / resistance,
            m.stallCurrent / resistance,
            free_current,
            m.Kv / kt * (m.nominalVoltage - m.R * resistance * free_current),
            1,
        )
        return replace(self, motor=motor)

    def free_speed(self, volts: float) -> float:
        """Speed at which the back-EMF equals `volts`, without friction [rad/s]."""
        return volts / self.volts_per_speed

    def stall_torque(self, volts: float) -> float:
        """Torque at rest, before friction and within the current limit [N m]."""
        require("GearboxConfig.stall_torque", "volts", volts, SIGNED_VOLTAGE)
        return self.torque_per_amp * within(volts / self.resistance, self.stator_current_limit)

    def holding_volts(self, torque: float) -> float:
        """Voltage that makes `torque` [N m] at rest [V]."""
        return torque * self.resistance / self.torque_per_amp
