"""The committed models of REBUILT: where things are, and moving as the robot's mechanisms do."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from robotpy_apriltag import AprilTagField, AprilTagFieldLayout
from wpimath.geometry import Pose3d, Rotation3d, Transform3d, Translation3d

from games.rebuilt import RebuiltSim
from games.rebuilt import dimensions as dim
from games.rebuilt.robot import rebuilt_robot
from simcore.geometry.rotation import rotate
from simcore.show.view_models import load_models

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "models" / "rebuilt" / "advantagescope"
COMPONENTS = rebuilt_robot().components


def test_the_field_is_where_the_dimensions_say():
    """Through the same transforms as the view's: the model's red wall is at -x, so blue comes back to x = 0."""
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


def test_the_hood_lets_fuel_go_in_the_direction_of_the_shot():
    """Its edge, seen from the axle, is at right angles to where the fuel flies: 110 degrees minus the hood's angle."""
    part = load_models(FOLDER).robots[0].parts[[c.name for c in COMPONENTS].index("hood")]
    points = trimesh.load_scene(part.path).to_geometry().vertices
    shell = points[np.hypot(points[:, 0], points[:, 2]) > 0.19]
    edge = max(math.atan2(z, -x) for x, _, z in shell)
    with RebuiltSim() as sim:
        robot = sim.robots[0]
        for volts in (3.0, -3.0):
            for _ in range(40):
                robot.mechanisms["hood"].set_volts(volts)
                for mechanism in robot.mechanisms.values():
                    mechanism.step(0.02)
            row = robot.component_poses()[[c.name for c in COMPONENTS].index("hood")]
            w, x, y, z = row[3:]
            to_edge = np.array(rotate((x, y, z, w), (-math.cos(edge), 0.0, math.sin(edge))))
            shot = np.array((math.cos(robot.shooters[0].aim.elevation), 0.0, math.sin(robot.shooters[0].aim.elevation)))
            assert to_edge @ shot == pytest.approx(0.0, abs=0.02)
            along = np.cross((0.0, 1.0, 0.0), to_edge)  # the wheels turn about +y: what they touch moves this way
            assert along @ shot == pytest.approx(1.0, abs=0.02)


def test_rollers_ride_on_the_intake_and_clear_the_bumper():
    names = [c.name for c in COMPONENTS]
    with RebuiltSim() as sim:
        robot = sim.robots[0]
        for _ in range(60):
            robot.mechanisms["intake_deploy"].set_volts(6.0)
            for mechanism in robot.mechanisms.values():
                mechanism.step(0.02)
            rows = robot.component_poses()
            for name in ("intake roller, lower", "intake roller, upper"):
                x, _, z = rows[names.index(name), :3]
                if -0.427 < x < -0.31:
                    assert z - 0.027 > robot.chassis.config.bumper_top, "through the bumper"
        roller = rows[names.index("intake roller, lower")]
        assert roller[0] == pytest.approx(
            COMPONENTS[2].joints[-1].origin[0] - robot.config.mechanisms["intake_deploy"].travel, abs=1e-3
        )
        assert 0.15 < roller[2] + 0.027 and roller[2] - 0.027 < 0.15, "it touches fuel that lies on the carpet"


def test_tags_and_driver_stations_stand_where_they_are_on_the_field():
    """In the frame of the model: origin in the middle, the red wall at -x."""
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
        for step in shown[tag.ID]["rotations"]:  # one after the other, about fixed axes
            axis = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}[step["axis"]]
            turn = turn.rotateBy(Rotation3d(np.array(axis, dtype=float), math.radians(step["degrees"])))
        own = Pose3d(Translation3d(*shown[tag.ID]["position"]), turn)
        back = Pose3d().transformBy(turned).transformBy(own - Pose3d())
        assert back.translation().distance(tag.pose.translation()) < 2e-4
        away = (back.rotation() - tag.pose.rotation()).angle
        assert math.remainder(away, math.tau) == pytest.approx(0.0, abs=1e-4)
