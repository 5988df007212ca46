"""The summary of a run as one picture: the field with path, shots and pieces, and the curves under it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from simcore.show.charts import charts_of
from simcore.show.picture import draw_match
from simcore.show.scene import Scene
from simcore.telemetry.recording import Recording
from simcore.typing import FloatArray

__all__ = ["draw_summary", "planar"]


def draw_summary(path: str | Path, recording: Recording, scene: Scene, *, title: str = "", subtitle: str = "") -> None:
    """Draw what was recorded.

    Args:
        path: A `.png`, `.svg` or `.pdf` file; missing folders are made.
        recording: The run.
        scene: What it took place on.
        title: In large letters.
        subtitle: Under it, in small ones.

    Raises:
        OutputError: The picture cannot be written there, or as that kind of file.
    """
    times = recording.times
    first, *rest = [planar(recording, robot.pose_key) for robot in scene.robots] or [np.empty((0, 3))]
    draw_match(
        path,
        field_outlines=scene.field_outlines,
        field_size=scene.field_size,
        robot_path=first,
        fuel_start=recording.places(float(times[0]) if len(times) else 0.0),
        fuel_end=recording.places(float(times[-1]) if len(times) else 0.0),
        shots=scene.shots,
        intakes=scene.intakes,
        title=title,
        subtitle=subtitle,
        bumpers=scene.robots[0].bumpers if scene.robots else (0.8, 0.8),
        path_period=float(np.median(np.diff(times))) if len(times) > 1 else 0.02,
        fuel_radius=scene.piece_radius,
        others=[(robot.alliance, poses) for robot, poses in zip(scene.robots[1:], rest, strict=True)],
        charts=charts_of(recording, scene),
    )


def planar(recording: Recording, key: str) -> FloatArray:
    """A recorded pose seen from above: `x, y, yaw` [m, m, rad], shape (n, 3); no rows where nothing was recorded."""
    if not recording.has(key):
        return np.empty((0, 3))
    _, rows = recording.poses(key)
    w, x, y, z = rows[:, 3], rows[:, 4], rows[:, 5], rows[:, 6]
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return np.column_stack((rows[:, 0], rows[:, 1], yaw))
