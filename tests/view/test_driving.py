"""A person drives from the page of a real browser: by keys and by a gamepad, and never from another website."""

from __future__ import annotations

import json
import math
import sys
import threading
import time
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from games.rebuilt import REBUILT
from simcore import Match, RobotEntry
from simcore.players.driven_robot import HandedOver
from simcore.players.lineup import entries, lineup, take_seats
from simcore.show.live_view import LiveView
from simcore.show.view_driving import LONGEST, SUBPROTOCOL, ViewDriving
from simcore.show.view_models import ViewModels
from simcore.show.view_page import ViewPage

KEYS = {"KeyW": "w", "KeyA": "a", "KeyQ": "q", "Space": " ", "KeyF": "f"}
PAD = """(() => { window.pad = {connected: true, mapping: "standard", axes: [0, 0, 0, 0],
  buttons: Array.from({length: 17}, () => ({value: 0}))}; navigator.getGamepads = () => [null, window.pad]; })()"""


class Visitor:
    """A browser whose page has the focus, and whose keys are pressed."""

    def __init__(self, page) -> None:
        self.page = page
        page.wait_for_text("restart with this seed")
        page.call("Emulation.setFocusEmulationEnabled", enabled=True)

    def key(self, kind: str, code: str) -> None:
        self.page.call("Input.dispatchKeyEvent", type=kind, code=code, key=KEYS[code], text="")


def wait_until(condition, seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


class Run(threading.Thread):
    """A match that goes on at the page's pace while a test presses keys."""

    def __init__(self, match: Match, view: LiveView) -> None:
        super().__init__(daemon=True)
        self.match, self._view, self._ends = match, view, False
        self.robot = match.robots[0]

    def run(self) -> None:
        while not self._ends:
            self.match.tick()
            self._view.after_tick(self.match, should_stop=lambda: self._ends)

    @property
    def velocity(self) -> tuple[float, float]:
        return self.robot.chassis.vel[0], self.robot.chassis.vel[1]

    def stands(self) -> bool:
        return math.hypot(*self.velocity) < 0.02

    def end(self) -> None:
        self._ends = True
        self.join(20.0)


@pytest.mark.slow
def test_keys_and_a_gamepad_drive_until_they_are_let_go_or_the_page_loses_its_focus(browser) -> None:
    driving = ViewDriving(("shoot",))
    view = LiveView(ViewModels(), driving=driving)
    with Match(REBUILT, sinks=[view.sink()], robots=(RobotEntry(alliance="red", start=(2.0, 4.03, 0.0)),)) as match:
        match.set_controller(0, HandedOver(match, "red", lambda robot, time: None, driving.input))
        run = Run(match, view)
        try:
            visitor = Visitor(browser(view.url))
            page, robot = visitor.page, run.robot
            run.start()
            camera = next(iter(view.page.server.get_clients().values())).camera
            eye = camera.position.copy()
            visitor.key("keyDown", "KeyW")
            time.sleep(0.5)
            assert run.stands() and driving.input() is None, "nobody has pressed the button"
            visitor.key("keyUp", "KeyW")
            page.click("drive")
            page.wait_for_text("1 or Space shoot")
            page.wait_for_text("driving: keyboard")
            wait_until(lambda: driving.input() is not None)
            eye = camera.position.copy()
            visitor.key("keyDown", "KeyA")  # left of the red station is toward y = 0
            wait_until(lambda: run.velocity[1] < -0.5)
            visitor.key("keyUp", "KeyA")
            wait_until(run.stands)
            visitor.key("keyDown", "KeyF")
            deploy = robot.mechanisms[robot.config.intakes[0].deploy]
            out = deploy.stops[robot.config.intakes[0].deployed_at == "upper"]
            wait_until(lambda: abs(deploy.position - out) < 0.1 * (deploy.stops[1] - deploy.stops[0]))
            visitor.key("keyUp", "KeyF")
            visitor.key("keyDown", "Space")  # it turns to the hub, spins up and feeds
            wait_until(lambda: len(match.record.shots) > 2, 30.0)
            visitor.key("keyUp", "Space")
            visitor.key("keyDown", "KeyQ")
            wait_until(lambda: robot.chassis.rate[2] > 0.5)
            page.call("Emulation.setFocusEmulationEnabled", enabled=False)
            page.evaluate("dispatchEvent(new Event('blur'))")
            wait_until(lambda: run.stands() and not driving.input())
            page.call("Emulation.setFocusEmulationEnabled", enabled=True)
            assert abs(camera.position - eye).max() < 1e-6, "the keys do not move the camera, too"
        finally:
            run.end()
            view.close()
