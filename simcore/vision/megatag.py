"""From the corners of tags to the robot's pose: MegaTag 1 (everything from the picture) and 2 (heading from a gyro)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simcore.geometry.quaternion import Quaternion, Vector, matrix
from simcore.typing import FloatArray, IntArray
from simcore.vision.camera import LimelightType
from simcore.vision.frames import PoseEstimate, TagSighting
from simcore.vision.planar_pose import SquarePose, ambiguity, solve_square
from simcore.vision.projection import OPTICAL, angles_deg, quad_area
from simcore.vision.refine import CameraSolution, refine_pose, solve_position
from simcore.vision.tags import TagLayout

__all__ = ["Mounting", "megatag1", "megatag2", "sight_tags"]

_SQUARE_AXES = (1, 2, 0)  # a square's x, y, z are a tag's y, z, x


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


def sight_tags(
    layout: TagLayout, rows: IntArray, corners: FloatArray, lens: LimelightType, mounting: Mounting
) -> tuple[TagSighting, ...]:
    """Each tag by itself: its angles, its two poses and how far away it is.

    Args:
        layout: All tags.
        rows: Which ones are seen, shape (k,).
        corners: Their corners as detected [px], shape (k, 4, 2).
        lens: The picture.
        mounting: Where the camera believes to sit.
    """
    areas = (100.0 / (lens.width * lens.height) * np.abs(quad_area(corners))).tolist()
    middles = corners.mean(axis=1).tolist()
    ideal = ((corners - lens.principal_point) / lens.focal_length).tolist()
    found = []
    for k, row in enumerate(rows.tolist()):
        poses = solve_square(ideal[k], layout.size)
        near = far = 0.0
        if poses is not None:
            t = poses[0].translation
            near = math.sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
            far = float(np.linalg.norm(mounting.to_optical.T @ t + mounting.position))
        tx, ty = angles_deg(*middles[k], lens)
        found.append(
            TagSighting(
                int(layout.ids[row]), corners[k], tx, ty, areas[k], near, far,
                1.0 if poses is None else ambiguity(poses), poses,
            )
        )  # fmt: skip
    return tuple(found)


def megatag1(
    layout: TagLayout,
    rows: IntArray,
    tags: Sequence[TagSighting],
    corners: FloatArray,
    lens: LimelightType,
    mounting: Mounting,
) -> PoseEstimate | None:
    """Pose from the picture alone. One tag gives the better of its two poses, which may be the wrong one.

    With several tags both poses of the largest are tried against all corners.
    """
    largest = max(range(len(tags)), key=lambda k: tags[k].area_percent, default=None)
    if largest is None or tags[largest].poses is None:
        return None
    points = layout.corners[rows].reshape(-1, 3)
    pixels = (corners - lens.principal_point).reshape(-1, 2)
    poses = tags[largest].poses
    assert poses is not None
    guesses = [_camera_from_square(layout, int(rows[largest]), pose) for pose in poses]
    if len(tags) > 1 and _misfit(points, pixels, lens, *guesses[1]) < _misfit(points, pixels, lens, *guesses[0]):
        guesses.reverse()
    found = refine_pose(points, pixels, lens.focal_length, *guesses[0])
    if found is None:
        return None
    return _estimate(layout, rows, tags, lens, mounting, found, found.rotation.T @ mounting.to_optical)


def megatag2(
    layout: TagLayout,
    rows: IntArray,
    tags: Sequence[TagSighting],
    corners: FloatArray,
    lens: LimelightType,
    mounting: Mounting,
    attitude: FloatArray,
) -> PoseEstimate | None:
    """Place from the picture, with the attitude that the robot (or the camera's IMU) says it has.

    Args:
        layout: All tags.
        rows: Which ones are seen, shape (k,).
        tags: What was found of each.
        corners: Their corners [px], shape (k, 4, 2).
        lens: The picture.
        mounting: Where the camera believes to sit.
        attitude: From robot to field axes, shape (3, 3). A wrong one gives a wrong place.
    """
    if not len(tags):
        return None
    points = layout.corners[rows].reshape(-1, 3)
    pixels = (corners - lens.principal_point).reshape(-1, 2)
    found = solve_position(points, pixels, lens.focal_length, mounting.to_optical @ attitude.T)
    return None if found is None else _estimate(layout, rows, tags, lens, mounting, found, attitude)


def _camera_from_square(layout: TagLayout, row: int, pose: SquarePose) -> tuple[FloatArray, FloatArray]:
    """Place of the camera [m] and rotation from field to optical axes."""
    rotation = pose.rotation @ layout.rotations[row][:, _SQUARE_AXES].T
    return layout.centers[row] - rotation.T @ np.array(pose.translation), rotation


def _misfit(
    points: FloatArray, pixels: FloatArray, lens: LimelightType, position: FloatArray, rotation: FloatArray
) -> float:
    p = (points - position) @ rotation.T
    if p[:, 2].min() < 1e-3:
        return math.inf
    off = p[:, :2] / p[:, 2:] * lens.focal_length - pixels
    return float(np.einsum("ij,ij->", off, off))


def _estimate(
    layout: TagLayout,
    rows: IntArray,
    tags: Sequence[TagSighting],
    lens: LimelightType,
    mounting: Mounting,
    found: CameraSolution,
    attitude: FloatArray,
) -> PoseEstimate:
    """The robot's pose from the camera's, and its standard deviations."""
    place = found.position - attitude @ mounting.position
    r = attitude.tolist()
    noise = lens.corner_noise
    if len(found.covariance) == 6:
        # A turn w about the optical axes swings the robot's origin about the camera, by R^T (lever x w).
        back = found.rotation.T
        jacobian = np.zeros((6, 6))
        jacobian[:3, :3] = back @ mounting.lever
        jacobian[:3, 3:] = np.eye(3)
        jacobian[3:5, :3] = mounting.to_optical.T[:2]
        jacobian[5, :3] = back[2]
        variance = np.einsum("ij,jk,ik->i", jacobian, found.covariance, jacobian)
        sigma = (noise * np.sqrt(variance)).tolist()
        std = (sigma[0], sigma[1], sigma[2], *(math.degrees(s) for s in sigma[3:]))
    else:
        sigma = (noise * np.sqrt(np.diagonal(found.covariance))).tolist()
        std = (sigma[0], sigma[1], sigma[2], 0.0, 0.0, 0.0)
    n = len(tags)
    return PoseEstimate(
        position=(float(place[0]), float(place[1]), float(place[2])),
        roll_deg=math.degrees(math.atan2(r[2][1], r[2][2])),
        pitch_deg=math.degrees(math.asin(max(-1.0, min(1.0, -r[2][0])))),
        yaw_deg=math.degrees(math.atan2(r[1][0], r[0][0])),
        tag_count=n,
        tag_span=_span(layout.centers[rows]),
        average_distance=sum(tag.camera_distance for tag in tags) / n,
        average_area=sum(tag.area_percent for tag in tags) / n,
        std_devs=(std[0], std[1], std[2], std[3], std[4], std[5]),
    )


def _span(centers: FloatArray) -> float:
    if len(centers) < 2:
        return 0.0
    apart = centers[:, None, :] - centers[None, :, :]
    return math.sqrt(float(np.einsum("ijk,ijk->ij", apart, apart).max()))
