"""The page itself: a local web server with scene, score and camera. Live runs and replays add their buttons.

The one module that starts viser, and only when a page is made: without the extra everything else runs.
"""

from __future__ import annotations

import html
import itertools
import math
import os
import re
import socket
import sys
import threading
import webbrowser
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import rich

from simcore.errors import ConfigError, OutputError
from simcore.install_text import install_command
from simcore.show.view_models import ViewModels
from simcore.show.view_scene import ViewScene, robot_keys
from simcore.telemetry.snapshot import Snapshot

if TYPE_CHECKING:
    import viser

__all__ = ["SPEEDS", "ViewPage", "clock_text", "lights_html", "open_browser", "score_html"]

SPEEDS = {"0.1x": 0.1, "0.25x": 0.25, "0.5x": 0.5, "1x": 1.0, "2x": 2.0, "5x": 5.0, "max": float("inf")}
"""Simulated seconds a second, by what the page calls them."""

_BOX = "flex:1;padding:6px 0;color:#fff;text-align:center;border-radius:6px;font-size:26px;font-weight:700"
_MOST_SQUARES = 24  # of a strip of lights
_FIELD, _FOLLOW, _BEHIND = "whole field", "follow robot", "behind robot"


_quiet_lock = threading.Lock()
_quiet_count = 0


class ViewPage:
    """A page that shows snapshots.

    Args:
        models: What to draw.
        host: Where to listen; `0.0.0.0` lets other computers look.
        port: 0 takes a free one.
        robot: Name of the robot model; empty: the first.
        title: Of the page.

    Raises:
        OutputError: The extra `view` is not installed, or the port is taken.
        ConfigError: No such port.
        UnknownNameError: No robot model of that name.
        ModelError: A model cannot be read.
    """

    def __init__(
        self, models: ViewModels, *, host: str = "127.0.0.1", port: int = 0, robot: str = "", title: str = "simcore"
    ) -> None:
        models.robot(robot)  # a wrong name shall not cost a started server
        self._closed = False
        self.server = _start(host, port, title)
        self.url = f"http://{'127.0.0.1' if host in ('', '0.0.0.0') else host}:{self.server.get_port()}"
        try:
            self._build(models, robot)
        except BaseException:
            self.close()
            raise

    def show(self, snapshot: Snapshot) -> None:
        """Draw one snapshot; returns at once, browsers get it from another thread."""
        robots = robot_keys(snapshot)
        self._offer_robots(robots)
        self.scene.draw(snapshot)
        self._score.content = score_html(snapshot, robots)

    def close(self) -> None:
        """Stop serving; may be called twice."""
        if not self._closed:
            self._closed = True
            # A browser keeps a spare connection open; viser waits up to ten seconds for it. The port is free at once.
            stopping = threading.Thread(target=_stop, args=(self.server,), daemon=True)
            stopping.start()
            stopping.join(0.3)

    def __enter__(self) -> ViewPage:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- inside -------------------------------------------------------------------------------------------------

    def _build(self, models: ViewModels, robot: str) -> None:
        server = self.server
        server.gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(30, 84, 183))
        server.gui.main_panel.dock_right()
        self.scene = ViewScene(server, models, robot=robot)
        self._score = server.gui.add_html(score_html(Snapshot(time=0.0, tick=0), {}))
        x, y, _ = self.scene.center
        length = self.scene.size[0]
        self._home = ((x, y - 0.76 * length, 0.66 * length), (x, y - 0.03 * length, 0.0))
        server.initial_camera.position, server.initial_camera.look_at = self._home
        server.initial_camera.fov = 0.85
        last = 1000.0  # below the buttons of a run or a replay, which come later
        self._camera = server.gui.add_dropdown("camera", (_FIELD, _FOLLOW, _BEHIND), order=last)
        self._robot = server.gui.add_dropdown("robot", ("0",), visible=False, order=last)
        self._camera.on_update(lambda _: self._move_cameras())
        self._robot.on_update(lambda _: self._move_cameras())

    def _offer_robots(self, robots: dict[int, str]) -> None:
        names = tuple(str(number) for number in robots)
        if len(names) > 1 and names != tuple(self._robot.options):
            self._robot.options = names
            self._robot.visible = True

    def _move_cameras(self) -> None:
        mode = self._camera.value
        self.scene.follow = None if mode == _FIELD else (int(self._robot.value), mode == _BEHIND)
        position, look_at = self._home
        if mode != _FIELD:
            x, y, _ = self.scene.center
            position, look_at = (
                ((x - 2.6, y, 1.7), (x, y, 0.4)) if mode == _BEHIND else ((x, y - 4.0, 3.0), (x, y, 0.2))
            )
        for client in self.server.get_clients().values():
            with client.atomic():
                client.camera.position = position
                client.camera.look_at = look_at
                client.camera.up_direction = (0.0, 0.0, 1.0)
        self.on_camera()

    def on_camera(self) -> None:
        """Called when the camera's mode changed; a replay that stands draws anew."""


def open_browser(url: str) -> str:
    """Try to open a page; returns one sentence about what the user sees or has to do."""
    headless = sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    if headless:
        return f"no display here: open {url} in a browser on this computer"
    try:
        opened = webbrowser.open(url)
    except (webbrowser.Error, OSError):
        opened = False
    return f"the view is at {url}" if opened else f"no browser found: open {url} yourself"


def _start(host: str, port: int, title: str) -> viser.ViserServer:
    if not 0 <= port <= 65535:
        raise ConfigError(f"a port is 1 to 65535, or 0 for a free one, got {port}")
    try:
        import viser
    except ImportError as error:
        raise OutputError(f"the browser view needs the extra 'view': {install_command('view')} ({error})") from error
    with socket.socket() as probe:
        if sys.platform != "win32":
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise OutputError(
                f"cannot serve the view on {host or 'any address'}:{port}: {error.strerror or error}. "
                "Another view may be running: end it, or leave the port out for a free one"
            ) from error
        free: Any = probe.getsockname()[1]
    with _quiet():
        return viser.ViserServer(host=host, port=int(free), label=title, verbose=False)


def _stop(server: viser.ViserServer) -> None:
    with _quiet():
        server.stop()
        loop = getattr(getattr(server, "_websock_server", None), "_server_thread", None)
        if loop is not None:
            loop.join(15.0)  # its last word shall be unheard too


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep viser's messages off stdout, which is for the report: it prints them through rich's console."""
    global _quiet_count
    console = rich.get_console()
    with _quiet_lock:
        _quiet_count += 1
        console.quiet = True
    try:
        yield
    finally:
        with _quiet_lock:
            _quiet_count -= 1
            console.quiet = _quiet_count > 0


def clock_text(seconds: float) -> str:
    """Minutes, seconds and tenths.

    >>> clock_text(83.26)
    '1:23.3'
    """
    tenths = max(0, round(10.0 * seconds))
    return f"{tenths // 600}:{tenths // 10 % 60:02d}.{tenths % 10}"


def score_html(snapshot: Snapshot, robots: Mapping[int, str]) -> str:
    """The board for a snapshot.

    Args:
        snapshot: What is known; a missing number is left out.
        robots: Number and key prefix of each robot.
    """
    score, doubles = snapshot.integers, snapshot.doubles
    boxes = "".join(
        f'<div style="{_BOX};background:{color}">{score.get(f"Sim/Score/{name}", 0)}</div>'
        for name, color in (("Blue", "#1e54b7"), ("Red", "#c42828"))
    )
    clock = clock_text(doubles.get("Sim/Match/Time", snapshot.time))
    left = doubles.get("Sim/Match/TimeLeft")
    rest = "" if left is None else f'<span style="color:#667;font-size:14px"> {clock_text(left)} left</span>'
    lines = []
    pieces = {k.removeprefix("Sim/GamePieces/"): len(v) for k, v in snapshot.pose_arrays.items() if "/GamePieces/" in k}
    lines += [f"{name.lower()} on the field <b>{count}</b>" for name, count in pieces.items()]
    if "Sim/Shots" in score:
        lines.append(f"shots <b>{score['Sim/Shots']}</b>, hits <b>{score.get('Sim/Hits', 0)}</b>")
    for number, prefix in robots.items():
        held = score.get(f"{prefix}/Intake/HeldCount")
        volts = doubles.get(f"{prefix}/Debug/BatteryVoltage")
        parts = [] if held is None else [f"holds <b>{held}</b>"]
        parts += [] if volts is None else [f"battery <b>{volts:.1f} V</b>"]
        if parts:
            name = "robot" if len(robots) == 1 else f"robot {number}"
            lines.append(f"{name}: {', '.join(parts)}")
        lights = re.compile(rf"^{prefix}/Lights/([^/]+)/Colors$")
        lines += [
            f"{html.escape(match[1])} {lights_html(colors.tolist())}"
            for key, colors in snapshot.integer_arrays.items()
            if (match := lights.match(key))
        ]
    body = "<br>".join(line if "<" in line else html.escape(line) for line in lines)
    return (
        '<div style="padding:6px 14px 2px;font-family:system-ui,sans-serif">'
        f'<div style="display:flex;gap:6px">{boxes}</div>'
        f'<div style="font-size:24px;font-variant-numeric:tabular-nums;margin:4px 0">{clock}{rest}</div>'
        f'<div style="font-size:14px;line-height:1.5">{body}</div></div>'
    )


def lights_html(colors: Sequence[int]) -> str:
    """A strip of lights as squares: one per LED, or each for several LEDs of a long strip.

    Args:
        colors: 0xRRGGBB of each LED; below zero: of changing colors.
    """
    step = max(1, math.ceil(len(colors) / _MOST_SQUARES))
    text = ""
    for color, run in itertools.groupby(colors[::step]):
        squares = "\u25a0" * len(list(run))
        text += f'<span style="color:#{color:06x}">{squares}</span>' if color >= 0 else "\u25a8" * len(squares)
    return text
