"""The pinhole camera: from places on the field to pixels and back to angles.

A camera's own axes are WPILib's (x out of the lens, y left, z up); a picture's are u to the right and v down. Between
them stands the optical frame (x right, y down, z out of the lens), in which the mathematics is shortest.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.quaternion import Quaternion, Vector, multiply, rotate
from simcore.typing import FloatArray
from simcore.vision.camera import LimelightType

__all__ = ["OPTICAL", "angles_deg", "camera_pose", "optical_rotation", "optical_rows", "project", "quad_area"]

OPTICAL: FloatArray = np.array([(0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)])
"""Turns camera axes (x ahead, y left, z up) into optical ones (x right, y down, z ahead)."""


def camera_pose(
    robot_pos: Vector, robot_quat: Quaternion, mount_pos: Vector, mount_quat: Quaternion
) -> tuple[Vector, Quaternion]:
    """Place [m] and attitude of a camera in the field frame."""
    dx, dy, dz = rotate(robot_quat, mount_pos)
    pos = (robot_pos[0] + dx, robot_pos[1] + dy, robot_pos[2] + dz)
    return pos, multiply(robot_quat, mount_quat)


def optical_rotation(quat: Quaternion) -> FloatArray:
    """Rotation R from field to optical axes, shape (3, 3): `p_optical = R @ (p_field - camera)`."""
    return np.array(optical_rows(quat))


def optical_rows(quat: Quaternion) -> tuple[Vector, Vector, Vector]:
    """The same in plain floats, row by row: 2 us instead of 10."""
    x, y, z, w = quat
    right = (2.0 * (w * z - x * y), 2.0 * (x * x + z * z) - 1.0, -2.0 * (y * z + w * x))
    down = (-2.0 * (x * z + w * y), 2.0 * (w * x - y * z), 2.0 * (x * x + y * y) - 1.0)
    ahead = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y))
    return right, down, ahead


def project(
    points: FloatArray, pos: Vector, rotation: FloatArray, lens: LimelightType
) -> tuple[FloatArray, FloatArray]:
    """Pixels of points in the field.

    Args:
        points: Field frame [m], shape (n, 3).
        pos: Of the camera, field frame [m].
        rotation: From `optical_rotation`.
        lens: Focal lengths and principal point.

    Returns:
        Pixels (u, v), shape (n, 2), and depths along the optical axis [m], shape (n,). A point behind the camera has a
        depth <= 0 and a pixel without meaning.
    """
    (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
    p = (points - pos) @ rotation.T
    depth = p[:, 2]
    inverse = 1.0 / np.where(np.abs(depth) < 1e-9, 1e-9, depth)
    return p[:, :2] * inverse[:, None] * (fx, fy) + (cx, cy), depth


def angles_deg(u: float, v: float, lens: LimelightType) -> tuple[float, float]:
    """Angles tx (right is positive) and ty (up is positive) from the principal point to a pixel [deg]."""
    (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
    return math.degrees(math.atan((u - cx) / fx)), math.degrees(math.atan((cy - v) / fy))


def quad_area(corners: FloatArray) -> FloatArray:
    """Signed areas of quadrilaterals (n, 4, 2) [px^2]; positive is counter-clockwise as one sees them."""
    a, b = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    area: FloatArray = 0.5 * (a[:, 1] * b[:, 0] - a[:, 0] * b[:, 1])
    return area
