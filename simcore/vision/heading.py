"""Histories of robot poses and angles, and the source of the heading for MegaTag 2: robot code or the camera's IMU."""

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

_TELEPORT = 30.0  # [m/s]; a larger apparent speed means that the robot was placed at a new pose


_EXTERNAL, _SEED, _INTERNAL, _MT1_ASSIST, _EXTERNAL_ASSIST = range(5)
_IMU_RATE = 1000.0  # [1/s]; the assist filter runs at the IMU's rate


class _History(Generic[_Value]):
    """Time-ordered samples with interpolation between neighbors."""

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
        """Return the interpolated value at a time [s], or None without samples.

        Before the first or after the last sample, return the nearest value.
        """
        times, values = self._times, self._values
        k = bisect_right(times, time)
        if not times or k == len(times):
            return values[-1] if times else None
        if k == 0:
            return values[0]
        return self._between(values[k - 1], values[k], (time - times[k - 1]) / (times[k] - times[k - 1]))


class PoseHistory(_History[tuple[Vector, Quaternion]]):
    """Recent poses of a robot, with linear interpolation of position and attitude.

    >>> history = PoseHistory()
    >>> history.add(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    >>> history.add(0.02, (0.04, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    >>> history.at(0.01)[0]
    (0.02, 0.0, 0.0)
    """

    __slots__ = ()

    def __init__(self, span: float = 2.0) -> None:
        """Create an empty history that keeps the poses of at least the last `span` seconds."""
        super().__init__(lambda a, b, s: (_lerp(a[0], b[0], s), interpolate(a[1], b[1], s)), span)

    def add(self, time: float, pos: Vector, quat: Quaternion) -> None:
        """Add a pose at a time [s].

        Clear the history first if the time is not later than the last time, or if the position changed at over 30 m/s.
        """
        if self._times:
            step = time - self._times[-1]
            if step <= 0.0 or math.dist(pos, self._values[-1][0]) > _TELEPORT * step:
                self.clear()
        self._append(time, (pos, quat))

    def at(self, time: float) -> tuple[Vector, Quaternion]:
        """Return the interpolated pose at a time [s], or the nearest pose outside the history.

        Raises:
            ConfigError: If no pose was added yet.
        """
        found = self._look_up(time)
        if found is None:
            raise ConfigError("PoseHistory: no pose was added yet")
        return found


class AngleHistory(_History[Vector]):
    """Recent yaw, pitch and roll [rad], with linear interpolation; the angles must not wrap around."""

    __slots__ = ()

    def __init__(self, span: float = 2.0) -> None:
        """Create an empty history that keeps the angles of at least the last `span` seconds."""
        super().__init__(_lerp, span)

    def add(self, time: float, angles: Vector) -> None:
        """Add angles [rad] at a time [s].

        Angles with the time of the last entry replace the last entry. Angles with an earlier time are ignored.
        """
        if self._times and time == self._times[-1]:
            self._values[-1] = angles
        elif not self._times or time > self._times[-1]:
            self._append(time, angles)

    def at(self, time: float) -> Vector | None:
        """Return the interpolated angles [rad] at a time [s], or the nearest angles outside the history.

        Returns:
            Yaw, pitch and roll [rad]; None if the history is empty.
        """
        return self._look_up(time)


def _lerp(a: Vector, b: Vector, s: float) -> Vector:
    return a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])


class HeadingSource:
    """Source of the robot's yaw, pitch and roll at any time in the last two seconds.

    The IMU modes are: 0, heading from robot code; 1, heading from robot code, which also seeds the IMU; 2, IMU alone;
    3, IMU corrected by MegaTag 1; 4, IMU corrected by the heading from robot code. A camera without an IMU uses mode 0.

    The IMU's yaw is zero at power-on, whatever the robot's heading. The IMU then follows the robot's yaw with a slow
    drift.

    Args:
        has_imu: Whether the camera has an IMU.
        drift_deg: Standard deviation of the IMU's yaw drift after 30 s [deg].
        rng: Random generator for the drift.
    """

    def __init__(self, *, has_imu: bool, drift_deg: float, rng: np.random.Generator) -> None:
        self._has_imu = has_imu
        self._walk = math.radians(drift_deg) / math.sqrt(30.0)
        self._rng = rng
        self.mode = _EXTERNAL
        """IMU mode, 0 to 4; no effect if the camera has no IMU."""
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
        """Record the orientation that robot code sent at a time [s].

        Args:
            time: Simulated time at which robot code sent the orientation [s].
            orientation: Yaw, yaw rate, pitch, pitch rate, roll and roll rate [deg, deg/s]; the rates are not used.
        """
        yaw = math.radians(orientation[0])
        last = self._sent.at(math.inf)
        if last is not None:
            yaw = last[0] + math.remainder(yaw - last[0], math.tau)
        self._sent.add(time, (yaw, math.radians(orientation[2]), math.radians(orientation[4])))

    def move(self, time: float, quat: Quaternion) -> None:
        """Update the IMU from the robot's true attitude at a time [s]; do nothing without an IMU.

        Add the drift, and correct the yaw in the modes 1 and 4. Call this method once a tick.
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
        """Correct the IMU's yaw toward a MegaTag 1 yaw in mode 3; do nothing in other modes.

        Args:
            yaw_deg: Yaw of the robot from MegaTag 1 [deg].
            since: Time since the previous frame with tags [s].
        """
        if self._has_imu and self.mode == _MT1_ASSIST:
            self._draw_to(math.radians(yaw_deg), since)

    def attitude(self, time: float) -> FloatArray:
        """Return the rotation from robot to field axes at a time [s], from the source of the IMU mode, shape (3, 3)."""
        yaw, pitch, roll = self._at(time)
        return matrix(from_rpy(roll, pitch, yaw))

    def reading(self) -> ImuReading | None:
        """Return the latest readings of the IMU; None without an IMU or before the first call of `move`."""
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
        """Return yaw, pitch and roll [rad] at a time [s] from the source of the IMU mode; zeros without data."""
        is_internal = self._has_imu and self.mode >= _INTERNAL
        return (self._internal if is_internal else self._sent).at(time) or (0.0, 0.0, 0.0)

    def _draw_to(self, yaw: float, dt: float) -> None:
        """Move the IMU's yaw toward a yaw [rad] by a complementary filter, one step per IMU sample in dt [s]."""
        share = 1.0 - (1.0 - self.assist) ** (_IMU_RATE * dt)
        self._yaw += share * math.remainder(yaw - self._yaw, math.tau)
