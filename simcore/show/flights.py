"""Flights of pieces, put together again from what was published of a run's shots."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from simcore.show.scene import ShotTrace
from simcore.telemetry.recording import Recording
from simcore.typing import FloatArray

__all__ = ["flights_of"]

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
