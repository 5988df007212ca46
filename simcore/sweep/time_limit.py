"""Ends a run that takes too long: with an exception where Python still runs, else with its process."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from simcore.errors import SimcoreError

__all__ = ["GRACE", "TimeLimitError", "be_worker", "time_limit"]

GRACE = 5.0
"""Wall time after the limit in which an exception must have ended a run, before its worker ends itself [s]."""

_STEPS = 100  # of Python code, within which an exception that is due comes

_nowhere: TextIO | None = None


def be_worker() -> None:
    """Let `time_limit` end this process where nothing else helps: others play on."""
    global _nowhere
    _nowhere = _nowhere or open(os.devnull, "w")


class TimeLimitError(SimcoreError, TimeoutError):
    """A run took longer than it may."""


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Raise in the calling thread when a time is over.

    The exception comes between two steps of Python code. Where none comes by, as in a library that hangs, a worker
    (`be_worker`) ends after `GRACE` more.

    Args:
        seconds: Wall time [s]; None: no limit.

    Raises:
        TimeLimitError: It is over.
    """
    if seconds is None:
        yield
        return
    thread = threading.get_ident()
    lock = threading.Lock()
    is_over = is_due = False

    def interrupt() -> None:
        nonlocal is_due
        with lock:
            if not is_over:
                is_due = True
                _raise_in(thread, TimeLimitError)

    timer = threading.Timer(seconds, interrupt)
    timer.daemon = True
    timer.start()
    if _nowhere is not None:
        faulthandler.dump_traceback_later(seconds + GRACE, exit=True, file=_nowhere)  # needs no step of Python
    try:
        try:
            yield
        finally:
            with lock:
                is_over = True
        if is_due:  # not taken back: CPython 3.11 then looks for it for good, and hangs under a profiler or debugger
            for _ in range(_STEPS):
                pass
    except TimeLimitError:
        raise TimeLimitError(f"took longer than {seconds:g} s of wall time, and was ended") from None
    finally:
        timer.cancel()
        if _nowhere is not None:
            faulthandler.cancel_dump_traceback_later()


def _raise_in(thread: int, error: type[BaseException]) -> None:
    """Let a thread raise an error with its next step."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(error))
