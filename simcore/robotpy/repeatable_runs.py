"""What makes two runs of a robot test equal besides its physics: seeds, one clock, and nobody's thread in between."""

from __future__ import annotations

import random
import sys
import threading
import time
import types
from pathlib import Path
from typing import Any

import numpy as np
from wpilib import Timer

__all__ = ["own_threads", "seed_generators", "use_robot_clock"]

_EPOCH = 1_700_000_000.0  # [s]; what `time.time()` reads as a test begins: some day
_SEED = 1


def seed_generators() -> None:
    """Seed `random` and `numpy.random`; generators that a program makes without a seed of its own stay as they are."""
    random.seed(_SEED)
    np.random.seed(_SEED)  # noqa: NPY002  (robot code may use it)


def _seconds() -> float:
    return float(Timer.getFPGATimestamp())


def _nanoseconds() -> int:
    return round(1e9 * Timer.getFPGATimestamp())


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
    """The module `time`, with the clocks of the robot."""

    def __getattr__(self, name: str) -> Any:
        return getattr(time, name)


_robot_time = _RobotTime("time")
for _name, _clock in _CLOCKS.items():
    setattr(_robot_time, _name, _clock)


def use_robot_clock(folder: Path) -> None:
    """Let the modules of a project that are loaded by now read the FPGA's clock where they read `time`.

    On a robot both run alike; in a test only the FPGA's is stepped. Other modules keep the computer's clock.

    Args:
        folder: Of the project.
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


_LIBRARIES = ("commands2", "cscore", "hal", "magicbot", "ntcore", "phoenix6", "pyfrc", "simcore", "wpilib", "wpiutil")


def own_threads() -> list[str]:
    """Names of the threads that the robot program has started; nobody steps them in simulated time.

    Threads of the libraries, such as those of notifiers, are not among them.
    """
    known = {threading.main_thread(), threading.current_thread()}
    return sorted(
        thread.name
        for thread in threading.enumerate()
        if thread not in known and not isinstance(thread, threading._DummyThread) and not _is_of_library(thread)
    )


def _is_of_library(thread: threading.Thread) -> bool:
    work = getattr(thread, "_target", None) or type(thread).run
    if isinstance(work, types.BuiltinFunctionType):
        return True
    return (getattr(work, "__module__", None) or "").split(".")[0] in _LIBRARIES
