"""The pose of one square tag from its four corners, in closed form: two answers, and how well each fits.

A small or frontal square looks nearly the same from two sides. The two answers here are those of the infinitesimal
plane method: the local affine map at the square's middle has exactly two rotations that explain it.

Source: T. Collins, A. Bartoli, "Infinitesimal Plane-Based Pose Estimation", IJCV 109 (2014); the homography of a
square: P. Heckbert, "Fundamentals of Texture Mapping and Image Warping" (1989).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["SquarePose", "ambiguity", "solve_square"]


Rotation = tuple[float, float, float, float, float, float, float, float, float]


@dataclass(slots=True, eq=False)
class SquarePose:
    """One answer. Treat it as read-only."""

    rotation: Rotation
    """From the square's axes (x right as one faces it, y up, z out of its face) to optical axes: 9 numbers, row by
    row."""
    translation: tuple[float, float, float]
    """Of its middle, optical frame [m]."""
    error: float
    """Root mean square distance between its projected corners and those seen, in units of the corners given."""


def solve_square(corners: Sequence[Sequence[float]], size: float) -> tuple[SquarePose, SquarePose] | None:
    """Both poses that explain four corners, the better one first.

    Plain floats without loops: 9 us a tag, with loops 17, with small arrays 120.

    Args:
        corners: (x/z, y/z) in the optical frame of lower left, lower right, upper right, upper left [-].
        size: Edge of the square [m].

    Returns:
        None if the corners are no image of a square, e.g. three on a line.
    """
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = corners
    # Homography of the unit square (0,0) (1,0) (1,1) (0,1), then moved to the square from -h to h.
    dx1, dx2, dx3 = x1 - x2, x3 - x2, x0 - x1 + x2 - x3
    dy1, dy2, dy3 = y1 - y2, y3 - y2, y0 - y1 + y2 - y3
    det = dx1 * dy2 - dx2 * dy1
    if abs(det) < 1e-14:
        return None
    g, h = (dx3 * dy2 - dx2 * dy3) / det, (dx1 * dy3 - dx3 * dy1) / det
    a, b, d, e = x1 - x0 + g * x1, x3 - x0 + h * x3, y1 - y0 + g * y1, y3 - y0 + h * y3
    # The middle of the square is at (1/2, 1/2); w is the homography's last row there.
    w = 1.0 + 0.5 * (g + h)
    if w < 1e-9:
        return None
    p, q = (x0 + 0.5 * (a + b)) / w, (y0 + 0.5 * (d + e)) / w
    scale = 1.0 / (w * size)
    j00, j01 = (a - g * p) * scale, (b - h * p) * scale
    j10, j11 = (d - g * q) * scale, (e - h * q) * scale
    rotations = _rotations(p, q, j00, j01, j10, j11)
    if rotations is None:
        return None
    sums, half = _sums(corners), 0.5 * size
    first, other = _fit(rotations[0], corners, sums, half), _fit(rotations[1], corners, sums, half)
    if first.translation[2] <= 0.0 or other.translation[2] <= 0.0:
        return None
    return (first, other) if first.error <= other.error else (other, first)


def ambiguity(poses: tuple[SquarePose, SquarePose]) -> float:
    """How little the better answer is better, 0 to 1: the ratio of their errors."""
    best, other = poses
    return best.error / other.error if other.error > 1e-12 else 1.0


def _rotations(p: float, q: float, j00: float, j01: float, j10: float, j11: float) -> tuple[Rotation, Rotation] | None:
    """The two rotations (9 numbers each, row by row) of a plane whose middle is seen at (p, q) with this Jacobian."""
    # Rv turns the optical axis onto the line of sight (p, q, 1).
    t2 = p * p + q * q
    c = 1.0 / math.sqrt(1.0 + t2)
    s = math.sqrt(t2) * c
    kx, ky = (p / math.sqrt(t2), q / math.sqrt(t2)) if t2 > 1e-20 else (1.0, 0.0)
    v00, v01, v02 = 1.0 + (c - 1.0) * kx * kx, (c - 1.0) * kx * ky, s * kx
    v10, v11, v12 = v01, 1.0 + (c - 1.0) * ky * ky, s * ky
    v20, v21, v22 = -s * kx, -s * ky, c
    b00, b01, b10, b11 = v00 - p * v20, v01 - p * v21, v10 - q * v20, v11 - q * v21
    det = b00 * b11 - b01 * b10
    if abs(det) < 1e-14:
        return None
    a00, a01 = (b11 * j00 - b01 * j10) / det, (b11 * j01 - b01 * j11) / det
    a10, a11 = (b00 * j10 - b10 * j00) / det, (b00 * j11 - b10 * j01) / det
    # The larger singular value of A is the inverse of the depth.
    u00, u01, u11 = a00 * a00 + a01 * a01, a00 * a10 + a01 * a11, a10 * a10 + a11 * a11
    gamma2 = 0.5 * (u00 + u11 + math.sqrt((u00 - u11) ** 2 + 4.0 * u01 * u01))
    if gamma2 < 1e-20:
        return None
    gamma = math.sqrt(gamma2)
    r00, r01, r10, r11 = a00 / gamma, a01 / gamma, a10 / gamma, a11 / gamma
    # What is missing to unit columns is their third component, but for one common sign: hence two answers.
    z0 = math.sqrt(max(0.0, 1.0 - r00 * r00 - r10 * r10))
    z1 = math.sqrt(max(0.0, 1.0 - r01 * r01 - r11 * r11))
    if r00 * r01 + r10 * r11 > 0.0:
        z1 = -z1

    # Rv times the columns a, b and a x b. The other answer has the third component reversed before Rv: what that
    # component adds is taken off instead, and of a x b the first two components change sign.
    c0, c1, c2 = r10 * z1 - z0 * r11, z0 * r01 - r00 * z1, r00 * r11 - r10 * r01
    a0, a1, a2 = v00 * r00 + v01 * r10, v10 * r00 + v11 * r10, v20 * r00 + v21 * r10
    b0, b1, b2 = v00 * r01 + v01 * r11, v10 * r01 + v11 * r11, v20 * r01 + v21 * r11
    d0, d1, d2 = v00 * c0 + v01 * c1, v10 * c0 + v11 * c1, v20 * c0 + v21 * c1
    e0, e1, e2, f0, f1, f2 = v02 * z0, v12 * z0, v22 * z0, v02 * z1, v12 * z1, v22 * z1
    g0, g1, g2 = v02 * c2, v12 * c2, v22 * c2
    return (
        (a0 + e0, b0 + f0, g0 + d0, a1 + e1, b1 + f1, g1 + d1, a2 + e2, b2 + f2, g2 + d2),
        (a0 - e0, b0 - f0, g0 - d0, a1 - e1, b1 - f1, g1 - d1, a2 - e2, b2 - f2, g2 - d2),
    )


_Sums = tuple[float, float, float, float, float, float, float, float, float]


def _sums(corners: Sequence[Sequence[float]]) -> _Sums:
    """What a fit needs whatever the rotation: u, v and q = u^2 + v^2, summed up, of corner 2 less 0, of 1 less 3."""
    (u0, v0), (u1, v1), (u2, v2), (u3, v3) = corners
    q0, q1, q2, q3 = u0 * u0 + v0 * v0, u1 * u1 + v1 * v1, u2 * u2 + v2 * v2, u3 * u3 + v3 * v3
    return (
        u0 + u1 + u2 + u3, v0 + v1 + v2 + v3, q0 + q1 + q2 + q3,
        u2 - u0, u1 - u3, v2 - v0, v1 - v3, q2 - q0, q1 - q3,
    )  # fmt: skip


def _fit(r: Rotation, corners: Sequence[Sequence[float]], sums: _Sums, half: float) -> SquarePose:
    """The translation that fits best with a rotation (linear least squares), and the error that is left.

    Each corner says tx - u tz = u Z - X and ty - v tz = v Z - Y. Turned, opposite corners are -s and s, d and -d: sums
    over four corners become differences of two, and the normal equations have 4 on the diagonal.
    """
    (u0, v0), (u1, v1), (u2, v2), (u3, v3) = corners
    r0, r1, _, r3, r4, _, r6, r7, _ = r
    sx, sy, sz = half * (r0 + r1), half * (r3 + r4), half * (r6 + r7)
    dx, dy, dz = half * (r0 - r1), half * (r3 - r4), half * (r6 - r7)
    su, sv, sq, us, ud, vs, vd, qs, qd = sums
    bx, by = us * sz + ud * dz, vs * sz + vd * dz
    bz = us * sx + ud * dx + vs * sy + vd * dy - qs * sz - qd * dz
    denominator = sq - 0.25 * (su * su + sv * sv)
    tz = (bz + 0.25 * (su * bx + sv * by)) / denominator if abs(denominator) > 1e-18 else -1.0
    tx, ty = 0.25 * (bx + su * tz), 0.25 * (by + sv * tz)
    n0, n1, n2, n3 = tz - sz, tz + dz, tz + sz, tz - dz
    if min(n0, n1, n2, n3) <= 1e-9:
        return SquarePose(r, (tx, ty, -1.0), math.inf)
    x0, x1, x2, x3 = (tx - sx) / n0 - u0, (tx + dx) / n1 - u1, (tx + sx) / n2 - u2, (tx - dx) / n3 - u3
    y0, y1, y2, y3 = (ty - sy) / n0 - v0, (ty + dy) / n1 - v1, (ty + sy) / n2 - v2, (ty - dy) / n3 - v3
    error = x0 * x0 + x1 * x1 + x2 * x2 + x3 * x3 + y0 * y0 + y1 * y1 + y2 * y2 + y3 * y3
    return SquarePose(r, (tx, ty, tz), math.sqrt(0.25 * error))
