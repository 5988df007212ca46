"""A camera that follows keeps all of a robot in the picture, and stands where nothing solid hides it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from simcore.show.glb import box_glb, opaque_triangles
from simcore.show.view_cameras import BEHIND, CHASE, FOLLOW, FOV
from simcore.show.view_follow import FollowCamera, hidden_share, pull_back, robot_top

from games.reefscape import REEFSCAPE
from games.reefscape.robot import elevator_turns
from simcore import Match
from simcore.show.view_models import Model, load_models
from simcore.telemetry.sinks import MemorySink

CENTER = (8.0, 4.0, 0.0)


def height_in_picture(mode: str, height: float, top: float) -> float:
    """Of a point over the robot's center, from -1 at the lower edge of the picture to 1 at the upper one."""
    eye, look = CHASE[mode]
    ahead = np.array((0.0, 0.0, look)) - eye
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    up = np.cross(right / np.linalg.norm(right), ahead)
    point = np.array((0.0, 0.0, height)) + pull_back(np.array(eye), look, top) - eye
    return float(point @ up / (point @ ahead) / math.tan(0.5 * FOV))


@pytest.mark.parametrize("mode", [FOLLOW, BEHIND])
def test_a_robot_is_in_the_picture_up_to_its_highest_part(mode) -> None:
    """A low robot is looked at as ever; a high one fills 80 % from the middle up, and its wheels stay."""
    assert pull_back(np.array(CHASE[mode][0]), CHASE[mode][1], 0.6) == pytest.approx(np.zeros(3))
    for top in np.linspace(0.5, 3.5, 31):
        assert height_in_picture(mode, top, top) <= 0.8 + 1e-9 and height_in_picture(mode, 0.0, top) >= -0.8 - 1e-9
    assert height_in_picture(mode, 3.0, 3.0) == pytest.approx(0.8)


def test_the_top_of_a_robot_is_that_of_its_elevator() -> None:
    memory = MemorySink()
    with Match(REEFSCAPE, sinks=[memory]) as match:
        robot = match.robots[0]
        tops = []
        for pivot in (0.45, 2.0):
            robot.mechanisms["elevator"].reset(elevator_turns(pivot))
            rows = match.snapshot().pose_arrays["Sim/Robot/ComponentPoses"]
            tops.append(robot_top(load_models(REEFSCAPE.models).robot(), rows))
    assert tops[1] - tops[0] == pytest.approx(2.0 - 0.45, abs=0.3) and 0.8 < tops[0] < 1.8


def test_a_wall_hides_what_is_behind_it() -> None:
    wall = np.array([[(0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 2.0)]])
    places = np.array([(1.0, 0.0, 0.5), (1.0, 5.0, 0.5), (-0.5, 0.0, 0.5), (1.0, 0.0, 3.0)])
    assert hidden_share(wall, np.array((-2.0, 0.0, 0.5)), places) == 0.25
    assert hidden_share(wall[:0], np.array((-2.0, 0.0, 0.5)), places) == 0.0


@pytest.fixture
def wall(tmp_path) -> Model:
    """A wall of 8 x 0.2 x 3 m along x, its middle at (8, 3)."""
    (tmp_path / "model.glb").write_bytes(box_glb((8.0, 0.2, 3.0), 1.5, (90, 90, 90)))
    transform = np.eye(4)
    transform[:2, 3] = 8.0, 3.0
    return Model(tmp_path / "model.glb", transform)


def test_a_camera_stands_on_a_free_side_of_a_wall(wall) -> None:
    """North of the wall the view from the south is nothing; it turns there step by step, and back only if it must."""
    camera = FollowCamera(wall, CENTER)
    far, near = (np.array((8.0, y, 0.0, 1.0, 0.0, 0.0, 0.0)) for y in (0.5, 4.0))
    position, yaw = camera.world_pose(FOLLOW, far, 0.5)
    assert yaw == 0.0 and position == pytest.approx((0.0, 3.5, 0.0)), "the robot is in the middle"
    yaws = [camera.world_pose(FOLLOW, near, 0.5)[1] for _ in range(40)]
    assert 0.0 < max(abs(np.diff([0.0, *yaws]))) < 0.13 and yaws[-1] == yaws[-2]
    c, s = math.cos(yaws[-1]), math.sin(yaws[-1])
    eye = np.array((8.0 - s * 4.0, 4.0 - c * 4.0, 3.0))  # 4 m from the robot, at the camera's place in the field
    assert hidden_share(opaque_triangles(wall, 100), eye, near[None, :3] + (0.0, 0.0, 0.2)) == 0.0
    near[0] += 0.5
    assert camera.world_pose(FOLLOW, near, 0.5)[1] == yaws[-1]
    assert FollowCamera(None, CENTER).world_pose(FOLLOW, near, 0.5)[1] == 0.0
    assert opaque_triangles(wall, 11).shape == (0, 3, 3), "finer than what is looked through"


def test_behind_a_robot_its_front_is_ahead_whatever_stands_there(wall) -> None:
    half = 0.5 * 2.0
    pose = np.array((8.0, 4.0, 0.0, math.cos(half), 0.0, 0.0, math.sin(half)))
    assert FollowCamera(wall, CENTER).world_pose(BEHIND, pose, 0.5)[1] == pytest.approx(-2.0)
