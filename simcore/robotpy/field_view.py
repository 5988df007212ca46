"""The field as the simulation GUI shows it: the robot where it truly is, and the pieces."""

from __future__ import annotations

from collections.abc import Mapping

from wpilib import Field2d
from wpimath.geometry import Pose2d, Rotation2d

from simcore.typing import FloatArray

__all__ = ["FieldView"]


class FieldView:
    """Draws on a Field2d, pieces five times a second: a dashboard does not need more.

    Args:
        field: Where to draw.
        every: Ticks between two drawings of the pieces.
    """

    def __init__(self, field: Field2d, *, every: int = 10) -> None:
        self._field = field
        self._every = every
        self._ticks = 0
        self._level = Rotation2d()

    def update(self, pose: tuple[float, float, float], pieces: Mapping[str, FloatArray]) -> None:
        """After a tick: the true pose [m, m, rad] and all pieces [m], shape (n, 3) per type."""
        x, y, yaw = pose
        self._field.setRobotPose(Pose2d(x, y, Rotation2d(yaw)))
        if self._ticks % self._every == 0:
            for name, places in pieces.items():
                poses = [Pose2d(px, py, self._level) for px, py, _ in places.tolist()]
                self._field.getObject(name).setPoses(poses)
        self._ticks += 1
