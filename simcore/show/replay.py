"""A log on the page: a time slider, play, pause and speed, with the same scene as live."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from simcore.show.animation import frame_times
from simcore.show.pacing import FrameRate, Pacer
from simcore.show.view_charts import LogSignals, ViewCharts
from simcore.show.view_clip import CLIP_SECONDS, ClipButton
from simcore.show.view_models import ViewModels
from simcore.show.view_page import CHARTS, SPEEDS, ViewPage
from simcore.telemetry.snapshot import POSE_ARRAY_TYPE, POSE_TYPE, Snapshot
from simcore.telemetry.wpilog import TelemetryLog
from simcore.typing import FloatArray

__all__ = ["Replay", "can_draw", "smooth_snapshot"]

_JUMP = 1.2  # [m]
_GAP = 0.25  # [s]; a longer time without a value is rest
_FRAME = 1.0 / 30.0  # [s] of wall time
_PANEL, _EDGE = 320.0, 10.0  # width of the page's panel, and of the gap around the timeline [pixels]
# The page lets a window have a width in pixels only; this one is as wide as what the panel leaves.
_TIMELINE = f"""<style>@media (min-width: 36em) {{
[data-floating-window]:has(#simcore-timeline) {{ width: calc(100% - {_PANEL + 2 * _EDGE:.0f}px) !important; }} }}
</style><span id="simcore-timeline"></span>"""
_COVERED = 0.16  # share of the window, from below, that the timeline takes
_MAX_SPEED = 20.0  # what "max" means here: a replay has no slowest computer to wait for


def can_draw(log: TelemetryLog) -> bool:
    """Whether a log holds anything that the scene knows, e.g. `Sim/Robot/Pose3d`."""
    wanted = ("Sim/Robot/Pose3d", "Sim/Robots/", "Sim/GamePieces/")
    return any(key.startswith(wanted) and c.type in (POSE_TYPE, POSE_ARRAY_TYPE) for key, c in log.columns.items())


def smooth_snapshot(log: TelemetryLog, time: float) -> Snapshot:
    """The snapshot of a time [s], with the pieces between two logged places where they must have been.

    Long arrays are logged some twelve times a second, less often than a replay draws. Rows of one id in
    `Sim/PieceIds/<Type>` belong together; without ids rows do while their number stays the same. A row that is over
    `_JUMP` away is another piece, and stays where it was.
    """
    snapshot = log.snapshot_at(time)
    arrays = dict(snapshot.pose_arrays)
    for key, rows in arrays.items():
        if not key.startswith("Sim/GamePieces/"):
            continue
        column = log.columns[key]
        row = column.row_at(time)
        if row + 1 >= len(column):
            continue
        start, end = column.times[row : row + 2].tolist()
        if not 0.0 < end - start < _GAP:
            continue
        step = _steps(log, key, snapshot, rows, column.pose_array(row + 1), end)
        if step is None:
            continue
        near = np.abs(step).max(axis=1, initial=0.0) < _JUMP
        between = rows.copy()
        between[:, :3] += np.where(near, (time - start) / (end - start), 0.0)[:, None] * step
        arrays[key] = between
    return replace(snapshot, pose_arrays=arrays)


def _steps(
    log: TelemetryLog, key: str, snapshot: Snapshot, rows: FloatArray, after: FloatArray, end: float
) -> FloatArray | None:
    """Way of each row to its place at the time `end` [m], zero for a piece that is gone; None if no rows match."""
    id_key = key.replace("Sim/GamePieces/", "Sim/PieceIds/")
    ids = snapshot.integer_arrays.get(id_key)
    if ids is None or len(ids) != len(rows):
        return after[:, :3] - rows[:, :3] if after.shape == rows.shape else None
    column = log.columns[id_key]
    ids_after = column.integer_array(column.row_at(end))
    if len(ids_after) != len(after):
        return None
    _, before, later = np.intersect1d(ids, ids_after, assume_unique=True, return_indices=True)
    steps = np.zeros((len(rows), 3))
    steps[before] = after[later, :3] - rows[before, :3]
    return steps


class Replay:
    """Plays a log.

    Args:
        log: What to play.
        models: What to draw.
        host: Where to listen.
        port: 0 takes a free one.
        robot: Name of the robot model; empty: the first.

    Raises:
        OutputError: The extra `view` is not installed, or the port is taken.
        ConfigError: No such port.
        ModelError: A model cannot be read.
        UnknownNameError: No robot model of that name.
    """

    def __init__(
        self, log: TelemetryLog, models: ViewModels, *, host: str = "127.0.0.1", port: int = 0, robot: str = ""
    ) -> None:
        self.log = log
        self.start, self.end = log.span
        self.page = ViewPage(models, host=host, port=port, robot=robot, title=log.path.name)
        self.url = self.page.url
        self.time = self.start
        """Shown now, on the log's own clock [s]."""
        self.playing = True
        self.speed = 1.0
        self._drawn = math.nan
        self._slider_rate = FrameRate(10.0)
        self._signals = LogSignals(log)
        self._charts = ViewCharts(self.page.server, self._signals, order=CHARTS)
        ClipButton(self.page.server, self._until_now, log.path.stem, order=CHARTS - 2)
        self._build_timeline()
        self.page.on_camera = self._redraw  # type: ignore[method-assign]

    def set_playing(self, playing: bool) -> None:
        """Play or stand; at the end, play begins anew."""
        if playing and self.time >= self.end:
            self.seek(self.start)
        self.playing = playing
        self._buttons.options = ("pause" if playing else "play", *SPEEDS)

    def seek(self, time: float) -> None:
        """Show another time [s]."""
        self.time = min(max(time, self.start), self.end)
        self.page.scene.forget()

    def run(self, *, should_stop: Callable[[], bool] = lambda: False, seconds: float = math.inf) -> None:
        """Serve until `should_stop` returns true, or for so many seconds of the wall clock.

        It plays from the first viewer on.
        """
        pacer = Pacer()
        frames = 0
        while not should_stop() and frames * _FRAME < seconds:
            if self.page.has_viewers or self.time > self.start:  # a browser takes some seconds to come
                self.step(_FRAME)
            frames += 1
            pacer.wait(frames * _FRAME, should_stop=should_stop)

    def step(self, wall: float) -> None:
        """Move on by some wall time [s], and draw if there is something new."""
        if self.playing:
            self.time = min(self.time + wall * self.speed, self.end)
            if self.time >= self.end:
                self.set_playing(False)
        if self.time != self._drawn:
            self._drawn = self.time
            self.page.show(smooth_snapshot(self.log, self.time))
            self._signals.time = self.time
            self._charts.update(now=not self.playing)
            if self._slider_rate.due() or not self.playing:
                self._slider_rate.take()
                self._slider.value = round(self.time - self.start, 2)

    def close(self) -> None:
        """Stop serving."""
        self.page.close()

    # --- inside -------------------------------------------------------------------------------------------------

    def _build_timeline(self) -> None:
        """A strip along the lower edge of the window; on a phone a section of the sheet."""
        gui = self.page.server.gui
        length = max(round(self.end - self.start, 2), 0.02)
        panel = gui.add_panel(order=0.0)
        with panel.add_tab("time of the log [s]"):
            gui.add_html(_TIMELINE)
            self._slider = gui.add_slider("time", min=0.0, max=length, step=0.02, initial_value=0.0)
            self._buttons = gui.add_button_group("speed 1x", ("pause", *SPEEDS))
        panel.float(x=_EDGE, y=-_EDGE, width=600.0)
        panel.expand()
        gui.main_panel.set_width(_PANEL)
        self._slider.on_update(lambda event: self._on_slider(event.client is not None))
        self._buttons.on_click(lambda _: self._on_button(self._buttons.value))
        self.page.cameras.covered = _COVERED

    def _on_slider(self, by_user: bool) -> None:
        if by_user:
            self.seek(self.start + float(self._slider.value))

    def _on_button(self, name: str) -> None:
        if name in SPEEDS:
            self.speed = min(SPEEDS[name], _MAX_SPEED)
            self._buttons.label = f"speed {name}"
        else:
            self.set_playing(not self.playing)

    def _until_now(self) -> Iterator[Snapshot]:
        """What a clip shows: the seconds up to the time of the slider, or the first ones at the start."""
        end = max(self.time, min(self.end, self.start + CLIP_SECONDS))
        return (smooth_snapshot(self.log, time) for time in frame_times(max(self.start, end - CLIP_SECONDS), end))

    def _redraw(self) -> None:
        self._drawn = math.nan
