"""The camera's pose from the corners of any number of tags: least squares on the picture, and how sure it is.

The camera stands at c and turns field into optical axes by R: p = R (X - c), seen at (x, y) = (p_x, p_y) / p_z. A small
turn w about the optical axes moves p by -w x p, a small step s along them by -s. Everything is in these ideal
coordinates: pixels from the principal point over the focal length.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dposv

from simcore.geometry.quaternion import Vector
from simcore.typing import FloatArray

__all__ = ["CameraSolution", "refine_pose", "solve_position"]

_ITERATIONS = 12
_CONVERGED = 1e-18  # square of the last step [m^2 and rad^2]
_GAIN = 0.2
"""Part of the squared error; the step that wins less is the last one. What it leaves is its own square: under a
hundredth of what noise does to the answer."""


@dataclass(slots=True, eq=False)
class CameraSolution:
    """A camera pose that fits the corners best. Treat it as read-only."""

    position: FloatArray
    """Field frame [m], shape (3,)."""
    rotation: FloatArray
    """From field to optical axes, shape (3, 3)."""
    error: float
    """Root mean square distance of corners [-]."""
    normal: FloatArray
    """Matrix of the normal equations for turn and step along the optical axes, shape (6, 6): the inverse of their
    covariance for a noise of 1."""


def refine_pose(
    points: Sequence[Sequence[float]], ideal: Sequence[Sequence[float]], position: FloatArray, rotation: FloatArray
) -> CameraSolution | None:
    """Gauss-Newton from a first guess. Plain floats: 20 us a step for two tags, with arrays 45.

    Args:
        points: Corners, field frame [m], n >= 4 of three numbers.
        ideal: Where they are seen [-], n of two.
        position: First guess of the camera's place [m].
        rotation: First guess, field to optical axes.

    Returns:
        None if it runs away, which a guess from `solve_square` does not.
    """
    for _ in range(_ITERATIONS):
        sums = _normal_equations(points, ideal, position.tolist(), rotation.tolist())
        if sums is None:
            return None
        normal, slope, error2 = sums
        _, step, failed = dposv(normal, slope)  # LAPACK's own: 2 us, numpy.linalg.solve 7
        if failed:
            return None
        w0, w1, w2, s0, s1, s2 = step.tolist()
        size2 = w0 * w0 + w1 * w1 + w2 * w2 + s0 * s0 + s1 * s1 + s2 * s2
        if not size2 < 100.0:
            return None
        position = position + step[3:] @ rotation
        rotation = _turn(-w0, -w1, -w2) @ rotation
        gain = w0 * slope[0] + w1 * slope[1] + w2 * slope[2] + s0 * slope[3] + s1 * slope[4] + s2 * slope[5]
        if size2 < _CONVERGED or gain < _GAIN * error2:
            break
    return CameraSolution(position, rotation, math.sqrt(error2 / len(points)), normal)


def _normal_equations(
    points: Sequence[Sequence[float]],
    ideal: Sequence[Sequence[float]],
    position: Sequence[float],
    rotation: Sequence[Sequence[float]],
) -> tuple[FloatArray, list[float], float] | None:
    """Their matrix, right side, and the sum of squares; None if a corner is behind the camera.

    A corner's two rows are (xy, -1 - xx, y, -n, 0, xn) and (1 + yy, -xy, -x, 0, -n, yn), with n = 1 / p_z.
    """
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation
    cx, cy, cz = position
    n00 = n01 = n02 = n03 = n04 = n05 = n11 = n12 = n13 = n14 = n15 = 0.0
    n22 = n23 = n24 = n33 = n35 = n45 = n55 = 0.0
    g0 = g1 = g2 = g3 = g4 = g5 = error2 = 0.0
    for (px, py, pz), (seen_x, seen_y) in zip(points, ideal, strict=True):
        px, py, pz = px - cx, py - cy, pz - cz
        depth = r20 * px + r21 * py + r22 * pz
        if depth <= 1e-3:
            return None
        n = 1.0 / depth
        x, y = n * (r00 * px + r01 * py + r02 * pz), n * (r10 * px + r11 * py + r12 * pz)
        a, b = seen_x - x, seen_y - y
        xy, xx, yy, xn, yn = x * y, 1.0 + x * x, 1.0 + y * y, x * n, y * n
        n00 += xy * xy + yy * yy
        n01 -= xy * (xx + yy)
        n02 += xy * y - yy * x
        n03 -= xy * n
        n04 -= yy * n
        n05 += xy * xn + yy * yn
        n11 += xx * xx + xy * xy
        n12 += xy * x - xx * y
        n13 += xx * n
        n14 += xy * n
        n15 -= xx * xn + xy * yn
        n22 += x * x + y * y
        n23 -= yn
        n24 += xn
        n33 += n * n
        n35 -= n * xn
        n45 -= n * yn
        n55 += xn * xn + yn * yn
        g0 += xy * a + yy * b
        g1 -= xx * a + xy * b
        g2 += y * a - x * b
        g3 -= n * a
        g4 -= n * b
        g5 += xn * a + yn * b
        error2 += a * a + b * b
    normal = np.array(
        (
            (n00, n01, n02, n03, n04, n05),
            (n01, n11, n12, n13, n14, n15),
            (n02, n12, n22, n23, n24, 0.0),
            (n03, n13, n23, n33, 0.0, n35),
            (n04, n14, n24, 0.0, n33, n45),
            (n05, n15, 0.0, n35, n45, n55),
        )
    )
    return normal, [g0, g1, g2, g3, g4, g5], error2


def solve_position(
    points: Sequence[Sequence[float]],
    ideal: Sequence[Sequence[float]],
    depths: Sequence[float],
    rotation: Sequence[Sequence[float]],
) -> tuple[Vector, Vector] | None:
    """Where the camera is when its attitude is known: linear least squares.

    Each corner says R_x (X - c) = x R_z (X - c), and the same of y; over its depth that is a distance in the picture.
    Plain floats: 12 us for two tags, with arrays 45.

    Args:
        points: Corners, field frame [m], n >= 2 of three numbers.
        ideal: Where they are seen [-], n of two.
        depths: About how far ahead each is [m]; only a weight.
        rotation: Field to optical axes, 3 rows.

    Returns:
        Its place in the field [m], and the standard deviations of that for a noise of 1 in `ideal`; None if the corners
        do not tell.
    """
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation
    xx = xy = xz = yy = yz = zz = bx = by = bz = 0.0
    for (px, py, pz), (u, v), depth in zip(points, ideal, depths, strict=True):
        w = 1.0 / depth
        a0, a1, a2 = (r00 - u * r20) * w, (r01 - u * r21) * w, (r02 - u * r22) * w
        b0, b1, b2 = (r10 - v * r20) * w, (r11 - v * r21) * w, (r12 - v * r22) * w
        a, b = a0 * px + a1 * py + a2 * pz, b0 * px + b1 * py + b2 * pz
        xx += a0 * a0 + b0 * b0
        xy += a0 * a1 + b0 * b1
        xz += a0 * a2 + b0 * b2
        yy += a1 * a1 + b1 * b1
        yz += a1 * a2 + b1 * b2
        zz += a2 * a2 + b2 * b2
        bx += a0 * a + b0 * b
        by += a1 * a + b1 * b
        bz += a2 * a + b2 * b
    i00, i01, i02 = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    i11, i12, i22 = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    det = xx * i00 + xy * i01 + xz * i02
    if not det > 1e-18 * (xx + yy + zz) ** 3:
        return None
    x, y, z = (
        (i00 * bx + i01 * by + i02 * bz) / det,
        (i01 * bx + i11 * by + i12 * bz) / det,
        (i02 * bx + i12 * by + i22 * bz) / det,
    )
    px, py, pz = points[0]
    if r20 * (px - x) + r21 * (py - y) + r22 * (pz - z) < 1e-3:
        return None  # the tag would be behind the camera
    return (x, y, z), (math.sqrt(i00 / det), math.sqrt(i11 / det), math.sqrt(i22 / det))


def _turn(x: float, y: float, z: float) -> FloatArray:
    """Rotation by a rotation vector [rad] (Rodrigues)."""
    angle2 = x * x + y * y + z * z
    angle = math.sqrt(angle2)
    a = math.sin(angle) / angle if angle > 1e-9 else 1.0
    b = (1.0 - math.cos(angle)) / angle2 if angle2 > 1e-12 else 0.5
    bx, by, bz, ax, ay, az = b * x, b * y, b * z, a * x, a * y, a * z
    return np.array(
        (
            (1.0 - by * y - bz * z, bx * y - az, bx * z + ay),
            (bx * y + az, 1.0 - bx * x - bz * z, by * z - ax),
            (bx * z - ay, by * z + ax, 1.0 - bx * x - by * y),
        )
    )
