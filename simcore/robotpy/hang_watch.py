"""Ends a robot test whose program keeps the clock from going on: one sentence, with the program's line.

Whoever steps WPILib's clock waits, in native code, until every notifier is waited for again. A program that waits in a
loop of its own, or a notifier that nobody ever waits on, keeps it there for ever.
"""

from __future__ import annotations

import functools
import math
import os
import sys
import sysconfig
import threading
import time
import traceback
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TextIO

from simcore import season
from simcore.devices.simulation_questions import is_of_program

__all__ = ["HangWatch", "program_line", "watch_notifiers"]

_STANDARD = sysconfig.get_path("stdlib")
_LOOK = 0.25  # [s] between two looks

_unwaited: dict[int, str] = {}
"""By notifier that nobody has waited on so far: the program's line that has made it."""


@functools.cache
def watch_notifiers() -> None:
    """Note from now on who makes a notifier of the HAL, until somebody waits on it; again is harmless."""
    hal, names = season.hal, ("initialize_notifier", "wait_for_notifier_alarm", "stop_notifier", "clean_notifier")
    make, *ends = (season.own_name(hal, name) for name in names)
    initialize = getattr(hal, make)

    def initialize_notifier(*args: Any) -> Any:
        answer = initialize(*args)
        _unwaited[answer[0] if isinstance(answer, tuple) else answer] = program_line([sys._getframe(1)])
        return answer

    def noticed(call: Callable[..., Any], handle: Any, *args: Any) -> Any:
        _unwaited.pop(handle, None)
        return call(handle, *args)

    setattr(hal, make, initialize_notifier)
    for name in ends:
        setattr(hal, name, functools.partial(noticed, getattr(hal, name)))


def program_line(frames: Iterable[Any]) -> str:
    """Return the innermost line of the program in the first of these stacks that has one; else nothing."""
    for frame in frames:
        for at, line in traceback.walk_stack(frame):
            if is_of_program(at.f_code) and not at.f_code.co_filename.startswith(_STANDARD):
                return f"{Path(at.f_code.co_filename).name}:{line} in {at.f_code.co_name}"
    return ""


class HangWatch:
    """Ends the process where what it is armed for takes too long.

    Args:
        patience: Wall time that is allowed [s].
        where: Says which line of the program is at work.
        complaints: Where the sentence goes.
    """

    def __init__(self, patience: float, where: Callable[[], str], complaints: TextIO) -> None:
        self._patience = patience
        self._where = where
        self._complaints = complaints
        self._until = math.inf
        threading.Thread(target=self._watch, daemon=True, name="simcore's watch").start()

    def arm(self) -> None:
        """Begin to wait for what comes now."""
        self._until = time.monotonic() + self._patience

    def disarm(self) -> None:
        """It has come."""
        self._until = math.inf

    def sentence(self) -> str:
        """Say what the clock waits for."""
        if _unwaited:
            place = next(iter(_unwaited.values())) or "a library"
            return (
                f"the clock stands still, because of a notifier that nobody waits on: initializeNotifier at {place}; "
                "wait on it (hal.waitForNotifierAlarm) in a thread, or use wpilib.Notifier"
            )
        return (
            f"no robot loop has come to its end in {self._patience:g} s of wall time: the program is at "
            f"{self._where()}. While a loop runs no time goes by and nothing moves, so waiting "
            "there never ends; go on in the next loop (simcore_hang in pytest.ini allows slow ones more)"
        )

    def _watch(self) -> None:
        while time.monotonic() < self._until:
            time.sleep(_LOOK)
        self._complaints.write(f"\nrobot test ended: {self.sentence()}\n")
        self._complaints.flush()
        os._exit(1)
