"""The opening that shots fall through: its rim, the boards behind it that send them back in, and what is within it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.errors import ConfigError
from simcore.geometry.rotation import Vector
from simcore.physics.surface import TerrainSurface
from simcore.quantities import ANGLE, FIELD_PLACE, require, require_fields
from simcore.typing import BoolArray, FloatArray

__all__ = ["Panel", "ShotOpening"]

_FLAT = 1e-3  # [m]; corners may be this far off their common plane


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """A flat, convex part around an opening, that shots bounce off."""

    corners: tuple[Vector, ...]
    """In their order around it, field frame [m]."""
    surface: TerrainSurface

    def __post_init__(self) -> None:
        require_fields(self, corners=[(FIELD_PLACE,) * 3])
        _require_flat("Panel", self.corners)

    @property
    def normal(self) -> FloatArray:
        """Unit normal, on either side, shape (3,)."""
        return _normal(self.corners)

    def holds(self, points: FloatArray) -> BoolArray:
        """Which points of its plane (n, 3) [m] are within it, shape (n,)."""
        return _within(self.corners, points)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotOpening:
    """A flat opening with a rim, convex, in any attitude."""

    corners: tuple[Vector, ...]
    """Of the rim, in their order around it, field frame [m]."""
    approach: float
    """Direction in which a shot comes that comes straight at it [rad]."""
    boards: tuple[Panel, ...] = ()
    """Each stands over the nearest edge of the rim: what hits it falls in along it, whatever it does to that edge."""
    walls: tuple[Panel, ...] = ()
    """What is within it, e.g. of a funnel."""

    def __post_init__(self) -> None:
        require_fields(self, corners=[(FIELD_PLACE,) * 3])
        require("ShotOpening", "approach", self.approach, ANGLE)
        _require_flat("ShotOpening", self.corners)

    @property
    def middle(self) -> FloatArray:
        """Mean of its corners: where to aim, field frame [m], shape (3,)."""
        mean: FloatArray = np.array(self.corners).mean(axis=0)
        return mean

    @property
    def inward(self) -> FloatArray:
        """Unit normal toward the inside: down, or on where a shot comes straight from, shape (3,)."""
        normal = _normal(self.corners)
        ahead = np.array([math.cos(self.approach), math.sin(self.approach), -1.0])
        inward: FloatArray = normal if normal @ ahead > 0.0 else -normal
        return inward

    @property
    def rim(self) -> list[tuple[Vector, Vector]]:
        """Its edges, from corner to corner [m]."""
        return list(zip(self.corners, (*self.corners[1:], self.corners[0]), strict=True))

    @property
    def bare_rim(self) -> list[tuple[Vector, Vector]]:
        """Those of its edges over which no board stands."""
        edges = self.rim
        middles = np.array([np.mean(edge, axis=0)[:2] for edge in edges])
        boarded = {
            int(np.argmin(np.linalg.norm(middles - np.mean(board.corners, axis=0)[:2], axis=1)))
            for board in self.boards
        }
        return [edge for number, edge in enumerate(edges) if number not in boarded]

    @property
    def reach(self) -> float:
        """Radius of the ball around its middle that holds rim, boards and walls [m]."""
        corners = [self.corners, *(panel.corners for panel in (*self.boards, *self.walls))]
        return max(float(np.linalg.norm(np.array(some) - self.middle, axis=1).max()) for some in corners)

    def holds(self, points: FloatArray) -> BoolArray:
        """Which points of its plane (n, 3) [m] are within the rim, shape (n,)."""
        return _within(self.corners, points)


def _normal(corners: tuple[Vector, ...]) -> FloatArray:
    rows = np.array(corners)
    normal: FloatArray = np.cross(rows[1] - rows[0], rows[2] - rows[1])
    return normal / np.linalg.norm(normal)


def _within(corners: tuple[Vector, ...], points: FloatArray) -> BoolArray:
    """Which points (n, 3), looked at along the normal, are within a convex outline, shape (n,)."""
    rows = np.array(corners)
    inside: BoolArray = np.ones(len(points), dtype=bool)
    # from each edge toward the inside; np.cross of all of them takes 40 us, and of one as much
    for corner, toward in zip(rows, np.cross(_normal(corners), np.roll(rows, -1, axis=0) - rows), strict=True):
        inside &= (points - corner) @ toward >= 0.0
    return inside


def _require_flat(owner: str, corners: tuple[Vector, ...]) -> None:
    """Refuse what is no flat, convex outline."""
    if len(corners) < 3:
        raise ConfigError(f"{owner}: corners must be three or more, got {len(corners)}")
    rows = np.array(corners)
    sides = np.roll(rows, -1, axis=0) - rows
    turns = np.cross(sides, np.roll(sides, -1, axis=0))
    if not (turns @ turns[0] > 0.0).all() or float(np.abs((rows - rows[0]) @ _normal(corners)).max()) > _FLAT:
        raise ConfigError(f"{owner}: corners must go around a flat, convex outline, got {corners}")
