"""Functions for corners of boxes and for plan-view outlines: rectangle, hexagon, and overlap test."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from simcore.typing import FloatArray

__all__ = ["box_corners", "corners", "hexagon", "overlaps"]


def box_corners(low: Sequence[float] | FloatArray, high: Sequence[float] | FloatArray) -> FloatArray:
    """Return all eight corners of an axis-aligned box from the low and high corners [m], shape (8, 3)."""
    return np.array(list(itertools.product(*zip(low, high, strict=True))))


def corners(x: float, y: float, yaw: float, length: float, width: float) -> FloatArray:
    """Return the corners of a rectangle in plan view, counter-clockwise from the front left corner [m], shape (4, 2).

    Args:
        x: x coordinate of the center [m].
        y: y coordinate of the center [m].
        yaw: Yaw of the length axis [rad].
        length: Length [m].
        width: Width [m].

    >>> corners(1.0, 0.0, 0.0, 0.8, 0.6).tolist()
    [[1.4, 0.3], [0.6, 0.3], [0.6, -0.3], [1.4, -0.3]]
    """
    c, s, a, b = math.cos(yaw), math.sin(yaw), 0.5 * length, 0.5 * width
    return np.array([(x + c * u - s * v, y + s * u + c * v) for u, v in ((a, b), (-a, b), (-a, -b), (a, -b))])


def hexagon(center: tuple[float, float], apothem: float, yaw: float = 0.0) -> FloatArray:
    """Return the corners of a regular hexagon in plan view, counter-clockwise [m], shape (6, 2).

    Args:
        center: Center of the hexagon [m].
        apothem: Distance from the center to the middle of a side [m].
        yaw: Yaw of the direction from the center to the middle of a side [rad].

    >>> hexagon((0.0, 0.0), 1.0).max(axis=0).round(3).tolist()
    [1.0, 1.155]
    """
    angles = yaw + np.radians(np.arange(30.0, 390.0, 60.0))
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    outline: FloatArray = np.array(center) + apothem / math.cos(math.pi / 6.0) * rays
    return outline


def overlaps(one: FloatArray, other: FloatArray) -> bool:
    """Return whether two convex outlines overlap, by the separating axis theorem.

    Args:
        one: Corners of the first outline, in order [m], shape (n, 2).
        other: Corners of the second outline, in order [m], shape (m, 2).

    >>> square = corners(0.0, 0.0, 0.0, 2.0, 2.0)
    >>> overlaps(square, square + 1.9), overlaps(square, square + 2.1), overlaps(square, 0.1 * square)
    (True, False, True)
    """
    for outline in (one, other):
        side = np.roll(outline, -1, axis=0) - outline
        normal = np.column_stack([side[:, 1], -side[:, 0]])
        a, b = one @ normal.T, other @ normal.T
        if ((a.max(axis=0) < b.min(axis=0)) | (b.max(axis=0) < a.min(axis=0))).any():
            return False
    return True
