"""Projection and pose from corners, against OpenCV, which shares no code with ours."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.geometry.rotation import from_rpy, matrix
from simcore.vision.camera import CameraMount, camera_pose, limelight_type, optical_rotation
from simcore.vision.megatag import Mounting, TagPicture
from simcore.vision.tag_layout import official_layout
from simcore.vision.tag_visibility import TagFinder

cv2 = pytest.importorskip("cv2", reason="needs OpenCV: pip install opencv-python-headless")

LAYOUT = official_layout("2026-welded")
MOUNT = CameraMount(x=0.2, y=0.1, z=0.5, roll_deg=3.0, pitch_deg=-15.0, yaw_deg=20.0)
MOUNTING = Mounting.of(MOUNT.position, MOUNT.rotation)


def tuples(corners):
    """Corners as a camera has them: of each tag four pairs of floats."""
    return [tuple(map(tuple, four)) for four in corners.tolist()]


def intrinsics(lens):
    (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
    return np.array([(fx, 0.0, cx), (0.0, fy, cy), (0.0, 0.0, 1.0)])


def views(kind: str, count: int):
    """Random robot poses, also tilted, with what the camera would read there."""
    lens = limelight_type(kind)
    rng = np.random.default_rng(7)
    while count:
        pos = tuple(rng.uniform((0.5, 0.5, 0.0), (16.0, 7.5, 0.1)).tolist())
        quat = from_rpy(*rng.uniform(-0.15, 0.15, 2).tolist(), float(rng.uniform(-math.pi, math.pi)))
        eye, turn = camera_pose(pos, quat, MOUNT.position, MOUNT.rotation)
        rotation = optical_rotation(turn)
        rows, found = TagFinder(LAYOUT, lens).find(eye, rotation, min_side=12.0, max_angle_deg=75.0)
        corners = np.array(found)
        if len(rows):
            count -= 1
            yield lens, pos, quat, np.array(eye), rotation, rows, corners


@pytest.mark.parametrize("kind", ["LL3", "LL4"])
def test_pixels_are_those_of_project_points(kind):
    worst = 0.0
    for lens, _, _, eye, rotation, rows, corners in views(kind, 100):
        turn, _ = cv2.Rodrigues(rotation)
        pixels, _ = cv2.projectPoints(
            LAYOUT.corners[rows].reshape(-1, 3), turn, -rotation @ eye, intrinsics(lens), None
        )
        worst = max(worst, float(np.abs(pixels.reshape(-1, 4, 2) - corners).max()))
    print(f"largest difference {worst:.1e} px")
    assert worst < 1e-6


@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_both_poses_of_a_single_tag_are_those_of_ippe(noise):
    """OpenCV's SOLVEPNP_IPPE_SQUARE finds the same two, also from corners that fit no square."""
    rng = np.random.default_rng(3)
    h = LAYOUT.size / 2.0
    square = np.array([(-h, h, 0.0), (h, h, 0.0), (h, -h, 0.0), (-h, -h, 0.0)])
    compared = 0
    for lens, _, _, _, _, rows, exact in views("LL4", 60):
        corners = exact + noise * rng.standard_normal(exact.shape)
        for tag in TagPicture(LAYOUT, rows, tuples(corners), lens, MOUNTING).tags:
            assert tag.poses is not None
            _, turns, places, _ = cv2.solvePnPGeneric(
                square, tag.corners[[3, 2, 1, 0]], intrinsics(lens), None, flags=cv2.SOLVEPNP_IPPE_SQUARE
            )
            theirs = [(cv2.Rodrigues(r)[0], t.ravel()) for r, t in zip(turns, places, strict=True)]
            for ours in tag.poses:
                rotation = np.array(ours.rotation).reshape(3, 3)
                off = min(
                    max(np.abs(r - rotation).max(), np.abs(t - ours.translation).max() / ours.translation[2])
                    for r, t in theirs
                )
                # OpenCV takes the square's Jacobian from the same homography: equal to rounding.
                assert off < 1e-5
                compared += 1
    assert compared > 200


def test_megatag_1_agrees_with_an_independent_pnp_and_with_the_truth():
    """Without noise: the issue asks for 1 mm and 0.05 degrees."""
    worst_mm = worst_deg = 0.0
    compared = 0
    for lens, pos, quat, _, _, rows, corners in views("LL4", 100):
        found = TagPicture(LAYOUT, rows, tuples(corners), lens, MOUNTING).megatag1()
        assert found is not None
        worst_mm = max(worst_mm, 1e3 * math.dist(found.position, pos))
        turn = matrix(from_rpy(*map(math.radians, (found.roll_deg, found.pitch_deg, found.yaw_deg))))
        cosine = 0.5 * (np.trace(turn.T @ matrix(quat)) - 1.0)
        worst_deg = max(worst_deg, math.degrees(math.acos(min(1.0, cosine))))
        points, pixels = LAYOUT.corners[rows].reshape(-1, 3), corners.reshape(-1, 2)
        ok, r, t = cv2.solvePnP(points, pixels, intrinsics(lens), None, flags=cv2.SOLVEPNP_SQPNP)
        rotation, _ = cv2.Rodrigues(r)
        eye = -rotation.T @ t.ravel()
        ours = np.array(found.position) + turn @ MOUNTING.position
        back, _ = cv2.projectPoints(points, r, t, intrinsics(lens), None)
        if ok and np.abs(back.reshape(-1, 2) - pixels).max() < 1e-3:  # else it found the other one of a tag's two poses
            compared += 1
            assert math.dist(eye, ours) < 1e-3
            assert np.abs(rotation - MOUNTING.to_optical @ turn.T).max() < math.radians(0.05)
    print(f"worst {worst_mm:.1e} mm, {worst_deg:.1e} degrees")
    assert worst_mm < 1.0
    assert worst_deg < 0.05
    assert compared > 80


def test_refinement_ends_where_opencv_ends_with_noise():
    """Several tags, 0.5 px of noise: both least-squares answers are the same to a hundredth of their error."""
    rng = np.random.default_rng(11)
    compared = 0
    for lens, pos, _, _, _, rows, exact in views("LL3", 80):
        if len(rows) < 2:
            continue
        corners = exact + 0.5 * rng.standard_normal(exact.shape)
        found = TagPicture(LAYOUT, rows, tuples(corners), lens, MOUNTING).megatag1()
        assert found is not None
        turn = matrix(from_rpy(*map(math.radians, (found.roll_deg, found.pitch_deg, found.yaw_deg))))
        eye = np.array(found.position) + turn @ MOUNTING.position
        rotation = MOUNTING.to_optical @ turn.T
        start, _ = cv2.Rodrigues(rotation)
        _, r, t = cv2.solvePnP(
            LAYOUT.corners[rows].reshape(-1, 3),
            corners.reshape(-1, 2),
            intrinsics(lens),
            None,
            start.copy(),
            (-rotation @ eye).reshape(3, 1),
            useExtrinsicGuess=True,
            flags=cv2.SOLVEPNP_ITERATIVE,
        )
        theirs = -cv2.Rodrigues(r)[0].T @ t.ravel()
        assert math.dist(theirs, eye) < 0.05 * math.dist(found.position, pos) + 1e-3
        compared += 1
    assert compared >= 20
