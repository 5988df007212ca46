"""When a sink is due: a fixed rate in simulated time."""

from __future__ import annotations

import math

from simcore.errors import require_positive

__all__ = ["Cadence"]


class Cadence:
    """Due once in every slot of `period` simulated seconds, without drift when ticks and slots do not divide.

    A jump of time, also backwards after a restart, is a new slot.

    >>> cadence = Cadence(0.05)
    >>> [t for t in (0.02, 0.04, 0.06, 0.08, 0.10, 0.12) if cadence.take(t)]
    [0.02, 0.06, 0.1]
    """

    __slots__ = ("_last", "period")

    def __init__(self, period: float) -> None:
        """Set the time between two snapshots [s]."""
        require_positive("telemetry sink", "period", period, "s")
        self.period = period
        self._last: int | None = None

    def due(self, time: float) -> bool:
        """Whether this simulated time [s] lies in a slot that was not taken yet."""
        return self._slot(time) != self._last

    def take(self, time: float) -> bool:
        """Mark the slot of this time [s] as taken; whether it was still free."""
        slot = self._slot(time)
        free = slot != self._last
        self._last = slot
        return free

    def _slot(self, time: float) -> int:
        # 0.06 / 0.02 is 2.9999999999999996: without the margin a tick at a slot's edge would count for the one before
        return math.floor(time / self.period + 1e-6)
