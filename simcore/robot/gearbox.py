"""Gearboxes of mechanisms (DC motors, gearing and friction), and controllers that compute the motor voltage."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from simcore.errors import ConfigError
from simcore.quantities import (
    CURRENT_LIMIT,
    GAIN,
    GEARING,
    MOTORS,
    SIGNED_VOLTAGE,
    TORQUE_OR_NONE,
    VOLTAGE,
    VOLTAGE_OR_NONE,
    require,
    require_fields,
)
from simcore.robot.dc_motor import MotorModel, as_motor

__all__ = [
    "GEARED_FRICTION_VOLTS",
    "GearboxConfig",
    "PositionController",
    "VelocityController",
    "default_friction",
    "friction_from_volts",
    "no_load_friction",
]

_LIMIT = replace(CURRENT_LIMIT, is_open=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class GearboxConfig:
    """Config of a gearbox: one or more identical motors that drive a mechanism through gears.

    >>> from simcore.robot.dc_motor import motor
    >>> shooter = GearboxConfig(motor=motor("Kraken X60"), motors=4, gearing=24 / 36)
    >>> round(shooter.free_speed(12.0), 1)  # [rad/s] of the wheels
    947.7
    """

    motor: MotorModel
    """Model of one motor, such as `motor("Kraken X60")`. The constructor also accepts and converts a `DCMotor` of
    WPILib, such as `DCMotor.krakenX60(1)`."""
    motors: int = 1
    """Number of motors that share the load."""
    gearing: float
    """Rotor turns per turn of the mechanism [-]; a value above 1 is a reduction."""
    stator_current_limit: float = math.inf
    """Stator current limit of each motor, in both directions [A]."""
    supply_current_limit: float = math.inf
    """Supply current limit of each motor, for drawing and for regenerating [A]. The loop evaluates this limit at the
    speed at the start of a step."""
    friction_torque: float = 0.0
    """Coulomb friction torque at the mechanism, in motion and at rest [N m]."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "motor", as_motor(self.motor))
        require_fields(
            self,
            motors=MOTORS,
            gearing=GEARING,
            stator_current_limit=_LIMIT,
            supply_current_limit=_LIMIT,
            friction_torque=TORQUE_OR_NONE,
        )

    @property
    def torque_per_amp(self) -> float:
        """Torque at the mechanism for a current of one ampere in each motor [N m/A]."""
        return self.motors * self.gearing * self.motor.kt

    @property
    def volts_per_speed(self) -> float:
        """Back-EMF per angular velocity of the mechanism [V s/rad]; also the feed-forward gain of a velocity loop."""
        return self.gearing / self.motor.kv

    @property
    def resistance(self) -> float:
        """Resistance of one motor at full duty cycle [ohm]."""
        return self.motor.resistance

    def varied(self, *, kt: float, resistance: float) -> GearboxConfig:
        """Return a copy whose motors deviate from the datasheet.

        Args:
            kt: Factor on torque per current and on back-EMF per speed, averaged over the motors [-].
            resistance: Factor on the resistance, averaged over the motors [-].
        """
        motor = self.motor.varied(kt=kt, resistance=resistance)
        return self if motor is self.motor else replace(self, motor=motor)

    def free_speed(self, volts: float) -> float:
        """Return the free speed of the mechanism without friction [rad/s].

        Args:
            volts: Motor voltage [V].
        """
        return volts / self.volts_per_speed

    def stall_torque(self, volts: float) -> float:
        """Return the stall torque at the mechanism without friction, within the stator current limit [N m].

        Args:
            volts: Motor voltage [V].
        """
        require("GearboxConfig.stall_torque", "volts", volts, SIGNED_VOLTAGE)
        return self.torque_per_amp * min(
            max(volts / self.resistance, -self.stator_current_limit), self.stator_current_limit
        )

    def holding_volts(self, torque: float) -> float:
        """Return the motor voltage that produces a given torque at the mechanism at rest, without friction [V].

        Args:
            torque: Torque at the mechanism [N m].
        """
        return torque * self.resistance / self.torque_per_amp


# Without friction, a released mechanism would turn forever. Two values are available without a measurement: the no-load
# current in the datasheet, which covers bearing and iron losses of the motor, and the usual kS of gears, belts and
# bearings.
GEARED_FRICTION_VOLTS = 0.2
"""Voltage needed to start a mechanism with gears, belts and bearings [V]; estimate, -50 % to +100 %.

Source: the friction voltages that CTRE's Tuner X generates for a swerve module
(`SwerveModuleConstants.drive_friction_voltage`, `steer_friction_voltage`); no vendor publishes values for mechanisms.
"""


def no_load_friction(gearbox: GearboxConfig) -> float:
    """Compute the no-load friction torque of the motors, referred to the mechanism [N m].

    The torque is the number of motors times gearing, no-load current and kT. A motor with this friction reaches the
    free speed in the datasheet.

    >>> from simcore.robot.dc_motor import motor
    >>> krakens = GearboxConfig(motor=motor("Kraken X60"), motors=2, gearing=3.0)
    >>> round(no_load_friction(krakens), 3)  # 2 motors x 3 x 2 A x 0.0194 N m/A
    0.232
    """
    return gearbox.torque_per_amp * gearbox.motor.free_current


def friction_from_volts(gearbox: GearboxConfig, volts: float) -> float:
    """Convert a static friction gain kS to a friction torque at the mechanism [N m].

    Args:
        gearbox: Motors and gears of the mechanism.
        volts: Gain kS, for example from SysId [V]; the sign does not matter.

    Raises:
        ConfigError: If `volts` is not finite.
    """
    if not math.isfinite(volts):
        raise ConfigError(f"friction volts must be a finite number, got {volts}")
    return gearbox.torque_per_amp * abs(volts) / gearbox.resistance


def default_friction(gearbox: GearboxConfig, *, has_gears: bool = True) -> float:
    """Estimate the friction torque at a mechanism for which no measurement exists [N m].

    The estimate is `no_load_friction`, or with gears the larger of `no_load_friction` and the torque of
    `GEARED_FRICTION_VOLTS`.

    Args:
        gearbox: Motors and gears of the mechanism.
        has_gears: Whether gears or belts add friction; False for a flywheel, whose motors cause most of the friction.
    """
    own = no_load_friction(gearbox)
    return max(own, friction_from_volts(gearbox, GEARED_FRICTION_VOLTS)) if has_gears else own


@dataclass(frozen=True, slots=True, kw_only=True)
class VelocityController:
    """Velocity controller with kS and kV feed-forward and a proportional term, without an integral term."""

    kv: float
    """Velocity feed-forward gain [V s/rad]."""
    kp: float = 0.0
    """Proportional gain on the velocity error [V s/rad]."""
    ks: float = 0.0
    """Static friction feed-forward, in the direction of the goal [V]."""
    max_volts: float = 12.0
    """Voltage limit, in both directions [V]."""

    def __post_init__(self) -> None:
        require_fields(self, kv=GAIN, kp=GAIN, ks=VOLTAGE_OR_NONE, max_volts=VOLTAGE)

    @classmethod
    def for_gearbox(cls, gearbox: GearboxConfig, *, kp: float = 0.0, max_volts: float = 12.0) -> VelocityController:
        """Return a controller whose gains `kv` and `ks` match the back-EMF and friction of a gearbox."""
        return cls(
            kv=gearbox.volts_per_speed,
            kp=kp,
            ks=gearbox.holding_volts(gearbox.friction_torque),
            max_volts=max_volts,
        )

    def volts(self, goal: float, velocity: float) -> float:
        """Compute the motor voltage for a goal velocity, within the voltage limit [V].

        Args:
            goal: Goal velocity [rad/s].
            velocity: Current velocity [rad/s].
        """
        friction = self.ks if goal > 0.0 else -self.ks if goal < 0.0 else 0.0
        volts = friction + self.kv * goal + self.kp * (goal - velocity)
        return min(max(volts, -self.max_volts), self.max_volts)


@dataclass(frozen=True, slots=True, kw_only=True)
class PositionController:
    """Proportional-derivative position controller for an angle; the caller supplies the gravity feed-forward."""

    kp: float
    """Proportional gain on the position error [V/rad]."""
    kd: float = 0.0
    """Derivative gain on the velocity, which damps the motion [V s/rad]."""
    max_volts: float = 12.0
    """Voltage limit, in both directions [V]."""

    def __post_init__(self) -> None:
        require_fields(self, kp=GAIN, kd=GAIN, max_volts=VOLTAGE)

    def volts(self, goal: float, position: float, velocity: float, feedforward: float = 0.0) -> float:
        """Compute the motor voltage for a goal position, within the voltage limit [V].

        Args:
            goal: Goal position [rad].
            position: Current position [rad].
            velocity: Current velocity [rad/s].
            feedforward: Voltage to add before the limit, for example `ArmSim.holding_volts` [V].
        """
        volts = feedforward + self.kp * (goal - position) - self.kd * velocity
        return min(max(volts, -self.max_volts), self.max_volts)
