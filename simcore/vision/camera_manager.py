"""All cameras of a field: one call a tick."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.geometry.quaternion import Quaternion, Vector
from simcore.typing import BoolSupplier
from simcore.vision.camera import CameraConfig
from simcore.vision.camera_scene import Scene
from simcore.vision.frames import Frame
from simcore.vision.history import PoseHistory
from simcore.vision.limelight import CameraPort, LimelightSim
from simcore.vision.tags import TagLayout

__all__ = ["VisionSimManager"]


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
        camera = LimelightSim(config, self.layout, rng, robot=robot, ports=ports, gate=gate)
        self.cameras[config.name] = camera
        self._histories.setdefault(robot, PoseHistory())
        return camera

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

    def update(self, time: float, scene: Scene) -> list[Frame]:
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
