"""Mechanisms that are told where to go instead of how hard to push: pneumatic cylinders and servos."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.errors import ConfigError
from simcore.loop.robot_state import PISTON, SERVO, TARGET
from simcore.quantities import ANGLE, DURATION, ROBOT_LENGTH, TURN_RATE, require, require_fields
from simcore.robot.dc_motor import MotorModel
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, ArmSim, RackConfig, RackSim

__all__ = ["PistonConfig", "PistonSim", "ServoConfig", "ServoSim"]

_VALVE_VOLTS = 12.0
_SPEED_UP = 0.05  # [-]; share of the stroke time in which a cylinder comes to speed. Estimate: 2 kg on a 3/4 in bore
_SERVO_VOLTS = 6.0  # of the roboRIO's servo rail
_SERVO_TORQUE = 1.32  # [N m], and
_SERVO_AMPS = 2.0  # [A], both at stall. Source: REV Smart Robot Servo (REV-41-1097), 13.5 kg cm and 2 A at 6 V
_SERVO_SPEED_UP = 0.02  # [s]; time constant of a servo that swings a light part. Estimate


@dataclass(frozen=True, slots=True, kw_only=True)
class PistonConfig:
    """A pneumatic cylinder on a solenoid valve, and what it pushes."""

    stroke: float
    """From the retracted to the extended stop [m]."""
    stroke_time: float
    """From one stop to the other, as the flow controls are set [s]."""
    is_double: bool = False
    """Whether its valve has a coil each way and stays where it was put; one with a single coil returns by a spring."""
    springs_out: bool = False
    """Where a spring sends it while a single coil has no power: out instead of in."""
    starts_extended: bool = False
    """Where it is at first."""

    def __post_init__(self) -> None:
        require_fields(self, stroke=ROBOT_LENGTH, stroke_time=DURATION)

    @property
    def speed(self) -> float:
        """At which it travels once it is up to speed [m/s].

        The way from rest with a time constant tau is v (t - tau (1 - exp(-t / tau))), and it is the stroke after the
        stroke time.
        """
        tau = _SPEED_UP * self.stroke_time
        return self.stroke / (self.stroke_time - tau * -math.expm1(-self.stroke_time / tau))

    @property
    def rack(self) -> RackConfig:
        """As a slide: the force of a throttled cylinder falls evenly with its speed, as that of a DC motor does."""
        # Speed and time constant matter, force does not: one kilogram, and as many newtons as bring it to speed.
        force = self.speed / (_SPEED_UP * self.stroke_time)
        motor = MotorModel(
            name="piston",
            nominal_voltage=_VALVE_VOLTS,
            stall_torque=force,
            stall_current=1.0,
            free_current=0.0,
            free_speed=self.speed,
        )
        return RackConfig(
            gearbox=GearboxConfig(motor=motor, gearing=1.0),
            mass=1.0,
            pinion_radius=1.0,
            travel=self.stroke,
            start_extension=self.stroke if self.starts_extended else 0.0,
        )


class PistonSim(RackSim):
    """A cylinder: `position` and `extension` are its rod's [m], `volts` 12 while it is pushed out and -12 while in.

    There is always air: compressor and tanks are not modelled. The coil's current is not counted (0.3 A).

    >>> piston = PistonSim(PistonConfig(stroke=0.2, stroke_time=0.4))
    >>> piston.set_volts(12.0)
    >>> piston.step(0.41)
    >>> piston.extension
    0.2
    """

    __slots__ = ()

    def __init__(self, config: PistonConfig) -> None:
        super().__init__(config.rack)
        record = self.record
        record["kind"], record["rail"] = PISTON, _VALVE_VOLTS
        record["idle"] = 0.0 if config.is_double else _VALVE_VOLTS if config.springs_out else -_VALVE_VOLTS
        super().set_volts(_VALVE_VOLTS if config.starts_extended else -_VALVE_VOLTS)

    def set_volts(self, volts: float) -> None:
        """Power the valve: above zero the rod goes out, below it goes in.

        Without power it goes where the spring sends it; a valve with two coils stays as it is.
        """
        if volts == 0.0:
            volts = float(self.record["idle"][0])
        if volts != 0.0:
            super().set_volts(math.copysign(_VALVE_VOLTS, volts))

    def coast(self) -> None:
        """Take the power from the valve."""
        self.set_volts(0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoConfig:
    """A servo, and the part that it turns between two angles."""

    min_angle: float
    """Lower end of its travel [rad]."""
    max_angle: float
    """Upper end [rad]."""
    speed: float
    """Without load at 6 V [rad/s]; data sheets give the time for 60 degrees."""
    start_angle: float | None = None
    """Where it is at first; None is the lower end [rad]."""

    def __post_init__(self) -> None:
        require_fields(self, min_angle=ANGLE, max_angle=ANGLE, speed=TURN_RATE, start_angle=ANGLE)
        if not self.min_angle < self.max_angle:
            raise ConfigError(f"ServoConfig: min_angle must be below max_angle, got {self.min_angle}, {self.max_angle}")

    @property
    def arm(self) -> ArmConfig:
        """As an arm without weight: the servo's motor and gear, and an inertia that suits its time constant."""
        motor = MotorModel(
            name="servo",
            nominal_voltage=_SERVO_VOLTS,
            stall_torque=_SERVO_TORQUE,
            stall_current=_SERVO_AMPS,
            free_current=0.0,
            free_speed=self.speed,
        )
        return ArmConfig(
            gearbox=GearboxConfig(motor=motor, gearing=1.0),
            inertia=_SERVO_SPEED_UP * _SERVO_TORQUE / self.speed,
            min_angle=self.min_angle,
            max_angle=self.max_angle,
            start_angle=self.start_angle,
        )


class ServoSim(ArmSim):
    """A servo: goes to `goal` with its own controller, at the rate of its motor; holds still without a signal.

    Its controller is proportional, with as much gain as does not overshoot: with a motor's time constant tau that is
    a quarter of (speed / volts) / tau, and the last 4 tau of the way are slower.

    >>> servo = ServoSim(ServoConfig(min_angle=0.0, max_angle=1.0, speed=8.0))
    >>> servo.set_goal(0.5)
    >>> servo.step(0.5)
    >>> round(servo.position, 3)
    0.5
    """

    __slots__ = ()

    def __init__(self, config: ServoConfig) -> None:
        super().__init__(config.arm)
        record = self.record
        record["kind"], record["rail"] = SERVO, _SERVO_VOLTS
        record["kp"] = self.gearbox.volts_per_speed / (4.0 * _SERVO_SPEED_UP)
        self.coast()

    @property
    def goal(self) -> float:
        """Where it goes [rad]; where it is while it has no signal."""
        return self.position if self.record["mode"][0] != TARGET else float(self.record["request"][0])

    def set_goal(self, angle: float) -> None:
        """Go there [rad]; within its travel."""
        require("ServoSim", "goal", angle, ANGLE)
        lower, upper = self.stops
        record = self.record
        record["mode"], record["request"], record["brakes"] = TARGET, min(max(angle, lower), upper), 1

    def coast(self) -> None:
        """No signal: its gear holds it where it is."""
        super().coast()
        self.velocity = 0.0
