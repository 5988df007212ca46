"""The cameras of a match: what they can see, and when they look."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from simcore.geometry.rotation import Vector
from simcore.physics.world import PhysicsWorld
from simcore.pieces.piece_manager import GamePieceManager
from simcore.robot.robot import Robot
from simcore.typing import FloatArray
from simcore.vision.camera_manager import NetworkClock, VisionSimManager, direction_line, sighting_lines
from simcore.vision.camera_scene import CameraScene
from simcore.vision.tag_layout import TagLayout, load_layout, official_layout

if TYPE_CHECKING:
    import ntcore

__all__ = ["CameraRig", "tag_layout"]


def tag_layout(name: str | Path) -> TagLayout:
    """A layout by name (see `simcore.vision.tag_layout.OFFICIAL_LAYOUTS`), or from a JSON file.

    Raises:
        UnknownNameError: No such layout.
        ConfigError: A broken file.
    """
    return load_layout(name) if isinstance(name, Path) else official_layout(name)


class CameraRig(VisionSimManager):
    """All cameras of a match.

    Args:
        world: For lines of sight.
        pieces: What they may see.
        robots: With their cameras.
        layout: Where the tags are.
        rng: For all noise.
        network: Where cameras publish; None: nowhere, their frames can be read all the same.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        pieces: GamePieceManager,
        robots: Sequence[Robot],
        layout: TagLayout,
        rng: np.random.Generator,
        network: ntcore.NetworkTableInstance | None = None,
    ) -> None:
        super().__init__(layout, rng)
        self.clock = NetworkClock()
        """From simulated time to that of NetworkTables."""
        self._pieces = pieces
        self._class_ids = pieces.state.kind.astype(np.int64)
        self._carriers = [robot for robot in robots if robot.config.cameras]
        self._sight = _WorldSight(world, {robot.number: robot.chassis.row for robot in self._carriers})
        for robot in self._carriers:
            for config in robot.config.cameras:
                self.add(config, robot=robot.number)
        if network is not None:
            from simcore.vision.limelight_table import LimelightTable  # only here: a headless run needs no ntcore

            for camera in self.cameras.values():
                camera.ports.append(LimelightTable(network, camera.config, layout.field_size, self.clock))

    def look(self, time: float) -> None:
        """One tick, at its end [s]."""
        if not self.cameras:
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

    def lines(self, robots: Sequence[Robot]) -> dict[str, FloatArray]:
        """What to draw, by telemetry key: rows of poses."""
        found: dict[str, FloatArray] = {}
        for name, camera in self.cameras.items():
            chassis = robots[camera.robot].chassis
            pos, quat = camera.pose_at(chassis.pos, chassis.quat)
            found[f"Sim/Limelights/{name}/DirectionLine"] = direction_line(pos, quat, camera.last)
            found[f"Sim/Limelights/{name}/SeenTags"] = sighting_lines(pos, quat, camera.last, self.layout)
        return found


class _WorldSight:
    """Lines of sight by rays of the physics world."""

    def __init__(self, world: PhysicsWorld, rows: Mapping[int, int]) -> None:
        self._world = world
        self._rows = rows

    def blocked(self, robot: int, start: Vector, ends: Sequence[Sequence[float]]) -> list[bool]:
        return self._world.blocked(start, ends, ignore=self._rows[robot])
