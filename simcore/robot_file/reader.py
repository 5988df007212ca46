"""Reader of `simcore.toml`: converts the file to `RobotSettings` and checks names, ranges and consistency."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from simcore.errors import ConfigError
from simcore.match.registry import NO_GAME
from simcore.match.scatter import Scatter
from simcore.quantities import (
    DEGREES,
    EFFICIENCY,
    FACTOR,
    FIELD_PLACE,
    FRICTION,
    RESISTANCE,
    SPEED_SHARE,
    VOLTAGE_OR_NONE,
    DeviceKey,
    Quantity,
)
from simcore.robot.dc_motor import MOTOR_NAMES
from simcore.robot_file.camera_table import read_cameras
from simcore.robot_file.drivetrain_table import read_drivetrain
from simcore.robot_file.further_robots import ROLES, read_further_robot
from simcore.robot_file.key_tables import Key, KeyTable, Table, read_toml
from simcore.robot_file.manipulator_tables import (
    read_claw,
    read_climber,
    read_component,
    read_intake,
    read_shooter,
    read_storage,
)
from simcore.robot_file.mechanism_tables import moving_masses, read_mechanism, require_chains
from simcore.robot_file.robot_settings import MechanismSettings, RobotSettings
from simcore.robot_file.sensor_tables import read_sensors
from simcore.vision.tag_layout import OFFICIAL_LAYOUTS
from simcore.world.engine_choice import ENGINES

__all__ = ["AUTOS", "ROBOT", "SCATTER", "START", "TOP", "read_settings"]

_D = RobotSettings()
_MASS = Quantity("kg", 20.0, 75.0)  # the 2026 manual allows 115 lb plus bumpers and battery of about 33 lb: 67 kg
_BAY = Quantity("m", 0.1, 1.1)
_BUMPER = Quantity("m", 0.4, 1.2)  # the 2026 manual allows a frame perimeter of 110 in, a square of 0.76 m
_FIELD = Quantity("m", 2.0, 100.0)
_COUNT = Quantity("", 0, 500, is_whole=True)

TOP = KeyTable("at the top", "keys above the first table", (
    Key("game", str, None, f'game to play; "{NO_GAME}" for an empty field; left out: the newest installed game',
        "name"),
    Key("field_size", (_FIELD, _FIELD), None,
        f'length and width of the field for game = "{NO_GAME}" [m]; left out: 16 x 8', [16.0, 8.0]),
    Key("engine", tuple(ENGINES), None, "physics engine; left out: bullet if installed, else mujoco", "mujoco"),
    Key("match", str, None, "whole match with scripted players (docs/whole_match.md); left out: practice",
        "practice-2v2"),
    Key("tags", tuple(OFFICIAL_LAYOUTS), None, "AprilTag layout; left out: that of the game",
        next(iter(OFFICIAL_LAYOUTS))),
))  # fmt: skip
ROBOT = KeyTable("[robot]", "your robot", (
    Key("team", Quantity("", 1, 99_999, is_whole=True), None, "team number on the bumpers; left out: the robot's "
        "number in the match", 9999),
    Key("models", str, None, "folder, relative to this file, with the Robot_... folder of the AdvantageScope model "
        "that pages show; left out: pages show the robot that this file describes", "ascope_assets"),
    Key("mass", _MASS, _D.mass, "mass with bumpers and battery [kg], measured on a scale"),
    Key("bumper_length", _BUMPER, None, "length over the bumpers, along x [m]; left out: 15 cm beyond the wheel "
        "centers", 0.8, needs=("bumper_width", "<m>")),
    Key("bumper_width", _BUMPER, None, "width over the bumpers, along y [m]; left out: 15 cm beyond the wheel centers",
        0.8, needs=("bumper_length", "<m>")),
    Key("bay_depth", _BAY, None, "depth of an opening in the back of bumpers and frame, e.g. for a climber [m]; left "
        "out: no opening", 0.5, needs=("bay_width", "<m>")),
    Key("bay_width", _BAY, None, "width of the opening [m]", 0.3, needs=("bay_depth", "<m>")),
    Key("center_of_mass_height", Quantity("m", 0.0, 1.0, is_open=True), _D.center_of_mass_height, "height of the "
        "center of mass above the floor [m]"),
    Key("tread", Quantity("", 0.0, 10.0, is_open=True), _D.wheel_cof, "coefficient of friction of the wheels on "
        "carpet, in the rolling direction: 1.83 for new blue nitrile, 1.76 for HiGrip (team 1640, tilting table), "
        "less for worn treads", field="wheel_cof"),
    Key("wheel_grain", Quantity("", 0.0, 2.0, is_open=True), None, "ratio of sideways to forward friction of the "
        "wheels: 0.73 for blue nitrile, 0.97 for HiGrip (same test as for tread); left out: 1", 1.0),
    Key("drive_friction_volts", VOLTAGE_OR_NONE, None, "kS of the drive motors, from SysId [V]: 0.32 to 0.74 V "
        "measured on swerve drives, 0.13 to 1.3 V on tank drives; left out: the kS in your program, else 0.22 (tank: "
        "0.65, mecanum: 0.25)", 0.22),
    Key("drive_efficiency", EFFICIENCY, None, "efficiency of the drive gears; left out: 0.95 (tank and mecanum: 0.9)",
        0.95),
    Key("right_efficiency", EFFICIENCY, None, "efficiency of the drive gears on the right side of a tank drive; left "
        "out: drive_efficiency", 0.9),
    Key("free_speed_share", SPEED_SHARE, None, "ratio of actual to datasheet free speed of the drive motors; left "
        "out: 1 (tank or mecanum drive with NEOs: 0.885)", 1.0),
    Key("battery_resistance", RESISTANCE, None, "resistance of battery, breaker and cables [ohm]; left out: 0.02",
        0.02),
    Key("steer_friction_volts", VOLTAGE_OR_NONE, None, "kS of the steer motors [V]; left out: 0.2", 0.2),
    Key("bumper_friction", FRICTION, None, "friction factor of the bumper fabric: 0.7 gives a coefficient of friction "
        "of 0.49 between two robots and 0.35 at a wall; team 971 measured coefficients of 0.5 for Cordura and 0.25 "
        "for sailcloth; left out: 0.7", 0.7),
    Key("drive_motor", MOTOR_NAMES, None, "model of the drive motors; left out: the motor in the program, which is a "
        "Kraken X60 FOC for a TalonFX in CTRE's swerve constants", "Kraken X60"),
    Key("steer_motor", MOTOR_NAMES, None, "model of the steer motors; left out: as for drive_motor", "Kraken X44"),
    Key("real", bool, False, "whether RobotBase.isReal() returns true in your program, for programs that build the "
        "robot's motors only then (IO layers)"),
    Key("serial_number", str, "", "serial number of the roboRIO, for a program that identifies the robot by this "
        "number", "03248A12"),
    Key("capacity", _COUNT, None, "maximum number of pieces in a storage; left out: that of the game's own robot", 1),
))  # fmt: skip
START = KeyTable("[start]", "start pose for the blue alliance; a red robot starts at the corresponding pose", (
    Key("x", FIELD_PLACE, _D.start[0], "x coordinate, field frame [m]"),
    Key("y", FIELD_PLACE, _D.start[1], "y coordinate, field frame [m]"),
    Key("heading_deg", DEGREES, 0.0, "heading [deg]; 0 faces the red alliance wall", field="heading"),
    Key("preload", _COUNT, _D.preload, "number of preloaded pieces"),
))  # fmt: skip
AUTOS = KeyTable('[autos."Left two piece"]', "start pose for the auto of this name; other autos use [start]", (
    Key("start", (FIELD_PLACE, FIELD_PLACE, DEGREES), about="start pose for the blue alliance: x [m], y [m], heading "
        "[deg]", example=[2.0, 1.2, 0.0]),
))  # fmt: skip
SCATTER = KeyTable("[scatter]", "variation from run to run; without this table, runs do not vary", (
    Key("scale", FACTOR, 1.0, "factor on the default spreads (docs/scatter.md); a spread can be set by name, e.g. "
        "exit_speed = 0.04"),
    *(Key(name, FACTOR, None) for name in Scatter.names()),
))  # fmt: skip
_TABLES = (
    *("autos", "camera", "claw", "climber", "component", "drivetrain", "intake", "mechanism", "robot", "scatter"),
    *("sensor", "shooter", "start", "storage", *ROLES),
)


def read_settings(path: Path) -> RobotSettings:
    """Return the settings in a `simcore.toml`, with defaults for missing values or for a missing file.

    Raises:
        ConfigError: The file is not valid TOML, or a value is invalid; the message names file, table and key.
    """
    if not path.exists():
        return RobotSettings()
    file = Table(read_toml(path), path.name)
    file.require_known([*(key.name for key in TOP.keys), *_TABLES])
    top = TOP.read(file)
    if top["field_size"] is not None and top["game"] != NO_GAME:
        raise file.error("field_size", f'is for the empty field: it needs game = "{NO_GAME}" as well')
    robot, start = (file.table(name) or Table({}, f"{file.where} [{name}]") for name in ("robot", "start"))
    body, stand = ROBOT.read(robot), START.read(start)
    mechanisms = tuple(read_mechanism(table) for table in file.tables("mechanism"))
    _require_own_devices(file.where, mechanisms)
    by_name = {m.name: m for m in mechanisms}
    carriers = require_chains(file.where, by_name)
    storages = tuple(
        read_storage(table, body["capacity"], {"mechanism": tuple(by_name)})
        for table in file.table_or_tables("storage")
    )
    rooms = [storage.name for storage in storages]
    if len(rooms) > 1 and "" in rooms:
        raise ConfigError(f"{file.where} [[storage]]: give each of several storages a name")
    bumper = body.pop("bumper_length"), body.pop("bumper_width")
    bay = body.pop("bay_depth"), body.pop("bay_width")
    body["models"] = None if body["models"] is None else _models(robot, path.parent / body["models"])
    cameras, headset = read_cameras(file)
    autos = file.named_tables("autos")
    names = {"mechanism": tuple(by_name), "carrier": carriers, "storage": rooms}
    drivetrain = read_drivetrain(file.table("drivetrain"))
    for key in ("drive_motor", "steer_motor"):
        if key in robot and key in drivetrain.measures:
            raise robot.error(key, "is in [drivetrain] too; keep one of them")
    settings = RobotSettings(
        **top,
        **body,
        bumper=None if None in bumper else bumper,
        bay=None if None in bay else bay,
        drivetrain=drivetrain,
        given=frozenset(key for key in ("mass", "tread") if key in robot),
        scatter=_scatter(file.table("scatter")),
        preload=stand["preload"],
        start=(stand["x"], stand["y"], stand["heading"]),
        mechanisms=mechanisms,
        intakes=tuple(read_intake(table, by_name, names) for table in file.table_or_tables("intake")),
        shooters=tuple(read_shooter(table, by_name, names) for table in file.table_or_tables("shooter")),
        storages=storages,
        placers=tuple(read_claw(table, by_name, names) for table in file.table_or_tables("claw")),
        climbers=tuple(read_climber(table, by_name, names) for table in file.table_or_tables("climber")),
        components=tuple(read_component(table, by_name, names) for table in file.tables("component")),
        moving_masses=moving_masses(by_name),
        auto_starts={name: AUTOS.read(table)["start"] for name, table in autos.items()},
        sensors=read_sensors(file.tables("sensor"), {m.name: m.config for m in mechanisms}),
        further_robots=tuple(
            read_further_robot(table, role, path.parent) for role in ROLES for table in file.tables(role)
        ),
        cameras=cameras,
        headset=headset,
    )
    for table in (robot, start, *autos.values()):
        table.finish()
    capacity = storages[0].capacity if storages else settings.capacity  # preloads are in the first storage
    if capacity is not None and settings.preload > capacity:
        raise start.error("preload", f"must be at most the robot's capacity, {capacity}; got {settings.preload}")
    return settings


def _models(robot: Table, folder: Path) -> Path:
    """Return the absolute path of a folder that contains the AdvantageScope model of the robot.

    Raises:
        ConfigError: The folder contains no `Robot_...` folder.
    """
    if not any(folder.glob("Robot_*")):
        raise robot.error("models", f"must be a folder with a Robot_... in it, but {folder} has none")
    return folder.resolve()


def _scatter(t: Table | None) -> Scatter | None:
    """Return the default spreads times `scale`, with the spreads that the table sets by name; None without a table."""
    if t is None:
        return None
    values = SCATTER.read(t)
    t.finish()
    scale = values.pop("scale")
    try:
        return replace(Scatter().scaled(scale), **{name: one for name, one in values.items() if one is not None})
    except ConfigError as error:
        raise ConfigError(f"{t.where}: {error}") from error


def _require_own_devices(where: str, mechanisms: tuple[MechanismSettings, ...]) -> None:
    owners: dict[DeviceKey, str] = {}
    for m in mechanisms:
        for device in m.keys if m.cancoder is None else [*m.keys, ("CANcoder", m.cancoder)]:
            if device in owners:
                raise ConfigError(
                    f"{where} [[mechanism]] {m.name!r}: {device[0]} {device[1]} already belongs to {owners[device]!r}; "
                    "a device turns one mechanism"
                )
            owners[device] = m.name
