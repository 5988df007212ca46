"""Table `[drivetrain]`: its meaning, and the messages about mistakes."""

import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.quantities import DeviceAddress
from simcore.robot_file.drivetrain_table import read_drivetrain
from simcore.robot_file.key_tables import Table, table_text, tomllib

SWERVE = {
    "kind": "swerve", "controller": "SPARK MAX", "drive": [1, 3, 5, 7], "steer": [2, 4, 6, 8], "encoder": "wired",
    "x": [0.3, 0.3, -0.3, -0.3], "y": [0.3, -0.3, 0.3, -0.3], "zeros_deg": [90.0, 0.0, 180.0, -90.0],
    "gyro": "Pigeon2 9", "wheel_diameter": 0.1,
}  # fmt: skip


def read(data):
    return read_drivetrain(Table(data, "simcore.toml [drivetrain]"))


def test_a_complete_swerve_drive_is_read():
    settings = read(SWERVE)
    assert settings.drive == tuple((DeviceAddress(number),) for number in (1, 3, 5, 7)) and settings.has_devices
    assert settings.places[1] == (0.3, -0.3) and settings.zeros[0] == pytest.approx(1.5708, abs=1e-4)
    assert settings.measures == {"wheel_diameter": 0.1}


def test_the_sides_of_a_tank_drive_are_read():
    settings = read({"kind": "tank", "controller": "PWM", "left": [0, 2], "right": [1, 3]})
    assert settings.drive == tuple(tuple(map(DeviceAddress, side)) for side in ((0, 2), (1, 3)))


def test_a_drivetrain_table_with_only_dimensions_describes_no_devices():
    settings = read({"drive_gearing": 5.9})
    assert not settings.has_devices and settings.measures == {"drive_gearing": 5.9}
    assert read_drivetrain(None).measures == {}


def test_the_written_table_is_read_back_unchanged():
    text = table_text("[drivetrain]", [(key, value, "found") for key, value in SWERVE.items()])
    assert read(tomllib.loads(text)["drivetrain"]) == read(SWERVE)


@each(
    ("changed", "words"),
    [
        ({"kind": "hover"}, "kind must be one of swerve, tank, mecanum"),
        ({"steer": [2, 4]}, "steer must have 4 entries, one for each of drive; got 2"),
        ({"x": [0.3]}, "x and y must name as many places, got 1 and 4"),
        ({"kind": ""}, "kind must"),
        ({"controller": None}, "kind and controller .of the drive motors, e.g. SPARK MAX. belong to its motors"),
        ({"left": [1]}, "left and right must both name motors"),
        ({"drive": None}, "controller needs the motors as well"),
        ({"kind": "mecanum", "drive": [1, 2, 3], "steer": None, "x": None, "y": None, "zeros_deg": None}, "4 motors"),
        ({"wheels": 4}, "no key 'wheels'"),
    ],
)
def test_the_error_names_each_mistake_in_a_drivetrain(changed, words):
    data = {key: value for key, value in {**SWERVE, **changed}.items() if value is not None}
    with pytest.raises(ConfigError, match=words):
        read(data)
