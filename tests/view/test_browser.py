"""The page in a real browser: what it draws is compared with the state, point by point; buttons are pressed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from simcore.show.replay import Replay
from simcore.show.view_cameras import BEHIND
from simcore.show.view_page import ViewPage

from games.rebuilt import REBUILT, RebuiltSim
from simcore import RobotEntry
from simcore.geometry.rotation import from_rpy, rotate
from simcore.show.live_view import LiveView
from simcore.show.view_models import load_models
from simcore.telemetry.log_reader import read_log
from simcore.telemetry.sinks import MemorySink
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
SIZE = (360, 640)
"""Height and width of a picture [pixels]."""


def picture(page: ViewPage, eye, target, fov: float = 0.8) -> tuple[np.ndarray, object]:
    """What the browser draws from an eye at a target, and the function from field points to its pixels."""
    end = time.monotonic() + 30.0
    while not page.server.get_clients():
        assert time.monotonic() < end, "no browser came"
        time.sleep(0.05)
    (client,) = page.server.get_clients().values()
    eye, target = np.array(eye, dtype=float), np.array(target, dtype=float)
    z = (target - eye) / np.linalg.norm(target - eye)
    x = np.cross(z, (0.0, 0.0, 1.0))
    x /= np.linalg.norm(x)
    axes = np.column_stack((x, np.cross(z, x), z))  # camera: x right, y down, z ahead
    from scipy.spatial.transform import Rotation

    qx, qy, qz, qw = Rotation.from_matrix(axes).as_quat()
    height, width = SIZE
    image = client.get_render(
        height=height, width=width, wxyz=(qw, qx, qy, qz), position=tuple(eye), fov=fov, transport_format="png"
    )
    focal = 0.5 * height / np.tan(0.5 * fov)

    def pixel(point) -> tuple[int, int]:
        a, b, c = axes.T @ (np.asarray(point) - eye)
        return round(height / 2 + focal * b / c - 0.5), round(width / 2 + focal * a / c - 0.5)

    return image[:, :, :3].astype(int), pixel


def is_yellow(rgb: np.ndarray) -> bool:
    r, g, b = rgb
    return r > 100 and g > 80 and b < 0.62 * min(r, g)


def is_like(rgb: np.ndarray, channel: int) -> bool:
    others = [rgb[i] for i in range(3) if i != channel]
    return rgb[channel] > 60 and rgb[channel] > 1.5 * max(others)


def settled(page: ViewPage, eye, target, good) -> tuple[np.ndarray, object]:
    """The picture once it has all of the scene; a software renderer needs some seconds."""
    end = time.monotonic() + 40.0
    while True:
        image, pixel = picture(page, eye, target)
        if good(image, pixel) or time.monotonic() > end:
            return image, pixel
        time.sleep(0.5)


def test_fuel_robots_and_field_are_where_the_state_says(browser) -> None:
    """From above: yellow at all 448 fuel, carpet between them, bumpers in their alliance's color at both robots."""
    memory = MemorySink()
    entries = (RobotEntry(start=(2.5, 5.9, 0.4)), RobotEntry(alliance="red"))
    with RebuiltSim(robots=entries, sinks=[memory]) as sim:
        for _ in range(5):
            sim.tick()
    snapshot = memory.snapshots[-1]
    fuel = snapshot.pose_arrays["Sim/GamePieces/Fuel"][:, :3]
    in_sight = fuel[(fuel[:, 0] > 5.5) & (fuel[:, 0] < 11.0)]  # the neutral zone; depots lie in their walls' shade
    assert len(in_sight) > 350
    with ViewPage(load_models(REBUILT.models)) as page:
        page.show(snapshot)
        visitor = browser(page.url)
        visitor.wait_for_text("fuel on the field")

        def share(image, pixel):
            return np.mean([is_yellow(image[pixel(p)]) for p in in_sight])

        eye, target = (8.27, 3.0, 9.0), (8.27, 4.03, 0.0)
        image, pixel = settled(page, eye, target, lambda i, p: share(i, p) > 0.99)
        assert share(image, pixel) > 0.99
        clear = [(x, y, 0.0) for x in (6.2, 10.3) for y in (2.6, 4.0, 5.4)]
        assert not any(is_yellow(image[pixel(p)]) for p in clear)
        for number, channel in ((0, 2), (1, 0)):
            key = "Sim/Robot/Pose3d" if number == 0 else "Sim/Robots/1/Robot/Pose3d"
            x, y, z, w, qx, qy, qz = snapshot.poses[key]
            bumpers = [(sx, sy, 0.25) for sx, sy in ((0.1, 0.36), (0.1, -0.36), (0.36, 0.36), (0.36, -0.36))]
            corners = [np.array((x, y, z)) + rotate((qx, qy, qz, w), b) for b in bumpers]
            image, pixel = settled(
                page,
                (x, y - 0.5, 4.0),
                (x, y, 0.0),
                lambda i, p, c=corners, k=channel: all(is_like(i[p(corner)], k) for corner in c),
            )
            assert [is_like(image[pixel(corner)], channel) for corner in corners] == [True] * 4
        # one fuel moves: it is drawn there and no longer here
        rows = snapshot.pose_arrays["Sim/GamePieces/Fuel"].copy()
        here, there = rows[0, :3].copy(), np.array((6.2, 4.0, 0.075))
        rows[:] = np.where(np.linalg.norm(rows[:, :2] - here[:2], axis=1)[:, None] < 0.4, (*there, 1, 0, 0, 0), rows)
        page.show(Snapshot(time=1.0, tick=1, poses=snapshot.poses, pose_arrays={"Sim/GamePieces/Fuel": rows}))
        image, pixel = settled(page, eye, target, lambda i, p: is_yellow(i[p(there)]))
        assert is_yellow(image[pixel(there)]) and not is_yellow(image[pixel(here)])
        assert {url.split("/")[2] for url in visitor.requests if url.startswith("http")} == {page.url.split("/")[2]}, (
            "the page asks nobody else: it works offline"
        )


def test_parts_move_with_their_poses(browser) -> None:
    """The intake's orange arm is outside of the bumpers when the pose of the part says so, and only then."""
    pose = np.array((4.0, 4.0, 0.0, 1.0, 0.0, 0.0, 0.0))
    parts = np.zeros((16, 7))
    parts[:, 3] = 1.0
    parts[:, 2] = -5.0  # out of sight, below the carpet
    with ViewPage(load_models(REBUILT.models).with_field(None)) as page:
        for back in (0.0, 0.28):
            parts[0, :3] = (-0.30 - back, 0.0, 0.35 - 0.5 * back)
            snapshot = Snapshot(
                time=back, tick=0, poses={"Sim/Robot/Pose3d": pose},
                pose_arrays={"Sim/Robot/ComponentPoses": parts.copy()},
            )  # fmt: skip
            page.show(snapshot)
            if back == 0.0:
                browser(page.url).wait_for_text("0:00.0")
            arm = pose[:3] + parts[0, :3] + (-0.12, 0.345, 0.045)

            def orange(image, pixel, arm=arm):
                r, g, b = image[pixel(arm)]
                return r > 1.2 * g > 1.2 * b

            image, pixel = settled(page, (3.4, 2.5, 3.0), (3.6, 4.0, 0.2), orange)
            assert orange(image, pixel), back
        assert not orange(image, pixel, pose[:3] + np.array((-0.37, 0.345, 0.395)))


def wait_until(condition, seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_a_live_run_is_paused_slowed_touched_and_restarted(browser) -> None:
    """Buttons, the speed that is reached and the preview of a shot, in one run of a robot that spins its shooter."""
    view = LiveView(load_models(REBUILT.models).with_field(None), seed=3)
    with RebuiltSim(sinks=[view.sink()], robots=(RobotEntry(start=(2.5, 4.03, 0.0)),)) as match:
        view.wait_for_viewer(should_stop=lambda: True)  # nobody looks yet
        visitor = browser(view.url)
        view.wait_for_viewer()
        visitor.wait_for_text("restart with this seed")
        robot = match.robots[0]

        def spin(robot, time):
            robot.mechanisms["shooter"].velocity = robot.shooters[0].config.wheel_speed_for(6.0)

        match.set_controller(0, spin)

        def play(until, ticks: int = 500) -> None:
            for _ in range(ticks):
                match.tick()
                view.after_tick(match)
                if until():
                    return
            raise AssertionError(f"it never came: {seen}")

        seen = ""

        def says(text: str):
            def look() -> bool:
                nonlocal seen
                if match.ticks % 10 == 0:
                    seen = visitor.evaluate("document.body.innerText")
                return text in seen

            return look

        play(says("shot now: misses, touches at x"))
        period = says("period: auto")
        play(lambda: period() and "x real time" in seen and "blue hub active" in seen)
        assert view.pacer.reached is not None and 0.05 < view.pacer.reached < 1.2
        count = len(match.pieces.on_field())
        visitor.click("pause")
        wait_until(lambda: view.pacer.paused)
        visitor.evaluate("[...document.querySelectorAll('*')].filter(e => e.innerText === 'field').pop().click()")
        visitor.wait_for_text("put a piece before the robot")
        visitor.click("put a piece before the robot")
        ticks = match.ticks
        view.after_tick(match, should_stop=lambda: len(match.pieces.on_field()) > count)  # acts while it stands
        assert match.ticks == ticks and len(match.pieces.on_field()) == count + 1 and match.count.is_conserved
        near = match.pieces.state.pos[match.pieces.on_field()][:, :2] - (
            robot.chassis.pos[0] + 1.2,
            robot.chassis.pos[1],
        )
        assert np.linalg.norm(near, axis=1).min() < 0.5
        visitor.wait_for_text("1 Fuel put down")
        visitor.click("go on")
        wait_until(lambda: not view.pacer.paused)
        robot.carry_to((3.0, 2.0, 1.0))
        visitor.click("put the robot at its start")
        play(lambda: np.allclose(robot.chassis.pose, match.start_pose(0), atol=0.05))
        visitor.click("put all pieces back")
        play(lambda: len(match.pieces.on_field()) == count)
        visitor.click("restart with this seed")
        wait_until(lambda: view.wants_restart)
        view.after_tick(match)  # does not wait: the run shall end
        final = match.snapshot()
    try:
        assert view.next_seed(final) == 3
        assert not view.wants_restart
        assert view.next_seed(final, should_stop=lambda: True) is None
        visitor.wait_for_text("the run is over")
    finally:
        view.close()


def test_buttons_and_keys_do_what_human_players_do(browser) -> None:
    """Blue's by a button, red's by a key: what is typed into a field is no key, and the other alliance plays on."""
    view = LiveView(load_models(REBUILT.models).with_field(None))
    with RebuiltSim(sinks=[view.sink()], options=["human_players"], robots=(RobotEntry(preload=0),)) as match:
        try:
            visitor = browser(view.url)
            view.wait_for_viewer()
            view.set_paused(True)
            match.tick()
            view.after_tick(match, should_stop=lambda: True)
            visitor.wait_for_text("human players")
            visitor.call("Emulation.setFocusEmulationEnabled", enabled=True)
            unfold = "[...document.querySelectorAll('*')].filter(e => e.innerText === 'human players').pop().click()"
            visitor.evaluate(unfold)
            visitor.wait_for_text("red: push a fuel out of the corral (K)")
            stock = dict(match.rules.human_players.stock)
            visitor.click("blue: push a fuel out of the corral (O)")
            view.after_tick(match, should_stop=lambda: bool(match.persons))  # acts while it stands
            assert set(match.persons) == {"blue"}
            visitor.wait_for_text("blue's human player: push a fuel out")
            assert match.rules.human_players.stock == {**stock, "blue": stock["blue"] - 1}

            def press(code: str) -> None:
                for kind in ("rawKeyDown", "keyUp"):
                    key = code[-1].lower()
                    visitor.call(
                        "Input.dispatchKeyEvent", type=kind, code=code, key=key, windowsVirtualKeyCode=ord(code[-1])
                    )

            visitor.evaluate(
                "[...document.querySelectorAll('input')].find(one => one.value === '0').focus()"
            )  # the seed
            press("KeyK")
            time.sleep(0.5)
            assert not view._buttons.is_pressed
            visitor.evaluate("document.activeElement.blur()")
            press("KeyK")
            view.after_tick(match, should_stop=lambda: "red" in match.persons)
            assert match.rules.human_players.stock["red"] == stock["red"] - 1 and match.count.is_conserved
            visitor.click("blue: leave it to the game")
            view.after_tick(match, should_stop=lambda: "blue" not in match.persons)
            assert set(match.persons) == {"red"}
        finally:
            view.close()


def test_replay_plays_seeks_and_stops_at_the_end(browser, tmp_path: Path) -> None:
    with RebuiltSim(sinks=[WpilogSink(tmp_path / "run.wpilog")]) as sim:
        for _ in range(100):
            sim.tick()
        end_pose = np.array((*sim.robots[0].chassis.pos,))
    replay = Replay(read_log(tmp_path / "run.wpilog"), load_models(REBUILT.models))
    try:
        visitor = browser(replay.url)
        visitor.wait_for_text("run.wpilog")
        width = "document.querySelector('.mantine-Slider-root').getBoundingClientRect().width"
        assert visitor.evaluate(width) > 0.55 * visitor.evaluate("innerWidth"), "as wide as the panel leaves"
        replay.step(0.5)
        visitor.wait_for_text("0:00.5")
        visitor.wait_for_text("fuel on the field 448")
        visitor.click("pause")
        end = time.monotonic() + 10.0
        while replay.playing:
            assert time.monotonic() < end
            time.sleep(0.02)
        replay.seek(1.3)
        replay.step(0.1)
        visitor.wait_for_text("0:01.3")
        visitor.click("play")
        while not replay.playing:
            assert time.monotonic() < end
            time.sleep(0.02)
        replay.step(5.0)
        visitor.wait_for_text("0:02.0")
        assert not replay.playing and replay.time == replay.end == pytest.approx(2.0)
        seen = replay.log.snapshot_at(replay.time).poses["Sim/Robot/Pose3d"]
        assert seen[:3] == pytest.approx(end_pose, abs=1e-6)  # telemetry rounds to 1 um
        assert visitor.screenshot().startswith(b"\x89PNG")
    finally:
        replay.close()


def test_a_clip_of_the_last_ten_seconds_is_downloaded(browser, tmp_path: Path) -> None:
    """The browser gets a GIF of the seconds up to the slider, under the log's name."""
    with RebuiltSim(sinks=[WpilogSink(tmp_path / "run.wpilog")]) as sim:
        for _ in range(100):
            sim.tick()
    replay = Replay(read_log(tmp_path / "run.wpilog"), load_models(REBUILT.models).with_field(None))
    try:
        visitor = browser(replay.url)
        visitor.wait_for_text("clip of the last 10 s")
        visitor.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
        replay.step(1.0)
        visitor.click("clip of the last 10 s")
        wait_until(lambda: (tmp_path / "run.gif").exists(), 40.0)
        wait_until(lambda: (tmp_path / "run.gif").read_bytes().endswith(b";"))  # a GIF's trailer
        assert (tmp_path / "run.gif").read_bytes().startswith(b"GIF89a")
        visitor.wait_for_text("clip of the last 10 s")
    finally:
        replay.close()


def test_following_a_robot_brings_it_to_the_middle(browser) -> None:
    """The world moves, so the camera can be turned meanwhile; behind the robot its front is always ahead."""
    x, y, yaw = 3.0, 5.0, 2.0
    qx, qy, qz, qw = from_rpy(0.0, 0.0, yaw)
    snapshot = Snapshot(
        time=0.0, tick=0, poses={"Sim/Robot/Pose3d": np.array((x, y, 0.0, qw, qx, qy, qz))},
        booleans={"Sim/Robot/IsRed": True},
    )  # fmt: skip
    with ViewPage(load_models(REBUILT.models).with_field(None)) as page:
        page.scene.follow = (0, BEHIND)
        page.show(snapshot)
        browser(page.url).wait_for_text("0:00.0")
        cx, cy, _ = page.scene.center
        corner = (cx - 0.36, cy + 0.36, 0.25)
        mark = (cx + 0.404, cy, 0.16)  # the white plate on the front bumper
        image, pixel = settled(
            page,
            (cx + 2.0, cy - 1.0, 2.2),
            (cx, cy, 0.1),
            lambda i, p: is_like(i[p(corner)], 0) and i[p(mark)].min() > 90,
        )
        assert is_like(image[pixel(corner)], 0)
        assert image[pixel(mark)].min() > 90


def test_cameras_look_along_their_lines_and_shots_leave_trails(browser) -> None:
    """Green from a camera's lens to what it aims at, orange along a flight, and nothing when both are gone."""
    aim = np.array([[6.0, 4.0, 0.5, 1.0, 0.0, 0.0, 0.0], [9.0, 4.0, 0.5, 1.0, 0.0, 0.0, 0.0]])
    flight = np.array([(7.0 + 4.0 * t, 5.0, 0.8 + 2.0 * t - 4.905 * t * t) for t in np.arange(0.0, 0.4, 0.02)])
    with ViewPage(load_models(REBUILT.models).with_field(None)) as page:
        for i, point in enumerate(flight):
            shot = np.array([[*point, 1.0, 0.0, 0.0, 0.0]])
            arrays = {"Sim/Limelights/front/DirectionLine": aim, "Sim/InFlight/Fuel": shot}
            ids = {"Sim/InFlightIds/Fuel": np.array([7])}
            page.show(Snapshot(time=0.02 * i, tick=i, pose_arrays=arrays, integer_arrays=ids))
        browser(page.url).wait_for_text("0:00.4")

        def near(image, pixel, point, good) -> bool:
            row, column = pixel(point)
            return any(good(rgb) for rgb in image[row - 2 : row + 3, column - 2 : column + 3].reshape(-1, 3))

        def green(rgb) -> bool:
            return rgb[1] > 1.15 * max(rgb[0], rgb[2])

        def orange(rgb) -> bool:
            return rgb[0] > 1.3 * rgb[1] > 1.3 * rgb[2]

        def both(image, pixel) -> bool:
            return near(image, pixel, (7.5, 4.0, 0.5), green) and near(image, pixel, flight[10], orange)

        view = ((7.5, 1.0, 2.0), (7.5, 4.5, 0.6))
        image, pixel = settled(page, *view, both)
        assert both(image, pixel)
        page.show(Snapshot(time=9.0, tick=450))
        image, pixel = settled(page, *view, lambda i, p: not both(i, p))
        assert not near(image, pixel, (7.5, 4.0, 0.5), green) and not near(image, pixel, flight[10], orange)


def test_a_run_waits_for_its_first_viewer_and_stays_until_ctrl_c(browser, tmp_path: Path) -> None:
    """The command as it is typed: nothing moves before the page is open; Ctrl-C leaves at once, before and after."""
    words = [sys.executable, "-m", "simcore", "play", "rebuilt", "--view", "--no-browser", "--seconds", "1", "--json"]
    log = tmp_path / "out" / "depot.wpilog"
    for opens, status in ((False, 130), (True, 0)):
        with subprocess.Popen(
            words, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        ) as run:  # fmt: skip
            assert run.stderr is not None and run.stdout is not None
            url = run.stderr.readline().split()[-1]
            assert run.stderr.readline() == "the run begins when the page is open; Ctrl-C leaves\n"
            time.sleep(0.5)
            size = log.stat().st_size
            time.sleep(0.5)
            assert log.stat().st_size == size, "it has not begun"
            if opens:
                browser(url).wait_for_text("the run is over: restart it here, or press Ctrl-C", 60.0)
                assert run.stderr.readline() == "the run is over; the page stays. Press Ctrl-C to leave\n"
                assert run.poll() is None
            run.send_signal(signal.SIGINT)
            out, _ = run.communicate(timeout=20)
            assert run.returncode == status
            assert (json.loads(out)["ticks"] == 50) if opens else out == ""
