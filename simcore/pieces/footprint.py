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
    heights: tuple[float, float] = (-math.inf, math.inf)
    """Of its lowest and highest parts [m]."""
    waking_speed: float = 0.005
    """While it is slower, it wakes nothing [m/s]."""

    def gap(self, pos: FloatArray) -> FloatArray:
        """Flat distance of places (n, 2 or 3) from the outside of the box [m], negative within, shape (n,)."""
        dx, dy = pos[:, 0] - self.x, pos[:, 1] - self.y
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        ahead, aside = np.abs(c * dx + s * dy) - self.half_length, np.abs(c * dy - s * dx) - self.half_width
        outside = np.hypot(np.maximum(ahead, 0.0), np.maximum(aside, 0.0))
        gap: FloatArray = outside + np.minimum(np.maximum(ahead, aside), 0.0)
        return gap
