"""Robot pose at the time of an exposure, and the heading for MegaTag 2, from robot code or from an IMU."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

import numpy as np

from simcore.errors import ConfigError
from simcore.quantities import DURATION, require
from simcore.typing import FloatArray
from simcore.vision.camera_frame import ImuReading
from simcore.world.rotation import Quaternion, Vector, from_rpy, interpolate, matrix, rotate_back, rpy

__all__ = ["AngleHistory", "HeadingSource", "PoseHistory"]

_Value = TypeVar("_Value")

_TELEPORT = 30.0  # [m/s]; a robot that seems faster than this was placed elsewhere


_EXTERNAL, _SEED, _INTERNAL, _MT1_ASSIST, _EXTERNAL_ASSIST = range(5)
_IMU_RATE = 1000.0  # [1/s]; the assist filter runs at the IMU's rate


class _History(Generic[_Value]):
    """Time-ordered samples with interpolation."""

    __slots__ = ("_between", "_span", "_times", "_values")

    def __init__(self, between: Callable[[_Value, _Value, float], _Value], span: float) -> None:
        require(type(self).__name__, "span", span, DURATION)
        self._between = between
        self._span = span
        self._times: list[float] = []
        self._values: list[_Value] = []

    def __len__(self) -> int:
        return len(self._times)

    def clear(self) -> None:
        """Remove all samples."""
        self._times.clear()
        self._values.clear()

    def _append(self, time: float, value: _Value) -> None:
        times = self._times
        times.append(time)
        self._values.append(value)
        if len(times) > 64 and times[32] < time - self._span:  # in batches, which is faster than one sample per tick
            del times[:32], self._values[:32]

    def _look_up(self, time: float) -> _Value | None:
        """Interpolate the value at a time [s]; outside the samples, use the nearest value; None without samples."""
        times, values = self._times, self._values
        k = bisect_right(times, time)
        if not times or k == len(times):
            return values[-1] if times else None
        if k == 0:
            return values[0]
        return self._between(values[k - 1], values[k], (time - times[k - 1]) / (times[k] - times[k - 1]))


class PoseHistory(_History[tuple[Vector, Quaternion]]):
    """Poses over time, with linearly interpolated position and attitude.

    >>> history = PoseHistory()
    >>> history.add(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    >>> history.add(0.02, (0.04, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    >>> history.at(0.01)[0]
    (0.02, 0.0, 0.0)
    """

    __slots__ = ()

    def __init__(self, span: float = 2.0) -> None:
        """Keep poses for `span` [s]."""
        super().__init__(lambda a, b, s: (_lerp(a[0], b[0], s), interpolate(a[1], b[1], s)), span)

    def add(self, time: float, pos: Vector, quat: Quaternion) -> None:
        """Add a pose at a time [s]; a jump back in time or in position (over 30 m/s) first clears the history."""
        if self._times:
            step = time - self._times[-1]
            if step <= 0.0 or math.dist(pos, self._values[-1][0]) > _TELEPORT * step:
                self.clear()
        self._append(time, (pos, quat))

    def at(self, time: float) -> tuple[Vector, Quaternion]:
        """Interpolate the pose at a time [s]; outside the history, use the nearest pose.

        Raises:
            ConfigError: If no pose was added yet.
        """
        found = self._look_up(time)
        if found is None:
            raise ConfigError("PoseHistory: no pose was added yet")
        return found


class AngleHistory(_History[Vector]):
    """Yaw, pitch and roll over time [rad], linearly interpolated; the angles must be continuous."""

    __slots__ = ()

    def __init__(self, span: float = 2.0) -> None:
        """Keep readings for `span` [s]."""
        super().__init__(_lerp, span)

    def add(self, time: float, angles: Vector) -> None:
        """Add a reading at a time [s]; a reading of equal time replaces the last one, an older reading is ignored."""
        if self._times and time == self._times[-1]:
            self._values[-1] = angles
        elif not self._times or time > self._times[-1]:
            self._append(time, angles)

    def at(self, time: float) -> Vector | None:
        """Interpolate the reading at a time [s]; outside the history, use the nearest; None without readings."""
        return self._look_up(time)


def _lerp(a: Vector, b: Vector, s: float) -> Vector:
    return a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])


class HeadingSource:
    """Source of yaw, pitch and roll at any time in the last two seconds.

    IMU modes: 0 heading from robot code; 1 heading from robot code, which also seeds the IMU; 2 IMU alone; 3 IMU
    corrected by MegaTag 1; 4 IMU corrected by the heading from robot code. Without an IMU the mode is always 0.

    The yaw of the IMU is zero at power-on for any heading of the robot, and follows the robot with a slow drift.

    Args:
        has_imu: Whether the camera has an IMU.
        drift_deg: Standard deviation of the IMU's yaw drift in 30 s [deg].
        rng: Random generator for the drift.
    """

    def __init__(self, *, has_imu: bool, drift_deg: float, rng: np.random.Generator) -> None:
        self._has_imu = has_imu
        self._walk = math.radians(drift_deg) / math.sqrt(30.0)
        self._rng = rng
        self.mode = _EXTERNAL
        """IMU mode, 0 to 4; ignored without an IMU."""
        self.assist = 0.001
        """Weight of the correction in modes 3 and 4, per IMU sample of 1 ms [-]."""
        self._sent = AngleHistory()
        self._internal = AngleHistory()
        self._yaw = 0.0
        self._true: tuple[float, float, float] | None = None  # roll, pitch, yaw
        self._time = 0.0
        self._rates = (0.0, 0.0, 0.0)
        self._gravity = (0.0, 0.0, 1.0)

    def tell(self, time: float, orientation: Sequence[float]) -> None:
        """Record the orientation from robot code: yaw, yaw rate, pitch, pitch rate, roll, roll rate [deg, deg/s]."""
        yaw = math.radians(orientation[0])
        last = self._sent.at(math.inf)
        if last is not None:
            yaw = last[0] + math.remainder(yaw - last[0], math.tau)
        self._sent.add(time, (yaw, math.radians(orientation[2]), math.radians(orientation[4])))

    def move(self, time: float, quat: Quaternion) -> None:
        """Update the IMU from the robot's true attitude at a time [s], with drift and the mode's correction.

        Call the method once a tick.
        """
        if not self._has_imu:
            return
        roll, pitch, yaw = rpy(quat)
        if self._true is not None and time > self._time:
            dt = time - self._time
            turned = math.remainder(yaw - self._true[2], math.tau)
            self._yaw += turned + self._walk * math.sqrt(dt) * float(self._rng.standard_normal())
            self._rates = (
                math.remainder(roll - self._true[0], math.tau) / dt,
                math.remainder(pitch - self._true[1], math.tau) / dt,
                turned / dt,
            )
            sent = self._sent.at(time)
            if sent is not None and self.mode == _SEED:
                self._yaw = sent[0]
            elif sent is not None and self.mode == _EXTERNAL_ASSIST:
                self._draw_to(sent[0], dt)
        self._true, self._time = (roll, pitch, yaw), time
        self._gravity = rotate_back(quat, (0.0, 0.0, 1.0))
        self._internal.add(time, (self._yaw, pitch, roll))

    def after_megatag1(self, yaw_deg: float, since: float) -> None:
        """Correct the IMU by a MegaTag 1 heading [deg] in mode 3; `since` is the time since the previous frame [s]."""
        if self._has_imu and self.mode == _MT1_ASSIST:
            self._draw_to(math.radians(yaw_deg), since)

    def attitude(self, time: float) -> FloatArray:
        """Return the rotation from robot to field axes at a time [s] by the current mode, shape (3, 3)."""
        yaw, pitch, roll = self._at(time)
        return matrix(from_rpy(roll, pitch, yaw))

    def reading(self) -> ImuReading | None:
        """Return the current readings of the IMU; None without an IMU."""
        if not self._has_imu or self._true is None:
            return None
        yaw, _, _ = self._at(self._time)
        rates = self._rates
        return ImuReading(
            math.degrees(math.remainder(yaw, math.tau)),
            math.degrees(self._true[0]),
            math.degrees(self._true[1]),
            math.degrees(math.remainder(self._yaw, math.tau)),
            (math.degrees(rates[0]), math.degrees(rates[1]), math.degrees(rates[2])),
            self._gravity,
        )

    def _at(self, time: float) -> Vector:
        """Return yaw, pitch and roll at a time [rad]; zeros before robot code has sent a heading."""
        is_internal = self._has_imu and self.mode >= _INTERNAL
        return (self._internal if is_internal else self._sent).at(time) or (0.0, 0.0, 0.0)

    def _draw_to(self, yaw: float, dt: float) -> None:
        """Apply the complementary filter toward a yaw [rad] over the IMU samples of dt [s]."""
        share = 1.0 - (1.0 - self.assist) ** (_IMU_RATE * dt)
        self._yaw += share * math.remainder(yaw - self._yaw, math.tau)
