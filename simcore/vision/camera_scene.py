"""Scene around a camera, occlusion by game pieces, and detection of game pieces."""

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
"""Largest number of pieces that the detector reports for a frame, nearest first."""
_CANDIDATES = 40  # number of nearest pieces tested for occlusion
_RIM: FloatArray = np.array([(0.0, 0.0), (0.7, 0.0), (-0.7, 0.0), (0.0, 0.7), (0.0, -0.7)])
"""Points of a piece that are tested for occlusion, as offsets (right, down) from the center [radii]."""
_NEARER: BoolArray = np.repeat(np.tri(_CANDIDATES, k=-1, dtype=bool), len(_RIM), axis=0)
"""Whether piece j (column) can hide a point of piece i (rows): j < i, because the pieces are sorted by distance."""


class SightLines(Protocol):
    """Line-of-sight test against the field and the robots."""

    def blocked(self, robot: int, start: Vector, ends: Sequence[Sequence[float]]) -> list[bool]:
        """Return whether the field or another robot blocks the straight line from `start` to each of n `ends`.

        Args:
            robot: Number of the robot that carries the camera; this robot blocks no line.
            start: Position of the camera, field frame [m].
            ends: Ends of the lines, field frame [m].
        """
        ...


@dataclass(slots=True)
class CameraScene:
    """Pieces and obstacles on the field at one moment."""

    pieces: FloatArray = field(default_factory=lambda: _NOTHING)
    """Centers of all pieces, field frame [m], shape (n, 3)."""
    is_there: BoolArray | None = None
    """Whether each piece is on the field, shape (n,); None if all pieces are on the field."""
    radii: FloatArray = field(default_factory=lambda: np.zeros(0))
    """Radius of the sphere that represents each piece [m], shape (n,)."""
    class_names: Sequence[str] = ()
    """Class names of the detector, by class id; empty if pieces have no class."""
    class_ids: IntArray | None = None
    """Class id of each piece, shape (n,); None if all pieces have the first class."""
    sight: SightLines | None = None
    """Line-of-sight test against the field and the robots; None if only pieces can block the view."""


def hidden_by_spheres(start: Vector, points: FloatArray, scene: CameraScene) -> BoolArray:
    """Test whether the spheres that represent the pieces hide points from the camera.

    Args:
        start: Position of the camera, field frame [m].
        points: Points to test, field frame [m], shape (n, 3).
        scene: Scene with the pieces.

    Returns:
        Whether each point is hidden, shape (n,).
    """
    # Most balls are below all lines of sight and hide nothing; one comparison excludes them.
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
    """Detect the visible pieces in a frame, nearest first, at most `MOST_DETECTIONS`.

    Args:
        scene: Scene with pieces and obstacles.
        robot: Number of the robot that carries the camera.
        pos: Position of the camera, field frame [m].
        rotation: Rotation from field to optical axes, from `optical_rotation`.
        lens: Camera model.
        pipeline: Pipeline with the range of depths, the class and the box noise.
        crop: Crop window, the part of the image to search.
        rng: Random generator for the noise of the boxes.
    """
    (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
    ahead = scene.pieces @ rotation[2]  # depths are tested first, as most pieces are behind the camera or too far away
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
    if scene.sight is not None and len(kept):  # rays come last, because they take most of the time
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
    """Return whether each piece has the class `name`, shape (n,)."""
    ids = np.zeros(len(scene.pieces), dtype=np.int64) if scene.class_ids is None else scene.class_ids
    is_of_it: BoolArray = np.array([known == name for known in scene.class_names])[ids]
    return is_of_it


def _visible_part(p: FloatArray, distance: FloatArray, radii: FloatArray) -> FloatArray:
    """Compute the fraction of the test points of each piece that no other piece hides [-], shape (n,).

    Args:
        p: Centers of the pieces, nearest first, optical frame [m], shape (n, 3).
        distance: Distances of the centers from the camera [m], shape (n,).
        radii: Radii of the pieces [m], shape (n,).
    """
    n = len(p)
    x, y, z = (p / distance[:, None]).T
    level = np.maximum(np.hypot(x, z), 1e-9)
    zero = np.zeros(n)
    across = np.array((z / level, zero, -x / level))  # horizontal in the image, perpendicular to the view
    down = np.array((-x * y / level, level, -y * z / level))  # perpendicular to both
    rim = _RIM[:, :1] * across.T[:, None, :] + _RIM[:, 1:] * down.T[:, None, :]
    points = p[:, None, :] + radii[:, None, None] * rim
    points = points.reshape(-1, 3)
    # A ball hides a point if the ball is nearer and the line of sight passes within the radius of the ball.
    along = points @ p.T
    reach2 = np.einsum("ij,ij->i", points, points)
    close = along * along > (distance * distance - radii * radii)[None, :] * reach2[:, None]
    hidden: BoolArray = (close & (along > 0.0) & _NEARER[: len(points), :n]).any(axis=1)
    part: FloatArray = 1.0 - hidden.reshape(n, -1).mean(axis=1)
    return part
