"""Says that a robot on the wall clock is late: one sentence now and then, with how much in between."""

from __future__ import annotations

import logging
import time

__all__ = ["LatenessReport"]

_log = logging.getLogger(__name__)

_EVERY = 10.0  # [s]
_MOST_MS = 15.0  # [ms]; robot code needs some of a tick's 20 ms, too
_AT_START = 2.0  # [s]; while a program starts every computer is late, and nothing moves yet


class LatenessReport:
    """Adds up the time that physics gives up, and says so at most every ten seconds of wall time.

    Args:
        every: Wall time between two sentences [s].
        start: Wall time in which nothing is said [s].
    """

    def __init__(self, *, every: float = _EVERY, start: float = _AT_START) -> None:
        self._every = every
        self._start = start
        self.given_up = 0.0
        """Since the last sentence [s]."""
        self._since = time.monotonic()
        self._is_first = True

    def note(self, seconds: float, *, tick_ms: float) -> None:
        """Physics has just skipped a time.

        Args:
            seconds: How much [s].
            tick_ms: What a tick of physics alone takes, of the 20 ms that it has [ms].
        """
        now = time.monotonic()
        if self._is_first and now - self._since < self._start:
            return
        self.given_up += seconds
        if not self._is_first and now - self._since < self._every:
            return
        why = "the computer is busy with other programs or robot code blocks"
        if tick_ms > _MOST_MS:
            why = f"the computer is too slow: physics alone takes {tick_ms:.0f} ms for a tick of 20 ms"
        _log.warning(
            "this run is late: %.2f s of the last %.0f s are missing from the physics, because %s; do not judge times "
            "by it (robot tests do not mind)",
            *(self.given_up, max(1.0, now - self._since), why),
        )
        self._is_first = False
        self.given_up = 0.0
        self._since = now
