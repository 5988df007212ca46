"""The files that a run leaves: where they go, and what happens when they cannot."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from simcore.errors import ConfigError, OutputError
from simcore.match.runner import AutoRun, RunReport
from simcore.show.animation import animate, check_animation
from simcore.show.page import write_page
from simcore.show.picture import draw_summary
from simcore.show.raster import writable_picture
from simcore.show.scene import Scene, scene_of
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import GuardedSink, discard_empty, require_writable
from simcore.telemetry.snapshot import TelemetrySink
from simcore.telemetry.wpilog import WpilogSink

__all__ = ["RunOutputs", "draw_files"]

_log = logging.getLogger(__name__)
_BULK_FRAMES = 4000  # of pieces kept in memory: 21 MB; a longer run keeps them less often


@dataclass(slots=True, kw_only=True)
class RunOutputs:
    """Log, picture, page and animation of one run.

    A file that was asked for by name must be possible, or the run does not start. Of those that nobody asked for, and
    when a disk fails later, one sentence is said and the run goes on.
    """

    log: Path | None
    picture: Path | None
    page: Path | None
    animation: Path | None
    say: Callable[[str], None]
    """Told what is missing, in one sentence."""
    seconds: float
    """How long the run is meant to be, simulated [s]."""
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
        picture: Path | None,
        page: Path | None,
        animation: Path | bool,
        seconds: float,
        say: Callable[[str], None],
    ) -> RunOutputs:
        """Decide where everything goes, before the first tick.

        Args:
            folder: Where files go that were not asked for by name; page and animation go beside the picture.
            name: Of those, without suffix.
            log: As asked for, or None.
            picture: The same.
            page: The same.
            animation: The same; True for one of the usual name, False for none.
            seconds: How long the run is meant to be, simulated [s].
            say: Told what goes missing.

        Raises:
            OutputError: A file that was asked for cannot be written.
            ConfigError: Two of them are the same file.
        """
        asked = {"log": log, "picture": picture, "page": page}
        beside = picture or folder / f"{name}.png"
        usual = {"log": folder / f"{name}.wpilog", "picture": beside, "page": beside.with_suffix(".html")}
        where: dict[str, Path | None] = {kind: asked[kind] or usual[kind] for kind in usual}
        _refuse_doubles({**where, "animation": animation if isinstance(animation, Path) else None})
        for kind, path in asked.items():
            if kind == "picture" and path is not None:
                writable_picture(path)
            elif path is not None:
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
            say(f"cannot write to {str(folder)!r} ({reason}): the run goes on without {_listed(missing)}")
        moving = beside.with_suffix(".gif") if animation is True else animation or None
        if moving is not None:
            check_animation(moving)
        return cls(**where, animation=moving, seconds=seconds, say=say)

    def sinks(self) -> list[TelemetrySink]:
        """Who listens during the run. Creates the log."""
        sinks: list[TelemetrySink] = [self.recording]
        if self.log is not None:
            self._guard = GuardedSink(WpilogSink(self.log), lambda why: self.say(f"{why}. The run goes on"))
            sinks.append(self._guard)
        return sinks

    def write(self, run: AutoRun) -> dict[str, str]:
        """Draw everything, after the run; returns what was written, by kind."""
        written: dict[str, str] = {}
        if self.log is not None and self._guard is not None and not self._guard.failure:
            written["log"] = str(self.log)
        drawings: dict[str, tuple[Path | None, Callable[..., None]]] = {
            "picture": (self.picture, partial(draw_summary, subtitle=_result(run.report))),
            "page": (self.page, partial(write_page, subtitle=_speed(run.report))),
            "animation": (self.animation, animate),
        }
        drawn = draw_files(drawings, self.recording, scene_of(run.match), _title(run), self.say)
        return written | {kind: str(path) for kind, path in drawn.items()}


def draw_files(
    drawings: Mapping[str, tuple[Path | None, Callable[..., None]]],
    recording: Recording,
    scene: Scene,
    title: str,
    say: Callable[[str], object],
    *,
    mistakes: type[Exception] = OutputError,
) -> dict[str, Path]:
    """Draw a run as several files; one that cannot be written is said, and the others are drawn all the same.

    Args:
        drawings: By kind: its file, None for none, and what draws it.
        recording: The run.
        scene: What it took place on.
        title: Of each.
        say: Told what is missing.
        mistakes: What may go wrong; anything else is raised.

    Returns:
        What was written, by kind.
    """
    written = {}
    for kind, (path, draw) in drawings.items():
        if path is not None:
            try:
                draw(path, recording, scene, title=title)
                written[kind] = path
            except mistakes as error:
                _log.debug("no %s", kind, exc_info=True)
                discard_empty(path)
                say(f"no {kind}: {error}")
    return written


def _refuse_doubles(files: dict[str, Path | None]) -> None:
    seen: dict[Path, str] = {}
    for kind, path in files.items():
        if path is None:
            continue
        other = seen.setdefault(path.resolve(), kind)
        if other != kind:
            raise ConfigError(f"{other} and {kind} cannot be one file, got {str(path)!r} for both")


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _title(run: AutoRun) -> str:
    report = run.report
    what = "match" if report.players else f"auto '{report.auto}', {report.alliance}"
    return f"{run.match.game.heading}, {what}, seed {report.seed}"


def _result(report: RunReport) -> str:
    shots = f"{report.hits} of {report.shots} shots hit, " if report.shots else ""
    points = f"{report.score.total} points"
    if report.players:
        points = f"blue {report.score.blue}, red {report.score.red} points"
    return f"{points}, {shots}{report.distance_m:.1f} m driven, {report.sim_seconds:g} s"


def _speed(report: RunReport) -> str:
    return f"computed {report.realtime_factor:.1f} times as fast as a real match"
