"""True and estimated paths of the robots of a recording."""

from __future__ import annotations

import math

import numpy as np

from simcore.show.scene import Scene
from simcore.telemetry.recording import Recording
from simcore.typing import FloatArray

__all__ = ["RunTrack"]

_DRIVES = 0.01  # [m]; a robot that has moved farther has driven


class RunTrack:
    """True and estimated paths of all robots of a run.

    Args:
        recording: Recording of the run.
        scene: Scene of the run.
    """

    def __init__(self, recording: Recording, scene: Scene) -> None:
        self.recording, self.scene = recording, scene
        self.robots = [self._path(robot.pose_key) for robot in scene.robots]
        """Times [s] and true `x, y, yaw` [m, m, rad] of each robot, shapes (n,) and (n, 3)."""
        self.estimates = [self._path(f"{robot.prefix}/Robot/EstimatedPose") for robot in scene.robots]
        """Times [s] and estimated `x, y, yaw` [m, m, rad] of each robot, shapes (n,) and (n, 3)."""

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of the recording [s]; both 0 if the recording is empty."""
        times = self.recording.times
        return (float(times[0]), float(times[-1])) if len(times) else (0.0, 0.0)

    def placed_times(self, number: int) -> FloatArray:
        """Return the times [s], after the first row, at which a robot was placed on the field, shape (n,)."""
        times, counts = self._numbers(f"{self.scene.robots[number].prefix}/Robot/Placements")
        jumps: FloatArray = times[1:][np.diff(counts) > 0.0]
        return jumps

    def began(self, number: int) -> float:
        """Return the time [s] at which a robot was last placed on the field before driving; -inf if never placed."""
        times, driven = self._numbers(f"{self.scene.robots[number].prefix}/Robot/DistanceDriven")
        drives = times[driven - driven[:1] > _DRIVES]
        placed = self.placed_times(number)
        return float(max(placed[placed <= drives.min(initial=math.inf)], default=-math.inf))

    def _path(self, key: str) -> tuple[FloatArray, FloatArray]:
        if not self.recording.has(key):
            return np.empty(0), np.empty((0, 3))
        return self.recording.poses(key)[0], self.recording.path(key)

    def _numbers(self, key: str) -> tuple[FloatArray, FloatArray]:
        return self.recording.series(key) if self.recording.has(key) else (np.empty(0), np.empty(0))
