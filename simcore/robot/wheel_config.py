"""Config that all drivetrains share: motors, driven wheels and the mass that they carry."""

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
"""kS of drive motors that a program may say [V]; a larger one is of another unit. Public ones go up to 1.3 V."""


@dataclass(frozen=True, slots=True)
class LimitedMotor:
    """Constants of `count` equal motors on one shaft, seen from the shaft."""

    resistance: float
    """Resistance of one motor at full duty [ohm]."""
    conductance: float
    """Inverse of `resistance` [1/ohm]."""
    winding: float
    """Resistance of one motor behind its controller [ohm]; see `MotorModel.supply_resistance`."""
    emf: float
    """Back-EMF per shaft speed [V s/rad]."""
    torque_driving: float
    """Shaft torque per motor current while the motor drives the gears [N m/A]."""
    torque_driven: float
    """Shaft torque per motor current while the gears drive the motor; gear losses then help to brake [N m/A]."""
    friction: float
    """Coulomb friction at the shaft [N m]."""
    stator_limit: float
    """Stator current limit per motor [A]."""
    supply_limit: float
    """Supply current limit per motor [A]."""
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
        """Refer a motor behind a gear to the shaft.

        Args:
            model: One motor.
            gearing: Rotor turns per turn of the shaft [-].
            efficiency: Of the gears [-].
            friction_volts: Voltage that just turns the shaft [V].
            limits: Of stator and supply, per motor [A].
            count: Motors on the shaft.
            free_speed_share: Free speed over that of the datasheet [-].
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
            # The gears multiply the voltage that just overcomes friction, like any torque.
            friction=torque * efficiency * friction_volts / model.winding_resistance,
            stator_limit=stator_limit,
            supply_limit=supply_limit,
            count=count,
        )


def plate_inertia(mass: float, length: float, width: float) -> float:
    """Compute the yaw inertia of a uniform rectangle [kg m^2]: m (a^2 + b^2) / 12."""
    require("robot", "mass", mass, MASS)
    require_row("robot", "bumper (length and width)", (length, width), (ROBOT_LENGTH, ROBOT_LENGTH))
    return mass * (length * length + width * width) / 12.0


@dataclass(frozen=True, kw_only=True)  # without slots: a config of wheels has them from `WheelConfig` already
class RobotMass:
    """Mass of a robot, and its wheel positions relative to the center of mass."""

    mass: float
    """Mass of the whole robot, bumpers and battery included [kg]."""
    yaw_inertia: float
    """Moment of inertia about the vertical axis through the center of mass [kg m^2]; see `plate_inertia`."""
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.2)
    """Position relative to the robot center on the floor, robot axes [m]; its height shifts load between wheels."""
    positions: tuple[tuple[float, float], ...]
    """Wheel positions relative to the center of mass, robot axes [m]."""
    lowered: tuple[int, ...] = ()
    """Rows of the wheels of a dropped center, lower than the others; empty: all are level."""


@dataclass(frozen=True, kw_only=True)
class DrivetrainConfig(RobotMass):
    """Base of `SwerveConfig`, `TankConfig` and `MecanumConfig`: the robot's mass as designed."""

    mass: float = 55.0
    yaw_inertia: float = 5.87
    positions: tuple[tuple[float, float], ...] = field(init=False, repr=False, compare=False)
    lowered: tuple[int, ...] = field(init=False, repr=False, compare=False, default=())

    def __post_init__(self) -> None:
        self.require_robot("drivetrain")

    @property
    def wheel_positions(self) -> tuple[tuple[float, float], ...]:
        """Centers of the wheels, robot frame [m]; this base has none."""
        return ()

    def require_robot(self, owner: str) -> None:
        """Validate these fields and place the wheels; messages name `owner`."""
        require_fields(
            self, owner, mass=MASS, yaw_inertia=INERTIA, center_of_mass=(ROBOT_PLACE, ROBOT_PLACE, ROBOT_HEIGHT)
        )
        cx, cy, _ = self.center_of_mass
        object.__setattr__(self, "positions", tuple((x - cx, y - cy) for x, y in self.wheel_positions))


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelConfig:
    """Wheel on carpet. `SwerveModuleConfig`, `TankConfig` and `MecanumConfig` include these fields."""

    wheel_radius: float = 0.0508
    """Radius of the wheel [m]."""
    wheel_cof: float = 1.2
    """Coefficient of friction of the wheel on carpet, along the wheel [-]. The default is conservative: on a tilting
    table new treads held to 1.83 (blue nitrile) and 1.76 (HiGrip) along and 1.34 and 1.71 across; in matches they wear.
    Source: team 1640, DEWBOT VIII wheel friction coefficient testing; further treads in `cots.TREADS`."""
    wheel_grain: float = 1.0
    """Ratio of friction across the wheel to friction along it [-]: .73 (blue nitrile) and .97 (HiGrip) in the same
    test. The default is 1, as 1.2 along is less than either has across; with a measured `wheel_cof` set this as
    well."""
    wheel_inertia: float = 8.0e-4
    """Inertia of wheel and last gears about the axle [kg m^2]; a 4 in wheel of 0.6 kg. Estimate, +-50 %."""
    rolling_resistance: float = 0.01
    """Drag per load while the wheel rolls [-]; estimate for carpet, +-50 %."""
    slip_ratio: float = 0.01
    """Slip per rolling speed at which the tire begins to slide [-]; estimate for a thin, stiff tread."""
    slip_speed: float = 0.0004
    """Slip at which a tire at rest begins to slide [m/s]; a robot parked on a 15 degree ramp creeps at 1/5 of it."""

    def __post_init__(self) -> None:
        self.require_wheel("wheel")

    def require_wheel(self, owner: str) -> None:
        """Validate these fields; messages name `owner`."""
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
