"""Config of a robot: body, drivetrain, mechanisms by name, and parts that handle game pieces."""

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
from simcore.pieces.kinds import GamePieceConfig
from simcore.quantities import ROBOT_LENGTH, ROBOT_PLACE, Quantity, require, require_fields
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
from simcore.robot.intake import IntakeConfig
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
from simcore.robot.placer import PlacerConfig
from simcore.robot.shooter import ShooterConfig, ShotErrors
from simcore.robot.storage import StorageConfig
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.units import GRAVITY
from simcore.vision.camera import CameraConfig
from simcore.world.linkage import Joint, part_pose, require_mechanisms
from simcore.world.rotation import Vector

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
    """Build a mechanism from its config, in the initial state."""
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
    """Build the model of a drivetrain, at rest.

    Args:
        config: Nominal drivetrain.
        battery: Battery of the robot; None for a stiff 12 V supply.
        built: `BuiltRobot.drivetrain`, the drivetrain as actually built; None for the nominal drivetrain.
    """
    if isinstance(config, SwerveConfig):
        assert built is None or isinstance(built, SwerveConfig)
        return SwerveDrive(config, battery=battery, built=built)
    assert not isinstance(built, SwerveConfig)
    if isinstance(config, MecanumConfig):
        return MecanumDrive(config, battery=battery, built=built)
    return TankDrive(config, battery=battery, built=built)


@cache
def telemetry_name(mechanism: str) -> str:
    """Convert a mechanism's name to the form used in telemetry keys.

    >>> telemetry_name("intake_deploy"), telemetry_name("left hood")
    ('IntakeDeploy', 'LeftHood')
    """
    return "".join(word[:1].upper() + word[1:] for word in re.split(r"[^0-9A-Za-z]+", mechanism))


@dataclass(frozen=True, slots=True, kw_only=True)
class ComponentConfig:
    """Part of the robot with its own AdvantageScope model."""

    name: str
    offset: Vector = (0.0, 0.0, 0.0)
    """Origin of the part in the frame after the last joint [m]."""
    joints: tuple[Joint, ...] = ()
    """Joints that move the part, from the robot outward; empty for a fixed part."""

    def __post_init__(self) -> None:
        require_fields(self, f"component {self.name!r}", offset=(ROBOT_PLACE,) * 3)


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotConfig:
    """Config of a robot. Make variants with `dataclasses.replace`.

    Raises:
        ConfigError: If parts of the config contradict each other.
        UnknownNameError: If a part of the robot names an unknown mechanism or storage.
    """

    drivetrain: SwerveConfig | TankConfig | MecanumConfig
    """Motors, wheels and tires of the robot, and mass properties of the whole robot at the start, without pieces."""
    bumper: tuple[float, float] = (0.8, 0.8)
    """Length and width over the bumpers [m]; not used if `chassis` is given."""
    chassis: ChassisConfig | None = None
    """Body of the robot; None for a body derived from `drivetrain` and `bumper`."""
    battery: BatteryConfig = field(default_factory=BatteryConfig)
    gyro: GyroConfig = field(default_factory=lambda: gyro_config("pigeon2"))
    mechanisms: Mapping[str, MechanismConfig] = field(default_factory=dict)
    """Mechanisms by name. The simulation steps and publishes the mechanisms in this order."""
    intakes: tuple[IntakeConfig, ...] = ()
    storage: StorageConfig = field(default_factory=StorageConfig)
    """First storage, for preloads and for intakes, shooters and placers that name no storage."""
    more_storages: tuple[StorageConfig, ...] = ()
    """Other storages; intakes, shooters and placers refer to these storages by name."""
    shooters: tuple[ShooterConfig, ...] = ()
    placers: tuple[PlacerConfig, ...] = ()
    climbers: tuple[ClimberConfig, ...] = ()
    cameras: tuple[CameraConfig, ...] = ()
    """Cameras on the robot; the names of all cameras in a match must be unique."""
    components: tuple[ComponentConfig, ...] = ()
    """Parts with their own AdvantageScope models, in the order of the model files."""
    moving_masses: tuple[MovingMass, ...] = ()
    """Parts of the robot's mass that mechanisms move; the rest of the mass is the body."""
    team: int | None = None
    """Team number on the bumpers; None for the robot's number in the match."""
    models: Path | None = None
    """Folder with an AdvantageScope model of the robot. None for the model of the game or, if the game has no model, a
    model drawn from this config."""

    def __post_init__(self) -> None:
        require_fields(self, bumper=(ROBOT_LENGTH, ROBOT_LENGTH))
        if self.team is not None:
            require("RobotConfig", "team", self.team, Quantity("", 1, 99999, is_whole=True))
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
                    raise ConfigError(f"RobotConfig: wheels of a shooter must be flywheels, but {wheel!r} is not one")
        for owner, parts in (
            ("an intake", self.intakes), ("a placer", self.placers), ("a climber", self.climbers)
        ):  # fmt: skip
            for part in parts:
                require_mechanisms(owner, part.mechanism_names, self.mechanisms)
        storages = [self.storage.name, *(storage.name for storage in self.more_storages)]
        if len(set(storages)) < len(storages) or "" in storages[1:]:
            raise ConfigError(f"RobotConfig: storages need unique names, got {storages}")
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
        """Body of the robot: `chassis` if given, otherwise a body derived from `drivetrain` and `bumper`."""
        return self.chassis or ChassisConfig.around(self.drivetrain, bumper=self.bumper)

    @property
    def whole(self) -> MassDistribution:
        """Mass properties of the whole robot at the start, without pieces."""
        body, (x, y, _) = self.body, self.drivetrain.center_of_mass
        return MassDistribution(body.mass, (x, y, body.center_of_mass_height), body.inertia)

    @property
    def bare_body(self) -> MassDistribution:
        """Mass properties of the robot without pieces and moving masses.

        The subtraction uses the initial positions of the moving masses.
        """
        if not self.moving_masses:
            return self.whole
        start = {name: build_mechanism(mechanism) for name, mechanism in self.mechanisms.items()}
        return with_points(self.whole, [(-mass, place) for mass, place in moved_points(self.moving_masses, start)])


@dataclass(frozen=True, slots=True, kw_only=True)
class BuiltRobot:
    """Properties of a robot as built, which may differ from the nominal properties in the `RobotConfig`."""

    drivetrain: SwerveConfig | tuple[FixedWheelConfig, ...]
    """Config of the drivetrain as built: of the whole swerve drive, of each side (left, right) of a tank drive, or of
    each wheel of a mecanum drive."""
    battery: BatteryConfig
    gyro: GyroConfig
    mechanisms: Mapping[str, MechanismConfig]
    shot_errors: tuple[ShotErrors | None, ...]
    """Errors of each shooter; None for a shooter without errors."""

    @classmethod
    def exactly(cls, config: RobotConfig) -> BuiltRobot:
        """Return the properties of a robot that is built exactly as in the config."""
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
    """Accelerations at which a robot tips, with full storages and the mechanisms in the least stable position."""

    mass: float
    """Mass of the robot with full storages and placers [kg]."""
    height: float
    """Height of the center of mass above the floor [m]."""
    forward: float
    """Smallest acceleration along x, forward or backward, at which wheels lift [m/s^2]."""
    sideways: float
    """Smallest acceleration along y, to the left or right, at which wheels lift [m/s^2]."""
    drivetrain: float
    """Acceleration from rest that the drivetrain reaches with full storages and placers at 12 V [m/s^2]."""


def tipping_limit(config: RobotConfig, kinds: Sequence[GamePieceConfig] = ()) -> TippingLimit:
    """Compute the accelerations at which a robot in the least stable position tips over the outer wheels.

    The robot tips at an acceleration a = g b / h, where h is the height of the center of mass, and b is the horizontal
    distance from the center of mass to the line of the outermost wheels. Each storage and placer is full of the
    heaviest kind of piece that can enter.

    Args:
        config: Config of the robot.
        kinds: Kinds of pieces that the robot may hold; empty for a robot without pieces.
    """
    worst = min(_standings(config, kinds), key=lambda one: min(_limits(config, one)))
    forward, sideways = _limits(config, worst)
    drive = build_drivetrain(config.drivetrain)
    drive.set_mass_properties(worst.mass, worst.inertia[2], worst.center)
    return TippingLimit(worst.mass, worst.center[2], forward, sideways, drive.max_accel)


def _limits(config: RobotConfig, standing: MassDistribution) -> tuple[float, float]:
    """Compute the accelerations along x and along y at which wheels lift [m/s^2]."""
    x, y, height = standing.center
    xs, ys = zip(*config.body.wheel_positions, strict=True)
    per_meter = GRAVITY / max(height, 1e-3)
    along, across = min(max(xs) - x, x - min(xs)), min(max(ys) - y, y - min(ys))
    return per_meter * max(0.0, along), per_meter * max(0.0, across)


def _standings(config: RobotConfig, kinds: Sequence[GamePieceConfig]) -> Iterator[MassDistribution]:
    """Yield the mass properties of the full robot with each mechanism that moves mass at either of two hard stops.

    The generator covers all combinations of stops.
    """
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
    """Return the heaviest kind of piece that intakes can put into a storage.

    Without an intake for the storage, return the heaviest of all kinds. Return None if no kind is possible.
    """
    names = (storage.name, "") if storage is config.storage else (storage.name,)
    users = [intake for intake in config.intakes if intake.storage in names]
    allowed = [] if any(not one.kinds for one in users) else [kind for one in users for kind in one.kinds]
    return _heaviest(kinds, allowed)


def _stored(config: RobotConfig, kinds: Sequence[GamePieceConfig]) -> Iterator[PointMass]:
    """Yield the pieces in full storages as point masses; the pieces are of the kinds from `stored_kind`."""
    for storage in (config.storage, *config.more_storages):
        heaviest = stored_kind(config, storage, kinds)
        if heaviest is not None:
            for number in range(storage.capacity):
                yield heaviest.mass, storage.position(number, heaviest.bounding_radius)


def _heaviest(kinds: Sequence[GamePieceConfig], allowed: Sequence[str]) -> GamePieceConfig | None:
    """Return the heaviest of the allowed kinds, or of all kinds if `allowed` is empty; None if no kind is left."""
    return max((k for k in kinds if not allowed or k.name in allowed), key=lambda kind: kind.mass, default=None)
