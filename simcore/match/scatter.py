"""Scatter: random differences of robots, pieces, sensors and human players between matches and between shots.

A `Scatter` contains the size of each spread. `ScatterDraws` draws the values for a match, with a separate random
generator for each spread and object. A draw therefore depends only on the match's seed, and not on other spreads, the
order of draws or the number of robots. `built_robot` draws the differences between a robot as built and the config.
"""

from __future__ import annotations

import dataclasses
import math
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.pieces.kinds import PieceVariation
from simcore.quantities import FACTOR, Quantity, require, require_fields, shown
from simcore.robot.battery import BatteryConfig
from simcore.robot.dc_motor import MotorModel
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.gyro import GyroConfig
from simcore.robot.mechanisms import PistonConfig, ServoConfig
from simcore.robot.robot_config import BuiltRobot, MechanismConfig, RobotConfig
from simcore.robot.shooter import ShotErrors
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.typing import FloatArray, FloatSupplier
from simcore.units import degrees
from simcore.world.symmetry import Pose

__all__ = ["Scatter", "ScatterDraws", "built_robot", "piece_variation", "start_error"]

_SHARE = Quantity("", 0.0, 0.5)
_ANGLE = Quantity("rad", 0.0, 0.5)
_RATE = Quantity("rad/s", 0.0, 0.5)


@dataclass(frozen=True, slots=True, kw_only=True)
class Scatter:
    """Sizes of all random differences, called spreads; `Scatter()` has default sizes, `Scatter.none()` has no spread.

    Unless stated otherwise, a spread with a unit is the standard deviation of a normally distributed error. A
    dimensionless spread is the standard deviation of the logarithm of a random factor on the value in the config of the
    game or robot. To make a variant, use `dataclasses.replace`, `scaled` or `parse`.

    Example:
        >>> half = Scatter().scaled(0.5)
        >>> round(half.exit_speed / Scatter().exit_speed, 9), Scatter.none().exit_speed
        (0.5, 0.0)
    """

    exit_speed: float = 0.03
    """Spread of the exit speed, for each shot [-].

    Estimate: 2 to 5 % for foam balls, mostly from the balls themselves. Balls of different density land up to 2 m apart
    (vexforum.com/t/29718), and used balls fall short of new balls (chiefdelphi.com/t/150445, /t/117361)."""
    elevation: float = degrees(1.0)
    """Spread of the elevation, for each shot [rad]. Estimate: backlash of the hood, and variation of the point where a
    piece leaves the hood."""
    azimuth: float = degrees(0.7)
    """Spread of the azimuth, for each shot [rad]. Estimate: lateral position of the piece on the wheels."""
    spin: float = 0.1
    """Spread of the spin, for each shot [-]. Estimate; spin matters for pieces with lift and after the first bounce."""
    feed_time: float = 0.02
    """Spread of the time since the previous shot, for each shot [s]. Estimate: gaps between pieces vary."""
    piece_mass: float = 0.055
    """Spread of the mass, for each piece, uniform within plus or minus this value [-]. According to the 2026 manual,
    balls weigh 0.448 to 0.500 lb; boulders of 2016 were within 2 % (chiefdelphi.com/t/147506)."""
    piece_diameter: float = 0.01
    """Spread of the diameter, for each piece, uniform within plus or minus this value [-]. Estimate, within a factor of
    2: no manual gives a tolerance."""
    restitution: float = 0.05
    """Spread of the coefficient of restitution, for each piece [-]. Estimate."""
    drag: float = 0.05
    """Spread of the drag coefficient, for each piece [-]. Estimate: skins wear, and balls that are not round tumble."""
    tread_friction: float = 0.08
    """Spread of the treads' coefficient of friction on carpet, for each robot [-]. Estimate: some fields have carpet
    with good grip, others have slippery carpet (chiefdelphi.com/t/160925)."""
    wheel_wear: float = 0.025
    """Largest tread wear, for each wheel: relative reduction of the wheel radius in the config, uniform from 0 to this
    value [-]. A 3.75 in wheel loses 0.05 in of tread at an event (chiefdelphi.com/t/406728)."""
    battery_charge: float = 0.1
    """Largest missing charge at the start, for each battery, uniform from 0 to this value [-]. Estimate: time spent
    waiting in the queue."""
    battery_resistance: float = 0.12
    """Spread of the resistances, for each battery [-]. One team's used batteries have internal resistances of 13 to 21
    mohm (chiefdelphi.com/t/368572); with 5 mohm of cable, the total is 22 +- 2.5 mohm."""
    motor_kt: float = 0.03
    """Spread of the torque constant, and equally of the back-EMF constant, for each motor [-]. HIWIN guarantees +-10 %
    for torque motors ("tolerances"), taken as three standard deviations."""
    motor_resistance: float = 0.04
    """Spread of the resistance of winding and leads, for each motor [-]. Source: HIWIN as for `motor_kt`, plus
    10 K of temperature rise of the copper, at 0.4 %/K."""
    encoder: float = degrees(0.5)
    """Spread of the zero offset of each absolute encoder on swerve steering, hoods and turrets [rad]. Estimate: teams
    zero wheels along a straight bar, and hoods at a hard stop."""
    drive_friction: float = 0.47
    """Spread of kS, for each tank or mecanum drive: a typical factor of 1.6 [-]. Published kS values of tank drives
    range from 0.13 to 1.31 V, around 0.65 V."""
    swerve_friction: float = 0.18
    """Spread of kS, for each swerve drive: a typical factor of 1.2 [-]. Estimate: the values of one team agree from day
    to day, but values of different teams differ more."""
    drive_sides: float = 0.03
    """Largest loss of gear efficiency, for each side of a tank drive or wheel of another drive, uniform from 0 to
    this value [-]. A kit chassis turned by 0.3 rad over 12 m at equal voltages."""
    gyro: float = degrees(0.01)
    """Spread of the measured yaw rate at rest, for each gyro [rad/s]. Estimate: a drift of 0.6 degrees per minute
    remains after calibration at power-up, when the robot stands on a cart."""
    start_position: float = 0.015
    """Spread of the starting position along x and along y, for each robot [m]. Estimate: the drive team places the
    robot at a mark by eye."""
    start_heading: float = degrees(1.0)
    """Spread of the starting heading, for each robot [rad]. Estimate: 14 mm at the end of a bumper."""
    camera_noise: float = 0.3
    """Spread of the image noise, for each camera [-]. Estimate: focus, exposure and light vary."""
    human_players: float = 0.2
    """Spread of times and errors, for each human player [-]. Estimate."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            exit_speed=_SHARE,
            elevation=_ANGLE,
            azimuth=_ANGLE,
            spin=_SHARE,
            feed_time=Quantity("s", 0.0, 1.0),
            piece_mass=_SHARE,
            piece_diameter=Quantity("", 0.0, 0.1),
            restitution=_SHARE,
            drag=_SHARE,
            tread_friction=_SHARE,
            wheel_wear=_SHARE,
            battery_charge=Quantity("", 0.0, 1.0),
            battery_resistance=_SHARE,
            motor_kt=_SHARE,
            motor_resistance=_SHARE,
            drive_friction=Quantity("", 0.0, 1.0),
            swerve_friction=Quantity("", 0.0, 1.0),
            drive_sides=_SHARE,
            encoder=_ANGLE,
            gyro=_RATE,
            start_position=Quantity("m", 0.0, 0.5),
            start_heading=_ANGLE,
            camera_noise=_SHARE,
            human_players=_SHARE,
        )

    @classmethod
    def none(cls) -> Scatter:
        """Return a scatter without any spread, for a nominal run."""
        return cls(**dict.fromkeys(cls.names(), 0.0))

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Return the names of all spreads in order of definition."""
        return tuple(field.name for field in dataclasses.fields(cls))

    def scaled(self, factor: float) -> Scatter:
        """Return a scatter with all spreads multiplied by a factor.

        Raises:
            ConfigError: If the factor is not a number >= 0 or makes a spread too large.
        """
        require("Scatter", "factor", factor, FACTOR)
        return Scatter(**{name: factor * getattr(self, name) for name in self.names()})

    @classmethod
    def parse(cls, text: str) -> Scatter:
        """Parse a scatter: an optional factor on all default spreads, then `name=value` for single spreads.

        >>> Scatter.parse("0.5") == Scatter().scaled(0.5)
        True
        >>> only = Scatter.parse("0, exit_speed=0.03")
        >>> only.exit_speed, only.elevation
        (0.03, 0.0)

        Raises:
            ConfigError: If a part is not a number or a spread is too large.
            UnknownNameError: If no spread has one of the names.
        """
        first, *rest = text.split(",")
        if "=" in first:
            first, rest = "1", [first, *rest]
        own: dict[str, float] = {}
        for part in rest:
            name, _, value = part.partition("=")
            if name.strip() not in cls.names():
                raise UnknownNameError("spread", name.strip(), cls.names())
            own[name.strip()] = _number(text, value)
        return dataclasses.replace(cls().scaled(_number(text, first)), **own)

    @property
    def text(self) -> str:
        """Text of this scatter in the format of `parse`, with all spreads that are not 0.

        >>> Scatter.parse(Scatter().text) == Scatter(), Scatter.none().text
        (True, '0')
        """
        values = {name: float(getattr(self, name)) for name in self.names()}
        return ",".join(["0", *(f"{name}={value!r}" for name, value in values.items() if value)])


def _number(text: str, part: str) -> float:
    try:
        return float(part)
    except ValueError:
        raise ConfigError(
            f"scatter must be a factor of the default spreads and spreads by name, e.g. '0.5' or '1,exit_speed=0.03', "
            f"got {shown(text)}"
        ) from None


class ScatterDraws:
    """Random draws of one match. Each draw depends only on the seed, the spread's name and the object's numbers.

    Args:
        scatter: Sizes of all spreads.
        seed: Seed of the match.
    """

    def __init__(self, scatter: Scatter, seed: int) -> None:
        self.scatter = scatter
        self._seed = seed

    def generator(self, name: str, *numbers: int) -> np.random.Generator:
        """Return a new random generator for one spread of one object; equal arguments give equal draws.

        Args:
            name: Name of the spread.
            numbers: Numbers that identify the object, e.g. robot number and shooter number.
        """
        return np.random.default_rng((self._seed, zlib.crc32(name.encode()), *numbers))

    def normal(self, name: str, *numbers: int) -> float:
        """Draw a normally distributed number with mean 0 and the size of a spread as standard deviation."""
        size: float = getattr(self.scatter, name)
        return size * float(self.generator(name, *numbers).standard_normal()) if size else 0.0

    def factor(self, name: str, *numbers: int) -> float:
        """Draw a log-normally distributed factor with median 1: e to the power of a draw of `normal`."""
        return math.exp(self.normal(name, *numbers))

    def share(self, name: str, *numbers: int) -> float:
        """Draw a uniformly distributed number from 0 to the size of a spread."""
        size: float = getattr(self.scatter, name)
        return size * float(self.generator(name, *numbers).random()) if size else 0.0


def piece_variation(draws: ScatterDraws, counts: Sequence[int]) -> PieceVariation:
    """Draw the factors on mass, diameter, restitution and drag of all pieces of a match.

    Args:
        draws: Random draws of the match.
        counts: Number of pieces of each kind, in the order of the pool.
    """
    return PieceVariation(
        mass=_each("piece_mass", draws, counts, _even),
        diameter=_each("piece_diameter", draws, counts, _even),
        restitution=_each("restitution", draws, counts, _normal),
        drag=_each("drag", draws, counts, _normal),
    )


def _each(
    name: str,
    draws: ScatterDraws,
    counts: Sequence[int],
    factors: Callable[[np.random.Generator, float, int], FloatArray],
) -> FloatArray:
    size: float = getattr(draws.scatter, name)
    rows = [factors(draws.generator(name, kind), size, count) for kind, count in enumerate(counts)]
    return np.concatenate([np.ones(0), *rows])


def _even(rng: np.random.Generator, size: float, count: int) -> FloatArray:
    return 1.0 + rng.uniform(-size, size, count)


def _normal(rng: np.random.Generator, size: float, count: int) -> FloatArray:
    return np.exp(size * rng.standard_normal(count))


_DRIVE, _STEER, _MECHANISM = range(3)  # groups of motors
_AZIMUTH, _HOOD, _TURRET = range(3)  # groups of encoders
_MAX_COF = 10.0  # largest allowed friction
_AHEAD = 64  # random numbers that a shooter draws at once


def built_robot(config: RobotConfig, draws: ScatterDraws, robot: int) -> BuiltRobot:
    """Return the robot as built: drivetrain, battery, gyro and mechanisms with random errors, and shot errors.

    Args:
        config: Config of the robot.
        draws: Random draws of the match.
        robot: Number of the robot.
    """
    drivetrain = config.drivetrain
    return BuiltRobot(
        drivetrain=(
            _swerve(drivetrain, draws, robot)
            if isinstance(drivetrain, SwerveConfig)
            else _fixed_wheels(drivetrain, draws, robot)
        ),
        battery=_battery(config.battery, draws, robot),
        gyro=_gyro(config.gyro, draws, robot),
        mechanisms={
            name: _mechanism(mechanism, draws, robot, number)
            for number, (name, mechanism) in enumerate(config.mechanisms.items())
        },
        shot_errors=tuple(
            _shot_errors(draws, robot, number, hood=shooter.hood is not None, turret=shooter.turret is not None)
            for number, shooter in enumerate(config.shooters)
        ),
    )


def start_error(draws: ScatterDraws, robot: int) -> Pose:
    """Draw the drive team's placement error in the robot frame: forward, left and counter-clockwise [m, m, rad]."""
    return (
        draws.normal("start_position", robot, 0),
        draws.normal("start_position", robot, 1),
        draws.normal("start_heading", robot),
    )


# --- drivetrain -----------------------------------------------------------------------------------------------------


def _swerve(config: SwerveConfig, draws: ScatterDraws, robot: int) -> SwerveConfig:
    tread, drag = draws.factor("tread_friction", robot), draws.factor("swerve_friction", robot)

    def built(number: int, module: SwerveModuleConfig) -> SwerveModuleConfig:
        return replace(
            module,
            drive_motor=_motor(module.drive_motor, draws, robot, _DRIVE, number),
            steer_motor=_motor(module.steer_motor, draws, robot, _STEER, number),
            drive_friction_volts=drag * module.drive_friction_volts,
            drive_efficiency=module.drive_efficiency * (1.0 - draws.share("drive_sides", robot, number)),
            wheel_cof=min(_MAX_COF, tread * module.wheel_cof),
            wheel_radius=module.wheel_radius * (1.0 - draws.share("wheel_wear", robot, number)),
            steer_offset=module.steer_offset + draws.normal("encoder", robot, _AZIMUTH, number),
        )

    return replace(config, modules=tuple(built(number, module) for number, module in enumerate(config.modules)))


def _fixed_wheels(
    config: TankConfig | MecanumConfig, draws: ScatterDraws, robot: int
) -> tuple[TankConfig | MecanumConfig, ...]:
    """Draw the as-built config of each wheel of a mecanum drive or of each side of a tank drive.

    The factor on a motor constant is the mean factor of the motors on a shaft. All wheels of a side have the same wear.
    """
    tread, drag = draws.factor("tread_friction", robot), draws.factor("drive_friction", robot)
    is_tank = isinstance(config, TankConfig)
    sides: tuple[TankConfig | MecanumConfig, ...] = config.sides if isinstance(config, TankConfig) else (config,) * 4
    motors = config.motors_per_side if isinstance(config, TankConfig) else config.motors_per_wheel

    def built(side: int) -> TankConfig | MecanumConfig:
        kt, resistance = _motor_factors(draws, motors, robot, _DRIVE, side)
        one = sides[side]
        return replace(
            one,
            motor=config.motor.varied(kt=kt, resistance=resistance),
            friction_volts=drag * one.friction_volts,
            efficiency=one.efficiency * (1.0 - draws.share("drive_sides", robot, side)),
            wheel_cof=min(_MAX_COF, tread * config.wheel_cof),
            wheel_radius=config.wheel_radius * (1.0 - draws.share("wheel_wear", robot, side)),
        )

    return tuple(built(shaft) for shaft in range(2 if is_tank else 4))


# --- motors, battery, gyro ------------------------------------------------------------------------------------------


def _motor_factors(draws: ScatterDraws, motors: int, *numbers: int) -> tuple[float, float]:
    """Draw factors for the motors on a shaft; return the mean torque-constant factor and the mean resistance factor."""
    kt = [draws.factor("motor_kt", *numbers, motor) for motor in range(motors)]
    resistance = [draws.factor("motor_resistance", *numbers, motor) for motor in range(motors)]
    return math.fsum(kt) / motors, math.fsum(resistance) / motors


def _motor(motor: MotorModel, draws: ScatterDraws, *numbers: int) -> MotorModel:
    kt, resistance = _motor_factors(draws, 1, *numbers)
    return motor.varied(kt=kt, resistance=resistance)


def _gearbox(gearbox: GearboxConfig, draws: ScatterDraws, *numbers: int) -> GearboxConfig:
    kt, resistance = _motor_factors(draws, gearbox.motors, *numbers)
    return gearbox.varied(kt=kt, resistance=resistance)


def _mechanism(config: MechanismConfig, draws: ScatterDraws, robot: int, number: int) -> MechanismConfig:
    if isinstance(config, PistonConfig | ServoConfig):
        return config
    return replace(config, gearbox=_gearbox(config.gearbox, draws, robot, _MECHANISM, number))


def _battery(config: BatteryConfig, draws: ScatterDraws, robot: int) -> BatteryConfig:
    aged = draws.factor("battery_resistance", robot)  # one factor, because both resistances rise with age
    return replace(
        config,
        initial_charge=max(0.0, config.initial_charge - draws.share("battery_charge", robot)),
        resistance=aged * config.resistance,
        recovery_resistance=aged * config.recovery_resistance,
    )


def _gyro(config: GyroConfig, draws: ScatterDraws, robot: int) -> GyroConfig:
    return replace(config, bias_dps=config.bias_dps + math.degrees(draws.normal("gyro", robot)))


# --- shots ----------------------------------------------------------------------------------------------------------


def _shot_errors(draws: ScatterDraws, robot: int, shooter: int, *, hood: bool, turret: bool) -> ShotErrors:
    def errors(name: str) -> FloatSupplier:
        return _normals(getattr(draws.scatter, name), draws.generator(name, robot, shooter))

    def factors(name: str) -> FloatSupplier:
        error = errors(name)
        return lambda: math.exp(error())

    return ShotErrors(
        exit_speed=factors("exit_speed"),
        elevation=errors("elevation"),
        azimuth=errors("azimuth"),
        spin=factors("spin"),
        feed_time=errors("feed_time"),
        hood=draws.normal("encoder", robot, _HOOD, shooter) if hood else 0.0,
        turret=draws.normal("encoder", robot, _TURRET, shooter) if turret else 0.0,
    )


def _normals(size: float, rng: np.random.Generator) -> Callable[[], float]:
    """Return a function that draws a normally distributed number, mean 0, standard deviation `size`, at each call."""
    ready: list[float] = []

    def next_one() -> float:
        if not ready:
            ready.extend(reversed((size * rng.standard_normal(_AHEAD)).tolist()))
        return ready.pop()

    return next_one
