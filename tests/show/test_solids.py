"""Solids of a described robot: intakes, shots and cameras stand where its config says; models are in test_models.py."""

import math
from dataclasses import replace

import numpy as np
import pytest

from games.rebuilt import REBUILT
from simcore.show.solids import described_solids
from simcore.vision.camera import CameraConfig, CameraMount

ROBOT = REBUILT.robot()


def corners(config, name):
    """Return all vertices of the solids of a name, shape (n, 3)."""
    return np.concatenate([solid.vertices for found, solid in described_solids(config) if found == name])


def test_an_intake_is_out_and_bumpers_have_their_size() -> None:
    """The zone reaches 0.28 m, the rack's travel, farther to the back than stowed."""
    zone = corners(ROBOT, "intake, out")
    assert zone.min(axis=0) == pytest.approx((-0.78, -0.33, 0.0), abs=1e-6)
    assert zone.max(axis=0)[1:] == pytest.approx((0.33, 0.20), abs=1e-6)
    body = corners(ROBOT, "")
    assert body[:, 0].min() == pytest.approx(-0.5 * ROBOT.body.bumper_length)
    assert body[:, 1].min() == pytest.approx(-0.5 * ROBOT.body.bumper_width)


def test_a_shot_points_where_hood_and_heading_say() -> None:
    """The hood starts at 20 degrees, so straight up from the muzzle; a fixed one at 45 degrees to the front or back."""
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


def test_a_camera_opens_by_its_fields_of_view() -> None:
    mount = CameraMount(x=-0.2, z=0.5, yaw_deg=180.0, pitch_deg=-30.0)
    camera = CameraConfig(mount=mount)
    rays = np.unique((corners(replace(ROBOT, cameras=(camera,)), "camera") - mount.position).round(6), axis=0)
    rays = rays[np.linalg.norm(rays, axis=1) > 0.1]
    assert len(rays) == 4
    middle = rays.mean(axis=0) / np.linalg.norm(rays.mean(axis=0))
    assert middle == pytest.approx((-math.cos(math.radians(30.0)), 0.0, 0.5), abs=1e-5), "back and up"
    across = 2.0 * math.atan(np.ptp(rays[:, 1]) / 2.0 / abs(rays.mean(axis=0) @ middle))
    assert math.degrees(across) == pytest.approx(camera.type.horizontal_fov_deg, abs=1e-3)
