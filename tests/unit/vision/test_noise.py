"""How pose errors grow with distance, and whether the published standard deviations tell the truth about them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.geometry.rotation import from_yaw, matrix
from simcore.vision.camera import CameraMount, camera_pose, limelight_type, optical_rotation
from simcore.vision.megatag import Mounting, TagPicture
from simcore.vision.tag_layout import TagLayout
from simcore.vision.tag_visibility import TagFinder

LENS = limelight_type("LL4")
MOUNT = CameraMount(x=0.1, z=0.6, pitch_deg=-5.0)
MOUNTING = Mounting.of(MOUNT.position, MOUNT.rotation)
DISTANCES = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)


def layout(*tags: tuple[int, tuple[float, float, float]]) -> TagLayout:
    return TagLayout.of([(n, place, from_yaw(math.pi)) for n, place in tags], field_size=(16.0, 8.0))


ONE = layout((1, (10.0, 4.0, 0.9)))
TWO = layout((1, (10.0, 3.7, 0.9)), (2, (10.0, 4.3, 1.1)))


def errors(tags: TagLayout, distance: float, frames: int, yaw: float = 0.0, off: float = 0.7, seed: int = 0):
    """Errors and standard deviations of x, y, yaw in MegaTag 1 and of x, y in MegaTag 2, a row a frame."""
    rng = np.random.default_rng(seed)
    finder = TagFinder(tags, LENS)
    one, two = [], []
    for _ in range(frames):
        pos = (10.0 - distance - 0.1, 4.0 - off + float(rng.uniform(-0.2, 0.2)), 0.0)
        quat = from_yaw(yaw + math.atan2(off, distance))
        eye, turn = camera_pose(pos, quat, MOUNT.position, MOUNT.rotation)
        rows, exact = finder.find(eye, optical_rotation(turn), min_side=8.0, max_angle_deg=75.0)
        assert len(rows) == len(tags.ids)
        corners = np.array(exact) + LENS.corner_noise * rng.standard_normal((len(rows), 4, 2))
        quads = [tuple(map(tuple, four)) for four in corners.tolist()]
        picture = TagPicture(tags, rows, quads, LENS, MOUNTING)
        first, second = picture.megatag1(), picture.megatag2(matrix(quat))
        assert first is not None and second is not None
        x, y = pos[:2]
        turned = math.remainder(first.yaw_deg - math.degrees(math.atan2(off, distance)) - math.degrees(yaw), 360.0)
        s = first.std_devs
        one.append((first.position[0] - x, first.position[1] - y, turned, s[0], s[1], s[5]))
        two.append((second.position[0] - x, second.position[1] - y, second.std_devs[0], second.std_devs[1]))
    return np.array(one), np.array(two)


def test_errors_grow_with_the_square_of_the_distance():
    """Depth is a length in the picture: sigma_z ~ z^2. MegaTag 2 leaves the direction to the gyro and grows so in range
    too, but is several times better for one tag, whose own attitude tells little.
    """
    print("distance, MegaTag 1 (two tags), MegaTag 2 (one tag): median error in the plane [m]")
    first, second = [], []
    for distance in DISTANCES:
        one, _ = errors(TWO, distance, 150)
        _, two = errors(ONE, distance, 150)
        first.append(float(np.median(np.hypot(one[:, 0], one[:, 1]))))
        second.append(float(np.median(np.hypot(two[:, 0], two[:, 1]))))
        print(f"{distance:.0f} m   {first[-1]:.4f}   {second[-1]:.4f}")
    for grown in (first, second):
        power = np.polyfit(np.log(DISTANCES), np.log(grown), 1)[0]
        assert 1.5 < power < 2.5
        assert grown[-1] > 10.0 * grown[0]


def test_a_single_tag_seen_head_on_flips_and_an_oblique_one_does_not():
    """Head on, both poses of a small square fit about as well, and noise decides."""
    far, _ = errors(ONE, 5.0, 200, off=0.0)
    near, _ = errors(ONE, 1.0, 200, off=0.9)
    flipped = np.hypot(far[:, 0], far[:, 1]) > 0.5
    assert 0.1 < flipped.mean() < 0.7
    assert (np.hypot(near[:, 0], near[:, 1]) < 0.05).all()


@pytest.mark.parametrize("distance", [1.0, 2.0, 4.0, 6.0])
def test_published_standard_deviations_cover_the_true_error(distance):
    """One sigma covers 68 % of a normal error; the issue asks for 60 to 80 %."""
    one, two = errors(TWO, distance, 400, seed=1)
    for name, error, sigma in (
        ("x, MegaTag 1", one[:, 0], one[:, 3]),
        ("y, MegaTag 1", one[:, 1], one[:, 4]),
        ("yaw, MegaTag 1", one[:, 2], one[:, 5]),
        ("x, MegaTag 2", two[:, 0], two[:, 2]),
        ("y, MegaTag 2", two[:, 1], two[:, 3]),
    ):
        covered = float((np.abs(error) < sigma).mean())
        print(f"{distance:.0f} m, {name}: {100 * covered:.0f} % within one sigma of {np.median(sigma):.4f}")
        assert 0.60 < covered < 0.80


def test_a_wrong_heading_gives_a_wrong_place():
    """MegaTag 2 turned by 10 degrees about a tag 3 m away lands 3 m x 2 sin(5 deg) = 0.52 m beside the truth."""
    finder = TagFinder(ONE, LENS)
    pos, quat = (6.9, 4.0, 0.0), from_yaw(0.0)
    eye, turn = camera_pose(pos, quat, MOUNT.position, MOUNT.rotation)
    rows, exact = finder.find(eye, optical_rotation(turn), min_side=8.0, max_angle_deg=75.0)
    picture = TagPicture(ONE, rows, exact, LENS, MOUNTING)
    right, wrong = picture.megatag2(matrix(quat)), picture.megatag2(matrix(from_yaw(math.radians(10.0))))
    assert right is not None and wrong is not None
    assert math.dist(right.position, pos) < 1e-9
    assert math.dist(wrong.position[:2], pos[:2]) == pytest.approx(3.1 * 2.0 * math.sin(math.radians(5.0)), rel=0.03)
    assert wrong.yaw_deg == pytest.approx(10.0)
