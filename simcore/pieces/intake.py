"""Where the robot takes pieces in: a box on the robot, tested on all pieces at once, and swept between ticks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.errors import ConfigError, require_finite
from simcore.geometry.rotation import matrix
from simcore.geometry.zones import BoxZone
from simcore.typing import BoolArray, BoolSupplier, FloatArray

__all__ = ["IntakeZone", "field_to_robot"]


def _always() -> bool:
    return True


@dataclass(frozen=True, slots=True, kw_only=True)
class IntakeZone:
    """A box in the robot frame (x forward, y left, z up from the floor); a piece is in it when its center is.

    >>> zone = IntakeZone(x_min=-0.50, x_max=-0.35, y_min=-0.25, y_max=0.25, z_max=0.20)
    >>> zone.contains(np.array([[-0.4, 0.0, 0.075], [0.4, 0.0, 0.075]])).tolist()
    [True, False]
    """

    x_min: float
    """[m]"""
    x_max: float
    """[m]"""
    y_min: float
    """[m]"""
    y_max: float
    """[m]"""
    z_min: float = -0.10
    """Below the floor plane, for a robot that pitches over a bump [m]."""
    z_max: float
    """[m]"""
    active: BoolSupplier = _always
    """Whether the intake is out and its roller turns; asked once by `captured`."""

    def __post_init__(self) -> None:
        for axis in "xyz":
            low, high = getattr(self, f"{axis}_min"), getattr(self, f"{axis}_max")
            require_finite("IntakeZone", f"{axis}_min", low, "m")
            require_finite("IntakeZone", f"{axis}_max", high, "m")
            if not low < high:
                raise ConfigError(f"IntakeZone: {axis}_min must be below {axis}_max, got {low} and {high} m")

    @property
    def reach(self) -> float:
        """From the robot's origin to the farthest corner [m]."""
        return math.hypot(max(-self.x_min, self.x_max), max(-self.y_min, self.y_max), max(-self.z_min, self.z_max))

    def contains(self, pos_robot: FloatArray) -> BoolArray:
        """Which positions are in the box, active or not; NaN is never in it.

        Args:
            pos_robot: Centers, robot frame [m], shape (n, 3).

        Returns:
            Mask, shape (n,).
        """
        return self._box().contains(pos_robot)

    def captured(self, prev_robot: FloatArray, now_robot: FloatArray) -> BoolArray:
        """Which pieces are in the box or went through it since the last tick; none while the intake is not active.

        A path is the straight line in the robot frame, so it does not matter whether piece or robot moved.

        Args:
            prev_robot: Centers a tick ago, in the robot frame of that time [m], shape (n, 3).
            now_robot: Centers now, in the robot frame of now [m], shape (n, 3).

        Returns:
            Mask, shape (n,).
        """
        if not self.active():
            return np.zeros(len(now_robot), dtype=np.bool_)
        box = self._box()
        # Few pieces are near: a test of the boxes round all paths (18 us for 400) leaves those worth the exact one.
        near: BoolArray = np.all(
            (np.maximum(prev_robot, now_robot) >= box.low) & (np.minimum(prev_robot, now_robot) <= box.high), axis=1
        )
        if near.any():
            near[near] = box.crossed(prev_robot[near], now_robot[near])
        return near

    def _box(self) -> BoxZone:
        return BoxZone((self.x_min, self.y_min, self.z_min), (self.x_max, self.y_max, self.z_max))


def field_to_robot(pos_field: FloatArray, robot_pos: FloatArray, robot_rotation: FloatArray) -> FloatArray:
    """Positions as the robot sees them.

    Args:
        pos_field: Field frame [m], shape (n, 3).
        robot_pos: Origin of the robot frame, field frame [m], shape (3,).
        robot_rotation: Robot to field, unit quaternion xyzw, shape (4,).

    Returns:
        Robot frame [m], shape (n, 3).
    """
    x, y, z, w = (float(c) for c in robot_rotation)
    if not math.isclose(x * x + y * y + z * z + w * w, 1.0, rel_tol=1e-3):
        raise ConfigError(f"field_to_robot: want a unit quaternion xyzw, got {robot_rotation}")
    result: FloatArray = (pos_field - robot_pos) @ matrix((x, y, z, w))  # rows times R is R transposed times each
    return result
