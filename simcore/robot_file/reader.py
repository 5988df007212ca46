"""From `simcore.toml` to `RobotSettings`: names, ranges, and that what one table says fits the others."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

from wpimath.system.plant import DCMotor

from simcore.errors import ConfigError
from simcore.robot.dc_motor import MOTOR_NAMES, motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RackConfig, RollerConfig
from simcore.robot_file.robot_settings import (
    CONTROLLERS,
    IntakeSettings,
    MechanismConfig,
    MechanismSettings,
    RobotSettings,
    ShooterSettings,
)
from simcore.robot_file.toml_tables import Table, read_tables
from simcore.vision.camera import (
    LIMELIGHTS,
    CameraConfig,
    CameraMount,
    PiecePipeline,
    TagPipeline,
    limelight_type,
)

__all__ = ["FILE_NAME", "gearbox_motor", "read_settings"]

FILE_NAME = "simcore.toml"

_KINDS = ("flywheel", "roller", "arm", "elevator", "rack")
_CAMERA_MODES = ("tags", "pieces")
_MAX_CAN_ID = 62


def read_settings(path: Path) -> RobotSettings:
    """The robot that a file describes; the defaults where it says nothing, or is not there.

    Raises:
        ConfigError: Something in it cannot work: which file, table and key, what was got and what would work.
    """
    if not path.exists():
        return RobotSettings()
    file = read_tables(path)
    robot = file.table("robot") or Table({}, f"{file.where} [robot]")
    start = file.table("start") or Table({}, f"{file.where} [start]")
    mechanisms = tuple(_mechanism(table) for table in file.tables("mechanism"))
    _require_own_names(file.where, "mechanism", (m.name for m in mechanisms))
    _require_own_devices(file.where, mechanisms)
    intake, shooter = file.table("intake"), file.table("shooter")
    cameras = tuple(_camera(table) for table in file.tables("camera"))
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
        mass=robot.number("mass", d.mass, above=0.0, unit="kg"),
        bumper=bumper,
        center_of_mass_height=robot.number("center_of_mass_height", d.center_of_mass_height, above=0.0, unit="m"),
        tread=robot.number("tread", d.tread, above=0.0),
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
        intake=None if intake is None else _intake(intake, mechanisms),
        shooter=None if shooter is None else _shooter(shooter, mechanisms),
        cameras=cameras,
    )
    for name in ("bumper_length", "bumper_width"):
        robot.number(name, None, above=0.2, unit="m")  # known, also where only one of them is missing
    robot.finish()
    start.finish()
    if settings.preload > settings.capacity:
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


def _intake(t: Table, mechanisms: tuple[MechanismSettings, ...]) -> IntakeSettings:
    intake = IntakeSettings(
        x=(t.number("x_min", unit="m"), t.number("x_max", unit="m")),
        y=(t.number("y_min", unit="m"), t.number("y_max", unit="m")),
        z_max=t.number("z_max", 0.2, above=0.0, unit="m"),
        roller=_named(t, "roller", mechanisms),
        deploy=_named(t, "deploy", mechanisms) if "deploy" in t else t.text("deploy", None),
        out_at=t.choice("out_at", ("upper", "lower"), "upper"),
    )
    for axis, (low, high) in (("x", intake.x), ("y", intake.y)):
        if not low < high:
            raise t.error(f"{axis}_min", f"must be below {axis}_max, got {low} and {high} m")
    if intake.deploy is None:
        if "out_at" in t:
            raise t.error("out_at", "needs a deploy = <mechanism> beside it")
    elif isinstance(next(m for m in mechanisms if m.name == intake.deploy).config, (FlywheelConfig, RollerConfig)):
        raise t.error("deploy", f"must be an arm, elevator or rack, which has stops; got {intake.deploy!r}")
    t.finish()
    return intake


def _shooter(t: Table, mechanisms: tuple[MechanismSettings, ...]) -> ShooterSettings:
    wheels = _named(t, "wheels", mechanisms)
    if not isinstance(next(m for m in mechanisms if m.name == wheels).config, FlywheelConfig):
        raise t.error("wheels", f"must be a mechanism of kind flywheel, got {wheels!r}")
    shooter = ShooterSettings(
        wheels=wheels,
        feeder=_named(t, "feeder", mechanisms) if "feeder" in t else t.text("feeder", None),
        hood=_named(t, "hood", mechanisms) if "hood" in t else t.text("hood", None),
        wheel_radius=t.number("wheel_radius", 0.05, above=0.0, unit="m"),
        exit_efficiency=t.number("exit_efficiency", 0.49, above=0.0),
        height=t.number("height", above=0.0, unit="m"),
        forward=t.number("forward", 0.0, unit="m"),
        yaw=math.radians(t.number("yaw_deg", 0.0, unit="deg")),
        barrels=t.numbers("barrels", (0.0,)),
        rate=t.number("shots_per_second", 8.0, above=0.0, unit="1/s"),
        elevation=math.radians(t.number("elevation_deg", unit="deg")),
        elevation_per_hood=float(t.number("elevation_per_hood", -1.0)),
    )
    if "elevation_per_hood" in t and shooter.hood is None:
        raise t.error("elevation_per_hood", "needs a hood = <mechanism> beside it")
    t.finish()
    return shooter


def _camera(t: Table) -> CameraConfig:
    degrees = {f"{axis}_deg": t.number(f"{axis}_deg", 0.0, unit="deg") for axis in ("roll", "pitch", "yaw")}
    pipeline = TagPipeline() if t.choice("mode", _CAMERA_MODES, _CAMERA_MODES[0]) == "tags" else PiecePipeline()
    name = t.text("name")
    if "/" in name:
        raise t.error("name", f"must be a NetworkTables name without '/', got {name!r}")
    camera = CameraConfig(
        name=name,
        type=limelight_type(t.choice("type", tuple(LIMELIGHTS))),
        mount=CameraMount(
            x=t.number("x", unit="m"), y=t.number("y", unit="m"), z=t.number("z", least=0.0, unit="m"), **degrees
        ),
        pipelines=(pipeline,),
    )
    t.finish()
    return camera


def _named(t: Table, key: str, mechanisms: tuple[MechanismSettings, ...]) -> str:
    """The mechanism that a key names."""
    known = [m.name for m in mechanisms]
    if not known:
        raise t.error(key, "must name a mechanism, but there is no [[mechanism]] in the file")
    return str(t.choice(key, known))


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
