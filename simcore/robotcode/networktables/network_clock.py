"""NetworkTables' time from simulated time."""

from __future__ import annotations

from simcore.season import clock_rate

__all__ = ["NetworkClock"]


class NetworkClock:
    """Offset between simulated time and NetworkTables' clock, which counts microseconds (since 2027 nanoseconds).

    Without an offset (headless) published values carry simulated time, and what robot code sends counts as sent just
    now, because its stamps are of the wall clock.

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
        """NetworkTables' time minus simulated time [s]; None: headless. Whatever runs on a real clock sets it."""

    def to_network(self, time: float) -> int:
        """Return the stamp of a simulated time [s], by `season.clock_rate`; at least 1, because 0 means now."""
        return max(1, round(self.rate * (time + (self.offset or 0.0))))

    def to_simulated(self, stamp: int) -> float | None:
        """Return the simulated time [s] of a stamp; None without an offset."""
        return None if self.offset is None else stamp / self.rate - self.offset
