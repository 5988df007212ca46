"""Robots, and what hangs and swings, as pieces see them: a box seen from above."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.typing import FloatArray

__all__ = ["Footprint"]


@dataclass(frozen=True, slots=True)
class Footprint:
    """A robot, or what hangs and swings, as the pieces see it."""

    x: float
    y: float
    yaw: float
    half_length: float
    """Half of the bumper box along its heading [m]."""
    half_width: float
    speed: float
    """Fastest point of the box [m/s], so including spin."""
    underside: tuple[float, float, float] = (-math.inf, 0.0, 0.0)
    """Height of its lower side at (x, y) [m], and how much it rises along x and along y, field frame [m/m]."""
    heights: tuple[float, float] = (-math.inf, math.inf)
    """Of its lowest and highest parts [m]."""
    waking_speed: float = 0.005
    """While it is slower, it reaches nothing [m/s]; what it touches wakes all the same."""

    def beyond(self, pos: FloatArray) -> tuple[FloatArray, FloatArray]:
        """How far places (n, 2 or 3) lie beyond the ends and beyond the sides of the box [m], negative within.

        Returns:
            Shape (n,) each.
        """
        dx, dy = pos[:, 0] - self.x, pos[:, 1] - self.y
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return np.abs(c * dx + s * dy) - self.half_length, np.abs(c * dy - s * dx) - self.half_width

    def over(self, pos: FloatArray) -> FloatArray:
        """How far the plane of its lower side is over places (n, 3) [m], shape (n,)."""
        height, along_x, along_y = self.underside
        over: FloatArray = height + along_x * (pos[:, 0] - self.x) + along_y * (pos[:, 1] - self.y) - pos[:, 2]
        return over

    def gap(self, pos: FloatArray) -> FloatArray:
        """Flat distance of places (n, 2 or 3) from the outside of the box [m], negative within, shape (n,)."""
        ahead, aside = self.beyond(pos)
        outside = np.hypot(np.maximum(ahead, 0.0), np.maximum(aside, 0.0))
        gap: FloatArray = outside + np.minimum(np.maximum(ahead, aside), 0.0)
        return gap
