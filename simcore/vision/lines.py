"""What to draw of a camera: the line it looks along, and lines to the tags it saw."""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.quaternion import Quaternion, Vector, rotate
from simcore.typing import FloatArray
from simcore.vision.frames import Frame
from simcore.vision.tags import TagLayout

__all__ = ["direction_line", "sighting_lines"]

_LENGTH = 1.0  # [m]


def direction_line(pos: Vector, quat: Quaternion, frame: Frame | None) -> FloatArray:
    """From the lens to what the last frame aims at, or 1 m along its axis.

    Args:
        pos: Of the camera, field frame [m].
        quat: Its attitude.
        frame: Its last one; None: it has none yet.

    Returns:
        Two poses as rows of x, y, z, qw, qx, qy, qz, shape (2, 7).
    """
    ahead, left, up = _LENGTH, 0.0, 0.0
    tag = frame.primary_tag if frame is not None else None
    piece = frame.primary_piece if frame is not None else None
    seen = tag or piece
    if seen is not None:
        reach = tag.camera_distance if tag is not None else piece.distance if piece is not None else _LENGTH
        left, up = -math.tan(math.radians(seen.tx_deg)), math.tan(math.radians(seen.ty_deg))
        scale = reach / math.sqrt(1.0 + left * left + up * up)
        ahead, left, up = scale, scale * left, scale * up
    dx, dy, dz = rotate(quat, (ahead, left, up))
    return _poses(np.array([pos, (pos[0] + dx, pos[1] + dy, pos[2] + dz)]), quat)


def sighting_lines(pos: Vector, quat: Quaternion, frame: Frame | None, layout: TagLayout) -> FloatArray:
    """From the lens to each tag of the last frame and back, shape (2 n + 1, 7); empty without tags."""
    ids = [tag.id for tag in frame.tags] if frame is not None else []
    if not ids:
        return np.zeros((0, 7))
    points = np.repeat(np.array([pos]), 2 * len(ids) + 1, axis=0)
    points[1::2] = layout.centers[np.searchsorted(layout.ids, ids)]
    return _poses(points, quat)


def _poses(points: FloatArray, quat: Quaternion) -> FloatArray:
    rows = np.empty((len(points), 7))
    rows[:, :3] = points
    rows[:, 3:] = (quat[3], quat[0], quat[1], quat[2])
    rows.setflags(write=False)
    return rows
