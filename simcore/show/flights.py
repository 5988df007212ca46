"""Flights of pieces, put together again from what was published: of a run's shots, and as trails in a live view."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from simcore.show.scene import ShotTrace
from simcore.telemetry.recording import Recording
from simcore.typing import FloatArray
from simcore.units import GRAVITY

__all__ = ["Trails", "flights_of"]

_ROLLS_IN = 2.0  # [s] between the first touch of a goal and the count
_FLOOR = 0.5  # [m]; what touches lower has missed
_MOST_TRIED = 5000  # ways to choose those that landed; with more than that the oldest are taken


@dataclass(slots=True)
class _Flight:
    start: float
    points: list[FloatArray]
    end: float = 0.0
    scored: bool = False


def flights_of(recording: Recording, key: str, *, shots: str = "Sim/Shots", hits: str = "Sim/Hits") -> list[ShotTrace]:
    """The shots of a run, oldest first.

    Pieces in flight are published in the order in which they were shot, and the numbers of shots and hits so far. So it
    is known how many are new in a tick and how many landed; which ones, their flight so far tells. A piece touches the
    goal some ticks before it counts: a hit is the oldest flight that ended above the floor within the last seconds.

    Args:
        recording: The run.
        key: Poses of pieces in flight.
        shots: The number of shots so far.
        hits: The number of those that scored so far.
    """
    if not (recording.has(key) and recording.has(shots) and recording.has(hits)):
        return []
    times = recording.array_times(key)
    new, scored = (_increments(recording, name, times) for name in (shots, hits))
    flying: list[_Flight] = []
    landed: list[_Flight] = []
    for time, fresh, hit in zip(times.tolist(), new, scored, strict=True):
        places = recording.array_at(key, time)[:, :3]
        known = max(0, len(places) - fresh)
        gone = _landed([flight.points for flight in flying], places[:known])
        for index in gone:
            flying[index].end = time
            landed.append(flying[index])
        flying = [flight for index, flight in enumerate(flying) if index not in gone]
        for flight, place in zip(flying, places, strict=False):
            flight.points.append(place)
        flying += [_Flight(time, [place]) for place in places[len(flying) :]]
        recent = [f for f in landed if not f.scored and time - f.end < _ROLLS_IN and f.points[-1][2] > _FLOOR]
        for flight in recent[:hit]:
            flight.scored = True
    return [
        ShotTrace(points=np.array(flight.points), scored=flight.scored, time=flight.start)
        for flight in sorted([*landed, *flying], key=lambda flight: flight.start)
    ]


def _increments(recording: Recording, name: str, times: FloatArray) -> list[int]:
    """By how much a count rose until each of these times, since the one before."""
    at, count = recording.series(name)
    rows = np.clip(np.searchsorted(at, times + 1e-9) - 1, 0, None)
    return [round(rise) for rise in np.diff(count[rows], prepend=0.0).tolist()]


def _landed(flights: list[list[FloatArray]], places: FloatArray) -> tuple[int, ...]:
    """Which of the flights, in their order, have no place any more."""
    missing = len(flights) - len(places)
    if missing <= 0:
        return ()
    expected = np.array([2.0 * points[-1] - points[-2] if len(points) > 1 else points[-1] for points in flights])
    best, least = tuple(range(missing)), np.inf
    for tried, gone in enumerate(combinations(range(len(flights)), missing)):
        if tried > _MOST_TRIED:
            break
        error = float(np.square(np.delete(expected, gone, axis=0) - places).sum())
        if error < least:
            best, least = gone, error
    return best


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
