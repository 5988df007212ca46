"""A sink that may fail without ending the run."""

from __future__ import annotations

from collections.abc import Callable

from simcore.errors import OutputError
from simcore.telemetry.snapshot import Snapshot, TelemetrySink

__all__ = ["GuardedSink"]


class GuardedSink:
    """Hands everything to another sink until that fails, e.g. on a full disk; then says so once and takes no more.

    Mistakes of ours (a key of two types) still raise: only what the machine refuses is forgiven.

    Args:
        sink: The one that may fail.
        on_failure: Told what went wrong, in one sentence.
    """

    def __init__(self, sink: TelemetrySink, on_failure: Callable[[str], None]) -> None:
        self.sink = sink
        self.failure = ""
        """What went wrong; empty while nothing has."""
        self._on_failure = on_failure

    def due(self, time: float) -> bool:
        """Whether the sink wants the snapshot of this simulated time [s]; never after it failed."""
        return not self.failure and self.sink.due(time)

    def write(self, snapshot: Snapshot) -> None:
        """Hand over one snapshot."""
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
