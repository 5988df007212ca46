"""Configs of tank (differential) and mecanum drivetrains, validated at construction."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from simcore.errors import ConfigError
from simcore.quantities import (
    CURRENT_LIMIT,
    EFFICIENCY,
    GAIN,
    GEARING,
    MOTORS,
    ROBOT_LENGTH,
    ROBOT_PLACE,
    SPEED_SHARE,
    VOLTAGE_OR_NONE,
    require_fields,
)
from simcore.robot.dc_motor import MotorModel, controller_limits, motor
from simcore.robot.wheel_config import DrivetrainConfig, LimitedMotor, WheelConfig

__all__ = ["FixedWheelConfig", "MecanumConfig", "TankConfig"]

_CONTRADICTED = 0.885


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedWheelConfig(WheelConfig, DrivetrainConfig):
    """Base of `TankConfig` and `MecanumConfig`, drivetrains with wheels that do not steer."""

    motor: MotorModel = field(default_factory=lambda: motor("NEO"))
    gearing: float = 8.45
    """Rotor turns per wheel turn [-]; the KitBot's Toughbox has 10.71 or 8.45."""
    wheel_radius: float = 0.0762
    """Radius of the wheels [m]."""
    wheel_cof: float = 1.0
    """Coefficient of friction of the wheels on carpet, along the wheels [-]."""
    wheel_inertia: float = 1.5e-3
    """Moment of inertia of a wheel with sprocket about the axle [kg m^2]; estimate, +-50 %."""
    rolling_resistance: float = 0.015
    """Coefficient of rolling resistance [-]; estimate for carpet and chains, +-50 %."""
    friction_volts: float = 0.25
    """Smallest motor voltage that turns a shaft with the wheels off the ground [V]; see
    `SwerveModuleConfig.drive_friction_volts`."""
    efficiency: float = 0.90
    """Efficiency of gearbox and chains, for driving and for back-driving [-]."""
    free_speed_share: float | None = None
    """Ratio of actual to datasheet free speed of the motors [-]; None for the default of `speed_share`."""
    stator_limit: float | None = None
    """Stator current limit per motor [A]; None for the controller's factory default (`controller_limits`), `math.inf`
    for no limit."""
    supply_limit: float | None = None
    """Supply current limit per motor, drawing and regenerating [A]; None for the controller's factory default,
    `math.inf` for no limit."""
    brake: bool = True
    """Whether the motors brake (short circuit) in neutral, instead of coasting (open circuit)."""
    kp: float = 1.0
    """Proportional gain of the on-board velocity loop [V per m/s]; the feed-forward gain follows from the motor."""
    mass: float = 50.0
    """Mass of the robot [kg]."""
    yaw_inertia: float = 5.3
    """Yaw moment of inertia of the robot [kg m^2]."""

    def __post_init__(self) -> None:
        self.require_robot("fixed wheels")

    def require_robot(self, owner: str) -> None:
        """Validate the fields of wheels, motors and robot, and compute `positions`; error messages contain `owner`."""
        self.require_wheel(owner)
        require_fields(
            self,
            owner,
            gearing=GEARING,
            friction_volts=VOLTAGE_OR_NONE,
            efficiency=EFFICIENCY,
            free_speed_share=SPEED_SHARE,
            stator_limit=CURRENT_LIMIT,
            supply_limit=CURRENT_LIMIT,
            kp=GAIN,
        )
        DrivetrainConfig.require_robot(self, owner)

    def shaft_motor(self, count: int) -> LimitedMotor:
        """Return the constants of all motors on a drive shaft, with gears and current limits.

        Args:
            count: Number of motors on the shaft.
        """
        return LimitedMotor.of(
            self.motor,
            gearing=self.gearing,
            efficiency=self.efficiency,
            friction_volts=self.friction_volts,
            limits=controller_limits(self.motor, self.stator_limit, self.supply_limit),
            count=count,
            free_speed_share=self.speed_share,
        )

    @property
    def speed_share(self) -> float:
        """Ratio of actual to datasheet free speed [-]: `free_speed_share` if given, otherwise 1 or .885.

        The default is .885 for motors with `kt * kv` above 1.1, such as the NEO. The stall torque and the free speed in
        the datasheets of these motors contradict each other; see `MotorModel`. In a measurement, a kit chassis with
        four NEOs reached .87 to .89 of the datasheet speed. A tank drive with Falcons reached the datasheet speed.
        """
        if self.free_speed_share is not None:
            return self.free_speed_share
        return _CONTRADICTED if self.motor.kt * self.motor.kv > 1.1 else 1.0

    def shaft_inertia(self, wheels: int, motors: int) -> float:
        """Return the moment of inertia about the axle of a drive shaft [kg m^2].

        Args:
            wheels: Number of wheels on the shaft.
            motors: Number of motors on the shaft; each rotor turns `gearing` times as fast as the shaft.
        """
        return wheels * self.wheel_inertia + motors * self.motor.rotor_inertia * self.gearing**2


@dataclass(frozen=True, slots=True, kw_only=True)
class TankConfig(FixedWheelConfig):
    """Config of a tank drive with a row of chained wheels and one gearbox per side.

    The defaults describe a KitBot on the AM14U chassis.
    """

    wheel_xs: tuple[float, ...] = (0.28, 0.0, -0.28)
    """x coordinates of the wheels on one side, forward of the robot center [m]."""
    dropped_center: bool = True
    """Whether the inner wheels of each side are lower than the outer wheels, by about 3 mm in a kit chassis; no effect
    with fewer than three wheels per side. The robot then stands on the inner wheels and on the outer wheels of one end,
    so the outer wheels of the other end do not scrub in a turn."""
    trackwidth: float = 0.56
    """Distance between left and right wheels [m]."""
    friction_volts: float = 0.65
    """Friction voltage kS as measured by SysId, including rolling resistance [V]. The kS in public code of tank drives
    ranges from .13 to 1.31 V, with a median near .65 V. A kit chassis with 4 NEOs and a gearing of 8.46 had .7 to .8 V
    in a measurement."""
    rolling_resistance: float = 0.0
    """Coefficient of rolling resistance [-]; 0 because `friction_volts` includes rolling resistance."""
    motors_per_side: int = 2
    """Number of motors on each side."""
    right_efficiency: float | None = None
    """Efficiency of gearbox and chains on the right side [-]; None if equal to `efficiency`."""

    def __post_init__(self) -> None:
        require_fields(
            self, "tank", wheel_xs=[ROBOT_PLACE], trackwidth=ROBOT_LENGTH, motors_per_side=MOTORS,
            right_efficiency=EFFICIENCY,
        )  # fmt: skip
        if not len(self.wheel_xs):
            raise ConfigError("tank: wheel_xs must name at least one wheel per side, got none")
        self.require_robot("tank")
        if self.dropped_center:
            ends = min(self.wheel_xs), max(self.wheel_xs)
            lowered = tuple(k for k, (x, _) in enumerate(self.wheel_positions) if x not in ends)
            object.__setattr__(self, "lowered", lowered)

    @property
    def sides(self) -> tuple[TankConfig, TankConfig]:
        """Configs of two drives: one with both sides like the left side, one with both sides like the right side."""
        right = self.efficiency if self.right_efficiency is None else self.right_efficiency
        return replace(self, right_efficiency=None), replace(self, efficiency=right, right_efficiency=None)

    @property
    def wheel_positions(self) -> tuple[tuple[float, float], ...]:
        """Centers of the wheels, robot frame, left side first [m]."""
        return tuple((x, side * 0.5 * self.trackwidth) for side in (1.0, -1.0) for x in self.wheel_xs)


@dataclass(frozen=True, slots=True, kw_only=True)
class MecanumConfig(FixedWheelConfig):
    """Config of a mecanum drive with four wheels, 45-degree rollers and one gearbox per wheel.

    Seen from above, the axes of the rollers on top of the wheels form an X.
    """

    places: tuple[tuple[float, float], ...] = ((0.28, 0.28), (0.28, -0.28), (-0.28, 0.28), (-0.28, -0.28))
    """Centers of the front left, front right, rear left and rear right wheel, robot frame [m]."""
    motors_per_wheel: int = 1
    """Number of motors on each wheel."""
    wheel_cof: float = 0.8
    """Coefficient of friction of the rollers on carpet, along the roller axes [-]; estimate, +-20 %."""

    def __post_init__(self) -> None:
        require_fields(self, "mecanum", motors_per_wheel=MOTORS, places=((ROBOT_PLACE, ROBOT_PLACE),) * 4)
        self.require_robot("mecanum")

    @property
    def wheel_positions(self) -> tuple[tuple[float, float], ...]:
        """Centers of the wheels, in the order of `places`, robot frame [m]."""
        return self.places
