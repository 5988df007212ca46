"""Estimation of tag poses and of the robot pose from tag corners, by MegaTag 1 (image alone) or 2 (known heading).

The modeled result of a solver is the true pose plus the effect of the corner errors in the linearized projection.
With the Jacobian J (8 x 6) of a tag's corners with respect to its pose, corner errors e move the least-squares pose by
(J^T J)^-1 J^T e, with covariance s^2 (J^T J)^-1 for noise s in each direction. Source: R. Hartley, A. Zisserman,
"Multiple View Geometry in Computer Vision", sections 5.2 and A6.

Corners are in ideal coordinates: pixels from the principal point, divided by the focal length. A change of a tag's pose
is a rotation w about the tag's center m and a translation v, in optical axes: a point m + a moves to
m + a + w x a + v.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simcore.typing import FloatArray, IntArray
from simcore.vision.camera import OPTICAL, LimelightType, quad_area
from simcore.vision.camera_frame import PoseEstimate, StdDevs, TagPose, TagSighting, as_pixels
from simcore.vision.tag_layout import TagLayout, cross_matrices, rotation_matrices
from simcore.world.rotation import Quaternion, Vector, matrix

__all__ = ["Mounting", "TagPicture", "flip_pose", "solve_tags"]

_NEAR = 0.01  # [m]; smallest depth of a corner: the flipped pose of a near tag can have corners behind the lens
_EXACT = 1e-20  # [-]; square of the rounding error of corners without noise
_IDENTITY: FloatArray = np.eye(3)
_HALF_TURN: FloatArray = np.diag([-1.0, -1.0, 1.0])  # half turn of a tag about the normal of the tag's face


@dataclass(frozen=True, slots=True, eq=False)
class Mounting:
    """Configured pose of a camera on the robot."""

    position: FloatArray
    """Position in the robot frame [m], shape (3,)."""
    to_optical: FloatArray
    """Rotation from robot to optical axes, shape (3, 3)."""

    @classmethod
    def of(cls, position: Vector, rotation: Quaternion) -> Mounting:
        """Create a mounting from position [m] and attitude (camera to robot axes), robot frame."""
        return cls(np.array(position), OPTICAL @ matrix(rotation).T)


def flip_pose(rotations: FloatArray, places: FloatArray) -> FloatArray:
    """Compute a second attitude of each tag that projects to nearly the same image.

    The second normal is the first normal mirrored at the line of sight. The rotation is half a turn in the plane of the
    tag, then half a turn about the line of sight. In weak perspective, the two images are equal. Source: D. Oberkampf,
    D. DeMenthon, L. Davis, "Iterative Pose Estimation Using Coplanar Feature Points", CVIU 63 (1996).

    Args:
        rotations: Rotations from tag face axes (right, up, out of the face) to optical axes, shape (k, 3, 3).
        places: Centers of the tags, optical frame [m], shape (k, 3).

    Returns:
        Rotations from tag face axes to optical axes in the second attitude, shape (k, 3, 3).
    """
    sight = places / _lengths(places)[:, None]
    mirrored: FloatArray = (2.0 * sight[:, :, None] * sight[:, None, :] - _IDENTITY) @ rotations @ _HALF_TURN
    return mirrored


def solve_tags(
    rotations: FloatArray, places: FloatArray, seen: FloatArray, size: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Compute one Gauss-Newton step for the pose of each tag separately.

    Args:
        rotations: Initial rotation of each tag, from face axes to optical axes, shape (..., 3, 3).
        places: Initial center of each tag, optical frame [m], shape (..., 3).
        seen: Detected corners in ideal coordinates [-], shape (..., 4, 2).
        size: Edge length of a tag [m].

    Returns:
        J^T J, shape (..., 6, 6); J^T e, shape (..., 6); step with rotation [rad] and translation [m], shape (..., 6);
        and remaining sum of squared corner errors [-], shape (...).
    """
    half = 0.5 * size
    square = np.array([(-half, -half, 0.0), (half, -half, 0.0), (half, half, 0.0), (-half, half, 0.0)])
    arms = square @ rotations.swapaxes(-1, -2)
    corners = arms + places[..., None, :]
    inverse = 1.0 / np.maximum(corners[..., 2:], _NEAR)
    ideal = corners[..., :2] * inverse
    # d(x / z) is the product of (1, 0, -x / z) / z and the displacement of a corner, v - a x w.
    by_step = np.zeros((*ideal.shape, 3))
    by_step[..., 0, 0] = by_step[..., 1, 1] = inverse[..., 0]
    by_step[..., 2] = -ideal * inverse
    by_turn = -by_step @ cross_matrices(arms)
    jacobian = np.concatenate((by_turn, by_step), axis=-1).reshape(*ideal.shape[:-2], 8, 6)
    error = (seen - ideal).reshape(*jacobian.shape[:-1], 1)
    transposed = jacobian.swapaxes(-1, -2)
    normal, right = transposed @ jacobian, (transposed @ error)[..., 0]
    step = np.linalg.solve(normal, right[..., None])[..., 0]
    left = (error[..., 0] ** 2).sum(-1) - (step * right).sum(-1)
    return normal, right, step, np.maximum(left, 0.0)


class TagPicture:
    """Visible tags of a frame, with the poses of the tags and of the robot estimated from the tag corners.

    Two poses of a single tag fit the corners about equally well: the true pose and the pose of `flip_pose`. The solver
    chooses the better fit, so noise can flip the pose of a small or frontal tag. The ambiguity of a tag is the ratio of
    the two reprojection errors, as defined in PhotonVision's documentation ("3D Tracking").

    Args:
        layout: All tags at the nominal poses, which robot code and the camera assume.
        true_layout: All tags at the true poses.
        offsets: True poses relative to nominal poses: rotation [rad] and translation [m], field axes, shape (n, 6).
        rows: Indices of the k visible tags in the arrays of the layouts, k >= 1.
        pixels: Detected corners of the visible tags [px], shape (k, 4, 2).
        eye: True position of the camera, field frame [m].
        rotation: Rotation from field to true optical axes, shape (3, 3).
        lens: Camera model with the nominal focal length.
        mounting: Configured pose of the camera.
    """

    def __init__(
        self,
        layout: TagLayout,
        true_layout: TagLayout,
        offsets: FloatArray,
        rows: Sequence[int],
        pixels: FloatArray,
        eye: Vector,
        rotation: FloatArray,
        lens: LimelightType,
        mounting: Mounting,
    ) -> None:
        focal_length, principal_point = np.array(lens.focal_length), np.array(lens.principal_point)
        self._layout, self._rows, self._mounting = layout, np.array(rows), mounting
        self._noise = lens.corner_noise / math.sqrt(lens.focal_length[0] * lens.focal_length[1])
        self._eye, self._rotation = np.array(eye), rotation
        self._seen = (pixels - principal_point) / focal_length
        offsets = offsets[self._rows]
        true = rotation @ true_layout.square_axes[self._rows].swapaxes(1, 2)
        self._places = (true_layout.centers[self._rows] - self._eye) @ rotation.T
        start = np.array((true, flip_pose(true, self._places)))
        normal, right, step, left = solve_tags(start, self._places, self._seen, layout.size)
        # A tilt by an angle a shortens a tag by a^2 / 2, in any direction; noise s hides tilts up to sqrt(2 s z / h).
        hidden = 4.0 * self._noise / layout.size * self._places[:, 2]
        turned = (step[..., :3] ** 2).sum(axis=-1)
        step[..., :3] *= np.sqrt(hidden / (hidden + turned + _EXACT))[..., None]
        better = np.argmin(left, axis=0)
        order = np.array((better, 1 - better)), np.arange(len(better))
        self._turns = (rotation_matrices(step[..., :3]) @ start)[order]
        self._found = (self._places + step[..., 3:])[order]
        least, most = left[order]
        doubt = np.sqrt((least + _EXACT) / (most + _EXACT))
        # Normal equations of the camera: its rotation w and step s, optical axes, move a tag by -w and m x w - s.
        by_camera = np.zeros((len(better), 6, 6))
        by_camera[:, :3, :3] = by_camera[:, 3:, 3:] = -_IDENTITY
        by_camera[:, 3:, :3] = cross_matrices(self._places)
        misplaced = (offsets.reshape(-1, 2, 3) @ rotation.T).reshape(-1, 6, 1)
        right = right[0, :, :, None] + normal[0] @ misplaced
        back = by_camera.swapaxes(1, 2)
        self._normal = (back @ normal[0] @ by_camera).sum(axis=0)
        self._right = (back @ right).sum(axis=0)[:, 0]
        if len(better) == 1 and self._noise > 0.0:
            self._normal[:3, :3] += self._noise**2 / hidden[0] * _IDENTITY
        self.tags = self._sightings(pixels, lens, doubt)
        """Detections of the visible tags, in the order of `rows`; the pose of each tag is solved separately."""
        self._statistics = _statistics(layout, self._rows, self.tags)

    def _sightings(self, pixels: FloatArray, lens: LimelightType, doubt: FloatArray) -> tuple[TagSighting, ...]:
        middle = (pixels.mean(axis=1) - lens.principal_point) / lens.focal_length
        tx, ty = np.degrees(np.arctan(middle.T)).tolist()
        area = (100.0 / (lens.width * lens.height) * np.abs(quad_area(pixels))).tolist()
        best = self._found[0]
        near = _lengths(best).tolist()
        far = _lengths(best @ self._mounting.to_optical + self._mounting.position).tolist()
        turns, places = self._turns.tolist(), self._found.tolist()
        ids = self._layout.ids[self._rows].tolist()
        return tuple(
            TagSighting(
                ids[k], as_pixels(pixels[k]), tx[k], -ty[k], area[k], near[k], far[k], float(doubt[k]),
                (TagPose(turns[0][k], places[0][k]), TagPose(turns[1][k], places[1][k])),
            )
            for k in range(len(ids))
        )  # fmt: skip

    def megatag1(self) -> PoseEstimate:
        """Estimate the robot pose from the image alone.

        The estimate uses the better pose of a single tag, or a least-squares fit to several tags.
        """
        covariance = np.linalg.inv(self._normal)
        if len(self._rows) == 1:
            row = self._rows[0]
            rotation = self._turns[0, 0] @ self._layout.square_axes[row]
            eye = self._layout.centers[row] - self._found[0, 0] @ rotation
        else:
            step = covariance @ self._right
            rotation = rotation_matrices(-step[:3]) @ self._rotation
            eye = self._eye + step[3:] @ rotation
        to_optical, position = self._mounting.to_optical, self._mounting.position
        # Robot: x, y, z from s + lever x w in field axes; roll and pitch about robot axes, yaw about the field z axis.
        lever = cross_matrices(to_optical @ position)
        back = rotation.T
        by_camera = np.zeros((6, 6))
        by_camera[:3, :3], by_camera[:3, 3:] = back @ lever, back
        by_camera[3:, :3] = to_optical[:, 0], to_optical[:, 1], back[2]
        deviations = self._noise * np.sqrt(np.einsum("ij,jk,ik->i", by_camera, covariance, by_camera))
        deviations[3:] = np.degrees(deviations[3:])
        return self._estimate(eye, back @ to_optical, deviations)

    def megatag2(self, attitude: FloatArray) -> PoseEstimate | None:
        """Estimate the robot position by linear least squares, with the attitude from robot code or the camera's IMU.

        For a camera at c with the rotation R and t = -R c, a corner X at the image point (x, y) satisfies
        t_x - x t_z = x p_z - p_x with p = R X, and the analogous equation for y. The error of this equation divided by
        the depth is a distance in the image.

        Args:
            attitude: Rotation from robot to field axes, shape (3, 3); an attitude error causes a position error.

        Returns:
            Estimate; None if the solution puts a tag behind the camera, because of a large attitude error.
        """
        rotation = self._mounting.to_optical @ attitude.T
        points = (self._layout.corners[self._rows] @ rotation.T).reshape(-1, 3)
        seen = self._seen.reshape(-1, 2)
        rows = np.zeros((len(seen), 2, 3))
        rows[:, 0, 0] = rows[:, 1, 1] = 1.0
        rows[:, :, 2] = -seen
        weights = (np.repeat(self._places[:, 2], 8) ** -1.0)[:, None]
        right = weights * (seen * points[:, 2:] - points[:, :2]).reshape(-1, 1)
        rows = weights * rows.reshape(-1, 3)
        covariance = np.linalg.inv(rows.T @ rows)
        step = (covariance @ (rows.T @ right))[:, 0]
        if (points[:, 2] + step[2]).min() <= 0.0:
            return None
        deviations = np.zeros(6)
        deviations[:3] = self._noise * np.sqrt(np.einsum("ji,jk,ki->i", rotation, covariance, rotation))
        return self._estimate(-step @ rotation, attitude, deviations)

    def _estimate(self, eye: FloatArray, attitude: FloatArray, deviations: FloatArray) -> PoseEstimate:
        x, y, z = (eye - attitude @ self._mounting.position).tolist()
        (a, _, _), (b, _, _), (c, d, e) = attitude.tolist()
        std: StdDevs = tuple(deviations.tolist())
        return PoseEstimate(
            (x, y, z),
            math.degrees(math.atan2(d, e)),
            math.degrees(math.asin(max(-1.0, min(1.0, -c)))),
            math.degrees(math.atan2(b, a)),
            *self._statistics,
            std,
        )


def _lengths(vectors: FloatArray) -> FloatArray:
    lengths: FloatArray = np.sqrt((vectors * vectors).sum(axis=1))
    return lengths


def _statistics(layout: TagLayout, rows: IntArray, tags: Sequence[TagSighting]) -> tuple[int, float, float, float]:
    """Compute the number, largest mutual distance [m], average distance [m] and average area [%] of the tags."""
    centers, n = layout.centers[rows], len(tags)
    span = _lengths((centers[:, None, :] - centers).reshape(-1, 3)).max()
    return n, float(span), sum(t.camera_distance for t in tags) / n, sum(t.area_percent for t in tags) / n
