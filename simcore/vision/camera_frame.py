"""Results of one frame: tags, pieces and the robot poses derived from them. Plain records for any protocol.

Treat them as read-only; they are not frozen, because frozen ones take three times as long to make.
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
"""Pixels (u to the right, v down) of a tag's lower left, lower right, upper right and upper left corner when facing it,
or of a box's upper left, upper right, lower right and lower left corner."""


def as_pixels(corners: FloatArray) -> Corners:
    """Convert an array of corners, shape (4, 2), to plain floats."""
    (u0, v0), (u1, v1), (u2, v2), (u3, v3) = corners.tolist()
    return (u0, v0), (u1, v1), (u2, v2), (u3, v3)


StdDevs = tuple[float, float, float, float, float, float]
"""Standard deviations of x, y, z [m], roll, pitch, yaw [deg]."""


@dataclass(slots=True, eq=False)
class TagPose:
    """Pose of a tag relative to the camera."""

    rotation: list[list[float]]
    """Rotation from the tag's axes (right when facing it, up, out of its face) to optical axes, 3 rows."""
    translation: list[float]
    """Center of the tag, optical frame [m]."""


@dataclass(slots=True, eq=False)
class TagSighting:
    """One tag in a picture."""

    id: int
    pixels: Corners
    """Corners when facing the tag: lower left, lower right, upper right, upper left."""
    tx_deg: float
    """Horizontal angle from the principal point to the tag's center [deg]; right is positive."""
    ty_deg: float
    """Vertical angle from the principal point to the tag's center [deg]; up is positive."""
    area_percent: float
    """Share of the picture [%]."""
    camera_distance: float
    """Measured distance from the lens to the tag's center [m]."""
    robot_distance: float
    """Measured distance from the robot's center on the carpet to the tag's center [m]."""
    ambiguity: float
    """Ambiguity, 0 to 1: reprojection error of the better of the two single-tag poses over that of the other."""
    poses: tuple[TagPose, TagPose]
    """Both poses that explain the corners, the better one first."""

    @property
    def corners(self) -> FloatArray:
        """`pixels` as an array, shape (4, 2)."""
        return np.array(self.pixels)


@dataclass(slots=True, eq=False)
class PieceSighting:
    """One game piece in a picture."""

    class_id: int
    class_name: str
    pixels: Corners
    """Corners of the box: upper left, upper right, lower right, lower left."""
    tx_deg: float
    ty_deg: float
    area_percent: float
    distance: float
    """True distance from the lens to its center [m], which defines "nearest"; a Limelight does not publish it."""
    slot: int
    """Row of the piece in the arrays of the scene."""

    @property
    def corners(self) -> FloatArray:
        """`pixels` as an array, shape (4, 2)."""
        return np.array(self.pixels)


@dataclass(slots=True)
class PoseEstimate:
    """Robot pose derived from tags, field frame."""

    position: Vector
    """Position of the robot [m]."""
    roll_deg: float
    pitch_deg: float
    yaw_deg: float
    tag_count: int
    tag_span: float
    """Largest distance between two of the tags [m]."""
    average_distance: float
    """Average distance of the tags from the camera [m]."""
    average_area: float
    """Average share of the picture [%]."""
    std_devs: StdDevs
    """Standard deviations of x, y, z [m], roll, pitch, yaw [deg], from the noise of the corners."""


@dataclass(frozen=True, slots=True)
class ImuReading:
    """Readings of the camera's own IMU."""

    robot_yaw_deg: float
    """Heading that MegaTag 2 uses."""
    roll_deg: float
    pitch_deg: float
    internal_yaw_deg: float
    rates_dps: Vector
    """Rates of roll, pitch and yaw [deg/s]."""
    acceleration_g: Vector
    """Gravity in robot axes [g]; the robot's own acceleration is left out."""


@dataclass(slots=True, kw_only=True, eq=False)
class Frame:
    """All results of one frame."""

    number: int
    """Number of the frame, counting up by one; the heartbeat."""
    time: float
    """Simulated time of the exposure [s]."""
    published: float
    """Simulated time at which the camera published it [s]."""
    capture_latency: float
    pipeline_latency: float
    pipeline: int
    pipeline_kind: str
    """`tags` or `pieces`."""
    json: bool
    tags: tuple[TagSighting, ...] = ()
    pieces: tuple[PieceSighting, ...] = ()
    megatag1: PoseEstimate | None = None
    megatag2: PoseEstimate | None = None
    primary_tag: TagSighting | None = None
    """Tag whose angles are published: the priority tag, else the largest."""
    primary_piece: PieceSighting | None = None
    """Nearest piece."""
    mount: tuple[float, float, float, float, float, float]
    """Configured camera pose on the robot: ahead, right, up [m], roll, pitch (up positive), yaw [deg]."""
    mount_position: FloatArray
    """Position of `mount` in the robot frame [m], shape (3,)."""
    mount_axes: FloatArray
    """Rotation of `mount` from optical to robot axes, shape (3, 3)."""
    imu: ImuReading | None = None

    @property
    def latency(self) -> float:
        """Latency of capture and pipeline together [s]."""
        return self.capture_latency + self.pipeline_latency
