"""Which tags a camera can read: in the picture, large enough, turned towards it, and with nothing in between."""

from __future__ import annotations

import math
from collections.abc import Container, Sequence

import numpy as np

from simcore.geometry.quaternion import Vector
from simcore.typing import BoolArray, FloatArray
from simcore.vision.camera import LimelightType
from simcore.vision.scene import Scene, hidden_by_spheres
from simcore.vision.tags import TagLayout

__all__ = ["FULL_CROP", "Corners", "Occlusion", "TagFinder", "crop_pixels"]

FULL_CROP = (-1.0, 1.0, -1.0, 1.0)
"""x0, x1, y0, y1 of a crop window; 1 is the right and the upper edge."""

Pixel = tuple[float, float]
Corners = tuple[Pixel, Pixel, Pixel, Pixel]
"""Pixels of a tag's lower left, lower right, upper right and upper left corner, as one faces it."""

_CELL = 0.25  # [m]
_NEAREST = 0.1  # [m]; a tag whose middle is closer to the lens is not in focus
_CLEAR = 0.05
"""Lines of sight end so far before the tag's face [m]: the mesh behind it stands up to 14 mm proud (trench arms), the
estimated shoulder of a hub 39 mm at one corner of tags 2, 5, 18 and 21."""
_EDGE_POINTS: FloatArray = np.array(
    [(x, y, 1) for x, y in ((-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (0, 0))], dtype=float
)
"""Where a tag must be uncovered, in halves of its edge: 8.3 cm apart, so that no fuel (15 cm) slips between."""
_MIDDLE = 8
_MOVED = 0.15  # [m]
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


class TagFinder:
    """Finds the tags that one camera would read if nothing stood in the way.

    Few of a field's tags can be read from a place, whichever way the camera looks. These candidates are worked out anew
    when the camera has moved by 25 cm; then they are looked at one by one, in plain floats: 35 us a frame, where all 32
    in arrays take 70.

    Args:
        layout: All tags.
        lens: Its picture.
    """

    def __init__(self, layout: TagLayout, lens: LimelightType) -> None:
        self._layout = layout
        self._lens = lens
        self._from: tuple[Vector, float, float] | None = None
        self._candidates: list[int] = []

    def find(
        self,
        pos: Vector,
        rotation: Sequence[Sequence[float]] | FloatArray,
        *,
        min_side: float,
        max_angle_deg: float,
        crop: tuple[float, float, float, float] = FULL_CROP,
        wanted: Container[int] | None = None,
    ) -> tuple[list[int], list[Corners]]:
        """Tags in the picture.

        Args:
            pos: Of the camera, field frame [m].
            rotation: From `optical_rows`, or `optical_rotation`.
            min_side: Shortest edge in the picture [px].
            max_angle_deg: Between a tag's normal and the way to the camera.
            crop: The part of the picture that is searched.
            wanted: Ids of tags that count; None: all.

        Returns:
            Their rows in the layout, and the pixels (u, v) of the four corners of each.
        """
        layout = self._layout
        self._follow(pos, min_side, max_angle_deg)
        (fx, fy), (cx, cy) = self._lens.focal_length, self._lens.principal_point
        left, right, top, bottom = crop_pixels(crop, self._lens)
        (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation
        px, py, pz = pos
        lean = math.cos(math.radians(max_angle_deg))
        rows: list[int] = []
        found: list[Corners] = []
        for row in self._candidates:
            if wanted is not None and layout.id_list[row] not in wanted:
                continue
            x, y, z = layout.center_list[row]
            x, y, z = x - px, y - py, z - pz
            if r20 * x + r21 * y + r22 * z < _NEAREST:
                continue
            nx, ny, nz = layout.normal_list[row]
            if -(nx * x + ny * y + nz * z) < lean * math.sqrt(x * x + y * y + z * z):
                continue
            corners: list[Pixel] = []
            for x, y, z in layout.corner_list[row]:
                x, y, z = x - px, y - py, z - pz
                depth = r20 * x + r21 * y + r22 * z
                if depth <= 0.0:
                    break
                u = fx * (r00 * x + r01 * y + r02 * z) / depth + cx
                v = fy * (r10 * x + r11 * y + r12 * z) / depth + cy
                if not (left <= u <= right and top <= v <= bottom):
                    break
                corners.append((u, v))
            if len(corners) == 4 and min(map(math.dist, corners, (*corners[1:], corners[0]))) >= min_side:
                rows.append(row)
                found.append((corners[0], corners[1], corners[2], corners[3]))
        return rows, found

    def _follow(self, pos: Vector, min_side: float, max_angle_deg: float) -> None:
        """The candidates: large enough and turned towards the camera, from anywhere within 25 cm of here."""
        last = self._from
        if last is not None and last[1:] == (min_side, max_angle_deg) and math.dist(last[0], pos) < _CELL:
            return
        self._from = (pos, min_side, max_angle_deg)
        layout, lens = self._layout, self._lens
        away = layout.centers - pos
        distance = np.linalg.norm(away, axis=1)
        before = -np.einsum("ij,ij->i", away, layout.normals)  # the tag's plane
        # Off the axis a tag is larger, by up to the square of 1 / cos; in the corner of the picture most.
        (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
        stretch = 1.0 + (cx / fx) ** 2 + (cy / fy) ** 2
        reach = max(fx, fy) * layout.size * stretch / min_side + _CELL
        lean = math.cos(math.radians(max_angle_deg))
        able = (distance < reach) & (before + _CELL > lean * (distance - _CELL))
        self._candidates = able.nonzero()[0].tolist()


class Occlusion:
    """Whether something stands between one camera and each tag.

    Pieces are tested as balls at nine points of a tag, in every frame. The field and robots are tested by rays to its
    corners and its middle, when the camera has moved by 15 cm or 0.1 s have passed: rays are what costs most.

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

    def uncovered(self, rows: Sequence[int], pos: Vector, scene: Scene, time: float) -> list[bool]:
        """Which of some tags have nothing between them and the camera.

        Args:
            rows: Of the tags in the layout.
            pos: Of the camera, field frame [m].
            scene: What can stand in the way.
            time: Now [s].
        """
        free: list[bool] = [True] * len(rows)
        pieces = scene.above(min(pos[2], self._lowest))
        if rows and len(pieces):
            points = self._points[rows].reshape(-1, 3)
            hidden = hidden_by_spheres(pos, points, pieces, scene.piece_radius)
            if hidden is not None:
                free = [not one.any() for one in hidden.reshape(len(rows), -1)]
        if scene.sight is not None:
            self._refresh(rows, pos, scene, time)
            free = [ok and self._known[row][2] for ok, row in zip(free, rows, strict=True)]
        return free

    def _refresh(self, rows: Sequence[int], pos: Vector, scene: Scene, time: float) -> None:
        """Cast rays to the tags of which nothing is known from about here and now."""
        known = self._known
        old: list[int] = []
        for row in rows:
            last = known.get(row)
            if last is None or not 0.0 <= time - last[0] < _STALE or math.dist(last[1], pos) > _MOVED:
                old.append(row)
        if not old or scene.sight is None:
            return
        ends = self._points[old]
        # The middle first: most tags that are hidden are hidden there.
        free: BoolArray = ~scene.sight.blocked(self._robot, pos, ends[:, _MIDDLE])
        left = free.nonzero()[0]
        if len(left):
            corners = ends[left, :_MIDDLE:2].reshape(-1, 3)
            free[left] = ~scene.sight.blocked(self._robot, pos, corners).reshape(-1, 4).any(axis=1)
        for row, is_free in zip(old, free.tolist(), strict=True):
            known[row] = (time, pos, is_free)
