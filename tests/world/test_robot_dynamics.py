"""Records of robots in memory that the robots share with the loop."""

import math

import numpy as np
import pytest

from simcore.errors import ConfigError
from simcore.loop.robot_state import SHAFT, records
from simcore.robot.robot import Robot
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.world.robot_dynamics import RecordRows
from simcore.world.world import PhysicsWorld

CONFIG = RobotConfig(drivetrain=SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0)))


def test_robot_records_still_share_memory_with_the_loop_after_a_robot_is_added():
    """The drive of the first robot shares memory with the loop before and after a second robot is added."""
    with PhysicsWorld() as world:
        rng = np.random.default_rng(0)
        first = Robot(world, CONFIG, rng=rng)
        shafts, battery = first.drive.shafts, first.battery.records
        second = Robot(world, CONFIG, rng=rng, number=1, pose=(3.0, 0.0, 0.0))
        fleet = world.robots.fleet
        assert first.drive.shafts is shafts and first.battery.records is battery
        assert np.shares_memory(shafts, fleet.shafts[:8]) and np.shares_memory(battery, fleet.batteries[:1])
        assert np.shares_memory(second.drive.shafts, fleet.shafts[8:16])
        first.drive.set_volts([3.0] * 4, [0.0] * 4)
        assert fleet.shafts["request"]["value"].tolist() == [3.0] * 4 + [0.0] * 12


def test_a_requested_limit_leaves_the_model_unchanged():
    """A request of 20 A holds until the next request; a request beyond the model's limit gives the model's limit."""
    with PhysicsWorld() as world:
        drive = Robot(world, CONFIG, rng=np.random.default_rng(0)).drive
        own = drive.shafts["model"]["stator_limit"].tolist()
        drive.keep_limits([(20.0, 15.0)] * 8)
        assert drive.shafts["request"]["stator_limit"].tolist() == [min(20.0, limit) for limit in own]
        drive.keep_limits([(math.inf, math.inf)] * 8)
        assert drive.shafts["request"]["stator_limit"].tolist() == own == drive.shafts["model"]["stator_limit"].tolist()


def test_records_beyond_the_capacity_are_refused():
    rows = RecordRows("motors", SHAFT, 3)
    rows.take(records(SHAFT, 2))
    with pytest.raises(ConfigError, match="room for 3 motors, its robots have 4"):
        rows.take(records(SHAFT, 2))
