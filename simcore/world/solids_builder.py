"""Conversion of shapes of field elements and bodies into convex solids for the compiled loop."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from simcore.loop.solids import FIELD, Solids
from simcore.typing import FloatArray, IntArray
from simcore.world.rotation import Quaternion, matrix
from simcore.world.shapes import Box, Compound, Cylinder, Hull, Mesh, Part, Shape, Sphere

__all__ = ["SolidsBuilder"]

_SIDES = 48  # number of sides of the prism for a cylinder: error 0.2 % of the radius
_POINTS = 162  # number of corners of the polyhedron for a sphere: error 0.5 % of the radius
_AROUND = 1.0  # [m], margin of the cells around the solids
_CELL, _MOST_CELLS = 0.25, 50_000  # edge of a cell [m], larger on fields that would exceed the number of cells


class _Part(NamedTuple):
    row: int
    body: int
    drivable: bool
    in_plan: bool
    corner: FloatArray
    plane: FloatArray
    surface: tuple[float, float, float]


class SolidsBuilder:
    """Builder that collects shapes and converts them to `Solids`."""

    def __init__(self) -> None:
        self._parts: list[_Part] = []
        self._built: Solids | None = None
        self.count = 0
        """Number of solids added so far."""

    def add(
        self,
        shape: Shape,
        pos: FloatArray | tuple[float, float, float],
        quat: Quaternion,
        surface: tuple[float, float, float],
        *,
        row: int = 0,
        body: int = FIELD,
        drivable: bool = False,
        in_plan: bool = False,
    ) -> int:
        """Add one solid for each convex part of a shape, and return the index of the first new solid.

        Args:
            shape: Collision shape; each triangle of a mesh becomes a solid.
            pos: Origin of the shape in the frame of the field or the body [m].
            quat: Attitude of the shape in the frame of the field or the body.
            surface: Friction [-], restitution [-] and rolling lever [m].
            row: Row of the field element or body with this shape.
            body: Number of the body in `Bodies`, or `FIELD` for the static field.
            drivable: Whether robots drive on the shape.
            in_plan: Whether bumpers collide with the plan-view outline of the shape, and not with the solids.
        """
        axes, at, first = matrix(quat), np.asarray(pos, dtype=float), self.count
        flags = row, body, drivable, in_plan
        if isinstance(shape, Mesh):
            for a, b, c in shape.vertices[shape.faces]:
                self._put(flags, np.array([[a, b, c], [a, c, b]]) @ axes.T + at, surface)
            return first
        for part in shape.parts if isinstance(shape, Compound) else (Part(shape),):
            triangles = _triangles(part.shape) @ matrix(part.quat).T + np.array(part.offset)
            self._put(flags, triangles @ axes.T + at, surface)
        return first

    def _put(
        self, flags: tuple[int, int, bool, bool], triangles: FloatArray, surface: tuple[float, float, float]
    ) -> None:
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        plane = np.column_stack([normal, np.einsum("ij,ij->i", normal, triangles[:, 0])])
        self._parts.append(_Part(*flags, triangles.reshape(-1, 9), plane, surface))
        self.count += 1
        self._built = None

    @property
    def solids(self) -> Solids:
        """All solids added so far, as arrays for the compiled loop."""
        if self._built is None:
            self._built = self._build()
        return self._built

    def _build(self) -> Solids:
        parts = self._parts
        body = np.array([part.body for part in parts], dtype=np.int64)
        first = np.concatenate(([0], np.cumsum([len(part.corner) for part in parts]))).astype(np.int64)
        points = [part.corner.reshape(-1, 3) for part in parts]
        box = np.array([[*p.min(axis=0), *p.max(axis=0)] for p in points]).reshape(-1, 6)
        low, count, cell_first, cell_solid = _cells(box, body)
        return Solids(
            body=body,
            box=box,
            surface=np.array([part.surface for part in parts], dtype=float).reshape(-1, 3),
            row=np.array([part.row for part in parts], dtype=np.int64),
            is_drivable=np.array([part.drivable for part in parts], dtype=np.uint8),
            is_in_plan=np.array([part.in_plan for part in parts], dtype=np.uint8),
            first=first,
            plane=np.vstack([np.empty((0, 4)), *(part.plane for part in parts)]),
            corner=np.vstack([np.empty((0, 9)), *(part.corner for part in parts)]),
            cell_first=cell_first,
            cell_solid=cell_solid,
            cell_count=count,
            cell_low=low,
        )


def _cells(box: FloatArray, body: IntArray) -> tuple[FloatArray, IntArray, IntArray, IntArray]:
    """Divide the field into square cells and list the solids in each cell.

    Args:
        box: Low and high corners of each solid [m], shape (n, 6).
        body: Number of the body of each solid, shape (n,).

    Returns:
        `cell_low`, `cell_count`, `cell_first` and `cell_solid` of `Solids`.
    """
    fixed = np.nonzero(body == FIELD)[0]
    if not len(fixed):
        return np.array([0.0, 0.0, _CELL]), np.zeros(2, np.int64), np.zeros(1, np.int64), np.zeros(0, np.int64)
    low = box[fixed, :2].min(axis=0) - _AROUND
    size = box[fixed, 3:5].max(axis=0) + _AROUND - low
    edge = max(_CELL, math.sqrt(float(size[0] * size[1]) / _MOST_CELLS))
    count = np.ceil(size / edge).astype(np.int64)
    cells: list[list[int]] = [[] for _ in range(int(count[0] * count[1]))]
    for solid in fixed.tolist():
        x0, y0 = ((box[solid, :2] - low) / edge).astype(int)
        x1, y1 = ((box[solid, 3:5] - low) / edge).astype(int)
        for cx in range(x0, x1 + 1):
            for cy in range(y0, y1 + 1):
                cells[cx * int(count[1]) + cy].append(solid)
    first = np.concatenate(([0], np.cumsum([len(cell) for cell in cells]))).astype(np.int64)
    return np.array([*low, edge]), count, first, np.array([solid for cell in cells for solid in cell], dtype=np.int64)


@lru_cache(maxsize=256)
def _triangles(shape: Sphere | Cylinder | Box | Hull) -> FloatArray:
    """Return the triangles of a convex shape, counter-clockwise seen from outside, shape frame [m], shape (n, 3, 3)."""
    if isinstance(shape, Cylinder):
        turn = np.arange(_SIDES) * math.tau / _SIDES
        ring = shape.radius * np.column_stack([np.cos(turn), np.sin(turn)])
        points = np.vstack(
            [np.column_stack([ring, np.full(_SIDES, z)]) for z in (-0.5 * shape.height, 0.5 * shape.height)]
        )
    elif isinstance(shape, Sphere):
        points = shape.radius * _sphere_points()
    elif isinstance(shape, Box):
        points = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T * np.array(shape.size)
    else:
        points = shape.points
    hull = ConvexHull(points)
    triangles = points[hull.simplices]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inward = np.einsum("ij,ij->i", normal, hull.equations[:, :3]) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    kept: FloatArray = triangles[np.linalg.norm(normal, axis=1) > 1e-12]
    return kept


def _sphere_points() -> FloatArray:
    """Return points distributed evenly over a unit sphere, shape (n, 3)."""
    k = np.arange(_POINTS) + 0.5
    z, turn = 1.0 - 2.0 * k / _POINTS, math.pi * (1.0 + math.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z * z)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])
