"""What a motor controller does on its own between two commands: speed and steer loops, and swerve kinematics."""

from __future__ import annotations

import math
from collections.abc import Sequence

__all__ = ["desaturate", "module_targets", "optimize", "wrap"]


def wrap(angle: float) -> float:
    """The same direction within -pi..pi [rad].

    >>> round(wrap(3 * math.pi / 2) / math.pi, 9)
    -0.5
    """
    return math.remainder(angle, math.tau)


def optimize(speed: float, angle: float, present: float) -> tuple[float, float]:
    """Reach a module state with less than a quarter turn: drive backwards where that is nearer.

    Args:
        speed: Wanted [m/s].
        angle: Wanted steer angle [rad].
        present: Steer angle now, any number of turns [rad].

    Returns:
        Signed speed [m/s], scaled by the cosine of the steer error so that a wheel on its way does not scrub
        sideways, and the error to steer away [rad], within -pi/2..pi/2.
    """
    error = math.remainder(angle - present, math.tau)
    if error > 0.5 * math.pi:
        error -= math.pi
        speed = -speed
    elif error < -0.5 * math.pi:
        error += math.pi
        speed = -speed
    return speed * math.cos(error), error


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
