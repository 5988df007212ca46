"""Snapshots kept in memory: for tests, pictures and notebooks."""

from __future__ import annotations

from collections import deque

from simcore.errors import ConfigError, UnknownNameError
from simcore.telemetry.cadence import Cadence
from simcore.telemetry.snapshot import Snapshot

__all__ = ["MemorySink"]


class MemorySink:
    """Keeps snapshots, the newest last; still readable after `close`.

    >>> sink = MemorySink(capacity=2)
    >>> for tick in range(3):
    ...     sink.write(Snapshot(time=0.02 * (tick + 1), tick=tick, doubles={"height": float(tick)}))
    >>> sink.series("height")
    ([0.04, 0.06], [1.0, 2.0])
    """

    def __init__(self, *, period: float | None = None, capacity: int | None = None) -> None:
        """Choose how much is kept.

        Args:
            period: Simulated time between two snapshots [s]; None takes every tick.
            capacity: The newest so many are kept; None keeps all (504 pieces at 50 Hz are 1.4 MB a second).

        Raises:
            ConfigError: A period that is not finite and > 0, or a capacity below 1.
        """
        if capacity is not None and capacity < 1:
            raise ConfigError(f"MemorySink: capacity must be at least 1 or None, got {capacity}")
        self.snapshots: deque[Snapshot] = deque(maxlen=capacity)
        self.closed = False
        self._cadence = None if period is None else Cadence(period)

    def due(self, time: float) -> bool:
        """Whether a snapshot of this simulated time [s] is wanted; never after `close`."""
        return not self.closed and (self._cadence is None or self._cadence.due(time))

    def write(self, snapshot: Snapshot) -> None:
        """Keep one snapshot."""
        if self._cadence is not None:
            self._cadence.take(snapshot.time)
        self.snapshots.append(snapshot)

    def close(self) -> None:
        """Take no more; what was kept stays."""
        self.closed = True

    def series(self, key: str) -> tuple[list[float], list[float]]:
        """Times [s] and values of one number or boolean, as far as it was published.

        Raises:
            UnknownNameError: No kept snapshot has a number of that key.
        """
        times: list[float] = []
        values: list[float] = []
        known: set[str] = set()
        for snapshot in self.snapshots:
            for kind in (snapshot.doubles, snapshot.integers, snapshot.booleans):
                known.update(kind)
                if key in kind:
                    times.append(snapshot.time)
                    values.append(float(kind[key]))
        if not times:
            raise UnknownNameError("telemetry number", key, known)
        return times, values
