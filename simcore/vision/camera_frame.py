"""Results of a camera frame: tags, pieces and robot poses, as plain records for any protocol.

The records must not be modified. The classes are not frozen, because a frozen dataclass takes three times as long to
create.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simcore.typing import FloatArray
from simcore.world.rotation import Vector

__all__ = [
    "Corners",
    "Frame",
    "ImuReading",
    "PieceSighting",
    "PoseEstimate",
    "StdDevs",
    "TagPose",
    "TagSighting",
    "as_pixels",
]

Pixel = tuple[float, float]
Corners = tuple[Pixel, Pixel, Pixel, Pixel]
"""Pixels (u to the right, v down) of four corners.

The order for a tag is lower left, lower right, upper right, upper left, as seen facing the tag. The order for a
bounding box is upper left, upper right, lower right, lower left.
"""


def as_pixels(corners: FloatArray) -> Corners:
    """Convert an array of corners [px], shape (4, 2), to tuples of floats."""
    (u0, v0), (u1, v1), (u2, v2), (u3, v3) = corners.tolist()
    return (u0, v0), (u1, v1), (u2, v2), (u3, v3)


StdDevs = tuple[float, float, float, float, float, float]
"""Standard deviations of x, y, z [m] and roll, pitch, yaw [deg]."""


@dataclass(slots=True, eq=False)
class TagPose:
    """Pose of a tag relative to the camera."""

    rotation: list[list[float]]
    """Rotation matrix from face axes (right as seen facing the tag, up, out of the face) to optical axes, 3 rows."""
    translation: list[float]
    """Center of the tag, optical frame [m]."""


@dataclass(slots=True, eq=False)
class TagSighting:
    """Detection of a tag in an image."""

    id: int
    """AprilTag id."""
    pixels: Corners
    """Corners in the order lower left, lower right, upper right, upper left, as seen facing the tag [px]."""
    tx_deg: float
    """Horizontal angle from the principal point to the tag's center, positive to the right [deg]."""
    ty_deg: float
    """Vertical angle from the principal point to the tag's center, positive up [deg]."""
    area_percent: float
    """Area of the tag as a percentage of the image [%]."""
    camera_distance: float
    """Measured distance from the camera to the tag's center [m]."""
    robot_distance: float
    """Measured distance from the robot's center on the carpet to the tag's center [m]."""
    ambiguity: float
    """Ambiguity, 0 to 1: ratio of the reprojection errors of the better and the worse pose in `poses`."""
    poses: tuple[TagPose, TagPose]
    """Two poses that fit the tag's corners in the image, the better fit first."""

    @property
    def corners(self) -> FloatArray:
        """`pixels` as an array, shape (4, 2)."""
        return np.array(self.pixels)


@dataclass(slots=True, eq=False)
class PieceSighting:
    """Detection of a game piece in an image."""

    class_id: int
    """Id of the piece's class in the detector."""
    class_name: str
    """Name of the piece's class in the detector."""
    pixels: Corners
    """Corners of the bounding box in the order upper left, upper right, lower right, lower left [px]."""
    tx_deg: float
    """Horizontal angle from the principal point to the box's center, positive to the right [deg]."""
    ty_deg: float
    """Vertical angle from the principal point to the box's center, positive up [deg]."""
    area_percent: float
    """Area of the box as a percentage of the image [%]."""
    distance: float
    """True distance from the camera to the piece's center [m], for sorting the detections; not published."""
    slot: int
    """Index of the piece in the arrays of `CameraScene`."""

    @property
    def corners(self) -> FloatArray:
        """`pixels` as an array, shape (4, 2)."""
        return np.array(self.pixels)


@dataclass(slots=True)
class PoseEstimate:
    """Robot pose estimated from tags, field frame."""

    position: Vector
    """Position of the robot [m]."""
    roll_deg: float
    """Roll of the robot [deg]."""
    pitch_deg: float
    """Pitch of the robot [deg]."""
    yaw_deg: float
    """Yaw of the robot [deg]."""
    tag_count: int
    """Number of tags in the estimate."""
    tag_span: float
    """Largest distance between two of the tags [m]."""
    average_distance: float
    """Average distance of the tags from the camera [m]."""
    average_area: float
    """Average area of the tags as a percentage of the image [%]."""
    std_devs: StdDevs
    """Standard deviations due to corner noise: x, y, z [m] and roll, pitch, yaw [deg]; 0 for a known angle."""


@dataclass(frozen=True, slots=True)
class ImuReading:
    """Readings of the camera's internal IMU."""

    robot_yaw_deg: float
    """Yaw that MegaTag 2 uses [deg]."""
    roll_deg: float
    """Roll of the robot [deg]."""
    pitch_deg: float
    """Pitch of the robot [deg]."""
    internal_yaw_deg: float
    """Yaw of the IMU [deg]: yaw since power-on with drift, and with the corrections of the IMU mode."""
    rates_dps: Vector
    """Rates of roll, pitch and yaw [deg/s]."""
    acceleration_g: Vector
    """Accelerometer reading of a robot at rest, in robot axes [g]: (0, 0, 1) for a level robot. The acceleration of a
    moving robot is not included."""


@dataclass(slots=True, kw_only=True, eq=False)
class Frame:
    """Results that a camera publishes for one frame."""

    number: int
    """Number of the frame, counted from 1 and including skipped frames; published as the heartbeat."""
    time: float
    """Simulated time of the exposure [s]."""
    published: float
    """Simulated time at which the camera published the frame [s]."""
    capture_latency: float
    """Time from exposure to the start of the pipeline [s]."""
    pipeline_latency: float
    """Processing time of the pipeline [s]."""
    pipeline: int
    """Number of the pipeline that processed the frame."""
    pipeline_kind: str
    """Kind of the pipeline that processed the frame, `tags` or `pieces`."""
    json: bool
    """Whether the camera also publishes the frame as JSON."""
    tags: tuple[TagSighting, ...] = ()
    pieces: tuple[PieceSighting, ...] = ()
    megatag1: PoseEstimate | None = None
    """Robot pose estimated from the image alone; None if the frame has no tags."""
    megatag2: PoseEstimate | None = None
    """Robot pose estimated with a known heading; None if the frame has no tags or the solver finds no solution."""
    primary_tag: TagSighting | None = None
    """Tag whose angles are published: the priority tag if visible, otherwise the largest tag; None without tags."""
    primary_piece: PieceSighting | None = None
    """Nearest piece; None without pieces."""
    mount: tuple[float, float, float, float, float, float]
    """Configured camera pose on the robot: forward, right, up [m], roll, pitch (positive up), yaw [deg]."""
    mount_position: FloatArray
    """Configured camera position, robot frame [m], shape (3,)."""
    mount_axes: FloatArray
    """Configured rotation from optical to robot axes, shape (3, 3)."""
    imu: ImuReading | None = None
    """Readings of the IMU; None if the camera has no IMU."""

    @property
    def latency(self) -> float:
        """Total latency of capture and pipeline [s]."""
        return self.capture_latency + self.pipeline_latency
