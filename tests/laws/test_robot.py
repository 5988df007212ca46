"""True pose, gyro and odometry of a robot on the engine, and a kit-bot drive."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simcore.errors import NonFiniteError
from simcore.match.motion import Motion
from simcore.robot.battery import BatteryConfig
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.gyro import gyro_config
from simcore.robot.robot import Robot
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.testing.benches import LoneChassis
from simcore.world.field import FieldElement
from simcore.world.shapes import Box
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")

DT = 0.02
SWERVE = SwerveConfig.square(0.5334, SwerveModuleConfig(x=0.0, y=0.0, drive_stator_limit=40.0))


def make(world, pose=(0.0, 0.0, 0.0), *, gyro="ideal", seed=0) -> Robot:
    config = RobotConfig(drivetrain=SWERVE, chassis=ChassisConfig(), gyro=gyro_config(gyro))
    return Robot(world, config, pose=pose, rng=np.random.default_rng(seed))


def advance(world, robot, ticks):
    motion = Motion(world, robots=[robot])
    for _ in range(ticks):
        motion.tick()


def test_odometry_follows_an_s_curve_when_no_wheel_slips():
    """A 6 m S-curve at 2 m/s with turning: rolling wheels measure the driven path within 2 %."""
    with PhysicsWorld() as world:
        robot = make(world, (1.0, 2.0, 0.3))
        for tick in range(160):
            phase = tick * DT
            speed = min(2.0, 3.0 * phase)
            robot.drive.set_chassis_speeds(speed, 0.6 * math.sin(2.0 * phase), 0.8 * math.sin(1.5 * phase))
            advance(world, robot, 1)
        x, y, yaw = robot.chassis.pose
        driven = math.dist((x, y), (1.0, 2.0))
        assert driven > 3.0
        assert math.dist(robot.odometry.pose[:2], (x, y)) < 0.02 * 6.0
        assert robot.odometry.pose[2] == pytest.approx(yaw, abs=1e-3)


def test_odometry_tracks_the_robot_origin_where_the_center_of_mass_is_beside_the_origin():
    """After half a turn on the spot, positions about the center of mass would put the origin 2 x 0.1 m away."""
    center = (0.1, 0.0, 0.15)
    config = RobotConfig(
        drivetrain=replace(SWERVE, center_of_mass=center),
        chassis=ChassisConfig(center_of_mass_height=center[2]),
        gyro=gyro_config("ideal"),
    )
    with PhysicsWorld() as world:
        robot = Robot(world, config, pose=(2.0, 2.0, 0.0), rng=np.random.default_rng(0))
        for tick in range(125):
            robot.drive.set_chassis_speeds(0.0, 0.0, min(1.5, 3.0 * tick * DT, max(0.0, 3.0 * (2.3 - tick * DT))))
            advance(world, robot, 1)
        x, y, yaw = robot.chassis.pose
        assert abs(yaw) > 2.5
        assert math.dist(robot.odometry.pose[:2], (x, y)) < 0.03
        assert math.dist((x, y), (2.0, 2.0)) < 0.05


def test_odometry_counts_the_turns_of_spinning_wheels():
    """40 A do not spin a wheel (60 A spin the unloaded front wheels); without a limit all four spin at the start."""
    with PhysicsWorld() as world:
        robot = make(world)
        robot.drive.set_volts([12.0] * 4, [0.0] * 4)
        free = SwerveConfig.square(0.5334, SwerveModuleConfig(x=0.0, y=0.0))
        stiff = BatteryConfig(resistance=0.0)
        config = RobotConfig(drivetrain=free, chassis=ChassisConfig(), gyro=gyro_config("ideal"), battery=stiff)
        skidding = Robot(world, config, pose=(0.0, 5.0, 0.0), rng=np.random.default_rng(0))
        skidding.drive.set_volts([12.0] * 4, [0.0] * 4)
        motion = Motion(world, robots=[robot, skidding])
        for _ in range(25):
            motion.tick()
        assert robot.odometry.pose[0] == pytest.approx(robot.chassis.pose[0], rel=0.05)
        assert skidding.odometry.pose[0] > 1.2 * skidding.chassis.pose[0]


def test_reset_moves_true_pose_gyro_and_odometry_together():
    with PhysicsWorld() as world:
        robot = make(world, gyro="pigeon2")
        robot.drive.set_chassis_speeds(2.0, 0.0, 1.0)
        advance(world, robot, 50)
        robot.reset((3.0, 1.0, 2.0))
        for pose in (robot.chassis.pose, robot.odometry.pose):
            assert pose == pytest.approx((3.0, 1.0, 2.0), abs=1e-6)
        assert robot.gyro.yaw == 2.0
        advance(world, robot, 25)
        assert robot.odometry.pose[:2] == pytest.approx((3.0, 1.0), abs=0.01), "and it stands"
        with pytest.raises(NonFiniteError):
            robot.reset((math.nan, 0.0, 0.0))
        assert robot.odometry.pose[:2] == pytest.approx((3.0, 1.0), abs=0.01)


def test_robot_code_that_resets_its_odometry_does_not_move_the_robot():
    with PhysicsWorld() as world:
        robot = make(world)
        robot.odometry.reset((5.0, 5.0, 1.0), robot.drive.wheel_distances(), robot.gyro.yaw)
        robot.drive.set_chassis_speeds(1.0, 0.0, 0.0)
        advance(world, robot, 50)
        x, y, _ = robot.chassis.pose
        assert y == pytest.approx(0.0, abs=0.01)
        ox, oy, _ = robot.odometry.pose
        assert (ox - 5.0, oy - 5.0) == pytest.approx((x * math.cos(1.0), x * math.sin(1.0)), abs=0.03)


def test_a_kit_bot_drives_straight_and_turns_on_the_spot():
    """Six wheels on two chained sides: straight at equal voltages, turning on the spot at opposite voltages."""
    config = TankConfig()
    wheels = tuple((x, side * config.trackwidth / 2) for side in (1.0, -1.0) for x in config.wheel_xs)
    body = ChassisConfig(wheel_positions=wheels, wheel_radius=config.wheel_radius, clearance=0.04)
    with PhysicsWorld() as world:
        drive = TankDrive(config)
        chassis = ChassisSimulation(world, body, drivetrain=drive)
        drive.set_volts(8.0, 8.0)
        motion = Motion(world, robots=[LoneChassis(chassis)])
        for _ in range(100):
            motion.tick()
        x, y, yaw = chassis.pose
        assert x > 2.0
        assert abs(y) < 0.05
        assert abs(yaw) < 0.05
        assert chassis.vel[0] == pytest.approx(float(np.mean(drive.wheel_speeds())), rel=0.02)
        drive.set_volts(-8.0, 8.0)
        for _ in range(100):
            motion.tick()
        assert chassis.rate[2] > 1.0
        assert math.hypot(*chassis.vel[:2]) < 0.3


# --- robots that are reset, hit a wall or feed the battery ------------------------------------------------------------


@pytest.mark.parametrize("ticks", [10, 100], ids=["speeding up", "pushing a wall"])
def test_a_reset_robot_has_the_wheel_loads_of_a_robot_at_rest(ticks):
    """Wheel loads already agree in the first substep."""
    wall = FieldElement(name="wall", shape=Box((0.5, 4.0, 1.0)), position=np.array([2.0, 0.0, 0.5]))
    with PhysicsWorld() as world:
        world.add_field([wall])
        robot = make(world)
        robot.drive.set_chassis_speeds(3.0, 0.0, 0.0)
        advance(world, robot, ticks)
        assert (robot.chassis.pos[0] > 1.3) == (ticks == 100)
        robot.reset((3.0, 3.0, 0.0))
        fresh = make(world, (6.0, 3.0, 0.0))
        world.advance(0.005)
        assert robot.chassis.normal_loads == pytest.approx(fresh.chassis.normal_loads, abs=0.5)


def test_a_supply_limit_also_holds_while_the_motors_feed_the_battery():
    """Half the voltage at full speed: 6 V times some 100 A would be 50 A at 12 V; the limit is 20 A both ways."""
    module = SwerveModuleConfig(x=0.0, y=0.0, drive_supply_limit=20.0)
    config = RobotConfig(drivetrain=SwerveConfig.square(0.5334, module), gyro=gyro_config("ideal"))
    with PhysicsWorld() as world:
        robot = Robot(world, config, rng=np.random.default_rng(0))
        robot.drive.set_volts([12.0] * 4, [0.0] * 4)
        advance(world, robot, 150)
        robot.drive.set_volts([6.0] * 4, [0.0] * 4)
        least = 0.0
        for _ in range(25):
            advance(world, robot, 1)
            least = min(least, *robot.drive.drive_motors.supply)
        assert -20.0 * 1.02 < least < -10.0
