"""Which tags a camera can read: in the picture, large enough, turned towards it, and with nothing in between."""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.quaternion import Vector
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.vision.camera import LimelightType
from simcore.vision.projection import project
from simcore.vision.scene import Scene, hidden_by_spheres
from simcore.vision.tags import TagLayout

__all__ = ["FULL_CROP", "crop_pixels", "tags_in_picture", "uncovered"]

FULL_CROP = (-1.0, 1.0, -1.0, 1.0)
"""x0, x1, y0, y1 of a crop window; 1 is the right and the upper edge."""

_NEAREST = 0.05  # [m]; a tag closer to the lens than this is not in focus
_CLEAR = 0.05
"""Lines of sight end so far before the tag's face [m]: the mesh behind it stands up to 14 mm proud (trench arms), the
estimated shoulder of a hub 39 mm at one corner of tags 2, 5, 18 and 21."""
_EDGE_POINTS: FloatArray = np.array(
    [(x, y, 1) for x, y in ((-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (0, 0))], dtype=float
)
"""Where a tag must be uncovered, in halves of its edge: 8.3 cm apart, so that no fuel (15 cm) slips between."""
_MIDDLE = 8


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
    away = layout.centers - pos
    depth = away @ rotation[2]
    toward = np.einsum("ij,ij->i", away, layout.normals)  # negative where the tag faces the camera
    distance2 = np.einsum("ij,ij->i", away, away)
    lean = math.cos(math.radians(max_angle_deg))
    corner = lens.corner_cosine
    seen = (
        (depth > _NEAREST)
        & (depth * np.abs(depth) > corner * corner * distance2)
        & (toward * np.abs(toward) < -lean * lean * distance2)
    )
    if wanted is not None:
        seen &= wanted
    rows = np.nonzero(seen)[0]
    if not len(rows):
        return rows, np.zeros((0, 4, 2))
    flat, depth = project(layout.corners[rows].reshape(-1, 3), pos, rotation, lens)
    left, right, top, bottom = crop_pixels(crop, lens)
    u, v = flat[:, 0], flat[:, 1]
    inside = (u >= left) & (u <= right) & (v >= top) & (v <= bottom) & (depth > _NEAREST)
    corners = flat.reshape(-1, 4, 2)
    edges = corners - corners[:, (1, 2, 3, 0)]
    short2 = np.einsum("ijk,ijk->ij", edges, edges).min(axis=1)
    keep = inside.reshape(-1, 4).all(axis=1) & (short2 >= min_side * min_side)
    return rows[keep], corners[keep]


def uncovered(layout: TagLayout, rows: IntArray, pos: Vector, robot: int, scene: Scene) -> BoolArray:
    """Which of some tags have nothing between them and the camera, shape (k,).

    Pieces are tested as balls at nine points of a tag, the field and robots by rays to its corners and its middle.
    """
    free = np.ones(len(rows), dtype=bool)
    if not len(rows):
        return free
    half = 0.5 * layout.size
    points = (_EDGE_POINTS * (half, half, _CLEAR)) @ layout.square_axes[rows] + layout.centers[rows][:, None, :]
    if len(scene.pieces):
        hidden = hidden_by_spheres(pos, points.reshape(-1, 3), scene.pieces, scene.piece_radius)
        if hidden is not None:
            free = ~hidden.reshape(len(rows), -1).any(axis=1)
    if scene.sight is not None:
        for some in (slice(_MIDDLE, None), slice(0, _MIDDLE, 2)):  # most that are hidden are so in their middle
            left = np.nonzero(free)[0]
            if len(left):
                ends = points[left][:, some]
                blocked = scene.sight.blocked(robot, pos, ends.reshape(-1, 3))
                free[left] = ~blocked.reshape(len(left), -1).any(axis=1)
    return free
