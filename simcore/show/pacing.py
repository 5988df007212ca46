"""Keeps simulated time in step with the wall clock: at any speed, paused, or as fast as it goes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from simcore.errors import ConfigError

__all__ = ["FrameRate", "Pacer"]

_NAP = 0.02  # [s]; the longest sleep, so that pause, speed and Ctrl-C act at once
_BEHIND = 0.25  # [s]; what is lost beyond this is not caught up with


class Pacer:
    """Waits until a simulated time is due.

    Args:
        speed: Simulated seconds a second; `inf` never waits.
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
        self.speed = speed

    @property
    def speed(self) -> float:
        """Simulated seconds a second; may be changed at any time, from any thread."""
        return self._speed

    @speed.setter
    def speed(self, value: float) -> None:
        if not value > 0.0:
            raise ConfigError(f"a speed must be > 0, got {value}")
        self._speed = value
        self._anchor = None

    def wait(self, simulated: float, *, should_stop: Callable[[], bool] = lambda: False) -> None:
        """Return when the simulated time [s] is due; at once if `should_stop` returns true."""
        while not should_stop():
            if self.paused:
                self._anchor = None
                self._sleep(_NAP)
                continue
            if math.isinf(self._speed):
                return
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


class FrameRate:
    """At most so many frames a second, by the wall clock, evenly.

    Args:
        rate: Frames a second.
        clock: Seconds that only go forward.
    """

    def __init__(self, rate: float = 30.0, *, clock: Callable[[], float] = time.perf_counter) -> None:
        if not (math.isfinite(rate) and rate > 0.0):
            raise ConfigError(f"a frame rate must be finite and > 0, got {rate}")
        self._period, self._clock = 1.0 / rate, clock
        self._next = -math.inf

    def due(self) -> bool:
        """Whether it is time for a frame."""
        return self._clock() >= self._next

    def take(self) -> None:
        """A frame is drawn now."""
        self._next = max(self._next + self._period, self._clock())
