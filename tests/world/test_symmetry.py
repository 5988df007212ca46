"""The red side is the blue side, rotated by 180 degrees or mirrored."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError
from simcore.world.symmetry import FieldSymmetry, wrap_angle

SIZE = (16.541, 8.069)
ROTATE, MIRROR = FieldSymmetry("rotate", SIZE), FieldSymmetry("mirror", SIZE)
x_place, y_place, any_angle = st.floats(0.0, SIZE[0]), st.floats(0.0, SIZE[1]), st.floats(-50.0, 50.0)
kinds = st.sampled_from([ROTATE, MIRROR])


@given(kinds, x_place, y_place, any_angle)
def test_a_pose_flipped_twice_returns_to_its_start(symmetry, x, y, yaw):
    bx, by, back = symmetry.flip_pose(*symmetry.flip_pose(x, y, yaw))
    assert (bx, by) == pytest.approx((x, y))
    assert math.remainder(back - yaw, math.tau) == pytest.approx(0.0, abs=1e-9)


@given(kinds, x_place, y_place, any_angle, st.floats(0.1, 2.0))
def test_a_pose_flips_like_the_points_along_its_heading(symmetry, x, y, yaw, ahead):
    fx, fy, turned = symmetry.flip_pose(x, y, yaw)
    tip = symmetry.flip_point(x + ahead * math.cos(yaw), y + ahead * math.sin(yaw))
    assert tip == pytest.approx((fx + ahead * math.cos(turned), fy + ahead * math.sin(turned)), abs=1e-9)


@given(kinds, x_place, y_place, st.floats(-5, 5), st.floats(-5, 5))
def test_a_velocity_flips_like_the_difference_of_two_points(symmetry, x, y, vx, vy):
    a, b = np.array([[x, y, 0.1], [x + vx, y + vy, 0.4]])
    way = symmetry.flip_points(b[None]) - symmetry.flip_points(a[None])
    assert symmetry.flip_vectors((b - a)[None]) == pytest.approx(way, abs=1e-9)


def test_a_rotation_is_about_the_center_and_a_reflection_about_the_center_line():
    assert ROTATE.flip_point(1.0, 2.0) == pytest.approx((SIZE[0] - 1.0, SIZE[1] - 2.0))
    assert MIRROR.flip_point(1.0, 2.0) == pytest.approx((SIZE[0] - 1.0, 2.0))
    assert ROTATE.keeps_hands and not MIRROR.keeps_hands


@given(any_angle)
def test_wrapped_angles_are_within_half_a_turn_and_keep_their_direction(angle):
    wrapped = wrap_angle(angle)
    assert -math.pi <= wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


def test_an_invalid_symmetry_is_refused():
    with pytest.raises(ConfigError, match="kind must be"):
        FieldSymmetry("turn", SIZE)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="size"):
        FieldSymmetry("mirror", (0.0, 8.0))
