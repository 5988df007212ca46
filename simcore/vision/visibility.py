"""Which tags a camera can read: in the picture, large enough, turned towards it, and with nothing in between."""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.quaternion import Vector
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.vision.camera import LimelightType
from simcore.vision.scene import Scene, hidden_by_spheres
from simcore.vision.tags import TagLayout

__all__ = ["FULL_CROP", "Occlusion", "crop_pixels", "tags_in_picture"]

FULL_CROP = (-1.0, 1.0, -1.0, 1.0)
"""x0, x1, y0, y1 of a crop window; 1 is the right and the upper edge."""

_NEAREST = 0.1  # [m]; a tag whose middle is closer to the lens is not in focus
_CLEAR = 0.05
"""Lines of sight end so far before the tag's face [m]: the mesh behind it stands up to 14 mm proud (trench arms), the
estimated shoulder of a hub 39 mm at one corner of tags 2, 5, 18 and 21."""
_EDGE_POINTS: FloatArray = np.array(
    [(x, y, 1) for x, y in ((-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (0, 0))], dtype=float
)
"""Where a tag must be uncovered, in halves of its edge: 8.3 cm apart, so that no fuel (15 cm) slips between."""
_MIDDLE = 8
_MOVED = 0.05  # [m]
_STALE = 0.1  # [s]


def crop_pixels(crop: tuple[float, float, float, float], lens: LimelightType) -> tuple[float, float, float, float]:
    """Least u, most u, least v, most v of a crop window [px]."""
    x0, x1, y0, y1 = crop
    return (
        0.5 * (x0 + 1.0) * lens.width,
        0.5 * (x1 + 1.0) * lens.width,
        0.5 * (1.0 - y1) * lens.height,
        0.5 * (1.0 - y0) * lens.height,
    )


def tags_in_picture(
    layout: TagLayout,
    pos: Vector,
    rotation: FloatArray,
    lens: LimelightType,
    *,
    min_side: float,
    max_angle_deg: float,
    crop: tuple[float, float, float, float] = FULL_CROP,
    wanted: BoolArray | None = None,
) -> tuple[IntArray, FloatArray]:
    """Tags that would be read if nothing stood in the way.

    Args:
        layout: All tags.
        pos: Of the camera, field frame [m].
        rotation: From `optical_rotation`.
        lens: Its picture.
        min_side: Shortest edge in the picture [px].
        max_angle_deg: Between a tag's normal and the way to the camera.
        crop: The part of the picture that is searched.
        wanted: Which tags of the layout count, shape (n,); None: all.

    Returns:
        Their rows in the layout, shape (k,), and the pixels of their corners, shape (k, 4, 2).
    """
    # Two products sort out most tags, then corners are projected, then the few that are left are looked at one by one.
    axis = rotation[2]
    px, py, pz = pos
    here = np.array((px, py, pz, 1.0))
    ahead = layout.centers @ axis > float(axis[0]) * px + float(axis[1]) * py + float(axis[2]) * pz + _NEAREST
    ahead &= layout.facing @ here > 0.0
    if wanted is not None:
        ahead &= wanted
    rows = ahead.nonzero()[0]
    p = (layout.corners[rows] - here[:3]) @ rotation.T
    (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = p[..., :2] / p[..., 2:] * (fx, fy) + (cx, cy)
    left, right, top, bottom = crop_pixels(crop, lens)
    inside = ((pixels >= (left, top)) & (pixels <= (right, bottom))).reshape(-1, 8).all(axis=1)
    lean = math.cos(math.radians(max_angle_deg))
    kept = []
    for k in inside.nonzero()[0].tolist():
        (x0, y0), (x1, y1), (x2, y2), (x3, y3) = pixels[k].tolist()
        row = rows[k]
        ax, ay, az = layout.center_list[row]
        toward = float(layout.facing[row] @ here)
        shortest = min(
            math.hypot(x1 - x0, y1 - y0),
            math.hypot(x2 - x1, y2 - y1),
            math.hypot(x3 - x2, y3 - y2),
            math.hypot(x0 - x3, y0 - y3),
        )
        away = math.sqrt((ax - px) ** 2 + (ay - py) ** 2 + (az - pz) ** 2)
        if shortest >= min_side and toward >= lean * away and p[k, :, 2].min() > 0.0:
            kept.append(k)
    return rows[kept], pixels[kept]


class Occlusion:
    """Whether something stands between one camera and each tag.

    Pieces are tested as balls at nine points of a tag, in every frame. The field and robots are tested by rays to its
    corners and its middle, when the camera has moved by 5 cm or 0.1 s have passed: rays are what costs most.

    Args:
        layout: The tags.
        robot: Number of the robot that carries the camera.
    """

    def __init__(self, layout: TagLayout, robot: int) -> None:
        self._layout = layout
        self._robot = robot
        half = 0.5 * layout.size
        offsets = _EDGE_POINTS * (half, half, _CLEAR)
        self._points = offsets @ layout.square_axes + layout.centers[:, None, :]
        self._lowest = float(self._points[:, :, 2].min(initial=math.inf))
        self._known: dict[int, tuple[float, Vector, bool]] = {}

    def uncovered(self, rows: IntArray, pos: Vector, scene: Scene, time: float) -> BoolArray:
        """Which of some tags have nothing between them and the camera, shape (k,).

        Args:
            rows: Of the tags in the layout.
            pos: Of the camera, field frame [m].
            scene: What can stand in the way.
            time: Now [s].
        """
        free = np.ones(len(rows), dtype=bool)
        if not len(rows):
            return free
        pieces = scene.above(min(pos[2], self._lowest))
        if len(pieces):
            points = self._points[rows].reshape(-1, 3)
            hidden = hidden_by_spheres(pos, points, pieces, scene.piece_radius)
            if hidden is not None:
                free = ~hidden.reshape(len(rows), -1).any(axis=1)
        if scene.sight is not None:
            self._refresh(rows, pos, scene, time)
            for k, row in enumerate(rows.tolist()):
                if not self._known[row][2]:
                    free[k] = False
        return free

    def _refresh(self, rows: IntArray, pos: Vector, scene: Scene, time: float) -> None:
        """Cast rays to the tags of which nothing is known from about here and now."""
        known, old = self._known, []
        for row in rows.tolist():
            last = known.get(row)
            if last is None or not 0.0 <= time - last[0] < _STALE or math.dist(last[1], pos) > _MOVED:
                old.append(row)
        if not old or scene.sight is None:
            return
        ends = self._points[old]
        free = ~scene.sight.blocked(self._robot, pos, ends[:, _MIDDLE])  # most that are hidden are so in their middle
        left = free.nonzero()[0]
        if len(left):
            corners = ends[left, :_MIDDLE:2].reshape(-1, 3)
            free[left] = ~scene.sight.blocked(self._robot, pos, corners).reshape(-1, 4).any(axis=1)
        for row, is_free in zip(old, free.tolist(), strict=True):
            known[row] = (time, pos, is_free)
