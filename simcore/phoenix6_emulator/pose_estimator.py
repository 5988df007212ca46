"""Pose from wheels and gyro, corrected by vision that comes late: WPILib's pose estimator as CTRE ships it.

Each axis of a correction, taken in the frame of the robot as it stood at the time of the measurement, counts with the
gain q / (q + sqrt(q r)) of a Kalman filter that has settled, q and r being the variances of odometry and vision.
Measured against 26.3.0 to the last printed digit.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from collections.abc import Sequence

from simcore.phoenix6_emulator.swerve_kinematics import Pose, between, exp, interpolate, then, wrap

__all__ = ["HISTORY", "PoseEstimator"]

HISTORY = 1.5
"""How long past poses are kept [s]."""


class PoseEstimator:
    """Estimate of the robot's pose.

    Args:
        state_std_devs: Of odometry: x, y [m], heading [rad].
        vision_std_devs: Of a vision measurement.
    """

    def __init__(
        self,
        state_std_devs: Sequence[float] = (0.1, 0.1, 0.1),
        vision_std_devs: Sequence[float] = (0.9, 0.9, 0.9),
    ) -> None:
        self._state_std_devs = [float(s) for s in state_std_devs]
        self._vision_std_devs = [float(s) for s in vision_std_devs]
        self._times: deque[float] = deque()
        self._poses: deque[Pose] = deque()
        self._updates: list[tuple[float, Pose, Pose]] = []  # time, corrected pose, odometry's pose
        self._odometry: Pose = (0.0, 0.0, 0.0)
        self._offset = 0.0
        self.pose: Pose = (0.0, 0.0, 0.0)
        """The estimate, field frame [m, m, rad]."""

    def set_state_std_devs(self, std_devs: Sequence[float]) -> None:
        """Set the standard deviations of odometry from now on."""
        self._state_std_devs = [float(s) for s in std_devs]

    def set_vision_std_devs(self, std_devs: Sequence[float]) -> None:
        """Set the standard deviations of vision from now on."""
        self._vision_std_devs = [float(s) for s in std_devs]

    def reset(self, pose: Pose, gyro_yaw: float) -> None:
        """Set the pose, without history, at the gyro reading `gyro_yaw` [rad]."""
        self._offset = pose[2] - gyro_yaw
        self._odometry = self.pose = pose
        self._times.clear()
        self._poses.clear()
        self._updates.clear()

    def update(self, time: float, dx: float, dy: float, gyro_yaw: float) -> None:
        """Add the travel of one period.

        Args:
            time: Of the sample [s].
            dx: Travel in the robot frame [m].
            dy: The same to the left [m].
            gyro_yaw: What the gyro shows, continuous [rad].
        """
        old = self._odometry
        new = exp(old, dx, dy, gyro_yaw + self._offset - old[2])
        self._odometry = new
        times = self._times
        times.append(time)
        self._poses.append(new)
        oldest = time - HISTORY
        while times[0] < oldest:
            times.popleft()
            self._poses.popleft()
        self.pose = self._corrected(new) if self._updates else new

    def add_vision(self, pose: Pose, time: float, std_devs: Sequence[float] | None = None) -> None:
        """Correct the estimate by a camera's pose at `time` [s]; `std_devs` apply to the next ones too."""
        if std_devs is not None:
            self.set_vision_std_devs(std_devs)
        if not self._times or time < self._times[0] - HISTORY:
            return
        odometry = self._sample(time)
        believed = self._believed(time, odometry)
        way = between(believed, pose)
        gains = [_gain(q, r) for q, r in zip(self._state_std_devs, self._vision_std_devs, strict=True)]
        corrected = then(believed, (way[0] * gains[0], way[1] * gains[1], way[2] * gains[2]))
        oldest = self._times[0]
        kept = [u for u in self._updates if u[0] < time]
        # of those from before the history only the last still counts
        while len(kept) > 1 and kept[1][0] < oldest:
            kept.pop(0)
        self._updates = [*kept, (time, corrected, odometry)]
        self.pose = self._corrected(self._odometry)

    def sample(self, time: float) -> Pose | None:
        """The estimate at a time within the last 1.5 s [s]; None before the first update."""
        if not self._times:
            return None
        return self._believed(time, self._sample(time))

    # --- inside -------------------------------------------------------------------------------------------------

    def _sample(self, time: float) -> Pose:
        """Odometry's pose at a time; before the history its oldest, after it its newest."""
        times, poses = self._times, self._poses
        k = bisect_left(times, time)
        if k == 0:
            return poses[0]
        if k == len(times):
            return poses[-1]
        return interpolate(poses[k - 1], poses[k], (time - times[k - 1]) / (times[k] - times[k - 1]))

    def _believed(self, time: float, odometry: Pose) -> Pose:
        for at, corrected, then_odometry in reversed(self._updates):
            if at <= time:
                return then(corrected, between(then_odometry, odometry))
        return odometry

    def _corrected(self, odometry: Pose) -> Pose:
        _, corrected, then_odometry = self._updates[-1]
        x, y, heading = then(corrected, between(then_odometry, odometry))
        return x, y, wrap(heading)


def _gain(state: float, vision: float) -> float:
    """Of the settled filter for one axis, from standard deviations [-]."""
    if state == 0.0:
        return 0.0
    if not math.isfinite(vision):
        return 0.0
    return state / (state + vision)
