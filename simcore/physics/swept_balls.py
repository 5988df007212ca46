"""When balls that move along straight lines first touch faces, edges and corners of what stands on the field.

The shapes are cut into triangles once, so that all engines have the same surfaces; spheres stay spheres.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from simcore.geometry.rotation import Quaternion, matrix
from simcore.physics.shapes import Box, Compound, Cylinder, HalfSpace, Hull, Mesh, Part, Shape, Sphere
from simcore.typing import FloatArray, IntArray

__all__ = ["FirstTouch", "TriangleSet"]

_SIDES = 48  # of a cylinder: 0.2 % of its radius off
_HALF_SPACE = 1_000.0  # [m], half of the side of the square that stands for one
_LEAST_AREA = 1e-10  # [m^2]
_SLACK = 1e-6  # [m], of what is on an edge
_LEAST_WAY = 1e-8  # [m] toward a surface; what goes less goes along it


class FirstTouch(NamedTuple):
    """What some balls touch first, one row a ball."""

    fraction: FloatArray
    """Part of the way before it, inf where nothing is touched, shape (n,)."""
    normal: FloatArray
    """Unit vector toward the ball, shape (n, 3)."""
    tag: IntArray
    """Of what is touched, -1 for nothing, shape (n,)."""


class TriangleSet:
    """Surfaces of some shapes, each with a tag, in one frame.

    >>> from simcore.geometry.rotation import IDENTITY
    >>> from simcore.physics.shapes import Box
    >>> walls = TriangleSet()
    >>> walls.add(7, Box((1.0, 1.0, 1.0)), (2.0, 0.0, 0.0), IDENTITY)
    >>> hit = walls.first_touch(np.zeros((1, 3)), np.array([[2.0, 0.0, 0.0]]), np.array([0.5]))
    >>> hit.fraction.tolist(), (hit.normal + 0.0).tolist(), hit.tag.tolist()
    ([0.5], [[-1.0, 0.0, 0.0]], [7])
    """

    def __init__(self) -> None:
        self._parts: list[tuple[int, Part | Mesh | HalfSpace, FloatArray, FloatArray]] = []
        self._balls: list[tuple[int, FloatArray, float]] = []  # spheres: tag, center, radius
        self._is_ready = False

    def add(self, tag: int, shape: Shape, pos: FloatArray | tuple[float, float, float], quat: Quaternion) -> None:
        """Add a shape whose origin is at a place [m], with its attitude x, y, z, w."""
        axes, at = matrix(quat), np.asarray(pos, dtype=float)
        if isinstance(shape, Mesh | HalfSpace):
            self._parts.append((tag, shape, axes, at))
        else:
            for part in shape.parts if isinstance(shape, Compound) else (Part(shape),):
                if isinstance(part.shape, Sphere):
                    self._balls.append((tag, at + axes @ part.offset, part.shape.radius))
                else:
                    self._parts.append((tag, part, axes, at))
        self._is_ready = False

    def first_touch(self, pos: FloatArray, way: FloatArray, radius: FloatArray) -> FirstTouch:
        """The first touch of each ball that moves toward what it touches, shape (n,) each.

        Args:
            pos: Centers at the start [m], shape (n, 3).
            way: How far each goes, shape (n, 3) [m].
            radius: Of each [m], shape (n,).
        """
        if not self._is_ready:
            self._prepare()
        found = FirstTouch(np.full(len(pos), np.inf), np.zeros((len(pos), 3)), np.full(len(pos), -1, dtype=np.int64))
        end = pos + way
        low, high = np.minimum(pos, end) - radius[:, None], np.maximum(pos, end) + radius[:, None]
        near = ((low[:, None, :] <= self._high) & (high[:, None, :] >= self._low)).all(axis=2)
        i, t = near.nonzero()
        if len(i):
            self._touch_triangles(found, pos, way, radius, i, t)
        for tag, center, size in self._balls:
            x = pos - center
            share = _reach(np.einsum("ij,ij->i", way, way), np.einsum("ij,ij->i", x, way), x, radius + size)
            for n in (share < np.minimum(found.fraction, 1.0)).nonzero()[0].tolist():
                away = x[n] + share[n] * way[n]
                found.fraction[n], found.tag[n] = share[n], tag
                found.normal[n] = away / math.sqrt(float(away @ away))
        return found

    # --- inside -------------------------------------------------------------------------------------------------

    def _touch_triangles(
        self, found: FirstTouch, pos: FloatArray, way: FloatArray, radius: FloatArray, i: IntArray, t: IntArray
    ) -> None:
        """Note the first touch of balls `i` with triangles `t`, pairs of shape (p,)."""
        p, w, r = pos[i], way[i], radius[i]
        corner, normal = self._corner[t], self._normal[t]
        # faces: the plane is reached while the point below the center is within the three edges
        height = np.einsum("ij,ij->i", p - corner[:, 0], normal)
        side = np.where(height < 0.0, -1.0, 1.0)
        closing = -side * np.einsum("ij,ij->i", w, normal)
        share = np.full(len(i), np.inf)
        meets = closing > _LEAST_WAY
        share[meets] = np.maximum(np.abs(height) - r, 0.0)[meets] / closing[meets]
        at = np.where(np.isfinite(share), share, 0.0)[:, None]
        foot = p + at * w
        within = (np.einsum("pkj,pkj->pk", foot[:, None] - corner, self._inward[t]) >= -_SLACK).all(axis=1)
        share[~within] = np.inf
        self._note(found, i, t, share, side[:, None] * normal)
        # edges and corners: how near the line of the center comes to them
        x, edge, v = p[:, None] - corner, self._edge[t], w[:, None]
        x_along, w_along = (
            np.einsum("pkj,pkj->pk", x, edge),
            np.einsum("pkj,pkj->pk", np.broadcast_to(v, x.shape), edge),
        )
        x_off, w_off = x - x_along[..., None] * edge, v - w_along[..., None] * edge
        share = _reach(
            np.einsum("pkj,pkj->pk", w_off, w_off), np.einsum("pkj,pkj->pk", x_off, w_off), x_off, r[:, None]
        )
        at = np.where(np.isfinite(share), share, 0.0)
        along = x_along + at * w_along
        share[(along < -_SLACK) | (along > self._length[t] + _SLACK)] = np.inf
        corners = _reach(np.einsum("ij,ij->i", w, w)[:, None], np.einsum("pkj,pj->pk", x, w), x, r[:, None])
        for k in range(3):
            self._note(found, i, t, share[:, k], x_off[:, k] + at[:, k, None] * w_off[:, k])
            some = np.where(np.isfinite(corners[:, k]), corners[:, k], 0.0)[:, None]
            self._note(found, i, t, corners[:, k], x[:, k] + some * w)

    def _note(self, found: FirstTouch, i: IntArray, t: IntArray, share: FloatArray, away: FloatArray) -> None:
        for n in (share < np.minimum(found.fraction[i], 1.0)).nonzero()[0].tolist():
            ball = i[n]
            size = math.sqrt(float(away[n] @ away[n]))
            if share[n] < found.fraction[ball] and size > 0.0:
                found.fraction[ball], found.normal[ball], found.tag[ball] = share[n], away[n] / size, self._tag[t[n]]

    def _prepare(self) -> None:
        corners, tags = [np.zeros((0, 3, 3))], [np.zeros(0, dtype=np.int64)]
        for tag, part, axes, at in self._parts:
            triangles = _triangles(part) @ axes.T + at
            corners.append(triangles)
            tags.append(np.full(len(triangles), tag, dtype=np.int64))
        corner = np.concatenate(corners)
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        area = np.sqrt(np.einsum("ij,ij->i", normal, normal))
        kept = area > _LEAST_AREA
        self._corner, self._tag = corner[kept], np.concatenate(tags)[kept]
        self._normal = normal[kept] / area[kept][:, None]
        edge = np.roll(self._corner, -1, axis=1) - self._corner
        self._length = np.sqrt(np.einsum("pkj,pkj->pk", edge, edge))
        self._edge = edge / self._length[..., None]
        self._inward = np.cross(self._normal[:, None], self._edge)
        self._low, self._high = self._corner.min(axis=1, initial=np.inf), self._corner.max(axis=1, initial=-np.inf)
        self._is_ready = True


def _reach(speed2: FloatArray, closing: FloatArray, x: FloatArray, radius: FloatArray) -> FloatArray:
    """Part of a way after which a place is as near to the origin as a radius; inf: never, or it moves away.

    Args:
        speed2: Square of the way.
        closing: Way times place.
        x: Place, vectors in the last axis.
        radius: [m]
    """
    gap = np.einsum("...j,...j->...", x, x) - radius * radius
    root = closing * closing - speed2 * gap
    share = np.full(closing.shape, np.inf)
    meets = (closing < -_LEAST_WAY * radius) & (root > 0.0)
    share[meets] = np.maximum(gap, 0.0)[meets] / (np.sqrt(root[meets]) - closing[meets])
    return share


def _triangles(part: Part | Mesh | HalfSpace) -> FloatArray:
    """Triangles of a shape in its frame, or in that of the whole for a part, shape (n, 3 corners, 3)."""
    if isinstance(part, Mesh):
        mesh: FloatArray = part.vertices[part.faces]
        return mesh
    if isinstance(part, HalfSpace):
        a = _HALF_SPACE
        square = np.array([(-a, -a, 0.0), (a, -a, 0.0), (a, a, 0.0), (-a, a, 0.0)])
        return square[[[0, 1, 2], [0, 2, 3]]]
    shape = part.shape
    if isinstance(shape, Hull):
        points = shape.points
    elif isinstance(shape, Box):
        points = 0.5 * np.array(shape.size) * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    else:
        assert isinstance(shape, Cylinder)
        turns = math.tau / _SIDES * np.arange(_SIDES)
        rim = shape.radius * np.column_stack((np.cos(turns), np.sin(turns)))
        points = np.vstack([np.column_stack((rim, np.full(_SIDES, z * shape.height))) for z in (-0.5, 0.5)])
    hull: FloatArray = points[ConvexHull(points).simplices] @ matrix(part.quat).T + part.offset
    return hull
