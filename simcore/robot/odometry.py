"""Where the robot thinks it is: wheel encoders and gyro added up, slips and all."""

from __future__ import annotations

import math
from collections.abc import Sequence

from simcore.quantities import ANGLE, require
from simcore.typing import FloatArray

__all__ = ["SwerveOdometry"]


class SwerveOdometry:
    """Pose from wheel travel and heading, as WPILib's SwerveDriveOdometry has it.

    Between two samples every module travelled d_i along its heading; the chassis moved by the twist (dx, dy, dyaw)
    that fits all of them best (least squares, the yaw from the gyro), along an arc.

    Args:
        positions: Of the modules, robot frame [m].
        pose: Start, field frame [m, m, rad].
    """

    def __init__(
        self, positions: Sequence[tuple[float, float]], pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ) -> None:
        self._positions = [(float(x), float(y)) for x, y in positions]
        self.reset(pose)

    def reset(
        self,
        pose: tuple[float, float, float],
        distances: Sequence[float] | FloatArray | None = None,
        gyro_yaw: float | None = None,
    ) -> None:
        """Say where the robot is.

        Args:
            pose: Field frame [m, m, rad].
            distances: What the drive encoders show now [m], shape (n,); None: zero.
            gyro_yaw: What the gyro shows now [rad]; None: the pose's own heading.
        """
        for name, value in zip(("x", "y", "yaw"), pose, strict=True):
            require("odometry", name, value, ANGLE)
        self.pose = pose
        """Field frame [m, m, rad]; the heading is continuous."""
        self._distances = [0.0] * len(self._positions) if distances is None else [float(d) for d in distances]
        self._offset = pose[2] - (pose[2] if gyro_yaw is None else gyro_yaw)

    def update(
        self, distances: Sequence[float], angles: Sequence[float], gyro_yaw: float
    ) -> tuple[float, float, float]:
        """Add the travel since the last call.

        Args:
            distances: What the drive encoders show [m], shape (n,).
            angles: Steer angles [rad], shape (n,).
            gyro_yaw: What the gyro shows, continuous [rad].

        Returns:
            The new pose, field frame [m, m, rad].
        """
        x, y, before = self.pose
        yaw = gyro_yaw + self._offset
        turn = yaw - before
        # Each module moves by the twist plus turn x position; the mean of the rest is the least-squares translation.
        # Plain floats: for four modules 4 us, with numpy 15.
        dx = dy = 0.0
        rows = zip(distances, self._distances, angles, self._positions, strict=True)
        for distance, last, angle, (px, py) in rows:
            travel = distance - last
            dx += travel * math.cos(angle) + turn * py
            dy += travel * math.sin(angle) - turn * px
        n = len(self._positions)
        dx, dy = dx / n, dy / n
        self._distances = list(distances)
        if abs(turn) > 1e-9:  # along the arc: WPILib's Pose2d.exp
            s, c = math.sin(turn) / turn, (1.0 - math.cos(turn)) / turn
        else:
            s, c = 1.0, 0.5 * turn
        along, across = s * dx - c * dy, c * dx + s * dy
        cos, sin = math.cos(before), math.sin(before)
        self.pose = (x + cos * along - sin * across, y + sin * along + cos * across, yaw)
        return self.pose
