"""Between simulated time and the time of NetworkTables."""

from __future__ import annotations

__all__ = ["NetworkClock"]


class NetworkClock:
    """Adds an offset: NetworkTables counts microseconds since some start of its own.

    Without an offset (headless) published values carry simulated time, and what robot code sends counts as sent just
    now, because its stamps are of the wall clock.

    >>> clock = NetworkClock()
    >>> clock.to_network(1.5), clock.to_simulated(123)
    (1500000, None)
    >>> clock.offset = 10.0
    >>> clock.to_network(1.5), clock.to_simulated(11_500_000)
    (11500000, 1.5)
    """

    __slots__ = ("offset",)

    def __init__(self, offset: float | None = None) -> None:
        self.offset = offset
        """Time of NetworkTables minus simulated time [s]; None: headless. Whoever runs beside a clock sets it."""

    def to_network(self, time: float) -> int:
        """Stamp of a simulated time [s], in microseconds; at least 1, because 0 means now."""
        return max(1, round(1e6 * (time + (self.offset or 0.0))))

    def to_simulated(self, stamp: int) -> float | None:
        """Simulated time [s] of a stamp [us]; None without an offset."""
        return None if self.offset is None else 1e-6 * stamp - self.offset
