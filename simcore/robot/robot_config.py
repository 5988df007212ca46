"""What a robot is built of: a body on a drivetrain, mechanisms by name, and what they do with pieces."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TypeAlias

from simcore.errors import ConfigError, UnknownNameError
from simcore.geometry.linkage import Joint, part_pose, require_mechanisms
from simcore.geometry.rotation import Vector
from simcore.pieces.intake import IntakeConfig
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.placer import PlacerConfig
from simcore.pieces.shooter import ShooterConfig, ShotErrors
from simcore.pieces.storage import StorageConfig
from simcore.quantities import ROBOT_LENGTH, ROBOT_PLACE, require_fields
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.chassis_config import (
    ChassisConfig,
    MassDistribution,
    MovingMass,
    PointMass,
    moved_points,
    with_points,
)
from simcore.robot.climber import ClimberConfig
from simcore.robot.fixed_wheel_config import FixedWheelConfig, MecanumConfig, TankConfig
from simcore.robot.fixed_wheel_drive import MecanumDrive, TankDrive
from simcore.robot.gyro import GyroConfig, gyro_config
from simcore.robot.mechanisms import (
    ArmConfig,
    ArmSim,
    ElevatorConfig,
    ElevatorSim,
    FlywheelConfig,
    FlywheelSim,
    PistonConfig,
    PistonSim,
    RackConfig,
    RackSim,
    RollerConfig,
    RollerSim,
    ServoConfig,
    ServoSim,
    ShaftSim,
)
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.units import GRAVITY
from simcore.vision.camera import CameraConfig

__all__ = [
    "BuiltRobot",
    "ComponentConfig",
    "MechanismConfig",
    "RobotConfig",
    "TippingLimit",
    "build_drivetrain",
    "build_mechanism",
    "stored_kind",
    "telemetry_name",
    "tipping_limit",
]

MechanismConfig: TypeAlias = (
    FlywheelConfig | RollerConfig | ArmConfig | ElevatorConfig | RackConfig | PistonConfig | ServoConfig
)


def build_mechanism(config: MechanismConfig) -> ShaftSim:
    """The mechanism of a config, at its start."""
    if isinstance(config, FlywheelConfig):
        return FlywheelSim(config)
    if isinstance(config, RollerConfig):
        return RollerSim(config)
    if isinstance(config, ArmConfig):
        return ArmSim(config)
    if isinstance(config, ElevatorConfig):
        return ElevatorSim(config)
    if isinstance(config, RackConfig):
        return RackSim(config)
    return PistonSim(config) if isinstance(config, PistonConfig) else ServoSim(config)


def build_drivetrain(
    config: SwerveConfig | TankConfig | MecanumConfig,
    *,
    battery: Battery | None = None,
    built: SwerveConfig | Sequence[FixedWheelConfig] | None = None,
) -> SwerveDrive | TankDrive | MecanumDrive:
    """The model of a drivetrain, at rest; for `built` see `BuiltRobot`."""
    if isinstance(config, SwerveConfig):
        assert built is None or isinstance(built, SwerveConfig)
        return SwerveDrive(config, battery=battery, built=built)
    assert not isinstance(built, SwerveConfig)
    if isinstance(config, MecanumConfig):
        return MecanumDrive(config, battery=battery, built=built)
    return TankDrive(config, battery=battery, built=built)


@cache
@cache
def telemetry_name(mechanism: str) -> str:
    """The name of a mechanism as telemetry keys spell it.

    >>> telemetry_name("intake_deploy"), telemetry_name("left hood")
    ('IntakeDeploy', 'LeftHood')
    """
    return "".join(word[:1].upper() + word[1:] for word in re.split(r"[^0-9A-Za-z]+", mechanism))


@dataclass(frozen=True, slots=True, kw_only=True)
class ComponentConfig:
    """A part of the robot that has a model of its own for AdvantageScope."""

    name: str
    offset: Vector = (0.0, 0.0, 0.0)
    """Of the part's origin in the frame after the last joint [m]."""
    joints: tuple[Joint, ...] = ()
    """What moves it, from the robot outward."""

    def __post_init__(self) -> None:
        require_fields(self, f"component {self.name!r}", offset=(ROBOT_PLACE,) * 3)


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotConfig:
    """One robot. Make variants with `dataclasses.replace`.

    Raises:
        ConfigError: Parts that do not fit each other.
        UnknownNameError: An intake, shooter, placer, climber or component names a mechanism that is not there.
    """

    drivetrain: SwerveConfig | TankConfig | MecanumConfig
    """Motors, wheels and tires; its mass is that of the whole robot as it starts, with nothing held."""
    bumper: tuple[float, float] = (0.8, 0.8)
    """Length and width over the bumpers [m]."""
    chassis: ChassisConfig | None = None
    """The body, where the one that follows from drivetrain and bumpers will not do."""
    battery: BatteryConfig = field(default_factory=BatteryConfig)
    gyro: GyroConfig = field(default_factory=lambda: gyro_config("pigeon2"))
    mechanisms: Mapping[str, MechanismConfig] = field(default_factory=dict)
    """By name, in the order in which they are stepped and published."""
    intakes: tuple[IntakeConfig, ...] = ()
    storage: StorageConfig = field(default_factory=StorageConfig)
    """Room for pieces; preloads are in it, and intakes and shooters that name no storage use it."""
    more_storages: tuple[StorageConfig, ...] = ()
    """Further ones, by their names."""
    shooters: tuple[ShooterConfig, ...] = ()
    placers: tuple[PlacerConfig, ...] = ()
    climbers: tuple[ClimberConfig, ...] = ()
    cameras: tuple[CameraConfig, ...] = ()
    """Limelights; each name only once in a match."""
    components: tuple[ComponentConfig, ...] = ()
    """Parts with models of their own, in the order of the model files."""
    moving_masses: tuple[MovingMass, ...] = ()
    """What of its mass its mechanisms move; all else is its body."""
    team: int | None = None
    """Number on its bumpers; None: its number in the match."""
    models: Path | None = None
    """Folder with its own model, as AdvantageScope has them; None: the game's, or drawn by this config."""

    def __post_init__(self) -> None:
        require_fields(self, bumper=(ROBOT_LENGTH, ROBOT_LENGTH))
        body = self.body
        d = self.drivetrain
        if len(d.positions) != len(body.wheel_positions):
            raise ConfigError(
                f"RobotConfig: drivetrain has {len(d.positions)} wheels, but the chassis {len(body.wheel_positions)}"
            )
        if abs(d.mass - body.mass) > 1e-9 * d.mass:
            raise ConfigError(
                f"RobotConfig: mass of drivetrain and chassis must agree, got {d.mass} and {body.mass} kg"
            )
        keys: dict[str, str] = {}
        for name in self.mechanisms:
            key = telemetry_name(name)
            if not key:
                raise ConfigError(f"RobotConfig: a mechanism's name needs a letter or digit, got {name!r}")
            if keys.setdefault(key, name) != name:
                raise ConfigError(f"RobotConfig: mechanisms {keys[key]!r} and {name!r} are both {key!r} in telemetry")
        for shooter in self.shooters:
            require_mechanisms("a shooter", shooter.mechanism_names, self.mechanisms)
            for wheel in shooter.wheels:
                if not isinstance(self.mechanisms[wheel], FlywheelConfig):
                    raise ConfigError(f"RobotConfig: the wheels of a shooter must be flywheels, but {wheel!r} is none")
        for owner, parts in (
            ("an intake", self.intakes), ("a placer", self.placers), ("a climber", self.climbers)
        ):  # fmt: skip
            for part in parts:
                require_mechanisms(owner, part.mechanism_names, self.mechanisms)
        storages = [self.storage.name, *(storage.name for storage in self.more_storages)]
        if len(set(storages)) < len(storages) or "" in storages[1:]:
            raise ConfigError(f"RobotConfig: storages need names of their own, got {storages}")
        for room in (self.storage, *self.more_storages):
            if room.hopper is not None:
                require_mechanisms("a hopper", (room.hopper.belt,), self.mechanisms)
        users: tuple[IntakeConfig | ShooterConfig | PlacerConfig, ...] = (
            *self.intakes,
            *self.shooters,
            *self.placers,
        )
        for user in users:
            if user.storage and user.storage not in storages:
                owner = type(user).__name__.removesuffix("Config").lower()
                raise UnknownNameError(f"storage (of {owner})", user.storage, storages)
        for component in self.components:
            names = (joint.mechanism for joint in component.joints)
            require_mechanisms(f"component {component.name!r}", names, self.mechanisms)
        for moving in self.moving_masses:
            names = (joint.mechanism for joint in moving.joints)
            require_mechanisms(f"moving mass {moving.name!r}", names, self.mechanisms)
        left = self.bare_body
        if left.mass <= 0.0 or min(left.inertia) <= 0.0:
            raise ConfigError(
                f"RobotConfig: the moving masses leave nothing for the body: {self.whole.mass:g} kg with moments of "
                f"inertia {_figures(self.whole.inertia)} kg m^2 are the whole robot's, and without them it has "
                f"{left.mass:g} kg with {_figures(left.inertia)}"
            )
        if min(_limits(self, self.whole)) <= 0.0:
            raise ConfigError(
                "RobotConfig: center_of_mass must lie between the wheels, or the robot falls over, got "
                f"{self.drivetrain.center_of_mass} with wheels at {body.wheel_positions}"
            )

    @property
    def body(self) -> ChassisConfig:
        """The body: as given, or as it follows from drivetrain and bumpers."""
        return self.chassis or ChassisConfig.around(self.drivetrain, bumper=self.bumper)

    @property
    def whole(self) -> MassDistribution:
        """Of the whole robot as it starts, with nothing held."""
        body, (x, y, _) = self.body, self.drivetrain.center_of_mass
        return MassDistribution(body.mass, (x, y, body.center_of_mass_height), body.inertia)

    @property
    def bare_body(self) -> MassDistribution:
        """Of the same without its moving masses."""
        if not self.moving_masses:
            return self.whole
        start = {name: build_mechanism(mechanism) for name, mechanism in self.mechanisms.items()}
        return with_points(self.whole, [(-mass, place) for mass, place in moved_points(self.moving_masses, start)])


@dataclass(frozen=True, slots=True, kw_only=True)
class BuiltRobot:
    """What may differ from a `RobotConfig` in the robot that was built after it."""

    drivetrain: SwerveConfig | tuple[FixedWheelConfig, ...]
    """Of a tank drive the left and the right side, of a mecanum drive each wheel."""
    battery: BatteryConfig
    gyro: GyroConfig
    mechanisms: Mapping[str, MechanismConfig]
    shot_errors: tuple[ShotErrors | None, ...]
    """Of each shooter."""

    @classmethod
    def exactly(cls, config: RobotConfig) -> BuiltRobot:
        """One that is what its config says."""
        drivetrain = config.drivetrain
        shafts = 4 if isinstance(drivetrain, MecanumConfig) else 2
        return cls(
            drivetrain=drivetrain if isinstance(drivetrain, SwerveConfig) else (drivetrain,) * shafts,
            battery=config.battery,
            gyro=config.gyro,
            mechanisms=config.mechanisms,
            shot_errors=(None,) * len(config.shooters),
        )


def _figures(values: Vector) -> str:
    return "(" + ", ".join(f"{value:.3g}" for value in values) + ")"


@dataclass(frozen=True, slots=True)
class TippingLimit:
    """Of a robot with everything up and full."""

    mass: float
    """Then [kg]."""
    height: float
    """Of its center of mass above the floor [m]."""
    forward: float
    """Acceleration along x at which wheels lift, speeding up or braking, whichever is less [m/s^2]."""
    sideways: float
    """The same along y [m/s^2]."""
    drivetrain: float
    """What its drivetrain can do from rest, so loaded [m/s^2]."""


def tipping_limit(config: RobotConfig, kinds: Sequence[GamePieceConfig] = ()) -> TippingLimit:
    """Where the weight's moment about the outer wheels meets that of the acceleration: a h = g b.

    h is the height of the center of mass, b how far it is inside of the outermost wheels. Storages and placers are full
    of the heaviest kind that they can hold.

    Args:
        config: The robot.
        kinds: Of pieces that it may hold; none: it is empty.
    """
    worst = min(_standings(config, kinds), key=lambda one: min(_limits(config, one)))
    forward, sideways = _limits(config, worst)
    drive = build_drivetrain(config.drivetrain)
    drive.set_mass_properties(worst.mass, worst.inertia[2], worst.center)
    return TippingLimit(worst.mass, worst.center[2], forward, sideways, drive.max_accel)


def _limits(config: RobotConfig, standing: MassDistribution) -> tuple[float, float]:
    """Acceleration along x and along y at which wheels lift [m/s^2]."""
    x, y, height = standing.center
    xs, ys = zip(*config.body.wheel_positions, strict=True)
    per_meter = GRAVITY / max(height, 1e-3)
    along, across = min(max(xs) - x, x - min(xs)), min(max(ys) - y, y - min(ys))
    return per_meter * max(0.0, along), per_meter * max(0.0, across)


def _standings(config: RobotConfig, kinds: Sequence[GamePieceConfig]) -> Iterator[MassDistribution]:
    """The full robot with the mechanisms that move mass at all of their stops."""
    mechanisms: dict[str, ShaftSim] = {name: build_mechanism(one) for name, one in config.mechanisms.items()}
    body = with_points(config.bare_body, _stored(config, kinds))
    chains = [part.joints for part in config.moving_masses] + [placer.joints for placer in config.placers]
    carriers = dict.fromkeys(joint.mechanism for chain in chains for joint in chain)
    names = [name for name in carriers if all(map(math.isfinite, mechanisms[name].stops))]
    for positions in itertools.product(*(mechanisms[name].stops for name in names)):
        for name, position in zip(names, positions, strict=True):
            mechanisms[name].reset(position)
        points = moved_points(config.moving_masses, mechanisms)
        for placer in config.placers:
            heaviest = _heaviest(kinds, placer.kinds)
            if heaviest is not None:
                points.append((heaviest.mass, part_pose(placer.joints, mechanisms, placer.offset)[0]))
        yield with_points(body, points)


def stored_kind(
    config: RobotConfig, storage: StorageConfig, kinds: Sequence[GamePieceConfig]
) -> GamePieceConfig | None:
    """The heaviest kind that intakes bring into a storage; None if they bring none."""
    names = (storage.name, "") if storage is config.storage else (storage.name,)
    users = [intake for intake in config.intakes if intake.storage in names]
    allowed = [] if any(not one.kinds for one in users) else [kind for one in users for kind in one.kinds]
    return _heaviest(kinds, allowed)


def _stored(config: RobotConfig, kinds: Sequence[GamePieceConfig]) -> Iterator[PointMass]:
    """The pieces in full storages."""
    for storage in (config.storage, *config.more_storages):
        heaviest = stored_kind(config, storage, kinds)
        if heaviest is not None:
            for number in range(storage.capacity):
                yield heaviest.mass, storage.position(number, heaviest.bounding_radius)


def _heaviest(kinds: Sequence[GamePieceConfig], allowed: Sequence[str]) -> GamePieceConfig | None:
    """Of those that are allowed; all are if none is named."""
    return max((k for k in kinds if not allowed or k.name in allowed), key=lambda kind: kind.mass, default=None)
