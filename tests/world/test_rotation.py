"""Rotations compared with WPILib's Rotation3d and scipy's Rotation."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from wpimath.geometry import Rotation3d, Translation3d

from simcore.world import rotation as q

angle = st.floats(-math.pi, math.pi)
pitch = st.floats(-math.pi / 2 + 0.01, math.pi / 2 - 0.01)
part = st.floats(-10.0, 10.0)
vector = st.tuples(part, part, part)


@st.composite
def rotation(draw) -> q.Quaternion:
    return q.from_rpy(draw(angle), draw(pitch), draw(angle))


def same_rotation(a, b) -> bool:
    """Return whether two quaternions are the same rotation; a quaternion and its negative are."""
    return abs(abs(float(np.dot(a, b))) - 1.0) < 1e-12


@given(angle, angle, angle)
def test_roll_pitch_and_yaw_agree_with_wpilib(roll, tilt, yaw):
    theirs = Rotation3d(roll, tilt, yaw).getQuaternion()
    assert same_rotation(q.from_rpy(roll, tilt, yaw), (theirs.X(), theirs.Y(), theirs.Z(), theirs.W()))


@given(angle, pitch, angle)
def test_angles_are_unchanged_by_conversion_to_a_quaternion_and_back(roll, tilt, yaw):
    back = q.rpy(q.from_rpy(roll, tilt, yaw))
    for got, want in zip(back, (roll, tilt, yaw), strict=True):
        assert math.remainder(got - want, math.tau) == pytest.approx(0.0, abs=1e-6)


@given(angle)
def test_a_yaw_rotation_has_zero_roll_and_pitch(yaw):
    assert q.from_yaw(yaw) == pytest.approx(q.from_rpy(0.0, 0.0, yaw), abs=1e-15)
    assert math.remainder(q.yaw_of(q.from_yaw(yaw)) - yaw, math.tau) == pytest.approx(0.0, abs=1e-12)


def test_a_vertical_direction_has_a_pitch_of_ninety_degrees_without_a_domain_error():
    """Rounding puts the sine of the pitch above 1, where asin would raise."""
    turn = q.from_rpy(0.0, math.pi / 2, 0.0)
    assert q.rpy([1.0000000001 * c for c in turn])[1] == pytest.approx(math.pi / 2)


@given(rotation(), vector)
def test_a_rotated_vector_agrees_with_wpilib_and_scipy(turn, v):
    got = q.rotate(turn, v)
    assert got == pytest.approx(Rotation.from_quat(turn).apply(v), abs=1e-9)
    theirs = Translation3d(*v).rotateBy(Rotation3d(*q.rpy(turn)))
    assert got == pytest.approx((theirs.x, theirs.y, theirs.z), abs=1e-6)


@given(rotation(), vector)
def test_a_vector_rotated_back_and_forth_is_unchanged(turn, v):
    assert q.rotate_back(turn, q.rotate(turn, v)) == pytest.approx(v, abs=1e-9)
    assert q.rotate(turn, q.rotate_back(turn, v)) == pytest.approx(v, abs=1e-9)


@given(rotation(), vector)
def test_the_matrix_agrees_with_the_quaternion(turn, v):
    m = q.matrix(turn)
    assert m @ v == pytest.approx(q.rotate(turn, v), abs=1e-9)
    assert m @ m.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(m) == pytest.approx(1.0)


@given(rotation(), rotation(), vector)
def test_a_product_is_the_second_rotation_followed_by_the_first(a, b, v):
    assert q.rotate(q.multiply(a, b), v) == pytest.approx(q.rotate(a, q.rotate(b, v)), abs=1e-8)


@given(rotation(), vector, st.floats(0.0, 1.0))
def test_an_interpolated_rotation_turns_by_its_share_of_the_angle(start, axis, share):
    """Interpolation agrees with slerp to within t^3 / 240 for a turn by t."""
    axis = np.array(axis) / max(1.0, float(np.linalg.norm(axis)))  # a turn by at most 1 rad
    a = Rotation.from_quat(start)
    want = a * Rotation.from_rotvec(share * axis)
    got = q.interpolate(start, tuple((a * Rotation.from_rotvec(axis)).as_quat().tolist()), share)
    size = float(np.linalg.norm(axis))
    assert (want.inv() * Rotation.from_quat(got)).magnitude() <= size**3 / 240 + 1e-7
