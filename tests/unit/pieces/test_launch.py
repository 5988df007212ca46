"""Where and how fast a piece leaves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.errors import ConfigError
from simcore.pieces.launch import (
    Aim,
    LaunchParameters,
    launch_direction,
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


def test_a_robot_at_rest_shoots_ahead():
    pos, velocity = state()
    assert pos == pytest.approx([2.168, 3.08, 0.55])
    assert velocity == pytest.approx([4.0, 0.0, 8.0 * math.sqrt(0.75)])


def test_yaw_turns_muzzle_and_velocity_to_the_left():
    pos, velocity = state(robot_rotation=yaw_rotation(math.pi / 2), barrel=1)
    assert pos == pytest.approx([2.08, 3.168, 0.55])
    assert velocity == pytest.approx([0.0, 4.0, 8.0 * math.sqrt(0.75)])


def test_turret_and_robot_turn_the_same_way():
    turned_robot = state(robot_rotation=yaw_rotation(0.7))
    turned_turret = state(turret_angle=0.7)
    for a, b in zip(turned_robot, turned_turret, strict=True):
        assert a == pytest.approx(b)


def test_a_spinning_driving_robot_adds_its_muzzle_speed():
    """omega x r: turning left at 2 rad/s, a muzzle 0.168 m ahead and 0.08 m left moves by (-0.16, 0.336)."""
    _, velocity = state(robot_velocity=np.array([1.0, -0.5, 0.0]), robot_spin=np.array([0.0, 0.0, 2.0]))
    assert velocity == pytest.approx([4.0 + 1.0 - 0.16, -0.5 + 0.336, 8.0 * math.sqrt(0.75)])


def test_a_turret_that_turns_against_the_robot_keeps_the_muzzle_where_it_is():
    """Robot and turret at +-2 rad/s about the same axis: the muzzle stands still in the field."""
    _, velocity = state(robot_spin=np.array([0.0, 0.0, 2.0]), turret_rate=-2.0)
    assert velocity == pytest.approx(state()[1])


def test_a_robot_with_its_nose_up_shoots_steeper():
    """Pitch up by 15 degrees is a turn of -15 degrees about +y: 60 degrees of hood become 75."""
    half = math.radians(-7.5)
    _, velocity = state(robot_rotation=np.array([0.0, math.sin(half), 0.0, math.cos(half)]))
    assert velocity == pytest.approx(8.0 * launch_direction(0.0, math.radians(75)))


def test_many_launches_are_the_single_ones():
    """n aims, barrels and poses at once give the rows that each of them gives alone."""
    rng = np.random.default_rng(3)
    quats = rng.normal(size=(6, 4))
    many = dict(
        robot_pos=rng.normal(size=(6, 3)), robot_rotation=quats / np.linalg.norm(quats, axis=1)[:, None],
        robot_velocity=rng.normal(size=(6, 3)), robot_spin=rng.normal(size=(6, 3)), barrel=np.arange(6) % 2,
        **{name: rng.normal(size=6) for name in ("elevation", "turret_angle", "turret_rate")},
    )  # fmt: skip
    pos, velocity = state(**many)
    for row in range(6):
        one_pos, one_velocity = state(**{name: values[row] for name, values in many.items()})
        assert pos[row] == pytest.approx(one_pos) and velocity[row] == pytest.approx(one_velocity)


def test_a_launcher_at_the_back_shoots_backward():
    rear = LaunchParameters(height=0.5, forward=0.2, heading=math.pi, barrels=(0.1,))
    assert muzzle_offset(rear) == pytest.approx([-0.2, -0.1, 0.5])


def test_turret_turns_about_its_pivot():
    turret = LaunchParameters(height=0.5, forward=0.1, pivot_x=-0.2, pivot_y=0.05)
    assert muzzle_offset(turret, turret_angle=math.pi / 2) == pytest.approx([-0.2, 0.15, 0.5])


@pytest.mark.parametrize("change", [{"height": -0.1}, {"forward": math.nan}, {"barrels": ()}, {"barrels": (math.inf,)}])
def test_launchers_that_cannot_be_are_refused(change):
    with pytest.raises(ConfigError, match=next(iter(change))):
        LaunchParameters(**{"height": 0.5, **change})
