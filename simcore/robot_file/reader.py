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
_MASS = Quantity("kg", 20.0, 75.0)  # the 2026 manual allows 115 lb, with about 33 lb of bumpers and battery 67 kg
_BAY = Quantity("m", 0.1, 1.1)
_BUMPER = Quantity("m", 0.4, 1.2)  # the 2026 manual allows a frame perimeter of 110 in, a square of 0.76 m
_FIELD = Quantity("m", 2.0, 100.0)
_COUNT = Quantity("", 0, 500, is_whole=True)

TOP = KeyTable("at the top", "for the whole file", (
    Key("game", str, None, f'left out: the newest; "{NO_GAME}": an empty field, with field_size = [16.0, 8.0]', "name"),
    Key("field_size", (_FIELD, _FIELD), None, f'for game = "{NO_GAME}": length, width; left out: 16 x 8', [16.0, 8.0]),
    Key("engine", tuple(ENGINES), None, "physics engine; left out: bullet where it is installed", "mujoco"),
    Key("match", str, None, "whole match, scripted players (docs/whole_match.md); left out: practice", "practice-2v2"),
    Key("tags", tuple(OFFICIAL_LAYOUTS), None, "AprilTags; left out: the game's", next(iter(OFFICIAL_LAYOUTS))),
))  # fmt: skip
ROBOT = KeyTable("[robot]", "your robot", (
    Key("team", Quantity("", 1, 99_999, is_whole=True), None, "number on the bumpers; left out: the robot's in the "
        "match", 9999),
    Key("models", str, None, "folder next to this file with AdvantageScope's Robot_..., drawn in pages; left out: "
        "what this file describes is drawn", "ascope_assets"),
    Key("mass", _MASS, _D.mass, "with bumpers and battery: weigh it"),
    Key("bumper_length", _BUMPER, None, "over the bumpers, along x; left out: 15 cm beyond the wheels", 0.8,
        needs=("bumper_width", "<m>")),
    Key("bumper_width", _BUMPER, None, "along y", 0.8, needs=("bumper_length", "<m>")),
    Key("bay_depth", _BAY, None, "opening in the back for a climber; left out: none", 0.5,
        needs=("bay_width", "<m>")),
    Key("bay_width", _BAY, None, "", 0.3, needs=("bay_depth", "<m>")),
    Key("center_of_mass_height", Quantity("m", 0.0, 1.0, is_open=True), _D.center_of_mass_height),
    Key("tread", Quantity("", 0.0, 10.0, is_open=True), _D.wheel_cof, "friction of the wheels on carpet, along them: "
        "1.83 new blue nitrile, 1.76 HiGrip (team 1640, tilting table); worn ones less", field="wheel_cof"),
    Key("wheel_grain", Quantity("", 0.0, 2.0, is_open=True), None, "friction across the wheels relative to that "
        "along them: 0.73 and 0.97 in the same test; left out: 1", 1.0),
    Key("drive_friction_volts", VOLTAGE_OR_NONE, None, "kS of the drive motors, as SysId finds it: .32 to .74 V were "
        "measured on swerves, .13 to 1.3 V on tanks; left out: your program's own kS, else 0.22, for a tank 0.65",
        0.22),
    Key("drive_efficiency", EFFICIENCY, None, "of the drive gears; left out: 0.95, for a tank 0.9", 0.95),
    Key("right_efficiency", EFFICIENCY, None, "the same for a tank's right side; left out: as on the left", 0.9),
    Key("free_speed_share", SPEED_SHARE, None, "free speed of the drive relative to its motors' datasheet; left "
        "out: 1, for tanks on NEOs 0.885", 1.0),
    Key("battery_resistance", RESISTANCE, None, "of battery, breaker and cables [ohm]; left out: 0.02", 0.02),
    Key("steer_friction_volts", VOLTAGE_OR_NONE, None, "the same for the steer motors; left out: 0.2", 0.2),
    Key("bumper_friction", FRICTION, None, "0.7 means .49 between two robots, .35 at a wall; .5 for Cordura and "
        ".25 for sailcloth were measured (team 971); left out: 0.7", 0.7),
    Key("drive_motor", MOTOR_NAMES, None, "left out: as the constants say, Kraken X60 with FOC", "Kraken X60"),
    Key("steer_motor", MOTOR_NAMES, None, "", "Kraken X44"),
    Key("real", bool, False, "whether RobotBase.isReal() is true to your program, so that it builds the robot's motors "
        "where it would build simulated ones (IO layers)"),
    Key("serial_number", str, "", "of the roboRIO, if your program identifies the robot by it", "03248A12"),
    Key("capacity", _COUNT, None, "game pieces that a storage holds; left out: that of the game's own robot", 1),
))  # fmt: skip
START = KeyTable("[start]", "as a blue robot; red starts at the corresponding place", (
    Key("x", FIELD_PLACE, _D.start[0]),
    Key("y", FIELD_PLACE, _D.start[1]),
    Key("heading_deg", DEGREES, 0.0, "0 faces the red wall", field="heading"),
    Key("preload", _COUNT, _D.preload, "pieces in the robot"),
))  # fmt: skip
AUTOS = KeyTable('[autos."Left two piece"]', "start of the auto of this name; others use [start]", (
    Key("start", (FIELD_PLACE, FIELD_PLACE, DEGREES), about="x, y, heading_deg as blue", example=[2.0, 1.2, 0.0]),
))  # fmt: skip
SCATTER = KeyTable("[scatter]", "variation from run to run; without this table there is none", (
    Key("scale", FACTOR, 1.0, "factor on the default spreads (docs/scatter.md); or by name, e.g. exit_speed = 0.04"),
    *(Key(name, FACTOR, None) for name in Scatter.names()),
))  # fmt: skip
_TABLES = (
    *("autos", "camera", "claw", "climber", "component", "drivetrain", "intake", "mechanism", "robot", "scatter"),
    *("sensor", "shooter", "start", "storage", *ROLES),
)


def read_settings(path: Path) -> RobotSettings:
    """Return the settings in a `simcore.toml`; missing values have defaults, as have all values if the file is missing.

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
    """Return the absolute path of the folder with the robot's own AdvantageScope model.

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
