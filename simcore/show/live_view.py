"""Live view, which sends frames of a run to web pages, paces the run, and executes commands of the pages."""

from __future__ import annotations

import json
import queue
import struct
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from simcore.errors import SimcoreError
from simcore.match.match import Match
from simcore.show.charts import value_at
from simcore.show.frames import FrameLayout, PieceKind, hanging_kinds
from simcore.show.pacing import FrameRate, Pacer
from simcore.show.page import packed, page_html
from simcore.show.run_data import Block, layout_of, report_data, scene_data
from simcore.show.run_events import board_now, counts_now, lamps_now
from simcore.show.scene import Scene, scene_of
from simcore.show.shot_preview import ShotPreview
from simcore.show.view_driving import ViewDriving
from simcore.show.view_server import ViewServer
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot, TelemetrySink

__all__ = ["LiveView"]

_FRAMES, _STATES = 60.0, 10.0  # [1/s]; largest rates by the wall clock
_PREVIEW_TIME = 0.004  # [s]; largest wall time per tick for shot previews
_PREVIEW_TICKS = 5  # [ticks]; interval at which also a late run computes previews
_MARK = 0.15 * np.array([((-1, -1, 0), (1, 1, 0)), ((-1, 1, 0), (1, -1, 0)), ((0, 0, -1), (0, 0, 1))])


class LiveView:
    """Live view that shows successive runs on one web page with controls.

    Args:
        host: Address to listen on; `0.0.0.0` also allows other computers to connect.
        port: TCP port; 0 for any free port.
        title: Title of the page.
        seed: Seed of the first run, shown on the page.
        driving: Input of the drivers at the pages; None if no robot can be driven.
        models: Folder with the user's own models; None for the game's models.

    Raises:
        OutputError: If the extra `view` is not installed or the port is in use.
        ConfigError: If the port number is invalid.
    """

    def __init__(
        self,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        title: str = "simcore",
        seed: int = 0,
        driving: ViewDriving | None = None,
        models: Path | None = None,
    ) -> None:
        self._driving, self._title, self._seed, self._models = driving, title, seed, models
        self.pacer = Pacer()
        self._frames, self._states = FrameRate(_FRAMES), FrameRate(_STATES)
        self._asked: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._restart: int | None = None
        self._runs = 0
        self._match: Match | None = None
        self._scene: Scene | None = None
        self._layout: FrameLayout | None = None
        self._kinds: list[PieceKind] = []
        self._curves: list[str] = []
        self._preview: ShotPreview | None = None
        self._greeting: list[str | bytes] = []
        self._server = ViewServer(host, port, page_html(title), lambda: self._greeting, self._take)
        self.url = self._server.url

    @property
    def has_viewers(self) -> bool:
        """Whether any page is connected."""
        return self._server.has_viewers

    def sink(self) -> TelemetrySink:
        """Return a new telemetry sink for one run. Closing the sink does not close the pages."""
        return _ViewSink(self)

    def wait_for_viewer(self, *, should_stop: Callable[[], bool] = lambda: False) -> None:
        """Wait until a page connects or `should_stop` returns True."""
        while not (self.has_viewers or should_stop()):
            time.sleep(0.05)

    def after_tick(self, match: Match, *, should_stop: Callable[[], bool] = lambda: False) -> None:
        """Update the shot previews, execute the pages' commands, and wait until the next tick is due.

        The first call with a new match begins a new run on the pages. The method returns early if `should_stop` returns
        True or a page requests a restart.
        """
        if match is not self._match:
            self._begin(match)
        self._work_on_preview(match)
        while True:
            has_acted = self._act(match)
            if has_acted and self.pacer.paused:  # show the effect of a command at once
                match.control.before_tick()
                self.show(match.snapshot(), now=True)
            self.pacer.wait(
                match.time, should_stop=lambda: should_stop() or self.wants_restart or not self._asked.empty()
            )
            if self._asked.empty():
                return

    @property
    def wants_restart(self) -> bool:
        """Whether the current run should end, because a page or `restart` has requested a new run."""
        return self._restart is not None

    def restart(self, seed: int) -> None:
        """Request a new run with a seed (at least 0), and end a pause."""
        self.pacer.paused = False
        self._restart = max(0, seed)

    def next_seed(self, recording: Recording, *, should_stop: Callable[[], bool] = lambda: False) -> int | None:
        """Show the result of a run on the pages and wait for a restart.

        Returns:
            Seed of the next run, or None if `should_stop` returns True first.
        """
        match, self._match, self._preview = self._match, None, None
        if not self.wants_restart and match is not None and self._scene is not None:
            block = Block()
            meta = report_data(recording, self._scene, block, self._kinds, self._title)
            self._say({"type": "end", "meta": meta, "data": packed(block.data)}, keep=True)
        while not self.wants_restart:
            self._act(match)
            if should_stop():
                return None
            time.sleep(0.02)
        self._seed, self._restart = self._restart or 0, None
        return self._seed

    def show(self, snapshot: Snapshot, *, now: bool = False) -> None:
        """Send a frame of a snapshot to all pages.

        Also send the values for the score board and the charts, at most ten times per second of wall time, or always if
        `now` is true.
        """
        if self._layout is None or self._scene is None:
            return
        groups = self._layout.frame(snapshot).values()
        frame = struct.pack("<d", snapshot.time) + b"".join(row.astype("<i2").tobytes() for row in groups)
        self._server.send(frame, is_frame=True)
        if now or self._states.due():
            self._states.take()
            self._say(self._state(snapshot, self._scene))

    def close(self) -> None:
        """Stop the server."""
        self._match = self._preview = None
        self._server.close()

    # --- inside -------------------------------------------------------------------------------------------------

    def _begin(self, match: Match) -> None:
        self._match, self._preview, self._runs = match, None, self._runs + 1
        if any(robot.shooters for robot in match.robots):
            self._preview = ShotPreview(match)
        scene = self._scene = scene_of(match) if self._models is None else scene_of(match).with_models(self._models)
        snapshot, kind_of = match.snapshot(), match.pieces.state.kind
        self._kinds = [
            PieceKind(supply.kind.name, np.nonzero(kind_of == number)[0], scene.look(supply.kind.name).size is None)
            for number, supply in enumerate(match.game.pieces)
        ]
        self._kinds += hanging_kinds(scene, len(match.hanging))
        self._layout, solids = layout_of(scene, self._kinds, snapshot)
        recording, block = Recording(), Block()
        recording.write(snapshot)
        meta = scene_data(scene, self._kinds, solids, block)
        meta |= report_data(recording, scene, block, self._kinds, self._title)
        self._curves = [curve.pop("key") for chart in meta["charts"] for curve in chart["curves"]]
        driving = {} if self._driving is None else self._driving.data
        camera = "free" if not driving.get("at_once") else "follow" if driving["free"] else "station"
        meta |= {
            "live": True, "facts": [], "events": [], "lamps": {}, "seed": self._seed, "run": self._runs,
            "groups": {name: {"width": width} for name, width in self._layout.widths.items()},
            "spawn": [supply.kind.name for supply in match.game.pieces],
            "people": [[action.name, action.summary] for action in match.rules.human_actions()],
            "drive": driving or {"robots": []}, "view": "both", "camera": camera,
        }  # fmt: skip
        self._greeting = []
        self._say({"type": "run", "meta": meta, "data": packed(block.data)}, keep=True)

    def _say(self, message: dict[str, Any], *, keep: bool = False) -> None:
        """Send a message to all pages, and if `keep` is true, also to pages that connect later."""
        text = json.dumps(message, separators=(",", ":"), allow_nan=False)
        if keep:
            self._greeting = [*self._greeting, text]
        self._server.send(text)

    def _state(self, snapshot: Snapshot, scene: Scene) -> dict[str, Any]:
        values = [value_at(snapshot, key) for key in self._curves]
        paths = self._preview.paths if self._preview is not None else []
        several = len(scene.robots) > 1
        says = [f"shot now{f' of robot {path.robot}' if several else ''}: {path}" for path in paths]
        results = () if self._match is None else self._match.control.results
        says += [f"{'' if results[-1].is_done else 'not done: '}{results[-1].text}"] if results else []
        wants = None if self._driving is None else self._driving.input()
        says += [] if wants is None else [f"driving: {wants.device}"]
        lines = [np.zeros((0, 2, 3))]
        for path in paths:  # solid with a cross at the end for a shot that would score, dashed for a miss
            segments = np.stack((path.points[:-1], path.points[1:]), axis=1)
            lines += [segments, path.landing + _MARK] if path.zone else [segments[::2]]
        left = snapshot.doubles.get("Sim/Match/TimeLeft")
        clock = None
        if left is not None:
            clock = {
                "left": left, "time": snapshot.doubles.get("Sim/Match/Time", snapshot.time),
                "period": snapshot.strings.get("Sim/Match/Period", ""),
                "enabled": snapshot.booleans.get("Sim/Match/Enabled", True),
                "blue": snapshot.integers.get("Sim/Score/Blue"), "red": snapshot.integers.get("Sim/Score/Red"),
            }  # fmt: skip
        return {
            "type": "state", "time": round(snapshot.time, 3), "board": board_now(snapshot, scene),
            "lamps": lamps_now(snapshot), "values": values, "says": says, "paused": self.pacer.paused, "clock": clock,
            "reached": self._pace(), "previews": np.round(np.concatenate(lines), 3).ravel().tolist(),
            "cells": counts_now(snapshot, scene),
        }  # fmt: skip

    def _pace(self) -> str:
        reached, asked = self.pacer.reached, self.pacer.speed
        if reached is None:
            return "its own pace"
        words = f"{reached:.2g}x real time"
        return words if reached > 0.9 * asked or asked > 10.0 else f"{words}, not {asked:g}x: this computer is too slow"

    def _work_on_preview(self, match: Match) -> None:
        if self._preview is None:
            return
        spare = self.pacer.spare(match.time)
        if spare > _PREVIEW_TIME or match.ticks % _PREVIEW_TICKS == 0:
            self._preview.work(min(_PREVIEW_TIME, max(0.0, 0.5 * spare)))

    # --- commands of pages --------------------------------------------------------------------------------------

    def _take(self, page: int, message: dict[str, Any] | None) -> None:
        """Receive a message of a page in the server's thread.

        Apply driving input at once, and queue commands for the thread of the run. A message of None ends driving by the
        page.
        """
        if message is None or "drive" in message:
            if self._driving is not None:
                self._driving.take(page, None if message is None else message["drive"])
        else:
            self._asked.put(message)

    def _act(self, match: Match | None) -> bool:
        """Execute the queued commands, ignore invalid commands, and return whether a command changed the field."""
        has_acted = False
        while not self._asked.empty():
            message = self._asked.get()
            what, value = message.get("do"), message.get("value")
            if what == "pause":
                self.pacer.paused = value is True
                if match is not None and self._match is not None:
                    self.show(match.snapshot(), now=True)
            elif what == "speed" and isinstance(value, int | float) and 0.05 <= value <= 100.0:
                self.pacer.speed = float(value)
            elif what == "restart":
                seed = message.get("seed")
                self.restart(seed if type(seed) is int and seed < 2**32 else 0)
            elif match is not None and self._match is not None:
                has_acted = self._act_on_field(match, what, message) or has_acted
        return has_acted

    def _act_on_field(self, match: Match, what: Any, message: dict[str, Any]) -> bool:
        try:
            match.control.do(what, {name: value for name, value in message.items() if name != "do"})
        except SimcoreError:
            return False
        return True


class _ViewSink:
    """Telemetry sink that sends up to sixty snapshots of a run per second of wall time to the pages."""

    def __init__(self, view: LiveView) -> None:
        self._view = view
        self._closed = False

    def due(self, time: float) -> bool:
        """Return whether a page is connected and a frame is due by the wall clock."""
        return not self._closed and self._view.has_viewers and self._view._frames.due()

    def write(self, snapshot: Snapshot) -> None:
        """Send a snapshot to the pages, if a frame is due."""
        if self.due(snapshot.time):
            self._view._frames.take()
            self._view.show(snapshot)

    def close(self) -> None:
        """Stop sending frames of this run."""
        self._closed = True
