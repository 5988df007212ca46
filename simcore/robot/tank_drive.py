"""A differential (tank) drive: two chained sides on the same motors, tires and solver as the swerve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from simcore.errors import ConfigError
from simcore.quantities import (
    CURRENT_LIMIT,
    EFFICIENCY,
    FRICTION,
    GAIN,
    GEARING,
    INERTIA,
    MASS,
    MOTORS,
    ROBOT_HEIGHT,
    ROBOT_LENGTH,
    ROBOT_PLACE,
    SLIP_SPEED,
    VOLTAGE_OR_NONE,
    require_fields,
)
from simcore.robot.battery import Battery
from simcore.robot.dc_motor import MotorModel, controller_limits, motor
from simcore.robot.drive_shaft import DriveShaft, WheelContact
from simcore.robot.limited_motor import LimitedMotor
from simcore.robot.wheeled_drive import WheeledDrive, checked_number

__all__ = ["TankConfig", "TankDrive"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TankConfig:
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
    """Coefficient of friction of the wheels on carpet [-]."""
    wheel_inertia: float = 1.5e-3
    """Of one wheel with its sprocket [kg m^2]; estimate, +-50 %."""
    rolling_resistance: float = 0.015
    """Drag per load [-]; estimate for carpet and chains, +-50 %."""
    slip_ratio: float = 0.01
    """See `SwerveModuleConfig`."""
    slip_speed: float = 0.002
    """See `SwerveModuleConfig` [m/s]."""
    friction_volts: float = 0.2
    """Voltage that just turns a free side [V]."""
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
        require_fields(
            self,
            "tank",
            wheel_xs=[ROBOT_PLACE],
            trackwidth=ROBOT_LENGTH,
            motors_per_side=MOTORS,
            gearing=GEARING,
            wheel_radius=ROBOT_LENGTH,
            wheel_cof=FRICTION,
            wheel_inertia=INERTIA,
            rolling_resistance=FRICTION,
            slip_ratio=EFFICIENCY,
            slip_speed=SLIP_SPEED,
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


class TankDrive(WheeledDrive[TankConfig]):
    """One robot's tank drive; stepped like `SwerveDrive`, commanded by side.

    Example:
        >>> drive = TankDrive(TankConfig())
        >>> drive.set_volts(6.0, 6.0)
        >>> drive.step(0.005, 0.0, 0.0, 0.0)[0] > 0.0
        True
    """

    def __init__(
        self,
        config: TankConfig,
        *,
        battery: Battery | None = None,
        built: tuple[TankConfig, TankConfig] | None = None,
    ) -> None:
        """Stand at rest.

        Args:
            config: The robot, as robot code and the loops on board know it.
            battery: Its battery; None is a stiff 12 V supply.
            built: What motors and wheels of the left and of the right side really are; None: what the config says.
        """
        n = len(config.wheel_xs)
        sides = built or (config, config)
        super().__init__(
            config,
            battery=battery,
            wheels=[
                WheelContact(
                    x=x, y=y, wheel_cof=sides[k // n].wheel_cof, rolling_resistance=sides[k // n].rolling_resistance
                )
                for k, (x, y) in enumerate(config.positions)
            ],
            shafts=[
                DriveShaft(
                    inertia=n * c.wheel_inertia + c.motors_per_side * c.motor.rotor_inertia * c.gearing**2,
                    motor=_side_motor(c),
                    radius=c.wheel_radius,
                    slip_ratio=c.slip_ratio,
                    slip_speed=c.slip_speed,
                    wheels=wheels,
                )
                for c, wheels in zip(sides, (tuple(range(n)), tuple(range(n, 2 * n))), strict=True)
            ],
            radii=[config.wheel_radius] * (2 * n),
        )
        self._known_emf = _side_motor(config).emf
        self._volts: tuple[float, float] = (0.0, 0.0)
        self._targets: tuple[float, float] | None = None

    def reset(self, *, vx: float = 0.0, vy: float = 0.0, omega: float = 0.0) -> None:
        """Everything as new: encoders at zero, battery rested, time at zero, sides rolling with the chassis.

        Args:
            vx: Velocity of the center of mass with which the wheels roll, forward [m/s]. The chassis has its own.
            vy: To the left; wheels cannot roll that way [m/s].
            omega: Yaw rate [rad/s].

        Raises:
            NonFiniteError: When a number is not finite; nothing has changed.
        """
        for name, value in (("vx", vx), ("vy", vy), ("omega", omega)):
            checked_number(f"reset {name}", value)
        sides = (self.robot.positions[0][1], self.robot.positions[-1][1])
        self._rest([(vx - omega * y) / self.config.wheel_radius for y in sides])
        self.stop()

    # ---------------------------------------------------------------- commands

    def set_volts(self, left: float, right: float) -> None:
        """Raw voltage per side [V].

        Raises:
            NonFiniteError: When one is missing, NaN or infinite; nothing has changed.
        """
        self._command(_pair("volts", left, right), None)

    def set_speeds(self, left: float, right: float) -> None:
        """Closed loop on board: ground speed per side [m/s]; see `set_volts` for errors."""
        self._command(self._volts, _pair("speed", left, right))

    def set_chassis_speeds(self, vx: float, omega: float) -> None:
        """Closed loop on board: forward speed [m/s] and yaw rate [rad/s], if the wheels did not scrub."""
        vx, omega = _pair("chassis speed", vx, omega)
        half = 0.5 * self.config.trackwidth * omega
        self.set_speeds(vx - half, vx + half)

    def stop(self) -> None:
        """Zero command: brake or coast."""
        self._command((0.0, 0.0), None)

    def _command(self, volts: tuple[float, float], targets: tuple[float, float] | None) -> None:
        is_other = volts != self._volts or targets != self._targets
        self._volts, self._targets = volts, targets
        self._new_command(is_other)

    def _requests(self, h: float, bus: float, neutral: bool) -> tuple[Sequence[float | None], Sequence[float]]:
        c = self.config
        request: list[float | None] = list(self._volts)
        if neutral:
            request = [0.0, 0.0]
        elif self._targets is not None:
            request = [
                self._known_emf * v / c.wheel_radius + c.kp * (v - w * c.wheel_radius)
                for v, w in zip(self._targets, self.shaft_speeds, strict=True)
            ]
        if not c.brake:
            request = [v if v != 0.0 else None for v in request]
        return request, self._stator_limits

    # ---------------------------------------------------------------- readings

    def wheel_angles(self) -> list[float]:
        """Azimuth of each wheel: always forward [rad]."""
        return [0.0] * self._wheels

    def motor_currents(self) -> dict[str, list[float]]:
        """Stator currents in the last inner step, motor by motor: `left` and `right` [A]."""
        left, right = self.drive_motors.current
        return {"left": [left] * self._motors_per_shaft, "right": [right] * self._motors_per_shaft}

    @property
    def gearing(self) -> dict[str, list[float]]:
        """Rotor turns per wheel turn, motor by motor: `left` and `right` [-]."""
        ratios = [self.config.gearing] * self._motors_per_shaft
        return {"left": ratios, "right": ratios[:]}

    def side_distances(self) -> tuple[float, float]:
        """How far left and right wheels have rolled since the reset [m]."""
        left, right = self.shaft_angles
        return left * self.config.wheel_radius, right * self.config.wheel_radius

    def side_speeds(self) -> tuple[float, float]:
        """Speed of the treads against the robot, left and right [m/s]."""
        left, right = self.shaft_speeds
        return left * self.config.wheel_radius, right * self.config.wheel_radius


def _side_motor(c: TankConfig) -> LimitedMotor:
    """All motors of one side."""
    usual = controller_limits(c.motor)
    return LimitedMotor.of(
        c.motor,
        gearing=c.gearing,
        efficiency=c.efficiency,
        friction_volts=c.friction_volts,
        stator_limit=usual[0] if c.stator_limit is None else c.stator_limit,
        supply_limit=usual[1] if c.supply_limit is None else c.supply_limit,
        count=c.motors_per_side,
    )


def _pair(what: str, left: float, right: float) -> tuple[float, float]:
    return checked_number(f"tank {what}, left,", left), checked_number(f"tank {what}, right,", right)
