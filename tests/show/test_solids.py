"""Solids of a described robot: intakes, shots and cameras have the poses in its config."""

import math
from dataclasses import replace

import numpy as np
import pytest

from games.rebuilt import REBUILT
from simcore.show.robot_outlines import zone_corners
from simcore.show.scene import Scene, shape_look
from simcore.show.solids import BUMPER, _rollers, described_solids, element_solids, shape_solids
from simcore.vision.camera import CameraConfig, CameraMount
from simcore.world.field import box_element
from simcore.world.shapes import Box, Cylinder, Sphere, cone, torus

ROBOT = REBUILT.robot()


def corners(config, name):
    """Return all vertices of the solids with a name, shape (n, 3)."""
    return np.concatenate([solid.vertices for found, solid in described_solids(config) if found == name])


def test_an_intake_is_drawn_extended_and_bumpers_have_the_configured_size() -> None:
    """Extended, the zone reaches 0.28 m, the rack's travel, farther to the back than stowed."""
    zone = corners(ROBOT, "intake, out")
    assert zone.min(axis=0) == pytest.approx((-0.78, -0.33, 0.0), abs=1e-6)
    assert zone.max(axis=0)[1:] == pytest.approx((0.33, 0.20), abs=1e-6)
    bumpers = [solid.vertices for _, solid in described_solids(ROBOT) if solid.name == BUMPER]
    body = np.concatenate(bumpers)
    assert body[:, 0].min() == pytest.approx(-0.5 * ROBOT.body.bumper_length)
    assert body[:, 1].min() == pytest.approx(-0.5 * ROBOT.body.bumper_width)


def test_a_robot_stands_on_its_wheels_and_its_rollers_are_in_their_zone() -> None:
    """Nothing of the robot is drawn below the carpet, and the intake is between the corners of its zone."""
    config = replace(ROBOT, components=())
    own = [solid.vertices for name, solid in described_solids(config) if not name]
    assert np.concatenate(own)[:, 2].min() == pytest.approx(0.0, abs=1e-9)
    zone = corners(config, "intake, out")
    (intake,) = config.intakes
    rollers = np.concatenate([solid.vertices for solid in _rollers(intake.zone)])
    room = zone_corners(intake.zone)
    assert (rollers.min(axis=0) >= room.min(axis=0) - 0.0041).all(), "plates are 4 mm beside it"
    assert (rollers.max(axis=0) <= room.max(axis=0) + 0.0041).all()
    assert np.concatenate(own)[:, 0].min() == pytest.approx(zone[:, 0].min(), abs=1e-6), "out as far as the zone"


def test_shapes_are_drawn_with_their_dimensions() -> None:
    """A ring has its hole, a cone its two radii, a box its corners, each where it stands."""
    ring = np.concatenate([one.vertices for one in shape_solids(torus(ring_radius=0.15, tube_radius=0.025), "#fff")])
    away = np.hypot(ring[:, 0], ring[:, 1])
    assert away.min() == pytest.approx(0.125, rel=0.05) and away.max() == pytest.approx(0.175, rel=0.05)
    (frustum,) = shape_solids(cone(height=0.3, bottom_radius=0.1, top_radius=0.02), "#fff")
    away, up = np.hypot(*frustum.vertices[:, :2].T), frustum.vertices[:, 2]
    assert away[up == up.min()].max() == pytest.approx(0.1) and away[up == up.max()].max() == pytest.approx(0.02)
    (ball,) = shape_solids(Sphere(0.2), "#fff")
    assert np.linalg.norm(ball.vertices, axis=1) == pytest.approx(0.2)
    shelf = box_element("blue_shelf_1", (1.0, 2.0, 0.5), (2.0, 3.0, 0.9))
    wall = box_element("boundary_red", (16.0, 0.0, 0.0), (16.1, 8.0, 2.0))
    scene = Scene(field_size=(16.0, 8.0), field_elements=[shelf, wall])
    solids = element_solids(scene, ["blue_shelf"])
    (named,) = [one for one in solids if one.name == "blue_shelf"]
    assert named.vertices.min(axis=0) == pytest.approx((1.0, 2.0, 0.5))
    assert named.vertices.max(axis=0) == pytest.approx((2.0, 3.0, 0.9))
    glass, board = (one for one in sorted(solids, key=lambda one: one.opacity) if not one.name)
    assert glass.opacity < 0.5 and glass.vertices[:, 2].max() == pytest.approx(2.0)
    assert board.opacity == 1.0 and board.vertices[:, 2].max() < 1.0, "one sees in over the board"


@pytest.mark.parametrize(
    ("shape", "hole"),
    [
        (torus(ring_radius=0.15, tube_radius=0.025), 0.125),
        (Cylinder(0.1, 0.3), 0.0),
        (cone(height=0.3, bottom_radius=0.1), 0.0),
        (Box((0.3, 0.3, 0.3)), None),
    ],
)  # fmt: skip
def test_a_body_of_revolution_is_recognized_with_its_hole(shape, hole) -> None:
    found = shape_look(shape, "#ffffff").hole
    assert found is None if hole is None else found == pytest.approx(hole, abs=0.01)


def test_a_shot_points_along_its_hood_and_heading() -> None:
    """The hood starts at 20 degrees, so the shot goes straight up; a fixed hood has 45 degrees to the front or back."""
    muzzle = np.array((0.168, 0.08, 0.55))
    way = corners(ROBOT, "shot") - muzzle
    assert way[np.argmax(way[:, 2])] == pytest.approx((0.0, 0.0, 0.38), abs=1e-6)
    (shooter,) = ROBOT.shooters
    for heading, sign in ((0.0, 1.0), (math.pi, -1.0)):
        fixed = replace(shooter, hood=None, elevation=math.radians(45.0))
        fixed = replace(fixed, launch=replace(shooter.launch, heading=heading))
        tips = corners(replace(ROBOT, shooters=(fixed,)), "shot")
        tip = tips[np.argmax(tips[:, 2])]
        assert tip - muzzle * (sign, sign, 1.0) == pytest.approx(0.38 * math.sqrt(0.5) * np.array((sign, 0.0, 1.0)))


def test_a_camera_is_drawn_with_its_fields_of_view() -> None:
    mount = CameraMount(x=-0.2, z=0.5, yaw_deg=180.0, pitch_deg=-30.0)
    camera = CameraConfig(mount=mount)
    rays = np.unique((corners(replace(ROBOT, cameras=(camera,)), "camera") - mount.position).round(6), axis=0)
    rays = rays[np.linalg.norm(rays, axis=1) > 0.1]
    assert len(rays) == 4
    middle = rays.mean(axis=0) / np.linalg.norm(rays.mean(axis=0))
    assert middle == pytest.approx((-math.cos(math.radians(30.0)), 0.0, 0.5), abs=1e-5), "back and up"
    across = 2.0 * math.atan(np.ptp(rays[:, 1]) / 2.0 / abs(rays.mean(axis=0) @ middle))
    assert math.degrees(across) == pytest.approx(camera.type.horizontal_fov_deg, abs=1e-3)
