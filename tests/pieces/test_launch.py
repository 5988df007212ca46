"""Position and velocity of a piece at launch."""

import math

import numpy as np
import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.pieces.launch import (
    Aim,
    LaunchParameters,
    launch_state,
    muzzle_offset,
)

LAUNCH = LaunchParameters(height=0.55, forward=0.168, barrels=(0.08, -0.08))


def yaw_rotation(yaw):
    return np.array([0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)])


def state(
    *, elevation=math.pi / 3, turret_angle=0.0, turret_rate=0.0, barrel=0,
    robot_pos=(2.0, 3.0, 0.0), robot_rotation=(0.0, 0.0, 0.0, 1.0), robot_velocity=(0.0,) * 3, robot_spin=(0.0,) * 3,
):  # fmt: skip
    robot = (robot_pos, robot_rotation, robot_velocity, robot_spin)
    return launch_state(LAUNCH, Aim(elevation, 8.0, turret_angle, turret_rate), robot, barrel)


def test_a_robot_at_rest_shoots_forward():
    pos, velocity = state()
    assert pos == pytest.approx([2.168, 3.08, 0.55])
    assert velocity == pytest.approx([4.0, 0.0, 8.0 * math.sqrt(0.75)])


def test_yaw_turns_the_muzzle_and_the_velocity_to_the_left():
    pos, velocity = state(robot_rotation=yaw_rotation(math.pi / 2), barrel=1)
    assert pos == pytest.approx([2.08, 3.168, 0.55])
    assert velocity == pytest.approx([0.0, 4.0, 8.0 * math.sqrt(0.75)])


def test_a_turret_that_counters_the_robots_rotation_keeps_the_muzzle_at_rest():
    """Robot and turret turn at +-2 rad/s about one axis, so the muzzle is at rest in the field."""
    _, velocity = state(robot_spin=np.array([0.0, 0.0, 2.0]), turret_rate=-2.0)
    assert velocity == pytest.approx(state()[1])


def test_a_launcher_at_the_back_shoots_backward():
    rear = LaunchParameters(height=0.5, forward=0.2, heading=math.pi, barrels=(0.1,))
    assert muzzle_offset(rear) == pytest.approx([-0.2, -0.1, 0.5])


def test_a_turret_turns_the_muzzle_about_its_pivot():
    turret = LaunchParameters(height=0.5, forward=0.1, pivot_x=-0.2, pivot_y=0.05)
    assert muzzle_offset(turret, turret_angle=math.pi / 2) == pytest.approx([-0.2, 0.15, 0.5])


@each("change", [{"height": -0.1}, {"forward": math.nan}, {"barrels": ()}, {"barrels": (math.inf,)}])
def test_invalid_launchers_are_refused(change):
    with pytest.raises(ConfigError, match=next(iter(change))):
        LaunchParameters(**{"height": 0.5, **change})
