"""Tests of the visibility of tags: position and size in the image, viewing angle, and occlusion."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from simcore.typing import BoolArray, FloatArray
from simcore.vision.camera import FULL_CROP, LimelightType, crop_pixels, project
from simcore.vision.camera_scene import CameraScene, SightLines, hidden_by_spheres
from simcore.vision.tag_layout import TagLayout
from simcore.world.rotation import Vector

__all__ = ["Occlusion", "find_tags"]

_NEAREST = 0.1  # [m]; a tag whose center is closer to the lens is out of focus
_CLEAR = 0.05
"""Gap between the end of a line of sight and the tag's face [m].

The mesh of a tag's support is up to 14 mm in front of the tag, and up to 39 mm at some corners (measured on the 2026
field mesh).
"""
_EDGE_POINTS: FloatArray = np.array(
    [(x, y, 1) for x, y in ((-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (0, 0))], dtype=float
)
"""Points of a tag that must be visible: right and up [half edges], out of the face [`_CLEAR`], shape (9, 3).

Adjacent points are 8.3 cm apart, so a piece of 15 cm in front of the tag cannot fit between the points.
"""
_RAYS = (0, 2, 4, 6, 8)  # indices in `_EDGE_POINTS` of the points tested by rays: corners and center
_MOVED = 0.3  # [m]; camera travel after which a result is out of date: travel of the fastest obstacle in `_STALE`
_STALE = 0.1  # [s]; age at which a result is out of date


def find_tags(
    layout: TagLayout,
    lens: LimelightType,
    pos: Vector,
    rotation: FloatArray,
    *,
    min_side: float,
    max_angle_deg: float,
    crop: tuple[float, float, float, float] = FULL_CROP,
    wanted: Collection[int] | None = None,
) -> tuple[list[int], FloatArray]:
    """Find the tags that a camera could read without occlusion.

    Args:
        layout: All tags at the true poses.
        lens: Camera model.
        pos: Position of the camera, field frame [m].
        rotation: Rotation from field to optical axes, from `optical_rotation`.
        min_side: Length of the shortest readable edge in the image [px].
        max_angle_deg: Largest readable angle between a tag's normal and the line to the camera [deg].
        crop: Crop window, the part of the image to search.
        wanted: Ids of the tags to find; None for all tags.

    Returns:
        Indices of the k readable tags in the layout, and pixels (u, v) of the corners of these tags, shape (k, 4, 2).
    """
    way = layout.centers - pos
    lean = math.cos(math.radians(max_angle_deg)) * np.sqrt((way * way).sum(axis=1))
    ahead = way @ rotation[2]
    rows = np.nonzero((ahead >= _NEAREST) & (-(layout.normals * way).sum(axis=1) >= lean))[0]
    if wanted is not None:
        rows = rows[np.isin(layout.ids[rows], list(wanted))]
    pixels, depth = project(layout.corners[rows].reshape(-1, 3), pos, rotation, lens)
    pixels = pixels.reshape(-1, 4, 2)
    left, right, top, bottom = crop_pixels(crop, lens)
    is_inside = ((pixels >= (left, top)) & (pixels <= (right, bottom))).all(axis=(1, 2))
    edges = pixels - pixels[:, (1, 2, 3, 0)]
    is_large = ((edges * edges).sum(axis=2) >= min_side * min_side).all(axis=1)
    is_read: BoolArray = is_inside & is_large & (depth.reshape(-1, 4) > 0.0).all(axis=1)
    return rows[is_read].tolist(), pixels[is_read]


class Occlusion:
    """Occlusion test between a camera and the tags.

    Every frame tests the pieces, modeled as spheres, against the lines of sight to nine points of a tag. Rays to the
    corners and the center test the field and the robots. A ray takes 3 us. The test therefore keeps a result of the
    rays for 0.1 s or 30 cm of camera travel, and casts all rays of a frame in one call.

    Args:
        layout: Tags of the field at the true poses.
        robot: Number of the robot that carries the camera.
    """

    def __init__(self, layout: TagLayout, robot: int) -> None:
        self._robot = robot
        half = 0.5 * layout.size
        self._points = _EDGE_POINTS * (half, half, _CLEAR) @ layout.square_axes + layout.centers[:, None, :]
        self._rays: list[list[list[float]]] = self._points[:, _RAYS].tolist()
        self._known: dict[int, tuple[float, Vector, bool]] = {}

    def uncovered(self, rows: Sequence[int], pos: Vector, scene: CameraScene, time: float) -> BoolArray:
        """Return whether each of k tags has a clear line of sight to the camera, shape (k,).

        Args:
            rows: Indices of the k tags in the layout.
            pos: Position of the camera, field frame [m].
            scene: Scene with the possible obstacles.
            time: Current simulated time [s].
        """
        free: BoolArray = np.ones(len(rows), dtype=bool)
        if scene.sight is not None:
            self._refresh(rows, pos, scene.sight, time)
            free = np.array([self._known[row][2] for row in rows])
        hidden = hidden_by_spheres(pos, self._points[rows].reshape(-1, 3), scene)
        free &= ~hidden.reshape(len(rows), -1).any(axis=1)
        return free

    def _refresh(self, rows: Sequence[int], pos: Vector, sight: SightLines, time: float) -> None:
        """Cast rays to the tags without a valid result.

        A result is valid for 0.1 s, while the camera is within 30 cm of the position at the time of the result.
        """
        stale = []
        for row in rows:
            last = self._known.get(row)
            if last is None or not 0.0 <= time - last[0] < _STALE or math.dist(last[1], pos) > _MOVED:
                stale.append(row)
        if stale:
            ends = [end for row in stale for end in self._rays[row]]
            blocked = np.array(sight.blocked(self._robot, pos, ends)).reshape(len(stale), -1)
            for row, rays in zip(stale, blocked.tolist(), strict=True):
                self._known[row] = (time, pos, True not in rays)
