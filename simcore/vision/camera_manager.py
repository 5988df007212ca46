"""All cameras of a field: one call a tick, their clock, and the lines that show what they see."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.geometry.rotation import Quaternion, Vector, rotate
from simcore.season import clock_rate
from simcore.typing import BoolSupplier, FloatArray
from simcore.vision.camera import CameraConfig
from simcore.vision.camera_frame import Frame
from simcore.vision.camera_scene import CameraScene
from simcore.vision.heading import PoseHistory
from simcore.vision.limelight import CameraPort, LimelightSim
from simcore.vision.tag_layout import TagLayout

__all__ = ["NetworkClock", "VisionSimManager", "direction_line", "sighting_lines"]


_LENGTH = 1.0  # [m], of the line of a camera that aims at nothing


class NetworkClock:
    """Adds an offset: NetworkTables counts microseconds, since 2027 nanoseconds, since some start of its own.

    Without an offset (headless) published values carry simulated time, and what robot code sends counts as sent just
    now, because its stamps are of the wall clock.

    >>> clock = NetworkClock()
    >>> clock.to_network(1.5) == 1.5 * clock.rate, clock.to_simulated(123)
    (True, None)
    >>> clock.offset = 10.0
    >>> clock.to_network(1.5) == 11.5 * clock.rate, clock.to_simulated(round(11.5 * clock.rate))
    (True, 1.5)
    """

    __slots__ = ("offset", "rate")

    def __init__(self, offset: float | None = None) -> None:
        self.rate = clock_rate()
        self.offset = offset
        """Time of NetworkTables minus simulated time [s]; None: headless. Set by what runs beside a real clock."""

    def to_network(self, time: float) -> int:
        """Stamp of a simulated time [s], by `season.clock_rate`; at least 1, because 0 means now."""
        return max(1, round(self.rate * (time + (self.offset or 0.0))))

    def to_simulated(self, stamp: int) -> float | None:
        """Simulated time [s] of a stamp; None without an offset."""
        return None if self.offset is None else stamp / self.rate - self.offset


def direction_line(pos: Vector, quat: Quaternion, frame: Frame | None) -> FloatArray:
    """From the lens to what the last frame aims at, or 1 m along its axis.

    Args:
        pos: Of the camera, field frame [m].
        quat: Its attitude.
        frame: Its last one; None: it has none yet.

    Returns:
        Two poses as rows of x, y, z, qw, qx, qy, qz, shape (2, 7).
    """
    ahead, left, up = _LENGTH, 0.0, 0.0
    tag = frame.primary_tag if frame is not None else None
    piece = frame.primary_piece if frame is not None else None
    seen = tag or piece
    if seen is not None:
        reach = tag.camera_distance if tag is not None else piece.distance if piece is not None else _LENGTH
        left, up = -math.tan(math.radians(seen.tx_deg)), math.tan(math.radians(seen.ty_deg))
        scale = reach / math.sqrt(1.0 + left * left + up * up)
        ahead, left, up = scale, scale * left, scale * up
    dx, dy, dz = rotate(quat, (ahead, left, up))
    return _poses(np.array([pos, (pos[0] + dx, pos[1] + dy, pos[2] + dz)]), quat)


def sighting_lines(pos: Vector, quat: Quaternion, frame: Frame | None, layout: TagLayout) -> FloatArray:
    """From the lens to each tag of the last frame and back, shape (2 n + 1, 7); empty without tags."""
    ids = [tag.id for tag in frame.tags] if frame is not None else []
    if not ids:
        return np.zeros((0, 7))
    points = np.repeat(np.array([pos]), 2 * len(ids) + 1, axis=0)
    points[1::2] = layout.centers[np.searchsorted(layout.ids, ids)]
    return _poses(points, quat)


def _poses(points: FloatArray, quat: Quaternion) -> FloatArray:
    rows = np.empty((len(points), 7))
    rows[:, :3] = points
    rows[:, 3:] = (quat[3], quat[0], quat[1], quat[2])
    rows.setflags(write=False)
    return rows


class VisionSimManager:
    """Keeps where each robot was for two seconds, and lets its cameras look.

    Args:
        layout: The tags.
        rng: For all noise; each camera draws from its own stream, so that one more changes nothing for the others.
    """

    def __init__(self, layout: TagLayout, rng: np.random.Generator) -> None:
        self.layout = layout
        self._rng = rng
        self._histories: dict[int, PoseHistory] = {}
        self._tag_errors: FloatArray | None = None
        self.cameras: dict[str, LimelightSim] = {}
        """By name, in the order in which they were added."""

    def add(
        self,
        config: CameraConfig,
        *,
        robot: int = 0,
        ports: Sequence[CameraPort] = (),
        gate: BoolSupplier | None = None,
    ) -> LimelightSim:
        """Put a camera on a robot.

        Args:
            config: What it is.
            robot: Number of the robot.
            ports: Where it publishes and listens, e.g. a `LimelightTable`.
            gate: Whether it looks; None: always.

        Raises:
            ConfigError: There is one of this name.
        """
        if config.name in self.cameras:
            raise ConfigError(f"camera {config.name!r} comes twice; each needs its own name, also on other robots")
        (rng,) = self._rng.spawn(1)
        if self._tag_errors is None:
            self._tag_errors = self._rng.standard_normal((len(self.layout.ids), 6))
        camera = LimelightSim(
            config, self.layout, rng, robot=robot, ports=ports, gate=gate, tag_errors=self._tag_errors
        )
        self.cameras[config.name] = camera
        self.follow(robot)
        return camera

    def follow(self, robot: int) -> None:
        """Note from now on where a robot is."""
        self._histories.setdefault(robot, PoseHistory())

    def camera(self, name: str) -> LimelightSim:
        """A camera by name.

        Raises:
            UnknownNameError: With the nearest names.
        """
        if name not in self.cameras:
            raise UnknownNameError("camera", name, self.cameras)
        return self.cameras[name]

    def listen(self, time: float) -> None:
        """Take what robot code wrote; call it right after robot code ran, at simulated time [s]."""
        for camera in self.cameras.values():
            camera.listen(time)

    def update(self, time: float, scene: CameraScene) -> list[Frame]:
        """One tick: note where the robots are, expose what is due, publish what is ready.

        Args:
            time: At the end of the tick, simulated [s].
            scene: Robots that carry cameras, pieces, and what can stand in between.

        Returns:
            Frames that were published.
        """
        for number, history in self._histories.items():
            history.add(time, *scene.robots[number])
        frames: list[Frame] = []
        for camera in self.cameras.values():
            frames += camera.update(time, self._histories[camera.robot], scene)
        return frames

    def pose_at(self, robot: int, time: float) -> tuple[Vector, Quaternion]:
        """Where a robot was at a time of the last two seconds [s]."""
        return self._histories[robot].at(time)

    def close(self) -> None:
        """Close all ports."""
        for camera in self.cameras.values():
            camera.close()
