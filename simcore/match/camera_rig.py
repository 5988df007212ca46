"""The cameras of a match: what they can see, and when they look."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from simcore.geometry.rotation import Vector
from simcore.physics.world import PhysicsWorld
from simcore.robot.robot import Robot
from simcore.season import NetworkTables
from simcore.typing import FloatArray
from simcore.vision.camera import CameraConfig, PiecePipeline
from simcore.vision.camera_manager import NetworkClock, VisionSimManager, direction_line, sighting_lines
from simcore.vision.camera_scene import CameraScene
from simcore.vision.limelight import LimelightSim
from simcore.vision.quest_headset import HeadsetPort, QuestConfig, QuestHeadset
from simcore.vision.tag_layout import TagLayout, load_layout, official_layout

if TYPE_CHECKING:
    from simcore.match.match import Match

__all__ = ["CameraRig", "tag_layout"]


def tag_layout(name: str | Path, field_size: tuple[float, float]) -> TagLayout:
    """A layout by name (see `simcore.vision.tag_layout.OFFICIAL_LAYOUTS`), or from a JSON file.

    Args:
        name: Of a layout, or of a file; empty: a field without tags.
        field_size: Length and width of such a field [m].

    Raises:
        UnknownNameError: No such layout.
        ConfigError: A broken file.
    """
    if not name:
        return TagLayout.of([], field_size=field_size)
    return load_layout(name) if isinstance(name, Path) else official_layout(name)


class CameraRig(VisionSimManager):
    """All cameras of a match.

    Args:
        match: What they may see, with the robots that they are on; its pieces and robots stand already.
        tags: Layout of the field's AprilTags, see `tag_layout`; read with the first camera.
        rng: For all noise.
        network: Where cameras publish; None: nowhere, their frames can be read all the same.
    """

    def __init__(
        self, match: Match, tags: str | Path, rng: np.random.Generator, network: NetworkTables | None = None
    ) -> None:
        field_size, pieces = match.game.field.size, match.pieces
        super().__init__(TagLayout.of([], field_size=field_size), rng)
        self.headsets: list[QuestHeadset] = []
        """Of QuestNav, in the order in which they were added."""
        self.clock = NetworkClock()
        """From simulated time to that of NetworkTables."""
        self._pieces = pieces
        self._class_ids = pieces.state.kind.astype(np.int64)
        self._robots = match.robots
        self._load_layout: Callable[[], TagLayout] | None = partial(tag_layout, tags, field_size)
        self._network = network
        self._draws = match.draws
        self._carriers: list[Robot] = []
        self._sight = _WorldSight(match.world, [robot.chassis.row for robot in self._robots])
        for robot in self._robots:
            for config in robot.config.cameras:
                self.mount_camera(config, robot=robot.number)

    def mount_camera(self, config: CameraConfig, *, robot: int = 0) -> LimelightSim:
        """Put one more camera on a robot, at any time; on a network a Limelight gets its table.

        Args:
            config: What it is.
            robot: Number of the robot.

        Raises:
            ConfigError: There is one of this name.
        """
        if self._load_layout is not None:
            self.layout, self._load_layout = self._load_layout(), None
        config = _with_noise(config, self._draws.factor("camera_noise", robot, zlib.crc32(config.name.encode())))
        camera = self.add(config, robot=robot)
        self._carry(robot)
        if self._network is not None and config.maker == "limelight":
            from simcore.vision.limelight_table import LimelightTable  # only here: a headless run needs no ntcore

            camera.ports.append(LimelightTable(self._network, config, self.layout.field_size, self.clock))
        return camera

    def add_headset(self, config: QuestConfig, *, robot: int = 0, ports: Sequence[HeadsetPort] = ()) -> QuestHeadset:
        """Put a headset of QuestNav on a robot.

        Args:
            config: What it is.
            robot: Number of the robot.
            ports: Where it publishes and listens, e.g. a `QuestNavTable`.
        """
        noise = self._draws.factor("camera_noise", robot, len(self.headsets))
        names = ("position_noise", "angle_noise_deg", "position_drift", "yaw_drift_deg")
        config = replace(config, **{name: noise * getattr(config, name) for name in names})
        (rng,) = self._rng.spawn(1)
        headset = QuestHeadset(config, rng, robot=robot, ports=ports)
        self.headsets.append(headset)
        self._carry(robot)
        return headset

    def _carry(self, robot: int) -> None:
        self.follow(robot)
        if all(other.number != robot for other in self._carriers):
            self._carriers.append(self._robots[robot])

    def listen(self, time: float) -> None:
        """Take what robot code wrote; call it right after robot code ran, at simulated time [s]."""
        super().listen(time)
        for headset in self.headsets:
            headset.listen(time, self._histories[headset.robot])

    def follow_carry(self, robot: int, time: float, old_pos: Vector, *, to_start: bool) -> None:
        """A robot was carried at a time [s]: it was nowhere in between; what looks or is told now is at the new place.

        Args:
            robot: Its number.
            time: Simulated [s].
            old_pos: Where it was [m].
            to_start: Whether to where an auto begins: its headset then takes the robot as having stood there.
        """
        chassis = self._robots[robot].chassis
        history = self._histories.get(robot)
        if history is not None and len(history):
            history.clear()
            history.add(time, chassis.pos, chassis.quat)
        for headset in self.headsets:
            if to_start and headset.robot == robot:
                headset.move_start(old_pos, chassis.pos, chassis.quat)

    def expose(self, time: float) -> None:
        """One tick, at its end [s]."""
        if not self._carriers:
            return
        scene = CameraScene(
            robots={robot.number: (robot.chassis.pos, robot.chassis.quat) for robot in self._carriers},
            pieces=self._pieces.state.pos,
            is_there=self._pieces.is_on_field,
            piece_radius=self._pieces.radius,
            class_names=tuple(kind.name.lower() for kind in self._pieces.types),
            class_ids=self._class_ids,
            sight=self._sight,
        )
        self.update(time, scene)
        for headset in self.headsets:
            headset.update(time, self._histories[headset.robot])

    def close(self) -> None:
        """Close all ports."""
        super().close()
        for headset in self.headsets:
            headset.close()

    def lines(self, robots: Sequence[Robot]) -> dict[str, FloatArray]:
        """What to draw, by telemetry key: rows of poses."""
        found: dict[str, FloatArray] = {}
        for name, camera in self.cameras.items():
            chassis = robots[camera.robot].chassis
            pos, quat = camera.pose_at(chassis.pos, chassis.quat)
            found[f"Sim/Limelights/{name}/DirectionLine"] = direction_line(pos, quat, camera.last)
            found[f"Sim/Limelights/{name}/SeenTags"] = sighting_lines(pos, quat, camera.last, self.layout)
        return found


def _with_noise(config: CameraConfig, factor: float) -> CameraConfig:
    """The same camera with pictures that are noisier by a factor."""
    if factor == 1.0:
        return config
    pipelines = tuple(
        replace(pipeline, box_noise=factor * pipeline.box_noise) if isinstance(pipeline, PiecePipeline) else pipeline
        for pipeline in config.pipelines
    )
    return replace(
        config, type=replace(config.type, corner_noise=factor * config.type.corner_noise), pipelines=pipelines
    )


class _WorldSight:
    """Lines of sight by rays of the physics world."""

    def __init__(self, world: PhysicsWorld, rows: Sequence[int]) -> None:
        self._world = world
        self._rows = rows

    def blocked(self, robot: int, start: Vector, ends: Sequence[Sequence[float]]) -> list[bool]:
        return self._world.blocked(start, ends, ignore=self._rows[robot])
