"""The world: material pairs, independent worlds and refused input."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from simcore.errors import ConfigError, EngineError, NonFiniteError, UnknownNameError
from simcore.match.motion import Motion
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.testing.benches import LoneChassis
from simcore.units import GRAVITY
from simcore.world.contact_law import CARPET, WALL, TerrainSurface
from simcore.world.shapes import Box, Cylinder, Shape, Sphere
from simcore.world.world import PhysicsWorld

ICE = TerrainSurface(name="ice", friction=0.0, restitution=0.0)


def surface(friction: float = 0.5, restitution: float = 0.0) -> TerrainSurface:
    return TerrainSurface(name="test", friction=friction, restitution=restitution)


def run(world: PhysicsWorld, seconds: float, substeps: int = 4) -> None:
    for _ in range(round(seconds / 0.02)):
        world.step(0.02, substeps=substeps)


# --- surfaces of the touching pair ------------------------------------------------------------------------------------


@settings(max_examples=15, suppress_health_check=list(HealthCheck))
@given(st.floats(0.2, 1.5), st.floats(0.2, 1.2))
def test_a_sliding_box_slows_by_the_product_of_both_friction_coefficients(engine_name, of_floor, of_box):
    """v = v0 - mu g t with the product mu; on MuJoCo a sliding box hops by less than 3 mm at 3 m/s."""
    is_mujoco = engine_name == "mujoco"
    mu, speed, seconds = of_floor * of_box, 3.0 if is_mujoco else 6.0, 0.3
    with PhysicsWorld(floor=surface(of_floor)) as world:
        row = world.add_piece_body("box", Box((0.4, 0.4, 0.1)), mass=2.0, surface=surface(of_box), pos=(0, 0, 0.05))
        run(world, 0.2)
        world.set_velocity(row, (speed, 0.0, 0.0))
        run(world, seconds)
        expected = max(0.0, speed - mu * GRAVITY * seconds)
        assert world.engine.velocity(row)[0][0] == pytest.approx(
            expected, abs=(0.1 if is_mujoco else 0.04) * (speed - expected) + 0.01
        )


@pytest.mark.parametrize("away", [40.0, 900.0])
def test_the_floor_extends_without_end(away):
    """Balls, boxes, cylinders and robots move far out as they do in the middle, within 1 mm."""
    with PhysicsWorld() as world:
        shapes = {"ball": Sphere(0.075), "box": Box((0.3, 0.3, 0.28)), "cylinder": Cylinder(0.06, 0.3)}
        pieces = {
            (name, x): world.add_piece_body(name, shape, mass=0.6, surface=surface(0.8), pos=(x, 2.0 * y, 0.15))
            for y, (name, shape) in enumerate(shapes.items())
            for x in (0.0, away)
        }
        robots = [ChassisSimulation(world, ChassisConfig(), pose=(x, 8.0, 0.3)) for x in (0.0, away)]
        lone = [LoneChassis(robot) for robot in robots]
        for one in lone:
            one.follow(2.0, 0.0, 0.5)
        motion = Motion(world, robots=lone)
        for _ in range(50):
            motion.tick()
        for name in shapes:
            middle, far = (world.engine.pose(pieces[name, x])[0] for x in (0.0, away))
            assert far == pytest.approx((middle[0] + away, middle[1], middle[2]), abs=1e-3)
        for robot in robots:
            robot.read()
        assert robots[1].pos == pytest.approx((robots[0].pos[0] + away, *robots[0].pos[1:]), abs=1e-3)
        assert robots[1].pose[2] == pytest.approx(robots[0].pose[2], abs=1e-3)


@dataclass(frozen=True)
class Element:
    name: str
    shape: Shape
    position: tuple[float, float, float]
    surface: TerrainSurface


def test_each_field_element_keeps_its_own_material():
    """Two plates lie side by side; the restitution of one does not affect the other."""
    plates = [
        Element("dead", Box((1.0, 1.0, 0.2)), (0.0, 0.0, 0.1), replace(WALL, restitution=0.0)),
        Element("live", Box((1.0, 1.0, 0.2)), (2.0, 0.0, 0.1), replace(WALL, restitution=0.9)),
    ]
    with PhysicsWorld() as world:
        world.add_field(plates)
        balls = [
            world.add_piece_body("ball", Sphere(0.1), mass=0.5, surface=surface(1.0, 1.0), pos=(x, 0.0, 0.8))
            for x in (0.0, 2.0)
        ]
        top = [0.0, 0.0]
        for tick in range(80):
            world.step(0.02, substeps=4)
            for i, row in enumerate(balls):
                if tick > 25:  # the fall takes 0.32 s
                    top[i] = max(top[i], world.engine.pose(row)[0][2] - 0.3)
        assert top[0] < 0.02
        assert top[1] == pytest.approx(0.9**2 * 0.5, rel=0.12)


def test_an_unmatched_drivable_pattern_lists_the_elements():
    plate = Element("blue_bump_left", Box((1.0, 1.0, 0.2)), (0.0, 0.0, 0.1), WALL)
    with PhysicsWorld() as world, pytest.raises(UnknownNameError, match="blue_bump_left"):
        world.add_field([plate], drivable=["blue_bmp_*"])


def test_carpet_friction_slows_pieces_but_not_robot_bodies():
    """A robot's grip comes from its tires alone; the carpet slows a piece."""
    with PhysicsWorld(floor=CARPET) as world:
        robot = world.add_robot_body(
            "robot", Box((0.5, 0.5, 0.2)), mass=50.0, surface=surface(1.0), center_of_mass=(0.0, 0.0, 0.0),
            inertia=(1.0, 1.0, 2.0), pos=(0.0, 0.0, 0.1),
        )  # fmt: skip
        piece = world.add_piece_body("box", Box((0.5, 0.5, 0.2)), mass=5.0, surface=surface(1.0), pos=(0, 3.0, 0.1))
        run(world, 0.2)
        for row in (robot, piece):
            world.set_velocity(row, (2.0, 0.0, 0.0))
        run(world, 0.5)
        assert world.engine.velocity(robot)[0][0] == pytest.approx(2.0, rel=1e-3)
        assert world.engine.velocity(piece)[0][0] == pytest.approx(0.0, abs=0.02)


# --- several worlds ---------------------------------------------------------------------------------------------------


class Scene:
    """Twenty balls thrown into a corner."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.world = PhysicsWorld()
        self.world.add_static("wall", Box((0.2, 6.0, 2.0)), (2.0, 0.0, 1.0), surface=WALL)
        self.rows = []
        for pos, vel in zip(rng.uniform((-1, -1, 0.2), (1, 1, 2), (20, 3)), rng.uniform(-4, 4, (20, 3)), strict=True):
            self.rows.append(
                self.world.add_piece_body("ball", Sphere(0.1), mass=0.3, surface=surface(0.7, 0.7), pos=pos.tolist())
            )
            self.world.set_velocity(self.rows[-1], vel.tolist())

    def state(self) -> bytes:
        return self.world.engine.centers(self.rows).tobytes() + self.world.engine.velocities(self.rows).tobytes()


def alone(seed: int, ticks: int = 60) -> bytes:
    scene = Scene(seed)
    with scene.world:
        for _ in range(ticks):
            scene.world.step(0.02)
        return scene.state()


def test_two_worlds_in_one_process_do_not_affect_each_other():
    """Stepped alternately, while another world opens and closes, each moves as it does alone."""
    one, two = Scene(1), Scene(2)
    with one.world, two.world:
        for tick in range(60):
            one.world.step(0.02)
            two.world.step(0.02)
            if tick == 30:
                Scene(3).world.close()
        assert one.state() == alone(1)
        assert two.state() == alone(2)


def memory_mb() -> float:
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="reads Linux's /proc")
def test_closing_a_world_frees_its_memory():
    """A world takes about 30 MB; forty leaked worlds would take 1.2 GB."""
    for _ in range(5):
        Scene(0).world.close()
    before = memory_mb()
    for _ in range(40):
        Scene(0).world.close()
    assert memory_mb() - before < 150.0


def test_every_call_on_a_closed_world_raises():
    scene = Scene(0)
    scene.world.close()
    scene.world.close()
    row = scene.rows[0]
    for use in (
        lambda: scene.world.step(0.02),
        lambda: scene.world.set_pose(row, (0.0, 0.0, 1.0)),
        lambda: scene.world.set_velocity(row, (0.0, 0.0, 1.0)),
        lambda: scene.world.engine.centers([row]),
        lambda: scene.world.engine.velocities([row]),
        lambda: scene.world.add_static("late", Box((1.0, 1.0, 1.0)), (0.0, 0.0, 0.0), surface=WALL),
    ):
        with pytest.raises(EngineError, match="closed"):
            use()


def test_an_error_inside_a_with_block_still_closes_the_world():
    with pytest.raises(RuntimeError, match="robot code"), PhysicsWorld() as world:
        assert world.engine.name
        raise RuntimeError("robot code")
    with pytest.raises(EngineError, match="closed"):
        world.step(0.02)


# --- refused input ----------------------------------------------------------------------------------------------------


@pytest.fixture
def world():
    with PhysicsWorld() as world:
        yield world


@pytest.mark.parametrize("dt", [0.0, -0.02, math.nan, math.inf])
def test_a_time_step_that_is_not_positive_and_finite_is_refused(world, dt):
    with pytest.raises(ConfigError, match="dt must be finite and > 0"):
        world.step(dt)


@pytest.mark.parametrize("substeps", [0, -3])
def test_a_step_without_substeps_is_refused(world, substeps):
    with pytest.raises(ConfigError, match="substeps"):
        world.step(0.02, substeps=substeps)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_non_finite_poses_and_velocities_are_refused_and_change_nothing(world, value):
    row = world.add_piece_body("ball", Sphere(0.1), mass=0.5, surface=ICE, pos=(1.0, 2.0, 3.0))
    before = world.engine.pose(row), world.engine.velocity(row)
    with pytest.raises(NonFiniteError, match="ball: position"):
        world.set_pose(row, (value, 0.0, 0.0))
    with pytest.raises(NonFiniteError, match="ball: attitude"):
        world.set_pose(row, (0.0, 0.0, 0.0), (value, 0.0, 0.0, 1.0))
    with pytest.raises(NonFiniteError, match="ball: attitude"):
        world.set_pose(row, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
    with pytest.raises(NonFiniteError, match="ball: velocity"):
        world.set_velocity(row, (0.0, value, 0.0))
    with pytest.raises(NonFiniteError, match="late: position"):
        world.add_piece_body("late", Sphere(0.1), mass=0.5, surface=ICE, pos=(0.0, 0.0, value))
    assert (world.engine.pose(row), world.engine.velocity(row)) == before


def test_an_attitude_of_any_length_is_normalized(world):
    row = world.add_piece_body("box", Box((0.1, 0.2, 0.3)), mass=0.5, surface=ICE, pos=(0.0, 0.0, 1.0))
    world.set_pose(row, (0.0, 0.0, 1.0), (0.0, 0.0, 3.0, 4.0))
    assert world.engine.pose(row)[1] == pytest.approx((0.0, 0.0, 0.6, 0.8))
