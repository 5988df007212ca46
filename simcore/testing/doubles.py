"""Test doubles: a clock that a test advances, and a telemetry sink in memory."""

from __future__ import annotations

from simcore.quantities import Quantity, require
from simcore.telemetry.sinks import MemorySink

__all__ = ["ManualClock", "MemorySink"]


class ManualClock:
    """Time supplier for tests; the time changes only when the test calls `advance`.

    >>> clock = ManualClock()
    >>> clock.advance(0.02)
    >>> clock()
    0.02
    """

    def __init__(self, time: float = 0.0) -> None:
        """Initialize the clock with a time [s]."""
        self.time = time

    def __call__(self) -> float:
        """Return the current time [s]."""
        return self.time

    def advance(self, seconds: float) -> None:
        """Advance the clock by a duration [s].

        Raises:
            ConfigError: If the duration is negative, not finite or above 1e6 s.
        """
        require("ManualClock", "seconds", seconds, Quantity("s", 0.0, 1e6))
        self.time += seconds
