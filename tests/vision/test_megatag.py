"""Projection and linearized poses agree with OpenCV, which shares no code with simcore and solves each image."""

import math

import numpy as np
import pytest

from simcore.vision.camera import CameraMount, camera_pose, limelight_type, optical_rotation
from simcore.vision.megatag import Mounting, TagPicture
from simcore.vision.tag_layout import official_layout
from simcore.vision.tag_visibility import find_tags
from simcore.world.rotation import from_rpy, matrix

cv2 = pytest.importorskip("cv2", reason="needs OpenCV: pip install opencv-python-headless")

LAYOUT = official_layout("2026-welded")
EXACT = np.zeros((len(LAYOUT.ids), 6))
MOUNT = CameraMount(x=0.2, y=0.1, z=0.5, roll_deg=3.0, pitch_deg=-15.0, yaw_deg=20.0)
MOUNTING = Mounting.of(MOUNT.position, MOUNT.rotation)


def intrinsics(lens):
    (fx, fy), (cx, cy) = lens.focal_length, lens.principal_point
    return np.array([(fx, 0.0, cx), (0.0, fy, cy), (0.0, 0.0, 1.0)])


def views(kind: str, count: int, min_side: float = 12.0):
    """Yield random robot poses, some of them tilted, with the tag corners that the camera reads."""
    lens = limelight_type(kind)
    rng = np.random.default_rng(7)
    while count:
        pos = tuple(rng.uniform((0.5, 0.5, 0.0), (16.0, 7.5, 0.1)).tolist())
        quat = from_rpy(*rng.uniform(-0.15, 0.15, 2).tolist(), float(rng.uniform(-math.pi, math.pi)))
        eye, turn = camera_pose(pos, quat, MOUNT.position, MOUNT.rotation)
        rotation = optical_rotation(turn)
        rows, corners = find_tags(LAYOUT, lens, eye, rotation, min_side=min_side, max_angle_deg=75.0)
        if len(rows):
            count -= 1
            yield lens, pos, quat, eye, rotation, rows, corners


def solved(lens, rows, corners, eye, rotation):
    """Return OpenCV's camera position and rotation from field to optical axes, iterated from the true pose."""
    start, _ = cv2.Rodrigues(rotation)
    points = LAYOUT.corners[rows].reshape(-1, 3)
    way = (-rotation @ eye).reshape(3, 1)
    _, r, t = cv2.solvePnP(
        points, corners.reshape(-1, 2), intrinsics(lens), None, start, way, True, cv2.SOLVEPNP_ITERATIVE
    )
    turn, _ = cv2.Rodrigues(r)
    return -turn.T @ t.ravel(), turn


def megatag1(lens, rows, corners, eye, rotation):
    """Return simcore's camera position, rotation from field to optical axes, and MegaTag 1 estimate."""
    found = TagPicture(LAYOUT, LAYOUT, EXACT, rows, corners, eye, rotation, lens, MOUNTING).megatag1()
    turn = matrix(from_rpy(*map(math.radians, (found.roll_deg, found.pitch_deg, found.yaw_deg))))
    return np.array(found.position) + turn @ MOUNTING.position, MOUNTING.to_optical @ turn.T, found


@pytest.mark.parametrize("kind", ["LL3", "LL4"])
def test_pixels_agree_with_the_projection_of_opencv(kind):
    worst = 0.0
    for lens, _, _, eye, rotation, rows, corners in views(kind, 100):
        turn, _ = cv2.Rodrigues(rotation)
        pixels, _ = cv2.projectPoints(
            LAYOUT.corners[rows].reshape(-1, 3), turn, -rotation @ eye, intrinsics(lens), None
        )
        worst = max(worst, float(np.abs(pixels.reshape(-1, 4, 2) - corners).max()))
    print(f"largest difference {worst:.1e} px")
    assert worst < 1e-6


def test_the_pose_from_several_tags_agrees_with_opencv():
    """The linearization leaves out terms of second order, about d^2 for a turn by d: some hundredths of d."""
    rng = np.random.default_rng(11)
    shares = []
    for lens, _, _, eye, rotation, rows, exact in views("LL3", 80):
        if len(rows) > 1:
            corners = exact + lens.corner_noise * rng.standard_normal(exact.shape)
            theirs, _ = solved(lens, rows, corners, eye, rotation)
            ours, _, _ = megatag1(lens, rows, corners, eye, rotation)
            shares.append(math.dist(ours, theirs) / math.dist(theirs, eye))
    half, most = np.percentile(shares, (50, 90))  # small far tags can make OpenCV end in another minimum
    print(f"{len(shares)} pictures: differ by {half:.4f} of the error, nine of ten by less than {most:.3f}")
    assert len(shares) >= 20
    assert half < 0.02 and most < 0.1


def test_the_standard_deviations_match_the_spread_of_opencv_solutions():
    """A deviation from 400 pictures is known to 3.5 %; the limit is four times 3.5 %, plus 2 % for nonlinearity."""
    rng = np.random.default_rng(5)
    compared = 0
    for lens, _, _, eye, rotation, rows, exact in views("LL4", 12, min_side=40.0):
        if compared == 6:
            break
        *_, found = megatag1(lens, rows, exact, eye, rotation)
        robots = []
        for _ in range(400):
            corners = exact + lens.corner_noise * rng.standard_normal(exact.shape)
            place, turn = solved(lens, rows, corners, eye, rotation)
            attitude = turn.T @ MOUNTING.to_optical
            robots.append((*(place - attitude @ MOUNTING.position), math.atan2(attitude[1, 0], attitude[0, 0])))
        theirs = np.std(robots, axis=0)
        ours = (*found.std_devs[:3], math.radians(found.std_devs[5]))
        assert theirs == pytest.approx(ours, rel=0.16), f"{len(rows)} tags"
        compared += 1
    assert compared == 6


def test_both_poses_of_a_tag_and_their_ambiguity_agree_with_ippe():
    """The reference is OpenCV's SOLVEPNP_IPPE_SQUARE, refined by least squares, for tags wider than 30 px."""
    rng = np.random.default_rng(3)
    h = LAYOUT.size / 2.0
    square = np.array([(-h, h, 0.0), (h, h, 0.0), (h, -h, 0.0), (-h, -h, 0.0)])
    angles, ways, doubts = [], [], []
    for lens, _, _, eye, rotation, rows, exact in views("LL4", 120, min_side=30.0):
        corners = exact + lens.corner_noise * rng.standard_normal(exact.shape)
        picture = TagPicture(LAYOUT, LAYOUT, EXACT, rows, corners, eye, rotation, lens, MOUNTING)
        for tag in picture.tags:
            pixels, camera = tag.corners[[3, 2, 1, 0]], intrinsics(lens)
            _, turns, places, _ = cv2.solvePnPGeneric(square, pixels, camera, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
            theirs = []
            for r, t in zip(turns, places, strict=True):
                r, t = cv2.solvePnPRefineLM(square, pixels, camera, None, r.copy(), t.copy())
                back, _ = cv2.projectPoints(square, r, t, camera, None)
                theirs.append((float(np.linalg.norm(back[:, 0] - pixels)), cv2.Rodrigues(r)[0], t.ravel()))
            theirs.sort(key=lambda answer: answer[0])
            for (_, turn, place), ours in zip(theirs, tag.poses, strict=True):
                cosine = 0.5 * (np.trace(turn.T @ np.array(ours.rotation)) - 1.0)
                angles.append(math.degrees(math.acos(max(-1.0, min(1.0, cosine)))))
                ways.append(math.dist(place, ours.translation) / ours.translation[2])
            doubts.append((tag.ambiguity, theirs[0][0] / theirs[1][0]))
    ours, theirs = np.array(doubts).T
    off = [np.percentile(some, (50, 90)) for some in (angles, ways, np.abs(ours - theirs))]
    print(f"{len(ours)} tags: angles [deg], ways [of the distance], ambiguity: {off}")
    assert len(ours) > 150
    for (half, most), (half_limit, most_limit) in zip(off, ((0.02, 0.5), (1e-4, 1e-3), (2e-3, 2e-2)), strict=True):
        assert half < half_limit and most < most_limit
