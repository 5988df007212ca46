"""Output files of a run: choice of the paths, and the handling of files that cannot be written."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from simcore.errors import ConfigError, OutputError
from simcore.match.runner import AutoRun, RunReport
from simcore.show.page import write_page
from simcore.show.scene import scene_of
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import GuardedSink, discard_empty, require_writable
from simcore.telemetry.snapshot import TelemetrySink
from simcore.telemetry.wpilog import WpilogSink

__all__ = ["RunOutputs"]

_log = logging.getLogger(__name__)
_BULK_FRAMES = 4000  # rows of pieces kept in memory, 21 MB; longer runs record pieces less often


@dataclass(slots=True, kw_only=True)
class RunOutputs:
    """Paths, sinks and recording for the log and the page of one run.

    If a file that the user named cannot be written, the run does not start. If a default file cannot be written, or if
    writing fails later, the run goes on after a message.
    """

    log: Path | None
    page: Path | None
    say: Callable[[str], None]
    """Function that prints a one-sentence message about a missing file."""
    seconds: float
    """Planned simulated duration [s]."""
    recording: Recording = field(init=False)
    _guard: GuardedSink | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self.recording = Recording(bulk_period=max(0.04, self.seconds / _BULK_FRAMES), seconds=self.seconds)

    @classmethod
    def plan(
        cls,
        folder: Path,
        name: str,
        *,
        log: Path | None,
        page: Path | None,
        seconds: float,
        say: Callable[[str], None],
    ) -> RunOutputs:
        """Choose the paths of the files, and check before the first tick that the files can be written.

        A default file that cannot be written is left out, with a message to `say`.

        Args:
            folder: Folder for files at default paths.
            name: Name of files at default paths, without suffix.
            log: Path of the log; None for the default path.
            page: Path of the page; None for the default path.
            seconds: Planned simulated duration [s].
            say: Function that prints a one-sentence message about a missing file.

        Raises:
            OutputError: If a file that the user named cannot be written.
            ConfigError: If log and page are the same file.
        """
        asked = {"log": log, "page": page}
        usual = {"log": folder / f"{name}.wpilog", "page": folder / f"{name}.html"}
        where: dict[str, Path | None] = {kind: asked[kind] or usual[kind] for kind in usual}
        if len({path.resolve() for path in where.values() if path is not None}) < len(where):
            raise ConfigError(f"log and page cannot be one file, got {str(log or page)!r} for both")
        for kind, path in asked.items():
            if path is not None:
                require_writable(kind, path)
        missing, reason = [], ""
        for kind, path in usual.items():
            if asked[kind] is None:
                try:
                    require_writable(kind, path)
                except OutputError as error:
                    where[kind] = None
                    missing.append(kind)
                    reason = str(error.__cause__ or error)
        if missing:
            say(f"cannot write to {str(folder)!r} ({reason}): the run goes on without {' and '.join(missing)}")
        return cls(**where, seconds=seconds, say=say)

    def sinks(self) -> list[TelemetrySink]:
        """Create the log file, and return the telemetry sinks for the run: the recording and the log."""
        sinks: list[TelemetrySink] = [self.recording]
        if self.log is not None:
            self._guard = GuardedSink(WpilogSink(self.log), lambda why: self.say(f"{why}. The run goes on"))
            sinks.append(self._guard)
        return sinks

    def write(self, run: AutoRun) -> dict[str, str]:
        """Write the page after the run, and return the paths of all written files by kind (`log`, `page`).

        If the page cannot be written, call `say` with the reason.
        """
        written: dict[str, str] = {}
        if self.log is not None and self._guard is not None and not self._guard.failure:
            written["log"] = str(self.log)
        if self.page is not None:
            try:
                scene = scene_of(run.match)
                write_page(self.page, self.recording, scene, title=_title(run), subtitle=_speed(run.report))
                written["page"] = str(self.page)
            except OutputError as error:
                _log.debug("no page", exc_info=True)
                discard_empty(self.page)
                self.say(f"no page: {error}")
        return written


def _title(run: AutoRun) -> str:
    report = run.report
    what = "match" if report.players else f"auto '{report.auto}', {report.alliance}"
    return f"{run.match.game.heading}, {what}, seed {report.seed}"


def _speed(report: RunReport) -> str:
    return f"computed {report.realtime_factor:.1f} times as fast as a real match"
