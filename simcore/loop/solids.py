"""Convex solids: arrays, distance from a point, ray casts, and overlap with a box.

Balls collide with the floor, with other balls and with convex solids. Field elements are solids in the field frame.
Parts of robots and of other bodies are solids in the body frame. The arrays contain the triangles of each solid and the
planes of the triangles.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from simcore.loop.compiled import compiled, inlined, inner
from simcore.loop.robot_state import Records
from simcore.typing import FloatArray, IntArray

__all__ = ["FIELD", "NO_SOLIDS", "Solids", "find_in_box", "first_hits", "nearest_point"]

FIELD = -1
"""Value of `Solids.body` for solids of the field."""
_FACE = 1e-9  # squared distance from the foot of the perpendicular below which a nearest point is in a face [m^2]


class Solids(NamedTuple):
    """Convex solids of a world; solids of the same body have consecutive rows."""

    body: IntArray
    """Row of the body of each solid, `FIELD` for the field, shape (n,)."""
    box: FloatArray
    """Lowest and highest corner of each solid's bounding box, field or body frame [m], shape (n, 6)."""
    surface: FloatArray
    """Friction factor [-], restitution factor [-] and rolling-resistance lever [m] of each solid, shape (n, 3)."""
    row: IntArray
    """Row of the field element or body that contains each solid, shape (n,)."""
    is_drivable: npt.NDArray[np.uint8]
    """Whether robots drive on each solid, shape (n,)."""
    is_in_plan: npt.NDArray[np.uint8]
    """Whether bumpers collide with the plan-view outline of each solid, shape (n,)."""
    first: IntArray
    """Index of each solid's first triangle; the last element is the number of triangles, shape (n + 1,)."""
    plane: FloatArray
    """Outward unit normal [-] and distance from the origin [m] of each triangle's plane, shape (t, 4)."""
    corner: FloatArray
    """Corners of each triangle, counter-clockwise seen from outside [m], shape (t, 9)."""
    cell_first: IntArray
    """Index of each grid cell's first entry in `cell_solid`; the last element is the number of entries,
    shape (nx * ny + 1,)."""
    cell_solid: IntArray
    """Rows of the field's solids in each grid cell, cell by cell, shape (entries,)."""
    cell_count: IntArray
    """Number of grid cells along x and y, shape (2,)."""
    cell_low: FloatArray
    """Lowest x and y of the grid, and edge length of a cell [m], shape (3,)."""


NO_SOLIDS = Solids(
    body=np.zeros(0, np.int64), box=np.zeros((0, 6)), surface=np.zeros((0, 3)), row=np.zeros(0, np.int64),
    is_drivable=np.zeros(0, np.uint8), is_in_plan=np.zeros(0, np.uint8), first=np.zeros(1, np.int64),
    plane=np.zeros((0, 4)), corner=np.zeros((0, 9)), cell_first=np.zeros(1, np.int64),
    cell_solid=np.zeros(0, np.int64), cell_count=np.zeros(2, np.int64), cell_low=np.array([0.0, 0.0, 1.0]),
)  # fmt: skip
"""Solids of an empty world."""


@inner
def _closest_on_triangle(x, y, z, ax, ay, az, bx, by, bz, cx, cy, cz):
    """Return the point of a triangle a, b, c that is nearest to a point x, y, z [m].

    Source: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
    """
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


@inlined
def nearest_point(solid, x, y, z, reach, first, plane, corner):
    """Return the distance of a point from a convex solid, and the unit normal from the solid towards the point.

    Args:
        solid: Row of the solid.
        x: x coordinate of the point in the solid's frame [m].
        y: y coordinate of the point [m].
        z: z coordinate of the point [m].
        reach: Distance beyond which a lower bound of the distance is sufficient [m].
        first: Array `Solids.first`.
        plane: Array `Solids.plane`.
        corner: Array `Solids.corner`.

    Returns:
        Distance, negative inside [m]; x, y, z of the unit normal; whether the nearest point of the solid is in a face.
    """
    most, face = -1e30, -1
    for t in range(first[solid], first[solid + 1]):
        over = plane[t, 0] * x + plane[t, 1] * y + plane[t, 2] * z - plane[t, 3]
        if over > most:
            most, face = over, t
            if most > reach:
                break
    distance, nx, ny, nz, is_face = most, plane[face, 0], plane[face, 1], plane[face, 2], True
    if 0.0 < most <= reach:  # outside the solid and within reach
        least = 1e30
        for t in range(first[solid], first[solid + 1]):
            over = plane[t, 0] * x + plane[t, 1] * y + plane[t, 2] * z - plane[t, 3]
            if over <= 0.0:
                continue
            px, py, pz = _closest_on_triangle(
                x, y, z, corner[t, 0], corner[t, 1], corner[t, 2], corner[t, 3], corner[t, 4], corner[t, 5],
                corner[t, 6], corner[t, 7], corner[t, 8],
            )  # fmt: skip
            px, py, pz = x - px, y - py, z - pz
            square = px * px + py * py + pz * pz
            if square < least:
                least, nx, ny, nz = square, px, py, pz
                is_face = square - over * over < _FACE
                if is_face and over >= most:  # no point of the solid is nearer than this plane
                    break
        distance = math.sqrt(least)
        if distance < 1e-12:
            distance, nx, ny, nz, is_face = 0.0, plane[face, 0], plane[face, 1], plane[face, 2], True
        else:
            nx, ny, nz = nx / distance, ny / distance, nz / distance
    return distance, nx, ny, nz, is_face


@inner
def _hit_triangles(solids, s, ox, oy, oz, dx, dy, dz, nearest):
    """Return the fraction of a ray's length at which the ray enters a solid, at most `nearest`."""
    corner, plane = solids.corner, solids.plane
    for t in range(solids.first[s], solids.first[s + 1]):
        slope = plane[t, 0] * dx + plane[t, 1] * dy + plane[t, 2] * dz
        if slope >= 0.0:
            continue
        over = plane[t, 0] * ox + plane[t, 1] * oy + plane[t, 2] * oz - plane[t, 3]
        part = -over / slope
        if over < 0.0 or part >= nearest:
            continue
        x, y, z = ox + part * dx, oy + part * dy, oz + part * dz
        is_inside = True
        for e in range(3):
            i, j = 3 * e, 3 * ((e + 1) % 3)
            ax, ay, az = corner[t, i], corner[t, i + 1], corner[t, i + 2]
            ex, ey, ez = corner[t, j] - ax, corner[t, j + 1] - ay, corner[t, j + 2] - az
            px, py, pz = x - ax, y - ay, z - az
            cx, cy, cz = ey * pz - ez * py, ez * px - ex * pz, ex * py - ey * px
            if cx * plane[t, 0] + cy * plane[t, 1] + cz * plane[t, 2] < -1e-12:
                is_inside = False
                break
        if is_inside:
            nearest = part
    return nearest


@inner
def _passes_box(box, s, ox, oy, oz, dx, dy, dz, nearest):
    """Return whether a ray meets the bounding box of a solid before the fraction `nearest` of the ray's length."""
    enter, leave = 0.0, nearest
    for axis in range(3):
        o = ox if axis == 0 else oy if axis == 1 else oz
        d = dx if axis == 0 else dy if axis == 1 else dz
        if d == 0.0:
            if o < box[s, axis] or o > box[s, 3 + axis]:
                return False
            continue
        a, b = (box[s, axis] - o) / d, (box[s, 3 + axis] - o) / d
        enter, leave = max(enter, min(a, b)), min(leave, max(a, b))
    return enter <= leave


@compiled
def first_hits(
    solids: Solids, bodies: Records, has_floor: bool, start: FloatArray, end: FloatArray, with_robots: bool,
    ignored: int, drivable: bool, fraction: FloatArray, row: IntArray,
) -> None:  # fmt: skip
    """Find the first hit of each line segment on the floor, the field, robots, and drivable bodies.

    Segments hit bodies that are not robots only if `drivable` is set. A solid that contains the start of a segment does
    not count as a hit.

    Args:
        solids: Solids of the field and of bodies.
        bodies: Records of all bodies.
        has_floor: Whether there is a floor at z = 0, with row 0.
        start: Starts of the segments, field frame [m], shape (n, 3).
        end: Ends of the segments, field frame [m], shape (n, 3).
        with_robots: Whether segments hit robots; ignored if `drivable`.
        ignored: Row of a robot that segments do not hit, -1 to hit all robots.
        drivable: Whether segments hit only the floor and solids of field and bodies that robots can drive on.
        fraction: Filled with the fraction of each segment before the hit, 1 without a hit, shape (n,).
        row: Filled with the row of the body or field element that is hit, -1 without a hit, shape (n,).
    """
    for k in range(len(start)):
        ox, oy, oz = start[k, 0], start[k, 1], start[k, 2]
        dx, dy, dz = end[k, 0] - ox, end[k, 1] - oy, end[k, 2] - oz
        nearest, met = 1.0, -1
        if has_floor and oz >= 0.0 and oz + dz < 0.0:
            nearest, met = -oz / dz, 0
        for s in range(len(solids.body)):
            if solids.body[s] != FIELD or (drivable and not solids.is_drivable[s]):
                continue
            if _passes_box(solids.box, s, ox, oy, oz, dx, dy, dz, nearest):
                part = _hit_triangles(solids, s, ox, oy, oz, dx, dy, dz, nearest)
                if part < nearest:
                    nearest, met = part, solids.row[s]
        for b in range(len(bodies)):
            body = bodies[b]
            if body.model.row == ignored or (body.model.is_robot and (drivable or not with_robots)):
                continue
            if not body.model.is_robot and not (drivable and solids.is_drivable[body.model.first_solid]):
                continue
            axes, pos = body.axes, body.pos
            px, py, pz = ox - pos[0], oy - pos[1], oz - pos[2]
            lx = axes[0, 0] * px + axes[1, 0] * py + axes[2, 0] * pz
            ly = axes[0, 1] * px + axes[1, 1] * py + axes[2, 1] * pz
            lz = axes[0, 2] * px + axes[1, 2] * py + axes[2, 2] * pz
            ux = axes[0, 0] * dx + axes[1, 0] * dy + axes[2, 0] * dz
            uy = axes[0, 1] * dx + axes[1, 1] * dy + axes[2, 1] * dz
            uz = axes[0, 2] * dx + axes[1, 2] * dy + axes[2, 2] * dz
            for s in range(body.model.first_solid, body.model.last_solid):
                if _passes_box(solids.box, s, lx, ly, lz, ux, uy, uz, nearest):
                    part = _hit_triangles(solids, s, lx, ly, lz, ux, uy, uz, nearest)
                    if part < nearest:
                        nearest, met = part, body.model.row
        fraction[k] = nearest
        row[k] = met


@compiled
def find_in_box(
    solids: Solids, x: float, y: float, yaw: float, half_length: float, half_width: float, bottom: float, top: float,
    met: npt.NDArray[np.uint8],
) -> None:  # fmt: skip
    """Find the solids of the field that may overlap an upright box, by height and plan-view outline.

    The separating-axis test uses four axes: the sides of the box and the axes of the field. The test is conservative: a
    solid that is marked may still have a small gap to the box.

    Args:
        solids: Solids of the field and of bodies.
        x: x coordinate of the center of the box, field frame [m].
        y: y coordinate of the center of the box, field frame [m].
        yaw: Yaw of the box's length axis, field frame [rad].
        half_length: Half of the length of the box [m].
        half_width: Half of the width of the box [m].
        bottom: Height of the bottom of the box [m].
        top: Height of the top of the box [m].
        met: Filled with 1 for solids that may overlap the box, else 0, shape (n,).
    """
    c, s = math.cos(yaw), math.sin(yaw)
    wide, deep = abs(c) * half_length + abs(s) * half_width, abs(s) * half_length + abs(c) * half_width
    for k in range(len(solids.body)):
        box = solids.box[k]
        met[k] = 0
        if solids.body[k] != FIELD or box[2] >= top or box[5] <= bottom:
            continue
        if box[0] >= x + wide or box[3] <= x - wide or box[1] >= y + deep or box[4] <= y - deep:
            continue
        low_a, high_a, low_b, high_b = 1e30, -1e30, 1e30, -1e30
        for t in range(solids.first[k], solids.first[k + 1]):
            for e in range(3):
                px, py = solids.corner[t, 3 * e] - x, solids.corner[t, 3 * e + 1] - y
                a, b = c * px + s * py, c * py - s * px
                low_a, high_a, low_b, high_b = min(low_a, a), max(high_a, a), min(low_b, b), max(high_b, b)
        if low_a < half_length and high_a > -half_length and low_b < half_width and high_b > -half_width:
            met[k] = 1
