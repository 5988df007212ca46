"""Telemetry sink in memory, rate limit, guard against failing sinks, and functions for output files."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from simcore.errors import OutputError
from simcore.quantities import DURATION, require
from simcore.telemetry.snapshot import Snapshot, TelemetrySink

__all__ = ["Cadence", "GuardedSink", "MemorySink", "discard_empty", "output_error", "require_writable", "write_text"]


class MemorySink:
    """Sink that keeps all snapshots in a list, for tests. Use `Recording` for whole matches."""

    def __init__(self) -> None:
        self.snapshots: list[Snapshot] = []
        """Snapshots in the order of writing, available even after `close`."""
        self.closed = False

    def due(self, time: float) -> bool:
        """Return whether the sink is open, regardless of the simulated time [s]."""
        return not self.closed

    def write(self, snapshot: Snapshot) -> None:
        """Append a snapshot to `snapshots`."""
        self.snapshots.append(snapshot)

    def close(self) -> None:
        """Close the sink, so that no further snapshot is due; a second call has no effect."""
        self.closed = True


class Cadence:
    """Rate limit: at most one event in each time slot of `period` simulated seconds, without drift.

    A jump to another slot, even backward in time after a restart, permits a new event.

    >>> cadence = Cadence(0.05)
    >>> [t for t in (0.02, 0.04, 0.06, 0.08, 0.10, 0.12) if cadence.take(t)]
    [0.02, 0.06, 0.1]
    """

    __slots__ = ("_last", "period")

    def __init__(self, period: float) -> None:
        """Initialize a rate limit with a period [s].

        Raises:
            ConfigError: If the period is not finite and > 0.
        """
        require("telemetry sink", "period", period, DURATION)
        self.period = period
        self._last: int | None = None

    def due(self, time: float) -> bool:
        """Return whether the slot of a simulated time [s] differs from the slot of the last event."""
        return self._slot(time) != self._last

    def take(self, time: float) -> bool:
        """Record an event at a simulated time [s]; return whether the event was due."""
        slot = self._slot(time)
        free = slot != self._last
        self._last = slot
        return free

    def _slot(self, time: float) -> int:
        # 0.06 / 0.02 is 2.9999999999999996: without the margin, a tick at a slot's edge would count for the last slot
        return math.floor(time / self.period + 1e-6)


class GuardedSink:
    """Sink that writes to another sink until the other sink fails, e.g. on a full disk, and then reports the failure.

    The guard catches only `OutputError`. Other errors, e.g. for a key with two types, are not caught.

    Args:
        sink: Sink that may fail.
        on_failure: Function called with the error message after the first failure.
    """

    def __init__(self, sink: TelemetrySink, on_failure: Callable[[str], None]) -> None:
        self.sink = sink
        self.failure = ""
        """Error message of the first failure of the sink; empty without a failure."""
        self._on_failure = on_failure

    def due(self, time: float) -> bool:
        """Return whether the guarded sink needs a snapshot at a simulated time [s]; always False after a failure."""
        return not self.failure and self.sink.due(time)

    def write(self, snapshot: Snapshot) -> None:
        """Write a snapshot to the guarded sink, and report a failure instead of raising an error."""
        try:
            self.sink.write(snapshot)
        except OutputError as error:
            self._fail(error)

    def close(self) -> None:
        """Close the guarded sink, and report a failure instead of raising an error."""
        try:
            self.sink.close()
        except OutputError as error:
            self._fail(error)

    def _fail(self, error: OutputError) -> None:
        if not self.failure:
            self.failure = str(error)
            self._on_failure(self.failure)


def output_error(kind: str, path: Path, error: OSError) -> OutputError:
    """Return the error for an output file that cannot be written, with an example of a path."""
    example = Path("out") / ("run.wpilog" if kind == "log" else "run.html")
    return OutputError(
        f"cannot write the {kind} {str(path)!r}: {error.strerror or error}. "
        f"Give a file in a folder that you may write to, for example {str(example)!r}"
    )


def require_writable(kind: str, path: str | Path) -> Path:
    """Check before a run that an output file can be written at the end of the run.

    The function creates missing folders. The function does not change an existing file, and does not create the file.

    Args:
        kind: Kind of file, for the error message, e.g. `log` or `page`.
        path: Path of the file.

    Returns:
        Path of the file.

    Raises:
        OutputError: If the file cannot be written, or if the suffix of a log or page is wrong.
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
    """Write a text file in UTF-8, and create missing folders.

    Args:
        kind: Kind of file, for the error message, e.g. `page` or `table`.
        path: Path of the file.
        text: Content of the file.

    Raises:
        OutputError: If the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise output_error(kind, path, error) from error


def discard_empty(path: Path) -> None:
    """Delete an empty file, e.g. after an attempt to write to a full disk; keep any other file."""
    try:
        if path.is_file() and path.stat().st_size == 0:
            path.unlink()
    except OSError:
        pass  # the file stays; the original error was reported already
