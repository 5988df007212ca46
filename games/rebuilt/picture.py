"""Picture, page and animation of a run."""

from __future__ import annotations

from pathlib import Path

from games.rebuilt.runner import AutoRun
from simcore.match.report import RunReport
from simcore.show.animation import animate
from simcore.show.page import write_page
from simcore.show.picture import draw_summary
from simcore.telemetry.recording import Recording

__all__ = ["animate_run", "draw_run", "write_run_page"]


def draw_run(path: Path, run: AutoRun, recording: Recording) -> None:
    """Write a PNG of a run: the field with path, shots and fuel, and its curves.

    Raises:
        OutputError: The file cannot be written.
    """
    report = run.report
    draw_summary(path, recording, run.sim.scene(), title=_title(report), subtitle=_subtitle(report))


def write_run_page(path: Path, run: AutoRun, recording: Recording) -> None:
    """Write an HTML file that plays a run.

    Raises:
        OutputError: The file cannot be written.
    """
    report = run.report
    subtitle = f"{report.realtime_factor:.1f} x real time, tick p99 {report.tick_ms.p99:.1f} ms"
    write_page(path, recording, run.sim.scene(), title=_title(report), subtitle=subtitle)


def animate_run(path: Path, run: AutoRun, recording: Recording) -> None:
    """Write a GIF of a run, or an MP4 where ffmpeg is installed.

    Raises:
        OutputError: The file cannot be written.
    """
    animate(path, recording, run.sim.scene(), title=_title(run.report))


def _title(report: RunReport) -> str:
    return f"REBUILT, auto '{report.auto}', {report.alliance}, seed {report.seed}"


def _subtitle(report: RunReport) -> str:
    return (
        f"{report.score.total} points, {report.hits} of {report.shots} shots hit, "
        f"{report.distance_m:.1f} m driven, {report.sim_seconds:g} s"
    )
