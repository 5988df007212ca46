"""Pieces other than balls stand, lie, slide, roll and fall according to their shape, on both engines."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from simcore import Match
from simcore.match.game import PieceSupply
from simcore.match.motion import Motion
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.piece_manager import GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.testing.benches import LoneChassis
from simcore.units import GRAVITY
from simcore.world.contact_law import CARPET, TerrainSurface
from simcore.world.field import FieldElement
from simcore.world.rotation import IDENTITY, from_rpy, matrix, multiply, rotate
from simcore.world.shapes import Box, Cylinder, Hull, cone, mass_properties, outline_points, torus, tube
from simcore.world.world import CollisionGroup, PhysicsWorld

LENGTH, OUTER, INNER = 0.3016, 0.1143 / 2, 0.1016 / 2
TUBE = GamePieceConfig(
    name="Tube",
    shape=tube(length=LENGTH, outer_radius=OUTER, inner_radius=INNER),
    mass=0.65,
    friction=0.5,
    restitution=0.3,
)
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.165
KINDS = {
    "disc": GamePieceConfig(name="disc", shape=Cylinder(0.2, 0.03), mass=0.3, friction=0.5, restitution=0.3),
    "cone": GamePieceConfig(
        name="cone", shape=cone(height=0.4, bottom_radius=0.15, top_radius=0.03), mass=0.5, friction=0.5
    ),
    "ring": GamePieceConfig(name="ring", shape=torus(ring_radius=0.15, tube_radius=0.025), mass=0.25, friction=0.5),
    "cube": GamePieceConfig(name="cube", shape=Hull(CUBE), mass=1.4, friction=0.5, restitution=0.1),
    "Tube": TUBE,
}
LYING = from_rpy(0.0, math.pi / 2, 0.0)


def low_gap(match: Match, slot: int) -> float:
    """Return the gap between the carpet and the lowest point of a piece [m]."""
    kind = match.pieces.types[match.pieces.state.kind[slot]]
    w, x, y, z = match.pieces.attitudes(np.array([slot]))[0].tolist()
    return float(match.pieces.state.pos[slot, 2]) - kind.rest_height_at((x, y, z, w))


def test_pieces_of_any_shape_land_without_sinking_and_come_to_rest(engine_name):
    """Dropped from up to 1.3 m or thrown down, a piece sinks at most 5 mm into the carpet, 8 mm on MuJoCo."""
    drops = [
        ("Tube", IDENTITY, 0.152, 0.0),
        ("Tube", LYING, 0.06, 0.0),
        ("Tube", from_rpy(0.3, 0.8, 0.0), 0.3, 1.0),
        ("disc", IDENTITY, 1.3, 0.0),
        ("cone", from_rpy(0.3, 0.0, 0.0), 0.5, 2.0),
        ("ring", from_rpy(0.9, 0.0, 0.0), 0.5, 1.0),
        ("cube", from_rpy(0.3, 0.2, 0.0), 0.5, 2.0),
    ]
    with Match.bare(pieces=[PieceSupply(kind, 3) for kind in KINDS.values()]) as match:
        slots = []
        for number, (name, quat, height, speed) in enumerate(drops):
            slot = match.pieces.spawn(name, np.array([[4.0 + number, 5.0, height]]), np.array([quat]))
            match.pieces.push(slot, np.array([[0.0, 0.0, -speed]]))
            slots.append(int(slot[0]))
        deepest = np.zeros(len(slots))
        for _ in range(150):
            match.tick()
            deepest = np.minimum(deepest, [low_gap(match, slot) for slot in slots])
        assert deepest.min() > (-0.008 if engine_name == "mujoco" else -0.005), dict(
            zip([name for name, *_ in drops], deepest, strict=True)
        )
        gaps = [low_gap(match, slot) for slot in slots]
        assert gaps == pytest.approx([0.0] * len(slots), abs=0.002)
        assert (match.pieces.state.status[slots] == PieceStatus.ASLEEP).all()
        assert match.pieces.state.pos[slots[:2], 2] == pytest.approx([LENGTH / 2, OUTER], abs=0.001)
        published = match.snapshot().pose_arrays["Sim/GamePieces/Tube"][:2, 3:]
        assert np.abs(published @ np.array([1.0, 0.0, 0.0, 0.0]))[0] == pytest.approx(1.0, abs=1e-3)
        assert abs(rotate((*published[1, 1:], published[1, 0]), (0.0, 0.0, 1.0))[2]) < 0.02


@pytest.mark.parametrize("rolls", [True, False], ids=["rolling", "sliding"])
def test_a_tube_rolls_and_slides_down_a_ramp_at_the_theoretical_acceleration(rolls, engine_name):
    """a = g sin a / (1 + I / m r^2) rolling, g (sin a - mu cos a) sliding along its axis.

    A tube of 96 faces loses energy at each face: 15 % of the distance after 0.8 s in steps of 4 ms on PyBullet, 8 % on
    MuJoCo.
    """
    slope, mu = math.radians(20.0), 1.0 if rolls else 0.2
    turn = from_rpy(0.0, slope, 0.0)
    up, down = np.array(rotate(turn, (0.0, 0.0, 1.0))), np.array(rotate(turn, (1.0, 0.0, 0.0)))
    ramp = TerrainSurface(name="ramp", friction=mu, restitution=0.3)
    with PhysicsWorld(engine=engine_name) as world:
        top = np.array([8.0, 4.0, 3.0])
        world.add_static("ramp", Box((8.0, 2.0, 0.5)), top - 0.25 * up, surface=ramp, quat=turn)
        pieces = GamePieceManager(world, [(replace(TUBE, friction=1.0), 1)], field_size=(16.0, 8.0))
        start = top - 2.0 * down + (OUTER + 0.0005) * up
        attitude = multiply(turn, from_rpy(math.pi / 2, 0.0, 0.0) if rolls else LYING)
        slot = pieces.spawn("Tube", start[None], np.array([attitude]))[0]
        for _ in range(40):
            Motion(world, pieces=pieces).tick()
        away = pieces.state.pos[slot] - start
    inertia = (INNER**2 + OUTER**2) / 2.0 / OUTER**2
    theory = GRAVITY * (math.sin(slope) / (1.0 + inertia) if rolls else math.sin(slope) - mu * math.cos(slope))
    way = 0.5 * theory * 0.8**2
    assert (0.83 if rolls else 0.98) * way < away @ down < 1.02 * way
    assert away @ up == pytest.approx(0.0, abs=0.005)


@pytest.mark.parametrize(("speed", "yaw"), [(0.8, 0.0), (1.2, math.pi / 4), (1.6, 0.0)])
def test_rolling_resistance_slows_a_rolling_tube_by_0_9_to_1_8_times_the_theory(speed, yaw, engine_name):
    """a = c g / (r (1 + I / m r^2)), where c is the lever arm of the pair; the tube slides first.

    Engines resist rolling about fixed axes, and a tube of 96 faces loses energy at each face: up to 1.8 times as much.
    """
    tube_kind = replace(TUBE, friction=0.35, rolling=0.0023, stiffness=1e5)
    lever = CARPET.rolling * tube_kind.friction + tube_kind.rolling * CARPET.friction
    slowing = lever * GRAVITY / (OUTER + (INNER**2 + OUTER**2) / 2.0 / OUTER)
    ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    with Match.bare(pieces=[PieceSupply(tube_kind, 1)], start=(14.0, 7.0, 0.0)) as match:
        attitude = multiply(from_rpy(0.0, 0.0, yaw), from_rpy(math.pi / 2, 0.0, 0.0))
        slots = match.pieces.spawn("Tube", np.array([[4.0, 3.0, OUTER + 1e-4]]), np.array([attitude]))
        match.play(0.3)
        match.pieces.push(slots, np.array([1.9 * speed * ahead]))
        match.play(0.9)
        before = match.pieces.state.vel[slots[0]] @ ahead
        match.play(0.8)
        lost = before - match.pieces.state.vel[slots[0]] @ ahead
        assert 0.9 * 0.8 * slowing < lost < 1.8 * 0.8 * slowing


def test_a_tumbling_body_precesses_and_conserves_its_energy(engine_name):
    """A symmetric top: its axis turns about L at |L| / I_across with constant energy.

    MuJoCo evaluates the gyroscopic torque at the start of its steps of 0.5 ms, which adds 1.2 % in 1.5 s.
    """
    mass, h = 0.65, 0.005
    moments = mass * np.diag(mass_properties(TUBE.shape).inertia)
    with PhysicsWorld(engine=engine_name, floor=None, gravity=0.0) as world:
        row = world.add_piece_body("tube", TUBE.shape, mass=mass, surface=TUBE.surface, pos=(4.0, 4.0, 2.0))
        spin = np.array([5.0, 0.0, 8.0])
        world.set_velocity(row, (0.0, 0.0, 0.0), spin)
        momentum = moments * spin
        rate, way = np.linalg.norm(momentum) / moments[0], momentum / np.linalg.norm(momentum)
        for _ in range(300):
            world.engine.step(h)
        axes = matrix(world.engine.pose(row)[1])
        spin = np.array(world.engine.velocity(row)[1])
        energy = spin @ axes @ np.diag(moments) @ axes.T @ spin
    assert energy == pytest.approx(momentum @ (momentum / moments), rel=0.02 if engine_name == "mujoco" else 0.01)
    along = way * way[2]
    start = np.array([0.0, 0.0, 1.0]) - along
    angle = rate * 300 * h
    theory = along + math.cos(angle) * start + math.sin(angle) * np.cross(way, start)
    assert axes[:, 2] == pytest.approx(theory, abs=0.05)


@pytest.mark.parametrize("over", [-1.2, 1.2])
def test_a_block_starts_to_slide_at_the_friction_angle(over, engine_name):
    """1.2 degrees above the friction angle the block accelerates by 0.22 m/s^2 and stays awake; below, it rests."""
    friction, slope = 0.4, math.atan(0.4) + math.radians(over)
    turn = from_rpy(0.0, slope, 0.0)
    up, down = np.array(rotate(turn, (0.0, 0.0, 1.0))), np.array(rotate(turn, (1.0, 0.0, 0.0)))
    block = GamePieceConfig(name="block", shape=Box((0.3, 0.3, 0.1)), mass=2.0, friction=1.0, restitution=0.0)
    with PhysicsWorld(engine=engine_name) as world:
        top = np.array([8.0, 4.0, 3.0])
        surface = TerrainSurface(name="ramp", friction=friction, restitution=0.0)
        world.add_static("ramp", Box((8.0, 2.0, 0.5)), top - 0.25 * up, surface=surface, quat=turn)
        pieces = GamePieceManager(world, [(block, 1)], field_size=(16.0, 8.0))
        start = top - 2.0 * down + 0.0505 * up
        slot = pieces.spawn("block", start[None], np.array([turn]))[0]
        for _ in range(50):
            Motion(world, pieces=pieces).tick()
        way = float((pieces.state.pos[slot] - start) @ down)
    theory = 0.5 * GRAVITY * (math.sin(slope) - friction * math.cos(slope))
    assert way == pytest.approx(max(0.0, theory), rel=0.08, abs=0.002)


def test_a_block_slides_down_a_hull_at_the_theoretical_acceleration(engine_name):
    """a = g (sin a - mu cos a) at any step length, and the block does not sink in."""
    slope, mu = math.radians(20.0), 0.2
    rise = 6.0 * math.tan(slope)
    points = np.array([(x, y, z) for y in (-1.0, 1.0) for x, z in ((0.0, 0.0), (6.0, 0.0), (0.0, rise))])
    up, turn = np.array([math.sin(slope), 0.0, math.cos(slope)]), from_rpy(0.0, slope, 0.0)
    for h in (0.005, 0.02):
        with PhysicsWorld(engine=engine_name) as world:
            ramp = TerrainSurface(name="ramp", friction=mu, restitution=0.0)
            world.add_static("ramp", Hull(points), (4.0, 4.0, 0.0), surface=ramp)
            block = TerrainSurface(name="block", friction=1.0, restitution=0.0)
            start = np.array([4.5, 4.0, rise - 0.5 * math.tan(slope)]) + 0.1001 * up
            row = world.add_piece_body("block", Box((0.3, 0.3, 0.2)), mass=2.0, surface=block, pos=start)
            world.set_pose(row, start, turn)
            for _ in range(round(0.8 / h)):
                world.engine.step(h)
            pos, speed = np.array(world.engine.pose(row)[0]), math.hypot(*world.engine.velocity(row)[0])
        assert speed == pytest.approx(0.8 * GRAVITY * (math.sin(slope) - mu * math.cos(slope)), rel=0.05)
        assert (pos - start) @ up == pytest.approx(0.0, abs=0.003)


def test_a_tube_slides_over_a_pipe_only_if_the_pipe_meets_its_bore():
    """The bore is 101.6 mm wide and the pipe 42.2 mm: a tube with its axis within 29.7 mm slides down to the carpet."""
    steel = TerrainSurface(name="steel", friction=0.5, restitution=0.3)
    places = [(3.0, 0.0), (5.0, 0.02), (7.0, 0.045)]
    pipes = [
        FieldElement(name=f"pipe {x}", shape=Cylinder(0.0211, 1.0), position=np.array([x, 5.0, 0.5]), surface=steel)
        for x, _ in places
    ]
    with Match.bare(pieces=[PieceSupply(TUBE, 3)], elements=pipes) as match:
        slots = match.pieces.spawn("Tube", np.array([[x + beside, 5.0, 1.2] for x, beside in places]))
        match.play(2.5)
        over, aside, missed = match.pieces.state.pos[slots]
    for place, (x, _) in zip((over, aside), places, strict=False):
        assert place[2] == pytest.approx(LENGTH / 2, abs=0.002)
        assert math.hypot(place[0] - x, place[1] - 5.0) < INNER - 0.0211 + 0.001
    assert math.hypot(missed[0] - 7.0, missed[1] - 5.0) > OUTER


@pytest.mark.parametrize(("kind", "quat"), [("cube", IDENTITY), ("Tube", IDENTITY), ("Tube", LYING)])
def test_a_robot_pushes_a_piece_against_the_wall_but_not_into_it(kind, quat):
    """The robot drives into a wall at x = 16 m: 600 N compress a stiffness of 1e5 N/m by 6 mm."""
    config = KINDS[kind]
    with Match.bare(pieces=[PieceSupply(config, 1)], start=(14.0, 2.0, 0.0)) as match:
        place = np.array([[14.9, 2.0, config.rest_height_at(quat)]])
        slots = match.pieces.spawn(config.name, place, np.array([quat]))
        match.robots[0].drive.set_volts([4.0] * 4, [0.0] * 4)
        match.play(2.5)
        w, x, y, z = match.pieces.attitudes(slots)[0].tolist()
        points = outline_points(config.shape) @ matrix((x, y, z, w)).T + match.pieces.state.pos[slots[0]]
        assert 15.97 < points[:, 0].max() < 16.007
        assert points[:, 2].min() > -0.005 and match.pieces.recovered == 0


@pytest.mark.parametrize(("height", "attitude"), [(1.0, IDENTITY), (3.0, IDENTITY), (3.0, LYING)])
def test_a_tube_that_falls_on_a_robot_stays_on_top(height, attitude, engine_name):
    """The overlap stays below 20 mm, the distance that a point of the tube moves in an engine step."""
    with PhysicsWorld(engine=engine_name) as world:
        chassis = ChassisSimulation(world, ChassisConfig(), pose=(4.0, 4.0, 0.0))
        pieces = GamePieceManager(world, [(TUBE, 1)], field_size=(16.0, 8.0))
        motion = Motion(world, robots=[LoneChassis(chassis)], pieces=pieces)
        slots = pieces.spawn("Tube", np.array([[4.05, 4.0, height]]), np.array([attitude]))
        depths = []
        for _ in range(100):
            motion.tick()
            w, x, y, z = pieces.attitudes(slots)[0].tolist()
            lowest = float(pieces.state.pos[slots[0], 2]) - TUBE.rest_height_at((x, y, z, w))
            if math.dist(pieces.state.pos[slots[0], :2], (4.0, 4.0)) < 0.25:
                depths.append(chassis.config.height - lowest)
    assert len(depths) > 20 and max(depths) < 0.02


def test_a_tube_has_no_gaps_around_its_circumference():
    """Rays from outside hit all its staves, in both halves of its length."""
    with Match.bare(pieces=[PieceSupply(TUBE, 1)]) as match:
        match.world.add_piece_body("tube", TUBE.shape, mass=TUBE.mass, surface=TUBE.surface, pos=(6.0, 4.0, 2.0))
        turn = np.repeat(np.arange(36) * math.tau / 36 + 0.01, 2)
        ends = np.column_stack((np.full(72, 6.0), np.full(72, 4.0), np.tile((1.93, 2.07), 36)))
        starts = ends + 0.3 * np.column_stack((np.cos(turn), np.sin(turn), np.zeros(72)))
        hits = match.world.engine.rays(starts, ends, CollisionGroup.PIECE)
        assert 0.3 * (1.0 - hits.fraction) == pytest.approx(OUTER, abs=5e-4)


def test_friction_stops_a_lying_tube_that_spins(engine_name):
    """A contact line of length l resists with mu m g l / 4: 5 rad/s end within half a second, not in ten."""
    with PhysicsWorld(engine=engine_name) as world:
        rows = []
        for number, turn in enumerate((0.0, 3.75, 7.5, 15.0)):
            pos = (2.0 + number, 4.0, OUTER + 0.0005)
            row = world.add_piece_body("tube", TUBE.shape, mass=TUBE.mass, surface=TUBE.surface, pos=pos)
            world.set_pose(row, pos, multiply(LYING, from_rpy(0.0, 0.0, math.radians(turn))))
            world.set_velocity(row, (0.0, 0.0, 0.0), (0.0, 0.0, 5.0))
            rows.append(row)
        world.step(0.5, substeps=125)
        assert np.abs(world.engine.velocities(rows)[:, 5]).max() < 0.2


@pytest.mark.parametrize("stiffness", [1500.0, 3000.0])
@pytest.mark.parametrize("restitution", [0.5, 0.9])
def test_an_inflated_cube_bounces_and_rests_as_configured(stiffness, restitution):
    """Dropped flat from h, the cube rebounds to e^2 h with the e of the pair, and rests less than m g / k deep.

    Four corners share the weight. Errors are up to a fifth: the spring has damping, and steps of 5 ms are coarse.
    """
    cube = GamePieceConfig(
        name="Cube", shape=Box((0.2413,) * 3), mass=0.07, stiffness=stiffness, restitution=restitution
    )
    drop, bounce = 0.5, restitution * CARPET.restitution
    with Match.bare(pieces=[PieceSupply(cube, 1)]) as match:
        (slot,) = match.pieces.spawn("Cube", np.array([[8.0, 4.0, cube.rest_height + drop]]))
        gaps = []
        for _ in range(200):
            match.tick()
            gaps.append(low_gap(match, slot))
    touch = next(i for i, (before, after) in enumerate(pairwise(gaps)) if after > before)
    assert max(gaps[touch:]) == pytest.approx(bounce**2 * drop, rel=0.2, abs=0.001)
    assert -cube.mass * GRAVITY / stiffness <= gaps[-1] <= 1e-4
