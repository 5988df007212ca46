"""What can reach what: robots as pieces see them, chunks of the field, near and touching pieces.

Pieces in quiet chunks cost nothing. A chunk is active while anything that moves could reach it within the tick, and for
a while after (hysteresis). Because reach is computed before the tick from speed, size and a margin, across chunk
borders too, nothing can meet a piece that is not there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from simcore.quantities import COUNT, ROBOT_LENGTH, SPEED, Quantity, require, require_fields
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = [
    "TOUCH",
    "ChunkGrid",
    "Footprint",
    "WakeSettings",
    "close_pairs",
    "distances2",
    "lengths",
    "touching_chain",
]

TOUCH = 0.005
"""Pieces and bumpers this near count as touching [m]."""

_CHUNK_SIZE = Quantity("m", 0.1, 100.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class WakeSettings:
    """When pieces wake and sleep."""

    chunk_size: float = 2.0
    """Edge of a chunk [m]."""
    chunk_linger: int = 25
    """Ticks that a chunk stays visible to the engine after the last mover left its reach."""
    margin: float = 0.05
    """Added to the reach of a robot [m]."""
    piece_margin: float = 0.01
    """Added to the reach of a moving piece [m]."""
    waking_speed: float = 0.05
    """A piece slower than this does not wake those near it [m/s]; by touch it still does, in the engine."""
    slow_speed: float = 0.03
    """Below this a piece counts as slow [m/s]: gravity alone gives 0.2 m/s in a tick, so nothing in the air does."""
    slow_ticks: int = 15
    """Ticks in a row that a piece must be slow before it sleeps; by then the engine has repaired overlaps, too."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            chunk_size=_CHUNK_SIZE,
            chunk_linger=COUNT,
            margin=ROBOT_LENGTH,
            piece_margin=ROBOT_LENGTH,
            waking_speed=SPEED,
            slow_speed=SPEED,
            slow_ticks=Quantity("ticks (else apexes freeze)", 5, 10_000, is_whole=True),
        )


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


class ChunkGrid:
    """Which chunks are active. Places beyond the grid belong to its border chunks.

    Args:
        low: Smallest corner of the grid [m].
        high: Largest corner [m].
        size: Edge of a chunk [m].
        linger: Ticks that a chunk stays active after the last mark.
    """

    def __init__(
        self, low: tuple[float, float], high: tuple[float, float], *, size: float = 2.0, linger: int = 25
    ) -> None:
        require("ChunkGrid", "size", size, _CHUNK_SIZE)
        self.size = size
        self._low = low
        self._nx = max(1, math.ceil((high[0] - low[0]) / size))
        self._ny = max(1, math.ceil((high[1] - low[1]) / size))
        self._linger = linger
        self._idle = np.full(self._nx * self._ny, linger + 1, dtype=np.int64)  # ticks since the last mark
        self._marked = np.zeros(self._nx * self._ny, dtype=bool)
        self.active = np.zeros(self._nx * self._ny, dtype=bool)
        """Active chunks by index, shape (n,)."""

    def index(self, pos: FloatArray) -> IntArray:
        """Chunk of each place (n, 2 or 3) [m], shape (n,)."""
        x, y = pos[:, 0] - self._low[0], pos[:, 1] - self._low[1]
        index: IntArray = _cells(x, self.size, self._nx - 1) * self._ny + _cells(y, self.size, self._ny - 1)
        return index

    def mark_box(self, x: float, y: float, reach: float) -> None:
        """Mark every chunk that the square of half width `reach` around a place touches [m]."""
        ax, bx = self._column(x - reach), self._column(x + reach)
        ay, by = self._line(y - reach), self._line(y + reach)
        self._marked.reshape(self._nx, self._ny)[ax : bx + 1, ay : by + 1] = True

    def mark(self, pos: FloatArray, reach: FloatArray) -> None:
        """Mark the chunks around many places (n, 2 or 3), each with its reach (n,) [m]."""
        if len(reach) and reach.max() > self.size / 2:
            far = reach > self.size / 2
            for x, y, r in zip(pos[far, 0].tolist(), pos[far, 1].tolist(), reach[far].tolist(), strict=True):
                self.mark_box(x, y, r)
            pos, reach = pos[~far], reach[~far]
        # A square no wider than a chunk touches only the chunks of its corners.
        x, y, last_x, last_y = pos[:, 0] - self._low[0], pos[:, 1] - self._low[1], self._nx - 1, self._ny - 1
        corners = np.array((x - reach, x + reach, y - reach, y + reach))
        cells = _cells(corners, self.size, np.array((last_x, last_x, last_y, last_y))[:, None])
        self._marked[cells[:2, None] * self._ny + cells[None, 2:]] = True

    def update(self) -> tuple[BoolArray, BoolArray]:
        """Close the marking of a tick: chunks that became active, and chunks that fell quiet, shape (n,) each."""
        self._idle += 1
        self._idle[self._marked] = 0
        self._marked[:] = False
        now = self._idle <= self._linger
        woken, quiet = now & ~self.active, self.active & ~now
        self.active = now
        return woken, quiet

    def _column(self, x: float) -> int:
        return min(self._nx - 1, max(0, int((x - self._low[0]) / self.size)))

    def _line(self, y: float) -> int:
        return min(self._ny - 1, max(0, int((y - self._low[1]) / self.size)))


def _cells(offset: FloatArray, size: float, last: int | IntArray) -> IntArray:
    """Number of the cell of each offset, those beyond the grid in its border cells."""
    return np.minimum(np.maximum(offset, 0.0) * (1.0 / size), last).astype(np.int64)


def lengths(rows: FloatArray) -> FloatArray:
    """Of vectors (n, 3), shape (n,); in two thirds of the time of `np.linalg.norm`."""
    norm: FloatArray = np.sqrt(np.einsum("ij,ij->i", rows, rows))
    return norm


def distances2(a: FloatArray, b: FloatArray) -> FloatArray:
    """Squares of the distances of places (n, k) to others (m, k) [m^2], shape (n, m), to 1e-12 m^2 on a field.

    As |a|^2 - 2 a b + |b|^2, which takes a fifth to a half of the time of the differences.
    """
    squares: FloatArray = a @ (-2.0 * b.T)
    squares += (a * a).sum(axis=1)[:, None]
    squares += (b * b).sum(axis=1)
    return squares


def close_pairs(a: FloatArray, b: FloatArray, reach: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Which places (n, 3) have which others (m, 3) within reach of them, (n,) [m].

    Returns:
        Row of the place and row of the other, and the square of their distance [m^2], shape (pairs,) each.
    """
    away2 = distances2(a, b)
    close = (away2 < np.square(reach)[:, None]).ravel().nonzero()[0]  # in a third of the time of rows and columns
    i, j = np.divmod(close, max(len(b), 1))
    return i, j, away2.ravel().take(close)


def touching_chain(pos: FloatArray, radius: FloatArray, first: BoolArray) -> BoolArray:
    """Which of some pieces touch one of the first, or one that does, and so on; the first are among them, shape (n,).

    Args:
        pos: Centers [m], shape (n, 3).
        radius: Of the pieces [m], shape (n,).
        first: Where chains begin, shape (n,).
    """
    count, largest = len(pos), float(radius.max(initial=0.0))
    i, j, away2 = close_pairs(pos, pos, radius + (largest + TOUCH))
    reach = radius.take(i) + radius.take(j) + TOUCH
    touch = (i < j) & (away2 < reach * reach)
    links = coo_matrix((np.ones(np.count_nonzero(touch)), (i[touch], j[touch])), shape=(count, count))
    cluster = connected_components(links, directed=False)[1]
    found: BoolArray = np.bincount(cluster[first], minlength=count)[cluster] > 0
    return found
