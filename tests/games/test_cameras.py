"""Visibility from cameras on the field of REBUILT: cases worked out from dimensions in the manual and tag positions."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from games.rebuilt import RebuiltSim
from games.rebuilt.robot import rebuilt_robot
from games.rebuilt.staging import Staging
from simcore.errors import ConfigError, UnknownNameError
from simcore.match.game import RobotEntry
from simcore.robot.robot_config import RobotConfig
from simcore.vision.camera import CameraBias, CameraConfig, CameraMount, PiecePipeline, limelight_type, optical_rotation
from simcore.vision.tag_layout import official_layout
from simcore.vision.tag_visibility import find_tags
from simcore.world.rotation import from_yaw

NO_FUEL = Staging(neutral=0, depot=0, chute=0, preload_per_robot=0, robots=3)


def with_cameras(*cameras: CameraConfig) -> RobotConfig:
    return replace(rebuilt_robot(), cameras=cameras)


def at_lens(height: float, yaw_deg: float = 0.0, pitch_deg: float = 0.0, **more) -> CameraConfig:
    """Return a camera at the robot's center, so that robot and lens have the same x and y."""
    mount = CameraMount(z=height, yaw_deg=yaw_deg, pitch_deg=pitch_deg)
    return CameraConfig(name="eye", type=limelight_type("LL4"), mount=mount, bias=CameraBias.none(), **more)


def seen(camera: CameraConfig, x: float, y: float, yaw_deg: float = 0.0, others=(), fuel=()) -> set[int]:
    """Return the tags in the first frames of a camera on a robot at a place of the field."""
    robots = [RobotEntry(start=(x, y, math.radians(yaw_deg)), preload=0, config=with_cameras(camera))]
    robots += [RobotEntry(start=pose, preload=0) for pose in others]
    staging = Staging(neutral=len(fuel), depot=0, chute=0, preload_per_robot=0, robots=3)
    with RebuiltSim(robots=robots, staging=staging) as match:
        if len(fuel):
            slots = match.pieces.on_field()
            match.pieces.release(slots, np.array(fuel))
        for _ in range(4):
            match.tick()
            if len(fuel):  # hold the fuel in place: the test is about the line of sight
                match.pieces.release(slots, np.array(fuel))
        frame = match.cameras.camera("eye").last
        assert frame is not None
        return {tag.id for tag in frame.tags}


def test_tags_on_the_near_face_are_visible_and_tags_behind_the_hub_are_not():
    """From 1.5 m in front of the blue hub, tags 25 and 26 are visible and tags 19 and 20 face away.

    Tag 4 on the red hub faces the camera, 8.8 m away and 14 px wide, but its line of sight crosses the blue hub's box
    (1.2 m high) at a height of 0.57 m.
    """
    camera = at_lens(0.5, pitch_deg=-15.0)
    found = seen(camera, 2.5, 4.0345)
    assert {25, 26} <= found
    assert not {3, 4, 19, 20} & found
    layout, rotation = official_layout("2026-welded"), optical_rotation(camera.mount.rotation)
    rows, _ = find_tags(layout, camera.type, (2.5, 4.0345, 0.5), rotation, min_side=12.0, max_angle_deg=75.0)
    in_picture = set(layout.ids[rows].tolist())
    assert 4 in in_picture  # only the hub hides it


def test_a_tag_beyond_the_trench_is_visible_only_below_the_trench_arm():
    """Tag 1, in front of the red trench, has its upper corners at 0.972 m, 8.6 m away.

    The lower edge of the blue arm is at 0.565 m, 1.3 m away. The upper line of sight passes there at 0.40 m from an eye
    at 0.3 m, and at 0.571 m from an eye at 0.5 m.
    """
    assert 1 in seen(at_lens(0.3), 3.3, 7.425)
    assert 1 not in seen(at_lens(0.5), 3.3, 7.425)


@pytest.mark.parametrize(("inside_deg", "expected"), [(0.2, True), (-0.2, False)])
def test_a_tag_counts_only_if_all_corners_are_inside_the_picture(inside_deg, expected):
    """The camera is 1.5 m in front of tag 26, at the height of the tag.

    The outer edge of the tag is atan(0.0826 / 1.5) from its middle, and the picture ends at 41 degrees.
    """
    edge = math.degrees(math.atan(0.5 * 0.1651 / 1.5))
    yaw = 41.0 - edge - inside_deg
    for sign in (1.0, -1.0):
        assert (26 in seen(at_lens(1.124), 4.0219 - 1.5, 4.0346, yaw_deg=sign * yaw)) is expected


@pytest.mark.parametrize(
    ("angle_deg", "distance", "expected"), [(60.0, 4.8, True), (60.0, 5.4, False), (0.0, 5.4, True), (77.0, 1.5, False)]
)
def test_an_oblique_tag_has_a_shorter_detection_range(angle_deg, distance, expected):
    """At 60 degrees the upper edge has half its length: 12 px at 5.06 m instead of 10.1 m.

    736 x 0.1651 x cos 60 / 12 = 5.06. Beyond 75 degrees no tag is detected.
    """
    layout, lens = official_layout("2026-welded"), limelight_type("LL4")
    row = layout.id_list.index(26)
    x, y, z = layout.centers[row].tolist()
    angle = math.radians(angle_deg)
    eye = (x - distance * math.cos(angle), y + distance * math.sin(angle), z)
    turn = optical_rotation(from_yaw(-angle))
    rows, _ = find_tags(layout, lens, eye, turn, min_side=12.0, max_angle_deg=75.0)
    assert (row in rows) is expected


def test_a_robot_in_front_hides_a_tag():
    """A robot 0.5 m high, 1.4 m away, covers the line of sight from 0.3 m to a tag 3.1 m away.

    Tag 13 in the red wall is 0.635 m high at the top, so the line passes the robot at 0.45 m; from 1.2 m it passes at
    0.78 m or more.
    """
    other = ((14.8, 7.403, 0.0),)
    assert 13 in seen(at_lens(0.3), 13.4, 7.403)
    assert 13 not in seen(at_lens(0.3), 13.4, 7.403, others=other)
    assert 13 in seen(at_lens(1.2, pitch_deg=10.0), 13.4, 7.403, others=other)


@pytest.mark.parametrize(("aside", "expected"), [(0.0, False), (0.1, False), (0.2, True)])
def test_a_tag_behind_fuel_is_not_visible(aside, expected):
    """A fuel of 0.075 m radius halfway to tag 26 leaves the tag free if it is more than 0.116 m to the side.

    Halfway, the tag's image is half as large: 0.041 m from its middle to its edge.
    """
    middle = (0.5 * (2.5 + 4.0219), 4.0346 + aside, 0.5 * (0.5 + 1.124))
    assert (26 in seen(at_lens(0.5, pitch_deg=-15.0), 2.5, 4.0346, fuel=[middle])) is expected


# --- game pieces ----------------------------------------------------------------------------------------------------


def piece_frame(fuel, camera=None, others=(), is_off=False):
    camera = camera or CameraConfig(
        bias=CameraBias.none(),
        name="eye",
        type=limelight_type("LL3"),
        mount=CameraMount(z=0.5, pitch_deg=20.0),
        pipelines=(PiecePipeline(near=0.3, far=3.0, box_noise=0.0),),
    )
    robots = [RobotEntry(start=(7.0, 2.0, 0.0), preload=0, config=with_cameras(camera))]
    robots += [RobotEntry(start=pose, preload=0) for pose in others]
    staging = Staging(neutral=len(fuel), depot=0, chute=0, preload_per_robot=0, robots=3)
    with RebuiltSim(robots=robots, staging=staging) as match:
        match.cameras.camera("eye").is_off = is_off
        slots = match.pieces.on_field()
        match.pieces.release(slots, np.array(fuel))
        for _ in range(8):
            match.tick()
        frame = match.cameras.camera("eye").last
        assert frame is not None
        return frame, [match.pieces.on_field().tolist().index(s) for s in slots.tolist()]


def test_a_fuel_has_the_angles_and_area_of_the_pinhole_model():
    """The fuel is at (1.5, -0.4) and the eye is 0.5 m high, pitched 20 degrees down."""
    frame, _ = piece_frame([(8.5, 1.6, 0.075)])
    (piece,) = frame.pieces
    c, s = math.cos(math.radians(20.0)), math.sin(math.radians(20.0))
    depth = 1.5 * c + 0.425 * s
    down = 0.425 * c - 1.5 * s
    assert piece.tx_deg == pytest.approx(math.degrees(math.atan(0.4 / depth)), abs=0.05)
    assert piece.ty_deg == pytest.approx(-math.degrees(math.atan(down / depth)), abs=0.05)
    (fx, fy), lens = limelight_type("LL3").focal_length, limelight_type("LL3")
    box = (2.0 * 0.075 / depth) ** 2 * fx * fy
    assert piece.area_percent == pytest.approx(100.0 * box / (lens.width * lens.height), rel=0.01)
    assert piece.class_name == "fuel"


def test_the_nearest_piece_is_first_and_pieces_out_of_range_are_not_seen():
    """The eye is above the fuel, so fuel in a row is visible; fuel beyond the far plane or behind the robot is not."""
    frame, _ = piece_frame(
        [(9.0, 2.0, 0.075), (8.2, 2.0, 0.075), (8.2, 1.9, 0.075), (10.6, 2.0, 0.075), (6.0, 2.0, 0.075)]
    )
    distances = [piece.distance for piece in frame.pieces]
    assert len(distances) == 3
    assert distances == sorted(distances)
    assert frame.primary_piece is frame.pieces[0]


def test_a_piece_is_hidden_by_another_piece_and_by_a_robot():
    low = CameraConfig(
        name="eye",
        type=limelight_type("LL3"),
        mount=CameraMount(z=0.075),
        pipelines=(PiecePipeline(near=0.5, far=4.0, box_noise=0.0),),
    )
    row = [(8.0, 2.0, 0.075), (9.0, 2.0, 0.075)]
    assert len(piece_frame(row, low)[0].pieces) == 1  # from the height of the fuel, the first one covers the second
    assert len(piece_frame([(8.0, 1.7, 0.075), (9.0, 2.0, 0.075)], low)[0].pieces) == 2
    assert len(piece_frame([(9.4, 2.0, 0.075)], low, others=((8.3, 2.0, 0.0),))[0].pieces) == 0


def test_a_camera_that_is_off_gives_empty_frames():
    frame, _ = piece_frame([(8.5, 1.6, 0.075)], is_off=True)
    assert frame.pieces == () and frame.primary_tag is None


# --- the match ------------------------------------------------------------------------------------------------------


def test_the_same_seed_gives_the_same_frames_and_cameras_change_nothing_else():
    def run(cameras):
        with RebuiltSim(seed=5, robots=(RobotEntry(config=with_cameras(*cameras)),)) as match:
            for _ in range(40):
                match.tick()
            corners = [
                tag.corners for camera in match.cameras.cameras.values() if camera.last for tag in camera.last.tags
            ]
            return match.digest.hexdigest(), np.concatenate(corners).tobytes() if corners else b""

    eye = at_lens(0.5, pitch_deg=-15.0)
    first, second, none = run((eye,)), run((eye,)), run(())
    assert first == second
    assert len(first[1]) > 0
    assert none[0] == first[0]


def test_the_seed_determines_the_bias_and_all_cameras_share_the_tag_errors():
    """Tags are moved by 50 mm x N(0, 1) and there is no other error: both cameras report the same wrong place."""
    bias = replace(CameraBias.none(), tag_position=0.05)
    eyes = [replace(at_lens(0.5, pitch_deg=-15.0), name=name, bias=bias) for name in ("a", "b")]
    places = {}
    for seed in (1, 1, 2):
        entry = RobotEntry(start=(2.5, 4.0345, 0.0), config=with_cameras(*eyes))
        with RebuiltSim(seed=seed, robots=(entry,), staging=NO_FUEL) as match:
            match.play(0.2)
            a, b = (np.array(match.cameras.camera(name).last.megatag1.position) for name in ("a", "b"))
            true = match.robots[0].chassis.pos
        assert math.dist(a, b) < 0.02 < math.dist(a, true)
        assert np.array_equal(places.setdefault(seed, a), a)
    assert math.dist(places[1], places[2]) > 0.02


@pytest.mark.parametrize(
    ("cameras", "tags", "error", "said"),
    [
        ((at_lens(0.5), at_lens(0.6)), None, ConfigError, "'eye' comes twice"),
        ((at_lens(0.5),), "2026-weldet", UnknownNameError, "2026-welded"),
    ],
)
def test_invalid_cameras_and_layouts_are_refused_at_construction(cameras, tags, error, said):
    with pytest.raises(error, match=said):
        RebuiltSim(robots=(RobotEntry(config=with_cameras(*cameras)),), tags=tags)


def test_on_a_field_without_tags_tag_frames_are_empty_and_piece_frames_arrive():
    """Cameras detect pieces there, but no tag."""
    from games.rebuilt import REBUILT
    from simcore import Match
    from simcore.vision.camera import PiecePipeline, TagPipeline

    eye = replace(at_lens(0.5, pitch_deg=20.0), pipelines=(TagPipeline(), PiecePipeline()))
    field = replace(REBUILT.field, tags="")
    with Match(replace(REBUILT, field=field), robots=(RobotEntry(config=with_cameras(eye)),)) as match:
        match.play(0.2)
        frame = match.cameras.camera("eye").last
        assert frame is not None and not frame.tags and not frame.pieces and frame.pipeline_kind == "tags"
        late = match.cameras.mount_camera(replace(eye, name="late"))
        late.settings.apply("pipeline", (1.0,))
        match.play(0.2)
        assert late.last is not None and late.last.pipeline_kind == "pieces"


def test_telemetry_contains_the_view_and_the_detections_of_a_camera():
    from simcore.telemetry.sinks import MemorySink

    sink = MemorySink()
    robot = with_cameras(at_lens(0.5, pitch_deg=-15.0))
    with RebuiltSim(robots=(RobotEntry(start=(2.5, 4.0346, 0.0), config=robot),), sinks=[sink]) as match:
        for _ in range(5):
            match.tick()
        seen_tags = match.cameras.camera("eye").last.tags
        layout = match.cameras.layout
    line = sink.snapshots[-1].pose_arrays["Sim/Limelights/eye/DirectionLine"]
    tags = sink.snapshots[-1].pose_arrays["Sim/Limelights/eye/SeenTags"]
    assert line.shape == (2, 7)
    assert line[0, :3] == pytest.approx((2.5, 4.0346, 0.5), abs=0.01)
    assert len(tags) == 2 * len(seen_tags) + 1
    for k, tag in enumerate(seen_tags):
        assert tags[2 * k + 1, :3] == pytest.approx(layout.centers[layout.id_list.index(tag.id)])
    largest = max(seen_tags, key=lambda tag: tag.area_percent)
    assert math.dist(line[1, :3], layout.centers[layout.id_list.index(largest.id)]) < 0.1
