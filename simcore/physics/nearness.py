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

_CELL = 0.25
"""Side of a cell of the map of clearances [m]."""
_ROUND = 0.01  # share that a ring of 24 points is less wide than the circle around it
_MOST_CELLS = 100_000
"""Larger fields get larger cells."""


class StaticBoxes:
    """Bounding boxes of elements of the field, field frame.

    A map of the floor knows how far each of its cells is from the nearest box, so that places in the open, which are
    most, are told with one look.
    """

    def __init__(self) -> None:
        self._boxes: list[tuple[FloatArray, FloatArray]] = []
        self._corners: tuple[FloatArray, FloatArray] | None = None

    def add(self, shape: Shape, pos: Vector, quat: Quaternion) -> None:
        """Add a static whose origin is at a place [m], with its attitude."""
        low, high = bounding_box(shape)
        if quat != (0.0, 0.0, 0.0, 1.0):
            axes = matrix(quat)
            if not (np.isfinite(low).all() and np.isfinite(high).all()):
                low, high = np.full(3, -np.inf), np.full(3, np.inf)
            else:
                middle, half = axes @ (0.5 * (low + high)), np.abs(axes) @ (0.5 * (high - low))
                low, high = middle - half, middle + half
        self._boxes.append((low + pos, high + pos))
        self._corners = None

    def are_near(self, pos: FloatArray, reach: FloatArray) -> BoolArray:
        """Whether one of the boxes is within reach of each place, shape (n,).

        Args:
            pos: Places [m], shape (n, 3).
            reach: Of each [m], shape (n,).
        """
        near: BoolArray = np.zeros(len(pos), dtype=bool)
        if not self._boxes or not len(pos):
            return near
        low, high = self._prepared()
        cell = np.minimum(np.fmax((pos[:, :2] - self._origin) * self._scale, 0.0), self._last).astype(np.int64)
        doubtful = np.nonzero(self._clearance[cell[:, 0], cell[:, 1]] < reach)[0]
        if len(doubtful):
            near[doubtful] = (_distances2(low, high, pos[doubtful]) < np.square(reach[doubtful])[:, None]).any(axis=1)
        return near

    def is_clear(self, x: float, y: float, reach: float) -> bool:
        """Whether no box at any height is within reach of a place [m]; False may also mean that the map is too coarse.

        >>> from simcore.physics.shapes import Box
        >>> boxes = StaticBoxes()
        >>> boxes.add(Box((1.0, 1.0, 1.0)), (5.0, 5.0, 0.5), (0.0, 0.0, 0.0, 1.0))
        >>> boxes.is_clear(3.0, 5.0, 1.0), boxes.is_clear(4.0, 5.0, 1.0)
        (True, False)
        """
        if not self._boxes:
            return True
        self._prepared()
        scale = self._scale
        column = min(self._last[0], max(0.0, (x - self._origin[0]) * scale))
        line = min(self._last[1], max(0.0, (y - self._origin[1]) * scale))
        return bool(self._clearance[int(column), int(line)] >= reach)

    def _prepared(self) -> tuple[FloatArray, FloatArray]:
        """Corners of the boxes, shape (3, n) each; the map is made where one was added since."""
        if self._corners is None:
            low, high = (np.array(corners).T.copy() for corners in zip(*self._boxes, strict=True))
            self._corners = low, high
            self._map(low, high)
        return self._corners

    def _map(self, low: FloatArray, high: FloatArray) -> None:
        """Least distance in plan from each cell to the boxes; the border cells reach to infinity."""
        bounded = np.isfinite(low[:2]).all(axis=0) & np.isfinite(high[:2]).all(axis=0)
        least = low[:2, bounded].min(axis=1, initial=0.0) - 1.0
        most = high[:2, bounded].max(axis=1, initial=0.0) + 1.0
        side = max(_CELL, math.sqrt(float(np.prod(most - least)) / _MOST_CELLS))
        count = np.ceil((most - least) / side).astype(np.int64)
        self._origin, self._scale = least, 1.0 / side
        self._last = count - 1.0
        edges = [least[axis] + side * np.arange(count[axis] + 1) for axis in (0, 1)]
        away2 = np.full(tuple(count), np.inf)
        for number in range(low.shape[1]):
            flat = []
            for axis in (0, 1):
                left, right = edges[axis][:-1].copy(), edges[axis][1:].copy()
                left[0], right[-1] = -np.inf, np.inf  # beyond the map
                gap = np.maximum(np.maximum(low[axis, number] - right, left - high[axis, number]), 0.0)
                flat.append(np.square(gap))
            np.minimum(away2, flat[0][:, None] + flat[1][None, :], out=away2)
        self._clearance = np.sqrt(away2)


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


def _distances2(low: FloatArray, high: FloatArray, pos: FloatArray) -> FloatArray:
    """Square of the distance from each place to each box [m^2], shape (places, boxes)."""
    distance2: FloatArray = np.zeros((len(pos), low.shape[1]))
    for axis in range(3):
        x = pos[:, axis, None]
        away = np.maximum(np.maximum(low[axis] - x, x - high[axis]), 0.0)
        distance2 += away * away
    return distance2
