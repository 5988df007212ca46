"""Regions of the field (zones), with tests for points and for segments, such as the path of a fast piece in a tick."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from simcore.errors import ConfigError
from simcore.quantities import FIELD_LENGTH, FIELD_PLACE, require_fields
from simcore.typing import BoolArray, FloatArray
from simcore.world.rotation import Vector

__all__ = ["BoxZone", "CapsuleZone", "CylinderZone", "Zone", "box_crossed"]


@runtime_checkable
class Zone(Protocol):
    """Closed region of the field."""

    @property
    def box(self) -> tuple[Vector, Vector]:
        """Low and high corners of the bounding box, field frame [m]."""
        ...

    def contains(self, points: FloatArray) -> BoolArray:
        """Return whether each point, (n, 3) [m], is inside the zone, shape (n,)."""
        ...

    def crossed(self, start: FloatArray, end: FloatArray) -> BoolArray:
        """Return whether each segment from `start` to `end`, (n, 3) [m], touches the zone, shape (n,)."""
        ...


@dataclass(frozen=True, slots=True)
class BoxZone:
    """Zone in the shape of an axis-aligned box, field frame."""

    low: tuple[float, float, float]
    """Corner with the smallest coordinates [m]."""
    high: tuple[float, float, float]
    """Corner with the largest coordinates [m]."""

    def __post_init__(self) -> None:
        require_fields(self, low=(FIELD_PLACE,) * 3, high=(FIELD_PLACE,) * 3)
        if not all(a < b for a, b in zip(self.low, self.high, strict=True)):
            raise ConfigError(f"BoxZone: low must be below high on every axis, got {self.low} and {self.high}")

    @property
    def box(self) -> tuple[Vector, Vector]:
        """Low and high corners, field frame [m]."""
        return self.low, self.high

    def contains(self, points: FloatArray) -> BoolArray:
        """Return whether each point, (n, 3) [m], is inside the box, shape (n,)."""
        inside = (points >= self.low) & (points <= self.high)
        return inside[:, 0] & inside[:, 1] & inside[:, 2]

    def crossed(self, start: FloatArray, end: FloatArray) -> BoolArray:
        """Return whether each segment from `start` to `end`, (n, 3) [m], touches the box, shape (n,)."""
        return box_crossed(self.low, self.high, start, end)


@dataclass(frozen=True, slots=True)
class CylinderZone:
    """Zone in the shape of an upright cylinder, field frame."""

    center: tuple[float, float]
    """x and y of the axis [m]."""
    radius: float
    """Radius [m]."""
    bottom: float
    """Height of the lower end [m]."""
    top: float
    """Height of the upper end [m]."""

    def __post_init__(self) -> None:
        require_fields(
            self, center=(FIELD_PLACE, FIELD_PLACE), radius=FIELD_LENGTH, bottom=FIELD_PLACE, top=FIELD_PLACE
        )
        if not self.bottom < self.top:
            raise ConfigError(f"CylinderZone: bottom must be below top, got {self.bottom} and {self.top} m")

    @property
    def box(self) -> tuple[Vector, Vector]:
        """Low and high corners of the bounding box, field frame [m]."""
        (x, y), r = self.center, self.radius
        return (x - r, y - r, self.bottom), (x + r, y + r, self.top)

    def contains(self, points: FloatArray) -> BoolArray:
        """Return whether each point, (n, 3) [m], is inside the cylinder, shape (n,)."""
        flat = np.hypot(points[:, 0] - self.center[0], points[:, 1] - self.center[1])
        inside: BoolArray = (flat <= self.radius) & (points[:, 2] >= self.bottom) & (points[:, 2] <= self.top)
        return inside

    def crossed(self, start: FloatArray, end: FloatArray) -> BoolArray:
        """Return whether each segment from `start` to `end`, (n, 3) [m], touches the cylinder, shape (n,).

        The method first clips a segment to the heights between bottom and top. The segment touches the cylinder if the
        smallest distance of the clipped part from the axis is at most the radius.
        """
        enter, leave = _slab(start[:, 2:], end[:, 2:], np.array([self.bottom]), np.array([self.top]))
        meets = enter[:, 0] <= leave[:, 0]
        t0, t1 = np.where(meets, enter[:, 0], 0.0), np.where(meets, leave[:, 0], 0.0)
        flat, move = start[:, :2] - np.asarray(self.center), end[:, :2] - start[:, :2]
        length2 = np.einsum("ij,ij->i", move, move)
        nearest = -np.einsum("ij,ij->i", flat, move) / np.where(length2 > 0.0, length2, 1.0)
        t = np.clip(nearest, t0, t1)
        closest = flat + t[:, None] * move
        hit: BoolArray = meets & (np.hypot(closest[:, 0], closest[:, 1]) <= self.radius)
        return hit


@dataclass(frozen=True, slots=True)
class CapsuleZone:
    """Zone of all points within a radius of a line segment, for example around a pipe, bar or ledge, field frame."""

    start: tuple[float, float, float]
    """First end of the segment [m]."""
    end: tuple[float, float, float]
    """Second end of the segment [m]."""
    radius: float
    """Radius [m]."""

    def __post_init__(self) -> None:
        require_fields(self, start=(FIELD_PLACE,) * 3, end=(FIELD_PLACE,) * 3, radius=FIELD_LENGTH)
        if self.start == self.end:
            raise ConfigError(f"CapsuleZone: start and end must differ, got {self.start}")

    @property
    def box(self) -> tuple[Vector, Vector]:
        """Low and high corners of the bounding box, field frame [m]."""
        (a, b, c), (d, e, f), r = self.start, self.end, self.radius
        return (min(a, d) - r, min(b, e) - r, min(c, f) - r), (max(a, d) + r, max(b, e) + r, max(c, f) + r)

    def contains(self, points: FloatArray) -> BoolArray:
        """Return whether each point, (n, 3) [m], is inside the capsule, shape (n,)."""
        line = np.asarray(self.end) - self.start
        away = points - self.start
        share = np.clip(away @ line / (line @ line), 0.0, 1.0)
        inside: BoolArray = np.linalg.norm(away - share[:, None] * line, axis=1) <= self.radius
        return inside

    def crossed(self, start: FloatArray, end: FloatArray) -> BoolArray:
        """Return whether each segment from `start` to `end`, (n, 3) [m], touches the capsule, shape (n,)."""
        hit: BoolArray = _line_distance(start, end, self.start, self.end) <= self.radius
        return hit


def box_crossed(low: Vector, high: Vector, start: FloatArray, end: FloatArray) -> BoolArray:
    """Return whether each segment touches a box, by the slab method, shape (n,).

    Args:
        low: Corner of the box with the smallest coordinates [m].
        high: Corner of the box with the largest coordinates [m].
        start: Starts of the segments [m], shape (n, 3).
        end: Ends of the segments [m], shape (n, 3).
    """
    enter, leave = _slab(start, end, np.asarray(low), np.asarray(high))
    first: FloatArray = np.max(enter, axis=1)
    last: FloatArray = np.min(leave, axis=1)
    return first <= last


def _line_distance(start: FloatArray, end: FloatArray, a: Vector, b: Vector) -> FloatArray:
    """Compute the smallest distance between each of n segments and the segment from a to b [m], shape (n,).

    The closest points are either inner points of both segments, or at least one is an end of a segment.

    Args:
        start: Starts of the n segments [m], shape (n, 3).
        end: Ends of the n segments [m], shape (n, 3).
        a: Start of the other segment [m].
        b: End of the other segment [m].
    """
    line, move = np.asarray(b) - np.asarray(a), end - start
    away = start - np.asarray(a)
    aa, ab, bb = line @ line, move @ line, np.einsum("ij,ij->i", move, move)
    c, f = away @ line, np.einsum("ij,ij->i", away, move)
    steep = aa * bb - ab * ab
    t = np.clip(np.where(steep > 1e-12 * aa, ab * c - aa * f, 0.0) / np.where(steep > 1e-12 * aa, steep, 1.0), 0.0, 1.0)
    nearest: FloatArray = np.full(len(start), np.inf)
    free = np.where(bb > 0.0, bb, 1.0)
    for guess in (
        t,
        np.zeros_like(t),
        np.ones_like(t),
        np.clip(-f / free, 0.0, 1.0),
        np.clip((ab - f) / free, 0.0, 1.0),
    ):
        point = away + guess[:, None] * move
        share = np.clip(point @ line / aa, 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(point - share[:, None] * line, axis=1))
    return nearest


def _slab(start: FloatArray, end: FloatArray, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Compute the fractions of segments, 0 to 1, at entry into slabs and at exit; entry > exit if a segment misses.

    Args:
        start: Starts of the segments [m], shape (n, axes).
        end: Ends of the segments [m], shape (n, axes).
        low: Lower bound of the slab on each axis [m], shape (axes,).
        high: Upper bound of the slab on each axis [m], shape (axes,).

    Returns:
        Fractions at entry and at exit, shape (n, axes) each.
    """
    move = end - start
    still = np.abs(move) < 1e-300
    safe = np.where(still, 1.0, move)
    with np.errstate(over="ignore"):
        a, b = (low - start) / safe, (high - start) / safe
    inside = (start >= low) & (start <= high)
    enter = np.where(still, np.where(inside, 0.0, np.inf), np.minimum(a, b))
    leave = np.where(still, np.where(inside, 1.0, -np.inf), np.maximum(a, b))
    return np.maximum(enter, 0.0), np.minimum(leave, 1.0)
