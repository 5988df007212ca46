"""Repeatable robot tests outside physics: random seeds, one clock, and a fixed order of notifiers.

Each `wpilib.Notifier` is a thread. If several notifiers, or a notifier and the robot's loop, are due at the same time,
the operating system decides the order. This module therefore delays the n-th notifier by n microseconds. Time stepping
finishes one alarm before the next alarm. Notifiers therefore run after the robot's loop, in the order of the
notifiers' first starts.
"""

from __future__ import annotations

import itertools
import math
import random
import sys
import threading
import time
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary, ref

import numpy as np

from simcore import season
from simcore.robotcode.program.recorder import after_call

Notifier = season.wpilib.Notifier
Timer = season.wpilib.Timer

__all__ = ["fastest_period", "note_threads", "order_notifiers", "seed_generators", "started_threads", "use_robot_clock"]

_EPOCH = 1_700_000_000.0  # value of `time.time()` at the start of a test, an arbitrary date [s]
_SEED = 1


def seed_generators() -> None:
    """Seed the global generators of `random` and `numpy.random`.

    The function does not seed generators that a program creates.
    """
    random.seed(_SEED)
    np.random.seed(_SEED)  # noqa: NPY002  (robot code may use it)


def _seconds() -> float:
    return float(Timer.get_monotonic_timestamp())


def _nanoseconds() -> int:
    return round(1e9 * Timer.get_monotonic_timestamp())


_CLOCKS: dict[str, Any] = {
    "time": lambda: _EPOCH + _seconds(),
    "time_ns": lambda: round(1e9 * _EPOCH) + _nanoseconds(),
    "monotonic": _seconds,
    "monotonic_ns": _nanoseconds,
    "perf_counter": _seconds,
    "perf_counter_ns": _nanoseconds,
}
_REAL = {getattr(time, name): clock for name, clock in _CLOCKS.items()}


class _RobotTime(types.ModuleType):
    """Replacement for the module `time`, with clocks that return the robot's time."""

    def __getattr__(self, name: str) -> Any:
        return getattr(time, name)


_robot_time = _RobotTime("time")
for _name, _clock in _CLOCKS.items():
    setattr(_robot_time, _name, _clock)


def use_robot_clock(folder: Path) -> None:
    """Replace the clocks of `time` with the FPGA clock in the loaded modules of a project, except the tests.

    A test steps only the FPGA clock. The project's tests and modules outside the project keep the computer's clock.

    Args:
        folder: Folder of the project.
    """
    for module in list(sys.modules.values()):
        file = getattr(module, "__file__", None)
        if not isinstance(file, str) or not _is_of_project(Path(file), folder):
            continue
        for key, value in list(vars(module).items()):
            if value is time:
                setattr(module, key, _robot_time)
            elif isinstance(value, types.BuiltinFunctionType) and value in _REAL:
                setattr(module, key, _REAL[value])


def _is_of_project(file: Path, folder: Path) -> bool:
    if not file.is_relative_to(folder):
        return False
    inside = file.relative_to(folder).parts
    return inside[0] != "tests" and "site-packages" not in inside


_LIBRARIES = (
    *("commands2", "cscore", "hal", "magicbot", "ntcore", "pathplannerlib", "phoenix6", "pyfrc", "simcore", "wpilib"),
    "wpiutil",
)
_started: list[str] = []
_start_thread = threading.Thread.start


def note_threads() -> None:
    """Start recording the names of the program's threads, including threads that are already running.

    Simulated time does not control these threads. The record excludes library threads, for example notifier threads and
    PathPlanner's thread. Simcore waits for PathPlanner's thread.
    """
    known = {threading.main_thread(), threading.current_thread()}
    _started[:] = []
    for thread in threading.enumerate():
        if thread not in known and not isinstance(thread, threading._DummyThread):
            _note_thread(thread)
    threading.Thread.start = _start_noted  # type: ignore[method-assign, assignment]


def started_threads() -> list[str]:
    """Return the sorted names of the threads recorded since the last call, including threads that have ended."""
    names, _started[:] = sorted(set(_started)), []
    return names


def _start_noted(thread: threading.Thread) -> None:
    _note_thread(thread)  # a thread deletes its target when it ends
    _start_thread(thread)


def _note_thread(thread: threading.Thread, *_: object) -> None:
    if not _is_of_library(thread):
        _started.append(thread.name)


def _is_of_library(thread: threading.Thread) -> bool:
    work = getattr(thread, "_target", None) or type(thread).run
    if isinstance(work, types.BuiltinFunctionType):
        return True
    return (getattr(work, "__module__", None) or "").split(".")[0] in _LIBRARIES


# --- the order of notifiers -------------------------------------------------------------------------------------------

_APART = 1e-6  # delay between consecutive notifiers, the resolution of the FPGA clock [s]
_MOST = 900  # largest number of different delays; more would shift alarms into the next millisecond
_ROUND = 0.4e-6  # added because the HAL truncates alarm times to whole microseconds [s]

_build, _start_single, _stop, _set_callback = (
    Notifier.__init__,
    Notifier.start_single,
    Notifier.stop,
    Notifier.set_callback,
)


class _Schedule:
    """Schedule of one notifier's alarms, delayed by the notifier's number in microseconds."""

    def __init__(self, notifier: Any, callback: Callable[[], object]) -> None:
        self.callback = callback
        self.period: float | None = None
        self._notifier = ref(notifier)  # weak, so that a notifier without an owner is deleted
        self._late: float | None = None
        self._next = 0.0

    def start(self, delay: float, period: float | None) -> None:
        """Start the alarms with a first delay [s] and the period of later alarms [s]; None for a single alarm."""
        if self._late is None:
            self._late = (next(_numbers) % _MOST) * _APART
        self.period = period
        self._next = Timer.get_monotonic_timestamp() + delay + self._late
        self._arm()

    def run(self) -> None:
        """Set the next alarm of a periodic notifier, and then run the callback, which may cancel this alarm."""
        if self.period is not None:
            self._next += self.period
            self._arm()
        self.callback()

    def _arm(self) -> None:
        notifier = self._notifier()
        if notifier is not None:
            _start_single(notifier, self._next - Timer.get_monotonic_timestamp() + _ROUND)


_schedules: WeakKeyDictionary[Any, _Schedule] = WeakKeyDictionary()
_periodic: WeakKeyDictionary[Any, float] = WeakKeyDictionary()
"""Shortest period that a robot has passed to `addPeriodic`, by robot [s]."""


def _note_periodic(robot: Any, _: object, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    call, period = (*args, *settings.values())[:2]
    if not (getattr(call, "__module__", None) or "").startswith("simcore"):
        _periodic[robot] = min(float(period), _periodic.get(robot, math.inf))


def fastest_period() -> float:
    """Return the shortest period of all running notifiers and `addPeriodic` calls [s]; infinity without a period."""
    notifiers = [schedule.period for schedule in list(_schedules.values()) if schedule.period is not None]
    return min([*notifiers, *_periodic.values()], default=math.inf)


_numbers = itertools.count(1)


def order_notifiers() -> None:
    """Make new notifiers that are due at the same time run in the order of the notifiers' first starts.

    A further call restarts the numbering of notifiers for the next robot.
    """
    global _numbers
    _numbers = itertools.count(1)
    if Notifier.__init__ is not _build:
        return
    timed = season.wpilib.TimedRobot
    after_call(timed, season.own_name(timed, "add_periodic"), _note_periodic)

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
        (season.own_name(Notifier, "start_single"), start_single),
        (season.own_name(Notifier, "start_periodic"), start_periodic),
        ("stop", stop),
        (season.own_name(Notifier, "set_callback"), set_callback),
    ):
        setattr(Notifier, name, function)
