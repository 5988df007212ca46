"""The drawing of a described robot: what stands where, and that it is written."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore.errors import OutputError
from simcore.geometry.linkage import Joint
from simcore.pieces.intake import IntakeZone
from simcore.pieces.placer import PlacerConfig
from simcore.robot.climber import ClimberConfig
from simcore.show.robot_drawing import draw_robot
from simcore.show.robot_sketch import SHOT, sketch_robot
from simcore.vision.camera import CameraConfig, CameraMount

ROBOT = REBUILT.robot()
ARM = Joint(mechanism="hood", axis=(0.0, -1.0, 0.0), origin=(0.1, 0.0, 0.6))


def volumes(sketch, role):
    return [volume for volume in sketch.volumes if volume.role == role]


def test_an_intake_is_drawn_out_and_stowed():
    """The zone reaches 0.28 m, the rack's travel, farther to the back when it is out."""
    out, stowed = volumes(sketch_robot(ROBOT), "intake")
    assert stowed.is_outline and not out.is_outline
    assert stowed.corners.min(axis=0) == pytest.approx((-0.50, -0.33, 0.0))
    assert out.corners.min(axis=0) == pytest.approx((-0.78, -0.33, 0.0))
    assert out.corners.max(axis=0) == pytest.approx((-0.35, 0.33, 0.20))


def test_shots_point_where_hood_and_heading_say():
    """The hood stands at 20 degrees, so straight up; at its other stop 45 degrees, to the front."""
    bold, *_ = [arrow for arrow in sketch_robot(ROBOT).arrows if not arrow.is_faint]
    faint, *_ = [arrow for arrow in sketch_robot(ROBOT).arrows if arrow.is_faint]
    assert bold.start == pytest.approx((0.168, 0.08, 0.55)) and bold.end - bold.start == pytest.approx((0, 0, SHOT))
    assert faint.end - faint.start == pytest.approx(SHOT * np.array((math.sqrt(0.5), 0.0, math.sqrt(0.5))))
    (shooter,) = ROBOT.shooters
    back = replace(ROBOT, shooters=(replace(shooter, launch=replace(shooter.launch, heading=math.pi)),))
    faint, *_ = [arrow for arrow in sketch_robot(back).arrows if arrow.is_faint]
    assert faint.end[0] < faint.start[0] < 0.0


def test_names_and_tags_do_not_cover_each_other(tmp_path):
    """Arm, elevator, climber and both claws of REEFSCAPE's robot stand at nearly one place."""
    draw_robot(tmp_path / "robot.svg", sketch_robot(REEFSCAPE.robot()), title="robot")
    seen = 0
    for group in ElementTree.parse(tmp_path / "robot.svg").iter():
        found = [(float(r.get("x")), float(r.get("y")), float(r.get("width")), float(r.get("height")))
                 for r in group if r.tag.endswith("rect") and r.get("height") in ("16", "20")]  # fmt: skip
        seen += len(found)
        for (x, y, wide, tall), (a, b, w, h) in itertools.combinations(found, 2):
            assert x >= a + w - 0.1 or a >= x + wide - 0.1 or y >= b + h - 0.1 or b >= y + tall - 0.1
    assert seen > 15


def test_the_way_of_an_arm_is_its_arc_from_stop_to_stop():
    """From 20 to 65 degrees at 0.4 m."""
    zone = IntakeZone(x_min=0.3, x_max=0.5, y_min=-0.1, y_max=0.1, z_min=-0.1, z_max=0.1)
    claw = PlacerConfig(joints=(ARM,), offset=(0.4, 0.0, 0.0), roller="feeder", zone=zone)
    sketch = sketch_robot(replace(ROBOT, placers=(claw,), climbers=(ClimberConfig(joints=(ARM,)),)))
    (way,) = [way for way in sketch.ways if way.name == "hood"]
    for end, degrees in ((way.way[0], 20.0), (way.way[-1], 65.0)):
        angle = math.radians(degrees)
        assert end == pytest.approx((0.1 + 0.4 * math.cos(angle), 0.0, 0.6 + 0.4 * math.sin(angle)))
    assert way.link[0] == pytest.approx(ARM.origin) and way.link[-1] == pytest.approx(way.way[0])
    assert [note.tag for note in sketch.notes] == ["R1", "I1", "S1", "G1", "H1"]


def test_a_camera_s_cone_opens_by_its_fields_of_view():
    mount = CameraMount(x=-0.2, z=0.5, yaw_deg=180.0, pitch_deg=-30.0)
    camera = CameraConfig(mount=mount)
    (cone,) = volumes(sketch_robot(replace(ROBOT, cameras=(camera,))), "camera")
    apex, rays = cone.corners[0], cone.corners[1:] - cone.corners[0]
    assert apex == pytest.approx(mount.position)
    middle = rays.mean(axis=0) / np.linalg.norm(rays.mean(axis=0))
    assert middle == pytest.approx((-math.cos(math.radians(30.0)), 0.0, 0.5)), "back and up"
    across = 2.0 * math.atan(np.ptp(rays[:, 1]) / 2.0 / abs(rays.mean(axis=0) @ middle))
    assert math.degrees(across) == pytest.approx(camera.type.horizontal_fov_deg)


def test_it_is_drawn_to_scale_and_says_which_files_it_can_write(tmp_path):
    """The front's band has the same bold blue in the picture, right of the robot's middle in the left half."""
    path = tmp_path / "deep" / "robot.png"
    draw_robot(path, sketch_robot(ROBOT), title="a $robot$", subtitle="55 kg")
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB")) / 255.0
    assert pixels.shape[1] == 1600
    front = np.abs(pixels[:, :800] - np.array([0x2F, 0x5F, 0xAE]) / 255.0).max(axis=2) < 0.01
    columns = np.nonzero(front.sum(axis=0) > 200)[0]
    black = np.abs(pixels[:, :800] - np.array([0x20, 0x24, 0x2B]) / 255.0).max(axis=2) < 0.01
    wheels = np.nonzero(black[300:700].sum(axis=0) > 5)[0]
    # the right edge of the band is 0.4 m ahead of the middle; the front wheels' front edge 0.2667 + 0.0508 m
    scale = (columns.max() - wheels.max()) / (0.4 - 0.2667 - 0.0508)
    assert np.ptp(columns) / scale == pytest.approx(0.085, abs=0.01)
    with pytest.raises(OutputError, match=r"pictures end in \.pdf, \.png, \.svg"):
        draw_robot(tmp_path / "robot.jpg", sketch_robot(ROBOT), title="")
