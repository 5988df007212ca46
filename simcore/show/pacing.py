"""Pacing of simulated time by the wall clock, at a chosen speed and with pauses."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable

__all__ = ["FrameRate", "Pacer"]

_NAP = 0.02  # [s]; longest sleep, so that pause, speed and Ctrl-C act at once
_BEHIND = 0.25  # [s]; a run that is later than this does not catch up
_MEASURED = 1.0  # [s]; wall time over which the reached speed is averaged


class Pacer:
    """Pacer that waits until a simulated time is due by the wall clock.

    Args:
        speed: Simulated seconds per second of wall time [-].
        clock: Function that returns a monotonic time [s].
        sleep: Function that waits for a time [s].
    """

    def __init__(
        self,
        speed: float = 1.0,
        *,
        clock: Callable[[], float] = time.perf_counter,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._clock, self._sleep = clock, sleep
        self._speed = 1.0
        self.paused = False
        self._anchor: tuple[float, float] | None = None  # (wall, simulated)
        self._passed: deque[tuple[float, float]] = deque()
        self.speed = speed

    @property
    def speed(self) -> float:
        """Simulated seconds per second of wall time [-]; any thread may set the speed at any time."""
        return self._speed

    @speed.setter
    def speed(self, value: float) -> None:
        self._speed = value
        self._anchor = None
        self._passed.clear()

    @property
    def reached(self) -> float | None:
        """Measured simulated seconds per second of wall time, over the last second [-]; None before a measurement."""
        if len(self._passed) < 2:
            return None
        (start, first), (end, last) = self._passed[0], self._passed[-1]
        return (last - first) / (end - start) if end > start + 0.2 * _MEASURED else None

    def spare(self, simulated: float) -> float:
        """Return the wall time [s] until a simulated time [s] is due.

        The result is 0 if the time is past or the run has not been paced yet, and 1 s while the run is paused.
        """
        if self.paused:
            return 1.0
        if self._anchor is None:
            return 0.0
        return max(0.0, self._anchor[0] + (simulated - self._anchor[1]) / self._speed - self._clock())

    def wait(self, simulated: float, *, should_stop: Callable[[], bool] = lambda: False) -> None:
        """Wait until a simulated time [s] is due and the run is not paused, or until `should_stop` returns True.

        A run that is more than 0.25 s late continues at the set speed without making up for the delay.
        """
        self._measure(simulated)
        while not should_stop():
            if self.paused:
                self._anchor = None
                self._passed.clear()
                self._sleep(_NAP)
                continue
            now = self._clock()
            anchor = self._anchor
            if anchor is None or simulated < anchor[1]:
                self._anchor = (now, simulated)
                return
            rest = anchor[0] + (simulated - anchor[1]) / self._speed - now
            if rest <= 0.0:
                if rest < -_BEHIND:
                    self._anchor = (now, simulated)
                return
            self._sleep(min(rest, _NAP))

    def _measure(self, simulated: float) -> None:
        now = self._clock()
        if self._passed and simulated < self._passed[-1][1]:  # a new run has begun
            self._passed.clear()
        self._passed.append((now, simulated))
        while self._passed[0][0] < now - _MEASURED and len(self._passed) > 2:
            self._passed.popleft()


class FrameRate:
    """Rate limiter for evenly spaced frames by the wall clock.

    Args:
        rate: Largest number of frames per second [1/s].
        clock: Function that returns a monotonic time [s].
    """

    def __init__(self, rate: float = 30.0, *, clock: Callable[[], float] = time.perf_counter) -> None:
        self._period, self._clock = 1.0 / rate, clock
        self._next = -math.inf

    def due(self) -> bool:
        """Return whether a frame is due."""
        return self._clock() >= self._next

    def take(self) -> None:
        """Record that a frame has been sent, and set the time of the next frame."""
        self._next = max(self._next + self._period, self._clock())
