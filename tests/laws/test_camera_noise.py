"""Pose errors of cameras: closed forms of the linearized projection, a measured Limelight and ambiguous poses."""

import math

import numpy as np
import pytest
from each_case import each

from simcore.vision.camera import CameraBias, CameraConfig, CameraMount, camera_pose, limelight_type, optical_rotation
from simcore.vision.camera_scene import CameraScene
from simcore.vision.heading import PoseHistory
from simcore.vision.limelight import CameraRequest, LimelightSim
from simcore.vision.megatag import Mounting, TagPicture
from simcore.vision.tag_layout import TagLayout
from simcore.vision.tag_visibility import find_tags
from simcore.world.rotation import from_yaw, matrix

pytestmark = pytest.mark.engines("bullet")

LENS = limelight_type("LL4")
NOISE = LENS.corner_noise / math.sqrt(LENS.focal_length[0] * LENS.focal_length[1])
MOUNT = CameraMount(x=0.1, z=0.6, pitch_deg=-5.0)


def layout(*tags: tuple[int, tuple[float, float, float]]) -> TagLayout:
    return TagLayout.of([(n, place, from_yaw(math.pi)) for n, place in tags], field_size=(16.0, 8.0))


ONE = layout((1, (10.0, 4.0, 0.9)))
TWO = layout((1, (10.0, 3.7, 0.9)), (2, (10.0, 4.3, 1.1)))
HALF = 0.5 * ONE.size


def picture(tags, pos, yaw, mount=MOUNT, rng=None, lens=LENS):
    """Return a frame, with pixel noise if a generator is given."""
    eye, turn = camera_pose(pos, from_yaw(yaw), mount.position, mount.rotation)
    rotation = optical_rotation(turn)
    rows, pixels = find_tags(tags, lens, eye, rotation, min_side=8.0, max_angle_deg=75.0)
    assert len(rows) == len(tags.ids)
    if rng is not None:
        pixels = pixels + lens.corner_noise * rng.standard_normal(pixels.shape)
    exact = np.zeros((len(tags.ids), 6))
    return TagPicture(tags, tags, exact, rows, pixels, eye, rotation, lens, Mounting.of(mount.position, mount.rotation))


@each("distance", [1.0, 2.0, 4.0])
def test_deviations_of_a_frontal_tag_agree_with_the_linearized_projection(distance):
    """Compare standard deviations with the linearized projection of corners at (+-h, +-h) in depth z.

    A step along z moves each corner by h z'/z^2 in u and in v, eight values: s z^2 / (h sqrt(8)). A turn about the
    vertical moves u of all corners equally, like a step, and v by +-h^2/z^2, four values: s z^2 / (2 h^2). The square
    of the turn matters where it moves a corner by s: at sqrt(2 s z / h). The error is of order (h / z)^2, 0.7 % at 1 m.
    """
    low = layout((1, (10.0, 4.0, 0.0)))  # lens at the robot's origin: no turn of the robot moves it
    found = picture(low, (10.0 - distance, 4.0, 0.0), 0.0, CameraMount()).megatag1()
    x, _, _, _, _, yaw_deg = found.std_devs
    assert x == pytest.approx(NOISE * distance**2 / (HALF * math.sqrt(8.0)), rel=3.0 * (HALF / distance) ** 2)
    by_depth, by_square = NOISE * distance**2 / (2.0 * HALF**2), math.sqrt(2.0 * NOISE * distance / HALF)
    turn = 1.0 / math.hypot(1.0 / by_depth, 1.0 / by_square)
    assert math.radians(yaw_deg) == pytest.approx(turn, rel=3.0 * (HALF / distance) ** 2)


def test_a_wrong_heading_displaces_a_megatag_2_pose():
    """MegaTag 2 with a heading error of 10 degrees and a tag 3 m away is off by 3 m x 2 sin(5 deg) = 0.52 m."""
    pos = (6.9, 4.0, 0.0)
    seen = picture(ONE, pos, 0.0)
    right, wrong = (seen.megatag2(matrix(from_yaw(math.radians(angle)))) for angle in (0.0, 10.0))
    assert math.dist(right.position, pos) < 1e-9
    assert math.dist(wrong.position[:2], pos[:2]) == pytest.approx(3.1 * 2.0 * math.sin(math.radians(5.0)), rel=0.03)
    assert wrong.yaw_deg == pytest.approx(10.0)


# --- a measured Limelight ---------------------------------------------------------------------------------------------

SPEAKER = layout((3, (16.579, 4.983, 1.451)), (4, (16.579, 5.548, 1.451)))  # from the 2024 field
MEASURED = [
    # Distance of tag 3 [m], angle [deg], camera height [m]; visible tags; tag whose distance is measured; standard
    # deviations of tx [deg], distance, x, y [mm], yaw [deg].
    (2.19, 50.0, 0.88, (3.0,), 3, (0.0023, 3.9, 6.4, 4.0, 0.092)),
    (2.24, 50.0, 0.88, (3.0, 4.0), 4, (0.0023, 4.8, 4.7, 0.7, 0.057)),
    (3.48, 34.5, 0.88, (3.0, 4.0), 3, (0.0047, 8.5, 12.1, 5.1, 0.145)),
]


def stand(distance, angle_deg, height, ids, *, frames, seed=0, bias):
    """Return frames of a Limelight 3 on a robot at rest, aimed at the middle of both tags."""
    middle = SPEAKER.centers[0]
    level = math.sqrt(distance**2 - (middle[2] - height) ** 2)
    a = math.radians(angle_deg)
    eye = middle[:2] - level * np.array((math.cos(a), math.sin(a)))
    ahead = SPEAKER.centers.mean(axis=0)[:2] - eye
    yaw = math.atan2(ahead[1], ahead[0])
    pos = (eye[0] - 0.25 * math.cos(yaw), eye[1] - 0.25 * math.sin(yaw), 0.0)
    mount = CameraMount(x=0.25, z=height, pitch_deg=-13.0)
    camera = LimelightSim(
        CameraConfig(type=limelight_type("LL3"), mount=mount, bias=bias), SPEAKER, np.random.default_rng(seed)
    )
    camera.request(CameraRequest("fiducial_id_filters_set", ids), 0.0)
    history, found = PoseHistory(), []
    for k in range(2 * frames):  # 30 frames in 50 ticks
        history.add(0.02 * k, pos, from_yaw(yaw))
        found += camera.update(0.02 * k, history, CameraScene())
    return found[:frames]


@each(("distance", "angle", "height", "ids", "tag", "measured"), MEASURED)
def test_poses_of_a_robot_at_rest_are_as_noisy_as_measured(distance, angle, height, ids, tag, measured):
    """Deviations agree with a measured log within a factor of 1.5.

    Source: a log of 2024 (github.com/Tan560/wpilogsTomf4). It does not give the robot's position: at this angle a
    single corner noise explains all of its figures.
    """
    found = stand(distance, angle, height, ids, frames=600, bias=CameraBias.none())
    assert {len(frame.tags) for frame in found} == {len(ids)}
    tags = [next(one for one in frame.tags if one.id == tag) for frame in found]
    places = np.array([frame.megatag1.position for frame in found])
    deviations = (
        np.std([one.tx_deg for one in tags]),
        1e3 * np.std([one.camera_distance for one in tags]),
        *(1e3 * places.std(axis=0)[:2]),
        np.std([frame.megatag1.yaw_deg for frame in found]),
    )
    ratios = np.array(deviations) / measured
    print(
        f"{found[0].megatag1.average_distance:.2f} m: {np.round(deviations, 4)}, of the measured {np.round(ratios, 2)}"
    )
    assert (ratios < 1.5).all() and (ratios > 1.0 / 1.5).all()


@each(
    ("name", "size", "closed"),
    [("mount_angle_deg", 0.5, "yaw"), ("mount_position", 0.05, "place"), ("focal_length", 0.01, "range")],
)
def test_each_bias_moves_a_megatag_1_pose_by_the_pinhole_model(name, size, closed):
    """Compare means of frames with the pinhole model; errors are of second order in the bias.

    A mount angle error turns the pose by that angle, a mount position error moves the pose by that offset, and a longer
    focal length shortens the distance in proportion.
    """
    none = {field: 0.0 for field in CameraBias.__dataclass_fields__}
    quiet = {"type": limelight_type("LL3"), "mount": CameraMount(z=0.9), "bias": CameraBias(**{**none, name: size})}
    camera = LimelightSim(CameraConfig(**quiet), ONE, np.random.default_rng(4))
    history, pos = PoseHistory(), (8.5, 3.4, 0.0)
    yaw, offs = math.atan2(0.6, 1.5), []
    for k in range(600):
        history.add(0.02 * k, pos, from_yaw(yaw))
        for frame in camera.update(0.02 * k, history, CameraScene()):
            found = frame.megatag1
            offs.append(
                (*np.subtract(found.position, pos), math.radians(found.yaw_deg) - yaw, frame.tags[0].camera_distance)
            )
    off, sure = np.mean(offs, axis=0), 4.0 * np.std(offs, axis=0) / math.sqrt(len(offs))
    (true_x, true_y, _), true_quat = camera.pose_at((0.0, 0.0, 0.0), from_yaw(0.0))
    if closed == "yaw":
        turned = math.atan2(*matrix(true_quat)[(1, 0), 0])
        assert off[3] == pytest.approx(turned, abs=sure[3] + 0.03 * abs(turned))
    elif closed == "place":
        c, s = math.cos(yaw), math.sin(yaw)
        assert off[:2] == pytest.approx((c * true_x - s * true_y, s * true_x + c * true_y), abs=sure[:2].max())
    else:
        distance = math.hypot(1.5, 0.6)
        assert off[4] == pytest.approx(distance / camera._focal_factor, abs=sure[4] + 1e-4)
