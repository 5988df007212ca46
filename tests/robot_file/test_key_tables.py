"""Keys of simcore.toml: each key changes the settings or is refused by a message with its name."""

import re
from dataclasses import fields, replace
from pathlib import Path

import pytest
from each_case import each

import simcore
from simcore.errors import ConfigError
from simcore.quantities import DeviceAddress, Quantity
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot_file.camera_table import CAMERAS
from simcore.robot_file.drivetrain_table import DRIVETRAIN, MEASURES, DrivetrainSettings
from simcore.robot_file.further_robots import FURTHER_ROBOT, FurtherRobot
from simcore.robot_file.key_tables import Key, Named, Several, Table, toml
from simcore.robot_file.manipulator_tables import CLAW, CLIMBER, COMPONENT, INTAKE, SHOOTER, STORAGE
from simcore.robot_file.mechanism_tables import KINDS, MECHANISM, MOTORS, PLACE
from simcore.robot_file.reader import AUTOS, ROBOT, SCATTER, START, TOP
from simcore.robot_file.robot_settings import MechanismSettings, RobotSettings
from simcore.robot_file.sensor_tables import SENSOR, SENSORS, PieceView, SensorSettings

CORNERS = {"x_min": 0.1, "x_max": 0.2, "y_min": -0.1, "y_max": 0.1, "z_min": 0.1, "z_max": 0.2}
OF_KIND = {
    "flywheel": {"leader": 1, "followers": [2]},
    "roller": {"leader": 3},
    "arm": {"leader": 4},
    "turret": {"leader": 5},
    "elevator": {"leader": 6},
    "rack": {"leader": 7},
    "servo": {"pwm": 1},
    "piston": {"solenoid": [1]},
}
FILE = {
    "mechanism": [{"name": kind, "kind": kind, **more} for kind, more in OF_KIND.items()],
    "storage": [{"name": "front", "capacity": 5, "outlet": "front", "outlet_width": 0.3}],
    "intake": [{**CORNERS, "roller": "roller", "deploy": "arm"}],
    "shooter": [
        {"wheels": "flywheel", "elevation_deg": 60.0, "height": 0.5, "feeder": ["roller"], "hood": "arm",
         "turret": "turret"}
    ],
    "claw": [{"on": "elevator", "roller": "roller", "from_storage": True}],
    "climber": [{"on": "elevator"}],
    "component": [{"name": "part", "on": "elevator"}],
    "partner": [{"name": "friend"}],
    "camera": [
        {"maker": "limelight", "name": "a", "type": "LL4", "x": 0.1, "z": 0.2},
        {"maker": "photonvision", "name": "b", "x": 0.1, "z": 0.2},
        {"maker": "questnav", "x": 0.1, "z": 0.2},
    ],
    "sensor": [
        {"name": "one", "kind": "encoder", "mechanism": "arm", "dio": [0, 1], "pulses_per_turn": 100},
        {"name": "two", "kind": "duty cycle encoder", "mechanism": "arm", "dio": 2},
        {"name": "three", "kind": "analog encoder", "mechanism": "arm", "analog": 0},
        {"name": "four", "kind": "potentiometer", "mechanism": "arm", "analog": 1, "lower_volts": 1.0,
         "upper_volts": 4.0},
        {"name": "five", "kind": "limit switch", "mechanism": "arm", "at": "lower", "dio": 3},
        {"name": "six", "kind": "beam break", "dio": 4},
        {"name": "seven", "kind": "canrange", "id": 9},
    ],
    "drivetrain": {
        **{"kind": "swerve", "controller": "TalonFX", "drive": [11, 12, 13], "steer": [21, 22, 23]},
        **{"x": [0.3, 0.3, -0.3], "y": [0.3, -0.3, 0.0], "encoder": "CANcoder", "encoders": [31, 32, 33]},
    },
    "robot": {"bumper_length": 0.8, "bumper_width": 0.8, "bay_depth": 0.4, "bay_width": 0.3},
    "start": {},
    "scatter": {},
    "autos": {"left": {"start": [1.0, 1.0, 0.0]}},
}  # fmt: skip
"""File with every table and with the keys that other keys need."""


def text(file) -> str:
    """Return a file as TOML text."""
    lines = [f"{key} = {toml(value)}" for key, value in file.items() if not _is_table(value)]
    for key, value in file.items():
        if key == "autos":
            lines += [line for name, auto in value.items() for line in (f"[autos.{name}]", *_rows(auto))]
        elif isinstance(value, dict):
            lines += [f"[{key}]", *_rows(value)]
        elif _is_table(value):
            lines += [line for table in value for line in (f"[[{key}]]", *_rows(table))]
    return "\n".join(lines)


def _is_table(value) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and isinstance(value[0], dict))


def _rows(table) -> list[str]:
    return [f"{key} = {toml(value)}" for key, value in table.items()]


def cases():
    """Yield the path of each table in FILE with each key of the table."""
    for place, table in {
        (): TOP, ("robot",): ROBOT, ("start",): START, ("scatter",): SCATTER, ("drivetrain",): DRIVETRAIN,
        ("autos", "left"): AUTOS, ("storage", 0): STORAGE, ("intake", 0): INTAKE, ("shooter", 0): SHOOTER,
        ("claw", 0): CLAW, ("climber", 0): CLIMBER, ("component", 0): COMPONENT, ("partner", 0): FURTHER_ROBOT,
        **{("camera", k): table for k, table in enumerate(CAMERAS.values())},
    }.items():  # fmt: skip
        yield from ((place, key) for key in table.keys)
    for k, (kind, table) in enumerate(KINDS.items()):
        motors = () if kind in ("servo", "piston") else MOTORS.keys
        carries = PLACE.keys if kind in ("arm", "turret", "elevator", "rack") else ()
        yield from ((("mechanism", k), key) for key in (*MECHANISM.keys, *motors, *table.keys, *carries))
    for k, table in enumerate(SENSORS.values()):
        yield from ((("sensor", k), key) for key in (*SENSOR.keys, *table.keys))


def values(form, now):
    """Return values of a form that differ from the present value."""
    if isinstance(form, Quantity):
        found = [v for v in (0, 1, 2, 3, 9, 21, 60, 0.02, 0.4, 0.5, 0.7, 1.1, 0.03) if form.problem(v) is None]
    elif isinstance(form, Several):
        found = [[one] * n for one in values(form.of, now) for n in (1, 2, 3)]
    elif isinstance(form, Named):
        found = [[name] if form.many else name for name in ("roller", "rack", "elevator", "front")]
    elif form is bool:
        found = [True, False]
    elif form is DeviceAddress:
        found = [9, 21, 60, "canivore:3"]
    elif form is str:
        found = ["other", "rebuilt", "elevator", "practice-2v2", "SPARK MAX", "defender:3", "module:function"]
    elif isinstance(form, list):
        found = [[one] for one in values(form[0], now)]
    elif isinstance(form[0], str):
        found = list(form) if len(form) > 1 else ["other"]
    else:
        found = [[values(one, None)[k] for one in form] for k in (0, 1, 2)]
    return [value for value in found if value != now]


def test_every_key_changes_the_settings_or_is_named_in_an_error(read):
    whole = read(text(FILE))
    tried = list(cases())
    assert len(tried) > 300
    wrong = {f"{'.'.join(map(str, place))}.{key.name}": _objection(read, whole, place, key) for place, key in tried}
    assert {name: said for name, said in wrong.items() if said} == {}


def _objection(read, whole, place, key: Key) -> str:
    """Return an objection if no other value of the key changes the settings or is refused by name, else ''."""
    here = FILE
    for step in place:
        here = here[step]
    said = "not tried"
    for value in values(key.form, here.get(key.name)):
        if isinstance(key.form, Quantity):
            beside = {key.needs[0]: ""} if key.needs else {}
            assert key.read(Table({key.name: value, **beside}, ""), {}) is not None
        try:
            settings = read(text(changed(FILE, place, key.name, value)))
        except ConfigError as error:
            said = str(error)
            if key.name in ("name", "kind", "maker") or re.search(rf"\b{key.name}\b", said):
                return ""
        else:
            if settings != whole:
                return ""
            said = f"{value!r} changes nothing"
    return said


def changed(tree, place, name, value):
    """Return a copy of a file with another value of one key."""
    if not place:
        return {**tree, name: value}
    first, *rest = place
    if isinstance(tree, list):
        return [changed(one, rest, name, value) if k == first else one for k, one in enumerate(tree)]
    return {**tree, first: changed(tree[first], rest, name, value)}


@each("kind", [RobotSettings, MechanismSettings, DrivetrainSettings, SensorSettings, PieceView, FurtherRobot])
def test_every_setting_is_read_by_the_code(kind):
    """Each field of the settings is read somewhere in the code."""
    package = Path(simcore.__file__).parent
    code = "\n".join(path.read_text(encoding="utf-8") for path in sorted(package.rglob("*.py")))
    unread = [field.name for field in fields(kind) if not re.search(rf"\.{field.name}\b|asdict\(", code)]
    assert not unread


CORRECTIONS = ("x", "y", "zeros_deg", "reversed_drive", "reversed_steer", "reversed_encoders", "wheel_distances")
"""Keys that correct what the search of the program found about the wheels."""


@each("key", [key for key in DRIVETRAIN.keys if key not in MEASURES])
def test_keys_for_described_motors_are_refused_for_a_drivetrain_found_in_the_program(read, key):
    value = values(key.form, None)[0]
    if key.name == "kind" or key.name.startswith("gyro"):
        assert getattr(read(f"[drivetrain]\n{key.name} = {toml(value)}").drivetrain, key.name) == value
        return
    if key.name in CORRECTIONS:
        other = {"x": "y", "y": "x"}.get(key.name, "")
        beside = f"{other} = {toml(value)}\n" if other else ""
        said = read(f"[drivetrain]\n{key.name} = {toml(value)}\n{beside}").drivetrain
        assert said.corrections and not said.has_devices
        return
    whole = {"left": "left and right must both", "right": "left and right must both", "drive": "kind and controller"}
    with pytest.raises(ConfigError, match=whole.get(key.name, f"{key.name} needs the motors as well")):
        read(f"[drivetrain]\n{key.name} = {toml(value)}")


SWERVE = SwerveConfig(modules=tuple(SwerveModuleConfig(x=x, y=y) for x, y in ((0.3, 0.3), (0.3, -0.3), (-0.3, 0.0))))


@each("key", MEASURES)
def test_a_dimension_that_the_model_does_not_have_is_refused(read, key):
    """CTRE's drivetrains set the dimension by their constants; drives of another kind do not have it."""
    value = {"coupling_ratio": 0.7, "dropped_center": False}.get(key.name, key.example)
    value = 1.01 * value if isinstance(value, float) else "Bag" if isinstance(value, str) else value
    settings = read(f"[drivetrain]\n{key.name} = {toml(value)}\n")
    for config in (SWERVE, *(() if key.name == "reversed" else (TankConfig(), MecanumConfig()))):
        with pytest.raises(
            ConfigError, match=rf"\[drivetrain\]: {key.name} (does not apply to a \w+ drive|= .* has no effect)"
        ):
            settings.require_effect(config)


def test_matching_dimensions_are_accepted_and_inapplicable_ones_are_refused(read):
    text = "[drivetrain]\ndrive_gearing = 5.0\nwheel_diameter = 0.1\ndrive_motor = 'NEO'\nyaw_inertia = 4.0\n"
    module = replace(SWERVE.modules[0], drive_gearing=5.0, wheel_radius=0.05, drive_motor=motor("NEO"))
    read(text).require_effect(replace(SWERVE, modules=(module,) * 3, yaw_inertia=4.0))
    tank = TankConfig(gearing=5.0, wheel_radius=0.05, motor=motor("NEO"), yaw_inertia=4.0)
    read(text).require_effect(tank)
    for key in ("steer_motor = 'NEO'", "steer_friction_volts = 0.2"):
        with pytest.raises(ConfigError, match=rf"\[robot\]: {key.split()[0]} does not apply to a tank drive"):
            read(f"[robot]\n{key}").require_effect(tank)
    with pytest.raises(ConfigError, match=r"\[robot\]: drive_motor is in \[drivetrain\] too"):
        read(text + "[robot]\ndrive_motor = 'NEO'")
