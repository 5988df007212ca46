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
    is_over = False

    def interrupt() -> None:
        with lock:
            if not is_over:
                _set_exception(thread, ctypes.py_object(TimeLimitError))

    timer = threading.Timer(seconds, interrupt)
    timer.daemon = True
    timer.start()
    if _nowhere is not None:
        faulthandler.dump_traceback_later(seconds + GRACE, exit=True, file=_nowhere)  # needs no step of Python
    try:
        yield
    except TimeLimitError:
        raise TimeLimitError(f"took longer than {seconds:g} s of wall time, and was ended") from None
    finally:
        with lock:
            is_over = True
            _set_exception(thread, None)  # one that is due would come after the run
        timer.cancel()
        if _nowhere is not None:
            faulthandler.cancel_dump_traceback_later()


def _set_exception(thread: int, error: ctypes.py_object[type[BaseException]] | None) -> None:
    """Let a thread raise an error with its next step, or not any more."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), error)
