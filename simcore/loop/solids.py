"""Convex solids: their arrays, and the nearest point of one to the center of a ball.

Everything that balls touch, but the floor and each other, is a convex solid: elements of the field in the field frame,
parts of robots and of other bodies in the frame of their body. A solid is its triangles with their planes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from simcore.loop.compiled import compiled
from simcore.typing import FloatArray, IntArray

__all__ = ["FIELD", "Solids", "nearest_point"]

FIELD = -1
"""Body of the solids that stand on the field."""
_FACE = 1e-9  # [m^2]; a nearest point this near to the foot of the perpendicular is in a face


class Solids(NamedTuple):
    """All convex solids of a world, those of one body in a row."""

    body: IntArray
    """Row of the body of each, `FIELD` for the field's, shape (n,)."""
    box: FloatArray
    """Lowest and highest corner in its frame [m], shape (n, 6)."""
    surface: FloatArray
    """Friction [-], restitution [-] and rolling lever [m] of each, shape (n, 3)."""
    first: IntArray
    """First triangle of each, and the number of all, shape (n + 1,)."""
    plane: FloatArray
    """Of each triangle, outward unit normal and offset [m], shape (t, 4)."""
    corner: FloatArray
    """Its three corners, counter-clockwise seen from outside [m], shape (t, 9)."""
    cell_first: IntArray
    """First entry of `cell_solid` of each cell of the field, and the number of all, shape (nx * ny + 1,)."""
    cell_solid: IntArray
    """Solids of the field by cell, shape (entries,)."""
    cell_count: IntArray
    """Number of cells along x and y, shape (2,)."""
    cell_low: FloatArray
    """Lowest corner of the cells, and edge of one [m], shape (3,)."""


@compiled
def _closest_on_triangle(x, y, z, corner, t):
    """Point of a triangle that is nearest to a place [m].

    Source: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
    """
    ax, ay, az = corner[t, 0], corner[t, 1], corner[t, 2]
    bx, by, bz = corner[t, 3], corner[t, 4], corner[t, 5]
    cx, cy, cz = corner[t, 6], corner[t, 7], corner[t, 8]
    abx, aby, abz = bx - ax, by - ay, bz - az
    acx, acy, acz = cx - ax, cy - ay, cz - az
    px, py, pz = x - ax, y - ay, z - az
    d1 = abx * px + aby * py + abz * pz
    d2 = acx * px + acy * py + acz * pz
    if d1 <= 0.0 and d2 <= 0.0:
        return ax, ay, az
    px, py, pz = x - bx, y - by, z - bz
    d3 = abx * px + aby * py + abz * pz
    d4 = acx * px + acy * py + acz * pz
    if d3 >= 0.0 and d4 <= d3:
        return bx, by, bz
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v = d1 / (d1 - d3)
        return ax + v * abx, ay + v * aby, az + v * abz
    px, py, pz = x - cx, y - cy, z - cz
    d5 = abx * px + aby * py + abz * pz
    d6 = acx * px + acy * py + acz * pz
    if d6 >= 0.0 and d5 <= d6:
        return cx, cy, cz
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        w = d2 / (d2 - d6)
        return ax + w * acx, ay + w * acy, az + w * acz
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return bx + w * (cx - bx), by + w * (cy - by), bz + w * (cz - bz)
    scale = 1.0 / (va + vb + vc)
    v, w = vb * scale, vc * scale
    return ax + abx * v + acx * w, ay + aby * v + acy * w, az + abz * v + acz * w


@compiled
def nearest_point(solid, x, y, z, reach, first, plane, corner):
    """Distance of a place from a convex solid, and the way out.

    Args:
        solid: Which one.
        x: Of the place, in the solid's frame [m].
        y: The same [m].
        z: The same [m].
        reach: Farther solids need no exact answer [m].
        first: See `Solids`.
        plane: The same.
        corner: The same.

    Returns:
        Distance, negative inside [m]; unit normal towards the place; whether the nearest point is within a face.
    """
    most, face = -1e30, -1
    for t in range(first[solid], first[solid + 1]):
        over = plane[t, 0] * x + plane[t, 1] * y + plane[t, 2] * z - plane[t, 3]
        if over > most:
            most, face = over, t
            if over > reach:
                return over, 0.0, 0.0, 1.0, False
    if most <= 0.0:  # inside: out through the nearest face
        return most, plane[face, 0], plane[face, 1], plane[face, 2], True
    least = 1e30
    dx = dy = dz = 0.0
    is_face = False
    for t in range(first[solid], first[solid + 1]):
        over = plane[t, 0] * x + plane[t, 1] * y + plane[t, 2] * z - plane[t, 3]
        if over <= 0.0:
            continue
        px, py, pz = _closest_on_triangle(x, y, z, corner, t)
        px, py, pz = x - px, y - py, z - pz
        square = px * px + py * py + pz * pz
        if square < least:
            least, dx, dy, dz = square, px, py, pz
            is_face = square - over * over < _FACE
    distance = math.sqrt(least)
    if distance < 1e-12:
        return 0.0, plane[face, 0], plane[face, 1], plane[face, 2], True
    return distance, dx / distance, dy / distance, dz / distance, is_face
