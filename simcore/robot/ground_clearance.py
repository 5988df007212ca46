"""How high the robot is above what is under its wheels."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.typing import FloatArray

__all__ = ["GroundClearance", "ground_clearance"]


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundClearance:
    """Result of `ground_clearance`."""

    height: float
    """Of the lowest wheel above the surface under it [m]; a little below 0 when a tire is pressed in."""
    is_airborne: bool
    """No wheel touches."""


def ground_clearance(
    wheel_points: FloatArray, surface_heights: FloatArray, *, tolerance: float = 0.01
) -> GroundClearance:
    """Clearance of a robot from its wheels' lowest points, so that a tilted robot on a bump is not in the air.

    Args:
        wheel_points: Where each wheel would touch, field frame [m], shape (n, 3).
        surface_heights: Height of carpet, bump or ramp under each point, from a ray or a map [m], shape (n,).
        tolerance: A wheel within this of its surface touches it [m].

    Raises:
        ConfigError: No wheel, or shapes that do not belong together.
        NonFiniteError: A NaN or an infinity.

    >>> ground_clearance(np.array([[0.3, 0.0, 0.12], [-0.3, 0.0, 0.10]]), np.array([0.0, 0.0]))
    GroundClearance(height=0.1, is_airborne=True)
    """
    points, heights = np.asarray(wheel_points, dtype=np.float64), np.asarray(surface_heights, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points) or heights.shape != (len(points),):
        raise ConfigError(
            f"wheel_points need shape (n, 3) and surface_heights (n,), got {points.shape}, {heights.shape}"
        )
    gap = (points[:, 2] - heights).tolist()
    if not all(map(math.isfinite, gap)):
        raise NonFiniteError(f"height of wheels over the ground must be finite, got {gap}")
    height = min(gap)
    return GroundClearance(height=height, is_airborne=height > tolerance)
