"""What a differential (tank) drivetrain is made of, checked when it is written down."""

from __future__ import annotations

from dataclasses import dataclass, field

from simcore.errors import ConfigError
from simcore.quantities import (
    CURRENT_LIMIT,
    EFFICIENCY,
    GAIN,
    GEARING,
    INERTIA,
    MASS,
    MOTORS,
    ROBOT_HEIGHT,
    ROBOT_LENGTH,
    ROBOT_PLACE,
    VOLTAGE_OR_NONE,
    require_fields,
)
from simcore.robot.dc_motor import MotorModel, controller_limits, motor
from simcore.robot.limited_motor import LimitedMotor
from simcore.robot.wheel_config import WheelConfig

__all__ = ["TankConfig"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TankConfig(WheelConfig):
    """A kit-bot: wheels in a row on each side, chained to one gearbox per side. Defaults are FIRST's AM14U class."""

    wheel_xs: tuple[float, ...] = (0.28, 0.0, -0.28)
    """Of the wheels of one side, forward of the robot center [m]."""
    trackwidth: float = 0.56
    """Between left and right wheels [m]."""
    motor: MotorModel = field(default_factory=lambda: motor("NEO"))
    motors_per_side: int = 2
    gearing: float = 8.45
    """Rotor turns per wheel turn [-]; kit-bot toughbox 10.71 or 8.45."""
    wheel_radius: float = 0.0762
    """[m]"""
    wheel_cof: float = 1.0
    """Coefficient of friction of the wheels on carpet, along them [-]."""
    wheel_inertia: float = 1.5e-3
    """Of one wheel with its sprocket [kg m^2]; estimate, +-50 %."""
    rolling_resistance: float = 0.015
    """Drag per load [-]; estimate for carpet and chains, +-50 %."""
    friction_volts: float = 0.25
    """Voltage that just turns a free side [V]; see `SwerveModuleConfig.drive_friction_volts`."""
    efficiency: float = 0.90
    """Of gearbox and chains, both ways [-]."""
    stator_limit: float | None = None
    """Per motor [A]; None: as the motor's controller is delivered (`controller_limits`), `math.inf`: none."""
    supply_limit: float | None = None
    """The same, drawing and regenerating [A]."""
    brake: bool = True
    """At zero command: short the motors, or else open the circuit."""
    kp: float = 1.0
    """Feedback of the on-board speed loop [V per m/s]."""
    mass: float = 50.0
    """[kg]"""
    yaw_inertia: float = 5.3
    """[kg m^2]"""
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.2)
    """From the robot center on the floor [m]."""
    positions: tuple[tuple[float, float], ...] = field(init=False, repr=False, compare=False)
    """Of the wheels relative to the center of mass, left side first [m]."""

    def __post_init__(self) -> None:
        if not self.wheel_xs:
            raise ConfigError("tank: wheel_xs must name at least one wheel per side, got none")
        self.require_wheel("tank")
        require_fields(
            self,
            "tank",
            wheel_xs=[ROBOT_PLACE],
            trackwidth=ROBOT_LENGTH,
            motors_per_side=MOTORS,
            gearing=GEARING,
            friction_volts=VOLTAGE_OR_NONE,
            efficiency=EFFICIENCY,
            stator_limit=CURRENT_LIMIT,
            supply_limit=CURRENT_LIMIT,
            kp=GAIN,
            mass=MASS,
            yaw_inertia=INERTIA,
            center_of_mass=(ROBOT_PLACE, ROBOT_PLACE, ROBOT_HEIGHT),
        )
        cx, cy, _ = self.center_of_mass
        object.__setattr__(self, "positions", tuple((x - cx, y - cy) for x, y in self.wheel_positions))

    @property
    def wheel_positions(self) -> tuple[tuple[float, float], ...]:
        """Centers of the wheels, robot frame, left side first [m]."""
        return tuple((x, side * 0.5 * self.trackwidth) for side in (1.0, -1.0) for x in self.wheel_xs)

    @property
    def side_motor(self) -> LimitedMotor:
        """All motors of one side."""
        stator, supply = controller_limits(self.motor, self.stator_limit, self.supply_limit)
        return LimitedMotor.of(
            self.motor,
            gearing=self.gearing,
            efficiency=self.efficiency,
            friction_volts=self.friction_volts,
            stator_limit=stator,
            supply_limit=supply,
            count=self.motors_per_side,
        )
