"""Committed models of REBUILT: positions, and motion with the robot's mechanisms."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from robotpy_apriltag import AprilTagField, AprilTagFieldLayout
from wpimath.geometry import Pose3d, Rotation3d, Transform3d, Translation3d

from games.rebuilt import dimensions as dim
from games.rebuilt.robot import rebuilt_robot
from simcore.show.view_models import load_models

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "models" / "rebuilt" / "advantagescope"
COMPONENTS = rebuilt_robot().components


def test_the_field_model_agrees_with_the_dimensions_of_the_field():
    """The test applies the transforms of the view: the model's red wall is at -x, so blue is at x = 0."""
    field = load_models(FOLDER).field
    assert field.size == pytest.approx((dim.FIELD_LENGTH, dim.FIELD_WIDTH), abs=1e-4)
    scene = trimesh.load_scene(field.body.path)

    def bounds(name):
        mesh = scene.geometry[name]
        points = mesh.vertices @ field.body.transform[:3, :3].T + field.body.transform[:3, 3]
        return points.min(axis=0), points.max(axis=0)

    low, high = bounds("blue_hub_base")
    assert (low + high)[:2] / 2 == pytest.approx(dim.HUB_CENTER, abs=1e-3)
    low, high = bounds("blue_wall")
    assert high[0] == pytest.approx(0.0, abs=1e-3) and high[2] < 1.0
    low, high = bounds("red_depot_barrier_front")
    assert low[0] == pytest.approx(dim.FIELD_LENGTH - dim.DEPOT_DEPTH, abs=1e-3)
    ball = trimesh.load_scene(field.pieces["Fuel"].path)
    assert ball.extents == pytest.approx([0.15] * 3, abs=8e-3)


def test_the_field_model_has_tags_and_driver_stations_at_the_published_positions():
    """In the frame of the model: the origin is in the middle and the red wall at -x."""
    config = json.loads((FOLDER / "Field3d_SimcoreRebuilt" / "config.json").read_text())
    blue = [(8.28, -3.08), (8.28, -1.25), (8.28, 1.83)]
    stations = [*blue, *((-x, -y) for x, y in blue)]
    assert np.array(config["driverStations"]) == pytest.approx(np.array(stations), abs=2e-3)
    layout = AprilTagFieldLayout.loadField(AprilTagField.k2026RebuiltWelded)
    turned = Transform3d(Translation3d(dim.FIELD_LENGTH / 2, dim.FIELD_WIDTH / 2, 0.0), Rotation3d(0, 0, math.pi))
    shown = {tag["id"]: tag for tag in config["aprilTags"]}
    assert len(shown) == len(layout.getTags()) == 32 and {tag["variant"] for tag in shown.values()} == {"36h11-6.5in"}
    for tag in layout.getTags():
        turn = Rotation3d()
        for step in shown[tag.ID]["rotations"]:  # in sequence, about fixed axes
            axis = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}[step["axis"]]
            turn = turn.rotateBy(Rotation3d(np.array(axis, dtype=float), math.radians(step["degrees"])))
        own = Pose3d(Translation3d(*shown[tag.ID]["position"]), turn)
        back = Pose3d().transformBy(turned).transformBy(own - Pose3d())
        assert back.translation().distance(tag.pose.translation()) < 2e-4
        away = (back.rotation() - tag.pose.rotation()).angle
        assert math.remainder(away, math.tau) == pytest.approx(0.0, abs=1e-4)
