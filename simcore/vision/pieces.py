"""Which game pieces a camera finds: in its frustum and not covered by others, the field or robots; nearest first."""

from __future__ import annotations

import numpy as np

from simcore.geometry.quaternion import Vector
from simcore.typing import BoolArray, FloatArray
from simcore.vision.camera import LimelightType, PiecePipeline
from simcore.vision.camera_scene import Scene
from simcore.vision.frames import PieceSighting
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
    ahead = scene.pieces @ rotation[2]  # depths first: most pieces are behind or too far
    start = float(rotation[2] @ pos)
    is_near: BoolArray = (ahead >= start + pipeline.near) & (ahead <= start + pipeline.far)
    if scene.is_there is not None:
        is_near &= scene.is_there
    slots = np.nonzero(is_near)[0]
    p = (scene.pieces[slots] - pos) @ rotation.T
    u, v = fx * p[:, 0] / p[:, 2] + cx, fy * p[:, 1] / p[:, 2] + cy
    left, right, top, bottom = crop_pixels(crop, lens)
    inside = (u >= left) & (u <= right) & (v >= top) & (v <= bottom)
    slots, p = slots[inside], p[inside]
    distance = np.sqrt(np.einsum("ij,ij->i", p, p))
    order = np.argsort(distance, kind="stable")[:_CANDIDATES]
    slots, p, distance = slots[order], p[order], distance[order]
    if not len(slots):
        return ()
    kept = np.nonzero(_visible_part(p, distance, scene.piece_radius) >= pipeline.min_visible)[0]
    if scene.sight is not None and len(kept):  # rays cost most: only to what is left
        near_side = p[kept] * (1.0 - scene.piece_radius / distance[kept])[:, None]
        blocked = scene.sight.blocked(robot, pos, (near_side @ rotation + pos).tolist())
        kept = kept[~np.array(blocked)]
    kept = kept[:MOST_DETECTIONS]
    p = p[kept]
    middle = p[:, :2] / p[:, 2:] * (fx, fy) + (cx, cy)
    half = scene.piece_radius / p[:, 2:] * (fx, fy)
    noise = pipeline.box_noise * rng.standard_normal((2, len(kept), 2))
    low, high = middle - half + noise[0], middle + half + noise[1]
    tx = np.degrees(np.arctan((0.5 * (low[:, 0] + high[:, 0]) - cx) / fx)).tolist()
    ty = np.degrees(np.arctan((cy - 0.5 * (low[:, 1] + high[:, 1])) / fy)).tolist()
    size = high - low
    area = (100.0 / (lens.width * lens.height) * np.abs(size[:, 0] * size[:, 1])).tolist()
    spans = zip(low.tolist(), high.tolist(), strict=True)
    boxes = [((u0, v0), (u1, v0), (u1, v1), (u0, v1)) for (u0, v0), (u1, v1) in spans]
    rows = zip(boxes, tx, ty, area, distance[kept].tolist(), slots[kept].tolist(), strict=True)
    name = pipeline.piece_class
    return tuple([PieceSighting(0, name, *row) for row in rows])


def _visible_part(p: FloatArray, distance: FloatArray, radius: float) -> FloatArray:
    """Which part of each piece other pieces leave uncovered [-], shape (n,); in the optical frame, nearest first."""
    n = len(p)
    x, y, z = (p / distance[:, None]).T
    level = np.maximum(np.hypot(x, z), 1e-9)
    zero = np.zeros(n)
    across = np.array((z / level, zero, -x / level))  # level in the picture, square to the view
    down = np.array((-x * y / level, level, -y * z / level))  # square to both
    points = p[:, None, :] + radius * (_RIM[:, :1] * across.T[:, None, :] + _RIM[:, 1:] * down.T[:, None, :])
    points = points.reshape(-1, 3)
    # A ball hides a point if the line there passes it by less than its radius, and it is nearer.
    along = points @ p.T
    reach2 = np.einsum("ij,ij->i", points, points)
    close = along * along > (distance * distance - radius * radius)[None, :] * reach2[:, None]
    hidden: BoolArray = (close & (along > 0.0) & _NEARER[: len(points), :n]).any(axis=1)
    part: FloatArray = 1.0 - hidden.reshape(n, -1).mean(axis=1)
    return part


_NEARER: BoolArray = np.repeat(np.tri(_CANDIDATES, k=-1, dtype=bool), len(_RIM), axis=0)
"""Which of some pieces, sorted by distance, can hide which point: (points of piece i, piece j) for j < i."""
