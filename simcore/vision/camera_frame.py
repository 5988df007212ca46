"""Results of one frame: tags, pieces, and the robot poses that follow from them. Plain records for any protocol.

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
"""Pixels (u to the right, v down) of a tag's lower left, lower right, upper right and upper left corner as one faces
it, or of a box's upper left, upper right, lower right and lower left one."""


def as_pixels(corners: FloatArray) -> Corners:
    """Corners as plain floats, from an array of shape (4, 2)."""
    (u0, v0), (u1, v1), (u2, v2), (u3, v3) = corners.tolist()
    return (u0, v0), (u1, v1), (u2, v2), (u3, v3)


StdDevs = tuple[float, float, float, float, float, float]
"""Of x, y, z [m], roll, pitch, yaw [deg]."""


@dataclass(slots=True, eq=False)
class TagPose:
    """Where a camera sees a tag."""

    rotation: list[list[float]]
    """From the tag's axes (right as one faces it, up, out of its face) to optical axes, 3 rows."""
    translation: list[float]
    """Of its middle, optical frame [m]."""


@dataclass(slots=True, eq=False)
class TagSighting:
    """One tag in a picture."""

    id: int
    pixels: Corners
    """Of its corners as one faces it: lower left, lower right, upper right, upper left."""
    tx_deg: float
    """Of its middle from the principal point; right is positive."""
    ty_deg: float
    """Up is positive."""
    area_percent: float
    """Of the picture."""
    camera_distance: float
    """From the lens to its middle, as measured [m]."""
    robot_distance: float
    """From the robot's center on the carpet to its middle, as measured [m]."""
    ambiguity: float
    """0 to 1: error in the picture of the better of the two single-tag poses, over that of the other."""
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
    """Of its box: upper left, upper right, lower right, lower left."""
    tx_deg: float
    ty_deg: float
    area_percent: float
    distance: float
    """From the lens to its center, truly [m]: what 'nearest' means; a Limelight does not publish it."""
    slot: int
    """Row of the piece in the arrays that the camera was given."""

    @property
    def corners(self) -> FloatArray:
        """`pixels` as an array, shape (4, 2)."""
        return np.array(self.pixels)


@dataclass(slots=True)
class PoseEstimate:
    """Where tags say that the robot was, field frame."""

    position: Vector
    """[m]."""
    roll_deg: float
    pitch_deg: float
    yaw_deg: float
    tag_count: int
    tag_span: float
    """Largest distance between two of the tags [m]."""
    average_distance: float
    """From the camera [m]."""
    average_area: float
    """Of the picture [%]."""
    std_devs: StdDevs
    """Of x, y, z [m], roll, pitch, yaw [deg], from the corners' noise."""


@dataclass(frozen=True, slots=True)
class ImuReading:
    """Readings of the camera's own IMU."""

    robot_yaw_deg: float
    """The heading that MegaTag 2 uses."""
    roll_deg: float
    pitch_deg: float
    internal_yaw_deg: float
    rates_dps: Vector
    """Of roll, pitch and yaw [deg/s]."""
    acceleration_g: Vector
    """Gravity in robot axes [g]; the robot's own acceleration is left out."""


@dataclass(slots=True, kw_only=True, eq=False)
class Frame:
    """Everything that was found in one frame."""

    number: int
    """Counts up by one; the heartbeat."""
    time: float
    """When it was exposed, simulated [s]."""
    published: float
    """When it left the camera [s]."""
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
    """Whose angles are published: the wanted one, else the largest."""
    primary_piece: PieceSighting | None = None
    """The nearest."""
    mount: tuple[float, float, float, float, float, float]
    """Where the camera believes to sit: ahead, right, up [m], roll, pitch (up positive), yaw [deg]."""
    mount_position: FloatArray
    """The same in the robot frame [m], shape (3,)."""
    mount_axes: FloatArray
    """And its rotation from optical to robot axes, shape (3, 3)."""
    imu: ImuReading | None = None

    @property
    def latency(self) -> float:
        """Of both stages together [s]."""
        return self.capture_latency + self.pipeline_latency
