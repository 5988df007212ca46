"""From the corners of tags to the robot's pose: MegaTag 1 (everything from the picture) and 2 (heading from a gyro)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dtrtrs

from simcore.geometry.quaternion import Quaternion, Vector, matrix
from simcore.typing import FloatArray, IntArray
from simcore.vision.camera import LimelightType
from simcore.vision.frames import PoseEstimate, TagSighting
from simcore.vision.planar_pose import SquarePose, ambiguity, solve_square
from simcore.vision.projection import OPTICAL, angles_deg, quad_area
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
    lever: FloatArray
    """From the robot's origin to the camera, optical axes, as a cross-product matrix [m], shape (3, 3)."""

    @classmethod
    def of(cls, position: Vector, rotation: Quaternion) -> Mounting:
        """From the place [m] and attitude (camera to robot axes) on the robot."""
        to_optical = OPTICAL @ matrix(rotation).T
        x, y, z = (to_optical @ np.array(position)).tolist()
        return cls(np.array(position), to_optical, np.array([(0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)]))


class TagPicture:
    """The tags of one frame, and what follows from them.

    Args:
        layout: All tags.
        rows: Which ones are seen, shape (k,), k >= 1.
        corners: Their corners as detected [px], shape (k, 4, 2).
        lens: The picture.
        mounting: Where the camera believes to sit.
    """

    def __init__(
        self, layout: TagLayout, rows: IntArray, corners: FloatArray, lens: LimelightType, mounting: Mounting
    ) -> None:
        self._layout = layout
        self._rows = rows
        self._mounting = mounting
        focal = lens.focal_length
        self._noise = lens.corner_noise / math.sqrt(focal[0] * focal[1])  # in ideal coordinates
        ideal = (corners - lens.principal_point) / focal
        self._ideal = ideal.reshape(-1, 2)
        self._points = layout.corners[rows].reshape(-1, 3)
        areas = (np.abs(quad_area(corners)) * (100.0 / (lens.width * lens.height))).tolist()
        middles = (0.25 * corners.sum(axis=1)).tolist()
        ids = layout.ids[rows].tolist()
        self.tags = tuple(
            self._sight(*one, lens) for one in zip(ids, corners, ideal.tolist(), middles, areas, strict=True)
        )
        """Each tag by itself."""
        self._largest = max(range(len(areas)), key=areas.__getitem__)
        self._statistics = (
            layout.span(rows),
            sum(tag.camera_distance for tag in self.tags) / len(areas),
            sum(areas) / len(areas),
        )

    def _sight(
        self,
        number: int,
        corners: FloatArray,
        ideal: list[list[float]],
        middle: list[float],
        area: float,
        lens: LimelightType,
    ) -> TagSighting:
        """A tag's angles, its two poses and how far away it is."""
        poses = solve_square(ideal, self._layout.size)
        near = far = 0.0
        if poses is not None:
            x, y, z = poses[0].translation
            near = math.sqrt(x * x + y * y + z * z)
            far = math.dist(((x, y, z) @ self._mounting.to_optical + self._mounting.position).tolist(), (0.0, 0.0, 0.0))
        tx, ty = angles_deg(middle[0], middle[1], lens)
        return TagSighting(number, corners, tx, ty, area, near, far, ambiguity(poses) if poses else 1.0, poses)

    def megatag1(self) -> PoseEstimate | None:
        """Pose from the picture alone. One tag gives the better of its two poses, which may be the wrong one.

        With several tags both poses of the largest are tried against all corners.
        """
        poses = self.tags[self._largest].poses
        if poses is None:
            return None
        row = int(self._rows[self._largest])
        guess = self._camera(row, poses[0])
        # With an ambiguity this low the other one cannot be meant.
        if len(self.tags) > 1 and poses[0].error > 0.2 * poses[1].error:
            other = self._camera(row, poses[1])
            if self._misfit(*other) < self._misfit(*guess):
                guess = other
        found = refine_pose(self._points, self._ideal, *guess)
        return None if found is None else self._from_camera(found)

    def megatag2(self, attitude: FloatArray) -> PoseEstimate | None:
        """Place from the picture, with the attitude that the robot (or the camera's IMU) says it has.

        Args:
            attitude: From robot to field axes, shape (3, 3). A wrong one gives a wrong place.
        """
        depths = [tag.poses[0].translation[2] if tag.poses else 1.0 for tag in self.tags for _ in range(4)]
        rotation = self._mounting.to_optical @ attitude.T
        found = solve_position(self._points, self._ideal, np.array(depths), rotation)
        if found is None:
            return None
        inverse, _ = dtrtrs(found.factor, np.eye(3), trans=1)
        sx, sy, sz = (self._noise * np.sqrt((inverse * inverse).sum(axis=0))).tolist()
        return self._estimate(found, attitude, (sx, sy, sz, 0.0, 0.0, 0.0))

    def _camera(self, row: int, pose: SquarePose) -> tuple[FloatArray, FloatArray]:
        """Place of the camera [m] and rotation from field to optical axes, from one tag."""
        rotation = np.array(pose.rotation).reshape(3, 3) @ self._layout.square_axes[row]
        return self._layout.centers[row] - pose.translation @ rotation, rotation

    def _misfit(self, position: FloatArray, rotation: FloatArray) -> float:
        p = (self._points - position) @ rotation.T
        if p[:, 2].min() < 1e-3:
            return math.inf
        off = (p[:, :2] / p[:, 2:] - self._ideal).ravel()
        return float(off @ off)

    def _from_camera(self, found: CameraSolution) -> PoseEstimate:
        """The robot's pose and how sure it is: the corners' noise, carried through the linearised solution."""
        mounting, back = self._mounting, found.rotation.T
        # A turn w about the optical axes swings the robot's origin about the camera, by R^T (lever x w).
        jacobian = np.zeros((6, 6))
        jacobian[:3, :3] = back @ mounting.lever
        jacobian[:3, 3:] = back
        jacobian[3:5, :3] = mounting.to_optical.T[:2]
        jacobian[5, :3] = back[2]
        part, _ = dtrtrs(found.factor, jacobian.T, trans=1)  # columns: their squares add up to the variances
        sigma = (self._noise * np.sqrt((part * part).sum(axis=0))).tolist()
        roll, pitch, yaw = map(math.degrees, sigma[3:])
        return self._estimate(found, back @ mounting.to_optical, (sigma[0], sigma[1], sigma[2], roll, pitch, yaw))

    def _estimate(
        self, found: CameraSolution, attitude: FloatArray, std: tuple[float, float, float, float, float, float]
    ) -> PoseEstimate:
        x, y, z = (found.position - attitude @ self._mounting.position).tolist()
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
