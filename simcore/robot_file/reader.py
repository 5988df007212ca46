"""From `simcore.toml` to `RobotSettings`: names, ranges, and that what one table says fits the others."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path

from wpimath.system.plant import DCMotor

from simcore.errors import ConfigError
from simcore.physics.engine_choice import ENGINES
from simcore.pieces.intake import IntakeConfig, IntakeZone
from simcore.pieces.launch import LaunchParameters
from simcore.pieces.shooter import ShooterConfig
from simcore.robot.dc_motor import MOTOR_NAMES, motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RackConfig, RollerConfig
from simcore.robot.robot_config import MechanismConfig
from simcore.robot_file.camera_table import read_cameras
from simcore.robot_file.robot_settings import CONTROLLERS, MechanismSettings, RobotSettings
from simcore.robot_file.toml_tables import Table, read_tables

__all__ = ["gearbox_motor", "read_settings"]

_KINDS = ("flywheel", "roller", "arm", "turret", "elevator", "rack")
_MAX_CAN_ID = 62


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
    robot = file.table("robot") or Table({}, f"{file.where} [robot]")
    start = file.table("start") or Table({}, f"{file.where} [start]")
    mechanisms = tuple(_mechanism(table) for table in file.tables("mechanism"))
    _require_own_names(file.where, "mechanism", (m.name for m in mechanisms))
    _require_own_devices(file.where, mechanisms)
    by_name = {m.name: m for m in mechanisms}
    intakes = tuple(_intake(table, by_name) for table in file.table_or_tables("intake"))
    shooters = tuple(_shooter(table, by_name) for table in file.table_or_tables("shooter"))
    cameras, headset = read_cameras(file)
    _require_own_names(file.where, "camera", (c.name for c in cameras))
    file.finish()
    d = RobotSettings()
    bumper = None
    if "bumper_length" in robot or "bumper_width" in robot:
        bumper = (
            robot.number("bumper_length", above=0.2, unit="m"),
            robot.number("bumper_width", above=0.2, unit="m"),
        )
    settings = RobotSettings(
        game=game,
        engine=engine,
        mass=robot.number("mass", d.mass, above=0.0, unit="kg"),
        bumper=bumper,
        center_of_mass_height=robot.number("center_of_mass_height", d.center_of_mass_height, above=0.0, unit="m"),
        wheel_cof=robot.number("tread", d.wheel_cof, above=0.0),
        drive_motor=robot.choice("drive_motor", MOTOR_NAMES, None),
        steer_motor=robot.choice("steer_motor", MOTOR_NAMES, None),
        capacity=robot.whole("capacity", d.capacity, most=500),
        preload=start.whole("preload", d.preload, most=500),
        start=(
            start.number("x", d.start[0], unit="m"),
            start.number("y", d.start[1], unit="m"),
            math.radians(start.number("heading_deg", math.degrees(d.start[2]), unit="deg")),
        ),
        mechanisms=mechanisms,
        intakes=intakes,
        shooters=shooters,
        cameras=cameras,
        headset=headset,
    )
    for name in ("bumper_length", "bumper_width"):
        robot.number(name, None, above=0.2, unit="m")  # known, also where only one of them is missing
    robot.finish()
    start.finish()
    if settings.capacity is not None and settings.preload > settings.capacity:
        raise start.error(
            "preload", f"must be at most the robot's capacity, {settings.capacity}; got {settings.preload}"
        )
    return settings


def gearbox_motor(name: str) -> DCMotor:
    """One motor of the drivetrain's table, as mechanisms want it."""
    m = motor(name)
    return DCMotor(m.nominal_voltage, m.stall_torque, m.stall_current, m.free_current, m.free_speed, 1)


def _mechanism(t: Table) -> MechanismSettings:
    name = t.text("name")
    kind = t.choice("kind", _KINDS)
    leader = t.whole("leader", most=_MAX_CAN_ID)
    followers = t.wholes("followers", most=_MAX_CAN_ID)
    opposed = t.wholes("opposed", most=_MAX_CAN_ID)
    for device in opposed:
        if device not in followers:
            raise t.error("opposed", f"must name followers, which are {list(followers)}; got {device}")
    motor_name = t.choice("motor", MOTOR_NAMES, "Kraken X60")
    gearbox = GearboxConfig(
        motor=gearbox_motor(motor_name),
        motors=1 + len(followers),
        gearing=t.number("gearing", above=0.0),
        friction_torque=t.number("friction_torque", 0.0, least=0.0, unit="N m"),
    )
    try:
        config = _config(t, kind, gearbox)
    except ConfigError as error:
        if str(error).startswith(t.where):
            raise
        raise ConfigError(f"{t.where}: {error}") from error
    settings = MechanismSettings(
        name=name,
        config=config,
        motor=motor_name,
        controller=t.choice("controller", CONTROLLERS, CONTROLLERS[0]),
        leader=leader,
        followers=followers,
        opposed=opposed,
        reversed=t.flag("reversed", False),
        cancoder=t.whole("cancoder", None, most=_MAX_CAN_ID),
        cancoder_gearing=t.number("cancoder_gearing", 1.0, above=0.0),
    )
    if "cancoder_gearing" in t and settings.cancoder is None:
        raise t.error("cancoder_gearing", "needs a cancoder = <CAN id> beside it")
    t.finish()
    return settings


def _config(t: Table, kind: str, gearbox: GearboxConfig) -> MechanismConfig:
    if kind == "flywheel":
        return FlywheelConfig(gearbox=gearbox, inertia=t.number("inertia", above=0.0, unit="kg m^2"))
    if kind == "roller":
        return RollerConfig(
            gearbox=gearbox,
            inertia=t.number("inertia", 0.001, above=0.0, unit="kg m^2"),
            radius=t.number("radius", 0.025, above=0.0, unit="m"),
        )
    if kind == "arm":
        low, high = t.number("min_deg", unit="deg"), t.number("max_deg", unit="deg")
        return ArmConfig(
            gearbox=gearbox,
            inertia=t.number("inertia", above=0.0, unit="kg m^2"),
            mass=t.number("mass", 0.0, least=0.0, unit="kg"),
            center_of_mass=t.number("center_of_mass", 0.0, unit="m"),
            min_angle=math.radians(low),
            max_angle=math.radians(high),
            start_angle=math.radians(t.number("start_deg", low, unit="deg")),
        )
    if kind == "turret":
        low, high = t.number("min_deg", unit="deg"), t.number("max_deg", unit="deg")
        return ArmConfig(
            gearbox=gearbox,
            inertia=t.number("inertia", above=0.0, unit="kg m^2"),
            min_angle=math.radians(low),
            max_angle=math.radians(high),
            start_angle=math.radians(t.number("start_deg", min(max(0.0, low), high), unit="deg")),
        )
    if kind == "elevator":
        low = t.number("min_height", 0.0, unit="m")
        return ElevatorConfig(
            gearbox=gearbox,
            carriage_mass=t.number("mass", above=0.0, unit="kg"),
            drum_radius=t.number("drum_radius", above=0.0, unit="m"),
            min_height=low,
            max_height=t.number("max_height", unit="m"),
            start_height=t.number("start_height", low, unit="m"),
        )
    return RackConfig(
        gearbox=gearbox,
        mass=t.number("mass", above=0.0, unit="kg"),
        pinion_radius=t.number("pinion_radius", above=0.0, unit="m"),
        travel=t.number("travel", above=0.0, unit="m"),
        start_extension=t.number("start_extension", 0.0, least=0.0, unit="m"),
    )


def _intake(t: Table, mechanisms: Mapping[str, MechanismSettings]) -> IntakeConfig:
    zone = {key: t.number(key, unit="m") for key in ("x_min", "x_max", "y_min", "y_max")}
    for axis in "xy":
        low, high = zone[f"{axis}_min"], zone[f"{axis}_max"]
        if not low < high:
            raise t.error(f"{axis}_min", f"must be below {axis}_max, got {low} and {high} m")
    intake = IntakeConfig(
        zone=IntakeZone(**zone, z_max=t.number("z_max", 0.2, above=0.0, unit="m")),
        roller=_named(t, "roller", mechanisms),
        deploy=_maybe_named(t, "deploy", mechanisms),
        deployed_at=t.choice("out_at", ("upper", "lower"), "upper"),
        kinds=t.texts("kinds"),
    )
    if intake.deploy is None:
        if "out_at" in t:
            raise t.error("out_at", "needs a deploy = <mechanism> beside it")
    elif isinstance(mechanisms[intake.deploy].config, (FlywheelConfig, RollerConfig)):
        raise t.error("deploy", f"must be an arm, elevator or rack, which has stops; got {intake.deploy!r}")
    t.finish()
    return intake


def _shooter(t: Table, mechanisms: Mapping[str, MechanismSettings]) -> ShooterConfig:
    wheels = _names(t, "wheels", mechanisms)
    for name in wheels:
        if not isinstance(mechanisms[name].config, FlywheelConfig):
            raise t.error("wheels", f"must be a mechanism of kind flywheel, got {name!r}")
    if len(wheels) > 2 or len(set(wheels)) < len(wheels):
        raise t.error("wheels", f"must be one flywheel, or two: [lower, upper]; got {list(wheels)}")
    hood, turret = _maybe_named(t, "hood", mechanisms), _maybe_named(t, "turret", mechanisms)
    shooter = ShooterConfig(
        wheels=wheels,
        gate=_names(t, "feeder", mechanisms) if "feeder" in t else t.texts("feeder"),
        hood=hood,
        elevation=math.radians(t.number("elevation_deg", unit="deg")),
        elevation_per_hood=float(t.number("elevation_per_hood", -1.0)),
        turret=turret,
        turret_ratio=float(t.number("turret_ratio", 1.0)),
        wheel_radius=t.number("wheel_radius", 0.05, above=0.0, unit="m"),
        exit_efficiency=t.number("exit_efficiency", 0.49 if len(wheels) == 1 else 0.98, above=0.0),
        launch=LaunchParameters(
            height=t.number("height", above=0.0, unit="m"),
            forward=t.number("forward", 0.0, unit="m"),
            pivot_x=t.number("turret_x", 0.0, unit="m"),
            pivot_y=t.number("turret_y", 0.0, unit="m"),
            heading=math.radians(t.number("yaw_deg", 0.0, unit="deg")),
            barrels=t.numbers("barrels", (0.0,)),
        ),
        shot_rate=t.number("shots_per_second", 8.0, above=0.0, unit="1/s"),
        kinds=t.texts("kinds"),
    )
    for key, of, needs in (
        ("elevation_per_hood", hood, "hood"), ("turret_ratio", turret, "turret"),
        ("turret_x", turret, "turret"), ("turret_y", turret, "turret"),
    ):  # fmt: skip
        if key in t and of is None:
            raise t.error(key, f"needs a {needs} = <mechanism> beside it")
    t.finish()
    return shooter


def _named(t: Table, key: str, mechanisms: Mapping[str, MechanismSettings]) -> str:
    """The mechanism that a key names."""
    _require_some(t, key, mechanisms)
    return str(t.choice(key, tuple(mechanisms)))


def _maybe_named(t: Table, key: str, mechanisms: Mapping[str, MechanismSettings]) -> str | None:
    """The mechanism that a key names, if it is there."""
    return _named(t, key, mechanisms) if key in t else t.text(key, None)


def _names(t: Table, key: str, mechanisms: Mapping[str, MechanismSettings]) -> tuple[str, ...]:
    """The mechanism or mechanisms that a key names."""
    _require_some(t, key, mechanisms)
    return t.choices(key, tuple(mechanisms))


def _require_some(t: Table, key: str, mechanisms: Mapping[str, MechanismSettings]) -> None:
    if not mechanisms:
        raise t.error(key, "must name a mechanism, but there is no [[mechanism]] in the file")


def _require_own_names(where: str, what: str, names: Iterable[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise ConfigError(f"{where} [[{what}]] {name!r}: name is used twice; give each its own")
        seen.add(name)


def _require_own_devices(where: str, mechanisms: tuple[MechanismSettings, ...]) -> None:
    owners: dict[tuple[str, int], str] = {}
    for m in mechanisms:
        devices = [(m.controller, device) for device in m.devices]
        if m.cancoder is not None:
            devices.append(("CANcoder", m.cancoder))
        for device in devices:
            if device in owners:
                raise ConfigError(
                    f"{where} [[mechanism]] {m.name!r}: {device[0]} {device[1]} already belongs to {owners[device]!r}; "
                    "a device turns one mechanism"
                )
            owners[device] = m.name
