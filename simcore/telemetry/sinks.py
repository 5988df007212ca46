"""Snapshots kept in memory, and what sinks share: a rate, a guard against full disks, checks of files."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from simcore.errors import OutputError
from simcore.quantities import DURATION, require
from simcore.telemetry.snapshot import Snapshot, TelemetrySink

__all__ = ["Cadence", "GuardedSink", "MemorySink", "discard_empty", "output_error", "require_writable", "write_text"]


class MemorySink:
    """Snapshots of every tick in a list, for tests; a `Recording` keeps whole matches."""

    def __init__(self) -> None:
        self.snapshots: list[Snapshot] = []
        """Snapshots in order; still readable after `close`."""
        self.closed = False

    def due(self, time: float) -> bool:
        """Return whether a snapshot of this simulated time [s] is wanted; never after `close`."""
        return not self.closed

    def write(self, snapshot: Snapshot) -> None:
        """Keep one snapshot."""
        self.snapshots.append(snapshot)

    def close(self) -> None:
        """Take no more; may be called twice."""
        self.closed = True


class Cadence:
    """Due once in every slot of `period` simulated seconds, without drift when ticks and slots do not divide.

    A jump of time, also backwards after a restart, is a new slot.

    >>> cadence = Cadence(0.05)
    >>> [t for t in (0.02, 0.04, 0.06, 0.08, 0.10, 0.12) if cadence.take(t)]
    [0.02, 0.06, 0.1]
    """

    __slots__ = ("_last", "period")

    def __init__(self, period: float) -> None:
        """Set the time between two snapshots [s]."""
        require("telemetry sink", "period", period, DURATION)
        self.period = period
        self._last: int | None = None

    def due(self, time: float) -> bool:
        """Return whether this simulated time [s] lies in a slot that was not taken yet."""
        return self._slot(time) != self._last

    def take(self, time: float) -> bool:
        """Mark the slot of this time [s] as taken; return whether it was free before."""
        slot = self._slot(time)
        free = slot != self._last
        self._last = slot
        return free

    def _slot(self, time: float) -> int:
        # 0.06 / 0.02 is 2.9999999999999996: without the margin a tick at a slot's edge would count for the one before
        return math.floor(time / self.period + 1e-6)


class GuardedSink:
    """Sink that passes snapshots to another until that one fails, e.g. on a full disk; it reports the failure once.

    Errors in the program (a key of two types) still raise: only an `OutputError` of the sink is caught.

    Args:
        sink: Sink that may fail.
        on_failure: Function called with the error message, one sentence.
    """

    def __init__(self, sink: TelemetrySink, on_failure: Callable[[str], None]) -> None:
        self.sink = sink
        self.failure = ""
        """Error message of the failed sink; empty while it works."""
        self._on_failure = on_failure

    def due(self, time: float) -> bool:
        """Return whether the sink wants the snapshot of this simulated time [s]; never after it failed."""
        return not self.failure and self.sink.due(time)

    def write(self, snapshot: Snapshot) -> None:
        """Write one snapshot to the guarded sink; report a failure instead of raising it."""
        try:
            self.sink.write(snapshot)
        except OutputError as error:
            self._fail(error)

    def close(self) -> None:
        """Close the sink; may be called twice."""
        try:
            self.sink.close()
        except OutputError as error:
            self._fail(error)

    def _fail(self, error: OutputError) -> None:
        if not self.failure:
            self.failure = str(error)
            self._on_failure(self.failure)


def output_error(kind: str, path: Path, error: OSError) -> OutputError:
    """Return the error to raise when `path`, a log or a page, cannot be written."""
    example = Path("out") / ("run.wpilog" if kind == "log" else "run.html")
    return OutputError(
        f"cannot write the {kind} {str(path)!r}: {error.strerror or error}. "
        f"Give a file in a folder that you may write to, for example {str(example)!r}"
    )


def require_writable(kind: str, path: str | Path) -> Path:
    """Make sure that a file can be written later, so that a run does not fail at its end.

    Missing folders are made; an existing file keeps its content, a missing one is not left behind.

    Args:
        kind: Kind of file, for the error: `log`, `page`.
        path: The file.

    Raises:
        OutputError: The file cannot be written, or would not be opened by its name.
    """
    path, end = Path(path), {"log": ".wpilog", "page": ".html"}.get(kind, "")
    if end and path.suffix.lower() != end:
        raise OutputError(f"cannot write the {kind} {str(path)!r}: its name must end in {end}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        existed = path.exists()
        with path.open("ab"):
            pass
        if not existed:
            path.unlink()
    except OSError as error:
        raise output_error(kind, path, error) from error
    except ValueError as error:
        raise OutputError(f"cannot write the {kind} {str(path)!r}: {error}; give a path without it") from error
    return path


def write_text(kind: str, path: Path, text: str) -> None:
    """Write a text file; missing folders are made.

    Args:
        kind: Kind of file, for the error: `page`, `table`.
        path: The file.
        text: All of it.

    Raises:
        OutputError: The file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise output_error(kind, path, error) from error


def discard_empty(path: Path) -> None:
    """Delete the empty file that a full disk leaves. Other files and devices stay."""
    try:
        if path.is_file() and path.stat().st_size == 0:
            path.unlink()
    except OSError:
        pass  # then it stays: what matters was said already
