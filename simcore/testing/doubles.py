"""Test doubles for simcore's inputs."""

from __future__ import annotations

from simcore.quantities import Quantity, require
from simcore.telemetry.sinks import MemorySink

__all__ = ["ManualClock", "MemorySink"]


class ManualClock:
    """Clock that moves only by `advance`, for use as a supplier of time.

    >>> clock = ManualClock()
    >>> clock.advance(0.02)
    >>> clock()
    0.02
    """

    def __init__(self, time: float = 0.0) -> None:
        """Start at this time [s]."""
        self.time = time

    def __call__(self) -> float:
        """Return the present time [s]."""
        return self.time

    def advance(self, seconds: float) -> None:
        """Advance the time [s].

        Raises:
            ConfigError: If the amount is negative or not finite.
        """
        require("ManualClock", "seconds", seconds, Quantity("s", 0.0, 1e6))
        self.time += seconds
