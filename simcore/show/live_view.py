"""The view of a run as it happens: the run's sink, its pace, and the buttons that pause, slow down and restart it."""

from __future__ import annotations

import time
from collections.abc import Callable

from simcore.show.pacing import FrameRate, Pacer
from simcore.show.view_models import ViewModels
from simcore.show.view_page import SPEEDS, ViewPage
from simcore.telemetry.snapshot import Snapshot, TelemetrySink

__all__ = ["LiveView"]


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
    ) -> None:
        self.page = ViewPage(models, host=host, port=port, robot=robot, title=title)
        self.url = self.page.url
        self.pacer = Pacer()
        self._rate = FrameRate(rate)
        self._restart: int | None = None
        gui = self.page.server.gui
        self._state = gui.add_markdown("running")
        self._pause = gui.add_button("pause")
        self._speed = gui.add_dropdown("speed", tuple(SPEEDS), initial_value="1x")
        self._seed = gui.add_number("seed", seed, min=0, step=1)
        self._again = gui.add_button("restart with this seed")
        self._pause.on_click(lambda _: self.set_paused(not self.pacer.paused))
        self._speed.on_update(lambda _: self._set_speed())
        self._again.on_click(lambda _: self.restart(int(self._seed.value)))

    def sink(self) -> TelemetrySink:
        """What a run writes to; each run gets its own, the page stays when it is closed."""
        return _ViewSink(self)

    def after_tick(self, simulated: float, *, should_stop: Callable[[], bool] = lambda: False) -> None:
        """Wait until the next tick is due, by the speed or the pause chosen on the page."""
        self.pacer.wait(simulated, should_stop=lambda: should_stop() or self.wants_restart)

    @property
    def wants_restart(self) -> bool:
        """Whether the run should end for another one."""
        return self._restart is not None

    def restart(self, seed: int) -> None:
        """Request another run."""
        self.set_paused(False)
        self._restart = seed

    def set_paused(self, paused: bool) -> None:
        """Stop or go on."""
        self.pacer.paused = paused
        self._pause.label = "go on" if paused else "pause"

    def next_seed(self, last: Snapshot, *, should_stop: Callable[[], bool] = lambda: False) -> int | None:
        """Show how a run ended and wait for a restart; its seed, or None when `should_stop` returns true first."""
        if not self.wants_restart:
            self.page.show(last)
            self._state.content = "the run is over"
        while not self.wants_restart:
            if should_stop():
                return None
            time.sleep(0.05)
        seed, self._restart = self._restart, None
        self._state.content = "running"
        self.page.scene.forget()
        return seed

    def close(self) -> None:
        """Stop serving."""
        self.page.close()

    def _set_speed(self) -> None:
        self.pacer.speed = SPEEDS[self._speed.value]


class _ViewSink:
    """Hands snapshots of one run to the page, some thirty a second of the wall clock."""

    def __init__(self, view: LiveView) -> None:
        self._view = view
        self._closed = False

    def due(self, time: float) -> bool:
        """Whether the page wants a frame; the simulated time does not matter."""
        return not self._closed and self._view._rate.due()

    def write(self, snapshot: Snapshot) -> None:
        """Show it."""
        self._view._rate.take()
        self._view.page.show(snapshot)

    def close(self) -> None:
        """The run is over."""
        self._closed = True
