"""Red is blue turned by 180 degrees about the middle of the field."""

from __future__ import annotations

import math

from simcore.typing import FloatArray

__all__ = ["turn_half", "turn_half_point", "turn_half_pose", "wrap_angle"]


def wrap_angle(angle: float) -> float:
    """The same angle within -pi..pi [rad]."""
    return math.atan2(math.sin(angle), math.cos(angle))


def turn_half_point(x: float, y: float, field_size: tuple[float, float]) -> tuple[float, float]:
    """A point of the field turned by 180 degrees about its middle [m]."""
    return field_size[0] - x, field_size[1] - y


def turn_half_pose(x: float, y: float, yaw: float, field_size: tuple[float, float]) -> tuple[float, float, float]:
    """A planar pose turned by 180 degrees about the middle of the field [m, m, rad]."""
    return field_size[0] - x, field_size[1] - y, wrap_angle(yaw + math.pi)


def turn_half(points: FloatArray, field_size: tuple[float, float]) -> FloatArray:
    """Points of shape (n, 2) or (n, 3) turned by 180 degrees about the middle of the field [m]; z stays."""
    turned = points.copy()
    turned[:, 0] = field_size[0] - points[:, 0]
    turned[:, 1] = field_size[1] - points[:, 1]
    return turned
