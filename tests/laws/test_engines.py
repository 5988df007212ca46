"""Behavior of the engine protocol that every engine must have."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest

from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.world.contact_law import TerrainSurface
from simcore.world.engine import BodyDefinition, Engine
from simcore.world.engine_choice import make_engine
from simcore.world.shapes import Box, Compound, Hull, Part, Sphere
from simcore.world.world import PhysicsWorld

BALL = TerrainSurface(name="ball", friction=0.8, restitution=0.55)
HARD = TerrainSurface(name="hard", friction=1.0, restitution=1.0)
RADIUS, MASS = 0.075, 0.215


@pytest.fixture
def engine():
    with make_engine(gravity=1e-9) as one:
        yield one


def ball(engine: Engine, x: float, *, group: int = 2, mask: int = 0xFFFF) -> int:
    return engine.add_body(
        BodyDefinition(shape=Sphere(RADIUS), surface=HARD, mass=MASS, group=group, mask=mask, pos=(x, 0.0, 1.0))
    )


def run(engine: Engine, seconds: float) -> None:
    for _ in range(round(seconds / 0.005)):
        engine.step(0.005)


def test_each_test_runs_on_the_engine_in_its_name(engine, engine_name):
    assert engine.name == engine_name


@pytest.mark.parametrize(
    ("first", "second", "touch"),
    [((2, 4), (4, 2), True), ((2, 4), (4, 8), False), ((2, 8), (4, 2), False), ((2, 6), (2, 6), True)],
)
def test_two_bodies_collide_only_if_each_mask_includes_the_others_group(engine, first, second, touch):
    a = ball(engine, 0.0, group=first[0], mask=first[1])
    b = ball(engine, 0.3, group=second[0], mask=second[1])
    engine.set_velocity(a, (2.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    run(engine, 0.3)
    assert (engine.velocity(b)[0][0] > 1.0) == touch


def test_collision_masks_can_change_during_a_run(engine):
    a, b = ball(engine, 0.0), ball(engine, 0.3)
    engine.set_collision(b, 0, 0)
    engine.set_velocity(a, (2.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    run(engine, 0.3)
    assert engine.pose(a)[0][0] == pytest.approx(0.6, abs=1e-6), "it went through"
    engine.set_collision(b, 2, 0xFFFF)
    engine.set_velocity(a, (-2.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    run(engine, 0.2)
    assert engine.velocity(b)[0][0] < -1.0


def test_a_sleeping_body_stays_in_place_until_a_moving_body_touches_it():
    with PhysicsWorld() as world:
        engine = world.engine
        rows = [
            world.add_piece_body("ball", Sphere(RADIUS), mass=MASS, surface=BALL, pos=(x, 0.0, 1.0)) for x in (0.0, 0.4)
        ]
        engine.sleep(rows[0])
        engine.sleep(rows[1])
        for _ in range(25):
            world.step(0.02)
        assert engine.pose(rows[0])[0] == (0.0, 0.0, 1.0), "frozen in the air"
        world.set_velocity(rows[1], (-8.0, 0.0, 0.0))
        for _ in range(10):
            world.step(0.02)
        assert engine.pose(rows[0])[0][0] < -0.1 and engine.pose(rows[0])[0][2] < 1.0
        engine.sleep(rows[1])
        engine.wake(rows[1])
        height = engine.pose(rows[1])[0][2]
        world.step(0.02)
        assert engine.pose(rows[1])[0][2] < height or height < 0.08


@pytest.mark.parametrize("shape", [Sphere(RADIUS), Box((0.15, 0.15, 0.15))], ids=["ball", "box"])
def test_a_fixed_body_acts_as_static_until_it_is_woken(shape):
    with PhysicsWorld() as world:
        engine = world.engine
        fixed, other = (
            world.add_piece_body("piece", shape, mass=MASS, surface=BALL, pos=(x, 0.0, RADIUS)) for x in (0.0, 0.2)
        )
        engine.fix(fixed)
        world.set_velocity(other, (-2.0, 0.0, 0.0))
        for _ in range(15):
            world.step(0.02)
        assert engine.pose(fixed)[0] == (0.0, 0.0, RADIUS), "hit, and still there"
        assert engine.pose(other)[0][0] > 2.0 * RADIUS - 0.002, "thrown back"
        engine.set_pose(fixed, (2.0, 0.0, RADIUS), (0.0, 0.0, 0.0, 1.0))
        engine.fix(fixed)
        world.set_velocity(fixed, (0.0, 0.0, 0.0))
        world.set_pose(other, (2.2, 0.0, RADIUS))
        world.set_velocity(other, (-2.0, 0.0, 0.0))
        speeds = []
        for _ in range(15):
            world.step(0.02)
            speeds.append([engine.velocity(row)[0][0] for row in (fixed, other)])
        hit, left = min(speeds)
        assert -1.6 < hit < -0.3, "it has its mass again"
        assert hit < left


def test_adding_bodies_leaves_the_others_unchanged(engine):
    first = ball(engine, 0.0)
    engine.set_velocity(first, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0))
    asleep = ball(engine, 5.0)
    engine.sleep(asleep)
    run(engine, 0.1)
    before = engine.pose(first), engine.velocity(first)
    ball(engine, 9.0)
    assert (engine.pose(first), engine.velocity(first)) == before
    run(engine, 0.1)
    assert engine.pose(first)[0] == pytest.approx([0.2, 0.4, 1.6], abs=1e-6)
    assert engine.pose(asleep)[0] == (5.0, 0.0, 1.0)


def test_a_force_acts_for_one_step(engine):
    row = ball(engine, 0.0)
    engine.apply_forces([row], np.array([[MASS * 10.0, 0.0, 0.0]]))
    engine.step(0.02)
    assert engine.velocity(row)[0][0] == pytest.approx(0.2, abs=1e-9)
    engine.step(0.02)
    assert engine.velocity(row)[0][0] == pytest.approx(0.2, abs=1e-9)


def test_poses_refer_to_the_origin_and_velocities_to_the_center_of_mass(engine):
    row = engine.add_body(
        BodyDefinition(
            shape=Compound((Part(Box((0.4, 0.4, 0.2)), (0.0, 0.0, 0.1)),)),
            surface=HARD,
            mass=10.0,
            center_of_mass=(0.1, 0.0, 0.2),
            inertia=(1.0, 1.0, 2.0),
            pos=(1.0, 2.0, 3.0),
        )
    )
    assert engine.pose(row)[0] == pytest.approx((1.0, 2.0, 3.0), abs=1e-6)
    engine.set_velocity(row, (0.5, 0.0, 0.0), (0.0, 0.0, math.pi))
    run(engine, 1.0)
    (x, y, z), (_, _, qz, qw) = engine.pose(row)
    assert 2.0 * math.atan2(abs(qz), abs(qw)) == pytest.approx(math.pi, abs=0.01), "half a turn about the center"
    assert (x, y, z) == pytest.approx((1.0 + 0.5 + 0.2, 2.0, 3.0), abs=0.005)
    assert engine.velocity(row)[1][2] == pytest.approx(math.pi, rel=1e-6)


def test_rays_hit_the_bodies_in_their_mask_but_not_the_body_they_start_in(engine):
    box = engine.add_body(BodyDefinition(shape=Box((1.0, 1.0, 1.0)), surface=HARD, group=1, pos=(2.0, 0.0, 0.0)))
    points = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    hull = engine.add_body(BodyDefinition(shape=Hull(points), surface=HARD, group=8, pos=(5.0, 0.0, 0.0)))
    start, end = np.zeros((3, 3)), np.array([[10.0, 0.0, 0.0], [-10.0, 0.0, 0.0], [10.0, 0.0, 0.0]])
    start[2] = (2.0, 0.0, 0.0)
    hits = engine.rays(start, end, 9)
    assert hits.row.tolist() == [box, -1, hull]
    assert hits.fraction == pytest.approx([0.15, 1.0, 2.5 / 8.0], abs=2e-4), "PyBullet gives hulls a margin of 1 mm"
    assert hits.normal[0] == pytest.approx([-1.0, 0.0, 0.0], abs=1e-6)
    assert engine.rays(start, end, 8).row.tolist() == [hull, -1, hull]


SCENE = """
import hashlib, numpy as np
from simcore.world.shapes import Box, Sphere
from simcore.world.contact_law import WALL, TerrainSurface
from simcore.world.world import PhysicsWorld

def digest():
    surface = TerrainSurface(name="ball", friction=0.8, restitution=0.55)
    with PhysicsWorld() as world:
        for x in (-0.3, 0.3):
            world.add_static("wall", Box((0.1, 1.0, 1.0)), (x, 0.0, 0.5), surface=WALL)
        rows = [world.add_piece_body("ball", Sphere(0.075), mass=0.215, surface=surface,
                                     pos=(0.01 * (i % 3), 0.2 * (i % 4), 0.1 + 0.2 * i)) for i in range(12)]
        for _ in range(60):
            world.step(0.02)
        state = world.engine.centers(rows).tobytes() + world.engine.velocities(rows).tobytes()
        return hashlib.sha256(state).hexdigest()
"""


def test_worlds_in_two_processes_agree_to_the_last_bit():
    names: dict = {}
    exec(SCENE, names)
    first = names["digest"]()
    other = PhysicsWorld()
    other.add_piece_body("ball", Sphere(RADIUS), mass=MASS, surface=BALL, pos=(0.0, 0.0, 1.0))
    other.step(0.013)
    second = names["digest"]()
    other.close()
    done = subprocess.run([sys.executable, "-c", SCENE + "print(digest())"], capture_output=True, text=True, check=True)
    assert first == second == done.stdout.strip()


# --- MuJoCo settings --------------------------------------------------------------------------------------------------


@pytest.mark.engines("mujoco")
@pytest.mark.parametrize("h", [0.02, 0.004])
@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.8])
def test_a_box_bounces_with_the_restitution_of_its_pair_at_any_time_within_a_step(h, restitution):
    """The contact spring has some 15 steps in half a period, so the rebound is right within a tenth."""
    with PhysicsWorld(floor=HARD, gravity=1e-9) as world:
        piece = TerrainSurface(name="piece", friction=0.5, restitution=restitution)
        for phase in np.linspace(0.0, 1.0, 6, endpoint=False).tolist():
            place = (3.0 * phase, 0.0, 0.1 + 3.0 * h * phase)
            row = world.add_piece_body("box", Box((0.2, 0.2, 0.2)), mass=0.6, surface=piece, pos=place)
            world.set_velocity(row, (0.0, 0.0, -3.0))
            run(world.engine, 0.1)
            assert world.engine.velocity(row)[0][2] == pytest.approx(3.0 * restitution, abs=0.2)


@pytest.mark.engines("mujoco")
def test_a_fixed_body_stays_in_place_when_a_robot_drives_into_it():
    with PhysicsWorld() as world:
        row = world.add_piece_body("box", Box((0.3, 0.3, 0.3)), mass=1.0, surface=BALL, pos=(2.7, 2.0, 0.15))
        world.engine.fix(row)
        robot = ChassisSimulation(world, ChassisConfig(), pose=(2.0, 2.0, 0.0))
        for _ in range(100):
            world.engine.set_velocity(robot.row, (2.0, 0.0, 0.0), (0.0, 0.0, 0.0))
            world.engine.step(0.005)
            assert row in world.engine.touching(robot.row) or world.engine.pose(robot.row)[0][0] < 2.2
        assert world.engine.pose(row) == ((2.7, 2.0, 0.15), (0.0, 0.0, 0.0, 1.0))
        assert world.engine.pose(robot.row)[0][0] < 2.2
