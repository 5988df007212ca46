"""Tag layouts: official layouts, files, and errors in a file."""

import json
import math

import pytest
from each_case import each

from simcore.errors import ConfigError, UnknownNameError
from simcore.vision.camera import CameraConfig, PiecePipeline, TagPipeline, limelight_type
from simcore.vision.tag_layout import TAG_SIZE, TagLayout, load_layout, official_layout
from simcore.world.rotation import from_yaw


def test_the_official_layouts_agree_with_wpilib():
    apriltag = pytest.importorskip("robotpy_apriltag")
    for name in (n for n in vars(apriltag.AprilTagField) if n.startswith("k2")):
        theirs = apriltag.AprilTagFieldLayout.loadField(getattr(apriltag.AprilTagField, name))
        ours = official_layout(name)
        assert ours.field_size == (theirs.getFieldLength(), theirs.getFieldWidth())
        assert ours.ids.tolist() == sorted(tag.ID for tag in theirs.getTags())
        for number, center, rotation in zip(ours.ids, ours.centers, ours.rotations, strict=True):
            pose = theirs.getTagPose(int(number))
            assert tuple(center) == (pose.X(), pose.Y(), pose.Z())
            assert rotation == pytest.approx(pose.rotation().toMatrix(), abs=1e-12)


def test_corners_are_counter_clockwise_for_a_viewer_who_faces_the_tag():
    """Tag 26 faces the blue wall: whoever faces it looks along +x, so left is +y."""
    layout = official_layout("2026-welded")
    row = layout.id_list.index(26)
    low_left, low_right, up_right, up_left = layout.corners[row] - layout.centers[row]
    h = TAG_SIZE / 2.0
    assert low_left == pytest.approx((0.0, h, -h), abs=1e-9)
    assert low_right == pytest.approx((0.0, -h, -h), abs=1e-9)
    assert up_right == pytest.approx((0.0, -h, h), abs=1e-9)
    assert up_left == pytest.approx((0.0, h, h), abs=1e-9)
    assert layout.normals[row] == pytest.approx((-1.0, 0.0, 0.0), abs=1e-9)


def test_the_error_for_an_unknown_layout_suggests_a_known_layout():
    with pytest.raises(UnknownNameError, match="Did you mean '2026-welded'"):
        official_layout("2026-weld")


def test_a_file_in_the_format_of_wpilib_is_read(tmp_path):
    file = tmp_path / "practice.json"
    turn = {"W": math.cos(0.5), "X": 0.0, "Y": 0.0, "Z": math.sin(0.5)}
    tag = {"ID": 7, "pose": {"translation": {"x": 1.0, "y": 2.0, "z": 0.5}, "rotation": {"quaternion": turn}}}
    file.write_text(json.dumps({"tags": [tag], "field": {"length": 10.0, "width": 5.0}}))
    layout = load_layout(file)
    assert layout.ids.tolist() == [7] and layout.field_size == (10.0, 5.0)
    assert layout.normals[0] == pytest.approx((math.cos(1.0), math.sin(1.0), 0.0))


@pytest.mark.parametrize("text", ["", "{}", '{"tags": [{"ID": 1}], "field": {"length": 1, "width": 1}}'])
def test_the_error_names_a_broken_layout_file(tmp_path, text):
    file = tmp_path / "broken.json"
    file.write_text(text)
    with pytest.raises(ConfigError, match=r"broken\.json: not a tag layout"):
        load_layout(file)
    with pytest.raises(ConfigError, match="not a tag layout"):
        load_layout(tmp_path / "missing.json")


@each(
    ("tag", "size", "said"),
    [
        (
            (1, (0.0, math.nan, 0.0), from_yaw(0.0)),
            TAG_SIZE,
            r"place of tag 1\[1\] must be a number from -100 to 100 m",
        ),
        ((1, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.5)), TAG_SIZE, "attitude of tag 1 must be a unit quaternion"),
        ((1.5, (0.0, 0.0, 0.0), from_yaw(0.0)), TAG_SIZE, "id must be a whole number from 0 to 586, got 1.5"),
        ((1, (0.0, 0.0, 0.0), from_yaw(0.0)), -0.1, "size must be a number above 0 and up to 1 m, got -0.1"),
    ],
)
def test_an_invalid_tag_is_refused(tag, size, said):
    with pytest.raises(ConfigError, match=said):
        TagLayout.of([tag], field_size=(16.0, 8.0), size=size)


def test_a_repeated_id_is_refused():
    tags = [(1, (0.0, 0.0, 0.0), from_yaw(0.0)), (1, (1.0, 0.0, 0.0), from_yaw(0.0))]
    with pytest.raises(ConfigError, match="ids must differ"):
        TagLayout.of(tags, field_size=(1.0, 1.0))
    assert len(TagLayout.of([], field_size=(1.0, 1.0)).ids) == 0


@each(
    ("make", "message"),
    [
        (lambda: limelight_type("LL5"), "no Limelight type named 'LL5'"),
        (lambda: CameraConfig(name=""), "name without '/'"),
        (lambda: CameraConfig(name="a/b"), "name without '/'"),
        (lambda: CameraConfig(frame_rate=0.0), "frame_rate must be a number above 0 and up to 500 1/s"),
        (lambda: CameraConfig(pipelines=()), "1 to 10 pipelines"),
        (lambda: TagPipeline(downscale=0.5), "downscale must be a number from 1 to 8"),
        (lambda: TagPipeline(max_angle_deg=90.0), "max_angle_deg"),
        (lambda: PiecePipeline(near=1.0, far=0.5), "far must be beyond near"),
        (lambda: PiecePipeline(min_visible=2.0), "min_visible"),
    ],
)
def test_invalid_layout_settings_are_refused(make, message):
    with pytest.raises((ConfigError, UnknownNameError)) as error:
        make()
    assert message in str(error.value)
