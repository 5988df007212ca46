"""Simulation of a camera that exposes frames at a fixed rate and publishes the results after a latency."""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from simcore.errors import nearest
from simcore.typing import FloatArray
from simcore.vision.camera import CameraConfig, CameraMount, TagPipeline, camera_pose, optical_rotation
from simcore.vision.camera_frame import Frame, PieceSighting, PoseEstimate, TagSighting
from simcore.vision.camera_scene import CameraScene, find_pieces
from simcore.vision.heading import HeadingSource, PoseHistory
from simcore.vision.limelight_settings import INPUTS, NO_EFFECT, NOT_MODELED, CameraSettings, limelight_mount
from simcore.vision.megatag import Mounting, TagPicture
from simcore.vision.tag_layout import TagLayout
from simcore.vision.tag_visibility import Occlusion, find_tags
from simcore.world.rotation import Quaternion, Vector, from_rpy

__all__ = ["CameraPort", "CameraRequest", "LimelightSim"]

_log = logging.getLogger(__name__)

_ORIENTATION = "robot_orientation_set"
_LONGEST_GAP = 1.0  # [s]; after a longer gap, missed frames are skipped


@dataclass(slots=True)
class CameraRequest:
    """Value that robot code wrote to an input topic."""

    topic: str
    values: tuple[float, ...] | None
    """Numbers that robot code wrote; None if robot code wrote something other than numbers."""
    time: float | None = None
    """Simulated time at which robot code sent the request [s]; None for the current time."""


class CameraPort(Protocol):
    """Connection between a camera and robot code."""

    def read(self) -> Sequence[CameraRequest]:
        """Return the requests since the last call, oldest first."""
        ...

    def publish(self, frame: Frame) -> None:
        """Publish the results of a frame."""
        ...

    def close(self) -> None:
        """Unpublish all topics."""
        ...


class CameraNetwork(Protocol):
    """Network between cameras and robot code, for example `CameraTables` on NetworkTables."""

    def port(self, config: CameraConfig, field_size: tuple[float, float]) -> CameraPort:
        """Open the port of a camera; `field_size` is the length and width of the field [m]."""
        ...


@dataclass(slots=True, eq=False)
class _Exposure:
    """Exposed frame with detections, before the results are published."""

    number: int
    time: float
    pipeline: int
    eye: Vector
    """True position of the camera, field frame [m]."""
    rotation: FloatArray
    """Rotation from field to optical axes, shape (3, 3)."""
    rows: list[int] = field(default_factory=list)
    """Indices of the visible tags in the arrays of the layout."""
    pixels: FloatArray = field(default_factory=lambda: np.zeros((0, 4, 2)))
    """Corners of the visible tags [px], shape (k, 4, 2)."""
    pieces: tuple[PieceSighting, ...] = ()


@dataclass(slots=True)
class _RequestLog:
    """Logger for requests that are invalid or have no effect, with one log line per kind of problem."""

    camera: str
    known: set[tuple[str, str]] = field(default_factory=set)
    count: int = 0

    def add(self, topic: str, problem: str, time: float) -> None:
        self.count += 1
        kind = (topic, problem.split(", got")[0])
        if kind not in self.known:
            self.known.add(kind)
            _log.warning("%s: %s at %.2f s: %s; it is ignored", self.camera, topic, time, problem)

    def note(self, topic: str) -> None:
        """Log once that a topic written by robot code has no effect."""
        if (topic, "") in self.known:
            return
        self.known.add((topic, ""))
        if topic in NO_EFFECT:
            _log.info("%s: %s changes nothing here: %s", self.camera, topic, NO_EFFECT[topic])
        elif topic in NOT_MODELED:
            _log.warning("%s: %s is not modeled; it has no effect on what the camera publishes", self.camera, topic)
        else:
            hint = nearest(topic, (*INPUTS, _ORIENTATION, *NO_EFFECT, *NOT_MODELED))
            _log.warning("%s: robot code writes %s, which a Limelight does not read.%s", self.camera, topic, hint)


class LimelightSim:
    """Simulation of a Limelight or PhotonVision camera on a robot.

    Args:
        config: Config of the camera.
        layout: Tags of the field at the nominal poses, which robot code assumes.
        rng: Random generator for noise, bias, and the time of the first exposure.
        robot: Number of the robot that carries the camera.
        ports: Connections to robot code; the camera publishes each frame on all ports.
        tag_errors: Rotation and translation errors of each tag as multiples of the standard deviations in
            `config.bias`, shape (n, 6). All cameras of a match get the same errors. None to draw errors for this camera
            alone.
    """

    def __init__(
        self,
        config: CameraConfig,
        layout: TagLayout,
        rng: np.random.Generator,
        *,
        robot: int = 0,
        ports: Sequence[CameraPort] = (),
        tag_errors: FloatArray | None = None,
    ) -> None:
        self.config = config
        self.layout = layout
        self.robot = robot
        self.is_off = False
        """Whether image processing is switched off. The camera then publishes empty frames."""
        self.ports = list(ports)
        self.settings = CameraSettings.of(config)
        self.heading = HeadingSource(has_imu=config.type.has_imu, drift_deg=config.type.imu_drift_deg, rng=rng)
        self.last: Frame | None = None
        """Last published frame; None before the first frame is published."""
        self._rng = rng
        self._latency = config.type.capture_latency + config.type.pipeline_latency
        self._period = 1.0 / config.rate
        self._next = float(rng.uniform(0.0, self._period))
        self._skip = 0
        self._number = 0
        self._megatag1_at: float | None = None
        self._working: deque[_Exposure] = deque()
        self._request_log = _RequestLog(config.name)
        self._believed = Mounting.of(*self.settings.believed_mount)
        self._wanted: frozenset[int] | None = None
        self._settings_seen = -1
        bias, draws = config.bias, rng.standard_normal(7)
        self._focal_factor = 1.0 + bias.focal_length * float(draws[6])
        x, y, z, *angles = (
            draws[:6] * np.repeat((bias.mount_position, math.radians(bias.mount_angle_deg)), 3)
        ).tolist()
        self._mount_bias = (x, y, z), from_rpy(*angles)
        self._mount = camera_pose(config.mount.position, config.mount.rotation, *self._mount_bias)
        if tag_errors is None:
            tag_errors = rng.standard_normal((len(layout.ids), 6))
        self._tag_offsets = tag_errors * np.repeat((math.radians(bias.tag_angle_deg), bias.tag_position), 3)
        self._tags = layout.displaced(self._tag_offsets)
        self._occlusion = Occlusion(self._tags, robot)

    @property
    def bad_requests(self) -> int:
        """Number of invalid requests so far."""
        return self._request_log.count

    # --- requests -----------------------------------------------------------------------------------------------

    def listen(self, time: float) -> None:
        """Read the new requests of robot code from all ports, and apply the requests at the current time [s]."""
        for port in self.ports:
            for request in port.read():
                self.request(request, time)

    def request(self, request: CameraRequest, time: float) -> None:
        """Apply a request of robot code at the current time [s].

        An invalid request does not change a setting. The method counts invalid requests in `bad_requests`, and logs a
        warning for each kind of problem once.
        """
        topic, values = request.topic, request.values
        if topic not in INPUTS and topic != _ORIENTATION:
            self._request_log.note(topic)
        elif values is None:
            self._request_log.add(topic, "needs numbers", time)
        elif topic == _ORIENTATION:
            if len(values) != 6:
                self._request_log.add(topic, f"needs 6 numbers, got {len(values)}", time)
            elif not all(map(math.isfinite, values)):
                self._request_log.add(topic, f"needs finite numbers, got {list(values)}", time)
            else:
                self.heading.tell(time if request.time is None else request.time, values)
        else:
            problem = self.settings.apply(topic, values)
            if problem is not None:
                self._request_log.add(topic, problem, time)

    # --- frames -------------------------------------------------------------------------------------------------

    def update(self, time: float, history: PoseHistory, scene: CameraScene) -> list[Frame]:
        """Update the IMU, expose the latest frame that is due, and publish all frames at the end of the latency.

        Args:
            time: Current simulated time [s].
            history: Poses of the robot that carries the camera.
            scene: Current state of the field.

        Returns:
            Published frames, oldest first.
        """
        self.heading.mode, self.heading.assist = self.settings.imu_mode, self.settings.imu_assist
        if self.config.type.has_imu:
            self.heading.move(time, history.at(time)[1])
        working = self._working
        published: list[Frame] = []
        if self._next > time and not working:
            return published
        if time - self._next > _LONGEST_GAP:
            self._next += math.floor((time - self._next) / self._period) * self._period
        while self._next <= time:
            if self._skip > 0:
                self._skip -= 1
            elif self._next + self._period > time:  # robot code reads only the latest of several frames in a tick
                working.append(self._expose(self._next, history, scene))
                self._skip = self.settings.throttle
            self._number += 1
            self._next += self._period
        latency = self._latency
        while working and working[0].time + latency <= time:
            frame = self.last = self._finish(working.popleft(), latency)
            for port in self.ports:
                port.publish(frame)
            published.append(frame)
        return published

    def pose_at(self, pos: Vector, quat: Quaternion) -> tuple[Vector, Quaternion]:
        """Compute the true position [m] and attitude of the camera, field frame, for a robot pose in the field frame.

        The result contains the mounting error.
        """
        return camera_pose(pos, quat, *self._mount)

    def move_to(self, mount: CameraMount) -> None:
        """Change the true and the configured mount of the camera; keep the mounting error.

        The change applies from the next frame on.
        """
        self._mount = camera_pose(mount.position, mount.rotation, *self._mount_bias)
        self.settings.mount = limelight_mount(mount)
        self.settings.version += 1

    def close(self) -> None:
        """Close all ports."""
        for port in self.ports:
            port.close()

    def _expose(self, time: float, history: PoseHistory, scene: CameraScene) -> _Exposure:
        """Return an exposure with noisy corners of the visible tags, or with the detected pieces.

        The exposure is empty if image processing is off. The scene is less than a tick newer than the exposure.
        """
        pos, quat = self.pose_at(*history.at(time))
        rotation = optical_rotation(quat)
        exposure = _Exposure(self._number + 1, time, self.settings.pipeline, pos, rotation)
        if self.is_off or self.settings.is_driver_camera:
            return exposure
        pipeline, lens = self.config.pipelines[exposure.pipeline], self.config.type
        if isinstance(pipeline, TagPipeline):
            self._follow_settings()
            rows, pixels = find_tags(
                self._tags,
                lens,
                pos,
                rotation,
                min_side=pipeline.min_side * (self.settings.downscale or pipeline.downscale),
                max_angle_deg=pipeline.max_angle_deg,
                crop=self.settings.crop,
                wanted=self._wanted,
            )
            if rows:
                free = self._occlusion.uncovered(rows, pos, scene, time)
                noise = lens.corner_noise * self._rng.standard_normal(pixels.shape)  # also drawn for hidden tags
                center = np.array(lens.principal_point)
                exposure.rows = [row for row, is_free in zip(rows, free, strict=True) if is_free]
                exposure.pixels = (center + self._focal_factor * (pixels - center) + noise)[free]
        elif len(scene.pieces):
            exposure.pieces = find_pieces(
                scene, self.robot, pos, rotation, lens, pipeline, self.settings.crop, self._rng
            )
        return exposure

    def _finish(self, exposure: _Exposure, latency: float) -> Frame:
        """Return the frame of an exposure, with robot poses estimated from the tags by MegaTag 1 and MegaTag 2.

        MegaTag 2 uses the heading at the exposure time. In IMU mode 3, the yaw of MegaTag 1 corrects the IMU.
        """
        self._follow_settings()
        lens = self.config.type
        pipeline = self.config.pipelines[exposure.pipeline]
        tags: tuple[TagSighting, ...] = ()
        one: PoseEstimate | None = None
        two: PoseEstimate | None = None
        if exposure.rows:
            picture = TagPicture(
                *(self.layout, self._tags, self._tag_offsets, exposure.rows, exposure.pixels),
                *(exposure.eye, exposure.rotation, lens, self._believed),
            )
            tags = picture.tags
            two = picture.megatag2(self.heading.attitude(exposure.time))
            one = picture.megatag1()
            since = self._period if self._megatag1_at is None else exposure.time - self._megatag1_at
            self.heading.after_megatag1(one.yaw_deg, min(since, 0.1))
            self._megatag1_at = exposure.time
        primary: TagSighting | None = None
        wanted = self.settings.priority_id
        for tag in tags:
            if tag.id == wanted:
                primary = tag
                break
            if primary is None or tag.area_percent > primary.area_percent:
                primary = tag
        return Frame(
            number=exposure.number,
            time=exposure.time,
            published=exposure.time + latency,
            capture_latency=lens.capture_latency,
            pipeline_latency=lens.pipeline_latency,
            pipeline=exposure.pipeline,
            pipeline_kind=pipeline.kind,
            json=pipeline.json,
            tags=tags,
            pieces=exposure.pieces,
            megatag1=one,
            megatag2=two,
            primary_tag=primary,
            primary_piece=exposure.pieces[0] if exposure.pieces else None,
            mount=self.settings.mount,
            mount_position=self._believed.position,
            mount_axes=self._believed.to_optical.T,
            imu=self.heading.reading(),
        )

    def _follow_settings(self) -> None:
        """Update the configured mount and the wanted tag ids if the settings changed since the last call."""
        settings = self.settings
        if self._settings_seen == settings.version:
            return
        self._settings_seen = settings.version
        self._believed = Mounting.of(*settings.believed_mount)
        pipeline = self.config.pipelines[settings.pipeline]
        ids = settings.id_filters
        if ids is None and isinstance(pipeline, TagPipeline):
            ids = pipeline.id_filters or None
        self._wanted = None if ids is None else frozenset(ids)
