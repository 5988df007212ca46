"""Which tags a camera can read: in the picture, large enough, turned towards it, and with nothing in between."""

from __future__ import annotations

import math
from collections.abc import Container, Sequence

import numpy as np

from simcore.geometry.rotation import Vector
from simcore.typing import BoolArray, FloatArray
from simcore.vision.camera import FULL_CROP, LimelightType, crop_pixels
from simcore.vision.camera_frame import Corners
from simcore.vision.camera_scene import CameraScene, SightLines, hidden_by_spheres
from simcore.vision.tag_layout import TagLayout

__all__ = ["Occlusion", "TagFinder"]

_CELL = 0.25  # [m]
_NEAREST = 0.1  # [m]; a tag whose middle is closer to the lens is not in focus
_CLEAR = 0.05
"""Lines of sight end so far before the tag's face [m]: the mesh of what carries it stands up to 14 mm proud, at some
corners up to 39 mm (measured on the field of 2026)."""
_EDGE_POINTS: FloatArray = np.array(
    [(x, y, 1) for x, y in ((-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (0, 0))], dtype=float
)
"""Where a tag must be uncovered, in halves of its edge: 8.3 cm apart, so that no piece of 15 cm slips between."""
_MIDDLE = 8
_RAYS = (0, 2, 4, 6, _MIDDLE)  # of these points: corners and middle
_MOVED = 0.3  # [m]; what the fastest obstacle does in `_STALE`
_STALE = 0.1  # [s]
_SPREAD = 1.0  # edges; no point of a tag is farther than 0.8 from its middle
_FEW = 24  # balls up to which plain floats are faster


class TagFinder:
    """Finds the tags that one camera would read if nothing stood in the way.

    Few of a field's tags can be read from a place, whichever way the camera looks. These candidates are worked out anew
    when the camera has moved by 25 cm; then they are looked at one by one, in plain floats: 15 us a frame, where all 32
    in arrays take 70. Conditions are asked in the order in which most candidates fail them.

    Args:
        layout: All tags.
        lens: Its picture.
    """

    def __init__(self, layout: TagLayout, lens: LimelightType) -> None:
        self._layout = layout
        self._lens = lens
        self._from: Vector | None = None
        self._limits = (-1.0, -1.0)
        """Least side [px] and largest angle [deg] that the candidates are for."""
        self._lean = 0.0
        """Cosine of the largest angle."""
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
        if (
            self._from is None
            or math.dist(self._from, pos) >= _CELL
            or self._limits[0] != min_side
            or self._limits[1] != max_angle_deg
        ):
            self._follow(pos, min_side, max_angle_deg)
        (fx, fy), (cx, cy) = self._lens.focal_length, self._lens.principal_point
        left, right, top, bottom = crop_pixels(crop, self._lens)
        x0, x1, y0, y1 = (left - cx) / fx, (right - cx) / fx, (top - cy) / fy, (bottom - cy) / fy
        (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation
        px, py, pz = pos
        lean, sqrt, hypot = self._lean, math.sqrt, math.hypot
        squares, normals = layout.squares, layout.normal_list
        rows: list[int] = []
        found: list[Corners] = []
        for row in self._candidates:
            middle, third, second = squares[row]
            x, y, z = middle
            x, y, z = x - px, y - py, z - pz
            ahead = r20 * x + r21 * y + r22 * z
            if ahead < _NEAREST:
                continue
            # Its middle is in the picture if its corners are.
            across = r00 * x + r01 * y + r02 * z
            if not x0 * ahead <= across <= x1 * ahead:
                continue
            down = r10 * x + r11 * y + r12 * z
            if not y0 * ahead <= down <= y1 * ahead:
                continue
            nx, ny, nz = normals[row]
            if -(nx * x + ny * y + nz * z) < lean * sqrt(x * x + y * y + z * z):
                continue
            if wanted is not None and layout.id_list[row] not in wanted:
                continue
            sx, sy, sz = third
            dx, dy, dz = second
            sx, sy, sz = r00 * sx + r01 * sy + r02 * sz, r10 * sx + r11 * sy + r12 * sz, r20 * sx + r21 * sy + r22 * sz
            dx, dy, dz = r00 * dx + r01 * dy + r02 * dz, r10 * dx + r11 * dy + r12 * dz, r20 * dx + r21 * dy + r22 * dz
            n0, n1, n2, n3 = ahead - sz, ahead + dz, ahead + sz, ahead - dz
            if n0 <= 0.0 or n1 <= 0.0 or n2 <= 0.0 or n3 <= 0.0:
                continue
            ua, ub = fx * (across - sx) / n0 + cx, fx * (across + dx) / n1 + cx
            uc, ud = fx * (across + sx) / n2 + cx, fx * (across - dx) / n3 + cx
            va, vb = fy * (down - sy) / n0 + cy, fy * (down + dy) / n1 + cy
            vc, vd = fy * (down + sy) / n2 + cy, fy * (down - dy) / n3 + cy
            if (
                left <= ua <= right and left <= ub <= right and left <= uc <= right and left <= ud <= right
                and top <= va <= bottom and top <= vb <= bottom and top <= vc <= bottom and top <= vd <= bottom
                and hypot(ub - ua, vb - va) >= min_side and hypot(uc - ub, vc - vb) >= min_side
                and hypot(ud - uc, vd - vc) >= min_side and hypot(ua - ud, va - vd) >= min_side
            ):  # fmt: skip
                rows.append(row)
                found.append(((ua, va), (ub, vb), (uc, vc), (ud, vd)))
        return rows, found

    def _follow(self, pos: Vector, min_side: float, max_angle_deg: float) -> None:
        """The candidates: large enough and turned towards the camera, from anywhere within 25 cm of here."""
        layout, lens = self._layout, self._lens
        self._from, self._limits = pos, (min_side, max_angle_deg)
        self._lean = lean = math.cos(math.radians(max_angle_deg))
        # Off the axis a tag is larger, by up to the square of 1 / cos; in the corner of the picture most.
        (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
        stretch = 1.0 + (cx / fx) ** 2 + (cy / fy) ** 2
        reach = max(fx, fy) * layout.size * stretch / min_side + _CELL
        px, py, pz = pos
        candidates = self._candidates = []
        for row, (middle, (nx, ny, nz)) in enumerate(zip(layout.center_list, layout.normal_list, strict=True)):
            x, y, z = middle
            x, y, z = x - px, y - py, z - pz
            distance = math.sqrt(x * x + y * y + z * z)
            before = -(nx * x + ny * y + nz * z)  # the tag's plane
            if distance < reach and before + _CELL > lean * (distance - _CELL):
                candidates.append(row)


class Occlusion:
    """Whether something stands between one camera and each tag.

    Pieces are tested as balls at nine points of a tag, in every frame. The field and robots are tested by rays to its
    corners and its middle, every 0.1 s or 30 cm, all rays of a frame in one call: they cost most, 3 us each.

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
        self._point_lists: list[list[list[float]]] = self._points.tolist()
        self._rays = [[points[k] for k in _RAYS] for points in self._point_lists]
        self._lowest = float(self._points[:, :, 2].min(initial=math.inf))
        self._known: dict[int, tuple[float, Vector, bool]] = {}

    def uncovered(self, rows: Sequence[int], pos: Vector, scene: CameraScene, time: float) -> list[bool]:
        """Which of some tags have nothing between them and the camera.

        Args:
            rows: Of the tags in the layout.
            pos: Of the camera, field frame [m].
            scene: What can stand in the way.
            time: Now [s].
        """
        if scene.sight is not None:
            self._refresh(rows, pos, scene.sight, time)
            known = self._known
            free = [known[row][2] for row in rows]
        else:
            free = [True] * len(rows)
        pieces, radii = scene.above(min(pos[2], self._lowest))
        if len(pieces):
            left = [row for row, ok in zip(rows, free, strict=True) if ok]
            hidden = self._behind_pieces(left, pos, pieces, radii)
            if hidden:
                free = [ok and row not in hidden for row, ok in zip(rows, free, strict=True)]
        return free

    def _behind_pieces(self, rows: list[int], pos: Vector, pieces: FloatArray, radii: FloatArray) -> list[int]:
        """Those of some tags that a piece hides in part."""
        if not rows:
            return []
        px, py, pz = pos
        lowest = min(pz, self._lowest)
        if len(pieces) > _FEW:  # a ball below all lines of sight hides nothing
            is_up: BoolArray = pieces[:, 2] > lowest - radii
            pieces, radii = pieces[is_up], radii[is_up]
        if len(pieces) > _FEW:
            hidden = hidden_by_spheres(pos, self._points[rows].reshape(-1, 3), pieces, radii)
            if hidden is None:
                return []
            return [row for row, one in zip(rows, hidden.reshape(len(rows), -1), strict=True) if one.any()]
        spheres = zip(pieces.tolist(), radii.tolist(), strict=True)
        balls = [(x - px, y - py, z - pz, radius) for (x, y, z), radius in spheres if z > lowest - radius]
        return [row for row in rows if self._is_behind(row, pos, balls)] if balls else []

    def _is_behind(self, row: int, pos: Vector, balls: Sequence[tuple[float, float, float, float]]) -> bool:
        """Whether one of a few balls, counted from the camera, hides one of a tag's points: 2 us, in arrays 20."""
        px, py, pz = pos
        x, y, z = self._layout.squares[row][0]
        x, y, z = x - px, y - py, z - pz
        length2 = x * x + y * y + z * z
        spread = _SPREAD * self._layout.size
        for bx, by, bz, radius in balls:
            along = (bx * x + by * y + bz * z) / length2
            along = 0.0 if along < 0.0 else min(along, 1.0)
            gx, gy, gz = bx - along * x, by - along * y, bz - along * z
            reach = radius + along * spread
            if gx * gx + gy * gy + gz * gz >= reach * reach:
                continue  # it is outside of the cone around all points
            for qx, qy, qz in self._point_lists[row]:
                qx, qy, qz = qx - px, qy - py, qz - pz
                part = (bx * qx + by * qy + bz * qz) / (qx * qx + qy * qy + qz * qz)
                part = 0.0 if part < 0.0 else min(part, 1.0)
                gx, gy, gz = bx - part * qx, by - part * qy, bz - part * qz
                if gx * gx + gy * gy + gz * gz < radius * radius:
                    return True
        return False

    def _refresh(self, rows: Sequence[int], pos: Vector, sight: SightLines, time: float) -> None:
        """Cast rays to the tags of which nothing is known from about here and now."""
        known, rays = self._known, self._rays
        first: list[int] = []
        whole: list[int] = []
        ends: list[list[float]] = []
        for row in rows:
            last = known.get(row)
            if last is not None and 0.0 <= time - last[0] < _STALE and math.dist(last[1], pos) <= _MOVED:
                continue
            if last is None or last[2]:
                whole.append(row)
            else:  # of a tag that was hidden the middle first: most are hidden there
                first.append(row)
                ends.append(rays[row][-1])
        for row in whole:
            ends += rays[row]
        if not ends:
            return
        blocked = sight.blocked(self._robot, pos, ends)
        turned_up: list[int] = []
        for row, is_blocked in zip(first, blocked[: len(first)], strict=True):
            if is_blocked:
                known[row] = (time, pos, False)
            else:
                turned_up.append(row)
        start = len(first)
        for row in whole:
            known[row] = (time, pos, True not in blocked[start : start + len(_RAYS)])
            start += len(_RAYS)
        if turned_up:
            blocked = sight.blocked(self._robot, pos, [end for row in turned_up for end in rays[row][:-1]])
            for k, row in enumerate(turned_up):
                known[row] = (time, pos, True not in blocked[4 * k : 4 * k + 4])
