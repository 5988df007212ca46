"""From `simcore.toml` to `RobotSettings`: names, ranges, and that what one table says fits the others."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from wpimath.system.plant import DCMotor

from simcore.errors import ConfigError
from simcore.match.scatter import Scatter
from simcore.physics.engine_choice import ENGINES
from simcore.quantities import (
    DEGREES,
    FACTOR,
    FIELD_PLACE,
    GEARING,
    INERTIA,
    MASS,
    MASS_OR_NONE,
    ROBOT_HEIGHT,
    ROBOT_LENGTH,
    ROBOT_PLACE,
    TORQUE_OR_NONE,
    VOLTAGE_OR_NONE,
    WHEEL_RADIUS,
    Quantity,
)
from simcore.robot.dc_motor import MOTOR_NAMES, motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanism_friction import default_friction, friction_from_volts
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RackConfig, RollerConfig
from simcore.robot.robot_config import MechanismConfig
from simcore.robot_file.camera_table import read_cameras
from simcore.robot_file.device_tables import POSITIONED_KINDS, positioned_mechanism, read_sensors
from simcore.robot_file.linkage_tables import moving_masses, read_joint, read_moving_mass, require_chains
from simcore.robot_file.manipulator_tables import (
    read_claw,
    read_climber,
    read_component,
    read_intake,
    read_shooter,
    read_storage,
)
from simcore.robot_file.robot_settings import CONTROLLERS, MechanismSettings, RobotSettings
from simcore.robot_file.toml_tables import Table, read_tables
from simcore.units import GRAVITY
from simcore.vision.tag_layout import OFFICIAL_LAYOUTS

__all__ = ["gearbox_motor", "read_settings"]

_KINDS = ("flywheel", "roller", "arm", "turret", "elevator", "rack")
_MASS = Quantity("kg", 20.0, 75.0)  # the 2026 manual allows 115 lb and some 33 lb of bumpers and battery: 67 kg
_BAY = Quantity("m", 0.1, 1.1)
_BUMPER = Quantity("m", 0.4, 1.2)  # the 2026 manual allows a frame of 110 in around, so 0.76 m square, and bumpers
_CENTER_HEIGHT = Quantity("m", 0.0, 1.0, is_open=True)
_MAX_CAN_ID = 62
_USUAL_MOTORS = {"SPARK MAX": "NEO", "SPARK Flex": "NEO Vortex"}


def read_settings(path: Path) -> RobotSettings:
    """The robot that a file describes; the defaults where it says nothing, or is not there.

    Raises:
        ConfigError: Something in it cannot work: which file, table and key, what was got and what would work.
    """
    if not path.exists():
        return RobotSettings()
    file = read_tables(path)
    game = file.text("game", None)
    engine = file.choice("engine", tuple(ENGINES), None)
    tags = file.choice("tags", tuple(OFFICIAL_LAYOUTS), None)
    robot = file.table("robot") or Table({}, f"{file.where} [robot]")
    start = file.table("start") or Table({}, f"{file.where} [start]")
    mechanisms = tuple(_mechanism(table) for table in file.tables("mechanism"))
    _require_own_names(file.where, "mechanism", (m.name for m in mechanisms))
    _require_own_devices(file.where, mechanisms)
    by_name = {m.name: m for m in mechanisms}
    require_chains(file.where, by_name)
    capacity = robot.whole("capacity", None, most=500)
    storages = tuple(read_storage(table, capacity) for table in file.table_or_tables("storage"))
    rooms = [storage.name for storage in storages]
    _require_own_names(file.where, "storage", rooms)
    if "" in rooms[1:] or (len(rooms) > 1 and not rooms[0]):
        raise ConfigError(f"{file.where} [[storage]]: give each of several storages a name")
    intakes = tuple(read_intake(table, by_name, rooms) for table in file.table_or_tables("intake"))
    shooters = tuple(read_shooter(table, by_name, rooms) for table in file.table_or_tables("shooter"))
    claws = tuple(read_claw(table, by_name, rooms) for table in file.table_or_tables("claw"))
    climbers = tuple(read_climber(table, by_name) for table in file.table_or_tables("climber"))
    components = tuple(read_component(table, by_name) for table in file.tables("component"))
    _require_own_names(file.where, "component", (c.name for c in components))
    auto_starts = {name: _auto_start(table) for name, table in file.named_tables("autos").items()}
    cameras, headset = read_cameras(file)
    _require_own_names(file.where, "camera", (c.name for c in cameras))
    sensors = read_sensors(file.tables("sensor"), by_name)
    scatter = _scatter(file.table("scatter"))
    file.finish()
    d = RobotSettings()
    bumper = _both(robot, ("bumper_length", "bumper_width"), _BUMPER)
    settings = RobotSettings(
        game=game,
        engine=engine,
        tags=tags,
        scatter=scatter,
        mass=robot.number("mass", _MASS, d.mass),
        bumper=bumper,
        bay=_both(robot, ("bay_depth", "bay_width"), _BAY),
        center_of_mass_height=robot.number(
            "center_of_mass_height", Quantity("m", 0.0, 1.0, is_open=True), d.center_of_mass_height
        ),
        wheel_cof=robot.number("tread", Quantity("", 0.0, 10.0, is_open=True), d.wheel_cof),
        drive_motor=robot.choice("drive_motor", MOTOR_NAMES, None),
        steer_motor=robot.choice("steer_motor", MOTOR_NAMES, None),
        capacity=capacity,
        preload=start.whole("preload", d.preload, most=500),
        start=(
            start.number("x", FIELD_PLACE, d.start[0]),
            start.number("y", FIELD_PLACE, d.start[1]),
            math.radians(start.number("heading_deg", DEGREES, math.degrees(d.start[2]))),
        ),
        mechanisms=mechanisms,
        intakes=intakes,
        shooters=shooters,
        storages=storages,
        placers=claws,
        climbers=climbers,
        components=components,
        moving_masses=moving_masses(by_name),
        auto_starts=auto_starts,
        cameras=cameras,
        sensors=sensors,
        headset=headset,
    )
    robot.finish()
    start.finish()
    if storages:
        capacity = storages[0].capacity  # preloads are in the first
    if capacity is not None and settings.preload > capacity:
        raise start.error("preload", f"must be at most the robot's capacity, {capacity}; got {settings.preload}")
    return settings


def _scatter(t: Table | None) -> Scatter | None:
    """The default spreads times `scale`, but for those that the table names."""
    if t is None:
        return None
    scale = t.number("scale", FACTOR, 1.0)
    own = {name: t.number(name, FACTOR, None) for name in Scatter.names()}
    t.finish()
    try:
        return replace(Scatter().scaled(scale), **{name: value for name, value in own.items() if value is not None})
    except ConfigError as error:
        raise ConfigError(f"{t.where}: {error}") from error


def _auto_start(t: Table) -> tuple[float, float, float]:
    try:
        start = t.numbers("start", (FIELD_PLACE, FIELD_PLACE, DEGREES))
    except ConfigError as error:
        raise ConfigError(f"{error}; it is [x, y, heading_deg] as a blue robot, e.g. [2.0, 1.2, 0.0]") from error
    t.finish()
    return start[0], start[1], math.radians(start[2])


def gearbox_motor(name: str) -> DCMotor:
    """One motor of the drivetrain's table, as mechanisms want it."""
    m = motor(name)
    return DCMotor(m.nominal_voltage, m.stall_torque, m.stall_current, m.free_current, m.free_speed, 1)


def _mechanism(t: Table) -> MechanismSettings:
    name = t.text("name")
    kind = t.choice("kind", (*_KINDS, *POSITIONED_KINDS))
    if kind in POSITIONED_KINDS:
        return positioned_mechanism(t, name, kind)
    leader = t.whole("leader", most=_MAX_CAN_ID)
    followers = t.wholes("followers", most=_MAX_CAN_ID)
    opposed = t.wholes("opposed", most=_MAX_CAN_ID)
    for device in opposed:
        if device not in followers:
            raise t.error("opposed", f"must name followers, which are {list(followers)}; got {device}")
    controller = t.choice("controller", CONTROLLERS, CONTROLLERS[0])
    motor_name = t.choice("motor", MOTOR_NAMES, _USUAL_MOTORS.get(controller, "Kraken X60"))
    gearbox = GearboxConfig(
        motor=gearbox_motor(motor_name), motors=1 + len(followers), gearing=t.number("gearing", GEARING)
    )
    gearbox = replace(gearbox, friction_torque=_friction(t, kind, gearbox))
    try:
        config = _config(t, kind, gearbox)
    except ConfigError as error:
        if str(error).startswith(t.where):
            raise
        raise ConfigError(f"{t.where}: {error}") from error
    settings = MechanismSettings(
        name=name,
        config=config,
        friction_is_given="friction_torque" in t or "friction_volts" in t,
        motor=motor_name,
        controller=controller,
        coasts=t.flag("coasts", False),
        leader=leader,
        followers=followers,
        opposed=opposed,
        reversed=t.flag("reversed", False),
        cancoder=t.whole("cancoder", None, most=_MAX_CAN_ID),
        cancoder_gearing=t.number("cancoder_gearing", GEARING, 1.0),
        encoder_gearing=t.number("encoder_gearing", GEARING, 1.0),
    )
    is_spark = controller.startswith("SPARK")
    if is_spark and settings.cancoder is not None:
        raise t.error("cancoder", f"is of a TalonFX; a {controller} has encoder_gearing for the encoder wired to it")
    if "encoder_gearing" in t and not is_spark:
        raise t.error("encoder_gearing", f"is of a SPARK MAX or SPARK Flex; the controller is a {controller}")
    if "cancoder_gearing" in t and settings.cancoder is None:
        raise t.error("cancoder_gearing", "needs a cancoder = <CAN id> beside it")
    if "coasts" in t and settings.controller not in ("PWM", "Relay"):
        raise t.error("coasts", f"is of a PWM or relay port; a {settings.controller} has its neutral mode configured")
    joint = read_joint(t, name, kind, config)
    if joint is None:
        t.finish()
        return settings
    on, (mass, center) = t.text("on", None), read_moving_mass(t, joint, config)
    t.finish()
    return replace(settings, joint=joint, on=on, moving_mass=mass, mass_center=center)


def _friction(t: Table, kind: str, gearbox: GearboxConfig) -> float:
    """As the file says, in either unit; else the default of its kind and motor [N m]."""
    torque = t.number("friction_torque", TORQUE_OR_NONE, None)
    volts = t.number("friction_volts", VOLTAGE_OR_NONE, None)
    if torque is not None and volts is not None:
        raise t.error("friction_volts", "says the same as friction_torque; keep one of them")
    if volts is not None:
        return friction_from_volts(gearbox, volts)
    return default_friction(gearbox, has_gears=kind != "flywheel") if torque is None else float(torque)


def _config(t: Table, kind: str, gearbox: GearboxConfig) -> MechanismConfig:
    if kind == "flywheel":
        return FlywheelConfig(gearbox=gearbox, inertia=t.number("inertia", INERTIA))
    if kind == "roller":
        return RollerConfig(
            gearbox=gearbox,
            inertia=t.number("inertia", INERTIA, 0.001),
            radius=t.number("radius", WHEEL_RADIUS, 0.025),
        )
    if kind == "arm":
        low, high = t.number("min_deg", DEGREES), t.number("max_deg", DEGREES)
        return ArmConfig(
            gearbox=gearbox,
            inertia=t.number("inertia", INERTIA),
            mass=t.number("mass", MASS_OR_NONE, 0.0),
            center_of_mass=t.number("center_of_mass", ROBOT_PLACE, 0.0),
            min_angle=math.radians(low),
            max_angle=math.radians(high),
            start_angle=math.radians(t.number("start_deg", DEGREES, low)),
        )
    if kind == "turret":
        low, high = t.number("min_deg", DEGREES), t.number("max_deg", DEGREES)
        return ArmConfig(
            gearbox=gearbox,
            inertia=t.number("inertia", INERTIA),
            min_angle=math.radians(low),
            max_angle=math.radians(high),
            start_angle=math.radians(t.number("start_deg", DEGREES, min(max(0.0, low), high))),
        )
    if kind == "elevator":
        low = t.number("min_height", ROBOT_PLACE, 0.0)
        return ElevatorConfig(
            gearbox=gearbox,
            carriage_mass=t.number("mass", MASS),
            drum_radius=t.number("drum_radius", WHEEL_RADIUS),
            min_height=low,
            max_height=t.number("max_height", ROBOT_PLACE),
            start_height=t.number("start_height", ROBOT_PLACE, low),
            gravity=GRAVITY * math.cos(math.radians(t.number("lean_deg", DEGREES, 0.0))),
        )
    return RackConfig(
        gearbox=gearbox,
        mass=t.number("mass", MASS),
        pinion_radius=t.number("pinion_radius", WHEEL_RADIUS),
        travel=t.number("travel", ROBOT_LENGTH),
        start_extension=t.number("start_extension", ROBOT_HEIGHT, 0.0),
    )


def _require_own_names(where: str, what: str, names: Iterable[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise ConfigError(f"{where} [[{what}]] {name!r}: name is used twice; give each its own")
        seen.add(name)


def _require_own_devices(where: str, mechanisms: tuple[MechanismSettings, ...]) -> None:
    owners: dict[tuple[str, int], str] = {}
    for m in mechanisms:
        devices = m.keys
        if m.cancoder is not None:
            devices.append(("CANcoder", m.cancoder))
        for device in devices:
            if device in owners:
                raise ConfigError(
                    f"{where} [[mechanism]] {m.name!r}: {device[0]} {device[1]} already belongs to {owners[device]!r}; "
                    "a device turns one mechanism"
                )
            owners[device] = m.name


def _both(t: Table, keys: tuple[str, str], quantity: Quantity) -> tuple[float, float] | None:
    """Two lengths that a table has both of, or neither [m]."""
    first, second = (t.number(key, quantity, None) for key in keys)
    if first is not None and second is not None:
        return first, second
    if first is None and second is None:
        return None
    raise t.error(keys[0] if first is None else keys[1], "is missing beside the other; it must be a length in meters")
