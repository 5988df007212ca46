"""Trails of pieces in flight, each followed by its id, for a view of what happens now."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from simcore.telemetry.snapshot import Snapshot
from simcore.typing import FloatArray

__all__ = ["FlightTrails"]

_FLYING, _IDS = "Sim/InFlight/", "Sim/InFlightIds/"
_PAUSE = 0.5  # [s] without a look, after which trails begin anew


@dataclass(slots=True)
class _Trail:
    times: list[float] = field(default_factory=list)
    points: list[FloatArray] = field(default_factory=list)


class FlightTrails:
    """The last part of each flight, also for a while after its end.

    Args:
        keep: How long a trail stays after its piece was there [s].
    """

    def __init__(self, *, keep: float = 1.5) -> None:
        self._keep = keep
        self.clear()

    def clear(self) -> None:
        """Forget all, e.g. after a jump in time."""
        self._flying: dict[tuple[str, int], _Trail] = {}
        self._ended: list[_Trail] = []
        self._time = -np.inf

    def update(self, snapshot: Snapshot) -> None:
        """Note where pieces in flight are now; those of a log that gives them no ids leave no trail."""
        time = snapshot.time
        if time == self._time:
            return
        if not self._time < time <= self._time + _PAUSE:
            self.clear()
        self._time = time
        before, self._flying = self._flying, {}
        for key, rows in snapshot.pose_arrays.items():
            if not key.startswith(_FLYING):
                continue
            ids = snapshot.integer_arrays.get(key.replace(_FLYING, _IDS))
            for piece, row in zip([] if ids is None else ids.tolist(), rows, strict=False):
                trail = before.pop((key, piece), None) or _Trail()
                trail.times.append(time)
                trail.points.append(row[:3])
                self._flying[key, piece] = trail
        self._ended = [trail for trail in (*self._ended, *before.values()) if time - trail.times[-1] < self._keep]

    def segments(self, time: float) -> FloatArray:
        """Pieces of line of the last `keep` seconds before a time [m], shape (m, 2, 3)."""
        lines = []
        for trail in (*self._ended, *self._flying.values()):
            first = next((i for i, then in enumerate(trail.times) if time - then < self._keep), len(trail.times))
            points = trail.points[first:]
            if len(points) > 1:
                array = np.array(points)
                lines.append(np.stack((array[:-1], array[1:]), axis=1))
        return np.concatenate(lines) if lines else np.zeros((0, 2, 3))
