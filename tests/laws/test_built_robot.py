"""A robot whose build differs from the config and from the constants in its program."""

import math
from dataclasses import replace

import pytest

from simcore.match.match import Match
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.testing.benches import hold

pytestmark = pytest.mark.engines("bullet")

SQUARE = SwerveConfig.square(0.53, SwerveModuleConfig(x=0.0, y=0.0))


def with_modules(**change) -> SwerveConfig:
    return replace(SQUARE, modules=tuple(replace(module, **change) for module in SQUARE.modules))


def test_a_worn_wheel_reports_more_distance_than_the_robot_drives():
    """Rolling at 1 m/s, a wheel of 0.9 of the configured radius turns 1/0.9 as fast: the encoder reports 1/0.9 m/s."""
    worn = SwerveDrive(SQUARE, built=with_modules(wheel_radius=0.9 * SQUARE.wheel_radius))
    worn.reset(vx=1.0)
    assert worn.wheel_speeds() == pytest.approx([1.0 / 0.9] * 4)
    hold(worn, 0.02, (1.0, 0.0, 0.0))
    assert worn.wheel_distances() == pytest.approx([angle * SQUARE.wheel_radius for angle in worn.shaft_angles])
    assert worn.shaft_angles[0] > 0.1


def test_onboard_loops_use_the_configured_feedforward_constants():
    """With motors 20 % stronger than the config, the same command draws less current."""
    strong = [replace(m, drive_motor=m.drive_motor.varied(kt=1.2, resistance=1.0)) for m in SQUARE.modules]
    drives = [SwerveDrive(SQUARE, built=built) for built in (None, replace(SQUARE, modules=tuple(strong)))]
    for drive in drives:
        drive.set_module_states([3.0] * 4, [0.0] * 4)
        hold(drive, 0.02, (3.0, 0.0, 0.0))
    plain, weak = (drive.motor_currents()["drive"][0] for drive in drives)
    assert weak < plain - 5.0, "back-EMF that nobody expected"


def test_steer_offset_errors_turn_the_direction_of_travel_but_not_the_odometry():
    config = RobotConfig(drivetrain=with_modules(steer_offset=0.1))
    with Match.bare(config, start=(4.0, 4.0, 0.0)) as match:
        (robot,) = match.robots
        robot.drive.set_volts([6.0] * 4, [0.0] * 4)
        match.play(0.6)
        x, y, _ = robot.chassis.pose
        assert x > 4.3 and math.atan2(y - 4.0, x - 4.0) == pytest.approx(0.1, abs=0.01)
        assert robot.drive.wheel_angles() == pytest.approx([0.0] * 4, abs=0.01)
        assert robot.odometry.pose[1] == pytest.approx(4.0, abs=0.01)


def test_a_tank_drive_turns_toward_its_weaker_side():
    config = TankConfig()
    turns = []
    for right in (config, replace(config, motor=config.motor.varied(kt=1.0, resistance=1.5))):
        drive = TankDrive(config, built=(config, right))
        drive.set_volts(4.0, 4.0)
        turns.append(hold(drive, 0.02, (0.0, 0.0, 0.0))[2])
    assert turns[0] == pytest.approx(0.0, abs=1e-12) and turns[1] < -1e-3


def test_a_varied_gearbox_scales_torque_back_emf_and_resistance():
    plain = GearboxConfig(motor=motor("Kraken X60"), motors=2, gearing=3.0)
    one = plain.varied(kt=1.1, resistance=1.3)
    assert one.torque_per_amp / plain.torque_per_amp == pytest.approx(1.1)
    assert one.volts_per_speed / plain.volts_per_speed == pytest.approx(1.1)
    assert one.resistance / plain.resistance == pytest.approx(1.3)
    assert one.motor.free_current * one.torque_per_amp == pytest.approx(plain.motor.free_current * plain.torque_per_amp)
    assert plain.varied(kt=1.0, resistance=1.0) is plain
