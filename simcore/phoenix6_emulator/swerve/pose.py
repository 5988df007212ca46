"""Poses on the plane as plain tuples (x [m], y [m], heading [rad]): WPILib's Pose2d without its objects."""

from __future__ import annotations

import math
from typing import TypeAlias

__all__ = ["Pose", "between", "exp", "interpolate", "then", "wrap"]

Pose: TypeAlias = tuple[float, float, float]


def wrap(angle: float) -> float:
    """The same direction within -pi..pi [rad]."""
    return math.remainder(angle, math.tau)


def exp(start: Pose, dx: float, dy: float, turn: float) -> Pose:
    """Where a constant twist (robot frame) leads from `start`, along an arc.

    Source: WPILib's Pose2d.Exp; R. Murray et al., A Mathematical Introduction to Robotic Manipulation, 2.3.
    """
    if abs(turn) < 1e-9:
        s, c = 1.0 - turn * turn / 6.0, 0.5 * turn
    else:
        s, c = math.sin(turn) / turn, (1.0 - math.cos(turn)) / turn
    along, across = dx * s - dy * c, dx * c + dy * s
    cos, sin = math.cos(start[2]), math.sin(start[2])
    return start[0] + cos * along - sin * across, start[1] + sin * along + cos * across, start[2] + turn


def between(start: Pose, end: Pose) -> Pose:
    """The way from `start` to `end`, in the frame of `start`."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    cos, sin = math.cos(start[2]), math.sin(start[2])
    return cos * dx + sin * dy, cos * dy - sin * dx, wrap(end[2] - start[2])


def then(start: Pose, way: Pose) -> Pose:
    """Where `way`, given in the frame of `start`, leads."""
    cos, sin = math.cos(start[2]), math.sin(start[2])
    return start[0] + cos * way[0] - sin * way[1], start[1] + sin * way[0] + cos * way[1], start[2] + way[2]


def interpolate(start: Pose, end: Pose, part: float) -> Pose:
    """A pose on the arc from `start` (0) to `end` (1), as WPILib's Pose2d.Interpolate."""
    x, y, turn = between(start, end)
    half = 0.5 * turn
    # the inverse of `exp`: half the turn over the tangent of it
    stretch = half * math.cos(half) / math.sin(half) if abs(half) > 1e-9 else 1.0 - half * half / 3.0
    dx, dy = x * stretch + y * half, y * stretch - x * half
    return exp(start, dx * part, dy * part, turn * part)
