"""Brown-outs in words: one line when a series of them begins, with what drew the current, and a count at the end.

A reset of the roboRIO, which ends most matches, has a line of its own, every time.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping

from simcore.robot.battery import Battery

__all__ = ["BrownoutLog"]

_log = logging.getLogger(__name__)

_SERIES = 5.0  # [s]; a brown-out that comes sooner after the last one is of the same series
_MOST = 3  # consumers that are named
_LEAST = 1.0  # [A]; what draws less is not named


class BrownoutLog:
    """Notes the brown-outs of one robot as they begin, and tells of them after the tick.

    Args:
        number: Of the robot.
        battery: That is watched.
        consumers: What each consumer draws now, by name [A].
    """

    def __init__(self, number: int, battery: Battery, consumers: Callable[[], Mapping[str, float]]) -> None:
        self._number = number
        self._battery = battery
        self._consumers = consumers
        self._first = self._reset = ""  # of the present tick, in words
        self._last = -_SERIES
        battery.on_brownout, battery.on_reset = self._note, self._note_reset

    def _note(self) -> None:
        self._first = self._first or self._in_words()

    def _note_reset(self) -> None:
        self._reset = self._in_words()

    def _in_words(self) -> str:
        battery = self._battery
        largest = sorted(self._consumers().items(), key=lambda one: -one[1])[:_MOST]
        named = ", ".join(f"{name} {amps:.0f} A" for name, amps in largest if amps > _LEAST)
        return f"{battery.voltage:.1f} V with {battery.current:.0f} A" + (f", {named}" if named else "")

    def after_tick(self, time: float) -> None:
        """Tell of a reset, and of a series that has begun, in a tick that ended at a time [s]."""
        if self._reset:
            _log.warning(
                "robot %d: roboRIO reset at %.1f s: %s; no motor runs for %.0f s",
                *(self._number, time, self._reset, self._battery.config.reboot_time),
            )
            self._reset = ""
        if not self._first:
            return
        if time - self._last >= _SERIES:
            _log.warning(
                "robot %d: brown-out at %.1f s: %s; motors are off until %.1f V are back",
                *(self._number, time, self._first, self._battery.config.recovered_voltage),
            )
        self._first, self._last = "", time

    def tell_total(self) -> None:
        """At the end of a run: how many there were, if any."""
        battery = self._battery
        if battery.brownouts:
            resets = f", {battery.resets} resets of the roboRIO" if battery.resets else ""
            _log.warning(
                "robot %d: %d brown-outs%s in this run, %.2f s without motors; lowest %.1f V",
                *(self._number, battery.brownouts, resets, battery.off_time, battery.min_voltage),
            )
