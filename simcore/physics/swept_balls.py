"""When a ball that moves along a straight line first touches faces, edges and corners of what stands on the field.

The shapes are cut into triangles once, so that all engines have the same surfaces; spheres stay spheres. Places are
sorted into cubes, each of which knows the triangles around it, so that a ball in the open takes a microsecond.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from simcore.geometry.rotation import Quaternion, Vector, matrix
from simcore.physics.shapes import Box, Compound, Cylinder, HalfSpace, Hull, Mesh, Part, Shape, Sphere
from simcore.typing import BoolArray, FloatArray

__all__ = ["FirstTouch", "TriangleSet"]

_SIDES = 48  # of a cylinder: 0.2 % of its radius off
_HALF_SPACE = 1_000.0  # [m], half of the side of the square that stands for one
_LEAST_AREA = 1e-10  # [m^2]
_SLACK = 1e-6  # [m], of what is on an edge
_LEAST_WAY = 1e-8  # [m] toward a surface; what goes less goes along it
_FLAT = 1e-9  # 1 - cosine between two faces of one plane
_CUBE = 0.25  # [m], edge of the smallest cubes: they serve balls that reach half as far


class FirstTouch(NamedTuple):
    """What a ball touches first."""

    fraction: float
    """Part of the way before it."""
    normal: Vector
    """Unit vector toward the ball."""
    tag: int
    """Of what is touched."""


class _Triangle(NamedTuple):
    """A face with those of its edges and corners that no other triangle has."""

    plane: tuple[float, float, float, float]
    """Unit normal, and height of the plane along it [m]."""
    low: Vector
    high: Vector
    sides: list[list[float]]
    """Of each edge the normal toward the inside, and its least height of a place within [m]."""
    edges: list[list[float]]
    """Start, direction and length [m]."""
    corners: list[list[float]]
    tag: int


class TriangleSet:
    """Surfaces of some shapes, each with a tag, in one frame.

    >>> from simcore.geometry.rotation import IDENTITY
    >>> from simcore.physics.shapes import Box
    >>> walls = TriangleSet()
    >>> walls.add(7, Box((1.0, 1.0, 1.0)), (2.0, 0.0, 0.0), IDENTITY)
    >>> touch = walls.first_touch((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), 0.5)
    >>> touch.fraction, touch.normal[0], touch.tag
    (0.5, -1.0, 7)
    """

    def __init__(self) -> None:
        self._parts: list[tuple[int, Part | Mesh | HalfSpace, FloatArray, FloatArray]] = []
        self._balls: list[tuple[int, FloatArray, float]] = []  # spheres: tag, center, radius
        self._cubes: dict[tuple[float, float, float, float], list[_Triangle]] = {}
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
        self._cubes.clear()
        self._is_ready = False

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner of the box around all of it [m], shape (3,) each."""
        if not self._is_ready:
            self._prepare()
        return self._bounds

    def first_touch(self, pos: Vector, way: Vector, radius: float, least: float = 0.0) -> FirstTouch | None:
        """The first touch of a ball that moves toward what it touches; None: there is none.

        Args:
            pos: Center at the start [m].
            way: How far it goes [m].
            radius: [m]
            least: Part of the way along the normal from which on a touch counts [m].
        """
        (x, y, z), (u, v, w) = pos, way
        length2, least = u * u + v * v + w * w, max(least, _LEAST_WAY)
        triangles = self._around(x, y, z, radius + math.sqrt(length2)) if length2 > least * least else None
        if not (triangles or self._balls):
            return None
        best, found = 1.0, None
        low_x, high_x = min(x, x + u) - radius, max(x, x + u) + radius
        low_y, high_y = min(y, y + v) - radius, max(y, y + v) + radius
        low_z, high_z = min(z, z + w) - radius, max(z, z + w) + radius
        rest: list[tuple[float, _Triangle]] = []
        for triangle in triangles or ():
            (nx, ny, nz, level), (ax, ay, az), (bx, by, bz), sides, edges, corners, tag = triangle
            height, toward = nx * x + ny * y + nz * z - level, -(nx * u + ny * v + nz * w)
            if height < 0.0:
                nx, ny, nz, height, toward = -nx, -ny, -nz, -height, -toward
            gap = height - radius
            if gap > 0.0 and gap >= best * toward:  # nothing in the plane is touched in time
                continue
            if low_z > bz or high_z < az or low_x > bx or high_x < ax or low_y > by or high_y < ay:
                continue
            share = gap / toward if gap > 0.0 else 0.0
            if toward > least and share < best:  # the plane is reached while the point below the center is within
                px, py, pz = x + share * u, y + share * v, z + share * w
                for sx, sy, sz, inside in sides:
                    if sx * px + sy * py + sz * pz < inside:
                        break
                else:
                    best, found = share, FirstTouch(share, (nx, ny, nz), tag)
                    continue
            if edges or corners:
                rest.append((share, triangle))
        for share, triangle in rest:
            if share >= best:
                continue
            for ax, ay, az, ex, ey, ez, size in triangle.edges:  # how near the line of the center comes to them
                dx, dy, dz = x - ax, y - ay, z - az
                along, speed = dx * ex + dy * ey + dz * ez, u * ex + v * ey + w * ez
                at = _reach(
                    dx * dx + dy * dy + dz * dz - along * along,
                    dx * u + dy * v + dz * w - along * speed,
                    length2 - speed * speed,
                    radius,
                    least,
                )
                along += at * speed
                if at < best and -_SLACK <= along <= size + _SLACK:
                    away = dx + at * u - along * ex, dy + at * v - along * ey, dz + at * w - along * ez
                    best, found = at, FirstTouch(at, away, triangle.tag)
            for ax, ay, az in triangle.corners:
                at, away = _meet((x - ax, y - ay, z - az), way, length2, radius, least)
                if at < best:
                    best, found = at, FirstTouch(at, away, triangle.tag)
        for tag, center, size in self._balls:
            ax, ay, az = center.tolist()
            at, away = _meet((x - ax, y - ay, z - az), way, length2, radius + size, least)
            if at < best:
                best, found = at, FirstTouch(at, away, tag)
        if found is None:
            return None
        nx, ny, nz = found.normal
        size = math.sqrt(nx * nx + ny * ny + nz * nz)
        return FirstTouch(best, (nx / size, ny / size, nz / size), found.tag) if size > 0.0 else None

    # --- inside -------------------------------------------------------------------------------------------------

    def _around(self, x: float, y: float, z: float, reach: float) -> list[_Triangle]:
        """Triangles that may be within reach of a place [m]."""
        size = _CUBE
        while reach > 0.5 * size:
            size *= 2.0
        key = size, x // size, y // size, z // size
        found = self._cubes.get(key)
        if found is None:
            if not self._is_ready:
                self._prepare()
            corner = np.array(key[1:]) * size
            near = (self._low <= corner + 1.5 * size) & (self._high >= corner - 0.5 * size)
            found = self._cubes[key] = [self._triangles[n] for n in near.all(axis=1).nonzero()[0].tolist()]
        return found

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
        corner, normal = corner[kept], normal[kept] / area[kept][:, None]
        edge = np.roll(corner, -1, axis=1) - corner
        length = np.sqrt(np.einsum("pkj,pkj->pk", edge, edge))[..., None]
        edge /= length
        inward = np.cross(normal[:, None], edge)
        inside = np.einsum("pkj,pkj->pk", inward, corner)[..., None] - _SLACK
        height = np.einsum("ij,ij->i", normal, corner[:, 0])[:, None]
        self._low, self._high = corner.min(axis=1, initial=np.inf), corner.max(axis=1, initial=-np.inf)
        own_edges, own_corners = _own(corner, normal, inward)
        every, sides = np.concatenate((corner, edge, length), axis=2), np.concatenate((inward, inside), axis=2)
        self._triangles = [
            _Triangle(
                tuple(plane),
                tuple(low),
                tuple(high),
                side,
                [one for one, is_own in zip(lines, own, strict=True) if is_own],
                [one[:3] for one, is_own in zip(lines, points, strict=True) if is_own],
                tag,
            )
            for plane, low, high, side, lines, own, points, tag in zip(
                np.concatenate((normal, height), axis=1).tolist(),
                *(rows.tolist() for rows in (self._low, self._high, sides, every, own_edges, own_corners)),
                np.concatenate(tags)[kept].tolist(),
                strict=True,
            )
        ]
        ends = [self._low, *(center[None] - size for _, center, size in self._balls)]
        self._bounds = (
            np.concatenate(ends).min(axis=0, initial=np.inf),
            np.concatenate([self._high, *(center[None] + size for _, center, size in self._balls)]).max(
                axis=0, initial=-np.inf
            ),
        )
        self._is_ready = True


def _own(corner: FloatArray, normal: FloatArray, inward: FloatArray) -> tuple[BoolArray, BoolArray]:
    """Which edges and corners of triangles are to be looked at, shape (n, 3) each.

    Each one once, though triangles share them; and no edge between two triangles of one plane, which is inside a face.
    """
    _, number = np.unique(corner.reshape(-1, 3).round(6), axis=0, return_inverse=True)
    number = number.reshape(-1, 3)
    pair = np.sort(np.stack((number, np.roll(number, -1, axis=1))), axis=0)
    code = (pair[0] * (number.max(initial=0) + 1) + pair[1]).ravel()
    edges, corners = np.zeros(code.shape, dtype=bool), np.zeros(code.shape, dtype=bool)
    corners[np.unique(number, return_index=True)[1]] = True
    _, first, count = np.unique(code, return_index=True, return_counts=True)
    last = len(code) - 1 - np.unique(code[::-1], return_index=True)[1]
    sides, faces = inward.reshape(-1, 3), np.repeat(normal, 3, axis=0)
    is_flat = np.einsum("ij,ij->i", faces[first], faces[last]) > 1.0 - _FLAT
    is_flat &= (count == 2) & (np.einsum("ij,ij->i", sides[first], sides[last]) < 0.0)
    edges[first[~is_flat]] = True
    return edges.reshape(-1, 3), corners.reshape(-1, 3)


def _meet(x: Vector, way: Vector, length2: float, radius: float, least: float) -> tuple[float, Vector]:
    """When a place comes as near to the origin as a radius, as `_reach` says, and where it is then."""
    (a, b, c), (u, v, w) = x, way
    at = _reach(a * a + b * b + c * c, a * u + b * v + c * w, length2, radius, least)
    return at, (a + at * u, b + at * v, c + at * w)


def _reach(away2: float, closing: float, speed2: float, radius: float, least: float) -> float:
    """Part of a way after which a place is as near to the origin as a radius; inf: never, or it moves away.

    Args:
        away2: Square of its distance [m^2].
        closing: Way times place.
        speed2: Square of the way.
        radius: [m]
        least: Part of the way toward the origin from which on it counts [m].
    """
    gap, least = away2 - radius * radius, least * radius
    root = closing * closing - speed2 * gap
    if closing >= -least or root <= least * least:
        return math.inf
    return max(gap, 0.0) / (math.sqrt(root) - closing)


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
