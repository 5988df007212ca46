"""A person drives from the page of a real browser: by keys and by a gamepad, and never from another website."""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from simcore.show.view_page import ViewPage
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from games.rebuilt import REBUILT
from simcore import Match, RobotEntry
from simcore.errors import ConfigError
from simcore.players.driven_robot import HandedOver
from simcore.players.lineup import entries, lineup, take_seats
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.show import play_command
from simcore.show.live_view import LiveView
from simcore.show.view_driving import LONGEST, SUBPROTOCOL, ViewDriving
from simcore.show.view_models import ViewModels

ROOT = Path(__file__).resolve().parents[2]
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
            wait_until(lambda: robot.chassis.robot_rate[2] > 0.5)
            page.evaluate("window.focused = false; document.hasFocus = () => window.focused")
            page.evaluate("dispatchEvent(new Event('blur'))")
            wait_until(lambda: abs(robot.chassis.robot_rate[2]) < 0.02 and driving.input() is None)
            page.evaluate("window.focused = true")
            wait_until(lambda: driving.input() is not None)
            assert driving.input().turn == 0.0, "the key that was down as the focus went counts no more"
            assert abs(camera.position - eye).max() < 1e-6, "the keys do not move the camera, too"
            page.evaluate(PAD)
            page.wait_for_text("driving: keyboard and gamepad")
            page.evaluate("pad.axes = [0, 0.6, 0, 0]")  # back, toward the red station
            wait_until(lambda: run.velocity[0] > 0.5)
            page.evaluate("pad.axes = [0.05, -0.05, 0.05, 0]")
            wait_until(run.stands)
            page.evaluate("[...document.querySelectorAll('input')].find(one => one.value === '0').focus()")  # the seed
            assert page.evaluate("document.activeElement.value") == "0"
            visitor.key("keyDown", "KeyA")
            time.sleep(0.3)
            assert run.stands(), "it is typed into a field of the page"
            page.evaluate("document.activeElement.blur()")
            page.evaluate("pad.axes = [0, -0.6, 0, 0]")
            wait_until(lambda: run.velocity[0] < -0.5)
            page.call("Page.navigate", url="about:blank")
            wait_until(lambda: run.stands() and driving.input() is None)
        finally:
            run.end()
            view.close()


def test_no_other_site_and_no_second_page_can_drive() -> None:
    driving = ViewDriving()
    with ViewPage(ViewModels(), driving=driving) as page:
        address = page.url.replace("http", "ws")
        options = {"subprotocols": [SUBPROTOCOL], "compression": None}
        for headers in (
            {"origin": "http://evil.example"},
            {"origin": "null"},
            {"origin": page.url, "additional_headers": {"Host": "evil.example"}, "user_agent_header": None},
        ):
            with pytest.raises(InvalidStatus) as caught:
                connect(address, **options, **headers)
            assert caught.value.response.status_code == 403
        assert driving.input() is None
        message = json.dumps({"keys": ["KeyW"]})
        with connect(address, origin=page.url, **options) as socket:
            socket.send(message)
            wait_until(lambda: driving.input() is not None and driving.input().ahead == 1.0)
            with connect(address, origin=page.url, **options) as second, pytest.raises(ConnectionClosed) as closed:
                second.recv(timeout=10)
            assert closed.value.rcvd.reason == "another page drives"
            assert not page.has_viewers, "who drives is no viewer of the scene"
        wait_until(lambda: driving.input() is None)
        for nonsense, code in (("{}", 1007), (message.encode(), 1007), ("[" * 10 * LONGEST, 1009)):
            with connect(address, origin=page.url, **options) as socket, pytest.raises(ConnectionClosed) as closed:
                socket.send(nonsense)
                socket.recv(timeout=10)
            assert closed.value.rcvd.code == code
            wait_until(lambda: driving._driver is None)
    with ViewPage(ViewModels()) as page, pytest.raises(InvalidStatus) as caught:
        connect(page.url.replace("http", "ws"), origin=page.url, **options)
    assert caught.value.response.status_code == 400, "a view without a robot to drive has no such socket"


@pytest.mark.slow
def test_in_a_match_a_person_has_its_robot_in_teleop_and_the_others_play_on(browser) -> None:
    driving = ViewDriving(tuple(REBUILT.driving.actions))
    view = LiveView(ViewModels(), driving=driving)
    seats = lineup(REBUILT, red="idle", blue="me")
    auto = REBUILT.auto("tour")
    with Match(REBUILT, sinks=[view.sink()], robots=entries(REBUILT, seats)) as match:

        def me():
            return HandedOver(match, "blue", auto.controller(match, "blue"), driving.input, from_teleop=True)

        take_seats(match, seats, me)
        run = Run(match, view)
        try:
            visitor = Visitor(browser(view.url))
            visitor.page.click("drive")
            visitor.key("keyDown", "KeyA")
            wait_until(lambda: driving.input() is not None)
            run.start()
            wait_until(lambda: match.timer.time > 1.5)
            assert run.velocity[0] > 1.0 and abs(run.velocity[1]) < 0.3, "its auto, whatever the keys say"
            visitor.key("keyUp", "KeyA")
            run.end()
            robot = match.robots[0]
            robot.carry_to((3.0, 5.9, 0.0))
            match.timer._start = 23.0 - match.timer._ticks * 0.02  # teleop begins
            run = Run(match, view)
            run.start()
            visitor.key("keyDown", "KeyA")
            wait_until(lambda: run.velocity[1] > 0.5)
            visitor.key("keyUp", "KeyA")
            wait_until(run.stands)
            assert match.timer.phase.mode == "teleop"
        finally:
            run.end()
            view.close()


@pytest.mark.slow
def test_the_command_lets_a_person_drive_and_says_how_far(browser, tmp_path: Path) -> None:
    words = [sys.executable, "-m", "simcore", "play", "rebuilt", "--view", "--no-browser", "--auto", "drive", "--json"]
    with subprocess.Popen(
        [*words, "--seconds", "12"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as run:  # fmt: skip
        try:
            visitor = Visitor(browser(run.stderr.readline().split()[-1]))
            visitor.page.click("drive")
            visitor.key("keyDown", "KeyA")
            visitor.page.wait_for_text("the run is over: restart it here", 60.0)
        finally:
            run.send_signal(2)
            out, _ = run.communicate(timeout=20)
    report = json.loads(out)
    assert report["auto"] == "drive" and report["distance_m"] > 0.1 and report["shots"] == 0


@pytest.mark.parametrize(
    ("words", "is_driven", "seconds"),
    [
        ("--view", True, 20.0),
        ("", False, 20.0),
        ("--view --auto drive", True, 166.0),
        ("--match --blue me,idle --view", True, 166.0),
        ("--match --blue idle --view", False, 166.0),
        ("--match --blue me", False, 166.0),
    ],
)
def test_there_is_a_button_where_there_is_a_robot_to_drive(words, is_driven, seconds) -> None:
    plan = play_command._plan(parsed(words), REBUILT)
    assert (plan.driving is not None) == is_driven
    assert plan.seconds == pytest.approx(seconds, abs=1.0)


def test_to_drive_needs_a_page_and_swerve() -> None:
    with pytest.raises(ConfigError, match="--auto drive is for a person at the page: give --view, too"):
        play_command._plan(parsed("--auto drive"), REBUILT)
    robot = replace(REBUILT.robot(), drivetrain=TankConfig())
    with pytest.raises(ConfigError, match="a person drives robots with swerve, and that of rebuilt has none"):
        play_command._plan(parsed("--view --auto drive"), replace(REBUILT, robot=lambda: robot))


def parsed(words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    play_command.add_arguments(parser)
    return parser.parse_args(["rebuilt", *words.split()])
