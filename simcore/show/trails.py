"""Trails of flying pieces: which of this frame's pieces is which of the last one's, and where each has been."""

from __future__ import annotations

import numpy as np

from simcore.typing import FloatArray
from simcore.units import GRAVITY

__all__ = ["Trails"]


class _Trail:
    __slots__ = ("points", "times", "vel")

    def __init__(self, point: FloatArray, time: float) -> None:
        self.points = [point]
        self.times = [time]
        self.vel: FloatArray | None = None

    def expected(self, time: float) -> FloatArray:
        """Where it should be now, on the parabola of its last two points."""
        dt = time - self.times[-1]
        if self.vel is None:
            return self.points[-1]
        guess: FloatArray = self.points[-1] + self.vel * dt
        guess[2] -= 0.5 * GRAVITY * dt * dt
        return guess


class Trails:
    """Follows unnamed points by where each must be next; telemetry does not say which piece is which.

    >>> trails = Trails()
    >>> for i in range(4):
    ...     trails.update(0.02 * i, np.array([[0.2 * i, 0.0, 1.0], [0.2 * i, 0.16, 1.0]]))
    >>> trails.segments(0.06).shape
    (6, 2, 3)
    """

    def __init__(self, *, keep: float = 1.5, reach: float = 0.12, fastest: float = 30.0) -> None:
        """Choose what is drawn.

        Args:
            keep: How long a trail stays after its piece was there [s].
            reach: How far from its parabola a piece may be [m].
            fastest: A piece's first step, of which no velocity is known, is at most at this speed [m/s].
        """
        self._keep, self._reach, self._fastest = keep, reach, fastest
        self._flying: list[_Trail] = []
        self._landed: list[_Trail] = []
        self._time = -np.inf

    def clear(self) -> None:
        """Forget all, e.g. after a jump in time."""
        self._flying, self._landed, self._time = [], [], -np.inf

    def update(self, time: float, points: FloatArray) -> None:
        """Where the flying pieces are now [s, m], shape (n, 3), in any order."""
        if time == self._time:
            return
        if time < self._time or time > self._time + 0.5:
            self.clear()
        free = list(range(len(points)))
        still: list[_Trail] = []
        for trail in sorted(self._flying, key=lambda t: t.vel is None):  # those whose way is known choose first
            dt = time - trail.times[-1]
            reach = self._reach if trail.vel is not None else self._fastest * dt
            distances = np.linalg.norm(points[free] - trail.expected(time), axis=1)
            if len(distances) and distances.min() <= reach:
                point = points[free.pop(int(distances.argmin()))]
                vel = (point - trail.points[-1]) / dt
                vel[2] -= 0.5 * GRAVITY * dt  # from the middle of the step to its end
                trail.vel = vel
                trail.points.append(point)
                trail.times.append(time)
                still.append(trail)
            else:
                self._landed.append(trail)
        self._flying = still + [_Trail(points[i], time) for i in free]
        self._landed = [t for t in self._landed if time - t.times[-1] < self._keep]
        self._time = time

    def segments(self, time: float) -> FloatArray:
        """Pieces of line of the last `keep` seconds [m], shape (m, 2, 3)."""
        lines = []
        for trail in (*self._landed, *self._flying):
            first = next((i for i, t in enumerate(trail.times) if time - t < self._keep), len(trail.times))
            points = trail.points[first:]
            if len(points) > 1:
                array = np.array(points)
                lines.append(np.stack((array[:-1], array[1:]), axis=1))
        return np.concatenate(lines) if lines else np.zeros((0, 2, 3))
