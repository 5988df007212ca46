"""From `simcore.toml` to `RobotSettings`: names, ranges, and that what one table says fits the others."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from simcore.errors import ConfigError
from simcore.geometry.symmetry import Pose
from simcore.match.registry import NO_GAME
from simcore.match.scatter import Scatter
from simcore.physics.engine_choice import ENGINES
from simcore.quantities import DEGREES, FACTOR, FIELD_PLACE, FRICTION, VOLTAGE_OR_NONE, DeviceKey, Quantity
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

__all__ = ["AUTOS", "ROBOT", "SCATTER", "START", "TOP", "read_settings"]

_D = RobotSettings()
_MASS = Quantity("kg", 20.0, 75.0)  # the 2026 manual allows 115 lb and some 33 lb of bumpers and battery: 67 kg
_BAY = Quantity("m", 0.1, 1.1)
_BUMPER = Quantity("m", 0.4, 1.2)  # the 2026 manual allows a frame of 110 in around, so 0.76 m square, and bumpers
_FIELD = Quantity("m", 2.0, 100.0)
_COUNT = Quantity("", 0, 500, is_whole=True)

TOP = KeyTable("at the top", "of the whole file", (
    Key("game", str, None, f'left out: the newest; "{NO_GAME}": an empty field, of field_size = [16.0, 8.0]', "name"),
    Key("field_size", (_FIELD, _FIELD), None, f'of game = "{NO_GAME}": length, width; left out: 16 x 8', [16.0, 8.0]),
    Key("engine", tuple(ENGINES), None, "of physics; left out: bullet where it is installed", "mujoco"),
    Key("match", str, None, "whole, with scripted players (docs/whole_match.md); left out: practice", "practice-2v2"),
    Key("tags", tuple(OFFICIAL_LAYOUTS), None, "AprilTags; left out: the game's", next(iter(OFFICIAL_LAYOUTS))),
))  # fmt: skip
ROBOT = KeyTable("[robot]", "your robot", (
    Key("mass", _MASS, _D.mass, "with bumpers and battery: weigh it"),
    Key("bumper_length", _BUMPER, None, "outside of the bumpers, along x; left out: 15 cm beyond the wheels", 0.8),
    Key("bumper_width", _BUMPER, None, "along y", 0.8),
    Key("bay_depth", _BAY, None, "opening in the back for what a climber hangs on; left out: none", 0.5),
    Key("bay_width", _BAY, None, "", 0.3),
    Key("center_of_mass_height", Quantity("m", 0.0, 1.0, is_open=True), _D.center_of_mass_height),
    Key("tread", Quantity("", 0.0, 10.0, is_open=True), _D.wheel_cof, "friction of the wheels on carpet, along them: "
        "1.83 new blue nitrile, 1.76 HiGrip (team 1640, tilting table); worn ones less", field="wheel_cof"),
    Key("wheel_grain", Quantity("", 0.0, 2.0, is_open=True), None, "friction across over that along: 0.73 and 0.97 in "
        "the same test; left out: 1", 1.0),
    Key("drive_friction_volts", VOLTAGE_OR_NONE, None, "kS of the drive motors, as SysId finds it: .32 to .74 V were "
        "measured of swerves; left out: 0.25", 0.25),
    Key("steer_friction_volts", VOLTAGE_OR_NONE, None, "the same of the steer motors; left out: 0.2", 0.2),
    Key("bumper_friction", FRICTION, None, "0.7 means .49 between two robots, .35 at a wall; .5 of Cordura and "
        ".25 of sailcloth were measured (team 971); left out: 0.7", 0.7),
    Key("drive_motor", MOTOR_NAMES, None, "left out: as the constants say, Kraken X60 with FOC", "Kraken X60"),
    Key("steer_motor", MOTOR_NAMES, None, "", "Kraken X44"),
    Key("real", bool, False, "whether RobotBase.isReal() is true to your program, so that it builds the robot's motors "
        "where it would build simulated ones (IO layers)"),
    Key("serial_number", str, "", "of the roboRIO, where your program decides by it which robot it is", "03248A12"),
    Key("capacity", _COUNT, None, "game pieces that a storage holds; left out: as many as the game's own robot", 1),
))  # fmt: skip
START = KeyTable("[start]", "as a blue robot; red starts at the corresponding place", (
    Key("x", FIELD_PLACE, _D.start[0]),
    Key("y", FIELD_PLACE, _D.start[1]),
    Key("heading_deg", DEGREES, 0.0, "0 looks at the red wall", field="heading"),
    Key("preload", _COUNT, _D.preload, "pieces in the robot"),
))  # fmt: skip
AUTOS = KeyTable('[autos."Left two piece"]', "where the auto of this name starts; others at [start]", (
    Key("start", (FIELD_PLACE, FIELD_PLACE, DEGREES), about="x, y, heading_deg as blue", example=[2.0, 1.2, 0.0]),
))  # fmt: skip
SCATTER = KeyTable("[scatter]", "by how much things differ from run to run; without this table they do not", (
    Key("scale", FACTOR, 1.0, "of the default spreads (docs/scatter.md); single ones by name, e.g. exit_speed = 0.04"),
    *(Key(name, FACTOR, None) for name in Scatter.names()),
))  # fmt: skip


def read_settings(path: Path) -> RobotSettings:
    """The robot that a file describes; the defaults where it says nothing, or is not there.

    Raises:
        ConfigError: Something in it cannot work: which file, table and key, what was got and what would work.
    """
    if not path.exists():
        return RobotSettings()
    file = Table(read_toml(path), path.name)
    top = TOP.read(file)
    if top["field_size"] is not None and top["game"] != NO_GAME:
        raise file.error("field_size", f'is of the empty field: it needs game = "{NO_GAME}" beside it')
    robot, start = (file.table(name) or Table({}, f"{file.where} [{name}]") for name in ("robot", "start"))
    body, stand = ROBOT.read(robot), START.read(start)
    mechanisms = tuple(read_mechanism(table) for table in file.tables("mechanism"))
    _require_own_names(file.where, "mechanism", (m.name for m in mechanisms))
    _require_own_devices(file.where, mechanisms)
    by_name = {m.name: m for m in mechanisms}
    carriers = require_chains(file.where, by_name)
    storages = tuple(
        read_storage(table, body["capacity"], {"mechanism": tuple(by_name)})
        for table in file.table_or_tables("storage")
    )
    rooms = [storage.name for storage in storages]
    _require_own_names(file.where, "storage", rooms)
    if "" in rooms[1:] or (len(rooms) > 1 and not rooms[0]):
        raise ConfigError(f"{file.where} [[storage]]: give each of several storages a name")
    for pair in ("bumper", "bay"):
        body[pair] = _both(robot, body, pair)
    cameras, headset = read_cameras(file)
    names = {"mechanism": tuple(by_name), "carrier": carriers, "storage": rooms}
    drivetrain = read_drivetrain(file.table("drivetrain"))
    for key in ("drive_motor", "steer_motor"):
        if key in robot and key in drivetrain.measures:
            raise robot.error(key, "is in [drivetrain] too; keep one of them")
    settings = RobotSettings(
        **top,
        **body,
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
        auto_starts={name: _auto_start(table) for name, table in file.named_tables("autos").items()},
        sensors=read_sensors(file.tables("sensor"), {m.name: m.config for m in mechanisms}),
        further_robots=tuple(
            read_further_robot(table, role, path.parent) for role in ROLES for table in file.tables(role)
        ),
        cameras=cameras,
        headset=headset,
    )
    _require_own_names(file.where, "component", (c.name for c in settings.components))
    _require_own_names(file.where, "camera", (c.name for c in settings.cameras))
    for role in ROLES:
        _require_own_names(file.where, role, (one.name for one in settings.further_robots if one.role == role))
    for table in (robot, start, file):
        table.finish()
    capacity = storages[0].capacity if storages else settings.capacity  # preloads are in the first
    if capacity is not None and settings.preload > capacity:
        raise start.error("preload", f"must be at most the robot's capacity, {capacity}; got {settings.preload}")
    return settings


def _both(t: Table, values: dict[str, float | None], what: str) -> tuple[float, float] | None:
    """Two lengths that a table has both of, or neither [m]."""
    names = [name for name in values if name.startswith(f"{what}_") and name != "bumper_friction"]
    first, second = (values.pop(name) for name in names)
    if first is not None and second is not None:
        return first, second
    if first is None and second is None:
        return None
    missing = names[0] if first is None else names[1]
    raise t.error(missing, "is missing beside the other; it must be a length in meters")


def _scatter(t: Table | None) -> Scatter | None:
    """The default spreads times `scale`, but for those that the table names."""
    if t is None:
        return None
    values = SCATTER.read(t)
    t.finish()
    scale = values.pop("scale")
    try:
        return replace(Scatter().scaled(scale), **{name: one for name, one in values.items() if one is not None})
    except ConfigError as error:
        raise ConfigError(f"{t.where}: {error}") from error


def _auto_start(t: Table) -> Pose:
    try:
        x, y, heading = AUTOS.read(t)["start"]
    except ConfigError as error:
        raise ConfigError(f"{error}; it is [x, y, heading_deg] as a blue robot, e.g. [2.0, 1.2, 0.0]") from error
    t.finish()
    return x, y, math.radians(heading)


def _require_own_names(where: str, what: str, names: Iterable[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise ConfigError(f"{where} [[{what}]] {name!r}: name is used twice; give each its own")
        seen.add(name)


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
