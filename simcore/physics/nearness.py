"""Which places are near elements of the field: these never move, so the engine need not be asked.

Boxes along the field's axes answer for places; outlines in plan for robots, beside what stands at an angle.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.rotation import Quaternion, Vector, matrix
from simcore.physics.shapes import Shape, bounding_box, outline, outline_points
from simcore.typing import BoolArray, FloatArray

__all__ = ["PlanOutlines", "StaticBoxes"]

_ROUND = 0.01  # share that a ring of 24 points is less wide than the circle around it


class StaticBoxes:
    """Bounding boxes of elements of the field, field frame."""

    def __init__(self) -> None:
        self._low: FloatArray = np.zeros((0, 3))
        self._high: FloatArray = np.zeros((0, 3))

    def add(self, shape: Shape, pos: Vector, quat: Quaternion) -> None:
        """Add a static whose origin is at a place [m], with its attitude."""
        low, high = bounding_box(shape)
        if quat != (0.0, 0.0, 0.0, 1.0):
            axes = matrix(quat)
            middle, half = axes @ (0.5 * (low + high)), np.abs(axes) @ (0.5 * (high - low))
            low, high = middle - half, middle + half
        self._low, self._high = np.vstack((self._low, low + pos)), np.vstack((self._high, high + pos))

    def are_near(self, pos: FloatArray, reach: FloatArray) -> BoolArray:
        """Whether one of the boxes is within reach of each place, shape (n,).

        Args:
            pos: Places [m], shape (n, 3).
            reach: Of each [m], shape (n,).
        """
        return self._are_near(pos, reach, 3)

    def is_clear(self, x: float, y: float, reach: float) -> bool:
        """Whether no box at any height is within reach of a place [m].

        >>> from simcore.physics.shapes import Box
        >>> boxes = StaticBoxes()
        >>> boxes.add(Box((1.0, 1.0, 1.0)), (5.0, 5.0, 0.5), (0.0, 0.0, 0.0, 1.0))
        >>> boxes.is_clear(3.0, 5.0, 1.0), boxes.is_clear(4.0, 5.0, 1.0)
        (True, False)
        """
        return not self._are_near(np.array([[x, y]]), np.array([reach]), 2)[0]

    def _are_near(self, pos: FloatArray, reach: FloatArray, axes: int) -> BoolArray:
        """As `are_near`, by the first axes alone."""
        place = pos[:, None, :axes]
        away = np.maximum(np.maximum(self._low[:, :axes] - place, place - self._high[:, :axes]), 0.0)
        near: BoolArray = (np.einsum("ijk,ijk->ij", away, away) < np.square(reach)[:, None]).any(axis=1)
        return near


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
        self._outlines.append(outline(points[:, :2]))
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
