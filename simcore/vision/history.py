"""Where the robot was when a frame was exposed: its poses of the last two seconds, interpolated."""

from __future__ import annotations

import math
from bisect import bisect_right

from simcore.errors import ConfigError, require_positive
from simcore.geometry.quaternion import Quaternion, Vector

__all__ = ["PoseHistory", "ScalarHistory", "slerp"]

_TELEPORT = 30.0  # [m/s]; faster than any robot: it was carried, and was nowhere in between


class PoseHistory:
    """Poses by time; between two of them the place moves straight and the attitude turns evenly.

    >>> history = PoseHistory()
    >>> history.add(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    >>> history.add(0.02, (0.04, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    >>> history.at(0.01)[0]
    (0.02, 0.0, 0.0)
    """

    __slots__ = ("_poses", "_span", "_times")

    def __init__(self, span: float = 2.0) -> None:
        """Keep poses for `span` [s]."""
        require_positive("PoseHistory", "span", span, "s")
        self._span = span
        self._times: list[float] = []
        self._poses: list[tuple[Vector, Quaternion]] = []

    def __len__(self) -> int:
        return len(self._times)

    def add(self, time: float, pos: Vector, quat: Quaternion) -> None:
        """Note where the robot is now; a jump in space or backwards in time starts over."""
        times = self._times
        if times:
            step = time - times[-1]
            if step <= 0.0 or math.dist(pos, self._poses[-1][0]) > _TELEPORT * step:
                times.clear()
                self._poses.clear()
        times.append(time)
        self._poses.append((pos, quat))
        if len(times) > 64 and times[32] < time - self._span:  # dropped in lots: cheaper than one each tick
            del times[:32], self._poses[:32]

    def at(self, time: float) -> tuple[Vector, Quaternion]:
        """Pose at a time [s]; before the first and after the last one: that one.

        Raises:
            ConfigError: Nothing was added yet.
        """
        times = self._times
        if not times:
            raise ConfigError("PoseHistory: no pose was added yet")
        k = bisect_right(times, time)
        if k == 0:
            return self._poses[0]
        if k == len(times):
            return self._poses[-1]
        (p0, q0), (p1, q1) = self._poses[k - 1], self._poses[k]
        s = (time - times[k - 1]) / (times[k] - times[k - 1])
        place = (p0[0] + s * (p1[0] - p0[0]), p0[1] + s * (p1[1] - p0[1]), p0[2] + s * (p1[2] - p0[2]))
        return place, slerp(q0, q1, s)


class ScalarHistory:
    """A reading by time, e.g. a heading; linear in between, so it must not wrap."""

    __slots__ = ("_span", "_times", "_values")

    def __init__(self, span: float = 2.0) -> None:
        """Keep readings for `span` [s]."""
        require_positive("ScalarHistory", "span", span, "s")
        self._span = span
        self._times: list[float] = []
        self._values: list[float] = []

    def __len__(self) -> int:
        return len(self._times)

    def add(self, time: float, value: float) -> None:
        """Note a reading; one from before the last is dropped, one of the same time replaces it."""
        times = self._times
        if times and time <= times[-1]:
            if time == times[-1]:
                self._values[-1] = value
            return
        times.append(time)
        self._values.append(value)
        if len(times) > 64 and times[32] < time - self._span:
            del times[:32], self._values[:32]

    def at(self, time: float) -> float | None:
        """Reading at a time [s], held before the first and after the last; None if there is none."""
        times = self._times
        if not times:
            return None
        k = bisect_right(times, time)
        if k == 0:
            return self._values[0]
        if k == len(times):
            return self._values[-1]
        s = (time - times[k - 1]) / (times[k] - times[k - 1])
        return self._values[k - 1] + s * (self._values[k] - self._values[k - 1])


def slerp(a: Quaternion, b: Quaternion, s: float) -> Quaternion:
    """The attitude a part `s` of the way from a to b, on the shorter way."""
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
    if dot < 0.0:
        b, dot = (-b[0], -b[1], -b[2], -b[3]), -dot
    if dot > 0.99995:  # under a degree: the chord is as good as the arc
        u, v = 1.0 - s, s
    else:
        angle = math.acos(dot)
        u, v = math.sin((1.0 - s) * angle), math.sin(s * angle)
    x, y, z, w = u * a[0] + v * b[0], u * a[1] + v * b[1], u * a[2] + v * b[2], u * a[3] + v * b[3]
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    return x / norm, y / norm, z / norm, w / norm
