"""Surroundings of a camera, and the game pieces that the camera finds in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.vision.camera import LimelightType, PiecePipeline, crop_pixels
from simcore.vision.camera_frame import PieceSighting
from simcore.world.rotation import Vector

__all__ = ["MOST_DETECTIONS", "CameraScene", "SightLines", "find_pieces", "hidden_by_spheres"]

_NOTHING: FloatArray = np.zeros((0, 3))


MOST_DETECTIONS = 32
"""Largest number of entries in a raw array; farther pieces are left out."""
_CANDIDATES = 40  # nearest pieces that are tested for occlusion
_RIM: FloatArray = np.array([(0.0, 0.0), (0.7, 0.0), (-0.7, 0.0), (0.0, 0.7), (0.0, -0.7)])
"""Points of a piece that are tested for occlusion, right and down in radii: its center and four points around it."""
_NEARER: BoolArray = np.repeat(np.tri(_CANDIDATES, k=-1, dtype=bool), len(_RIM), axis=0)
"""Pairs (points of piece i, piece j) with j < i, where j can hide the point; pieces are sorted by distance."""


class SightLines(Protocol):
    """Ray test against the field and its robots."""

    def blocked(self, robot: int, start: Vector, ends: Sequence[Sequence[float]]) -> list[bool]:
        """Return which of the straight lines from `start` to `ends` meet the field or another robot.

        Args:
            robot: Number of the robot that carries the camera; its own body is transparent.
            start: Position of the camera, field frame [m].
            ends: End points, field frame [m]: n points.
        """
        ...


@dataclass(slots=True)
class CameraScene:
    """Pieces and obstacles on the field at one moment."""

    pieces: FloatArray = field(default_factory=lambda: _NOTHING)
    """Centers of all pieces, field frame [m], shape (n, 3)."""
    is_there: BoolArray | None = None
    """Whether each piece is visible on the field, shape (n,); None: all are."""
    radii: FloatArray = field(default_factory=lambda: np.zeros(0))
    """Radius of the sphere that represents each piece [m], shape (n,)."""
    class_names: Sequence[str] = ()
    """Detector's class names of the piece types, by class id; empty: pieces have no class."""
    class_ids: IntArray | None = None
    """Row in `class_names` of each piece, shape (n,); None: all are of the first class."""
    sight: SightLines | None = None
    """Ray test against field and robots; None: only pieces can be in the way."""


def hidden_by_spheres(start: Vector, points: FloatArray, scene: CameraScene) -> BoolArray:
    """Return which lines of sight pass through a piece.

    Args:
        start: Position of the camera [m].
        points: End points of the lines [m], shape (n, 3).
        scene: Scene with the pieces, which are balls.

    Returns:
        Whether each point is hidden, shape (n,).
    """
    # A ball below all lines of sight hides nothing: that is most of them, and costs one comparison.
    z, radii = scene.pieces[:, 2], scene.radii
    is_near: BoolArray = z > min(start[2], float(points[:, 2].min(initial=np.inf))) - radii
    if scene.is_there is not None:
        is_near &= scene.is_there
    if not is_near.any():
        return np.zeros(len(points), dtype=bool)
    ray, ball, radii = points - start, scene.pieces[is_near] - start, radii[is_near]
    length2 = np.einsum("ij,ij->i", ray, ray)
    along = (ray @ ball.T) / length2[:, None]  # fraction of the line at its closest point to the ball
    at = np.clip(along, 0.0, 1.0)
    gap2 = np.einsum("ij,ij->i", ball, ball)[None, :] - (2.0 * along - at) * at * length2[:, None]
    hidden: BoolArray = (gap2 < radii * radii).any(axis=1)
    return hidden


def find_pieces(
    scene: CameraScene,
    robot: int,
    pos: Vector,
    rotation: FloatArray,
    lens: LimelightType,
    pipeline: PiecePipeline,
    crop: tuple[float, float, float, float],
    rng: np.random.Generator,
) -> tuple[PieceSighting, ...]:
    """Return the detections of one frame, the nearest first.

    Args:
        scene: Pieces and obstacles.
        robot: Number of the robot that carries the camera.
        pos: Position of the camera, field frame [m].
        rotation: Rotation from field to optical axes, from `optical_rotation`.
        lens: Type of the camera.
        pipeline: Pipeline with near and far plane and class.
        crop: Part of the picture that is searched.
        rng: Generator for the noise of the boxes.
    """
    (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
    ahead = scene.pieces @ rotation[2]  # depths first: most pieces are behind or too far
    start = float(rotation[2] @ pos)
    is_near: BoolArray = (ahead >= start + pipeline.near) & (ahead <= start + pipeline.far)
    if scene.is_there is not None:
        is_near &= scene.is_there
    if scene.class_names and pipeline.piece_class:
        is_near &= _is_of_class(scene, pipeline.piece_class)
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
    radii = scene.radii[slots]
    kept = np.nonzero(_visible_part(p, distance, radii) >= pipeline.min_visible)[0]
    if scene.sight is not None and len(kept):  # rays cost most: cast them last
        near_side = p[kept] * (1.0 - radii[kept] / distance[kept])[:, None]
        blocked = scene.sight.blocked(robot, pos, (near_side @ rotation + pos).tolist())
        kept = kept[~np.array(blocked)]
    kept = kept[:MOST_DETECTIONS]
    p = p[kept]
    middle = p[:, :2] / p[:, 2:] * (fx, fy) + (cx, cy)
    half = radii[kept][:, None] / p[:, 2:] * (fx, fy)
    noise = pipeline.box_noise * rng.standard_normal((2, len(kept), 2))
    low, high = middle - half + noise[0], middle + half + noise[1]
    tx = np.degrees(np.arctan((0.5 * (low[:, 0] + high[:, 0]) - cx) / fx)).tolist()
    ty = np.degrees(np.arctan((cy - 0.5 * (low[:, 1] + high[:, 1])) / fy)).tolist()
    size = high - low
    area = (100.0 / (lens.width * lens.height) * np.abs(size[:, 0] * size[:, 1])).tolist()
    spans = zip(low.tolist(), high.tolist(), strict=True)
    boxes = [((u0, v0), (u1, v0), (u1, v1), (u0, v1)) for (u0, v0), (u1, v1) in spans]
    rows = zip(boxes, tx, ty, area, distance[kept].tolist(), slots[kept].tolist(), strict=True)
    names = scene.class_names or (pipeline.piece_class or "piece",)
    ids = [0] * len(kept) if scene.class_ids is None else scene.class_ids[slots[kept]].tolist()
    return tuple([PieceSighting(number, names[number], *row) for number, row in zip(ids, rows, strict=True)])


def _is_of_class(scene: CameraScene, name: str) -> BoolArray:
    """Return which pieces are of a class, shape (n,)."""
    ids = np.zeros(len(scene.pieces), dtype=np.int64) if scene.class_ids is None else scene.class_ids
    is_of_it: BoolArray = np.array([known == name for known in scene.class_names])[ids]
    return is_of_it


def _visible_part(p: FloatArray, distance: FloatArray, radii: FloatArray) -> FloatArray:
    """Compute the share of each piece that other pieces leave visible [-], shape (n,); optical frame, nearest first."""
    n = len(p)
    x, y, z = (p / distance[:, None]).T
    level = np.maximum(np.hypot(x, z), 1e-9)
    zero = np.zeros(n)
    across = np.array((z / level, zero, -x / level))  # horizontal in the picture, perpendicular to the view
    down = np.array((-x * y / level, level, -y * z / level))  # perpendicular to both
    rim = _RIM[:, :1] * across.T[:, None, :] + _RIM[:, 1:] * down.T[:, None, :]
    points = p[:, None, :] + radii[:, None, None] * rim
    points = points.reshape(-1, 3)
    # A ball hides a point if it is nearer and the line of sight passes within its radius.
    along = points @ p.T
    reach2 = np.einsum("ij,ij->i", points, points)
    close = along * along > (distance * distance - radii * radii)[None, :] * reach2[:, None]
    hidden: BoolArray = (close & (along > 0.0) & _NEARER[: len(points), :n]).any(axis=1)
    part: FloatArray = 1.0 - hidden.reshape(n, -1).mean(axis=1)
    return part
