"""The heading that MegaTag 2 uses: what the robot sends, what the camera's own IMU says, or both."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from simcore.geometry.quaternion import Quaternion, rotate_back, rpy
from simcore.typing import FloatArray
from simcore.vision.frames import ImuReading
from simcore.vision.history import ScalarHistory
from simcore.vision.rows import Rows

__all__ = ["HeadingSource"]

_EXTERNAL, _SEED, _INTERNAL, _MT1_ASSIST, _EXTERNAL_ASSIST = range(5)
_IMU_RATE = 1000.0  # [1/s]; the assisting filter runs at the IMU's rate


class HeadingSource:
    """Yaw, pitch and roll at any time of the last two seconds.

    Modes, of cameras with an IMU: 0 what the robot sends; 1 the same, and the IMU is set to it; 2 the IMU alone;
    3 the IMU, drawn to MegaTag 1; 4 the IMU, drawn to what the robot sends. Without an IMU it is always mode 0.

    The IMU's yaw is zero when it is switched on, whichever way the robot looks. It follows the robot with a slow drift.

    Args:
        has_imu: Whether there is one.
        drift_deg: How far its yaw wanders in 30 s, one standard deviation [deg].
        rng: For the drift.
    """

    def __init__(self, *, has_imu: bool, drift_deg: float, rng: np.random.Generator) -> None:
        self._has_imu = has_imu
        self._walk = math.radians(drift_deg) / math.sqrt(30.0)
        self._rng = rng
        self.mode = _EXTERNAL
        """0 to 4; without an IMU it is ignored."""
        self.assist = 0.001
        """Weight of the correction in each of the IMU's 1000 samples a second, in modes 3 and 4 [-]."""
        self._told = ScalarHistory()
        self._told_tilt = ScalarHistory(), ScalarHistory()  # pitch, roll
        self._internal = ScalarHistory()
        self._felt_tilt = ScalarHistory(), ScalarHistory()
        self._yaw = 0.0
        self._true: tuple[float, float, float] | None = None  # roll, pitch, yaw
        self._time = 0.0
        self._rates = (0.0, 0.0, 0.0)
        self._gravity = (0.0, 0.0, 1.0)

    def tell(self, time: float, orientation: Sequence[float]) -> None:
        """What the robot sent: yaw, yaw rate, pitch, pitch rate, roll, roll rate [deg, deg/s]."""
        yaw = math.radians(orientation[0])
        last = self._told.at(math.inf)
        if last is not None:
            yaw = last + math.remainder(yaw - last, math.tau)
        self._told.add(time, yaw)
        for tilt, angle in zip(self._told_tilt, (orientation[2], orientation[4]), strict=True):
            tilt.add(time, math.radians(angle))

    def move(self, time: float, quat: Quaternion) -> None:
        """Let the IMU feel the robot's true attitude at a time [s]; called once a tick."""
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
            told = self._told.at(time)
            if told is not None and self.mode == _SEED:
                self._yaw = told
            elif told is not None and self.mode == _EXTERNAL_ASSIST:
                self._draw_to(told, dt)
        self._true, self._time = (roll, pitch, yaw), time
        self._gravity = rotate_back(quat, (0.0, 0.0, 1.0))
        self._internal.add(time, self._yaw)
        for tilt, angle in zip(self._felt_tilt, (pitch, roll), strict=True):
            tilt.add(time, angle)

    def after_megatag1(self, yaw_deg: float, since: float) -> None:
        """Mode 3: a frame gave a heading [deg]; `since` the one before [s]."""
        if self._has_imu and self.mode == _MT1_ASSIST:
            self._draw_to(math.radians(yaw_deg), since)

    def attitude(self, time: float) -> FloatArray:
        """From robot to field axes at a time [s], shape (3, 3)."""
        return np.array(self.attitude_rows(time))

    def attitude_rows(self, time: float) -> Rows:
        """The same in plain floats."""
        yaw, pitch, roll = self._at(time)
        cy, sy = math.cos(yaw), math.sin(yaw)
        if roll == 0.0 and pitch == 0.0:
            return (cy, -sy, 0.0), (sy, cy, 0.0), (0.0, 0.0, 1.0)
        cp, sp, cr, sr = math.cos(pitch), math.sin(pitch), math.cos(roll), math.sin(roll)
        return (
            (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
            (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
            (-sp, cp * sr, cp * cr),
        )

    def reading(self) -> ImuReading | None:
        """What the IMU says now; None without one."""
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

    def _at(self, time: float) -> tuple[float, float, float]:
        """Yaw, pitch, roll [rad]. A robot that never sent a heading looks along x, as far as the camera knows."""
        is_internal = self._has_imu and self.mode >= _INTERNAL
        yaw = self._internal if is_internal else self._told
        pitch, roll = self._felt_tilt if is_internal else self._told_tilt
        return yaw.at(time) or 0.0, pitch.at(time) or 0.0, roll.at(time) or 0.0

    def _draw_to(self, yaw: float, dt: float) -> None:
        """As many steps of a complementary filter as the IMU makes in dt [s]."""
        share = 1.0 - (1.0 - self.assist) ** (_IMU_RATE * dt)
        self._yaw += share * math.remainder(yaw - self._yaw, math.tau)
