"""Measured figures of a drivetrain in its config and in simcore.toml: free speed, friction and efficiency."""

import math

import pytest

from simcore.errors import ConfigError
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot_file.reader import read_settings
from simcore.testing.benches import DriveBench


def settings(tmp_path, text):
    (tmp_path / "simcore.toml").write_text(text)
    return read_settings(tmp_path / "simcore.toml")


def test_the_free_speed_share_scales_the_speed_without_friction():
    """Without friction v = 6 share kv r / G at 6 V; it is within 0.1 % of this after ten time constants."""
    config = TankConfig(free_speed_share=0.8, friction_volts=0.0)
    bench = DriveBench(TankDrive(config))
    bench.drive.set_volts(6.0, 6.0)
    bench.run(6.0)
    want = 6.0 * 0.8 * config.motor.kv / config.gearing * config.wheel_radius
    assert bench.vx == pytest.approx(want, rel=1e-3)


def test_a_weaker_right_side_turns_the_robot_to_the_right():
    bench = DriveBench(TankDrive(TankConfig(right_efficiency=0.5)))
    bench.drive.set_volts(11.0, 11.0)
    bench.run(0.4)
    assert bench.yaw < -math.radians(0.5)
    left, right = TankConfig(right_efficiency=0.5).sides
    assert (left.efficiency, right.efficiency) == (0.9, 0.5)


def test_the_robot_file_can_hold_the_figures_measured_in_a_log(tmp_path):
    said = settings(
        tmp_path,
        "[robot]\ndrive_friction_volts = 0.4\ndrive_efficiency = 0.8\nright_efficiency = 0.7\nfree_speed_share = 0.95\n"
        "battery_resistance = 0.03\n",
    )
    robot = said.robot_config(TankConfig())
    drive = robot.drivetrain
    assert (drive.friction_volts, drive.efficiency, drive.right_efficiency) == (0.4, 0.8, 0.7)
    assert (drive.free_speed_share, robot.battery.resistance) == (0.95, 0.03)
    with pytest.raises(ConfigError, match="right_efficiency does not apply to a swerve drive"):
        said.require_effect(SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0)))
