"""Parameters common to all drivetrains: motors, driven wheels and mass properties of the robot."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from simcore.quantities import (
    EFFICIENCY,
    FRICTION,
    INERTIA,
    MASS,
    ROBOT_HEIGHT,
    ROBOT_LENGTH,
    ROBOT_PLACE,
    SLIP_SPEED,
    Quantity,
    require,
    require_fields,
    require_row,
)
from simcore.robot.dc_motor import MotorModel

__all__ = ["MOST_FRICTION", "DrivetrainConfig", "LimitedMotor", "RobotMass", "WheelConfig", "plate_inertia"]


MOST_FRICTION = 3.0
"""Largest plausible kS of a drive motor in robot code [V]; the kS in public robot code is at most 1.3 V."""


@dataclass(frozen=True, slots=True)
class LimitedMotor:
    """Constants of `count` identical motors on one shaft, referred to the shaft."""

    resistance: float
    """Resistance of one motor at full duty cycle [ohm]."""
    conductance: float
    """Inverse of `resistance` [1/ohm]."""
    winding: float
    """Resistance of the winding of one motor [ohm]; see `MotorModel.supply_resistance`."""
    emf: float
    """Back-EMF per shaft speed [V s/rad]."""
    torque_driving: float
    """Shaft torque of all motors per current of one motor, while the motors drive the gears [N m/A]."""
    torque_driven: float
    """Shaft torque of all motors per current of one motor, while the gears drive the motors [N m/A]. The value is
    larger than `torque_driving`, because gear losses help to brake."""
    friction: float
    """Coulomb friction torque at the shaft [N m]."""
    stator_limit: float
    """Stator current limit per motor [A]."""
    supply_limit: float
    """Supply current limit per motor, drawing and regenerating [A]."""
    count: int

    @staticmethod
    def of(
        model: MotorModel,
        *,
        gearing: float,
        efficiency: float = 1.0,
        friction_volts: float = 0.0,
        limits: tuple[float, float] = (math.inf, math.inf),
        count: int = 1,
        free_speed_share: float = 1.0,
    ) -> LimitedMotor:
        """Compute the constants of identical motors with a gearbox, referred to the output shaft.

        Args:
            model: Model of one motor.
            gearing: Rotor turns per turn of the shaft [-].
            efficiency: Efficiency of the gears [-].
            friction_volts: Smallest voltage that turns the shaft [V].
            limits: Stator and supply current limit per motor [A].
            count: Number of motors on the shaft.
            free_speed_share: Ratio of actual to datasheet free speed of the motors [-].
        """
        torque = model.kt * gearing * count
        stator_limit, supply_limit = limits
        return LimitedMotor(
            resistance=model.resistance,
            conductance=1.0 / model.resistance,
            winding=model.winding_resistance,
            emf=gearing / model.kv / free_speed_share,
            torque_driving=torque * efficiency,
            torque_driven=torque / efficiency,
            # The friction torque is the shaft torque at the voltage that just overcomes the friction.
            friction=torque * efficiency * friction_volts / model.winding_resistance,
            stator_limit=stator_limit,
            supply_limit=supply_limit,
            count=count,
        )


def plate_inertia(mass: float, length: float, width: float) -> float:
    """Compute the yaw moment of inertia of a uniform rectangular plate, m (a^2 + b^2) / 12 [kg m^2].

    Args:
        mass: Mass m of the plate [kg].
        length: Side length a [m].
        width: Side length b [m].
    """
    require("robot", "mass", mass, MASS)
    require_row("robot", "bumper (length and width)", (length, width), (ROBOT_LENGTH, ROBOT_LENGTH))
    return mass * (length * length + width * width) / 12.0


@dataclass(frozen=True, kw_only=True)  # without slots: subclasses already get slots from `WheelConfig`
class RobotMass:
    """Mass properties of a robot, and wheel positions relative to the center of mass."""

    mass: float
    """Mass of the whole robot with bumpers and battery [kg]."""
    yaw_inertia: float
    """Moment of inertia about the vertical axis through the center of mass [kg m^2]; see `plate_inertia`."""
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.2)
    """Center of mass in the robot frame [m]; a higher center of mass causes more load transfer between wheels."""
    positions: tuple[tuple[float, float], ...]
    """Wheel positions relative to the center of mass, robot axes [m]."""
    lowered: tuple[int, ...] = ()
    """Indices of the lowered middle wheels of a dropped-center drive; empty if all wheels are level."""


@dataclass(frozen=True, kw_only=True)
class DrivetrainConfig(RobotMass):
    """Base of `SwerveConfig`, `TankConfig` and `MecanumConfig` with the nominal mass properties of the robot."""

    mass: float = 55.0
    yaw_inertia: float = 5.87
    positions: tuple[tuple[float, float], ...] = field(init=False, repr=False, compare=False)
    lowered: tuple[int, ...] = field(init=False, repr=False, compare=False, default=())

    def __post_init__(self) -> None:
        self.require_robot("drivetrain")

    @property
    def wheel_positions(self) -> tuple[tuple[float, float], ...]:
        """Centers of the wheels, robot frame [m]; empty in this base class."""
        return ()

    def require_robot(self, owner: str) -> None:
        """Validate the fields of this class, and compute `positions`; error messages contain `owner`.

        Raises:
            ConfigError: If a field is out of range.
        """
        require_fields(
            self, owner, mass=MASS, yaw_inertia=INERTIA, center_of_mass=(ROBOT_PLACE, ROBOT_PLACE, ROBOT_HEIGHT)
        )
        cx, cy, _ = self.center_of_mass
        object.__setattr__(self, "positions", tuple((x - cx, y - cy) for x, y in self.wheel_positions))


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelConfig:
    """Config of a wheel on carpet; base of `SwerveModuleConfig`, `TankConfig` and `MecanumConfig`."""

    wheel_radius: float = 0.0508
    """Radius of the wheel [m]."""
    wheel_cof: float = 1.2
    """Coefficient of friction of the wheel on carpet, along the wheel [-]. The default is conservative, because treads
    wear in matches. On a tilting table, new blue nitrile tread held up to 1.83 along the wheel and 1.34 across the
    wheel, and new HiGrip tread up to 1.76 and 1.71. Source: team 1640, DEWBOT VIII wheel friction coefficient testing.
    `cots.TREADS` has more treads."""
    wheel_grain: float = 1.0
    """Ratio of friction across the wheel to friction along the wheel [-]. The test cited in `wheel_cof` gave .73 for
    blue nitrile and .97 for HiGrip. The default is 1, because both treads had more than 1.2 across the wheel. Set
    `wheel_grain` only together with a measured `wheel_cof`."""
    wheel_inertia: float = 8.0e-4
    """Moment of inertia of wheel and last gear about the axle [kg m^2]. The default is an estimate for a 4 in wheel of
    0.6 kg, +-50 %."""
    rolling_resistance: float = 0.01
    """Coefficient of rolling resistance [-]; estimate for carpet, +-50 %."""
    slip_ratio: float = 0.01
    """Ratio of slip speed to rolling speed at which the tire begins to slide [-]; estimate for a thin, stiff tread."""
    slip_speed: float = 0.0004
    """Slip speed at which a tire at rest begins to slide [m/s]; a robot parked on a 15-degree ramp creeps at 1/5 of
    this speed."""

    def __post_init__(self) -> None:
        self.require_wheel("wheel")

    def require_wheel(self, owner: str) -> None:
        """Validate the fields of this class; error messages contain `owner`.

        Raises:
            ConfigError: If a field is out of range.
        """
        require_fields(
            self,
            owner,
            wheel_radius=ROBOT_LENGTH,
            wheel_cof=FRICTION,
            wheel_grain=Quantity("", 0.0, 2.0, is_open=True),
            wheel_inertia=INERTIA,
            rolling_resistance=FRICTION,
            slip_ratio=EFFICIENCY,
            slip_speed=SLIP_SPEED,
        )
