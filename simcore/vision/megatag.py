"""From the corners of tags to the robot's pose: MegaTag 1 (everything from the picture) and 2 (heading from a gyro).

And the perfect camera: the robot's exact pose, for tests of what robot code does with a pose.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simcore.geometry.rotation import (
    Quaternion,
    Rows,
    Vector,
    apply,
    apply_back,
    as_rows,
    matrix,
    rpy,
    times,
    times_back,
    transposed,
)
from simcore.typing import FloatArray
from simcore.units import plain_sum
from simcore.vision.camera import (
    OPTICAL,
    CameraConfig,
    LimelightType,
    angles_deg,
    camera_pose,
    optical_rotation,
    project,
    quad_area,
)
from simcore.vision.camera_frame import Corners, PoseEstimate, StdDevs, TagSighting
from simcore.vision.corner_fit import CameraSolution, refine_pose, solve_position, squared_error
from simcore.vision.planar_pose import SquarePose, ambiguity, solve_square
from simcore.vision.tag_layout import TagLayout

__all__ = ["CameraPose", "Mounting", "TagPicture", "perfect_frame"]

CameraPose = tuple[Vector, Rows]
"""Place of a camera in the field [m], and rotation from field to optical axes."""

_NEAR = 0.02
"""Root mean square distance of corners up to which a pose is a start for MegaTag 1 [-]: a heading off by 1 deg."""
_FITS = 3.0
"""And what may be left in the end, in standard deviations of the noise (1.4 are expected); more is another minimum."""


_TAGS = 4  # nearest ones that a perfect camera sees


@dataclass(frozen=True, slots=True, eq=False)
class Mounting:
    """Where a camera believes to sit, ready for use."""

    position: FloatArray
    """Robot frame [m], shape (3,)."""
    to_optical: FloatArray
    """From robot to optical axes, shape (3, 3)."""
    place: Vector
    """`position` in plain floats, for single vectors; so the next."""
    rows: Rows
    """The same as `to_optical`."""
    axes: Rows
    """From optical to robot axes."""
    lever: Vector
    """From the robot's origin to the camera, optical axes [m]."""

    @classmethod
    def of(cls, position: Vector, rotation: Quaternion) -> Mounting:
        """From the place [m] and attitude (camera to robot axes) on the robot."""
        to_optical = OPTICAL @ matrix(rotation).T
        rows = as_rows(to_optical)
        return cls(np.array(position), to_optical, position, rows, transposed(rows), apply(rows, position))


class TagPicture:
    """The tags of one frame, and what follows from them.

    Args:
        layout: All tags.
        rows: Which ones are seen, k >= 1.
        corners: Their corners as detected [px].
        lens: The picture.
        mounting: Where the camera believes to sit.
    """

    def __init__(
        self,
        layout: TagLayout,
        rows: Sequence[int],
        corners: Sequence[Corners],
        lens: LimelightType,
        mounting: Mounting,
    ) -> None:
        self._layout = layout
        self._rows = list(rows)
        self._mounting = mounting
        (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
        self._noise = lens.corner_noise / math.sqrt(fx * fy)  # in ideal coordinates
        self._squares = [layout.squares[row] for row in self._rows]
        self._ideal: list[Corners] = []
        """Corners in the optical frame, x / z and y / z [-]."""
        self._depths: list[float] = []
        axes, (mount_x, mount_y, mount_z) = mounting.axes, mounting.place
        percent = 50.0 / (lens.width * lens.height)
        atan, degrees, hypot = math.atan, math.degrees, math.hypot
        size, ids = layout.size, layout.id_list
        tags: list[TagSighting] = []
        areas: list[float] = []
        distance = 0.0
        for row, pixels in zip(self._rows, corners, strict=True):
            (u0, v0), (u1, v1), (u2, v2), (u3, v3) = pixels
            ideal = (
                ((u0 - cx) / fx, (v0 - cy) / fy),
                ((u1 - cx) / fx, (v1 - cy) / fy),
                ((u2 - cx) / fx, (v2 - cy) / fy),
                ((u3 - cx) / fx, (v3 - cy) / fy),
            )
            self._ideal.append(ideal)
            poses = solve_square(ideal, size)
            near = far = 0.0
            depth = doubt = 1.0
            if poses is not None:
                px, py, depth = place = poses[0].translation
                x, y, z = apply(axes, place)
                near, far = hypot(px, py, depth), hypot(x + mount_x, y + mount_y, z + mount_z)
                doubt = ambiguity(poses)
            area = percent * abs((u2 - u0) * (v3 - v1) - (v2 - v0) * (u3 - u1))
            tx = degrees(atan((0.25 * (u0 + u1 + u2 + u3) - cx) / fx))
            ty = degrees(atan((cy - 0.25 * (v0 + v1 + v2 + v3)) / fy))
            tags.append(TagSighting(ids[row], pixels, tx, ty, area, near, far, doubt, poses))
            self._depths.append(depth)
            areas.append(area)
            distance += near
        self.tags = tuple(tags)
        """Each tag by itself."""
        self._near: CameraPose | None = None
        self._largest = areas.index(max(areas))
        count = len(tags)
        self._statistics = (layout.span(self._rows), distance / count, plain_sum(areas) / count)

    def megatag1(self, std: StdDevs | None = None, near: CameraPose | None = None) -> PoseEstimate | None:
        """Pose from the picture alone. One tag gives the better of its two poses, which may be the wrong one.

        With several tags it is where the error in the picture is least, wherever the search starts: from where the
        camera truly is it takes 1.2 steps, from MegaTag 2 1.7, from the largest tag's pose 3. With one tag it starts
        from the picture, because there both poses are a minimum.

        Args:
            std: Standard deviations to hand on, from a frame just before; None: work them out, which takes 8 us.
            near: Where to start; None: from MegaTag 2 if that was asked for before.
        """
        found: CameraSolution | None = None
        near = near or self._near
        if near is not None and len(self.tags) > 1:
            found = refine_pose(self._squares, self._ideal, *near, start_error=_NEAR)
        if found is None or found.error > _FITS * self._noise:
            start = self._start()
            found = None if start is None else refine_pose(self._squares, self._ideal, *start)
        if found is None:
            return None
        attitude = times_back(found.rotation, self._mounting.rows)
        return self._estimate(found.position, attitude, std or self._std_devs(found))

    def megatag2(self, attitude: Rows | FloatArray) -> PoseEstimate | None:
        """Place from the picture, with the attitude from the robot or from the camera's IMU.

        Args:
            attitude: From robot to field axes, three rows. A wrong one gives a wrong place.
        """
        upright = as_rows(attitude)
        rotation = times(self._mounting.rows, transposed(upright))
        found = solve_position(self._squares, self._ideal, self._depths, rotation)
        if found is None:
            return None
        place, (sx, sy, sz) = found
        self._near = place, rotation
        k = self._noise
        return self._estimate(place, upright, (k * sx, k * sy, k * sz, 0.0, 0.0, 0.0))

    def _start(self) -> CameraPose | None:
        """Place of the camera [m] and rotation from field to optical axes, from the largest tag."""
        poses = self.tags[self._largest].poses
        if poses is None:
            return None
        row = self._rows[self._largest]
        guess = self._camera(row, poses[0])
        # With an ambiguity this low the other one cannot be meant.
        if len(self.tags) > 1 and poses[0].error > 0.2 * poses[1].error:
            other = self._camera(row, poses[1])
            if squared_error(self._squares, self._ideal, *other) < squared_error(self._squares, self._ideal, *guess):
                guess = other
        return guess

    def _camera(self, row: int, pose: SquarePose) -> CameraPose:
        a, b, c, d, e, f, g, h, i = pose.rotation
        rotation = times(((a, b, c), (d, e, f), (g, h, i)), as_rows(self._layout.square_axes[row]))
        x, y, z = self._layout.center_list[row]
        dx, dy, dz = apply_back(rotation, pose.translation)
        return (x - dx, y - dy, z - dz), rotation

    def _std_devs(self, found: CameraSolution) -> StdDevs:
        """Standard deviations of the robot's pose: the corners' noise, propagated through the linearised solution."""
        # A turn w about the optical axes swings the robot's origin about the camera, by R^T (lever x w).
        lx, ly, lz = self._mounting.lever
        back = transposed(found.rotation)
        swing = [((y * lz - z * ly, z * lx - x * lz, x * ly - y * lx), (x, y, z)) for x, y, z in back]
        roll, pitch, _ = self._mounting.axes
        still = (0.0, 0.0, 0.0)
        variances = found.variances([*swing, (roll, still), (pitch, still), (back[2], still)])
        k = self._noise
        turn = math.degrees(k)
        x, y, z, roll_sd, pitch_sd, yaw_sd = map(math.sqrt, variances)
        return k * x, k * y, k * z, turn * roll_sd, turn * pitch_sd, turn * yaw_sd

    def _estimate(self, camera: Vector, attitude: Rows, std: StdDevs) -> PoseEstimate:
        dx, dy, dz = apply(attitude, self._mounting.place)
        return PoseEstimate(
            (camera[0] - dx, camera[1] - dy, camera[2] - dz),
            math.degrees(math.atan2(attitude[2][1], attitude[2][2])),
            math.degrees(math.asin(max(-1.0, min(1.0, -attitude[2][0])))),
            math.degrees(math.atan2(attitude[1][0], attitude[0][0])),
            len(self.tags),
            *self._statistics,
            std,
        )


def perfect_frame(
    layout: TagLayout, robot_pose: tuple[Vector, Quaternion], config: CameraConfig
) -> tuple[tuple[TagSighting, ...], PoseEstimate, PoseEstimate]:
    """Tags and both poses of a frame without any error.

    Args:
        layout: All tags; the four nearest ones count as seen, even behind the camera.
        robot_pose: True pose, field frame.
        config: The camera.
    """
    lens = config.type
    pos, quat = camera_pose(*robot_pose, config.mount.position, config.mount.rotation)
    rotation = optical_rotation(quat)
    reach = np.linalg.norm(layout.centers - pos, axis=1)
    tags = []
    for row in np.argsort(reach, kind="stable")[:_TAGS].tolist():
        corners, _ = project(layout.corners[row], pos, rotation, lens)
        u, v = corners.mean(axis=0).tolist()
        tx, ty = angles_deg(u, v, lens)
        area = 100.0 / (lens.width * lens.height) * abs(float(quad_area(corners[None])[0]))
        near, far = float(reach[row]), math.dist(layout.centers[row].tolist(), robot_pose[0])
        (u0, v0), (u1, v1), (u2, v2), (u3, v3) = corners.tolist()
        pixels = (u0, v0), (u1, v1), (u2, v2), (u3, v3)
        tags.append(TagSighting(int(layout.ids[row]), pixels, tx, ty, area, near, far, 0.0, None))
    roll, pitch, yaw = rpy(robot_pose[1])
    chosen = layout.centers[np.argsort(reach, kind="stable")[:_TAGS]]
    apart = np.linalg.norm(chosen[:, None, :] - chosen[None, :, :], axis=2)
    estimate = PoseEstimate(
        position=robot_pose[0],
        roll_deg=math.degrees(roll),
        pitch_deg=math.degrees(pitch),
        yaw_deg=math.degrees(yaw),
        tag_count=len(tags),
        tag_span=float(apart.max(initial=0.0)),
        average_distance=plain_sum([tag.camera_distance for tag in tags]) / max(1, len(tags)),
        average_area=plain_sum([tag.area_percent for tag in tags]) / max(1, len(tags)),
        std_devs=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    )
    return tuple(tags), estimate, estimate
