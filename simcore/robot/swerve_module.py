"""Swerve modules, one row per module: their state, and what a chassis velocity asks of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from simcore.typing import FloatArray

__all__ = ["ModuleState", "desaturate", "module_targets"]


@dataclass(slots=True)
class ModuleState:
    """Angles and speeds of n modules: views of the loop's arrays, shape (n,) each."""

    wheel_angle: FloatArray
    """Of the wheel about its axle, any number of turns [rad]."""
    wheel_speed: FloatArray
    """[rad/s]"""
    steer_angle: FloatArray
    """Of the azimuth as its encoder shows it, counter-clockwise from forward, any number of turns [rad]."""
    steer_speed: FloatArray
    """[rad/s]"""
    cos: FloatArray
    """Of the angle at which the wheel truly stands."""
    sin: FloatArray
    """Of the same."""


def desaturate(speeds: list[float], limit: float) -> list[float]:
    """Scale all speeds by one factor so that none exceeds the limit: the direction of travel stays."""
    top = max(map(abs, speeds), default=0.0)
    if top <= limit:
        return speeds
    return [s * (limit / top) for s in speeds]


def module_targets(
    positions: Sequence[tuple[float, float]],
    vx: float,
    vy: float,
    omega: float,
    limit: float,
    present: Sequence[float],
) -> tuple[list[float], list[float]]:
    """Speed and direction of every module for a chassis velocity.

    Args:
        positions: Of the modules [m].
        vx: Forward [m/s].
        vy: To the left [m/s].
        omega: Counter-clockwise [rad/s].
        limit: Top speed of a module; faster wishes are scaled down together [m/s].
        present: Angles that stay where a module has nothing to do [rad].

    Returns:
        Speeds [m/s] and steer angles [rad].
    """
    speeds: list[float] = []
    angles: list[float] = []
    for (x, y), held in zip(positions, present, strict=True):
        wx = vx - omega * y
        wy = vy + omega * x
        speed = math.hypot(wx, wy)
        speeds.append(speed)
        angles.append(math.atan2(wy, wx) if speed > 1e-6 else held)
    return desaturate(speeds, limit), angles
