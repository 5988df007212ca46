"""The live view answers only its own page, withstands many viewers, and lets a person drive."""

from __future__ import annotations

import contextlib
import http.client
import json
import math
import socket
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("websockets", reason='needs websockets: pip install -e ".[view]"')

from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from games.rebuilt import REBUILT
from simcore import Match, RobotEntry
from simcore.errors import OutputError
from simcore.match.players.driven_robot import DriverInput, HandedOver
from simcore.show.live_view import LiveView
from simcore.show.play_command import _freely
from simcore.show.view_driving import ViewDriving
from simcore.show.view_server import LONGEST, MOST_VIEWERS, Guard, ViewServer
from simcore.telemetry.recording import Recording
from simcore.units import TICK

LINK = {"Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "document"}
KEYS = {"KeyW": "w", "KeyA": "a", "KeyQ": "q", "Space": " ", "KeyF": "f"}


def refused(guard: Guard, port: int = 8080, **headers: str) -> str:
    """Return the sentence with which a request is refused, empty if it is answered."""
    given = {name.replace("_", "-").lower(): value for name, value in headers.items()}
    return guard.refusal(
        SimpleNamespace(get_all=lambda key: [given[key.lower()]] if key.lower() in given else []), port
    )


@pytest.mark.parametrize(
    ("host", "other_site", "answered"),
    [
        ("127.0.0.1:8080", {}, True),
        ("localhost:8080", {"Origin": "http://localhost:8080"}, True),
        ("LocalHost:8080", {"Origin": "http://localhost:8080"}, True),
        ("[::1]:8080", {}, True),
        ("127.0.0.1:8080", {**LINK, "Sec_Fetch_Site": "cross-site"}, True),
        ("127.0.0.1:8080", {**LINK, "Sec_Fetch_Site": "same-site", "Sec_Fetch_Dest": "iframe"}, False),
        ("127.0.0.1:8080", {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "no-cors"}, False),
        ("127.0.0.1:8080", {"Origin": "http://localhost:8080"}, False),
        ("127.0.0.1:8080", {"Origin": "https://127.0.0.1:8080"}, False),
        ("127.0.0.1:8080", {"Origin": "http://127.0.0.1:8081"}, False),
        ("127.0.0.1:8080", {"Origin": "http://127.0.0.1:8080.evil.example"}, False),
        ("127.0.0.1:8080", {"Origin": "null"}, False),
        ("127.0.0.1:8081", {}, False),
        ("127.0.0.1", {}, False),
        ("evil.example:8080", {"Origin": "http://evil.example:8080"}, False),  # DNS rebinding
        ("192.168.0.7:8080", {}, False),
        ("localhost.evil.example:8080", {}, False),
        ("", {}, False),
    ],
)  # fmt: skip
def test_the_view_answers_only_its_own_host_and_origin(host, other_site, answered) -> None:
    assert (refused(Guard("127.0.0.1"), Host=host, **other_site) == "") == answered


def test_a_shared_view_accepts_only_numeric_hosts_and_its_own_host_name() -> None:
    guard = Guard("0.0.0.0")
    own = socket.gethostname()
    for host in ("192.168.0.7:8080", "[fe80::1]:8080", f"{own}:8080", f"{own}.local:8080", "127.0.0.1:8080"):
        assert refused(guard, Host=host, Origin=f"http://{host}") == ""
    assert "Host evil.example:8080" in refused(guard, Host="evil.example:8080", Origin="http://evil.example:8080")
    assert "Origin http://evil.example" in refused(guard, Host="192.168.0.7:8080", Origin="http://evil.example")


@pytest.fixture
def server():
    taken = []
    served = ViewServer("127.0.0.1", 0, "<p>page</p>", lambda: ["hello"], lambda *one: taken.append(one))
    yield SimpleNamespace(server=served, taken=taken, socket=served.url.replace("http", "ws") + "/live", url=served.url)
    served.close()


def got(server, path="/", **headers: str) -> tuple[int, str, dict[str, str]]:
    connection = http.client.HTTPConnection(server.url.removeprefix("http://"), timeout=10.0)
    connection.request("GET", path, headers={name.replace("_", "-"): value for name, value in headers.items()})
    answer = connection.getresponse()
    return answer.status, answer.read().decode(), dict(answer.headers)


def test_the_page_is_served_with_security_headers_and_other_sites_are_refused(server) -> None:
    status, text, headers = got(server)
    assert (status, text) == (200, "<p>page</p>") and headers["X-Frame-Options"] == "DENY"
    assert got(server, "/other")[0] == 404
    status, text, _ = got(server, Host="<b>evil.example")
    assert status == 403 and "&lt;b&gt;" in text
    with pytest.raises(InvalidStatus, match="403"):
        connect(server.socket, origin="http://evil.example")
    with connect(server.socket, origin=server.url) as page:
        assert page.recv(timeout=5) == "hello"
        server.server.send(b"frame", is_frame=True)
        assert page.recv(timeout=5) == b"frame"


def test_many_sockets_invalid_messages_and_a_slow_reader_do_not_stop_the_server(server) -> None:
    with contextlib.ExitStack() as stack:
        open_ones, turned_away = [], 0
        for _ in range(200):
            try:
                open_ones.append(stack.enter_context(connect(server.socket, origin=server.url, max_queue=1)))
            except (InvalidStatus, ConnectionClosed):
                turned_away += 1
        assert (len(open_ones), turned_away) == (MOST_VIEWERS, 200 - MOST_VIEWERS)
        assert got(server)[0] == 200, "the page itself is still served"
        for _ in range(200):  # no page reads: a page that is behind gets no frames, and no memory is filled
            server.server.send(bytes(50_000), is_frame=True)
        time.sleep(0.5)
        for text in ("[]", "{", "[" * 900, '"x"'):
            page = open_ones.pop()
            page.send(text)
        open_ones.pop().send("x" * (4 * LONGEST + 1))
    end = time.monotonic() + 10.0
    while server.server.has_viewers and time.monotonic() < end:
        time.sleep(0.05)
    assert not server.server.has_viewers, "their places are free"
    assert len({number for number, message in server.taken if message is None}) == MOST_VIEWERS


def test_a_page_that_falls_behind_is_sent_everything_except_frames(server, monkeypatch) -> None:
    class Page:
        def __init__(self, waiting: int) -> None:
            self.transport = SimpleNamespace(get_write_buffer_size=lambda: waiting)

    quick, slow, sent = Page(0), Page(10**7), []
    monkeypatch.setattr(server.server, "_clients", {quick: 1, slow: 2})
    monkeypatch.setattr(server.server, "_broadcast", lambda pages, message: sent.append((message, pages)))
    server.server._send(b"frame", True)
    server.server._send("board", False)
    assert sent == [(b"frame", [quick]), ("board", [quick, slow])]
    monkeypatch.undo()


def test_a_port_in_use_is_reported_in_a_single_sentence(server) -> None:
    with pytest.raises(OutputError, match=r"cannot serve the view on 127\.0\.0\.1"):
        ViewServer("127.0.0.1", int(server.url.rpartition(":")[2]), "", list, lambda *_: None)


class Run(threading.Thread):
    """Match that continues at the page's pace while a test presses keys."""

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


def wait_until(condition, seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.mark.slow
def test_a_person_drives_by_keys_and_gamepad_and_sees_how_the_run_ended(browser) -> None:
    driving, recording = ViewDriving(("shoot",)), Recording()
    view = LiveView(driving=driving, title="live")
    robots = (RobotEntry(alliance="red", start=(2.0, 4.03, 0.0)),)
    with Match(REBUILT, sinks=[view.sink(), recording], robots=robots) as match:
        match.set_controller(0, HandedOver(match, "red", lambda robot, time: None, driving.input))
        run = Run(match, view)
        try:
            page = browser(view.url)
            page.call("Emulation.setFocusEmulationEnabled", enabled=True)
            view.wait_for_viewer()
            run.start()
            page.wait_for("window.simcore && simcore.player && simcore.player.run.groups.robots.n > 3")

            def key(kind: str, code: str) -> None:
                page.call("Input.dispatchKeyEvent", type=kind, code=code, key=KEYS[code], text="")

            key("keyDown", "KeyW")
            time.sleep(0.3)
            key("keyUp", "KeyW")
            assert run.stands() and driving.input() is None, "nobody has pressed the button"
            page.click("drive")
            page.wait_for_text("1 or Space shoot")
            assert page.evaluate("getComputedStyle(document.querySelector('.keys')).display") == "none"
            wait_until(lambda: driving.input() is not None)
            key("keyDown", "KeyA")  # left of the red station is toward y = 0
            wait_until(lambda: run.velocity[1] < -0.5)
            key("keyUp", "KeyA")
            wait_until(run.stands)
            key("keyDown", "KeyQ")
            wait_until(lambda: run.robot.chassis.robot_rate[2] > 0.5)
            page.evaluate("window.focused = false; document.hasFocus = () => window.focused; 1")
            page.evaluate("dispatchEvent(new Event('blur')); 1")
            wait_until(lambda: driving.input() is None)
            page.evaluate("window.focused = true")
            wait_until(lambda: driving.input() is not None)
            assert driving.input().turn == 0.0, "the key that was down as the focus went counts no more"
            page.evaluate(
                "window.pad = {connected: true, mapping: 'standard', axes: [0, 0.6, 0, 0], buttons: []};"
                "navigator.getGamepads = () => [null, window.pad]; 1"
            )
            wait_until(lambda: run.velocity[0] > 0.5)
            page.evaluate("pad.axes = [0, 0, 0, 0]; 1")
            wait_until(run.stands)
            page.evaluate("simcore.send({do: 'pause', value: true}); 1")
            wait_until(lambda: view.pacer.paused)
            page.wait_for(f"Math.abs(simcore.head - {match.time}) < 0.001")
            shown = page.evaluate("simcore.player.run.robot(0, simcore.head).place")
            assert shown == pytest.approx(run.robot.chassis.pos, abs=0.002)
            page.evaluate(
                "simcore.send({do: 'pause', value: false}); simcore.send({do: 'spawn', kind: 'Fuel', robot: 0}); 1"
            )
            wait_until(lambda: not view.pacer.paused)
            run.end()
            ended = threading.Thread(target=lambda: seeds.append(view.next_seed(recording)))
            seeds: list[int | None] = []
            ended.start()
            page.wait_for("simcore.isOver === true")
            assert page.evaluate("document.querySelector('.sheet').hidden") is False
            assert page.evaluate("document.querySelector('.sheet h2').textContent") == f"{match.score.red} points"
            key("keyDown", "KeyW")  # driving has ended
            page.evaluate("dispatchEvent(new KeyboardEvent('keydown', {code: 'KeyR', key: 'r'})); 1")
            ended.join(10.0)
            assert seeds == [0]
            page.evaluate("1")
            assert [error for error in page.errors if "ReadPixels" not in error] == []
        finally:
            run.end()
            view.close()


@pytest.mark.slow
def test_free_driving_counts_down_shows_no_clock_and_views_from_the_drivers_side(browser) -> None:
    driving = ViewDriving(("shoot",), at_once=True, is_free=True)
    view = LiveView(driving=driving)
    with Match(
        REBUILT, sinks=[view.sink()], robots=(RobotEntry(alliance="red", start=(3.0, 4.0, 0.0)),), practice=True
    ) as match:
        _freely(match, "red")
        match.set_controller(0, HandedOver(match, "red", lambda robot, time: None, driving.input))
        run = Run(match, view)
        try:
            page = browser(view.url)
            page.call("Emulation.setFocusEmulationEnabled", enabled=True)
            page.call(
                "Page.addScriptToEvaluateOnNewDocument",
                source="window.counts = []; addEventListener('DOMContentLoaded', () => new MutationObserver(() =>"
                " counts.push(document.querySelector('.count').textContent)).observe("
                "document.querySelector('.count'), { childList: true }));",
            )
            page.call("Page.navigate", url=view.url)
            view.wait_for_viewer()
            run.start()
            page.wait_for("window.counts && counts.length === 4")
            assert page.evaluate("counts") == ["3", "2", "1", ""]
            wait_until(lambda: not view.pacer.paused)
            before = match.time
            wait_until(lambda: match.time > before + 0.5)
            shown = page.evaluate(
                "[...document.querySelectorAll('.score :is(b, span)')].map((node) => node.textContent)"
            )
            assert shown == ["free", "driving"]
            eye, robot = page.evaluate(
                "(() => { const s = simcore.player.solid; return [[...s.eye.position], [...s.control.target]]; })()"
            )
            assert eye[0] > robot[0] + 2.0 and abs(eye[1] - robot[1]) < 0.3, "from the red station's side"
            page.evaluate(
                "window.shaken = 0;"
                "window.pad = {connected: true, mapping: 'standard', axes: [0, 0, 0, 0], buttons: [],"
                " vibrationActuator: { playEffect: () => { shaken++; } }}; navigator.getGamepads = () => [pad];"
                "simcore.player.onScore(1); 1"
            )
            assert page.evaluate("shaken") == 1
        finally:
            run.end()
            view.close()


def test_free_driving_stays_enabled_after_the_end_of_a_match() -> None:
    with Match(REBUILT, robots=(RobotEntry(),), practice=True) as match:
        _freely(match, "blue")
        assert match.timer.phase.mode == "teleop" and match.timer.is_enabled
        match.timer.advance(1000.0)
        assert match.timer.is_over and match.timer.is_enabled


def test_invalid_requests_of_a_page_are_ignored() -> None:
    view = LiveView()
    try:
        with connect(view.url.replace("http", "ws") + "/live", origin=view.url) as page:
            for message in (
                {"do": "speed", "value": "x"},
                {"do": "speed", "value": -1},
                {"do": ["x"]},
                {},
                {"do": "start"},
            ):
                page.send(json.dumps(message))
            page.send(json.dumps({"do": "restart", "seed": "<b>"}))
            wait_until(lambda: not view._asked.empty())
            time.sleep(0.2)
            assert view._act(None) is False and view.pacer.speed == 1.0 and view.wants_restart
        with Match(REBUILT) as match:
            for name in ([], {}, None, 3):
                for what in ("human", "leave"):
                    assert not view._act_on_field(match, what, {"alliance": name, "name": name, "robot": name})
    finally:
        view.close()


def test_invalid_field_commands_of_a_page_never_end_the_match() -> None:
    """Arguments of another type are ignored; unknown names are refused in the next tick."""
    view = LiveView()
    try:
        with Match(REBUILT, robots=(RobotEntry(),)) as match:
            match.tick()
            view.after_tick(match)
            for message in (
                {"do": "human", "alliance": [], "name": "x"},
                {"do": "leave", "alliance": {}},
                {"do": "start", "robot": None},
                {"do": "reset", "self": 1},
                {"do": ["reset"]},
            ):
                view._take(1, message)
            view.after_tick(match)
            match.tick()
            assert match.control.count == 0
            view._take(1, {"do": "human", "alliance": "green", "name": "x"})
            view._take(1, {"do": "start", "robot": 7})
            view._take(1, {"do": "spawn", "robot": 0, "kind": "Fuel"})
            view.after_tick(match)
            match.tick()
            assert [result.is_done for result in match.control.results] == [False, False, True]
    finally:
        view.close()


def first(noted, wanted):
    """Return the first wanted item that another thread notes, as soon as it is there."""
    wait_until(lambda: any(map(wanted, list(noted))))
    return next(filter(wanted, list(noted)))


def test_a_pressed_key_takes_effect_in_the_next_frames(browser) -> None:
    """Measure the time from a key to the first picture with its whole effect, by stages; limit the server's part.

    The page notes when it sends a key and when a picture is finished, the server when it takes the message and when it
    sends the frame of the tick that read it; all by the clock of this computer.
    """
    driving, taken, read, sent = ViewDriving(), [], [], []
    view = LiveView(driving=driving, title="live")
    take, show = driving.take, view.show

    def note_take(page: int, message) -> None:
        take(page, message)
        taken.append((time.time(), bool(message and message["keys"]), match.time))

    def note_read() -> DriverInput | None:
        read.append((time.time(), match.time))
        return driving.input()

    def note_show(snapshot, **options) -> None:
        show(snapshot, **options)
        sent.append((time.time(), snapshot.time))

    driving.take, view.show = note_take, note_show
    robots = (RobotEntry(alliance="blue", start=(2.0, 4.03, 0.0)),)
    with Match(REBUILT, sinks=[view.sink()], robots=robots) as match:
        match.set_controller(0, HandedOver(match, "blue", lambda robot, time: None, note_read))
        run = Run(match, view)
        try:
            page = browser(view.url)
            page.call("Emulation.setFocusEmulationEnabled", enabled=True)
            view.wait_for_viewer()
            run.start()
            page.wait_for("window.simcore && simcore.player && simcore.player.run.groups.robots.n > 3")
            page.click("drive")
            wait_until(lambda: driving.input() is not None)
            page.evaluate(
                "window.wall = () => (performance.timeOrigin + performance.now()) / 1000; window.pressed = [];"
                "window.pictures = []; window.arrived = [];"
                "{ const frame = simcore.frame.bind(simcore);"
                "  simcore.frame = (data) => { frame(data); arrived.push([wall(), simcore.head]); }; }"
                "const add = Set.prototype.add;"
                "simcore.down.add = (code) => { pressed.push(wall()); return add.call(simcore.down, code); };"
                "{ const { player } = simcore, draw = player.draw.bind(player);"
                "  const gl = player.solid.renderer.getContext(), pixel = new Uint8Array(4);"
                "  player.draw = () => { draw(); gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);"
                "    pictures.push([wall(), player.now]); }; } 1"
            )
            for what in ("with software rendering", "without what the 3D view takes to render"):
                stages = []
                for press in range(8):
                    code = ("KeyA", "KeyQ")[press % 2]
                    while 19.5 < match.time < 23.5:  # no player is read in the pause after the autonomous period
                        time.sleep(0.1)
                    begun = time.time()
                    page.call("Input.dispatchKeyEvent", type="keyDown", code=code, key=KEYS[code], text="")
                    at, _, before = first(taken, lambda one, begun=begun: one[0] > begun and one[1])
                    effect = first(read, lambda one, at=at: one[0] > at)[1] + TICK
                    assert effect < before + 2.5 * TICK, "read by the next tick, or the one after that under way"
                    left, when = first(sent, lambda one, effect=effect: one[1] > effect - 0.001)
                    page.wait_for(f"pictures.some(([, now]) => now >= {when - 0.001})")
                    arrived, drawn = (
                        page.evaluate(f"{noted}.find(([, now]) => now >= {when - 0.001})[0]")
                        for noted in ("arrived", "pictures")
                    )
                    key = page.evaluate("pressed.at(-1)")
                    stages.append((at - key, left - at, arrived - left, drawn - arrived, drawn - key))
                    page.call("Input.dispatchKeyEvent", type="keyUp", code=code, key=KEYS[code], text="")
                    time.sleep(0.13)
                middle = 1e3 * np.median(stages, axis=0)
                rate = page.evaluate("pictures.length / (pictures.at(-1)[0] - pictures[0][0])")
                print(
                    f"{what}: key to server {middle[0]:.0f} ms, server {middle[1]:.0f} ms, to the page "
                    f"{middle[2]:.0f} ms, to the picture {middle[3]:.0f} ms, in all {middle[4]:.0f} ms at {rate:.0f} "
                    "pictures a second"
                )
                assert min(server for _, server, *_ in stages) < 0.05, "a computer that is busy with others may be late"
                page.evaluate("simcore.player.solid.renderer.render = () => {}; pictures.length = 0; 1")
        finally:
            run.end()
            view.close()
