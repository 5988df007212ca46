"""`simcore calibrate` in a project uses the drivetrain of the program."""

from pathlib import Path

import pytest

from simcore.calibrate.described import described
from simcore.errors import ConfigError
from simcore.robot.fixed_wheel_config import TankConfig

pytest.importorskip("pyfrc", reason="needs RobotPy: pip install -e .[robotpy]")
ROBOTS = Path(__file__).with_name("robots")


def test_calibrate_takes_the_drivetrain_and_its_sides_from_the_program():
    robot = described(ROBOTS / "tank")
    assert isinstance(robot.drivetrain, TankConfig) and robot.about == "as the program builds it"
    assert robot.devices == {"Spark-0": "left", "Spark-2": "left", "Spark-1": "right", "Spark-3": "right"}


def test_a_program_without_a_drivetrain_has_mechanisms_but_its_drivetrain_raises():
    robot = described(ROBOTS / "sparked")
    assert robot.settings.mechanisms
    with pytest.raises(ConfigError, match="needs only kind, drive_motor, drive_gearing and wheel_diameter"):
        _ = robot.drivetrain


def test_calibrate_assumes_the_kit_chassis_in_a_folder_without_a_robot_program(tmp_path):
    robot = described(tmp_path)
    assert isinstance(robot.drivetrain, TankConfig) and robot.devices == {}
