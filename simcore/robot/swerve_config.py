"""Configs of swerve modules and drivetrains, validated at construction."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field, replace

from simcore.errors import ConfigError
from simcore.quantities import (
    ANGLE,
    CURRENT_LIMIT,
    EFFICIENCY,
    GAIN,
    GEARING,
    INERTIA,
    RATIO,
    ROBOT_HEIGHT,
    ROBOT_PLACE,
    SPEED_SHARE,
    VOLTAGE_OR_NONE,
    Quantity,
    require_fields,
)
from simcore.robot.dc_motor import MotorModel, controller_limits, motor
from simcore.robot.wheel_config import DrivetrainConfig, LimitedMotor, WheelConfig, plate_inertia

__all__ = ["USUAL_FRICTION", "SwerveConfig", "SwerveModuleConfig"]

_log = logging.getLogger(__name__)

# Usual ranges, (low, high) in the unit of the field; values outside are possible, but logged.
_USUAL_MODULE = {
    "drive_gearing": (3.0, 24.0),
    "steer_gearing": (6.0, 50.0),
    "coupling_ratio": (-6.0, 6.0),
    "wheel_radius": (0.025, 0.082),
    "wheel_cof": (0.6, 2.5),
    "wheel_grain": (0.5, 1.0),
    "wheel_inertia": (1e-4, 5e-3),
    "steer_inertia": (5e-4, 0.06),
    "drive_friction_volts": (0.0, 0.8),
    "steer_friction_volts": (0.0, 1.0),
    "drive_efficiency": (0.7, 1.0),
    "steer_efficiency": (0.5, 1.0),
    "rolling_resistance": (0.0, 0.05),
    "slip_ratio": (0.001, 0.15),
    "slip_speed": (1e-4, 0.1),
}
_USUAL_ROBOT = {"mass": (10.0, 80.0), "yaw_inertia": (0.3, 20.0)}
USUAL_FRICTION = 0.22
"""Default friction voltage of drive motors [V]; see `SwerveModuleConfig.drive_friction_volts`."""
_UNITS = {"mass": "kg"}
"""Units of the fields whose warnings may suggest a conversion from another unit."""


def _unusual(owner: str, config: object, usual: dict[str, tuple[float, float]]) -> list[str]:
    remarks = []
    for name, (low, high) in usual.items():
        value = getattr(config, name)
        if not low <= value <= high:
            hint = Quantity(_UNITS.get(name, ""), low, high).in_other_units(value)
            remarks.append(f"{owner}: {name} = {value:g} is outside the usual {low:g} to {high:g}{hint}")
    return remarks


@dataclass(frozen=True, slots=True, kw_only=True)
class SwerveModuleConfig(WheelConfig):
    """Config of a swerve module: position, motors, gears, wheel and current limits."""

    x: float
    """x coordinate of the module, forward of the robot center [m]."""
    y: float
    """y coordinate of the module, left of the robot center [m]."""
    name: str = ""
    """Name of the module in messages; empty for `module 0`, `module 1` and so on."""

    drive_motor: MotorModel = field(default_factory=lambda: motor("Kraken X60"))
    steer_motor: MotorModel = field(default_factory=lambda: motor("Kraken X60"))
    drive_gearing: float = 6.75
    """Rotor turns per wheel turn [-]."""
    steer_gearing: float = 150.0 / 7.0
    """Rotor turns per turn of the module [-]."""
    coupling_ratio: float = 0.0
    """Turns of the drive rotor per turn of the module with the wheel locked against rolling [-]."""

    steer_offset: float = 0.0
    """Zeroing error of the steer encoder: true steer angle minus reading, counter-clockwise positive [rad]."""

    scrub_radius: float = 0.008
    """Mean radius of the contact patch, the lever arm of tread friction against steering [m]; estimate, +-50 %."""

    steer_inertia: float = 0.004
    """Moment of inertia of fork and wheel about the steer axis, without rotor [kg m^2]; estimate: real modules have
    .002 to .006."""
    drive_friction_volts: float = USUAL_FRICTION
    """Smallest motor voltage that turns the wheel off the ground [V]. The kS from SysId is about 0.02 V higher because
    of rolling resistance. A value of .21 to .22 V fits the log of a real swerve drive best (team 114, 2022). SysId
    results of three teams are .32, .555 and .743 V (with other gears, belts and treads)."""
    steer_friction_volts: float = 0.2
    """Smallest motor voltage that steers the module with the wheel off the ground [V]."""
    drive_efficiency: float = 0.95
    """Efficiency e of the drive gears [-]: forward driving multiplies torque by e, back-driving by 1 / e."""
    free_speed_share: float = 1.0
    """Ratio of actual to datasheet free speed of the drive motor [-]; see `FixedWheelConfig.free_speed_share`."""
    steer_efficiency: float = 0.90
    """Efficiency of the steer gears [-]."""

    drive_stator_limit: float | None = None
    """Stator current limit of the drive motor [A]; None for the controller's factory default (`controller_limits`),
    `math.inf` for no limit."""
    drive_supply_limit: float | None = None
    """Supply current limit of the drive motor, drawing and regenerating [A]; None for the controller's factory default,
    `math.inf` for no limit."""
    steer_stator_limit: float | None = None
    """Stator current limit of the steer motor [A]; None for the controller's factory default, `math.inf` for no
    limit."""
    steer_supply_limit: float | None = None
    """Supply current limit of the steer motor, drawing and regenerating [A]; None for the controller's factory default,
    `math.inf` for no limit."""
    drive_brake: bool = True
    """Whether the drive motor brakes (short circuit) in neutral, instead of coasting (open circuit)."""
    steer_brake: bool = True
    """Whether the steer motor brakes in neutral, instead of coasting."""

    drive_kp: float = 1.0
    """Proportional gain of the on-board drive velocity loop [V per m/s]; the feed-forward follows from the motor."""
    steer_kp: float = 40.0
    """Proportional gain of the on-board steer position loop [V/rad]."""

    def __post_init__(self) -> None:
        owner = f"{self.name}" or "module"
        self.require_wheel(owner)
        require_fields(
            self,
            owner,
            x=ROBOT_PLACE,
            y=ROBOT_PLACE,
            drive_gearing=GEARING,
            steer_gearing=GEARING,
            coupling_ratio=RATIO,
            steer_offset=ANGLE,
            scrub_radius=ROBOT_HEIGHT,
            steer_inertia=INERTIA,
            drive_friction_volts=VOLTAGE_OR_NONE,
            steer_friction_volts=VOLTAGE_OR_NONE,
            drive_efficiency=EFFICIENCY,
            free_speed_share=SPEED_SHARE,
            steer_efficiency=EFFICIENCY,
            drive_stator_limit=CURRENT_LIMIT,
            drive_supply_limit=CURRENT_LIMIT,
            steer_stator_limit=CURRENT_LIMIT,
            steer_supply_limit=CURRENT_LIMIT,
            drive_kp=GAIN,
            steer_kp=GAIN,
        )
        if abs(self.coupling_ratio) >= self.steer_gearing:
            raise ConfigError(
                f"{owner}: coupling_ratio must be smaller than steer_gearing ({self.steer_gearing:g}), "
                f"got {self.coupling_ratio:g}"
            )

    @property
    def limited_drive_motor(self) -> LimitedMotor:
        """Constants of the drive motor with gears and current limits."""
        return LimitedMotor.of(
            self.drive_motor,
            gearing=self.drive_gearing,
            efficiency=self.drive_efficiency,
            friction_volts=self.drive_friction_volts,
            limits=controller_limits(self.drive_motor, self.drive_stator_limit, self.drive_supply_limit),
            free_speed_share=self.free_speed_share,
        )

    @property
    def limited_steer_motor(self) -> LimitedMotor:
        """Constants of the steer motor with gears and current limits."""
        return LimitedMotor.of(
            self.steer_motor,
            gearing=self.steer_gearing,
            efficiency=self.steer_efficiency,
            friction_volts=self.steer_friction_volts,
            limits=controller_limits(self.steer_motor, self.steer_stator_limit, self.steer_supply_limit),
        )

    @property
    def drive_inertia(self) -> float:
        """Moment of inertia of wheel, gears and geared rotor about the axle [kg m^2]."""
        return self.wheel_inertia + self.drive_motor.rotor_inertia * self.drive_gearing**2

    @property
    def azimuth_inertia(self) -> float:
        """Moment of inertia of fork, wheel and geared rotor about the steer axis [kg m^2]."""
        return self.steer_inertia + self.steer_motor.rotor_inertia * self.steer_gearing**2


@dataclass(frozen=True, slots=True, kw_only=True)
class SwerveConfig(DrivetrainConfig):
    """Config of a swerve drivetrain: modules, and mass properties of the robot."""

    modules: tuple[SwerveModuleConfig, ...]

    def __post_init__(self) -> None:
        require_fields(self, "swerve")
        if not self.modules:
            raise ConfigError("swerve: modules must name at least one module, got none")
        object.__setattr__(self, "modules", tuple(self.modules))
        self.require_robot("swerve")
        # Warnings are logged here instead of in each module, so that four identical modules give one warning.
        remarks = _unusual("swerve", self, _USUAL_ROBOT)
        for module in self.modules:
            remarks += _unusual("swerve module", module, _USUAL_MODULE)
        for remark in dict.fromkeys(remarks):
            _log.warning("%s; going on with it", remark)

    @property
    def wheel_positions(self) -> tuple[tuple[float, float], ...]:
        """Centers of the wheels, in the order of `modules`, robot frame [m]."""
        return tuple((m.x, m.y) for m in self.modules)

    @property
    def wheel_radius(self) -> float:
        """Wheel radius of the first module [m]."""
        return self.modules[0].wheel_radius

    @property
    def wheel_cof(self) -> float:
        """Smallest coefficient of friction of the wheels [-]."""
        return min(m.wheel_cof for m in self.modules)

    @staticmethod
    def square(
        trackwidth: float, module: SwerveModuleConfig, *, mass: float = 55.0, bumper: float = 0.8, height: float = 0.2
    ) -> SwerveConfig:
        """Make the config of a drivetrain with four identical modules in a square.

        The order of the modules is front left, front right, back left, back right.

        Args:
            trackwidth: Distance between neighboring wheels [m].
            module: Config that all modules share except for the position.
            mass: Mass of the robot [kg].
            bumper: Side length over the bumpers, for the yaw moment of inertia of a uniform plate [m].
            height: Height of the center of mass above the floor [m].
        """
        return SwerveConfig.rectangle(trackwidth, trackwidth, module, mass=mass, bumper=(bumper, bumper), height=height)

    @staticmethod
    def rectangle(
        wheelbase: float,
        trackwidth: float,
        module: SwerveModuleConfig,
        *,
        mass: float = 55.0,
        bumper: tuple[float, float] = (0.8, 0.8),
        height: float = 0.2,
    ) -> SwerveConfig:
        """Make the config of a drivetrain with four identical modules in a rectangle.

        The order of the modules is front left, front right, back left, back right.

        Args:
            wheelbase: Distance between front and back wheels [m].
            trackwidth: Distance between left and right wheels [m].
            module: Config that all modules share except for the position.
            mass: Mass of the robot [kg].
            bumper: Length and width over the bumpers, for the yaw moment of inertia of a uniform plate [m].
            height: Height of the center of mass above the floor [m].
        """
        corners = (("front left", 1, 1), ("front right", 1, -1), ("back left", -1, 1), ("back right", -1, -1))
        return SwerveConfig(
            modules=tuple(
                replace(module, name=name, x=sx * wheelbase / 2.0, y=sy * trackwidth / 2.0) for name, sx, sy in corners
            ),
            mass=mass,
            yaw_inertia=plate_inertia(mass, *bumper),
            center_of_mass=(0.0, 0.0, height),
        )

    def module_name(self, index: int) -> str:
        """Return the name of a module for messages, or `module <index>` for a module without a name."""
        return self.modules[index].name or f"module {index}"
