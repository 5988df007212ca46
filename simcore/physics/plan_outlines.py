"""Which elements of the field a robot's bumper box could meet, seen from above.

They never move, so the engine need not be asked, whose boxes along the field's axes are far larger than what stands at
an angle.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from simcore.geometry.rotation import Quaternion, Vector, matrix
from simcore.physics.shape_extent import outline_points
from simcore.physics.shapes import Shape
from simcore.typing import BoolArray, FloatArray

__all__ = ["PlanOutlines"]

_ROUND = 0.01  # share that a ring of 24 points is less wide than the circle around it


class PlanOutlines:
    """Outlines of elements of the field in plan, and the heights between which they stand."""

    def __init__(self) -> None:
        self._outlines: list[FloatArray] = []
        self._heights: list[tuple[float, float]] = []
        self._points: FloatArray | None = None

    def add(self, shape: Shape, pos: Vector, quat: Quaternion) -> None:
        """Add a static whose origin is at a place [m], with its attitude."""
        points = outline_points(shape)
        points = points + _ROUND * (points - points.mean(axis=0))
        points = points @ matrix(quat).T + pos
        self._heights.append((float(points[:, 2].min()), float(points[:, 2].max())))
        self._outlines.append(_hull(points[:, :2]))
        self._points = None

    def met(
        self, x: float, y: float, yaw: float, half_length: float, half_width: float, bottom: float, top: float
    ) -> BoolArray:
        """Which elements, in the order in which they were added, may reach into an upright box, shape (n,).

        Convex shapes do not meet where a line parts them; four directions of such lines are tried, those of the box's
        sides and those of the field's axes. So one that is told to be met may still be a little way off.

        Args:
            x: Middle of the box [m].
            y: The same [m].
            yaw: Of its length [rad].
            half_length: [m]
            half_width: [m]
            bottom: Lowest height [m].
            top: Highest [m].
        """
        if not self._outlines:
            return np.zeros(0, dtype=bool)
        points = self._prepared()
        c, s = math.cos(yaw), math.sin(yaw)
        wide, deep = abs(c) * half_length + abs(s) * half_width, abs(s) * half_length + abs(c) * half_width
        ends = np.array([[x + wide], [y + deep], [top], [wide - x], [deep - y], [-bottom]])
        met: BoolArray = np.all(self._bounds < ends, axis=0)
        near = met.nonzero()[0]
        if len(near) and yaw != 0.0:
            along = (points.take(near, axis=0) - (x, y)) @ ((c, -s), (s, c))  # (elements, points, 2)
            half = (half_length, half_width)
            met[near] = ((along.min(axis=1) < half) & (along.max(axis=1) > np.negative(half))).all(axis=1)
        return met

    def _prepared(self) -> FloatArray:
        """Corners of all outlines, the last one of each again and again, shape (elements, most corners, 2) [m]."""
        if self._points is None:
            most = max(map(len, self._outlines))
            self._points = np.array(
                [np.vstack((line, np.repeat(line[-1:], most - len(line), axis=0))) for line in self._outlines]
            )
            bottom, top = np.array(self._heights).T
            low, high = self._points.min(axis=1).T, self._points.max(axis=1).T
            self._bounds = np.vstack((low, bottom, -high, -top))  # x, y, z of the low ends, and of the high ones
        return self._points


def _hull(points: FloatArray) -> FloatArray:
    """Corners of the convex outline of points in a plane, shape (n, 2)."""
    try:
        return points[ConvexHull(points).vertices]
    except QhullError:  # they lie on a line
        return points
