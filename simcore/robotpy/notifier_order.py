"""Notifiers of robot code in a defined order, in simulated time.

Each `wpilib.Notifier` is a thread. Where alarms of several fall on one instant, or on that of the robot's loop, the
operating system chooses who runs first. So the n-th that is started comes n microseconds late: whoever steps time lets
one alarm run to its end before the next, and the order is that of their starts, after the robot's loop.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any
from weakref import WeakKeyDictionary, ref

from wpilib import Notifier, Timer

__all__ = ["order_notifiers"]

_APART = 1e-6  # [s]; the resolution of the FPGA's clock
_MOST = 900  # notifiers; then their alarms would reach the next millisecond
_ROUND = 0.4e-6  # [s]; the alarm is cut to whole microseconds

_build, _start_single, _stop, _set_callback = (
    Notifier.__init__,
    Notifier.startSingle,
    Notifier.stop,
    Notifier.setCallback,
)


class _Schedule:
    """When a notifier comes next."""

    def __init__(self, notifier: Any, callback: Callable[[], object]) -> None:
        self.callback = callback
        self.period: float | None = None
        self._notifier = ref(notifier)  # whoever lets go of a notifier ends it
        self._late: float | None = None
        self._next = 0.0

    def start(self, delay: float, period: float | None) -> None:
        """Set the first alarm, `delay` from now [s], and the time between further ones [s]."""
        if self._late is None:
            self._late = (next(_numbers) % _MOST) * _APART
        self.period = period
        self._next = Timer.getFPGATimestamp() + delay + self._late
        self._arm()

    def run(self) -> None:
        """The alarm: the next one is set before the callback runs, which may stop it."""
        if self.period is not None:
            self._next += self.period
            self._arm()
        self.callback()

    def _arm(self) -> None:
        notifier = self._notifier()
        if notifier is not None:
            _start_single(notifier, self._next - Timer.getFPGATimestamp() + _ROUND)


_schedules: WeakKeyDictionary[Any, _Schedule] = WeakKeyDictionary()
_numbers = itertools.count(1)


def order_notifiers() -> None:
    """Let notifiers that are built from now on run in the order in which they are started."""
    global _numbers
    _numbers = itertools.count(1)
    if Notifier.__init__ is not _build:
        return

    def init(self: Any, callback: Callable[[], object]) -> None:
        schedule = _Schedule(self, callback)
        _build(self, schedule.run)
        _schedules[self] = schedule

    def start_single(self: Any, delay: float) -> None:
        _schedules[self].start(float(delay), None)

    def start_periodic(self: Any, period: float) -> None:
        _schedules[self].start(float(period), float(period))

    def stop(self: Any) -> None:
        _schedules[self].period = None
        _stop(self)

    def set_callback(self: Any, callback: Callable[[], object]) -> None:
        _schedules[self].callback = callback

    for name, function in (
        ("__init__", init),
        ("startSingle", start_single),
        ("startPeriodic", start_periodic),
        ("stop", stop),
        ("setCallback", set_callback),
    ):
        setattr(Notifier, name, function)
