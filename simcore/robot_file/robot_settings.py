"""Contents of `simcore.toml` in SI units, and the robot and match built from the contents."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
from simcore.match.registry import NO_GAME, practice_field
from simcore.match.scatter import Scatter
from simcore.match.starts import StartError, require_free_place
from simcore.quantities import DeviceAddress, DeviceKey
from simcore.robot.battery import BatteryConfig
from simcore.robot.chassis_config import ChassisConfig, MovingMass
from simcore.robot.climber import ClimberConfig
from simcore.robot.dc_motor import MotorModel
from simcore.robot.fixed_wheel_config import FixedWheelConfig, MecanumConfig, TankConfig
from simcore.robot.gearbox import default_friction, friction_from_volts
from simcore.robot.gyro import gyro_config
from simcore.robot.intake import IntakeConfig
from simcore.robot.mechanisms import FlywheelConfig, PistonConfig, ServoConfig
from simcore.robot.placer import PlacerConfig
from simcore.robot.robot_config import ComponentConfig, MechanismConfig, RobotConfig
from simcore.robot.shooter import ShooterConfig
from simcore.robot.storage import StorageConfig
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot_file.drivetrain_table import DrivetrainSettings
from simcore.robot_file.further_robots import FurtherRobot, add_controllers, players_beside
from simcore.robot_file.sensor_tables import SensorSettings
from simcore.telemetry.snapshot import TelemetrySink
from simcore.vision.camera import CameraConfig
from simcore.vision.limelight import CameraNetwork
from simcore.vision.quest_headset import QuestConfig
from simcore.world.linkage import Joint
from simcore.world.rotation import Vector

DrivetrainConfig: TypeAlias = SwerveConfig | TankConfig | MecanumConfig

__all__ = ["CONTROLLERS", "FILE_NAME", "PORT_CONTROLLERS", "MechanismSettings", "RobotSettings", "practice_match"]

FILE_NAME = "simcore.toml"

CONTROLLERS = ("TalonFX", "TalonFXS", "SPARK MAX", "SPARK Flex", "PWM", "Relay")
"""Valid controllers of a mechanism in the file; `PWM` is any controller on a PWM port, `Relay` a Spike relay."""
PORT_CONTROLLERS = ("PWM", "Relay", "Servo", "Solenoid")
"""Controllers on ports of the roboRIO or a pneumatics module, not on CAN."""


_OF_FIXED_WHEELS = {
    **{"drive_motor": "motor", "drive_gearing": "gearing"},
    **{"drive_stator_limit": "stator_limit", "drive_supply_limit": "supply_limit"},
}
"""Names of fields in tank and mecanum configs, by the key in `MEASURES`, where the names differ."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MechanismSettings:
    """Mechanism with config, devices and joint, as described in a `[[mechanism]]` table."""

    name: str
    config: MechanismConfig
    """Gears, masses and stops; the class of the config determines the kind of the mechanism."""
    guessed: Mapping[str, Any] = field(default_factory=dict)
    """Guessed values by key, for keys that are missing in the file."""
    friction_is_given: bool = True
    """Whether the file gives the friction; if not, a kS in the motor controller replaces the default friction."""
    motor: str
    """Name of the motor, one of `simcore.robot.dc_motor.MOTOR_NAMES`; empty for a servo or a piston."""
    controller: str
    """Controller, one of `CONTROLLERS`; `Servo` for a servo, `Solenoid` for a piston."""
    leader: DeviceAddress
    """CAN id of the leader, or PWM, relay or (forward) solenoid channel."""
    followers: tuple[DeviceAddress, ...] = ()
    """CAN ids or channels of the followers, or the reverse channel of a double solenoid."""
    opposed: tuple[DeviceAddress, ...] = ()
    """Followers that are mounted face to face with the leader."""
    reversed: bool = False
    """Whether the positive direction in robot code is the negative direction of the mechanism."""
    cancoder: DeviceAddress | None = None
    """CAN id of a CANcoder on the mechanism; None without a CANcoder."""
    cancoder_gearing: float = 1.0
    """Turns of the CANcoder per turn of the mechanism [-]."""
    encoder_gearing: float = 1.0
    """Turns of a SPARK's absolute, alternate or external encoder per turn of the mechanism [-]."""
    coasts: bool = False
    """Whether a controller on a PWM or relay port coasts at zero output instead of braking."""
    module: str = ""
    """Type and CAN id of a solenoid's pneumatics module, e.g. `REVPH 1`; empty for other controllers."""
    joint: Joint | None = None
    """Joint that the mechanism moves, in the frame of the carrier; None for a mechanism that cannot carry parts."""
    on: str | None = None
    """Name of the mechanism that carries this mechanism; None for the robot."""
    moving_mass: float | None = None
    """Part of the robot's mass that moves with the mechanism alone [kg]; None for the default in `moving_masses`."""
    mass_center: Vector = (0.0, 0.0, 0.0)
    """Center of the moving mass in the frame after the joint [m]."""

    @property
    def keys(self) -> list[DeviceKey]:
        """Model and address of each controller or port, leader first."""
        model = "PWM" if self.controller == "Servo" else f"{self.module} {self.controller}".strip()
        return [(model, address) for address in self.devices]

    def among(self, built: Collection[DeviceAddress]) -> MechanismSettings:
        """Return a copy with each address replaced by the matching address in `built`; see `DeviceAddress.among`."""
        leader, *followers = (address.among(built) for address in self.devices)
        opposed = tuple(address.among(built) for address in self.opposed)
        return replace(self, leader=leader, followers=tuple(followers), opposed=opposed)

    @property
    def guesses(self) -> str:
        """Guesses as text, e.g. `gearing = 1, inertia = 0.004`; empty if there are no guesses."""
        return ", ".join(f"{key} = {value:.3g}" for key, value in self.guessed.items())

    def with_program(self, gearing: float, inertia: float) -> MechanismSettings:
        """Return a copy with the gearing and inertia of the program's configuration in place of guesses.

        If the file gives no friction, the copy has the default friction for the new gearing.

        Args:
            gearing: Rotor turns per turn of the mechanism [-].
            inertia: Moment of inertia of all turning parts, at the mechanism [kg m^2].
        """
        from_program = {"gearing": gearing, "inertia": inertia}
        from_program = {key: value for key, value in from_program.items() if key in self.guessed}
        if not from_program or isinstance(self.config, (PistonConfig, ServoConfig)):
            return self
        config, gearbox = self.config, self.config.gearbox
        if "gearing" in from_program:
            gearbox = replace(gearbox, gearing=gearing)
            if not self.friction_is_given:
                friction = default_friction(gearbox, has_gears=not isinstance(config, FlywheelConfig))
                gearbox = replace(gearbox, friction_torque=friction)
        own: dict[str, Any] = {"inertia": inertia} if "inertia" in from_program else {}
        return replace(self, config=replace(config, gearbox=gearbox, **own), guessed={**self.guessed, **from_program})

    def with_friction(self, volts: float) -> MechanismSettings:
        """Return a copy with the friction torque for a kS [V], or `self` if the file gives the friction."""
        if self.friction_is_given or isinstance(self.config, (PistonConfig, ServoConfig)):
            return self
        gearbox = self.config.gearbox
        gearbox = replace(gearbox, friction_torque=friction_from_volts(gearbox, volts))
        return replace(self, config=replace(self.config, gearbox=gearbox))

    @property
    def devices(self) -> tuple[DeviceAddress, ...]:
        """Ids or channels of all motor controllers, leader first."""
        return (self.leader, *self.followers)

    @property
    def channels(self) -> tuple[int, ...]:
        """Channel numbers of all devices of the mechanism, leader first."""
        return tuple(address.number for address in self.devices)


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSettings:
    """Contents of the file; the defaults describe a robot without a file."""

    game: str | None = None
    """Name of the game to play, or `none` for an empty field; None if the file has no game."""
    field_size: tuple[float, float] | None = None
    """Length and width of the empty field [m]; None for the size in `Game.bare`."""
    engine: str | None = None
    """Name of the physics engine; None for the engine that `engine_choice` selects."""
    match: str | None = None
    """Whole match to play, in the format of `players_beside`; None for practice, in which every piece counts."""
    tags: str | None = None
    """Name of the AprilTag layout; None for the layout of the game."""
    scatter: Scatter | None = None
    """Variation from run to run; None for no variation."""
    drivetrain: DrivetrainSettings = field(default_factory=DrivetrainSettings)
    given: frozenset[str] = field(default=frozenset(), compare=False)
    """Keys that the file gives, out of `mass` and `tread`; other sources override the default of a missing key."""
    gyro_errors: str = "pigeon2"
    """Error model of the program's gyro, one of `simcore.robot.gyro.GYROS`; not a key of the file."""
    mass: float = 55.0
    """Mass with bumpers and battery [kg]."""
    bumper: tuple[float, float] | None = None
    """Length and width over the bumpers [m]; None for bumpers 15 cm beyond the wheel centers."""
    bay: tuple[float, float] | None = None
    """Depth and width of an opening in the back of bumpers and frame [m]; None for no opening."""
    center_of_mass_height: float = 0.2
    """Height of the center of mass above the floor [m]."""
    team: int | None = None
    """Number on the bumpers; None for the robot's number in the match."""
    models: Path | None = None
    """Folder with the robot's own AdvantageScope model; None if the robot has no model."""
    real: bool = False
    """Whether `RobotBase.isReal()` returns True in the program."""
    serial_number: str = ""
    """Serial number of the roboRIO that the program reads; empty for the value of WPILib's simulation."""
    wheel_cof: float = 1.2
    """Coefficient of friction of the wheels on carpet [-]."""
    wheel_grain: float | None = None
    """Ratio of sideways to forward friction of the wheels [-]; None for the default of the drivetrain model."""
    drive_friction_volts: float | None = None
    """kS of the drive motors [V]; None for the kS in the program, or else the default of the drivetrain model."""
    drive_efficiency: float | None = None
    """Efficiency of the drive gears [-]; None for the default of the drivetrain model."""
    right_efficiency: float | None = None
    """Efficiency of the drive gears on a tank drive's right side [-]; None if equal to `drive_efficiency`."""
    free_speed_share: float | None = None
    """Ratio of actual to datasheet free speed of the drive motors [-]; None for the default of the drivetrain model."""
    battery_resistance: float | None = None
    """Resistance of battery, breaker and cables [ohm]; None for the default of `BatteryConfig`."""
    steer_friction_volts: float | None = None
    """kS of the steer motors [V]; None for the default of the drivetrain model."""
    bumper_friction: float | None = None
    """Friction factor of the bumper fabric [-]; None for the default of `ChassisConfig`."""
    drive_motor: str | None = None
    """Name of the drive motors; None for the motor found in the program."""
    steer_motor: str | None = None
    start: tuple[float, float, float] = (2.0, 1.2, 0.0)
    """Start pose for the blue alliance, field frame [m, m, rad]."""
    preload: int = 0
    """Number of pieces in the robot at the start."""
    capacity: int | None = None
    """Number of pieces that the robot can hold; None for the capacity of the game's own robot."""
    mechanisms: tuple[MechanismSettings, ...] = ()
    intakes: tuple[IntakeConfig, ...] = ()
    storages: tuple[StorageConfig, ...] = ()
    """Storages, the first for preloads; empty for a single storage with `capacity`."""
    shooters: tuple[ShooterConfig, ...] = ()
    placers: tuple[PlacerConfig, ...] = ()
    climbers: tuple[ClimberConfig, ...] = ()
    components: tuple[ComponentConfig, ...] = ()
    moving_masses: tuple[MovingMass, ...] = ()
    auto_starts: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    """Start poses for the blue alliance by name of the auto, field frame [m, m, rad]; other autos use `start`."""
    cameras: tuple[CameraConfig, ...] = ()
    sensors: tuple[SensorSettings, ...] = ()
    headset: QuestConfig | None = None
    """QuestNav headset; None if the robot has no headset."""
    further_robots: tuple[FurtherRobot, ...] = ()
    """Partners and opponents of the team's robot in the file."""

    def with_bumper_around(self, wheels: Sequence[tuple[float, float]]) -> RobotSettings:
        """Return a copy with bumpers 15 cm beyond the given wheel centers [m], unless the file gives the bumpers."""
        if self.bumper is not None:
            return self
        # From a wheel's center to the outside of the bumpers: 2.6 in of module, 3.25 in of bumper.
        around = tuple(2.0 * (max(abs(w[axis]) for w in wheels) + 0.15) for axis in (0, 1))
        return replace(self, bumper=(around[0], around[1]))

    def with_friction(self, volts: Mapping[str, float]) -> RobotSettings:
        """Return a copy whose mechanisms have the friction of the controllers' kS where the file gives no friction.

        Args:
            volts: kS by name of the mechanism [V].
        """
        return replace(
            self, mechanisms=tuple(m.with_friction(volts[m.name]) if m.name in volts else m for m in self.mechanisms)
        )

    def mechanism(self, name: str) -> MechanismSettings:
        """Return the mechanism named `name`, which must exist."""
        return next(m for m in self.mechanisms if m.name == name)

    def require_pieces(self, kinds: Sequence[str]) -> None:
        """Check that intakes, shooters, claws and sensors name only the given kinds of pieces.

        Raises:
            UnknownNameError: A kind is unknown; the message lists the known kinds.
        """
        named = [kind for intake in self.intakes for kind in intake.kinds]
        named += [kind for shooter in self.shooters for kind in shooter.kinds]
        named += [kind for placer in self.placers for kind in placer.kinds]
        named += [kind for sensor in self.sensors if sensor.sees is not None for kind in sensor.sees.kinds]
        for kind in named:
            if kind not in kinds:
                raise UnknownNameError("kind of piece", kind, kinds)

    def require_effect(self, drivetrain: DrivetrainConfig) -> None:
        """Check that the drivetrain model uses every drivetrain value of the file.

        Raises:
            ConfigError: A value does not apply to the drivetrain, or the program's constants override the value.
        """
        own: Any = drivetrain
        kind = type(drivetrain).__name__.removesuffix("Config").lower()
        names: Mapping[str, str] = _OF_FIXED_WHEELS
        if isinstance(drivetrain, SwerveConfig):
            own, names = drivetrain.modules[0], {}
        for key, value in self.drivetrain.measures.items():
            where, said = f"{FILE_NAME} [drivetrain]: {key}", value
            if key == "reversed" and kind != "swerve":
                continue  # reverses the motors, not the model
            field = names.get(key, key)
            if key == "wheel_diameter":
                field, said = "wheel_radius", 0.5 * value
            has = getattr(drivetrain if key == "yaw_inertia" else own, field, None)
            if has is None:
                raise ConfigError(f"{where} does not apply to a {kind} drive")
            if said != (has.name if isinstance(has, MotorModel) else has):
                raise ConfigError(f"{where} = {value} has no effect: the program's own constants say it; change them")
        if kind != "tank" and self.right_efficiency is not None:
            raise ConfigError(f"{FILE_NAME} [robot]: right_efficiency does not apply to a {kind} drive")
        if kind != "swerve" and (self.steer_motor or self.steer_friction_volts is not None):
            key = "steer_motor" if self.steer_motor else "steer_friction_volts"
            raise ConfigError(f"{FILE_NAME} [robot]: {key} does not apply to a {kind} drive")

    def robot_config(
        self, drivetrain: SwerveConfig | TankConfig | MecanumConfig, *, storage: StorageConfig | None = None
    ) -> RobotConfig:
        """Build the config of a robot with the given drivetrain and the mechanisms in the file.

        Args:
            drivetrain: Drivetrain with the robot's mass. If the file has no bumpers, the bumpers are 15 cm beyond the
                wheel centers.
            storage: Storage for a file without `[[storage]]`; a capacity in the file overrides the storage's capacity.
                None for the default storage.
        """
        bumper = self.with_bumper_around(drivetrain.wheel_positions).bumper
        assert bumper is not None
        room = storage or StorageConfig()
        if self.capacity is not None:
            room = replace(room, capacity=self.capacity)
        first, *more = self.storages or (room,)
        drivetrain = self._tuned(drivetrain)
        own: dict[str, Any] = {} if self.bay is None else {"bay": self.bay}
        own |= {} if self.bumper_friction is None else {"bumper_friction": self.bumper_friction}
        resistance = self.battery_resistance
        body = replace(ChassisConfig.around(drivetrain, bumper=bumper), **own) if own else None
        return RobotConfig(
            drivetrain=drivetrain,
            bumper=bumper,
            chassis=body,
            gyro=gyro_config(self.gyro_errors),
            **({} if resistance is None else {"battery": BatteryConfig(resistance=resistance)}),
            mechanisms={m.name: m.config for m in self.mechanisms},
            intakes=self.intakes,
            storage=first,
            more_storages=tuple(more),
            shooters=self.shooters,
            placers=self.placers,
            climbers=self.climbers,
            components=self.components,
            moving_masses=self.moving_masses,
            cameras=self.cameras,
            team=self.team,
            models=self.models,
        )

    def _tuned(self, drivetrain: DrivetrainConfig) -> DrivetrainConfig:
        """Return a copy of a drivetrain with the friction, efficiency and free speed given in the file."""
        names = ("wheel_grain", "drive_friction_volts", "steer_friction_volts", "drive_efficiency", "free_speed_share")
        own: dict[str, Any] = {name: value for name in names if (value := getattr(self, name)) is not None}
        if isinstance(drivetrain, FixedWheelConfig):
            own.pop("steer_friction_volts", None)
            names_here = {"drive_friction_volts": "friction_volts", "drive_efficiency": "efficiency"}
            own = {names_here.get(name, name): value for name, value in own.items()}
            if isinstance(drivetrain, TankConfig) and self.right_efficiency is not None:
                own["right_efficiency"] = self.right_efficiency
            return replace(drivetrain, **own)
        return replace(drivetrain, modules=tuple(replace(m, **own) for m in drivetrain.modules)) if own else drivetrain


def practice_match(
    game: Game,
    settings: RobotSettings,
    drivetrain: SwerveConfig | TankConfig | MecanumConfig,
    *,
    engine: str | None = None,
    whole: str | None = None,
    seed: int = 0,
    scatter: Scatter | None = None,
    vary: Callable[[RobotConfig], RobotConfig] | None = None,
    sinks: Sequence[TelemetrySink] = (),
    network: CameraNetwork | None = None,
) -> Match:
    """Build a match with the team's robot and the partners and opponents in the settings.

    In practice, every scored piece counts. In a whole match, scripted players take part as well, the rules decide which
    pieces count, and the game's match options are on.

    Args:
        game: Game to play.
        settings: Settings of the robot.
        drivetrain: Drivetrain of the robot.
        engine: Name of the physics engine; None for the engine in the settings.
        whole: Whole match to play, in the format of `players_beside`; None for the match in the settings.
        seed: Seed of all random numbers.
        scatter: Variation from run to run; None for the scatter in the settings.
        vary: Function that changes the robot's config; None for no change.
        sinks: Receivers of telemetry.
        network: Network on which the robot's cameras publish and listen; None for no network.

    Raises:
        ConfigError: The robot is invalid or does not fit the game.
        UnknownNameError: The robot names a kind of piece that the game does not have.
    """
    if game.name == NO_GAME and settings.field_size is not None:
        game = practice_field(settings.field_size)
    settings.require_pieces([supply.kind.name for supply in game.pieces])
    config = settings.robot_config(drivetrain, storage=game.robot().storage)
    config = config if vary is None else vary(config)
    most = min(game.preload, config.storage.capacity)
    if settings.preload > most:
        raise ConfigError(f"{FILE_NAME} [start]: preload must be at most {most} in {game.name}, got {settings.preload}")
    whole = whole or settings.match
    further = (*settings.further_robots, *(() if whole is None else players_beside(game, whole)))
    entry = RobotEntry(config=config, start=settings.start, preload=settings.preload)
    try:
        match = Match(
            game,
            robots=(entry, *(one.entry(game) for one in further)),
            seed=seed,
            scatter=settings.scatter if scatter is None else scatter,
            options=[option.name for option in game.options if option.in_matches and whole is not None],
            practice=whole is None,
            sinks=sinks,
            network=network,
            engine=engine or settings.engine,
            tags=settings.tags,
        )
    except StartError as error:
        others = [f"[[{one.role}]] {one.name!r}" for one in further]
        whose = ["[start]", *others][error.number]
        raise _start_refused(whose, error) from error
    try:
        add_controllers(match, further)
        for name, pose in settings.auto_starts.items():
            _require_auto_start(match, name, pose)
    except BaseException:
        match.close()
        raise
    return match


def _require_auto_start(match: Match, name: str, pose: tuple[float, float, float]) -> None:
    robot, size = match.robots[0], match.game.field.size
    try:
        require_free_place(match.world, robot, pose, size, others=match.robots)
    except StartError as error:
        raise _start_refused(f"[autos.{name!r}]", error) from error


def _start_refused(table: str, error: StartError) -> ConfigError:
    return ConfigError(f"{FILE_NAME} {table}: the robot {error.problem}; {error.hint or 'choose another start'}")
