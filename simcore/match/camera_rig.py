"""Cameras and headsets of all robots in a match: exposures, settings from robot code, and lines for telemetry."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.scatter import ScatterDraws
from simcore.pieces.piece_manager import GamePieceManager
from simcore.robot.robot import Robot
from simcore.typing import FloatArray
from simcore.vision.camera import CameraConfig, PiecePipeline
from simcore.vision.camera_frame import Frame
from simcore.vision.camera_scene import CameraScene
from simcore.vision.heading import PoseHistory
from simcore.vision.limelight import CameraNetwork, LimelightSim
from simcore.vision.quest_headset import HeadsetPort, QuestConfig, QuestHeadset
from simcore.vision.tag_layout import TagLayout, load_layout, official_layout
from simcore.world.rotation import Quaternion, Vector, rotate
from simcore.world.world import PhysicsWorld

__all__ = ["CameraRig", "direction_line", "sighting_lines", "tag_layout"]

_LENGTH = 1.0  # [m]; length of the direction line of a camera without a target


def tag_layout(name: str | Path, field_size: tuple[float, float]) -> TagLayout:
    """Return an AprilTag layout: an official layout by name, or a layout from a JSON file in WPILib's format.

    Args:
        name: Name in `simcore.vision.tag_layout.OFFICIAL_LAYOUTS`, or path of a JSON file; empty for no tags.
        field_size: Length and width of the field [m], used only if the name is empty.

    Raises:
        UnknownNameError: If no official layout has this name.
        ConfigError: If the file is not a valid layout.
    """
    if not name:
        return TagLayout.of([], field_size=field_size)
    return load_layout(name) if isinstance(name, Path) else official_layout(name)


class CameraRig:
    """All cameras and headsets of a match.

    Args:
        world: Physics world in which lines of sight are tested.
        pieces: All pieces, at their starting positions.
        robots: All robots, at their starting poses.
        draws: Random draws of the run.
        field_size: Length and width of the field [m].
        tags: Name or file of the AprilTag layout for `tag_layout`; the rig loads the layout with the first camera.
        rng: Random number generator for the noise of cameras and headsets.
        network: Network on which Limelights publish frames; None if frames are read only from `cameras`.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        pieces: GamePieceManager,
        robots: Sequence[Robot],
        draws: ScatterDraws,
        *,
        field_size: tuple[float, float],
        tags: str | Path,
        rng: np.random.Generator,
        network: CameraNetwork | None = None,
    ) -> None:
        self.layout = TagLayout.of([], field_size=field_size)
        self.cameras: dict[str, LimelightSim] = {}
        """Cameras by name, in order of addition."""
        self._rng = rng  # each camera has a separate random stream, so that a new camera does not change other noise
        self._histories: dict[int, PoseHistory] = {}
        self._tag_errors: FloatArray | None = None
        self.headsets: list[QuestHeadset] = []
        """QuestNav headsets, in order of addition."""
        self._pieces = pieces
        self._class_ids = pieces.state.kind.astype(np.int64)
        self._robots = robots
        self._load_layout: Callable[[], TagLayout] | None = partial(tag_layout, tags, field_size)
        self._network = network
        self._draws = draws
        self._sight = _WorldSight(world, [robot.chassis.row for robot in self._robots])
        for robot in self._robots:
            for config in robot.config.cameras:
                self.mount_camera(config, robot=robot.number)

    def mount_camera(self, config: CameraConfig, *, robot: int = 0) -> LimelightSim:
        """Add a camera to a robot, possibly during a run, and return the camera.

        A random factor of the scatter (`camera_noise`) multiplies the image noise of the config. If the rig has a
        network, a Limelight also publishes frames on the network and reads the settings that robot code has written.

        Args:
            config: Config of the camera.
            robot: Number of the robot.

        Raises:
            ConfigError: If another camera has the same name.
        """
        if config.name in self.cameras:
            raise ConfigError(f"camera {config.name!r} comes twice; each needs its own name, also on other robots")
        if self._load_layout is not None:
            self.layout, self._load_layout = self._load_layout(), None
        if self._tag_errors is None:
            self._tag_errors = self._rng.standard_normal((len(self.layout.ids), 6))
        config = _with_noise(config, self._draws.factor("camera_noise", robot, zlib.crc32(config.name.encode())))
        (rng,) = self._rng.spawn(1)
        camera = LimelightSim(config, self.layout, rng, robot=robot, tag_errors=self._tag_errors)
        self.cameras[config.name] = camera
        self._histories.setdefault(robot, PoseHistory())
        if self._network is not None and config.maker == "limelight":
            camera.ports.append(self._network.port(config, self.layout.field_size))
        return camera

    def add_headset(self, config: QuestConfig, *, robot: int = 0, ports: Sequence[HeadsetPort] = ()) -> QuestHeadset:
        """Add a QuestNav headset to a robot, and return the headset.

        A random factor of the scatter (`camera_noise`) multiplies the noise and the drift of the config.

        Args:
            config: Config of the headset.
            robot: Number of the robot.
            ports: Connections on which the headset publishes poses and receives commands, e.g. a `QuestNavTable`.
        """
        noise = self._draws.factor("camera_noise", robot, len(self.headsets))
        names = ("position_noise", "angle_noise_deg", "position_drift", "yaw_drift_deg")
        config = replace(config, **{name: noise * getattr(config, name) for name in names})
        (rng,) = self._rng.spawn(1)
        headset = QuestHeadset(config, rng, robot=robot, ports=ports)
        self.headsets.append(headset)
        self._histories.setdefault(robot, PoseHistory())
        return headset

    def camera(self, name: str) -> LimelightSim:
        """Return a camera by name.

        Raises:
            UnknownNameError: If no camera has this name; the message suggests similar names.
        """
        if name not in self.cameras:
            raise UnknownNameError("camera", name, self.cameras)
        return self.cameras[name]

    def listen(self, time: float) -> None:
        """Read the settings of cameras and headsets that robot code has written until simulated time `time` [s].

        Call the method in each tick directly after robot code has run.
        """
        for camera in self.cameras.values():
            camera.listen(time)
        for headset in self.headsets:
            headset.listen(time, self._histories[headset.robot])

    def follow_carry(self, robot: int, time: float, old_pos: Vector, *, to_start: bool) -> None:
        """Restart a robot's pose history after a move by the drive team, so that no frame interpolates across the move.

        Args:
            robot: Number of the robot.
            time: Simulated time of the move [s].
            old_pos: Position of the robot before the move, field frame [m].
            to_start: Whether the drive team has placed the robot for an auto; the robot's headsets then repeat the
                last pose reset at the new pose.
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
        """Record the robots' poses at simulated time `time` [s], expose due frames, and publish completed frames."""
        if not self._histories:
            return
        scene = CameraScene(
            pieces=self._pieces.state.pos,
            is_there=self._pieces.is_on_field,
            radii=self._pieces.radius,
            class_names=tuple(kind.name.lower() for kind in self._pieces.types),
            class_ids=self._class_ids,
            sight=self._sight,
        )
        for number, history in self._histories.items():
            history.add(time, self._robots[number].chassis.pos, self._robots[number].chassis.quat)
        for camera in self.cameras.values():
            camera.update(time, self._histories[camera.robot], scene)
        for headset in self.headsets:
            headset.update(time, self._histories[headset.robot])

    def close(self) -> None:
        """Close the ports of all cameras and headsets."""
        for camera in self.cameras.values():
            camera.close()
        for headset in self.headsets:
            headset.close()

    def direction_lines(self) -> dict[str, FloatArray]:
        """Return the `direction_line` of each camera for the camera's last frame, by camera name."""
        return {name: direction_line(*self._pose(camera), camera.last) for name, camera in self.cameras.items()}

    def sighting_lines(self) -> dict[str, FloatArray]:
        """Return the `sighting_lines` of each camera for the camera's last frame, by camera name."""
        return {
            name: sighting_lines(*self._pose(camera), camera.last, self.layout) for name, camera in self.cameras.items()
        }

    def _pose(self, camera: LimelightSim) -> tuple[Vector, Quaternion]:
        chassis = self._robots[camera.robot].chassis
        return camera.pose_at(chassis.pos, chassis.quat)


def direction_line(pos: Vector, quat: Quaternion, frame: Frame | None) -> FloatArray:
    """Return a line from a camera to the target in the last frame, or 1 m along the optical axis without a target.

    The target is the primary AprilTag of the frame, or the primary piece if the frame shows no AprilTag.

    Args:
        pos: Position of the camera, field frame [m].
        quat: Attitude of the camera, unit quaternion x, y, z, w.
        frame: Last frame; None before the first frame.

    Returns:
        Poses of the two ends of the line, rows of x, y, z [m], qw, qx, qy, qz, shape (2, 7).
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
    """Return a polyline from a camera to each of the n tags in the last frame and back to the camera.

    Args:
        pos: Position of the camera, field frame [m].
        quat: Attitude of the camera, unit quaternion x, y, z, w.
        frame: Last frame; None before the first frame.
        layout: Layout of the field's tags.

    Returns:
        Poses of the line's points, rows of x, y, z [m], qw, qx, qy, qz, shape (2 n + 1, 7), or (0, 7) without tags.
    """
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


def _with_noise(config: CameraConfig, factor: float) -> CameraConfig:
    """Return a camera config with the corner noise and the pipelines' box noise multiplied by a factor."""
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
    """Line-of-sight test that casts rays in the physics world and ignores the robot with the camera."""

    def __init__(self, world: PhysicsWorld, rows: Sequence[int]) -> None:
        self._world = world
        self._rows = rows

    def blocked(self, robot: int, start: Vector, ends: Sequence[Sequence[float]]) -> list[bool]:
        return self._world.blocked(start, ends, ignore=self._rows[robot])
