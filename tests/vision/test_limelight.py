"""Behavior of a Limelight over time: rates, latency, throttle, settings and heading modes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from each_case import each

from simcore.vision.camera import CameraBias, CameraConfig, CameraMount, PiecePipeline, TagPipeline, limelight_type
from simcore.vision.camera_scene import CameraScene
from simcore.vision.heading import HeadingSource, PoseHistory
from simcore.vision.limelight import CameraRequest, LimelightSim
from simcore.vision.tag_layout import official_layout
from simcore.world.rotation import from_yaw

LAYOUT = official_layout("2026-welded")
LL3, LL4 = limelight_type("LL3"), limelight_type("LL4")
MOUNT = CameraMount(z=0.5, pitch_deg=-15.0)
PLACE = (2.3, 4.2, 0.0)


def drive(config, seconds=1.0, *, speed=0.0, spin=0.0, each=None, seed=0, yaw=0.0):
    """Return a camera and its frames on a robot that drives along x and turns, with a call before each tick."""
    camera = LimelightSim(config, LAYOUT, np.random.default_rng(seed))
    history = PoseHistory()
    frames = []
    for k in range(round(seconds / 0.02) + 1):
        t = 0.02 * k
        if each is not None:
            each(camera, t, yaw + spin * t)
        history.add(t, (PLACE[0] + speed * t, PLACE[1], 0.0), from_yaw(yaw + spin * t))
        frames += camera.update(t, history, CameraScene())
    return camera, frames


def orient(camera, t, yaw):
    camera.request(CameraRequest("robot_orientation_set", (math.degrees(yaw), 0.0, 0.0, 0.0, 0.0, 0.0), t), t)


@each(("kind", "rate", "expected"), [(LL3, None, 30), (LL3, 5.0, 5), (LL4, None, 50), (LL4, 45.0, 45)])
def test_frames_come_at_the_cameras_rate_and_at_most_once_in_a_tick(kind, rate, expected):
    _, frames = drive(CameraConfig(type=kind, mount=MOUNT, frame_rate=rate), 4.0)
    assert len(frames) / 4.0 == pytest.approx(expected, rel=0.06)
    numbers = [frame.number for frame in frames]
    assert numbers == sorted(set(numbers))


def test_a_frame_is_published_after_its_latency():
    config = CameraConfig(type=replace(LL3, corner_noise=0.0), mount=MOUNT, bias=CameraBias.none())
    _, frames = drive(config, 1.0, speed=0.3, each=orient)
    for frame in frames:
        assert frame.published - frame.time == pytest.approx(0.0376 + 0.0206)
        assert frame.megatag2.position[0] == pytest.approx(PLACE[0] + 0.3 * frame.time, abs=1e-6)  # where it was then


def test_megatag_2_uses_the_heading_at_the_time_of_the_frame():
    """At two turns in three seconds, a heading one tick old would be off by 5 degrees.

    For a turn by an angle t, 0.08 rad in a tick, the interpolated attitude is off by t^3 / 240: 5 um at the distance of
    the tags.
    """
    config = CameraConfig(type=replace(LL3, corner_noise=0.0), mount=MOUNT, bias=CameraBias.none())
    _, frames = drive(config, 0.4, spin=4.0, each=orient, yaw=-0.8)
    seen = [frame for frame in frames if frame.megatag2 is not None]
    assert len(seen) > 5
    for frame in seen:
        assert frame.megatag2.position[:2] == pytest.approx(PLACE[:2], abs=1e-5)
        assert math.radians(frame.megatag2.yaw_deg) == pytest.approx(-0.8 + 4.0 * frame.time, abs=1e-9)


def test_without_a_heading_megatag_2_assumes_heading_zero():
    _, frames = drive(CameraConfig(mount=MOUNT), 0.3, yaw=0.3)
    last = frames[-1]
    assert last.megatag2.yaw_deg == 0.0
    assert math.dist(last.megatag2.position[:2], PLACE[:2]) > 0.3
    assert math.dist(last.megatag1.position[:2], PLACE[:2]) < 0.05


def test_a_moved_camera_takes_frames_from_its_new_mount_and_reports_the_mount():
    """Then the camera is turned to the back: it sees other tags and still finds the robot's true place."""

    def turn(camera, t, yaw):
        if abs(t - 0.5) < 1e-9:
            camera.move_to(CameraMount(x=-0.3, z=0.5, pitch_deg=-10.0, yaw_deg=180.0))

    camera, frames = drive(CameraConfig(type=LL3, mount=MOUNT), 1.0, each=turn)
    before = [frame for frame in frames if frame.published < 0.5]
    after = [frame for frame in frames if frame.time > 0.5]
    assert len(before) > 5 and len(after) > 5
    seen = [{tag.id for frame in some for tag in frame.tags} for some in (before, after)]
    assert {25, 26} <= seen[0] and seen[1] and not seen[0] & seen[1]
    for frame in (*before, *after):
        assert math.dist(frame.megatag1.position[:2], PLACE[:2]) < 0.1
    assert camera.settings.mount == (-0.3, 0.0, 0.5, 0.0, 10.0, 180.0)


def test_a_throttle_skips_frames():
    def throttle(camera, t, yaw):
        camera.request(CameraRequest("throttle_set", (4.0,)), t)

    _, frames = drive(CameraConfig(type=LL3, mount=MOUNT), 4.0, each=throttle)
    assert len(frames) / 4.0 == pytest.approx(30 / 5, rel=0.1)


@pytest.mark.parametrize("topic", ["fiducial_id_filters_set", "priorityid"])
def test_filters_select_tags_and_a_priority_changes_only_the_published_angles(topic):
    def ask(camera, t, yaw):
        camera.request(CameraRequest(topic, (25.0,)), t)

    _, frames = drive(CameraConfig(mount=MOUNT), 0.3, each=ask)
    last = frames[-1]
    assert last.primary_tag.id == 25
    assert (len(last.tags) == 1) is (topic == "fiducial_id_filters_set")


def test_a_wrong_camera_mount_shifts_the_estimated_pose():
    """The mount is set 0.2 m ahead of its true place: the robot seems 0.2 m farther back."""

    def tell(camera, t, yaw):
        camera.request(CameraRequest("camerapose_robotspace_set", (0.2, 0.0, 0.5, 0.0, 15.0, 0.0)), t)

    config = CameraConfig(mount=MOUNT, type=replace(LL4, corner_noise=0.0), bias=CameraBias.none())
    _, frames = drive(config, 0.3, each=tell)
    last = frames[-1]
    assert last.megatag1.position == pytest.approx((PLACE[0] - 0.2, PLACE[1], 0.0), abs=1e-6)
    assert last.mount[0] == 0.2


def test_a_camera_switches_between_pipelines_for_tags_and_pieces():
    config = CameraConfig(mount=CameraMount(z=0.5), pipelines=(TagPipeline(), PiecePipeline(far=5.0)))
    camera = LimelightSim(config, LAYOUT, np.random.default_rng(0))
    history = PoseHistory()
    kinds = []
    scene = CameraScene(pieces=np.array([(3.5, 4.2, 0.5)]), radii=np.array([0.075]))
    for k in range(30):
        if k == 15:
            camera.request(CameraRequest("pipeline", (1.0,)), 0.02 * k)
        history.add(0.02 * k, PLACE, from_yaw(0.0))
        kinds += [(f.pipeline, f.pipeline_kind, len(f.pieces)) for f in camera.update(0.02 * k, history, scene)]
    assert kinds[0] == (0, "tags", 0)
    assert kinds[-1] == (1, "pieces", 1)


def test_pieces_of_several_types_have_their_own_size_and_class():
    """A ball of 0.2 m is twice as wide as a ball of 0.1 m at the same distance, with its own class id and name."""

    def look(**options):
        config = CameraConfig(
            mount=CameraMount(z=0.5),
            pipelines=(PiecePipeline(far=5.0, box_noise=0.0, **options),),
            frame_rate=50.0,
            bias=CameraBias.none(),
        )
        camera, history = LimelightSim(config, LAYOUT, np.random.default_rng(0)), PoseHistory()
        centers = np.array([(PLACE[0] + 2.0, PLACE[1] + y, 0.5) for y in (0.5, -0.5)])
        scene = CameraScene(
            pieces=centers,
            radii=np.array([0.1, 0.2]),
            class_names=("coral", "algae"),
            class_ids=np.array([0, 1]),
        )
        for k in range(10):
            history.add(0.02 * k, PLACE, from_yaw(0.0))
            camera.update(0.02 * k, history, scene)
        return {(p.class_id, p.class_name): np.ptp(p.corners[:, 0]) for p in camera.last.pieces}

    seen = look()
    assert set(seen) == {(0, "coral"), (1, "algae")}
    assert seen[1, "algae"] == pytest.approx(2.0 * seen[0, "coral"], rel=1e-6)
    assert set(look(piece_class="algae")) == {(1, "algae")}
    assert look(piece_class="cone") == {}


# --- the IMU of a Limelight 4 -----------------------------------------------------------------------------------------


def turn_with(mode, *, told=None, has_imu=True, assist=0.001, mt1=None, seconds=2.0):
    """Return the yaw that the camera uses after a robot at 0.5 rad has turned at 1 rad/s."""
    source = HeadingSource(has_imu=has_imu, drift_deg=0.0, rng=np.random.default_rng(0))
    source.mode, source.assist = mode, assist
    for k in range(round(seconds / 0.02) + 1):
        t = 0.02 * k
        if told is not None:
            source.tell(t, (math.degrees(told(t)), 0.0, 0.0, 0.0, 0.0, 0.0))
        source.move(t, from_yaw(0.5 + t))
        if mt1 is not None:
            source.after_megatag1(math.degrees(mt1(t)), 0.02)
    r = source.attitude(seconds)
    return math.atan2(r[1, 0], r[0, 0])


def test_each_imu_mode_uses_its_own_heading_source():
    def true(t):
        return 0.5 + t

    def wrong(t):
        return 0.9 + t

    assert turn_with(0, told=wrong) == pytest.approx(2.9)  # the heading that robot code sends
    assert turn_with(1, told=wrong) == pytest.approx(2.9)
    assert turn_with(2) == pytest.approx(2.0)  # from zero at power-up, by the camera's own gyro
    assert turn_with(2, told=wrong) == pytest.approx(2.0)
    assert turn_with(2, told=wrong, has_imu=False) == pytest.approx(2.9)  # a camera without an IMU ignores modes
    drawn = turn_with(4, told=true)  # 2 s of 1000 steps a second: all but exp(-2) of the way
    assert drawn == pytest.approx(2.5 - 0.5 * math.exp(-2.0), abs=0.01)
    assert turn_with(3, mt1=true) == pytest.approx(2.5 - 0.5 * math.exp(-2.0), abs=0.02)
    assert turn_with(4, told=true, assist=0.1) == pytest.approx(2.5, abs=1e-3)


def test_a_crop_window_and_downscaling_reduce_the_visible_tags():
    def crop(camera, t, yaw):
        camera.request(CameraRequest("crop", (-1.0, 0.0, -1.0, 1.0)), t)

    def downscale(camera, t, yaw):
        camera.request(CameraRequest("fiducial_downscale_set", (5.0,)), t)

    _, plain = drive(CameraConfig(mount=MOUNT), 0.3)
    _, left = drive(CameraConfig(mount=MOUNT), 0.3, each=crop)
    _, coarse = drive(CameraConfig(mount=MOUNT), 0.3, each=downscale)
    assert {tag.id for tag in left[-1].tags} < {tag.id for tag in plain[-1].tags}
    assert all(tag.tx_deg < 0.0 for tag in left[-1].tags)
    assert {tag.id for tag in coarse[-1].tags} == {25, 26}  # near tags: 70 px wide, where 48 are needed


def test_mode_1_seeds_the_imu_for_mode_2():
    source = HeadingSource(has_imu=True, drift_deg=0.0, rng=np.random.default_rng(0))
    source.mode = 1
    for k in range(10):
        source.tell(0.02 * k, (40.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        source.move(0.02 * k, from_yaw(0.0))
    source.mode = 2
    source.move(0.3, from_yaw(0.1))
    r = source.attitude(0.3)
    assert math.degrees(math.atan2(r[1, 0], r[0, 0])) == pytest.approx(40.0 + math.degrees(0.1))
    reading = source.reading()
    assert reading is not None and reading.internal_yaw_deg == pytest.approx(40.0 + math.degrees(0.1))
    assert reading.acceleration_g == pytest.approx((0.0, 0.0, 1.0))


def test_a_heading_beyond_half_a_turn_is_interpolated_over_the_smaller_angle():
    source = HeadingSource(has_imu=False, drift_deg=0.0, rng=np.random.default_rng(0))
    source.tell(0.0, (179.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    source.tell(0.02, (-179.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    r = source.attitude(0.01)
    assert abs(math.degrees(math.atan2(r[1, 0], r[0, 0]))) == pytest.approx(180.0)
