"""Watchdog that ends a robot test if the program blocks the clock, and reports the blocking source line.

A step of WPILib's clock blocks in native code until a thread waits on every notifier again. The step blocks forever if
the program waits in the robot loop, or if no thread waits on a notifier.

The time limit counts CPU time while the process works, and wall time while the process waits. A slow or busy computer
therefore does not end a test.
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
"""Text in the report if no thread is executing a source line of the program."""

_STANDARD = sysconfig.get_path("stdlib")
_LOOK = 0.25  # time between two checks [s]
_WORKS = 0.1  # processor load above which the process counts as working instead of waiting [-]
_UNSEEN = 10.0  # factor on the patience outside program code, e.g. while a slow computer builds a field [-]

_unwaited: dict[int, str] = {}
"""Source line that created a notifier on which no thread has waited yet, by notifier handle; empty for library code."""


@functools.cache
def watch_notifiers() -> None:
    """Start recording the source lines that create HAL notifiers.

    A record ends when a thread waits on the notifier, or when the notifier is stopped or cleaned.
    """
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
    """Return the source line of the program in the first stack that contains program code, as "FILE:LINE in FUNCTION".

    Args:
        frames: Innermost frame of each stack to search.

    Returns:
        Text for the innermost program frame; empty if no stack contains program code.
    """
    for frame in frames:
        for at, line in traceback.walk_stack(frame):
            if is_of_program(at.f_code) and not at.f_code.co_filename.startswith(_STANDARD):
                return f"{Path(at.f_code.co_filename).name}:{line} in {at.f_code.co_name}"
    return ""


class HangWatch:
    """Watchdog thread that reports the cause and ends the process if an expected event takes too long.

    Args:
        patience: Time limit, in CPU time while the process works and in wall time while the process waits [s].
        where: Function that returns the source line that the program is executing, or an empty text if the process is
            not executing program code.
        complaints: Stream for the report.
    """

    def __init__(self, patience: float, where: Callable[[], str], complaints: TextIO) -> None:
        self._patience = patience
        self._where = where
        self._complaints = complaints
        self._awaited = ""
        self._taken = 0.0
        threading.Thread(target=self._watch, daemon=True, name="simcore's watch").start()

    def arm(self, awaited: str) -> None:
        """Start the time limit for an event.

        Args:
            awaited: Start of the report, for example "no robot loop has finished".
        """
        self._taken = 0.0
        self._awaited = awaited

    def disarm(self) -> None:
        """Stop the time limit, because the event has occurred."""
        self._awaited = ""

    def sentence(self) -> str:
        """Return the sentence that reports the missing event and its cause."""
        if _unwaited:
            place = next(iter(_unwaited.values())) or "a library"
            return (
                f"the clock stands still, because of a notifier on which no thread waits: initializeNotifier at {place}"
                "; wait on it (hal.waitForNotifierAlarm) in a thread, or use wpilib.Notifier"
            )
        return (
            f"{self._awaited} in {self._taken:.0f} s: the program is at {self._where() or NO_LINE}. Until then "
            "simulated time stands still and nothing moves, so waiting there never ends; continue in the next loop "
            "(simcore_hang in pytest.ini gives slow loops more time)"
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
        """Add the time between two checks to the time taken: CPU time [s] while the process works, else wall time [s].

        The wall time counts at most 0.25 s, because a late check means that the process waited for a processor.
        """
        self._taken += min(work, wall) if work > _WORKS * wall else min(wall, _LOOK)

    def _is_over(self) -> bool:
        has_cause = bool(_unwaited) or (self._taken >= self._patience and bool(self._where()))
        return self._taken >= self._patience * (1.0 if has_cause else _UNSEEN)
