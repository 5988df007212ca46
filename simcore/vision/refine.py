"""The camera's pose from the corners of any number of tags: least squares on pixels, and how sure it is.

The camera stands at c and turns field into optical axes by R: p = R (X - c), seen at (fx p_x / p_z, fy p_y / p_z). A
small turn w about the optical axes moves p by -w x p, a small step dc by -R dc.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.typing import FloatArray

__all__ = ["CameraSolution", "refine_pose", "solve_position"]

_ITERATIONS = 12
_CONVERGED = 1e-18  # square of the last step [m^2 and rad^2]
_GAIN = 1e-6  # of the squared error; a step that wins less is far below what noise does to the answer


@dataclass(frozen=True, slots=True, eq=False)
class CameraSolution:
    """A camera pose that fits the corners best."""

    position: FloatArray
    """Field frame [m], shape (3,)."""
    rotation: FloatArray
    """From field to optical axes, shape (3, 3)."""
    error: float
    """Root mean square distance of corners [px]."""
    covariance: FloatArray
    """Of turn about the optical axes and place in the field, for corners of 1 px noise: (6, 6) [rad, m]; of the place
    alone if the attitude was given: (3, 3) [m]."""


def refine_pose(
    points: FloatArray, pixels: FloatArray, focal: tuple[float, float], position: FloatArray, rotation: FloatArray
) -> CameraSolution | None:
    """Gauss-Newton from a first guess.

    Args:
        points: Corners, field frame [m], shape (n, 3), n >= 4.
        pixels: Where they are seen, from the principal point [px], shape (n, 2).
        focal: Focal lengths [px].
        position: First guess of the camera's place [m].
        rotation: First guess, field to optical axes.

    Returns:
        None if it runs away, which a guess from `solve_square` does not.
    """
    n = len(points)
    fx, fy = focal
    jacobian = np.empty((2 * n, 6))
    residual = np.empty(2 * n)
    jx, jy = jacobian[0::2], jacobian[1::2]
    for _ in range(_ITERATIONS):
        p = (points - position) @ rotation.T
        z = p[:, 2]
        if z.min() < 1e-3:
            return None
        x, y, iz = p[:, 0] / z, p[:, 1] / z, 1.0 / z
        residual[0::2] = pixels[:, 0] - fx * x
        residual[1::2] = pixels[:, 1] - fy * y
        xy = x * y
        jx[:, 0], jx[:, 1], jx[:, 2] = -fx * -xy, -fx * (1.0 + x * x), fx * y
        jy[:, 0], jy[:, 1], jy[:, 2] = fy * (1.0 + y * y), -fy * xy, -fy * x
        jx[:, 3:] = (fx * iz)[:, None] * (x[:, None] * rotation[2] - rotation[0])
        jy[:, 3:] = (fy * iz)[:, None] * (y[:, None] * rotation[2] - rotation[1])
        normal = jacobian.T @ jacobian
        slope = jacobian.T @ residual
        try:
            step = np.linalg.solve(normal, slope)
        except np.linalg.LinAlgError:
            return None
        size2 = float(step @ step)
        if not size2 < 100.0:
            return None
        rotation = _turn(step[:3]) @ rotation
        position = position + step[3:]
        if size2 < _CONVERGED or float(step @ slope) < _GAIN * float(residual @ residual):
            break
    error = math.sqrt(float(residual @ residual) / n)
    return CameraSolution(position, rotation, error, np.linalg.inv(normal))


def solve_position(
    points: FloatArray, pixels: FloatArray, focal: tuple[float, float], rotation: FloatArray
) -> CameraSolution | None:
    """Where the camera is when its attitude is known: linear least squares, each corner weighted by its depth.

    Args:
        points: Corners, field frame [m], shape (n, 3), n >= 2.
        pixels: Where they are seen, from the principal point [px], shape (n, 2).
        focal: Focal lengths [px].
        rotation: Field to optical axes.
    """
    fx, fy = focal
    # fx p_x - u p_z = 0 with p = R (X - c): rows a . (X - c) = 0 with a = fx R_x - u R_z, in pixels times depth.
    across = fx * rotation[0] - pixels[:, :1] * rotation[2]
    down = fy * rotation[1] - pixels[:, 1:] * rotation[2]
    rows = np.concatenate((across, down))
    value = np.concatenate((np.einsum("ij,ij->i", across, points), np.einsum("ij,ij->i", down, points)))
    weight = np.ones(len(points))
    position = np.zeros(3)
    normal = np.eye(3)
    left = value
    for _ in range(2):  # the depths of the first answer weight the second
        scaled = rows * np.concatenate((weight, weight))[:, None]
        left = value * np.concatenate((weight, weight))
        normal = scaled.T @ scaled
        try:
            position = np.linalg.solve(normal, scaled.T @ left)
        except np.linalg.LinAlgError:
            return None
        left = scaled @ position - left
        depth = (points - position) @ rotation[2]
        if depth.min() < 1e-3:
            return None
        weight = 1.0 / depth
    error = math.sqrt(float(left @ left) / len(points))
    return CameraSolution(position, rotation, error, np.linalg.inv(normal))


def _turn(w: FloatArray) -> FloatArray:
    """What a turn -w x p does to p, as a rotation (Rodrigues)."""
    x, y, z = -float(w[0]), -float(w[1]), -float(w[2])
    angle2 = x * x + y * y + z * z
    angle = math.sqrt(angle2)
    a = math.sin(angle) / angle if angle > 1e-9 else 1.0
    b = (1.0 - math.cos(angle)) / angle2 if angle2 > 1e-12 else 0.5
    return np.array(
        [
            [1.0 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y],
            [b * x * y + a * z, 1.0 - b * (x * x + z * z), b * y * z - a * x],
            [b * x * z - a * y, b * y * z + a * x, 1.0 - b * (x * x + y * y)],
        ]
    )
