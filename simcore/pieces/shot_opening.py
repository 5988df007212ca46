"""Opening of a goal: the target of shooters, and the outline that a scoring shot passes through."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.errors import ConfigError
from simcore.quantities import ANGLE, FIELD_PLACE, require_fields
from simcore.typing import BoolArray, FloatArray
from simcore.world.rotation import Vector

__all__ = ["ShotOpening"]

_FLAT = 1e-3  # [m]; largest distance of corners from a common plane


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotOpening:
    """Flat, convex opening with a rim, in any attitude."""

    corners: tuple[Vector, ...]
    """Corners of the rim, in order, field frame [m]."""
    approach: float
    """Heading of a shot that approaches the opening head-on, field frame [rad]."""

    def __post_init__(self) -> None:
        require_fields(self, corners=[(FIELD_PLACE,) * 3], approach=ANGLE)
        if len(self.corners) < 3:
            raise ConfigError(f"ShotOpening: corners must be three or more, got {len(self.corners)}")
        rows = np.array(self.corners)
        sides = np.roll(rows, -1, axis=0) - rows
        turns = np.cross(sides, np.roll(sides, -1, axis=0))
        if not (turns @ turns[0] > 0.0).all() or float(np.abs((rows - rows[0]) @ self.inward).max()) > _FLAT:
            raise ConfigError(f"ShotOpening: corners must go around a flat, convex outline, got {self.corners}")

    @property
    def middle(self) -> FloatArray:
        """Point to aim at: the mean of the corners, field frame [m], shape (3,)."""
        mean: FloatArray = np.array(self.corners).mean(axis=0)
        return mean

    @property
    def inward(self) -> FloatArray:
        """Unit normal of the opening toward the inside of the goal, field frame, shape (3,).

        The normal points downward or along the approach.
        """
        first, second, third = np.array(self.corners[:3])
        normal: FloatArray = np.cross(second - first, third - second)
        ahead = np.array([math.cos(self.approach), math.sin(self.approach), -1.0])
        return normal * (math.copysign(1.0, normal @ ahead) / np.linalg.norm(normal))

    def holds(self, points: FloatArray) -> BoolArray:
        """Return whether each point, (n, 3) [m], is inside the rim, seen along the normal, shape (n,)."""
        rows, inside = np.array(self.corners), np.ones((2, len(points)), dtype=bool)
        for corner, toward in zip(rows, np.cross(self.inward, np.roll(rows, -1, axis=0) - rows), strict=True):
            side = (points - corner) @ toward
            inside &= np.stack([side >= 0.0, side <= 0.0])  # corners may be clockwise or counter-clockwise
        within: BoolArray = inside[0] | inside[1]
        return within
