"""The view of a run as it happens: the run's sink, its pace, and the buttons that pause, slow down and restart it."""

from __future__ import annotations

import html
import time
from collections.abc import Callable

from simcore.match.match import Match
from simcore.show.pacing import FrameRate, Pacer
from simcore.show.shot_preview import ShotPreview
from simcore.show.view_buttons import FieldButtons
from simcore.show.view_charts import RecentSignals, ViewCharts
from simcore.show.view_clip import ClipButton, RecentSnapshots
from simcore.show.view_driving import ViewDriving
from simcore.show.view_models import ViewModels
from simcore.show.view_page import CHARTS, SPEEDS, ViewPage
from simcore.telemetry.snapshot import Snapshot, TelemetrySink

__all__ = ["LiveView"]

_PREVIEW_TIME = 0.004  # [s] of a tick's spare time that previews of shots may take
_PREVIEW_TICKS = 5  # a run that is late spares a little time each so many ticks


class LiveView:
    """Watch one run after another on the same page.

    Args:
        models: What to draw.
        host: Where to listen.
        port: 0 takes a free one.
        robot: Name of the robot model; empty: the first.
        title: Of the page.
        seed: Shown at first.
        rate: Frames a second at most.
        driving: The person at the page, if there is a robot to drive.

    Raises:
        OutputError: The extra `view` is not installed, or the port is taken.
        ConfigError: No such port.
        ModelError: A model cannot be read.
        UnknownNameError: No robot model of that name.
    """

    def __init__(
        self,
        models: ViewModels,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        robot: str = "",
        title: str = "simcore",
        seed: int = 0,
        rate: float = 30.0,
        driving: ViewDriving | None = None,
    ) -> None:
        self.page = ViewPage(models, host=host, port=port, robot=robot, title=title, driving=driving)
        self._driving = driving
        self.url = self.page.url
        self.pacer = Pacer()
        self._rate, self._state_rate = FrameRate(rate), FrameRate(3.0)
        self._restart: int | None = None
        self._match: Match | None = None
        self._preview: ShotPreview | None = None
        self._signals = RecentSignals()
        server = self.page.server
        gui = server.gui
        self._state = gui.add_html(_state_html(["waiting for the run"]))
        self._pause = gui.add_button("pause")
        self._speed = gui.add_dropdown("speed", tuple(SPEEDS), initial_value="1x")
        self._seed = gui.add_number("seed", seed, min=0, step=1)
        self._again = gui.add_button("restart with this seed")
        self._recent = RecentSnapshots()
        ClipButton(server, self._recent, title, order=CHARTS - 2)
        self._buttons = FieldButtons(server, lambda: self.page.robot, order=CHARTS - 1)
        self._charts = ViewCharts(server, self._signals, order=CHARTS)
        self._pause.on_click(lambda _: self.set_paused(not self.pacer.paused))
        self._speed.on_update(lambda _: self._set_speed())
        self._again.on_click(lambda _: self.restart(int(self._seed.value)))

    def sink(self) -> TelemetrySink:
        """What a run writes to; each run gets its own, the page stays when it is closed."""
        return _ViewSink(self)

    def wait_for_viewer(self, *, should_stop: Callable[[], bool] = lambda: False) -> None:
        """Return when somebody looks, or `should_stop` returns true."""
        while not (self.page.has_viewers or should_stop()):
            time.sleep(0.05)

    def after_tick(self, match: Match, *, should_stop: Callable[[], bool] = lambda: False) -> None:
        """Wait until the next tick is due, by the speed or the pause chosen on the page."""
        if match is not self._match:
            self._begin(match)
        self._work_on_preview(match)
        if self._state_rate.due():
            self._say(self._progress())
        while True:
            self.pacer.wait(
                match.time, should_stop=lambda: should_stop() or self.wants_restart or self._buttons.is_pressed
            )
            if not self._buttons.is_pressed:
                return
            self._buttons.is_pressed = False
            if not self.pacer.paused:
                return  # the next tick begins with it
            match.control.before_tick()
            self.page.show(match.snapshot())
            self._say(self._progress())

    @property
    def wants_restart(self) -> bool:
        """Whether the run should end for another one."""
        return self._restart is not None

    def restart(self, seed: int) -> None:
        """Request another run."""
        self.set_paused(False)
        self._restart = max(0, seed)

    def set_paused(self, paused: bool) -> None:
        """Stop or go on."""
        self.pacer.paused = paused
        self._pause.label = "go on" if paused else "pause"
        if paused:
            self._say("paused")

    def next_seed(self, last: Snapshot, *, should_stop: Callable[[], bool] = lambda: False) -> int | None:
        """Show how a run ended and wait for a restart; its seed, or None when `should_stop` returns true first."""
        self._end()
        if not self.wants_restart:
            self.show(last)
            self._charts.update(now=True)
            self._say("the run is over: restart it here, or press Ctrl-C where it was started to leave")
        while not self.wants_restart:
            if should_stop():
                return None
            time.sleep(0.05)
        seed, self._restart = self._restart, None
        self._say("the next run begins")
        self.page.scene.forget()
        return seed

    def show(self, snapshot: Snapshot) -> None:
        """Draw a snapshot, and take its numbers into the charts."""
        self._signals.note(snapshot)
        self.page.show(snapshot)
        self._charts.update()

    def close(self) -> None:
        """Stop serving."""
        self._end()
        self.page.close()

    # --- inside -------------------------------------------------------------------------------------------------

    def _begin(self, match: Match) -> None:
        self._end()
        self._match = match
        self._buttons.attach(match)
        if any(robot.shooters for robot in match.robots):
            self._preview = ShotPreview(match)

    def _end(self) -> None:
        self._preview = self._match = None
        self.page.scene.previews = []

    def _work_on_preview(self, match: Match) -> None:
        if self._preview is None:
            return
        spare = self.pacer.spare(match.time)
        if spare > _PREVIEW_TIME or match.ticks % _PREVIEW_TICKS == 0:
            self._preview.work(min(_PREVIEW_TIME, max(0.0, 0.5 * spare)))
            self.page.scene.previews = self._preview.paths

    def _progress(self) -> str:
        if self.pacer.paused:
            return "paused"
        reached, asked = self.pacer.reached, self.pacer.speed
        if reached is None:
            return "running"
        words = f"running at <b>{reached:.2g}x</b> real time"
        return words if reached > 0.9 * asked or asked > 10.0 else f"{words}, not {asked:g}x: this computer is too slow"

    def _say(self, progress: str) -> None:
        self._state_rate.take()
        wants = None if self._driving is None else self._driving.input()
        lines = [progress] if wants is None else [progress, f"driving: {wants.device}"]
        if self._preview is not None:
            paths = self._preview.paths
            several = len(self._match.robots) > 1 if self._match is not None else False
            lines += [f"shot now{f' of robot {path.robot}' if several else ''}: {path}" for path in paths]
            lines += [] if paths else ["shot now: none, the shooter's wheels are too slow"]
        if self._buttons.result:
            lines.append(html.escape(self._buttons.result))
        self._state.content = _state_html(lines)

    def _set_speed(self) -> None:
        self.pacer.speed = SPEEDS[self._speed.value]


class _ViewSink:
    """Hands snapshots of one run to the page, some thirty a second of the wall clock."""

    def __init__(self, view: LiveView) -> None:
        self._view = view
        self._closed = False

    def due(self, time: float) -> bool:
        """Whether the page wants a frame, by the wall clock, or a clip one, by the simulated time [s]."""
        return not self._closed and (self._view._rate.due() or self._view._recent.due(time))

    def write(self, snapshot: Snapshot) -> None:
        """Show and keep it."""
        if self._view._recent.due(snapshot.time):
            self._view._recent.note(snapshot)
        if self._view._rate.due():
            self._view._rate.take()
            self._view.show(snapshot)

    def close(self) -> None:
        """The run is over."""
        self._closed = True


def _state_html(lines: list[str]) -> str:
    return (
        '<div style="padding:4px 14px;font:14px/1.5 system-ui,sans-serif" aria-live="polite">'
        f"{'<br>'.join(lines)}</div>"
    )
