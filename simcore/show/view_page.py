"""The page itself: scene, score board and cameras on a local server. Live runs and replays add their buttons."""

from __future__ import annotations

from simcore.show.view_board import board_html
from simcore.show.view_cameras import CAMERAS, FIELD, STATION, STATIONS, ViewCameras, default_stations
from simcore.show.view_driving import ViewDriving
from simcore.show.view_models import ViewModels
from simcore.show.view_scene import ViewScene, robot_keys
from simcore.show.view_server import address, start_server, stop_server
from simcore.telemetry.snapshot import Snapshot

__all__ = ["CHARTS", "SPEEDS", "ViewPage"]

SPEEDS = {"0.1x": 0.1, "0.25x": 0.25, "0.5x": 0.5, "1x": 1.0, "2x": 2.0, "5x": 5.0, "max": float("inf")}
"""Simulated seconds a second, by what the page calls them."""
CHARTS = 2000.0
"""Order of charts on the page, which come last."""
_LAST = 1000.0  # order of what comes below the buttons of a run or a replay


class ViewPage:
    """A page that shows snapshots.

    Args:
        models: What to draw.
        host: Where to listen; `0.0.0.0` lets other computers look.
        port: 0 takes a free one.
        robot: Name of the robot model; empty: the first.
        title: Of the page.
        driving: The person at the page; None: nobody can drive.

    Raises:
        OutputError: The extra `view` is not installed, the port is taken, or viser cannot be guarded.
        ConfigError: No such port.
        UnknownNameError: No robot model of that name.
        ModelError: A model cannot be read.
    """

    def __init__(
        self,
        models: ViewModels,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        robot: str = "",
        title: str = "simcore",
        driving: ViewDriving | None = None,
    ) -> None:
        models.robot(robot)  # a wrong name shall not cost a started server
        self._closed = False
        self.server = start_server(host, port, title, driving)
        self.url = f"http://{address(host)}:{self.server.get_port()}"
        try:
            self._build(models, robot)
        except BaseException:
            self.close()
            raise

    @property
    def robot(self) -> int:
        """Number of the robot that was chosen."""
        return int(self._robot.value)

    @property
    def has_viewers(self) -> bool:
        """Whether somebody looks."""
        return bool(self.server.get_clients())

    def show(self, snapshot: Snapshot) -> None:
        """Draw one snapshot; returns at once, browsers get it from another thread."""
        robots = robot_keys(snapshot)
        self._offer_robots(robots)
        self.scene.draw(snapshot)
        self._board.content = board_html(snapshot, robots)

    def close(self) -> None:
        """Stop serving; may be called twice."""
        if not self._closed:
            self._closed = True
            stop_server(self.server)

    def __enter__(self) -> ViewPage:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def on_camera(self) -> None:
        """Called when the camera's mode changed; a replay that stands draws anew."""

    # --- inside -------------------------------------------------------------------------------------------------

    def _build(self, models: ViewModels, robot: str) -> None:
        server = self.server
        server.gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(30, 84, 183))
        server.gui.main_panel.dock_right()
        self.scene = ViewScene(server, models, robot=robot)
        size = self.scene.size
        stations = models.field.stations if models.field else ()
        self.cameras = ViewCameras(server, size, stations or default_stations(size))
        self._board = server.gui.add_html(board_html(Snapshot(time=0.0, tick=0), {}))
        self._camera = server.gui.add_dropdown("camera", CAMERAS, order=_LAST)
        self._robot = server.gui.add_dropdown("robot", ("0",), visible=False, order=_LAST)
        self._station = server.gui.add_dropdown("station", STATIONS, visible=False, order=_LAST)
        for choice in (self._camera, self._robot, self._station):
            choice.on_update(lambda _: self._move_cameras())

    def _offer_robots(self, robots: dict[int, str]) -> None:
        names = tuple(str(number) for number in robots)
        if len(names) > 1 and names != tuple(self._robot.options):
            self._robot.options = names
            self._robot.visible = True

    def _move_cameras(self) -> None:
        mode = self._camera.value
        self._station.visible = mode == STATION
        self.scene.follow = None if mode in (FIELD, STATION) else (int(self._robot.value), mode)
        self.cameras.mode, self.cameras.station = mode, self._station.value
        self.cameras.place()
        self.on_camera()
