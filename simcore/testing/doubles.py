"""Doubles for what simcore is handed, to use in tests."""

from __future__ import annotations

from simcore.quantities import Quantity, require
from simcore.telemetry.sinks import MemorySink

__all__ = ["ManualClock", "MemorySink"]


class ManualClock:
    """A clock that moves only when told, to hand over where a supplier of time is asked for.

    >>> clock = ManualClock()
    >>> clock.advance(0.02)
    >>> clock()
    0.02
    """

    def __init__(self, time: float = 0.0) -> None:
        """Start at this time [s]."""
        self.time = time

    def __call__(self) -> float:
        """The time now [s]."""
        return self.time

    def advance(self, seconds: float) -> None:
        """Let time pass [s].

        Raises:
            ConfigError: A negative or non-finite amount.
        """
        require("ManualClock", "seconds", seconds, Quantity("s", 0.0, 1e6))
        self.time += seconds
