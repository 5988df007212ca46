"""Planar poses and swerve kinematics in plain floats: WPILib's Pose2d and SwerveDriveKinematics without objects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

from simcore.units import plain_sum

__all__ = ["Kinematics", "Pose", "between", "desaturate", "discretize", "exp", "interpolate", "then", "wrap"]

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


class Kinematics:
    """The geometry of a swerve drive.

    Args:
        positions: Of the modules, from the robot's center [m].
    """

    def __init__(self, positions: Sequence[tuple[float, float]]) -> None:
        self.positions = [(float(x), float(y)) for x, y in positions]
        n = len(self.positions)
        self._n = n
        self._cx = plain_sum([x for x, _ in self.positions]) / n
        self._cy = plain_sum([y for _, y in self.positions]) / n
        self._arms = [(x - self._cx, y - self._cy) for x, y in self.positions]
        self._spread = plain_sum([x * x + y * y for x, y in self._arms])
        self._headings = [0.0] * n

    def states(
        self, vx: float, vy: float, omega: float, center_x: float = 0.0, center_y: float = 0.0
    ) -> list[tuple[float, float]]:
        """Speed [m/s] and direction [rad] of every module for a chassis velocity, robot frame.

        A robot that shall stand keeps the directions of the last call, as in WPILib.

        Args:
            vx: [m/s]
            vy: [m/s]
            omega: [rad/s]
            center_x: What it turns about, from the robot's center [m].
            center_y: The same to the left [m].
        """
        if vx == 0.0 and vy == 0.0 and omega == 0.0:
            return [(0.0, heading) for heading in self._headings]
        result = []
        for k, (x, y) in enumerate(self.positions):
            mx = vx - omega * (y - center_y)
            my = vy + omega * (x - center_x)
            speed = math.hypot(mx, my)
            angle = math.atan2(my, mx) if speed > 1e-6 else 0.0
            self._headings[k] = angle
            result.append((speed, angle))
        return result

    def chassis(self, moves: Sequence[tuple[float, float]]) -> tuple[float, float, float]:
        """The rigid motion that fits what the modules did best (least squares).

        Args:
            moves: Velocity or travel of each module, robot frame, x and y.

        Returns:
            Of the robot's center: x, y and turn.
        """
        sx = sy = turn = 0.0
        for (mx, my), (ax, ay) in zip(moves, self._arms, strict=True):
            sx += mx
            sy += my
            turn += ax * my - ay * mx
        turn = turn / self._spread if self._spread > 0.0 else 0.0
        return sx / self._n + turn * self._cy, sy / self._n - turn * self._cx, turn


def desaturate(states: list[tuple[float, float]], limit: float) -> list[tuple[float, float]]:
    """All speeds scaled by one factor, so that the fastest module keeps to `limit` [m/s]."""
    fastest = max(abs(speed) for speed, _ in states)
    if fastest <= limit:
        return states
    return [(speed / fastest * limit, angle) for speed, angle in states]


def discretize(vx: float, vy: float, omega: float, period: float) -> tuple[float, float, float]:
    """The constant robot-frame velocity that ends, after a period of turning, where a field-frame one would.

    Source: WPILib's ChassisSpeeds.Discretize.
    """
    half = 0.5 * omega * period
    stretch = half * math.cos(half) / math.sin(half) if abs(half) > 1e-9 else 1.0
    return vx * stretch + vy * half, vy * stretch - vx * half, omega
