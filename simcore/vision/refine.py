"""The camera's pose from the corners of any number of tags: least squares on the picture, and how sure it is.

The camera stands at c and turns field into optical axes by R: p = R (X - c), seen at (x, y) = (p_x, p_y) / p_z. A small
turn w about the optical axes moves p by -w x p, a small step s along them by -s. Everything is in these ideal coordinates:
pixels from the principal point over the focal length.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dposv

from simcore.typing import FloatArray

__all__ = ["CameraSolution", "refine_pose", "solve_position"]

_ITERATIONS = 12
_CONVERGED = 1e-18  # square of the last step [m^2 and rad^2]
_GAIN = 0.01
"""Part of the squared error; a step that wins less is a tenth of what noise does to the answer, and is still taken."""


@dataclass(slots=True, eq=False)
class CameraSolution:
    """A camera pose that fits the corners best. Treat it as read-only."""

    position: FloatArray
    """Field frame [m], shape (3,)."""
    rotation: FloatArray
    """From field to optical axes, shape (3, 3)."""
    error: float
    """Root mean square distance of corners [-]."""
    factor: FloatArray
    """Upper Cholesky factor of the normal equations: for turn and step along the optical axes, shape (6, 6), or for the
    place in the field if the attitude was given, shape (3, 3)."""


def refine_pose(
    points: FloatArray, ideal: FloatArray, position: FloatArray, rotation: FloatArray
) -> CameraSolution | None:
    """Gauss-Newton from a first guess.

    Args:
        points: Corners, field frame [m], shape (n, 3), n >= 4.
        ideal: Where they are seen [-], shape (n, 2).
        position: First guess of the camera's place [m].
        rotation: First guess, field to optical axes.

    Returns:
        None if it runs away, which a guess from `solve_square` does not.
    """
    n = len(points)
    jacobian = np.zeros((n, 2, 6))
    flat = jacobian.reshape(2 * n, 6)
    jx, jy = jacobian[:, 0], jacobian[:, 1]
    # LAPACK's own Cholesky solver: 2 us, numpy.linalg.solve 7.
    for _ in range(_ITERATIONS):
        p = (points - position) @ rotation.T
        near = 1.0 / p[:, 2]
        if not 0.0 < near.min() <= near.max() < 1e3:
            return None
        seen = p[:, :2] * near[:, None]
        residual = (ideal - seen).ravel()
        x, y = seen[:, 0], seen[:, 1]
        across = x * y
        jx[:, 0] = across
        jx[:, 1] = -1.0 - x * x
        jx[:, 2] = y
        jx[:, 3] = -near
        jx[:, 5] = x * near
        jy[:, 0] = 1.0 + y * y
        jy[:, 1] = -across
        jy[:, 2] = -x
        jy[:, 4] = -near
        jy[:, 5] = y * near
        slope = residual @ flat
        factor, step, failed = dposv(flat.T @ flat, slope)
        if failed:
            return None
        w0, w1, w2, s0, s1, s2 = step.tolist()
        size2 = w0 * w0 + w1 * w1 + w2 * w2 + s0 * s0 + s1 * s1 + s2 * s2
        if not size2 < 100.0:
            return None
        error2 = float(residual @ residual)
        position = position + step[3:] @ rotation
        rotation = _turn(-w0, -w1, -w2) @ rotation
        if size2 < _CONVERGED or float(step @ slope) < _GAIN * error2:
            break
    return CameraSolution(position, rotation, math.sqrt(error2 / n), factor)


def solve_position(
    points: FloatArray, ideal: FloatArray, depths: FloatArray, rotation: FloatArray
) -> CameraSolution | None:
    """Where the camera is when its attitude is known: linear least squares.

    Each corner says R_x (X - c) = x R_z (X - c), and the same of y; over its depth that is a distance in the picture.

    Args:
        points: Corners, field frame [m], shape (n, 3), n >= 2.
        ideal: Where they are seen [-], shape (n, 2).
        depths: About how far ahead each is [m], shape (n,); only a weight.
        rotation: Field to optical axes.
    """
    rows = (rotation[:2] - ideal[:, :, None] * rotation[2]) / depths[:, None, None]
    value = np.einsum("nij,nj->ni", rows, points).ravel()
    flat = rows.reshape(-1, 3)
    factor, position, failed = dposv(flat.T @ flat, value @ flat)
    if failed or ((points - position) @ rotation[2]).min() < 1e-3:
        return None
    off = flat @ position - value
    return CameraSolution(position, rotation, math.sqrt(float(off @ off) / len(points)), factor)


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
