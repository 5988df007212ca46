"""A frame in photonlib's types: targets with both poses, the multi-tag pose, object detections."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from photonlibpy.targeting import (
    MultiTargetPNPResult,
    PhotonPipelineMetadata,
    PhotonPipelineResult,
    PhotonTrackedTarget,
    PnpResult,
    TargetCorner,
)
from wpimath.geometry import Pose3d, Rotation3d, Transform3d, Translation3d

from simcore.typing import FloatArray
from simcore.vision.camera import OPTICAL
from simcore.vision.camera_frame import Frame, PieceSighting, PoseEstimate, TagSighting
from simcore.vision.planar_pose import SquarePose

__all__ = ["pipeline_result"]

_TAG_TO_SQUARE: FloatArray = np.array([(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
_PONG = 1_000_000  # [us]; a time server answered a second ago


def pipeline_result(frame: Frame, stamp: int) -> Any:
    """A `PhotonPipelineResult`.

    Targets come in PhotonVision's default order, the largest first, which makes it `getBestTarget`.

    Args:
        frame: What was seen.
        stamp: When it is published, in NetworkTables' time [us].
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
    best, other = (_transform(pose) for pose in tag.poses) if tag.poses is not None else (Transform3d(), Transform3d())
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


def _transform(pose: SquarePose) -> Any:
    """Camera to tag, both with WPILib's axes."""
    rotation = OPTICAL.T @ np.array(pose.rotation).reshape(3, 3) @ _TAG_TO_SQUARE
    x, y, z = (OPTICAL.T @ np.array(pose.translation)).tolist()
    return Transform3d(Translation3d(x, y, z), _rotation(rotation))


def _camera_pose(robot: PoseEstimate, frame: Frame) -> Any:
    """Field to camera: the estimated pose of the robot and the configured mount of the camera on it."""
    turn = Rotation3d(math.radians(robot.roll_deg), math.radians(robot.pitch_deg), math.radians(robot.yaw_deg))
    mount = Transform3d(Translation3d(*frame.mount_position), _rotation(np.array(frame.mount_axes) @ OPTICAL))
    return Transform3d(Pose3d(), Pose3d(Translation3d(*robot.position), turn).transformBy(mount))


def _rotation(matrix: FloatArray) -> Any:
    """Through roll, pitch and yaw: Rotation3d refuses a matrix that is off by more than rounding."""
    r = matrix.tolist()
    return Rotation3d(
        math.atan2(r[2][1], r[2][2]), math.asin(max(-1.0, min(1.0, -r[2][0]))), math.atan2(r[1][0], r[0][0])
    )


def _corners(corners: FloatArray) -> list[Any]:
    return [TargetCorner(u, v) for u, v in corners.tolist()]


def _box(corners: FloatArray) -> list[Any]:
    (u0, v0), (u1, v1) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return [TargetCorner(u0, v1), TargetCorner(u1, v1), TargetCorner(u1, v0), TargetCorner(u0, v0)]
