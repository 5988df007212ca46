"""Functions that make the page of a run from a log file."""

from __future__ import annotations

import math
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from simcore.errors import LogError
from simcore.match.registry import find_game, installed_games, known_game
from simcore.show.failed_run import empty_scene, recorded_robots
from simcore.show.page import write_page
from simcore.show.scene import Scene, bare_scene
from simcore.show.view_models import load_models
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import require_writable
from simcore.telemetry.wpilog import TelemetryLog, read_log
from simcore.typing import FloatArray
from simcore.units import TICK

__all__ = ["game_of_log", "recorded_game", "recording_of", "scene_of_log", "write_log_page"]

_LONGEST_GAP = 60.0  # [s]
_OURS = re.compile(r"^(Sim|Robot)/")


def write_log_page(
    path: Path, *, page: Path | None = None, game: str | None = None, models: Path | None = None
) -> Path:
    """Write the page of a log, print the name of the game, and warn if the page does not show the whole log.

    Args:
        path: Path of the log.
        page: Path of the page; None for a page next to the log.
        game: Name of the game whose field the page shows; None for the game named in the log, or the newest installed
            game if the log names no game.
        models: Folder with the user's own models; None for the game's models.

    Returns:
        Path of the page.

    Raises:
        LogError: If the log cannot be read or contains no run of a simulation.
        ModelError: If the models cannot be used.
        OutputError: If the page cannot be written.
        UnknownNameError: If no game of this name is installed.
    """
    page = page or path.with_suffix(".html")
    require_writable("page", page)
    log = read_log(path)
    if log.ends_early:
        print(
            f"simcore: {path} is cut off or damaged at {log.span[1]:.2f} s; the page shows what comes before",
            file=sys.stderr,
        )
    recording = recording_of(log)
    name = find_game(game).name if game else recorded_game(recording) or next(iter(installed_games()), None)
    known_game(name, say=lambda why: print(f"simcore: {why}; the field is drawn empty", file=sys.stderr))
    print(f"{'game':9}  {name or 'none'}")
    scene = scene_of_log(recording, name)
    if models is not None:
        load_models(models)  # raises an error for invalid models, which would otherwise be drawn as boxes
        scene = scene.with_models(models)
    write_page(page, recording, scene, title=f"{name.upper()}, {path.stem}" if name else path.stem)
    return page


def recording_of(log: TelemetryLog) -> Recording:
    """Return the `Sim/` and `Robot/` columns of a log, resampled at 50 Hz; other columns are left out.

    A gap of over a minute divides the log into parts. The recording contains only the part with the most time stamps.

    Raises:
        LogError: If the log has neither a simulated robot nor simulated pieces.
    """
    columns = {key: column for key, column in log.columns.items() if _OURS.match(key)}
    if not any(key.startswith(("Sim/Robot/Pose3d", "Sim/GamePieces/")) for key in columns):
        raise LogError(
            f"the log {str(log.path)!r} has no simulated run: neither Sim/Robot/Pose3d nor Sim/GamePieces/..."
        )
    ours = replace(log, columns=columns)
    start, end = _longest_part(ours)
    first = math.ceil(start / TICK - 1e-6)
    last = max(first, math.floor(end / TICK + 1e-6))
    recording = Recording(seconds=max(1.0, end - start), bulk_period=max(0.04, (end - start) / 4000))
    times: FloatArray = TICK * np.arange(first, last + 1, dtype=np.float64)
    recording.fill(
        times,
        [
            (column.field, key, list(map(column.value, range(len(column)))), column.rows_at(times + 1e-6))
            for key, column in columns.items()  # logs round times to a microsecond
            if column.field is not None
        ],
    )
    return recording


def _longest_part(log: TelemetryLog) -> tuple[float, float]:
    """Return the start and end [s] of the part with the most time stamps between gaps of over `_LONGEST_GAP`.

    Print a message if the log has other parts.
    """
    start, end = log.span
    times = np.unique(np.concatenate([column.times for column in log.columns.values()]))
    times = times[(times >= start) & (times <= end)]
    parts = np.split(times, np.nonzero(np.diff(times) > _LONGEST_GAP)[0] + 1)
    if len(parts) < 2:
        return start, end
    part = max(parts, key=len)
    print(
        f"simcore: nothing was logged for over {_LONGEST_GAP:g} s at {len(parts) - 1} places between {start:g} and "
        f"{end:g} s; the page shows {part[0]:g} to {part[-1]:g} s",
        file=sys.stderr,
    )
    return float(part[0]), float(part[-1])


def scene_of_log(recording: Recording, game: str | None = None) -> Scene:
    """Return the scene of a recording: the field of the game, with the recorded robots.

    Args:
        recording: Recording of the run.
        game: Name of the game; None for the game named in the recording. The field of an unknown game is empty.
    """
    known = known_game(game or recorded_game(recording))
    scene = empty_scene(recording) if known is None else bare_scene(known)
    models = None if known is None else known.models
    return replace(scene, robots=[replace(look, models=models) for look in recorded_robots(recording)])


def game_of_log(log: TelemetryLog) -> str | None:
    """Return the name of the game that a log names, or None if no game is named or the game is not installed."""
    column = log.columns.get("Sim/Match/Game")
    name = str(column.value(len(column) - 1)) if column is not None and len(column) else None
    return None if known_game(name) is None else name


def recorded_game(recording: Recording) -> str | None:
    """Return the name of the game that a recording names, installed or not; None if no game is named."""
    if "Sim/Match/Game" not in recording.keys:
        return None
    return recording.strings("Sim/Match/Game")[1][-1]
