"""Configs of cameras (models, mounts, pipelines) and the projection of field points into an image.

Camera axes are WPILib's (x forward, y left, z up); image axes are u to the right and v down. Projection uses the
optical frame (x right, y down, z forward).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.quantities import (
    COUNT,
    DEGREES,
    DELAY,
    FIELD_LENGTH,
    FIELD_OF_VIEW,
    FRACTION,
    FRAME_RATE,
    NOISE_DEGREES,
    NOISE_PIXELS,
    PIXELS,
    ROBOT_HEIGHT,
    ROBOT_PLACE,
    Quantity,
    require_fields,
)
from simcore.typing import FloatArray
from simcore.world.rotation import Quaternion, Vector, from_rpy, matrix, multiply, rotate

__all__ = [
    "FULL_CROP",
    "LIMELIGHTS",
    "OPTICAL",
    "PHOTON_LENS",
    "CameraBias",
    "CameraConfig",
    "CameraMount",
    "LimelightType",
    "PiecePipeline",
    "Pipeline",
    "TagPipeline",
    "camera_pose",
    "crop_pixels",
    "limelight_type",
    "optical_rotation",
    "project",
    "quad_area",
    "vertical_fov_deg",
]


FULL_CROP = (-1.0, 1.0, -1.0, 1.0)
"""Crop window (x0, x1, y0, y1) of the full image; -1 is the left or lower edge, 1 the right or upper edge."""
OPTICAL: FloatArray = np.array([(0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)])
"""Rotation from camera axes (x forward, y left, z up) to optical axes (x right, y down, z forward)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LimelightType:
    """Camera model of any vendor: a pinhole camera with a centered principal point and fixed latencies.

    The model has no lens distortion.
    """

    name: str
    width: int
    """Width of the image [px]."""
    height: int
    """Height of the image [px]."""
    horizontal_fov_deg: float
    """Horizontal field of view [deg]."""
    vertical_fov_deg: float
    """Vertical field of view [deg]."""
    frame_rate: float
    """Number of processed frames per second [1/s]; `CameraConfig.frame_rate` can override the value."""
    capture_latency: float
    """Time from exposure to the start of the pipeline [s]; published as `cl`."""
    pipeline_latency: float
    """Processing time of the pipeline [s]; published as `tl`."""
    has_imu: bool = False
    """Whether the camera has an IMU. Without an IMU, the camera always uses IMU mode 0."""
    imu_drift_deg: float = 0.5
    """Standard deviation of the IMU's yaw drift after 30 s [deg]. Estimate, +-50 %."""
    corner_noise: float = 0.085
    """Standard deviation of the noise of a tag corner, independent in each frame and along each image axis [px]. The
    noise of the presets is 0.115 mrad, fitted to a Limelight on a robot at rest (2024 log, `docs/cameras.md`)."""
    focal_length: tuple[float, float] = field(init=False)
    """Horizontal and vertical focal length of the pinhole model [px]."""
    principal_point: tuple[float, float] = field(init=False)
    """Pixel (u, v) at which the optical axis meets the image, measured from the upper left corner [px]."""

    def __post_init__(self) -> None:
        owner = f"LimelightType {self.name!r}"
        require_fields(
            self,
            owner,
            width=PIXELS,
            height=PIXELS,
            horizontal_fov_deg=FIELD_OF_VIEW,
            vertical_fov_deg=FIELD_OF_VIEW,
            frame_rate=FRAME_RATE,
            capture_latency=DELAY,
            pipeline_latency=DELAY,
            imu_drift_deg=NOISE_DEGREES,
            corner_noise=NOISE_PIXELS,
        )
        across = math.tan(math.radians(self.horizontal_fov_deg) / 2.0)
        down = math.tan(math.radians(self.vertical_fov_deg) / 2.0)
        object.__setattr__(self, "focal_length", (0.5 * self.width / across, 0.5 * self.height / down))
        object.__setattr__(self, "principal_point", (0.5 * self.width, 0.5 * self.height))


LIMELIGHTS: dict[str, LimelightType] = {
    kind.name: kind
    for kind in (
        # OV5647 with a rolling shutter. FOV: docs.limelightvision.io (teams' constants also have 63.3 x 49.7).
        # Latency: JSON example on the same pages (LL2/3 class). Rate: simcore's predecessor in Java.
        LimelightType(
            name="LL3", width=640, height=480, horizontal_fov_deg=62.5, vertical_fov_deg=48.9,
            frame_rate=30.0, capture_latency=0.0376, pipeline_latency=0.0206, corner_noise=0.06,
        ),
        # FOV, and 50 frames/s at 640 x 480: docs.limelightvision.io. Latency: estimate, +-50 %.
        LimelightType(
            name="LL3A", width=640, height=480, horizontal_fov_deg=54.5, vertical_fov_deg=42.0,
            frame_rate=50.0, capture_latency=0.020, pipeline_latency=0.015, corner_noise=0.07,
        ),
        # OV9281, global shutter. FOV: constants in teams' code for the 1280 x 800 modes. Latency: estimate, +-50 %.
        LimelightType(
            name="LL3G", width=1280, height=800, horizontal_fov_deg=82.0, vertical_fov_deg=56.2,
            frame_rate=45.0, capture_latency=0.015, pipeline_latency=0.012,
        ),
        LimelightType(
            name="LL4", width=1280, height=800, horizontal_fov_deg=82.0, vertical_fov_deg=56.2,
            frame_rate=60.0, capture_latency=0.012, pipeline_latency=0.008, has_imu=True,
        ),
    )
}  # fmt: skip
"""Limelight presets, by name."""


def limelight_type(name: str) -> LimelightType:
    """Return the Limelight preset `name`: LL3, LL3A, LL3G or LL4.

    Raises:
        UnknownNameError: If no preset has this name; the message lists similar names and all known names.

    >>> round(limelight_type("LL4").focal_length[0])
    736
    """
    if name not in LIMELIGHTS:
        raise UnknownNameError("Limelight type", name, LIMELIGHTS)
    return LIMELIGHTS[name]


PHOTON_LENS = LimelightType(
    name="OV9281",
    width=1280,
    height=720,
    # Focal lengths: SimCameraProperties.OV9281_1280_720 of photonlibpy 2026.3, 940.7 x 940.0 px.
    horizontal_fov_deg=68.5,
    vertical_fov_deg=41.9,
    # Rate and latency: estimates for an Orange Pi 5, +-50 %; photonlibpy has 15 frames/s and 60 ms, for a Raspberry Pi.
    frame_rate=30.0,
    capture_latency=0.0,
    pipeline_latency=0.030,
    corner_noise=0.11,
)
"""Default camera model of a PhotonVision camera. The pipeline latency is the whole time from exposure to publication.
"""


def vertical_fov_deg(horizontal_deg: float, width: int, height: int) -> float:
    """Compute the vertical field of view of a camera with square pixels [deg].

    Args:
        horizontal_deg: Horizontal field of view [deg].
        width: Width of the image [px].
        height: Height of the image [px].

    Raises:
        ConfigError: If the field of view is not between 0 and 180 degrees, or the width or height is not positive.

    >>> round(vertical_fov_deg(90.0, 1280, 720), 1)
    58.7
    """
    if not (0.0 < horizontal_deg < 180.0 and width > 0 and height > 0):
        raise ConfigError(
            f"a lens needs a field of view between 0 and 180 degrees and a picture, got {horizontal_deg} and "
            f"{width} x {height}"
        )
    return math.degrees(2.0 * math.atan(math.tan(math.radians(horizontal_deg) / 2.0) * height / width))


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraMount:
    """Pose of a camera in the robot frame, like WPILib's `robot_to_camera`; camera axes are x forward, y left, z up."""

    x: float = 0.0
    """x coordinate of the camera, forward of the robot's center [m]."""
    y: float = 0.0
    """y coordinate of the camera, left of the robot's center [m]."""
    z: float = 0.0
    """Height of the camera above the carpet [m]."""
    roll_deg: float = 0.0
    """Roll about the camera's x axis, positive by the right-hand rule [deg]."""
    pitch_deg: float = 0.0
    """Pitch, positive down as in WPILib [deg]; negative for a camera that points up."""
    yaw_deg: float = 0.0
    """Yaw, counter-clockwise [deg]; 180 for a camera that points backward."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            x=ROBOT_PLACE,
            y=ROBOT_PLACE,
            z=ROBOT_PLACE,
            roll_deg=DEGREES,
            pitch_deg=DEGREES,
            yaw_deg=DEGREES,
        )

    @property
    def position(self) -> Vector:
        """Position of the camera, robot frame [m]."""
        return self.x, self.y, self.z

    @property
    def rotation(self) -> Quaternion:
        """Rotation from camera axes to robot axes."""
        return from_rpy(math.radians(self.roll_deg), math.radians(self.pitch_deg), math.radians(self.yaw_deg))


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraBias:
    """Standard deviations of the constant errors in the poses and focal length that robot code assumes.

    The errors depend on the seed of the match and are constant during a match. All cameras of a match have the same tag
    errors. `CameraBias.none()` has no errors. All values are estimates, within a factor of 3.
    """

    tag_position: float = 0.002
    """Standard deviation of the position error of each tag along each field axis [m]. With the default, the estimated
    pose of a robot at rest shifts by about 2 cm when a second tag becomes visible (measured on one robot: 58 mm)."""
    tag_angle_deg: float = 0.3
    """Standard deviation of the angle error of each tag about each field axis [deg]."""
    mount_position: float = 0.002
    """Standard deviation of the error of the mounting position along each camera axis [m], after a calibration with
    measured distances."""
    mount_angle_deg: float = 0.1
    """Standard deviation of the error of the mounting angle about each camera axis [deg]."""
    focal_length: float = 0.003
    """Standard deviation of the relative error of the calibrated focal length [-]."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            tag_position=ROBOT_HEIGHT,
            tag_angle_deg=NOISE_DEGREES,
            mount_position=ROBOT_HEIGHT,
            mount_angle_deg=NOISE_DEGREES,
            focal_length=Quantity("", 0.0, 0.5),
        )

    @classmethod
    def none(cls) -> CameraBias:
        """Return a bias without errors."""
        return cls(tag_position=0.0, tag_angle_deg=0.0, mount_position=0.0, mount_angle_deg=0.0, focal_length=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class TagPipeline:
    """Config of a pipeline that detects AprilTags."""

    kind: Literal["tags"] = "tags"
    json: bool = False
    """Whether the camera also publishes each frame to the topic `json`; off by default, as on a new Limelight."""
    downscale: float = 1.0
    """Downscale factor of the image before detection [-]; a larger factor reduces the range of tag detection."""
    min_side: float = 12.0
    """Shortest edge of a readable tag, in the downscaled image [px]. The default is 1.5 px for each of the 8 cells
    along an edge. Estimate, +-30 %."""
    max_angle_deg: float = 75.0
    """Largest readable angle between a tag's normal and the line to the camera [deg]; at larger angles, cells merge.
    Estimate."""
    id_filters: tuple[int, ...] = ()
    """Ids of the tags to use; empty for all tags."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            downscale=Quantity("", 1.0, 8.0),
            min_side=Quantity("px", 0.0, 10_000.0, is_open=True),
            max_angle_deg=Quantity("deg", 0.0, 89.9, is_open=True),
            id_filters=[COUNT],
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PiecePipeline:
    """Config of a pipeline that detects game pieces, like Limelight's neural detector."""

    kind: Literal["pieces"] = "pieces"
    json: bool = False
    """Whether the camera also publishes each frame to the topic `json`."""
    piece_class: str = ""
    """Class of the pieces to detect; empty for all classes. If the pieces have no classes, every detection has this
    class name."""
    near: float = 0.1
    """Smallest depth along the optical axis at which a piece is detected [m]."""
    far: float = 4.0
    """Largest depth along the optical axis at which a piece is detected [m]."""
    min_visible: float = 0.4
    """Smallest visible fraction of a piece that is detected [-]. Estimate."""
    box_noise: float = 1.0
    """Standard deviation of the position noise of each edge of the bounding box [px]. Estimate."""

    def __post_init__(self) -> None:
        require_fields(self, near=FIELD_LENGTH, far=FIELD_LENGTH, min_visible=FRACTION, box_noise=NOISE_PIXELS)
        if not self.near < self.far:
            raise ConfigError(f"PiecePipeline: far must be beyond near ({self.near} m), got {self.far}")


Pipeline = TagPipeline | PiecePipeline


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraConfig:
    """Config of a camera on a robot: camera model, mount, pipelines and errors."""

    name: str = "limelight"
    """Name of the camera in robot code, without '/'. The camera's NetworkTables table has the same name."""
    maker: Literal["limelight", "photonvision"] = "limelight"
    """Vendor of the camera, which determines the NetworkTables protocol. `simcore.robotcode.makers.photonvision`
    implements the protocol of PhotonVision."""
    type: LimelightType = field(default_factory=lambda: limelight_type("LL4"))
    mount: CameraMount = field(default_factory=CameraMount)
    """Nominal pose of the camera on the robot, without bias. Robot code can configure another pose through the topic
    `camerapose_robotspace_set`."""
    pipelines: tuple[Pipeline, ...] = (TagPipeline(),)
    """One to ten pipelines, in the order of the pipeline numbers, which start at 0."""
    frame_rate: float | None = None
    """Frame rate [1/s]; None for the frame rate of `type`."""
    bias: CameraBias = field(default_factory=CameraBias)
    """Standard deviations of the constant errors in camera pose, tag poses and focal length."""

    def __post_init__(self) -> None:
        require_fields(self, f"camera {self.name!r}", frame_rate=FRAME_RATE)
        if not self.name or "/" in self.name:
            raise ConfigError(f"CameraConfig: name is a NetworkTables name without '/', got {self.name!r}")
        if not 1 <= len(self.pipelines) <= 10:
            raise ConfigError(f"camera {self.name!r}: a Limelight has 1 to 10 pipelines, got {len(self.pipelines)}")

    @property
    def rate(self) -> float:
        """Frame rate of the camera [1/s]: `frame_rate`, or the frame rate of `type`."""
        return self.frame_rate if self.frame_rate is not None else self.type.frame_rate


def camera_pose(
    robot_pos: Vector, robot_quat: Quaternion, mount_pos: Vector, mount_quat: Quaternion
) -> tuple[Vector, Quaternion]:
    """Compute the position [m] and attitude of a camera in the field frame from the robot pose and the mount pose."""
    dx, dy, dz = rotate(robot_quat, mount_pos)
    pos = (robot_pos[0] + dx, robot_pos[1] + dy, robot_pos[2] + dz)
    return pos, multiply(robot_quat, mount_quat)


def optical_rotation(quat: Quaternion) -> FloatArray:
    """Compute the rotation R from field to optical axes for a camera attitude, shape (3, 3).

    A field point p has the optical coordinates `R @ (p - camera_position)`.
    """
    return OPTICAL @ matrix(quat).T


def project(
    points: FloatArray, pos: Vector, rotation: FloatArray, lens: LimelightType
) -> tuple[FloatArray, FloatArray]:
    """Project field points into the image.

    Args:
        points: Points, field frame [m], shape (n, 3).
        pos: Position of the camera, field frame [m].
        rotation: Rotation from field to optical axes, from `optical_rotation`.
        lens: Camera model with focal lengths and principal point.

    Returns:
        Pixels (u, v), shape (n, 2), and depths along the optical axis [m], shape (n,). Points behind the camera have a
        depth <= 0 and meaningless pixels.
    """
    (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
    p = (points - pos) @ rotation.T
    depth = p[:, 2]
    inverse = 1.0 / np.where(np.abs(depth) < 1e-9, 1e-9, depth)
    return p[:, :2] * inverse[:, None] * (fx, fy) + (cx, cy), depth


def quad_area(corners: FloatArray) -> FloatArray:
    """Compute the signed areas of n quadrilaterals [px^2], shape (n,); positive if counter-clockwise in the image.

    Args:
        corners: Corners (u, v) of the quadrilaterals [px], shape (n, 4, 2).
    """
    a, b = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    area: FloatArray = 0.5 * (a[:, 1] * b[:, 0] - a[:, 0] * b[:, 1])
    return area


def crop_pixels(crop: tuple[float, float, float, float], lens: LimelightType) -> tuple[float, float, float, float]:
    """Convert a crop window to pixel limits: smallest u, largest u, smallest v and largest v [px]."""
    x0, x1, y0, y1 = crop
    return (
        0.5 * (x0 + 1.0) * lens.width,
        0.5 * (x1 + 1.0) * lens.width,
        0.5 * (1.0 - y1) * lens.height,
        0.5 * (1.0 - y0) * lens.height,
    )
