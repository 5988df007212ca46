"""Keep simulated time in step with the wall clock: at any speed, or paused."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable

__all__ = ["FrameRate", "Pacer"]

_NAP = 0.02  # [s]; the longest sleep, so that pause, speed and Ctrl-C act at once
_BEHIND = 0.25  # [s]; what is lost beyond this is not caught up with
_MEASURED = 1.0  # [s] of wall time over which the reached speed is a mean


class Pacer:
    """Waits until a simulated time is due.

    Args:
        speed: Simulated seconds a second.
        clock: Seconds that only go forward.
        sleep: Waits so many seconds.
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
        """Simulated seconds a second; may be changed at any time, from any thread."""
        return self._speed

    @speed.setter
    def speed(self, value: float) -> None:
        self._speed = value
        self._anchor = None
        self._passed.clear()

    @property
    def reached(self) -> float | None:
        """Simulated seconds a second, as they really went by in the last second; None while that is not known."""
        if len(self._passed) < 2:
            return None
        (start, first), (end, last) = self._passed[0], self._passed[-1]
        return (last - first) / (end - start) if end > start + 0.2 * _MEASURED else None

    def spare(self, simulated: float) -> float:
        """Return the time until a simulated time [s] is due [s]; 0 if it is, 1 while paused."""
        if self.paused:
            return 1.0
        if self._anchor is None:
            return 0.0
        return max(0.0, self._anchor[0] + (simulated - self._anchor[1]) / self._speed - self._clock())

    def wait(self, simulated: float, *, should_stop: Callable[[], bool] = lambda: False) -> None:
        """Return when the simulated time [s] is due; at once if `should_stop` returns true."""
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
        if self._passed and simulated < self._passed[-1][1]:  # another run
            self._passed.clear()
        self._passed.append((now, simulated))
        while self._passed[0][0] < now - _MEASURED and len(self._passed) > 2:
            self._passed.popleft()


class FrameRate:
    """Limit of frames a second by the wall clock, evenly spaced.

    Args:
        rate: Frames a second.
        clock: Seconds that only go forward.
    """

    def __init__(self, rate: float = 30.0, *, clock: Callable[[], float] = time.perf_counter) -> None:
        self._period, self._clock = 1.0 / rate, clock
        self._next = -math.inf

    def due(self) -> bool:
        """Return whether it is time for a frame."""
        return self._clock() >= self._next

    def take(self) -> None:
        """Record that a frame is drawn now."""
        self._next = max(self._next + self._period, self._clock())
