"""Conversion between simulated time and NetworkTables time."""

from __future__ import annotations

from simcore.season import clock_rate

__all__ = ["NetworkClock"]


class NetworkClock:
    """Conversion between simulated time and the NetworkTables clock, in microseconds (nanoseconds from 2027 on).

    Without an offset (headless), the timestamps of published values are simulated time. Timestamps of robot code's
    values, which are from the wall clock, then convert to None.

    >>> clock = NetworkClock()
    >>> clock.to_network(1.5) == 1.5 * clock.rate, clock.to_simulated(123)
    (True, None)
    >>> clock.offset = 10.0
    >>> clock.to_network(1.5) == 11.5 * clock.rate, clock.to_simulated(round(11.5 * clock.rate))
    (True, 1.5)
    """

    __slots__ = ("offset", "rate")

    def __init__(self, offset: float | None = None) -> None:
        self.rate = clock_rate()
        self.offset = offset
        """NetworkTables time minus simulated time [s], set by a real-time run; None in a headless run."""

    def to_network(self, time: float) -> int:
        """Return the timestamp of a simulated time [s], in ticks of `season.clock_rate`.

        The result is at least 1, because 0 means the present time in ntcore.
        """
        return max(1, round(self.rate * (time + (self.offset or 0.0))))

    def to_simulated(self, stamp: int) -> float | None:
        """Return the simulated time of a timestamp [s], or None without an offset."""
        return None if self.offset is None else stamp / self.rate - self.offset
