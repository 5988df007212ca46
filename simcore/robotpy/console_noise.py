"""Keeps a screen readable on a busy computer: that a run is late, and lines of libraries that blame the wiring, once.

CTRE's library prints two lines for each signal that came late, straight to the standard error of the process, and has
no setting for it. In simulation there is no wire: its devices are threads, which a busy computer keeps waiting.
"""

from __future__ import annotations

import faulthandler
import logging
import os
import threading
import time
from collections.abc import Iterator

__all__ = ["LatenessReport", "StaleSignals", "filter_stderr", "restore_stderr"]

_log = logging.getLogger(__name__)

_LATE_EVERY = 10.0  # [s]
_MOST_MS = 15.0  # [ms]; robot code needs some of a tick's 20 ms, too
_AT_START = 2.0  # [s]; while a program starts every computer is late, and nothing moves yet
_CHECK = "Check the CAN bus wiring, CAN bus utilization, and power to the device."
_STALE = f"CAN message is stale, data is valid but old. {_CHECK}\n".encode()
_NOT_RECEIVED = f"CAN frame not received/too-stale. {_CHECK}\n".encode()
_OF_ALL = b"\tctre::phoenix6::BaseStatusSignal::WaitForAll\n"
_EVERY = 30.0  # [s]
_END = 1.0  # [s]; what was printed last is on the screen long before


class StaleSignals:
    r"""Takes the lines of late signals out of a stream, and says so at most every thirty seconds.

    Any other line passes, also one of CTRE's library about a device that does not answer.

    >>> lines = StaleSignals()
    >>> text = _STALE + b"\ttalon fx 3 (\"rio\") Status Signal Position\n"
    >>> [line.decode()[:7] for line in lines.pass_on(text + b"another\n" + text, now=5.0)]
    ['simcore', 'another']
    """

    def __init__(self) -> None:
        self._rest = b""
        self._opening = b""
        self._left_out = 0
        self._said = -_EVERY

    def pass_on(self, data: bytes, now: float) -> Iterator[bytes]:
        """What goes to the screen of what was printed.

        Args:
            data: As it comes, cut anywhere.
            now: Time on a clock that never goes back [s].
        """
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            yield from self._pass_line(line + b"\n", now)
        if (
            self._rest
            and not self._opening
            and not any(text.startswith(self._rest) for text in (_STALE, _NOT_RECEIVED))
        ):
            yield self._rest  # a prompt, or a line in the making
            self._rest = b""

    def end(self) -> bytes:
        """What was held back, at the end of the stream."""
        return self._opening + self._rest

    def _pass_line(self, line: bytes, now: float) -> Iterator[bytes]:
        opening, self._opening = self._opening, b""
        if line in (_STALE, _NOT_RECEIVED):
            if opening:
                yield opening
            self._opening = line
        elif (opening == _STALE and line.startswith(b"\t")) or (opening == _NOT_RECEIVED and line == _OF_ALL):
            self._left_out += 1
            if now - self._said >= _EVERY:
                yield (
                    f"simcore: Phoenix 6 calls {self._left_out} CAN signal(s) stale. No wire is at fault: this "
                    "computer is too busy for its simulated devices (further lines of this are left out for "
                    f"{_EVERY:.0f} s)\n"
                ).encode()
                self._said, self._left_out = now, 0
        else:
            yield opening + line


class _Filter:
    """Between the standard error of the process and the screen."""

    def __init__(self) -> None:
        self.screen = os.dup(2)
        self._source, sink = os.pipe()
        os.dup2(sink, 2)
        os.close(sink)
        faulthandler.enable(self.screen)  # of a crash nothing must be lost on the way
        self.thread = threading.Thread(target=self._run, name="simcore-stderr", daemon=True)
        self.thread.start()

    def _run(self) -> None:
        lines = StaleSignals()
        while data := os.read(self._source, 65536):
            for text in lines.pass_on(data, time.monotonic()):
                os.write(self.screen, text)
        os.write(self.screen, lines.end())


_filter: _Filter | None = None


def filter_stderr() -> None:
    """Filter what this process prints to its standard error, from here on."""
    global _filter
    if _filter is None:
        _filter = _Filter()


def restore_stderr() -> None:
    """Print everything that is on its way, and no longer filter."""
    global _filter
    if _filter is not None:
        os.dup2(_filter.screen, 2)  # closes the pipe, so that its reader comes to the end
        _filter.thread.join(_END)
        _filter = None


class LatenessReport:
    """Adds up the time that physics gives up, and says so at most every ten seconds of wall time.

    Args:
        every: Wall time between two sentences [s].
        start: Wall time in which nothing is said [s].
    """

    def __init__(self, *, every: float = _LATE_EVERY, start: float = _AT_START) -> None:
        self._every = every
        self._start = start
        self.given_up = 0.0
        """Since the last sentence [s]."""
        self._since = time.monotonic()
        self._is_first = True

    def note(self, seconds: float, *, tick_ms: float) -> None:
        """Physics has just skipped a time.

        Args:
            seconds: How much [s].
            tick_ms: What a tick of physics alone takes, of the 20 ms that it has [ms].
        """
        now = time.monotonic()
        if self._is_first and now - self._since < self._start:
            return
        self.given_up += seconds
        if not self._is_first and now - self._since < self._every:
            return
        why = "the computer is busy with other programs or robot code blocks"
        if tick_ms > _MOST_MS:
            why = f"the computer is too slow: physics alone takes {tick_ms:.0f} ms for a tick of 20 ms"
        _log.warning(
            "this run is late: %.2f s of the last %.0f s are missing from the physics, because %s; do not judge times "
            "by it (robot tests do not mind)",
            *(self.given_up, max(1.0, now - self._since), why),
        )
        self._is_first = False
        self.given_up = 0.0
        self._since = now
