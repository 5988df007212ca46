"""Which game pieces a camera finds: in its frustum and not covered by others, the field or robots; nearest first."""

from __future__ import annotations

import numpy as np

from simcore.geometry.quaternion import Vector
from simcore.typing import BoolArray, FloatArray
from simcore.vision.camera import LimelightType, PiecePipeline
from simcore.vision.frames import PieceSighting
from simcore.vision.projection import angles_deg
from simcore.vision.scene import Scene
from simcore.vision.visibility import crop_pixels

__all__ = ["MOST_DETECTIONS", "find_pieces"]

MOST_DETECTIONS = 32
"""Entries of a raw array at most; farther pieces are left out."""

_CANDIDATES = 40  # nearest pieces that are looked at closely
_RIM: FloatArray = np.array([(0.0, 0.0), (0.7, 0.0), (-0.7, 0.0), (0.0, 0.7), (0.0, -0.7)])
"""Where it is tested whether a piece is covered, right and down in radii: its middle and four places around it."""


def find_pieces(
    scene: Scene,
    robot: int,
    pos: Vector,
    rotation: FloatArray,
    lens: LimelightType,
    pipeline: PiecePipeline,
    crop: tuple[float, float, float, float],
    rng: np.random.Generator,
) -> tuple[PieceSighting, ...]:
    """Detections of one frame, the nearest first.

    Args:
        scene: Pieces, and what may cover them.
        robot: The one that carries the camera.
        pos: Of the camera, field frame [m].
        rotation: From `optical_rotation`.
        lens: The picture.
        pipeline: Near and far plane, class.
        crop: The part of the picture that is searched.
        rng: For the noise of the boxes.
    """
    (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
    p = (scene.pieces - pos) @ rotation.T
    z = p[:, 2]
    slots = np.nonzero((z >= pipeline.near) & (z <= pipeline.far))[0]
    p = p[slots]
    u, v = fx * p[:, 0] / p[:, 2] + cx, fy * p[:, 1] / p[:, 2] + cy
    left, right, top, bottom = crop_pixels(crop, lens)
    inside = (u >= left) & (u <= right) & (v >= top) & (v <= bottom)
    slots, p = slots[inside], p[inside]
    distance = np.sqrt(np.einsum("ij,ij->i", p, p))
    order = np.argsort(distance, kind="stable")[:_CANDIDATES]
    slots, p, distance = slots[order], p[order], distance[order]
    if not len(slots):
        return ()
    seen = _visible_part(p, distance, scene, robot, pos, rotation) >= pipeline.min_visible
    kept = np.nonzero(seen)[0][:MOST_DETECTIONS]
    p = p[kept]
    middle = p[:, :2] / p[:, 2:] * (fx, fy) + (cx, cy)
    half = scene.piece_radius / p[:, 2:] * (fx, fy)
    noise = pipeline.box_noise * rng.standard_normal((2, len(kept), 2))
    low, high = middle - half + noise[0], middle + half + noise[1]
    corners = np.stack((low, high), axis=1)[:, ((0, 0), (1, 0), (1, 1), (0, 1)), (0, 1)]
    percent = 100.0 / (lens.width * lens.height)
    found = []
    rows = zip(low.tolist(), high.tolist(), corners, distance[kept].tolist(), slots[kept].tolist(), strict=True)
    for (u0, v0), (u1, v1), box, reach, slot in rows:
        tx, ty = angles_deg(0.5 * (u0 + u1), 0.5 * (v0 + v1), lens)
        area = percent * abs((u1 - u0) * (v1 - v0))
        found.append(PieceSighting(0, pipeline.piece_class, box, tx, ty, area, reach, slot))
    return tuple(found)


def _visible_part(
    p: FloatArray, distance: FloatArray, scene: Scene, robot: int, pos: Vector, rotation: FloatArray
) -> FloatArray:
    """Which part of each piece is uncovered [-], shape (n,); pieces in the optical frame, nearest first.

    Other pieces can cover it in part; the field and robots cover it if they hide its middle.
    """
    n, radius = len(p), scene.piece_radius
    view = p / distance[:, None]
    across = np.stack((view[:, 2], np.zeros(n), -view[:, 0]), axis=1)  # level in the picture, square to the view
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-9)[:, None]
    down = np.cross(view, across)
    rim = radius * (_RIM[:, :1] * across[:, None, :] + _RIM[:, 1:] * down[:, None, :])
    points = p[:, None, :] + rim
    reach = np.linalg.norm(points, axis=2)
    rays = (points / reach[:, :, None]).reshape(-1, 3)
    along = rays @ p.T
    gap2 = (distance * distance)[None, :] - along * along
    free: BoolArray = ~((gap2 < radius * radius) & (along > 0.0) & _nearer(n)).any(axis=1)
    free = free.reshape(n, -1)
    part: FloatArray = free.mean(axis=1)
    if scene.sight is not None:
        some = np.nonzero(part > 0.0)[0]
        ends = (p[some] - radius * view[some]) @ rotation + pos  # to its near side
        part[some[scene.sight.blocked(robot, pos, ends)]] = 0.0
    return part


def _nearer(n: int) -> BoolArray:
    """Which of n pieces, sorted by distance, can hide which point: (points of piece i, piece j) for j < i."""
    return np.repeat(np.tri(n, k=-1, dtype=bool), len(_RIM), axis=0)
