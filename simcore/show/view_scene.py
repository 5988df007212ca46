"""Draws snapshots with viser: field, robots with their parts, pieces, trails, cameras.

What there is to draw follows from the keys alone (docs/telemetry.md), so that any game's snapshots will do. Server and
controls are in `view_page`.
"""

from __future__ import annotations

import contextlib
import math
import re
import threading
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.geometry.rotation import matrix
from simcore.show.glb import PieceMesh, box_glb, linear_rgba, look_mesh, painted_glb, piece_mesh
from simcore.show.scene import PLAIN_PIECE
from simcore.show.scope_assets import HANGING
from simcore.show.view_follow import FollowCamera, robot_top
from simcore.show.view_models import Model, RobotModels, ViewModels
from simcore.show.view_trails import Trails
from simcore.telemetry.snapshot import Snapshot
from simcore.typing import FloatArray

if TYPE_CHECKING:
    import viser

    from simcore.show.shot_preview import ShotPath

__all__ = ["ViewScene", "add_sun", "robot_keys"]

_ROBOT = re.compile(r"^Sim/(Robots/(\d+)/)?Robot/Pose3d$")
_CAMERA = re.compile(r"^Sim/Limelights/.+/(DirectionLine|SeenTags)$")
_PIECES, _FLYING = ("Sim/GamePieces/", "Sim/Held/", f"Sim/{HANGING}"), "Sim/InFlight/"
_BLUE, _RED = (30, 84, 183), (196, 40, 40)
_TRAIL, _CAMERA_COLOR = (255, 120, 20), (20, 200, 140)
_PREVIEW = (235, 60, 200)  # a hue of nothing else here; hit and miss differ by form
_PLAIN_FIELD = (16.0, 8.0)  # [m]; without a model of a field
_PLAIN_ROBOT = (0.8, 0.8, 0.25)  # [m]; without a model of a robot
_FRUSTUM = 0.35  # [m] long, drawn as a sign of where a camera looks
_MARK_SIZE = 0.15  # [m]
_CROSS = np.array([((-1, -1, 0), (1, 1, 0)), ((-1, 1, 0), (1, -1, 0)), ((0, 0, -1), (0, 0, 1))], dtype=np.float64)
_CORNERS = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], dtype=np.float64)
_SQUARE = np.stack((_CORNERS, np.roll(_CORNERS, -1, axis=0)), axis=1)
_SETTLE = 3.0  # [s]
_FAST = 0.1  # [s] for a picture of 640 x 360, there and back; software takes 0.2 to 1
_NO_LINES = np.zeros((1, 2, 3), dtype=np.float32)  # viser takes no empty lines


def robot_keys(snapshot: Snapshot) -> dict[int, str]:
    """Number and key prefix of each robot in a snapshot, e.g. `{0: "Sim", 1: "Sim/Robots/1"}`."""
    found = {}
    for key in snapshot.poses:
        match = _ROBOT.match(key)
        if match:
            found[int(match[2] or 0)] = f"Sim/Robots/{match[2]}" if match[1] else "Sim"
    return dict(sorted(found.items()))


def add_sun(
    client: viser.ClientHandle, connected: Callable[[], Mapping[int, object]], *, settle: float = _SETTLE
) -> None:
    """Give a browser its sun, and shadows as soon as it has shown that it draws fast.

    Where there is no graphics card, shadows take half of the frames.

    Args:
        client: Who looks.
        connected: All who look, by their numbers.
        settle: How long it may take to load the scene, before it is measured [s].
    """
    sun = client.scene.add_light_directional(
        "/light/sun", intensity=1.8, cast_shadow=False, position=(4.0, -6.0, 14.0), color=(255, 250, 240)
    )

    def measure() -> None:
        warnings.filterwarnings("ignore", "Queued a GetRenderRequestMessage")  # viser, of a page that is being closed
        with contextlib.suppress(RuntimeError, TimeoutError):  # it leaves, or does not answer
            for _ in range(3):  # the first one compiles shaders
                if client.client_id not in connected():
                    return
                begun = time.perf_counter()
                client.get_render(height=360, width=640, timeout=5.0)
                if time.perf_counter() - begun < _FAST:
                    sun.cast_shadow = True
                    return

    timer = threading.Timer(settle, measure)
    timer.daemon = True
    timer.start()


class ViewScene:
    """The world on a viser server.

    Args:
        server: Where to draw.
        models: Files of field, robot and pieces; plain shapes stand in for what is missing.
        robot: Name of the robot model; empty: the first.
    """

    def __init__(self, server: viser.ViserServer, models: ViewModels, *, robot: str = "") -> None:
        self._server = server
        self._models = models
        self._robot_models = models.robot(robot)
        self.size = models.field.size if models.field else _PLAIN_FIELD
        """Length and width of the field [m]."""
        self.follow: tuple[int, str] | None = None
        """The robot that stays in the middle, and how: `FOLLOW` or `BEHIND`; None for the whole field."""
        self.previews: Sequence[ShotPath] = ()
        """What shots would do now; drawn with the next snapshot."""
        self._robots: dict[int, _RobotNode] = {}
        self._pieces: dict[str, _PieceNode] = {}
        self._trails: dict[str, Trails] = {}
        self._lines: dict[str, Any] = {}
        self._follow_camera = FollowCamera(models.field.body if models.field else None, self.center)
        self._world = server.scene.add_frame("/world", show_axes=False)
        self._light()
        self._add_field()

    @property
    def center(self) -> tuple[float, float, float]:
        """Of the field; a followed robot is brought here [m]."""
        return (self.size[0] / 2.0, self.size[1] / 2.0, 0.0)

    def draw(self, snapshot: Snapshot) -> None:
        """Show one snapshot; what it does not mention stays away."""
        with self._server.atomic():
            robots = robot_keys(snapshot)
            for number, prefix in robots.items():
                node = self._robots.get(number)
                if node is None:
                    node = self._robots[number] = _RobotNode(self._server, number, self._robot_models)
                node.draw(snapshot, prefix)
            for number in self._robots.keys() - robots.keys():
                self._robots.pop(number).remove()
            there = {key: rows for key, rows in snapshot.pose_arrays.items() if key.startswith(_PIECES)}
            for key, rows in there.items():
                self._draw_pieces(key, rows)
            for key in self._pieces.keys() - there.keys():
                self._pieces[key].draw(np.zeros((0, 7)))
            self._draw_trails(snapshot)
            self._draw_previews()
            self._draw_cameras(snapshot)
            self._move_world(snapshot, robots)
        self._server.flush()

    def forget(self) -> None:
        """After a jump in time: trails begin anew."""
        self._trails.clear()

    # --- inside -------------------------------------------------------------------------------------------------

    def _light(self) -> None:
        scene = self._server.scene
        scene.set_up_direction("+z")
        scene.world_axes.visible = False
        scene.configure_default_lights(enabled=False)
        scene.configure_environment_map(None)
        scene.add_light_hemisphere("/light/sky", sky_color=(255, 255, 255), ground_color=(150, 150, 155), intensity=2.4)
        self._server.on_client_connect(lambda client: add_sun(client, self._server.get_clients))
        shade = np.linspace(0.0, 1.0, 64)[:, None, None]
        image = (1.0 - shade) * np.array((176, 196, 222)) + shade * np.array((238, 241, 245))
        scene.set_background_image(np.repeat(image, 2, axis=1).astype(np.uint8), format="png")

    def _add_field(self) -> None:
        field = self._models.field
        if field is not None:
            _add_glb(self._server, "/world/field", field.body)
            return
        length, width = self.size
        self._server.scene.add_box(
            "/world/field",
            dimensions=(length, width, 0.02),
            position=(length / 2, width / 2, -0.011),
            color=(92, 97, 104),
        )

    def _draw_pieces(self, key: str, rows: FloatArray) -> None:
        node = self._pieces.get(key)
        if node is None:
            field, name = self._models.field, key.rpartition("/")[2]
            model = field.pieces.get(name) if field else None
            mesh = piece_mesh(model) if model else look_mesh(self._models.pieces.get(name, PLAIN_PIECE))
            node = self._pieces[key] = _PieceNode(self._server, key, mesh)
        node.draw(rows)

    def _draw_trails(self, snapshot: Snapshot) -> None:
        lines = [np.zeros((0, 2, 3))]
        for key, rows in snapshot.pose_arrays.items():
            if key.startswith(_FLYING):
                trails = self._trails.setdefault(key, Trails())
                ids = snapshot.integer_arrays.get(key.replace(_FLYING, "Sim/InFlightIds/"), ())
                trails.update(snapshot.time, list(ids), rows[:, :3])
                lines.append(trails.segments())
        self._set_lines("/world/trails", np.concatenate(lines), _TRAIL, 3.0)

    def _draw_previews(self) -> None:
        """A whole line and a cross at its end for a shot that would score, a dashed one with a square for a miss."""
        lines = [np.zeros((0, 2, 3))]
        for path in self.previews:
            segments = np.stack((path.points[:-1], path.points[1:]), axis=1)
            lines.append(segments if path.zone else segments[::2])
            lines.append(path.landing + _MARK_SIZE * (_CROSS if path.zone else _SQUARE))
        self._set_lines("/world/previews", np.concatenate(lines), _PREVIEW, 3.0)

    def _draw_cameras(self, snapshot: Snapshot) -> None:
        lines = [np.zeros((0, 2, 3))]
        for key, rows in snapshot.pose_arrays.items():
            match = _CAMERA.match(key)
            if match and len(rows):
                lines.append(np.stack((rows[:-1, :3], rows[1:, :3]), axis=1))
                if match[1] == "DirectionLine":
                    lines.append(_frustum(rows[0]))
        self._set_lines("/world/cameras", np.concatenate(lines), _CAMERA_COLOR, 2.0)

    def _set_lines(self, name: str, segments: FloatArray, color: tuple[int, int, int], width: float) -> None:
        node = self._lines.get(name)
        if not len(segments):
            if node is not None:
                node.visible = False
            return
        if node is None:
            node = self._lines[name] = self._server.scene.add_line_segments(
                name, points=_NO_LINES, colors=color, thickness=width, thickness_units="screen"
            )
        node.points = segments.astype(np.float32)
        node.visible = True

    def _move_world(self, snapshot: Snapshot, robots: dict[int, str]) -> None:
        position, yaw = np.zeros(3), 0.0
        if self.follow is not None and self.follow[0] in robots:
            prefix = robots[self.follow[0]]
            rows = snapshot.pose_arrays.get(f"{prefix}/Robot/ComponentPoses", np.zeros((0, 7)))
            pose = snapshot.poses[f"{prefix}/Robot/Pose3d"]
            position, yaw = self._follow_camera.world_pose(self.follow[1], pose, robot_top(self._robot_models, rows))
        self._world.position = tuple(position.tolist())
        self._world.wxyz = (math.cos(yaw / 2.0), 0.0, 0.0, math.sin(yaw / 2.0))


class _RobotNode:
    """One robot and its parts."""

    def __init__(self, server: viser.ViserServer, number: int, models: RobotModels | None) -> None:
        self._server, self._models, self._path = server, models, f"/world/robot_{number}"
        self._frame = server.scene.add_frame(self._path, show_axes=False)
        self._is_red: bool | None = None
        self._body: Any = None
        self._parts: list[Any] = []
        self._placed: dict[int, bytes] = {}
        for i, part in enumerate(models.parts if models else ()):
            frame = server.scene.add_frame(f"{self._path}/part_{i}", show_axes=False, visible=False)
            _add_glb(server, f"{self._path}/part_{i}/model", part)
            self._parts.append(frame)

    def draw(self, snapshot: Snapshot, prefix: str) -> None:
        """Pose of the robot, its parts and the color of its bumpers."""
        is_red = snapshot.booleans.get(f"{prefix}/Robot/IsRed", False)
        if is_red != self._is_red:
            self._is_red = is_red
            self._paint(_RED if is_red else _BLUE)
        _place(self._frame, snapshot.poses[f"{prefix}/Robot/Pose3d"])
        rows = snapshot.pose_arrays.get(f"{prefix}/Robot/ComponentPoses", np.zeros((0, 7)))
        for i, (frame, row) in enumerate(zip(self._parts, rows, strict=False)):
            value = row.tobytes()
            if self._placed.get(i) != value:  # viser compares too, but takes 80 us for it
                if i not in self._placed:
                    frame.visible = True
                self._placed[i] = value
                _place(frame, row)

    def remove(self) -> None:
        """Take it away."""
        self._frame.remove()

    def _paint(self, color: tuple[int, int, int]) -> None:
        if self._body is not None:
            self._body.remove()
        name = f"{self._path}/body"
        if self._models is None:
            self._body = self._server.scene.add_glb(name, box_glb(_PLAIN_ROBOT, 0.15, color))
        else:
            self._body = _add_glb(self._server, name, self._models.body, painted_glb(self._models.body.path, color))


class _PieceNode:
    """All pieces of one kind: one mesh, drawn once for each."""

    def __init__(self, server: viser.ViserServer, name: str, mesh: PieceMesh) -> None:
        self._server, self._name = server, name
        self._mesh = mesh
        self._node: Any = None
        self._rows: FloatArray | None = None

    def draw(self, rows: FloatArray) -> None:
        """Pose rows of all of them; nothing is sent while they stay the same."""
        if rows is self._rows:
            return
        self._rows = rows
        if not len(rows):
            if self._node is not None:
                self._node.visible = False
            return
        pos, quat = rows[:, :3].astype(np.float32), rows[:, 3:].astype(np.float32)
        if self._node is None:
            vertices, faces, screen = self._mesh
            r, g, b = (round(255.0 * c) for c in linear_rgba(screen)[:3])  # viser takes these as linear in light
            self._node = self._server.scene.add_batched_meshes_simple(
                f"/world/pieces/{self._name}",
                vertices,
                faces,
                batched_wxyzs=quat,
                batched_positions=pos,
                batched_colors=(r, g, b),
                lod="off",
            )
        self._node.batched_wxyzs = quat
        self._node.batched_positions = pos
        self._node.visible = True


def _place(node: Any, row: FloatArray) -> None:
    x, y, z, qw, qx, qy, qz = row.tolist()
    node.position = (x, y, z)
    node.wxyz = (qw, qx, qy, qz)


def _add_glb(server: viser.ViserServer, name: str, model: Model, data: bytes | None = None) -> Any:
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(model.transform[:3, :3]).as_quat().tolist()
    position = tuple(model.transform[:3, 3].tolist())
    content = model.path.read_bytes() if data is None else data
    return server.scene.add_glb(name, content, wxyz=(w, x, y, z), position=position)


def _frustum(row: FloatArray) -> FloatArray:
    """A small pyramid along a camera's axis, not its true field of view [m], shape (8, 2, 3)."""
    tip, (w, x, y, z) = row[:3], row[3:]
    base = np.array([(1.0, 0.55, 0.4), (1.0, -0.55, 0.4), (1.0, -0.55, -0.4), (1.0, 0.55, -0.4)])
    corners = tip + _FRUSTUM * base @ matrix((x, y, z, w)).T
    edges = [(tip, corner) for corner in corners] + [(corners[i - 1], corners[i]) for i in range(4)]
    return np.array(edges)
