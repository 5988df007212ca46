"""Where the view looks from: the whole field in any window, a driver station, or along with a robot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.typing import FloatArray

if TYPE_CHECKING:
    import viser

__all__ = [
    "BEHIND",
    "CAMERAS",
    "CHASE",
    "COVERED",
    "FIELD",
    "FOLLOW",
    "FOV",
    "STATION",
    "STATIONS",
    "ViewCameras",
    "default_stations",
    "station_eye",
    "whole_field",
]

FIELD, FOLLOW, BEHIND, STATION = "whole field", "follow robot", "behind robot", "driver station"
CAMERAS = (FIELD, FOLLOW, BEHIND, STATION)
"""What the page offers."""
STATIONS = ("blue 1", "blue 2", "blue 3", "red 1", "red 2", "red 3")
"""In the order of a field model's `driverStations`."""
CHASE = {FOLLOW: ((0.0, -4.0, 3.0), 0.2), BEHIND: ((-2.6, 0.0, 1.7), 0.4)}
"""Where cameras that follow stand, from the robot's center on the carpet, and how high over it they look [m]."""
FOV = 0.85
"""Vertical field of view [rad]."""
COVERED = 0.45
"""Share of a phone's screen, from below, that the page's buttons cover."""

_PHONE = 0.75  # width over height; narrower windows are phones
_HEIGHT = 2.0  # [m]; of what stands on a field
_MARGIN = 0.95  # share of the window that the field may fill
_SIDE, _END = math.radians(42.0), math.radians(62.0)  # how far the view looks down, from the side and from blue's end
_MUCH_NEARER = 0.85  # the usual view, from the side, is left where the other one is so much nearer
_EYE_HEIGHT = 1.57  # estimate: eyes of standing adults are at 1.5 m (women) and 1.63 m (men) in the mean
_BEFORE_GLASS = 0.05  # [m]; drivers stand behind it, but a picture through it is grey


def whole_field(
    size: tuple[float, float], aspect: float, *, fov: float = FOV, covered: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """A camera that shows the whole field as large as the window allows.

    From the side or, where that shows it larger, from behind the blue wall.

    Args:
        size: Length and width of the field [m].
        aspect: Width over height of the window.
        fov: Vertical field of view [rad].
        covered: Share of the window, from below, in which nothing is seen.

    Returns:
        Position of the camera, and the point on the carpet at which it looks [m], shape (3,) each.

    >>> position, _ = whole_field((16.0, 8.0), 1.5)
    >>> farther, _ = whole_field((16.0, 8.0), 1.2)
    >>> bool(farther[2] > position[2])
    True
    """
    length, width = size
    ground = np.array([(x, y, z) for x in (0.0, length) for y in (0.0, width) for z in (0.0, _HEIGHT)])
    middle = np.array([0.5 * length, 0.5 * width, 0.0])
    across = _MARGIN * aspect * math.tan(0.5 * fov)
    above = _MARGIN * math.tan(0.5 * fov)
    below = above * (1.0 - 2.0 * covered)
    found = []
    for down, (ahead_x, ahead_y) in ((_SIDE, (0.0, 1.0)), (_END, (1.0, 0.0))):
        back = np.array([-ahead_x * math.cos(down), -ahead_y * math.cos(down), math.sin(down)])
        right = np.array([ahead_y, -ahead_x, 0.0])
        up = np.cross(back, right)
        corners = ground - middle
        nearer, x, y = corners @ back, corners @ right, corners @ up
        # a corner at (x, y), nearer to the camera than the middle by so much, is inside at these distances and more
        top, bottom = float((y / above + nearer).max()), float((nearer - y / below).max())
        closest = (above * top + below * bottom) / (above + below)  # where the upper and the lower corners just fit
        distance = max(float((np.abs(x) / across + nearer).max()), closest)
        depth = distance - nearer
        shift = 0.5 * (float((y - above * depth).max()) + float((y + below * depth).min()))
        target = middle + shift * up
        eye = target + distance * back
        found.append((distance, eye, target - back * (target[2] / back[2])))
    (from_side, *side), (from_end, *end) = found
    eye, target = end if from_end < _MUCH_NEARER * from_side else side
    return eye, target


def default_stations(size: tuple[float, float]) -> tuple[tuple[float, float], ...]:
    """Driver stations of a field whose model has none: at a quarter, half and three quarters of each end wall [m]."""
    length, width = size
    blue = tuple((0.0, width * share) for share in (0.75, 0.5, 0.25))
    return (*blue, *((length, width - y) for _, y in blue))


def station_eye(size: tuple[float, float], station: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """What a driver sees who stands in a station, from just before the glass.

    Args:
        size: Length and width of the field [m].
        station: Its place, field frame [m].

    Returns:
        Position of the eye and the point at which it looks [m], shape (3,) each.
    """
    x, y = station
    x = size[0] - _BEFORE_GLASS if x > 0.5 * size[0] else _BEFORE_GLASS
    return np.array([x, y, _EYE_HEIGHT]), np.array([0.5 * size[0], 0.5 * (y + 0.5 * size[1]), 0.3])


class ViewCameras:
    """Places the cameras of all who look, anew when a window changes its shape.

    Args:
        server: Whose viewers.
        size: Length and width of the field [m].
        stations: Places of the driver stations, in the order of `STATIONS`, field frame [m].
    """

    def __init__(
        self, server: viser.ViserServer, size: tuple[float, float], stations: Sequence[tuple[float, float]]
    ) -> None:
        self._server = server
        self._size = size
        self._stations = stations
        self.mode = FIELD
        """One of `CAMERAS`."""
        self.station = STATIONS[0]
        """One of `STATIONS`."""
        self.covered = 0.0
        """Share of a window, from below, that buttons cover; of a phone's it is `COVERED`."""
        self._placed: dict[int, tuple[float, FloatArray]] = {}  # window's shape and camera, by viewer
        eye, target = whole_field(size, 1.15)
        server.initial_camera.position, server.initial_camera.look_at = tuple(eye.tolist()), tuple(target.tolist())
        server.initial_camera.fov = FOV
        server.on_client_connect(self._welcome)
        server.on_client_disconnect(lambda client: self._placed.pop(client.client_id, None))

    def place(self) -> None:
        """Move all cameras to where the mode has them."""
        for client in self._server.get_clients().values():
            self._place(client)

    def _welcome(self, client: viser.ClientHandle) -> None:
        self._place(client)
        client.camera.on_update(lambda _: self._fit(client))

    def _fit(self, client: viser.ClientHandle) -> None:
        """Show the whole field in a window of another shape, unless the user has moved the camera."""
        aspect, eye = self._placed.get(client.client_id, (0.0, np.zeros(3)))
        now = _aspect(client)
        is_moved = float(np.abs(client.camera.position - eye).max()) > 0.02
        if self.mode == FIELD and abs(now - aspect) > 0.005 and not is_moved:
            self._place(client)

    def _place(self, client: viser.ClientHandle) -> None:
        aspect = _aspect(client)
        eye, target = self._looks(aspect, client.camera.fov)
        self._placed[client.client_id] = (aspect, eye)
        with client.atomic():
            client.camera.position = tuple(eye.tolist())
            client.camera.look_at = tuple(target.tolist())
            client.camera.up_direction = (0.0, 0.0, 1.0)

    def _looks(self, aspect: float, fov: float) -> tuple[FloatArray, FloatArray]:
        if self.mode == STATION:
            return station_eye(self._size, self._stations[STATIONS.index(self.station)])
        covered = COVERED if aspect < _PHONE else self.covered
        if self.mode == FIELD:
            return whole_field(self._size, aspect, fov=fov, covered=covered)
        middle = np.array([0.5 * self._size[0], 0.5 * self._size[1], 0.0])
        far = 1.0 if aspect > 1.0 else 1.6  # a narrow window shows less beside the robot
        eye, look = CHASE[self.mode]
        return middle + far * np.array(eye), middle + np.array([0.0, 0.0, look - 1.5 * covered])


def _aspect(client: Any) -> float:
    width, height = client.camera.image_width, client.camera.image_height
    return width / height if width > 0 and height > 0 else 1.4
