"""Ends a robot test whose program keeps the clock from going on: one sentence, with the program's line.

Whoever steps WPILib's clock waits, in native code, until every notifier is waited for again. A program that waits in a
loop of its own, or a notifier that nobody ever waits on, keeps it there for ever.

The patience is counted in CPU time of this process while it works, and in wall time while it waits for something, so a
slow or busy computer ends nothing.
"""

from __future__ import annotations

import functools
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
from simcore.robotcode.program.simulation_questions import is_of_program

__all__ = ["NO_LINE", "HangWatch", "program_line", "watch_notifiers"]

NO_LINE = "no line of its own"
"""Place of a program of which `program_line` finds none."""

_STANDARD = sysconfig.get_path("stdlib")
_LOOK = 0.25  # [s] between two looks
_WORKS = 0.1  # share of a processor from which on the process works, and does not wait
_UNSEEN = 10.0  # times the patience for what is at no line of the program, as a field that a slow computer builds

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
        patience: How long that may take, in CPU time while the process works and in wall time while it waits [s].
        where: Says which line of the program is at work; empty: none.
        complaints: Where the sentence goes.
    """

    def __init__(self, patience: float, where: Callable[[], str], complaints: TextIO) -> None:
        self._patience = patience
        self._where = where
        self._complaints = complaints
        self._awaited = ""
        self._taken = 0.0
        threading.Thread(target=self._watch, daemon=True, name="simcore's watch").start()

    def arm(self, awaited: str) -> None:
        """Begin to wait for what comes now, of which the sentence says that it has not come."""
        self._taken = 0.0
        self._awaited = awaited

    def disarm(self) -> None:
        """It has come."""
        self._awaited = ""

    def sentence(self) -> str:
        """Say what the clock waits for."""
        if _unwaited:
            place = next(iter(_unwaited.values())) or "a library"
            return (
                f"the clock stands still, because of a notifier that nobody waits on: initializeNotifier at {place}; "
                "wait on it (hal.waitForNotifierAlarm) in a thread, or use wpilib.Notifier"
            )
        return (
            f"{self._awaited} in {self._taken:.0f} s: the program is at {self._where() or NO_LINE}. Until "
            "then no time goes by and nothing moves, so waiting there never ends; go on in the next loop "
            "(simcore_hang in pytest.ini allows slow ones more)"
        )

    def _watch(self) -> None:
        while True:
            wall, work = time.monotonic(), time.process_time()
            time.sleep(_LOOK)
            self._count(time.monotonic() - wall, time.process_time() - work)
            if self._awaited and self._is_over():
                break
        self._complaints.write(f"\nrobot test ended: {self.sentence()}\n")
        self._complaints.flush()
        os._exit(1)

    def _count(self, wall: float, work: float) -> None:
        """Add what passed between two looks [s]; a watch that comes late was waiting for a processor itself."""
        self._taken += min(work, wall) if work > _WORKS * wall else min(wall, _LOOK)

    def _is_over(self) -> bool:
        is_told = bool(_unwaited) or (self._taken >= self._patience and bool(self._where()))
        return self._taken >= self._patience * (1.0 if is_told else _UNSEEN)
