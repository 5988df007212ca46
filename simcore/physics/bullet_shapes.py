"""Collision shapes of PyBullet: made once for all bodies of one shape, with what it needs to take hulls at all."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from simcore.errors import EngineError
from simcore.geometry.rotation import IDENTITY, matrix, rotate
from simcore.physics.shapes import (
    Box,
    Compound,
    Cylinder,
    HalfSpace,
    Hull,
    Mesh,
    Part,
    Shape,
    Sphere,
    bounding_box,
    outline_points,
    parts_of,
    smallest_thickness,
)

__all__ = ["BulletShapes"]

_MOST_SHAPES = 16
_HULL_MARGIN = 0.001  # [m], that it puts around hulls


class BulletShapes:
    """The shapes of one client.

    Args:
        pybullet: The module.
        client: Number of the client.
    """

    def __init__(self, pybullet: Any, client: int) -> None:
        self._p = pybullet
        self._kw = {"physicsClientId": client}
        self._shapes: dict[tuple[object, ...], int] = {}
        self._compounds: dict[Shape, int] = {}

    def moving(self, shape: Shape) -> int:
        """Collision shape id of what moves: all bodies of one shape share it, and hulls have their true size.

        A box is eight: with a hull each has one contact, and on a single one a block rocks, sinks in (by 84 mm on a
        slope) and drags (with 14 % too much friction there).
        """
        if isinstance(shape, Sphere | Cylinder):
            return self.static(shape)
        if shape not in self._compounds:
            parts = [_plain(part) for part in parts_of(shape)]
            if len(parts) == 1 and isinstance(parts[0].shape, Box):
                parts = _octants(parts[0])
            self._compounds[shape] = self._compound(Compound(tuple(parts)))
        return self._compounds[shape]

    def static(self, shape: Shape) -> int:
        """Collision shape id; equal spheres, boxes and cylinders share one."""
        p, kw = self._p, self._kw
        if isinstance(shape, Compound):
            return self._compound(shape)
        if isinstance(shape, Hull):
            return int(
                p.createCollisionShape(
                    p.GEOM_MESH, vertices=_corners(np.asarray(shape.points, dtype=np.float64).tobytes()), **kw
                )
            )
        if isinstance(shape, Mesh):
            return int(
                p.createCollisionShape(
                    p.GEOM_MESH,
                    vertices=shape.vertices.tolist(),
                    indices=shape.faces.ravel().tolist(),
                    flags=p.GEOM_FORCE_CONCAVE_TRIMESH,
                    **kw,
                )
            )
        key = (type(shape), shape)
        if key not in self._shapes:
            if isinstance(shape, HalfSpace):
                made = p.createCollisionShape(p.GEOM_PLANE, planeNormal=[0, 0, 1], **kw)
            elif isinstance(shape, Sphere):
                made = p.createCollisionShape(p.GEOM_SPHERE, radius=shape.radius, **kw)
            elif isinstance(shape, Cylinder):
                made = p.createCollisionShape(p.GEOM_CYLINDER, radius=shape.radius, height=shape.height, **kw)
            else:
                made = p.createCollisionShape(p.GEOM_BOX, halfExtents=[s / 2 for s in shape.size], **kw)
            self._shapes[key] = int(made)
        return self._shapes[key]

    def _compound(self, compound: Compound) -> int:
        """A shape of several; it takes hulls from files only, so all of them are written to one, which is deleted.

        It takes 16 shapes and says nothing about those left out; a file counts as one, however many hulls are in it.
        It never frees such hulls: a world with one kind of 24 hulls costs a process 0.22 MB.
        """
        p = self._p
        parts = [_plain(part) for part in compound.parts]
        hulls = [part for part in parts if isinstance(part.shape, Hull)]
        parts = [part for part in parts if not isinstance(part.shape, Hull)]
        n = len(parts) + bool(hulls)
        if n > _MOST_SHAPES:
            raise EngineError(f"PyBullet takes {_MOST_SHAPES} shapes in one, all hulls counted as one, got {n}")
        types, radii, halves, lengths = [p.GEOM_MESH] * n, [0.0] * n, [[0.0] * 3] * n, [0.0] * n
        files = [""] * n
        for i, part in enumerate(parts):
            shape = part.shape
            if isinstance(shape, Sphere):
                types[i], radii[i] = p.GEOM_SPHERE, shape.radius
            elif isinstance(shape, Cylinder):
                types[i], radii[i], lengths[i] = p.GEOM_CYLINDER, shape.radius, shape.height
            elif isinstance(shape, Box):
                types[i], halves[i] = p.GEOM_BOX, [s / 2 for s in shape.size]
        with ExitStack() as stack:
            if hulls:
                folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="simcore_hulls_"))
                files[-1] = _hull_file(Path(folder), hulls)
            made = p.createCollisionShapeArray(
                shapeTypes=types,
                radii=radii,
                halfExtents=halves,
                lengths=lengths,
                collisionFramePositions=[part.offset for part in parts] + [[0, 0, 0]] * bool(hulls),
                collisionFrameOrientations=[part.quat for part in parts] + [IDENTITY] * bool(hulls),
                planeNormals=[[0, 0, 1]] * n,
                fileNames=files,
                meshScales=[[1, 1, 1]] * n,
                **self._kw,
            )
        if made < 0:
            raise EngineError(f"PyBullet could not make a shape of {n} parts")
        return int(made)


def _octants(box: Part) -> list[Part]:
    corners = 0.5 * outline_points(box.shape)
    length, width, height = np.ptp(corners, axis=0).tolist()
    places = np.add(box.offset, corners @ matrix(box.quat).T).tolist()
    return [Part(Box((length, width, height)), (x, y, z), box.quat) for x, y, z in places]


def _plain(part: Part) -> Part:
    """The same part as a box, if it is a hull that is one: a box has more than one contact with a wall at a time."""
    if not isinstance(part.shape, Hull) or len(part.shape.points) != 8:
        return part
    low, high = bounding_box(part.shape)
    middle, size = 0.5 * (low + high), high - low
    if not np.allclose(np.abs(part.shape.points - middle), 0.5 * size, atol=1e-9):
        return part
    x, y, z = np.add(part.offset, rotate(part.quat, middle.tolist())).tolist()
    length, width, height = size.tolist()
    return Part(Box((length, width, height)), (x, y, z), part.quat)


def _hull_file(folder: Path, hulls: Sequence[Part]) -> str:
    """Write hulls as objects of an OBJ file, each within what PyBullet adds around it; returns the file's path."""
    lines, first = [], 1
    for number, part in enumerate(hulls):
        assert isinstance(part.shape, Hull)
        points = np.ascontiguousarray(part.shape.points, dtype=np.float64)
        inner = np.array(_without_margin(points.tobytes()))
        faces = ConvexHull(inner).simplices + first
        placed = (inner @ matrix(part.quat).T + part.offset).tolist()
        lines.append(f"o part{number}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in placed] + [f"f {a} {b} {c}" for a, b, c in faces.tolist()]
        first += len(inner)
    content = "\n".join(lines) + "\n"
    path = folder / f"{hashlib.sha256(content.encode()).hexdigest()[:24]}.obj"  # files of one name are read once
    path.write_text(content, encoding="ascii")
    return str(path)


@lru_cache(maxsize=256)
def _without_margin(points: bytes) -> list[list[float]]:
    """Corners of a hull whose faces are as far inside as PyBullet puts its own outside of them."""
    corners = np.frombuffer(points).reshape(-1, 3)
    planes = ConvexHull(corners).equations.copy()
    planes[:, 3] += _HULL_MARGIN
    try:
        inner = HalfspaceIntersection(np.unique(planes.round(12), axis=0), corners.mean(axis=0)).intersections
    except QhullError as error:
        raise EngineError(
            f"PyBullet needs hulls that are thicker than {2e3 * _HULL_MARGIN:.0f} mm, this one is "
            f"{1e3 * smallest_thickness(Hull(corners)):.1f} mm"
        ) from error
    inner = inner[np.sort(ConvexHull(inner).vertices)]
    rows: list[list[float]] = inner.tolist()
    return rows


@lru_cache(maxsize=4096)
def _corners(points: bytes) -> list[list[float]]:
    """Rows of float64 coordinates as a list. PyBullet never frees a list of corners, so equal hulls share one."""
    rows: list[list[float]] = np.frombuffer(points).reshape(-1, 3).tolist()
    return rows
