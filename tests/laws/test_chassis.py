"""A robot over bumps, into walls and through fuel, without a drivetrain model."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.errors import NonFiniteError
from simcore.match.motion import Motion
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.piece_manager import GamePieceManager
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import BUMPER_STIFFNESS, ChassisConfig
from simcore.testing.benches import LoneChassis
from simcore.units import inches
from simcore.world.contact_law import POLYCARBONATE, WALL
from simcore.world.rotation import from_rpy, rotate
from simcore.world.shapes import Box, Hull, Sphere
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")

DT = 0.02


def advance(
    world: PhysicsWorld, *robots: ChassisSimulation | LoneChassis, pieces: GamePieceManager | None = None
) -> int:
    motion = Motion(world, robots=[r if isinstance(r, LoneChassis) else LoneChassis(r) for r in robots], pieces=pieces)
    motion.tick()
    return motion.substeps


def bump(world: PhysicsWorld) -> float:
    height, depth = inches(6.513), inches(44.4)
    ends = [(-depth / 2, 0.0), (depth / 2, 0.0), (0.0, height)]
    points = np.array([(x, y, z) for y in (-5.0, 5.0) for x, z in ends])
    world.add_static("bump", Hull(points), (0.0, 0.0, 0.0), surface=POLYCARBONATE, drivable=True)
    return math.degrees(math.atan2(height, depth / 2))


@pytest.mark.parametrize(("height", "way"), [(0.5, 1.0), (0.7, 1.0), (0.7, -1.0)])
@pytest.mark.parametrize("over", [-2.0, 2.0])
def test_a_robot_balanced_on_its_bumper_edge_falls_toward_its_center_of_mass(height, way, over):
    """Two degrees beyond tan a = (w / 2) / (h - c) it falls over; two degrees less, it lands on its wheels."""
    config = ChassisConfig(center_of_mass_height=height, height=0.9)
    critical = math.atan2(0.5 * config.bumper_width, height - config.clearance)
    with PhysicsWorld() as world:
        robot = ChassisSimulation(world, config)
        roll = way * (critical + math.radians(over))
        quat = from_rpy(roll, 0.0, 0.0)
        corners = [(0.0, s * 0.5 * config.bumper_width, config.clearance) for s in (1.0, -1.0)]
        lift = -min(rotate(quat, corner)[2] for corner in corners) + 1e-4
        world.set_pose(robot.row, (0.0, 0.0, lift), quat)
        for _ in range(200):
            advance(world, robot)
        tilt = math.degrees(math.acos(math.cos(robot.roll_pitch_yaw[0]) * math.cos(robot.roll_pitch_yaw[1])))
        assert (tilt > 60.0) if over > 0.0 else (tilt < 0.5)


@pytest.mark.parametrize("speed", [1.0, 2.0, 3.0])
@pytest.mark.parametrize("heading_deg", [0.0, 30.0])
def test_a_robot_rises_tilts_and_comes_down_over_the_bump(speed, heading_deg):
    """The driver holds the heading, as swerve code does; wheels in the air cannot."""
    heading = math.radians(heading_deg)
    with PhysicsWorld() as world:
        slope = bump(world)
        start = (-2.0 * math.cos(heading), -2.0 * math.sin(heading), heading)
        robot = ChassisSimulation(world, ChassisConfig(), pose=start)
        lone = LoneChassis(robot)
        heights, pitches, tilts = [], [], []
        for _ in range(int(4.6 / speed / DT)):
            drift = robot.pose[2] - heading
            c, s = math.cos(drift), math.sin(drift)
            lone.follow(speed * c, -speed * s, -8.0 * drift)
            advance(world, lone)
            roll, pitch, _ = robot.roll_pitch_yaw
            heights.append(robot.pos[2])
            pitches.append(math.degrees(pitch))
            tilts.append(math.degrees(math.acos(math.cos(roll) * math.cos(pitch))))
        assert max(heights) > 0.10
        assert min(heights) > -0.01, "it does not sink"
        assert slope - 3.0 < max(tilts) < slope + 10.0, "about the slope, no flip"
        assert min(pitches) < -0.7 * slope * math.cos(heading), "nose up on the way up"
        assert max(pitches) > 0.5 * slope * math.cos(heading), "nose down on the way down"
        assert abs(robot.pos[2]) < 0.01, "back on the carpet"
        assert abs(pitches[-1]) < 1.0
        assert robot.pose[0] > 1.0, "and across"
        assert abs(math.degrees(robot.pose[2] - heading)) < 1.0


@pytest.mark.parametrize("speed", [1.0, 2.0, 4.0, 5.0])
@pytest.mark.parametrize("heading", [0.0, 0.4])
def test_a_wall_stops_a_robot_within_the_overlap_that_its_bumper_stiffness_allows(speed, heading):
    """The overlap is at most d = v sqrt(m / k); a corner has a quarter of the stiffness of a side."""
    with PhysicsWorld() as world:
        world.add_static("wall", Box((0.3, 6.0, 1.0)), (2.15, 0.0, 0.5), surface=WALL)
        robot = ChassisSimulation(world, ChassisConfig(), pose=(0.0, 0.0, heading))
        lone = LoneChassis(robot)
        world.set_velocity(robot.row, (speed, 0.0, 0.0))
        robot.read()
        overlap = 0.0
        for _ in range(100):
            yaw = robot.pose[2]
            lone.follow(speed * math.cos(yaw), -speed * math.sin(yaw), 0.0)
            advance(world, lone)
            x, _, yaw = robot.pose
            front = x + 0.4 * (abs(math.cos(yaw)) + abs(math.sin(yaw)))
            overlap = max(overlap, front - 2.0)
        stiffness = BUMPER_STIFFNESS * robot.config.bumper_width * (1.0 if heading == 0.0 else 0.25)
        assert overlap < speed * math.sqrt(robot.config.mass / stiffness)
        assert abs(robot.pos[2]) < 0.02, "it does not climb"
        assert abs(robot.vel[0]) < 0.2
        tilt = max(map(abs, robot.roll_pitch_yaw[:2]))
        assert math.degrees(tilt) < 5.0


def test_ground_height_over_the_bare_floor_agrees_with_ray_casts(monkeypatch):
    """The chassis casts no rays where nothing is near."""
    with PhysicsWorld() as world:
        chassis = ChassisSimulation(world, ChassisConfig(), pose=(5.0, 3.0, 0.7))
        for _ in range(4):
            chassis.apply_forces((0.0, 0.0, 900.0), (20.0, 0.0, 0.0))  # tilts the robot and raises it a little
            advance(world, chassis)
        assert world.is_flat(5.0, 3.0, 0.5)
        soles, ground = chassis.wheel_ground()
        monkeypatch.setattr(world, "is_flat", lambda x, y, reach: False)
        cast_soles, cast_ground = chassis.wheel_ground()
    assert soles == pytest.approx(cast_soles, abs=1e-12)
    assert np.ptp(soles[:, 2]) > 1e-3
    assert ground == pytest.approx(cast_ground, abs=1e-6)


@pytest.mark.parametrize("speed", [3.0, 4.5])
@pytest.mark.parametrize("gap", [0.001, 0.005, 0.008, 0.03, 0.07])
def test_a_loose_row_of_fuel_yields_like_a_touching_row(gap, speed):
    """A knock crosses gaps within a tick; a ball that it reaches must not block the robot like a wall."""
    fuel = GamePieceConfig(name="Fuel", shape=Sphere(0.075), mass=0.215)
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(fuel, 64)], field_size=(16.0, 8.0))
        spacing = 0.15 + gap
        grid = np.array([[2.5 + spacing * i, 4.0 + spacing * j, 0.075] for i in range(16) for j in range(4)])
        pieces.spawn("Fuel", grid)
        robot = ChassisSimulation(world, ChassisConfig(), pose=(1.0, 4.2, 0.0))
        lone = LoneChassis(robot)
        highest, slowest = 0.0, math.inf
        for tick in range(70):
            lone.follow(speed, 0.0, 0.0)
            advance(world, lone, pieces=pieces)
            highest = max(highest, abs(robot.pos[2]))
            slowest = min(slowest, robot.vel[0] if tick > 30 else math.inf)
        assert (np.linalg.norm(pieces.state.pos - grid, axis=1) > 0.1).sum() > 20
    assert highest < 0.01
    assert slowest > 0.9 * speed


def test_a_robot_pushes_fuel_and_stays_on_the_carpet():
    fuel = GamePieceConfig(name="Fuel", shape=Sphere(0.075), mass=0.215)
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(fuel, 200)], field_size=(16.0, 8.0))
        grid = np.array([[3 + 0.155 * i, 3 + 0.155 * j, 0.075] for i in range(10) for j in range(20)])
        pieces.spawn("Fuel", grid)
        robot = ChassisSimulation(world, ChassisConfig(), pose=(1.5, 4.5, 0.0))
        lone = LoneChassis(robot)
        highest = most_awake = 0.0
        for _ in range(100):
            lone.follow(3.0, 0.0, 0.0)
            advance(world, lone, pieces=pieces)
            highest = max(highest, abs(robot.pos[2]))
            most_awake = max(most_awake, len(pieces.awake))
        moved = np.linalg.norm(pieces.state.pos - grid, axis=1) > 0.1
        assert moved.sum() > 40
        assert highest < 0.03, "it does not ride up on the fuel"
        assert most_awake < 200, "the far ones sleep on"
        assert (pieces.state.pos[:, 2] > 0.05).all(), "no fuel under the carpet"
        assert robot.vel[0] > 2.0


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_non_finite_values_are_refused_and_change_nothing(value):
    with PhysicsWorld() as world:
        robot = ChassisSimulation(world, ChassisConfig())
        with pytest.raises(NonFiniteError, match="robot"):
            robot.apply_forces((value, 0.0, 0.0))
        with pytest.raises(NonFiniteError, match="robot"):
            robot.set_pose(value, 0.0, 0.0)
        advance(world, robot)
        assert robot.pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-4)


@pytest.mark.parametrize("back", [0.01, 0.025, 0.04])
def test_a_wheel_at_the_edge_of_a_bar_stands_on_it(back):
    """With the hub a little before the edge, no ground is straight below the hub, yet the wheel bears load and drives.

    A hub b before the edge, at a distance r from it, is sqrt(r^2 - b^2) above it.
    """
    high, radius = 0.0286, 0.05
    with PhysicsWorld() as world:
        world.add_static("bar", Box((0.2, 4.0, high)), (0.1, 0.0, high / 2), surface=POLYCARBONATE, drivable=True)
        robot = ChassisSimulation(world, ChassisConfig())
        lone = LoneChassis(robot)
        front = max(x for x, _ in robot.config.wheel_positions)
        lifted = high + math.sqrt(radius**2 - back**2) - radius
        tilt = math.atan2(lifted, 2.0 * front)
        world.set_pose(robot.row, (-back - front, 0.0, lifted / 2), from_rpy(0.0, -tilt, 0.0))
        robot.read()
        for _ in range(3):
            lone.follow(0.0, 0.0, 0.0)
            advance(world, lone)
        assert robot.pos[0] + front == pytest.approx(-back, abs=0.01), "it has hardly rolled back"
        assert all(robot.touching)
