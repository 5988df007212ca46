"""From the corners of tags to the robot's pose: MegaTag 1 (everything from the picture) and 2 (heading from a gyro)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simcore.geometry.quaternion import Quaternion, Vector, matrix
from simcore.typing import FloatArray
from simcore.vision.camera import LimelightType
from simcore.vision.frames import PoseEstimate, StdDevs, TagSighting
from simcore.vision.planar_pose import SquarePose, ambiguity, solve_square
from simcore.vision.projection import OPTICAL, angles_deg
from simcore.vision.refine import CameraSolution, refine_pose, solve_position
from simcore.vision.tags import TagLayout

__all__ = ["Mounting", "TagPicture"]


@dataclass(frozen=True, slots=True, eq=False)
class Mounting:
    """Where a camera believes to sit, ready for use."""

    position: FloatArray
    """Robot frame [m], shape (3,)."""
    to_optical: FloatArray
    """From robot to optical axes, shape (3, 3)."""
    axes: list[list[float]]
    """The same from optical to robot axes, in rows, for single vectors."""
    lever: FloatArray
    """From the robot's origin to the camera, optical axes, as a cross-product matrix [m], shape (3, 3)."""

    @classmethod
    def of(cls, position: Vector, rotation: Quaternion) -> Mounting:
        """From the place [m] and attitude (camera to robot axes) on the robot."""
        to_optical = OPTICAL @ matrix(rotation).T
        x, y, z = (to_optical @ np.array(position)).tolist()
        return cls(
            np.array(position), to_optical, to_optical.T.tolist(), np.array([(0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)])
        )


class TagPicture:
    """The tags of one frame, and what follows from them.

    Args:
        layout: All tags.
        rows: Which ones are seen, k >= 1.
        corners: Their corners as detected [px], shape (k, 4, 2).
        lens: The picture.
        mounting: Where the camera believes to sit.
    """

    def __init__(
        self, layout: TagLayout, rows: Sequence[int], corners: FloatArray, lens: LimelightType, mounting: Mounting
    ) -> None:
        self._layout = layout
        self._rows = list(rows)
        self._mounting = mounting
        (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
        self._noise = lens.corner_noise / math.sqrt(fx * fy)  # in ideal coordinates
        self._points = [corner for row in self._rows for corner in layout.corner_list[row]]
        self._ideal: list[tuple[float, float]] = []
        mount = mounting.position.tolist()
        percent = 100.0 / (lens.width * lens.height)
        tags = []
        for row, seen in zip(self._rows, corners, strict=True):
            (x0, y0), (x1, y1), (x2, y2), (x3, y3) = pixels = seen.tolist()
            ideal = [((u - cx) / fx, (v - cy) / fy) for u, v in pixels]
            self._ideal += ideal
            poses = solve_square(ideal, layout.size)
            near = far = 0.0
            if poses is not None:
                place = poses[0].translation
                near = math.hypot(*place)
                x, y, z = place
                far = math.hypot(
                    *(a * x + b * y + c * z + d for (a, b, c), d in zip(mounting.axes, mount, strict=True))
                )
            area = percent * 0.5 * abs((x2 - x0) * (y3 - y1) - (y2 - y0) * (x3 - x1))
            middle = 0.25 * (x0 + x1 + x2 + x3), 0.25 * (y0 + y1 + y2 + y3)
            doubt = 1.0 if poses is None else ambiguity(poses)
            number = layout.id_list[row]
            tags.append(TagSighting(number, seen, *angles_deg(*middle, lens), area, near, far, doubt, poses))
        self.tags = tuple(tags)
        """Each tag by itself."""
        self._largest = max(range(len(tags)), key=lambda k: tags[k].area_percent)
        self._statistics = (
            layout.span(self._rows),
            sum(tag.camera_distance for tag in tags) / len(tags),
            sum(tag.area_percent for tag in tags) / len(tags),
        )

    def megatag1(self, std: StdDevs | None = None) -> PoseEstimate | None:
        """Pose from the picture alone. One tag gives the better of its two poses, which may be the wrong one.

        With several tags both poses of the largest are tried against all corners.

        Args:
            std: Standard deviations to hand on, from a frame just before; None: work them out, which takes 25 us.
        """
        poses = self.tags[self._largest].poses
        if poses is None:
            return None
        row = self._rows[self._largest]
        guess = self._camera(row, poses[0])
        # With an ambiguity this low the other one cannot be meant.
        if len(self.tags) > 1 and poses[0].error > 0.2 * poses[1].error:
            other = self._camera(row, poses[1])
            if self._misfit(*other) < self._misfit(*guess):
                guess = other
        found = refine_pose(self._points, self._ideal, *guess)
        if found is None:
            return None
        attitude = found.rotation.T @ self._mounting.to_optical
        return self._estimate(found.position, attitude, std or self._std_devs(found))

    def megatag2(self, attitude: FloatArray) -> PoseEstimate | None:
        """Place from the picture, with the attitude that the robot (or the camera's IMU) says it has.

        Args:
            attitude: From robot to field axes, shape (3, 3). A wrong one gives a wrong place.
        """
        depths = [tag.poses[0].translation[2] if tag.poses else 1.0 for tag in self.tags for _ in range(4)]
        rotation = self._mounting.to_optical @ attitude.T
        found = solve_position(self._points, self._ideal, depths, rotation.tolist())
        if found is None:
            return None
        sx, sy, sz = found[1]
        k = self._noise
        return self._estimate(np.array(found[0]), attitude, (k * sx, k * sy, k * sz, 0.0, 0.0, 0.0))

    def _camera(self, row: int, pose: SquarePose) -> tuple[FloatArray, FloatArray]:
        """Place of the camera [m] and rotation from field to optical axes, from one tag."""
        rotation = np.array(pose.rotation).reshape(3, 3) @ self._layout.square_axes[row]
        return self._layout.centers[row] - pose.translation @ rotation, rotation

    def _misfit(self, position: FloatArray, rotation: FloatArray) -> float:
        (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation.tolist()
        cx, cy, cz = position.tolist()
        total = 0.0
        for (px, py, pz), (u, v) in zip(self._points, self._ideal, strict=True):
            px, py, pz = px - cx, py - cy, pz - cz
            depth = r20 * px + r21 * py + r22 * pz
            if depth < 1e-3:
                return math.inf
            a = (r00 * px + r01 * py + r02 * pz) / depth - u
            b = (r10 * px + r11 * py + r12 * pz) / depth - v
            total += a * a + b * b
        return total

    def _std_devs(self, found: CameraSolution) -> StdDevs:
        """How sure the robot's pose is: the corners' noise, carried through the linearised solution."""
        mounting, back = self._mounting, found.rotation.T
        # A turn w about the optical axes swings the robot's origin about the camera, by R^T (lever x w).
        jacobian = np.zeros((6, 6))
        jacobian[:3, :3] = back @ mounting.lever
        jacobian[:3, 3:] = back
        jacobian[3:5, :3] = mounting.to_optical.T[:2]
        jacobian[5, :3] = back[2]
        variance = ((jacobian @ np.linalg.inv(found.normal)) * jacobian).sum(axis=1)
        x, y, z, roll, pitch, yaw = (self._noise * np.sqrt(np.maximum(variance, 0.0))).tolist()
        return x, y, z, math.degrees(roll), math.degrees(pitch), math.degrees(yaw)

    def _estimate(self, camera: FloatArray, attitude: FloatArray, std: StdDevs) -> PoseEstimate:
        x, y, z = (camera - attitude @ self._mounting.position).tolist()
        r = attitude.tolist()
        return PoseEstimate(
            (x, y, z),
            math.degrees(math.atan2(r[2][1], r[2][2])),
            math.degrees(math.asin(max(-1.0, min(1.0, -r[2][0])))),
            math.degrees(math.atan2(r[1][0], r[0][0])),
            len(self.tags),
            *self._statistics,
            std,
        )
