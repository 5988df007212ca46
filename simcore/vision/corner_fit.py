"""The camera's pose from the corners of any number of tags: least squares on the picture, and how sure it is.

The camera stands at c and turns field into optical axes by R: p = R (X - c), seen at (x, y) = (p_x, p_y) / p_z. A small
turn w about the optical axes moves p by -w x p, a small step s along them by -s. Everything is in these ideal
coordinates: pixels from the principal point over the focal length.

A tag is a square: from its middle m, its corners are at -s, d, s, -d. So what turns 4 corners turns 3 vectors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from simcore.geometry.rotation import Rows, Vector, apply_back, times

__all__ = ["CameraSolution", "Square", "refine_pose", "solve_position", "squared_error"]

Square = tuple[Vector, Vector, Vector]
"""A tag's middle, and from there to its third (upper right) and second (lower right) corner, field axes [m]."""
Ideal = Sequence[tuple[float, float]]
"""Where the four corners of a tag are seen [-]."""

_ITERATIONS = 12
_CONVERGED = 1e-18  # square of the last step [m^2 and rad^2]
_GAIN = 0.2
"""Part of the squared error; the step that wins less is the last one. What it leaves is its own square: under a
hundredth of what noise does to the answer."""
_LINEAR = 1e-4
"""A step that moves corners by g bends their way by about g times its size (turn, and way over depth). Below this part
of the squared error that is left another step would change nothing."""


@dataclass(slots=True, eq=False)
class CameraSolution:
    """A camera pose that fits the corners best. Treat it as read-only."""

    position: Vector
    """Field frame [m]."""
    rotation: Rows
    """From field to optical axes."""
    error: float
    """Root mean square distance of corners that is left, the last step's part of it to first order [-]."""
    sums: _Sums

    def variances(self, functions: Sequence[tuple[Vector, Vector]]) -> list[float]:
        """How sure numbers are that follow from the pose.

        Args:
            functions: Of each, what it changes with a turn and with a step along the optical axes [1/rad, 1/m].

        Returns:
            Their variances for a noise of 1 in the picture; inf if the corners do not tell.
        """
        reduced = _reduce(self.sums)
        if reduced is None:
            return [math.inf] * len(functions)
        n, mx, my, rest, c0, c1, c2, (a00, a01, a02, a11, a12, a22) = reduced
        i00, i01, i02 = a11 * a22 - a12 * a12, a02 * a12 - a01 * a22, a01 * a12 - a02 * a11
        i11, i12, i22 = a00 * a22 - a02 * a02, a01 * a02 - a00 * a12, a00 * a11 - a01 * a01
        det = a00 * i00 + a01 * i01 + a02 * i02
        found = []
        for (wx, wy, wz), (sx, sy, sz) in functions:
            # A step follows a turn by -C^T; what is left of it has the covariance D^-1.
            x = wx - c0[0] * sx - c0[1] * sy - c0[2] * sz
            y = wy - c1[0] * sx - c1[1] * sy - c1[2] * sz
            z = wz - c2[0] * sx - c2[1] * sy - c2[2] * sz
            turn = i00 * x * x + i11 * y * y + i22 * z * z + 2.0 * (i01 * x * y + i02 * x * z + i12 * y * z)
            along = mx * sx + my * sy + sz
            found.append(max(0.0, turn / det) + (sx * sx + sy * sy) / n + along * along / rest)
        return found


def refine_pose(
    squares: Sequence[Square],
    ideal: Sequence[Ideal],
    position: Vector,
    rotation: Rows,
    *,
    start_error: float = math.inf,
) -> CameraSolution | None:
    """Gauss-Newton from a first guess. Plain floats: 16 us a step for two tags, with arrays 45.

    Args:
        squares: Tags, at least one.
        ideal: Where they are seen.
        position: First guess of the camera's place [m].
        rotation: First guess, field to optical axes.
        start_error: Root mean square distance of corners above which the guess is not worth a start [-].

    Returns:
        None if it runs away, which a guess from `solve_square` does not, or if the guess is too bad.
    """
    most = start_error * start_error * 4 * len(squares)
    for _ in range(_ITERATIONS):
        sums = _normal_equations(squares, ideal, position, rotation)
        if sums is None or sums[-1] > most:
            return None
        found, most, error2 = sums, math.inf, sums[-1]
        step = _solve(sums)
        if step is None:
            return None
        (w0, w1, w2), (s0, s1, s2), gain = step
        turn2, step2 = w0 * w0 + w1 * w1 + w2 * w2, s0 * s0 + s1 * s1 + s2 * s2
        if not turn2 + step2 < 100.0:
            return None
        dx, dy, dz = apply_back(rotation, (s0, s1, s2))
        position = (position[0] + dx, position[1] + dy, position[2] + dz)
        rotation = times(_turn(-w0, -w1, -w2), rotation)
        if turn2 + step2 < _CONVERGED or gain < _GAIN * error2:
            break
        if gain * (turn2 + step2 * sums[13] / (4 * len(squares))) < _LINEAR * (
            error2 - gain
        ):  # [13]: n^2, over depth^2
            break
    return CameraSolution(position, rotation, math.sqrt(max(0.0, error2 - gain) / (4 * len(squares))), found)


def squared_error(squares: Sequence[Square], ideal: Sequence[Ideal], position: Vector, rotation: Rows) -> float:
    """Sum over all corners of the squared distance between where they are seen and where this pose shows them [-]."""
    sums = _normal_equations(squares, ideal, position, rotation)
    return math.inf if sums is None else sums[-1]


_Sums = tuple[float, ...]
"""Normal equations: the upper triangle of the part for turns (a00 a01 a02 a11 a12 a22), what couples turns with steps
(b00 b01 b02 b10 b12 b20 b21; b11 = -b00, b22 = 0), the part for steps (n 0 -nx; 0 n -ny; -nx -ny nq), the right side
(6), and the sum of squares."""


def _normal_equations(
    squares: Sequence[Square], ideal: Sequence[Ideal], position: Vector, rotation: Rows
) -> _Sums | None:
    """None if a corner is behind the camera.

    A corner's two rows are (xy, -1 - xx, y, -n, 0, xn) and (1 + yy, -xy, -x, 0, -n, yn), with n = 1 / p_z. Multiplied
    out, only these sums are left.
    """
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation
    cx, cy, cz = position
    sx = sy = sq = axx = axy = ayy = bn = bx = by = bxx = bxy = byy = bqx = bqy = 0.0
    nn = nx = ny = nq = g0 = g1 = g2 = g3 = g4 = g5 = error2 = 0.0
    for ((px, py, pz), (ex, ey, ez), (fx, fy, fz)), seen in zip(squares, ideal, strict=True):
        px, py, pz = px - cx, py - cy, pz - cz
        mx, my, mz = r00 * px + r01 * py + r02 * pz, r10 * px + r11 * py + r12 * pz, r20 * px + r21 * py + r22 * pz
        ex, ey, ez = r00 * ex + r01 * ey + r02 * ez, r10 * ex + r11 * ey + r12 * ez, r20 * ex + r21 * ey + r22 * ez
        fx, fy, fz = r00 * fx + r01 * fy + r02 * fz, r10 * fx + r11 * fy + r12 * fz, r20 * fx + r21 * fy + r22 * fz
        if mz - abs(ez) <= 1e-3 or mz - abs(fz) <= 1e-3:
            return None
        (u0, v0), (u1, v1), (u2, v2), (u3, v3) = seen
        for x, y, depth, u, v in (
            (mx - ex, my - ey, mz - ez, u0, v0),
            (mx + fx, my + fy, mz + fz, u1, v1),
            (mx + ex, my + ey, mz + ez, u2, v2),
            (mx - fx, my - fy, mz - fz, u3, v3),
        ):
            n = 1.0 / depth
            x *= n
            y *= n
            a, b, xn, yn = u - x, v - y, x * n, y * n
            xx, xy, yy = x * x, x * y, y * y
            q = xx + yy
            e, h = 2.0 + q, x * a + y * b
            axx += xx * e
            axy += xy * e
            ayy += yy * e
            sx += x
            sy += y
            sq += q
            bn += n
            bx += xn
            by += yn
            bxx += xx * n
            bxy += xy * n
            byy += yy * n
            bqx += q * xn
            bqy += q * yn
            nn += n * n
            nx += xn * n
            ny += yn * n
            nq += q * n * n
            g0 += y * h + b
            g1 -= x * h + a
            g2 += y * a - x * b
            g3 -= n * a
            g4 -= n * b
            g5 += n * h
            error2 += a * a + b * b
    count = 4.0 * len(squares)
    return (
        count + ayy, -axy, -sx, count + axx, -sy, sq,
        -bxy, -(bn + byy), by + bqy, bn + bxx, -(bx + bqx), -by, bx,
        nn, nx, ny, nq, g0, g1, g2, g3, g4, g5, error2,
    )  # fmt: skip


_Reduced = tuple[float, float, float, float, Vector, Vector, Vector, tuple[float, float, float, float, float, float]]


def _reduce(sums: _Sums) -> _Reduced | None:
    """Eliminate the steps: their own part D = (n 0 -nx; 0 n -ny; -nx -ny nq) is all but diagonal.

    Returns:
        n, nx / n, ny / n, the last pivot of D, the rows of C = B D^-1, and the upper triangle of A - C B^T, which is
        what the corners tell of a turn; None if they do not.
    """
    a00, a01, a02, a11, a12, a22, b00, b01, b02, b10, b12, b20, b21, n, nx, ny, nq, *_ = sums
    mx, my = nx / n, ny / n
    rest = nq - mx * nx - my * ny
    if not rest > 0.0:
        return None
    c02 = (b02 + mx * b00 + my * b01) / rest
    c12 = (b12 + mx * b10 - my * b00) / rest
    c22 = (mx * b20 + my * b21) / rest
    c00, c01 = b00 / n + mx * c02, b01 / n + my * c02
    c10, c11 = b10 / n + mx * c12, my * c12 - b00 / n
    c20, c21 = b20 / n + mx * c22, b21 / n + my * c22
    a00 -= c00 * b00 + c01 * b01 + c02 * b02
    a01 -= c00 * b10 - c01 * b00 + c02 * b12
    a02 -= c00 * b20 + c01 * b21
    a11 -= c10 * b10 - c11 * b00 + c12 * b12
    a12 -= c10 * b20 + c11 * b21
    a22 -= c20 * b20 + c21 * b21
    return n, mx, my, rest, (c00, c01, c02), (c10, c11, c12), (c20, c21, c22), (a00, a01, a02, a11, a12, a22)


def _solve(sums: _Sums) -> tuple[Vector, Vector, float] | None:
    """Turn, step, and what of the sum of squares they win to first order; None if the corners do not tell."""
    reduced = _reduce(sums)
    if reduced is None:
        return None
    n, mx, my, rest, c0, c1, c2, (a00, a01, a02, a11, a12, a22) = reduced
    _, _, _, _, _, _, b00, b01, b02, b10, b12, b20, b21, _, _, _, _, g0, g1, g2, g3, g4, g5, _ = sums
    h0 = g0 - c0[0] * g3 - c0[1] * g4 - c0[2] * g5
    h1 = g1 - c1[0] * g3 - c1[1] * g4 - c1[2] * g5
    h2 = g2 - c2[0] * g3 - c2[1] * g4 - c2[2] * g5
    if not a00 > 0.0:
        return None
    l1, l2 = a01 / a00, a02 / a00
    a11, a12, a22 = a11 - l1 * a01, a12 - l1 * a02, a22 - l2 * a02
    if not a11 > 0.0:
        return None
    l3 = a12 / a11
    a22 -= l3 * a12
    if not a22 > 0.0:
        return None
    h1 -= l1 * h0
    h2 -= l2 * h0 + l3 * h1
    w2 = h2 / a22
    w1 = h1 / a11 - l3 * w2
    w0 = h0 / a00 - l1 * w1 - l2 * w2
    k0, k1, k2 = g3 - b00 * w0 - b10 * w1 - b20 * w2, g4 - b01 * w0 + b00 * w1 - b21 * w2, g5 - b02 * w0 - b12 * w1
    s2 = (k2 + mx * k0 + my * k1) / rest
    s0, s1 = k0 / n + mx * s2, k1 / n + my * s2
    return (w0, w1, w2), (s0, s1, s2), w0 * g0 + w1 * g1 + w2 * g2 + s0 * g3 + s1 * g4 + s2 * g5


def solve_position(
    squares: Sequence[Square], ideal: Sequence[Ideal], depths: Sequence[float], rotation: Rows
) -> tuple[Vector, Vector] | None:
    """Where the camera is when its attitude is known: linear least squares.

    With t = -R c each corner says t_x - x t_z = x p_z - p_x for p = R X, and the same of y; over its depth that is a
    distance in the picture. The normal equations are (w 0 -u; 0 w -v; -u -v q). Plain floats: 3 us a tag.

    Args:
        squares: Tags, at least one.
        ideal: Where they are seen.
        depths: About how far ahead each is [m]; only a weight.
        rotation: Field to optical axes.

    Returns:
        Its place in the field [m], and the standard deviations of that for a noise of 1 in `ideal`; None if the corners
        do not tell.
    """
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation
    (ox, oy, oz), _, _ = squares[0]  # places are counted from here, to keep the numbers small
    n = nu = nv = nq = bx = by = bz = 0.0
    for ((px, py, pz), (ex, ey, ez), (fx, fy, fz)), seen, depth in zip(squares, ideal, depths, strict=True):
        (u0, v0), (u1, v1), (u2, v2), (u3, v3) = seen
        w = 1.0 / (depth * depth)
        px, py, pz = px - ox, py - oy, pz - oz
        mx, my, mz = r00 * px + r01 * py + r02 * pz, r10 * px + r11 * py + r12 * pz, r20 * px + r21 * py + r22 * pz
        ex, ey, ez = r00 * ex + r01 * ey + r02 * ez, r10 * ex + r11 * ey + r12 * ez, r20 * ex + r21 * ey + r22 * ez
        fx, fy, fz = r00 * fx + r01 * fy + r02 * fz, r10 * fx + r11 * fy + r12 * fz, r20 * fx + r21 * fy + r22 * fz
        q0, q1, q2, q3 = u0 * u0 + v0 * v0, u1 * u1 + v1 * v1, u2 * u2 + v2 * v2, u3 * u3 + v3 * v3
        us, ud, vs, vd = u2 - u0, u1 - u3, v2 - v0, v1 - v3
        su, sv, sq = u0 + u1 + u2 + u3, v0 + v1 + v2 + v3, q0 + q1 + q2 + q3
        n += 4.0 * w
        nu += w * su
        nv += w * sv
        nq += w * sq
        bx += w * (su * mz - 4.0 * mx + us * ez + ud * fz)
        by += w * (sv * mz - 4.0 * my + vs * ez + vd * fz)
        bz += w * (
            su * mx + sv * my - sq * mz
            + us * ex + ud * fx + vs * ey + vd * fy - (q2 - q0) * ez - (q1 - q3) * fz
        )  # fmt: skip
    mu, mv = nu / n, nv / n
    rest = nq - mu * nu - mv * nv
    if not rest > 1e-12 * nq:
        return None
    tz = (bz + mu * bx + mv * by) / rest
    tx, ty = bx / n + mu * tz, by / n + mv * tz
    if tz < 1e-3:
        return None  # the tag would be behind the camera
    dx, dy, dz = apply_back(rotation, (tx, ty, tz))
    # The covariance is (1, 1, 0) / n on the diagonal plus k k^T / rest with k = (mu, mv, 1); turned into the field.
    kx, ky, kz = apply_back(rotation, (mu, mv, 1.0))
    sigmas = (
        math.sqrt((r00 * r00 + r10 * r10) / n + kx * kx / rest),
        math.sqrt((r01 * r01 + r11 * r11) / n + ky * ky / rest),
        math.sqrt((r02 * r02 + r12 * r12) / n + kz * kz / rest),
    )
    return (ox - dx, oy - dy, oz - dz), sigmas


def _turn(x: float, y: float, z: float) -> Rows:
    """Rotation by a rotation vector [rad] (Rodrigues)."""
    angle2 = x * x + y * y + z * z
    angle = math.sqrt(angle2)
    a = math.sin(angle) / angle if angle > 1e-9 else 1.0
    b = (1.0 - math.cos(angle)) / angle2 if angle2 > 1e-12 else 0.5
    bx, by, bz, ax, ay, az = b * x, b * y, b * z, a * x, a * y, a * z
    return (
        (1.0 - by * y - bz * z, bx * y - az, bx * z + ay),
        (bx * y + az, 1.0 - bx * x - bz * z, by * z - ax),
        (bx * z - ay, by * z + ax, 1.0 - bx * x - by * y),
    )
