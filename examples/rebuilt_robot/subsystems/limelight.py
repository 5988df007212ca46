"""What a Limelight says on NetworkTables, and what it wants to know: the few topics that this robot uses.

Times are those of NetworkTables on the robot, which are the FPGA's: a frame is as old as its value's timestamp less the
latency that the camera reports.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import ntcore
from wpimath.geometry import Pose2d, Rotation2d

_HEAD, _PER_TAG = 11, 7  # doubles


@dataclass(frozen=True)
class PoseEstimate:
    """Where one frame saw the robot, blue origin."""

    pose: Pose2d
    time: float
    """When the frame was taken, FPGA time [s]."""
    tag_count: int
    distance: float
    """To the tags on average [m]."""


@dataclass(frozen=True)
class Target:
    """The nearest game piece in a camera's picture."""

    tx_deg: float
    """Right of the crosshair is positive."""
    ty_deg: float
    """Above is positive."""
    area: float
    """Of the picture [%]."""


def parse_botpose(values: Sequence[float], timestamp: float) -> PoseEstimate | None:
    """A `botpose_orb_wpiblue` that arrived at a time [s]; None if it is not one, or sees no tag.

    x, y, z [m], roll, pitch, yaw [deg], latency [ms], tag count, span [m], distance [m], area [%]; then 7 per tag.
    """
    if len(values) < _HEAD or not all(map(math.isfinite, values)):
        return None
    count = int(values[7])
    if count < 1 or len(values) != _HEAD + _PER_TAG * count:
        return None
    pose = Pose2d(values[0], values[1], Rotation2d.fromDegrees(values[5]))
    return PoseEstimate(pose, timestamp - values[6] / 1000.0, count, values[9])


class AprilTagCamera:
    """A Limelight that looks for tags (MegaTag 2: it takes the heading from the robot's gyro)."""

    def __init__(self, name: str, instance: ntcore.NetworkTableInstance) -> None:
        self.name = name
        table = instance.getTable(name)
        every = ntcore.PubSubOptions(periodic=0.01, sendAll=True, keepDuplicates=True, pollStorage=20)
        self._botpose = table.getDoubleArrayTopic("botpose_orb_wpiblue").subscribe([], every)
        self._orientation = table.getDoubleArrayTopic("robot_orientation_set").publish()

    def set_orientation(self, yaw_deg: float, yaw_rate_dps: float, pitch_deg: float, roll_deg: float) -> None:
        self._orientation.set([yaw_deg, yaw_rate_dps, pitch_deg, 0.0, roll_deg, 0.0])

    def frames(self) -> list[PoseEstimate | None]:
        """What came since the last call, oldest first; None for a frame without a pose."""
        return [parse_botpose(frame.value, frame.time * 1e-6) for frame in self._botpose.readQueue()]


class PieceCamera:
    """A Limelight that looks for game pieces."""

    STALE = 0.5  # s without a frame

    def __init__(self, name: str, instance: ntcore.NetworkTableInstance) -> None:
        table = instance.getTable(name)
        self._numbers = {key: table.getDoubleTopic(key).subscribe(0.0) for key in ("tx", "ty", "ta")}
        self._valid = table.getIntegerTopic("tv").subscribe(0)
        self._beat = table.getDoubleTopic("hb").subscribe(0.0)

    def target(self, now: float) -> Target | None:
        """The nearest piece, if the camera is alive and sees one; now in FPGA time [s]."""
        if self._valid.get() != 1 or now - self._beat.getLastChange() * 1e-6 > self.STALE:
            return None
        return Target(*(self._numbers[key].get() for key in ("tx", "ty", "ta")))
