"""Red is blue turned by 180 degrees."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.geometry.symmetry import turn_half, turn_half_point, turn_half_pose, wrap_angle

SIZE = (16.541, 8.069)
x_place, y_place, any_angle = st.floats(0.0, SIZE[0]), st.floats(0.0, SIZE[1]), st.floats(-50.0, 50.0)


@given(x_place, y_place, any_angle)
def test_turning_twice_returns_the_start(x, y, yaw):
    bx, by, back = turn_half_pose(*turn_half_pose(x, y, yaw, SIZE), SIZE)
    assert (bx, by) == pytest.approx((x, y))
    assert math.remainder(back - yaw, math.tau) == pytest.approx(0.0, abs=1e-9)


@given(x_place, y_place)
def test_a_place_and_its_turned_one_have_the_middle_between_them(x, y):
    tx, ty = turn_half_point(x, y, SIZE)
    assert ((x + tx) / 2, (y + ty) / 2) == pytest.approx((SIZE[0] / 2, SIZE[1] / 2))


def test_rows_turn_like_points_and_keep_their_height_and_the_original():
    points = np.array([[1.0, 2.0, 0.3], [5.0, 8.0, 1.0]])
    turned = turn_half(points, SIZE)
    for before, after in zip(points, turned, strict=True):
        assert tuple(after[:2]) == pytest.approx(turn_half_point(before[0], before[1], SIZE))
        assert after[2] == before[2]
    assert points[0].tolist() == [1.0, 2.0, 0.3]


def test_a_robot_that_faces_the_red_wall_faces_the_blue_one_after():
    assert turn_half_pose(2.0, 3.0, 0.0, SIZE)[2] == pytest.approx(math.pi)


@given(any_angle)
def test_wrapped_angles_are_the_same_direction_within_half_a_turn(angle):
    wrapped = wrap_angle(angle)
    assert -math.pi <= wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)
