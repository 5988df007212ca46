"""NetworkTables port of a simulated PhotonVision camera, and conversion of frames to photonlib's types.

A frame contains AprilTag targets with both candidate poses, the multi-tag pose, and object detections.
"""

from __future__ import annotations

import logging
import math
from typing import Any

import numpy as np
from photonlibpy.networktables.NTTopicSet import NTTopicSet
from photonlibpy.targeting import (
    MultiTargetPNPResult,
    PhotonPipelineMetadata,
    PhotonPipelineResult,
    PhotonTrackedTarget,
    PnpResult,
    TargetCorner,
)

from simcore import season
from simcore.robotcode.networktables.network_clock import NetworkClock
from simcore.typing import FloatArray
from simcore.vision.camera import OPTICAL, CameraConfig
from simcore.vision.camera_frame import Frame, PieceSighting, PoseEstimate, TagPose, TagSighting
from simcore.vision.limelight import CameraRequest

Pose3d = season.wpimath.Pose3d
Rotation3d = season.wpimath.Rotation3d
Transform3d = season.wpimath.Transform3d
Translation3d = season.wpimath.Translation3d
ntcore = season.ntcore

__all__ = ["PhotonCameraPort", "pipeline_result"]

_log = logging.getLogger(__name__)

_ROOT = "photonvision"
_TAG_TO_SQUARE: FloatArray = np.array([(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
_PONG = 1_000_000  # [us], reported time since the last reply of the time server


class PhotonCameraPort:
    """NetworkTables table of one camera: publishes frames to each `PhotonCamera` of the same name, and reads requests.

    Append the port to `ports` of a `LimelightSim`. A frame takes about 1 ms, mostly for photonlib's packing. Pipeline,
    driver mode and frame limit take effect; the port only echoes the LED mode, and saves no images.

    Args:
        config: Configuration of the camera.
        clock: Clock that converts simulated time to NetworkTables time.
    """

    def __init__(self, config: CameraConfig, clock: NetworkClock) -> None:
        self._config = config
        self._clock = clock
        root = ntcore.NetworkTableInstance.get_default().get_table(_ROOT)
        table = root.get_sub_table(config.name)
        self._topics: Any = NTTopicSet(table)
        self._topics.updateEntries()  # publishes with the message format's ID, which a PhotonCamera checks
        self._version = root.get_string_topic("version").publish()
        self._version.set(_photonvision_version())
        # One poller for all rarely written topics is faster than polling each subscriber.
        self._poller = ntcore.NetworkTableListenerPoller(root.get_instance())
        self._lights_request = root.get_integer_topic("ledModeRequest").subscribe(-1)
        self._lights = root.get_integer_topic("ledModeState").publish()
        self._pictures = [table.get_integer_topic(f"{kind}SaveImgCmd").subscribe(0) for kind in ("input", "output")]
        now = ntcore.EventFlags.kValueAll | ntcore.EventFlags.kImmediate
        self._listeners = {
            self._poller.add_listener(subscriber, now): name
            for name, subscriber in (
                ("pipeline", self._topics.pipelineIndexRequestSub),
                ("driver", self._topics.driverModeSubscriber),
                ("limit", self._topics.fpsLimitSubscriber),
                ("lights", self._lights_request),
                *(("picture", subscriber) for subscriber in self._pictures),
            )
        }
        self._drives = False
        self._shortest = 0.0  # [s], shortest time between two frames
        self._last = float("-inf")
        self._has_warned = False
        (fx, fy), (cx, cy) = config.type.focal_length, config.type.principal_point
        first = clock.to_network(0.0)  # older than any frame, since ntcore drops values older than the current value
        self._topics.cameraIntrinsicsPublisher.set([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0], first)
        self._topics.cameraDistortionPublisher.set([0.0] * 8, first)
        self._topics.pipelineIndexPublisher.set(0, first)
        self._topics.driverModePublisher.set(False, first)
        self._topics.fpsLimitPublisher.set(-1, first)
        self._topics.heartbeatPublisher.set(0, first)

    def read(self) -> list[CameraRequest]:
        """Return the pipeline requests of robot code, and apply all other requests."""
        requests: list[CameraRequest] = []
        for event in self._poller.read_queue():
            name, value = self._listeners[event.listener], event.data.value.value()
            if name == "pipeline":
                requests.append(CameraRequest("pipeline", (float(value),)))
            elif name == "driver":
                self._drives = bool(value)
                self._topics.driverModePublisher.set(self._drives)
            elif name == "limit":
                self._shortest = 1.0 / value if value > 0 else 0.0
                self._topics.fpsLimitPublisher.set(value)
            elif name == "lights":
                self._lights.set(value)
            elif value and not self._has_warned:
                self._has_warned = True
                _log.warning("%s: simcore has no picture to save", self._config.name)
        return requests

    def publish(self, frame: Frame) -> None:
        """Publish a frame, without targets in driver mode; drop frames beyond the requested frame limit."""
        if frame.time - self._last < self._shortest - 1e-9:
            return
        self._last = frame.time
        stamp = self._clock.to_network(frame.published)
        result = pipeline_result(frame, stamp)
        if self._drives:
            result.targets, result.multitagResult = [], None
        topics = self._topics
        topics.rawBytesEntry.set(PhotonPipelineResult.photonStruct.pack(result).getData(), stamp)
        topics.latencyMillisEntry.set(result.getLatencyMillis(), stamp)
        best = result.getBestTarget()
        topics.hasTargetEntry.set(best is not None, stamp)
        topics.targetPitchEntry.set(0.0 if best is None else best.getPitch(), stamp)
        topics.targetYawEntry.set(0.0 if best is None else best.getYaw(), stamp)
        topics.targetAreaEntry.set(0.0 if best is None else best.getArea(), stamp)
        topics.targetSkewEntry.set(0.0 if best is None else best.getSkew(), stamp)
        topics.targetPoseEntry.set(Transform3d() if best is None else best.getBestCameraToTarget(), stamp)
        topics.pipelineIndexPublisher.set(frame.pipeline, stamp)
        topics.heartbeatPublisher.set(frame.number, stamp)

    def close(self) -> None:
        """Unpublish the topics; safe to call more than once."""
        self._poller.close()
        for name, publisher in vars(self._topics).items():
            if name.endswith(("Publisher", "Entry")) or name.startswith("bestTarget"):
                publisher.close()
        self._lights.close()
        self._version.close()


def _photonvision_version() -> str:
    from photonlibpy import version

    return str(getattr(version, "PHOTONVISION_VERSION", version.PHOTONLIB_VERSION))


def pipeline_result(frame: Frame, stamp: int) -> Any:
    """Convert a camera frame to a `PhotonPipelineResult`.

    Targets are in PhotonVision's default order, largest first, so `getBestTarget` returns the largest target.

    Args:
        frame: Frame of the camera.
        stamp: Publication time on the NetworkTables clock [us].
    """
    multitag = None
    if frame.megatag1 is not None and frame.megatag1.tag_count > 1:
        camera = _camera_pose(frame.megatag1, frame)
        found = PnpResult(best=camera, alt=camera)
        multitag = MultiTargetPNPResult(found, sorted(tag.id for tag in frame.tags))
    tags = sorted(frame.tags, key=lambda tag: -tag.area_percent)
    pieces = sorted(frame.pieces, key=lambda piece: -piece.area_percent)
    return PhotonPipelineResult(
        ntReceiveTimestampMicros=stamp,
        targets=[_tag(tag) for tag in tags] + [_piece(piece) for piece in pieces],
        metadata=PhotonPipelineMetadata(
            captureTimestampMicros=stamp - round(1e6 * frame.latency),
            publishTimestampMicros=stamp,
            sequenceID=frame.number,
            timeSinceLastPong=_PONG,
        ),
        multitagResult=multitag,
    )


def _tag(tag: TagSighting) -> Any:
    best, other = (_transform(pose) for pose in tag.poses)
    return PhotonTrackedTarget(
        yaw=tag.tx_deg,
        pitch=tag.ty_deg,
        area=tag.area_percent,
        skew=0.0,
        fiducialId=tag.id,
        bestCameraToTarget=best,
        altCameraToTarget=other,
        minAreaRectCorners=_box(tag.corners),
        detectedCorners=_corners(tag.corners),
        poseAmbiguity=tag.ambiguity,
    )


def _piece(piece: PieceSighting) -> Any:
    return PhotonTrackedTarget(
        yaw=piece.tx_deg,
        pitch=piece.ty_deg,
        area=piece.area_percent,
        skew=0.0,
        minAreaRectCorners=_box(piece.corners),
        detectedCorners=_corners(piece.corners),
        poseAmbiguity=-1.0,
        objDetectId=piece.class_id,
        objDetectConf=min(1.0, 2.0 * math.sqrt(piece.area_percent / 100.0)),  # photonlib's own estimate
    )


def _transform(pose: TagPose) -> Any:
    """Return the camera-to-tag transform in WPILib axes."""
    rotation = OPTICAL.T @ np.array(pose.rotation) @ _TAG_TO_SQUARE
    x, y, z = (OPTICAL.T @ np.array(pose.translation)).tolist()
    return Transform3d(Translation3d(x, y, z), _rotation(rotation))


def _camera_pose(robot: PoseEstimate, frame: Frame) -> Any:
    """Return the camera pose on the field from the estimated robot pose and the camera's configured mounting."""
    turn = Rotation3d(math.radians(robot.roll_deg), math.radians(robot.pitch_deg), math.radians(robot.yaw_deg))
    mount = Transform3d(Translation3d(*frame.mount_position), _rotation(frame.mount_axes @ OPTICAL))
    return Transform3d(Pose3d(), Pose3d(Translation3d(*robot.position), turn).transformBy(mount))


def _rotation(matrix: FloatArray) -> Any:
    """Convert a matrix to a Rotation3d via roll, pitch and yaw; Rotation3d rejects a slightly non-orthogonal matrix."""
    r = matrix.tolist()
    return Rotation3d(
        math.atan2(r[2][1], r[2][2]), math.asin(max(-1.0, min(1.0, -r[2][0]))), math.atan2(r[1][0], r[0][0])
    )


def _corners(corners: FloatArray) -> list[Any]:
    return [TargetCorner(u, v) for u, v in corners.tolist()]


def _box(corners: FloatArray) -> list[Any]:
    (u0, v0), (u1, v1) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return [TargetCorner(u0, v1), TargetCorner(u1, v1), TargetCorner(u1, v0), TargetCorner(u0, v0)]
