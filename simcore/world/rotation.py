"""Rotations: unit quaternions in the order x, y, z, w, as in Bullet and SciPy, and 3 x 3 matrices.

Functions on tuples of floats are for single bodies, because tuples take half the time of small arrays. Functions on
arrays are for many points at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from simcore.typing import FloatArray

__all__ = [
    "IDENTITY",
    "Quaternion",
    "Vector",
    "cross",
    "frame_pose",
    "from_rpy",
    "from_yaw",
    "interpolate",
    "matrix",
    "minus",
    "multiply",
    "outer_pose",
    "rotate",
    "rotate_back",
    "rpy",
    "wrap_angle",
    "yaw_of",
]

Quaternion = tuple[float, float, float, float]
Vector = tuple[float, float, float]

IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)


def from_rpy(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Compute the rotation by roll, then pitch, then yaw about the fixed x, y and z axes [rad], as in `Rotation3d`."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def from_yaw(yaw: float) -> Quaternion:
    """Compute the rotation by a yaw about the z axis, counter-clockwise seen from above [rad]."""
    return (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))


def rpy(q: Sequence[float]) -> Vector:
    """Compute roll, pitch (within +-pi/2) and yaw of a rotation [rad]; inverse of `from_rpy`."""
    x, y, z, w = q
    sin_pitch = max(-1.0, min(1.0, 2.0 * (w * y - z * x)))
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(sin_pitch),
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


def wrap_angle(angle: float) -> float:
    """Return an angle wrapped to -pi..pi [rad]."""
    return math.remainder(angle, math.tau)


def yaw_of(q: Sequence[float]) -> float:
    """Compute the yaw of a rotation: direction of the rotated x axis in plan view [rad]."""
    x, y, z, w = q
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def multiply(a: Sequence[float], b: Sequence[float]) -> Quaternion:
    """Compute the product a b of two rotations, which applies b first and then a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def interpolate(a: Quaternion, b: Quaternion, share: float) -> Quaternion:
    """Interpolate between the rotations a (share 0) and b (share 1) by the normalized weighted mean of the quaternions.

    The error for an angle t between a and b is at most t^3 / 240, for example 2e-6 rad at 0.08 rad.
    """
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    back = 1.0 - share
    there = share if ax * bx + ay * by + az * bz + aw * bw >= 0.0 else -share  # q and -q are the same rotation
    x, y, z, w = back * ax + there * bx, back * ay + there * by, back * az + there * bz, back * aw + there * bw
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    return x / norm, y / norm, z / norm, w / norm


def rotate(q: Sequence[float], v: Sequence[float]) -> Vector:
    """Return a vector rotated by a unit quaternion `q`, for example from robot axes to field axes."""
    qx, qy, qz, qw = q
    vx, vy, vz = v
    tx, ty, tz = 2.0 * (qy * vz - qz * vy), 2.0 * (qz * vx - qx * vz), 2.0 * (qx * vy - qy * vx)
    return (
        vx + qw * tx + qy * tz - qz * ty,
        vy + qw * ty + qz * tx - qx * tz,
        vz + qw * tz + qx * ty - qy * tx,
    )


def rotate_back(q: Sequence[float], v: Sequence[float]) -> Vector:
    """Rotate a vector by the inverse of `q`, for example from field axes to robot axes."""
    qx, qy, qz, qw = q
    return rotate((-qx, -qy, -qz, qw), v)


def frame_pose(
    pos: Sequence[float], quat: Sequence[float], offset: Vector, turn: Quaternion
) -> tuple[Vector, Quaternion]:
    """Compute the pose of an inner frame from the pose `pos`, `quat` of the outer frame.

    `offset` and `turn` are the position and rotation of the inner frame in the outer frame.
    """
    (x, y, z), (a, b, c, d) = pos, quat
    if offset != (0.0, 0.0, 0.0):
        ox, oy, oz = rotate(quat, offset)
        x, y, z = x + ox, y + oy, z + oz
    return (x, y, z), (a, b, c, d) if turn == IDENTITY else multiply(quat, turn)


def outer_pose(pos: Vector, quat: Quaternion, offset: Vector, turn: Quaternion) -> tuple[Vector, Quaternion]:
    """Compute the pose of the outer frame from the pose `pos`, `quat` of the inner frame; inverse of `frame_pose`."""
    if turn != IDENTITY:
        x, y, z, w = turn
        quat = multiply(quat, (-x, -y, -z, w))
    if offset != (0.0, 0.0, 0.0):
        ox, oy, oz = rotate(quat, offset)
        pos = (pos[0] - ox, pos[1] - oy, pos[2] - oz)
    return pos, quat


def matrix(q: Sequence[float] | FloatArray) -> FloatArray:
    """Compute the rotation matrix R of a quaternion, shape (3, 3), or of n quaternions (4, n), shape (3, 3, n).

    `R @ p_robot` rotates one point to field axes, and `points_robot @ R.T` rotates an array of points, one per row.
    """
    parts: Any = q  # four numbers or four arrays
    x, y, z, w = parts
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def minus(a: Vector, b: Vector) -> Vector:
    """Compute the vector a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Compute the cross product a x b."""
    (ax, ay, az), (bx, by, bz) = a, b
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
