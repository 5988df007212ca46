"""Foam with hysteresis: energy loss for any mass behind a ball, step length and ball stiffness."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from games.rebuilt.fuel import FUEL as REBUILT_FUEL
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.piece_manager import GamePieceManager
from simcore.units import GRAVITY, inches, pounds
from simcore.world.contact_law import BUMPER, CARPET, FRICTIONLESS, WALL
from simcore.world.shapes import Box, Sphere
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")
R = 0.075
FUEL = replace(REBUILT_FUEL, shape=Sphere(R), aerodynamics=None)


def awake(world: PhysicsWorld, kind: GamePieceConfig, places: list[tuple[float, float, float]]) -> GamePieceManager:
    """Spawn balls of a kind and wake them."""
    pieces = GamePieceManager(world, [(kind, len(places))], field_size=(16.0, 8.0))
    for slot in pieces.spawn(kind.name, np.array(places)).tolist():
        pieces._wake(slot)
    world.balls.begin_tick([], [])
    return pieces


def returned(speed: float, h: float) -> float:
    """Return the rebound speed of a 55 kg robot that rams a fuel at a wall, over its speed before; steps of h [s]."""
    with PhysicsWorld(floor=None, gravity=1e-9) as world:
        world.add_static("wall", Box((0.3, 4.0, 4.0)), (5.15, 4.0, 1.0), surface=WALL)
        awake(world, FUEL, [(5.0 - R, 4.0, 1.0)])
        row = world.add_robot_body(
            "robot", Box((0.8, 0.8, 0.4)), mass=55.0, surface=BUMPER, center_of_mass=(0.0, 0.0, 0.0),
            inertia=(5.0, 5.0, 5.0), pos=(5.0 - 2.0 * R - 0.41, 4.0, 1.0),
        )  # fmt: skip
        world.set_velocity(row, (speed, 0.0, 0.0))
        for _ in range(round((0.01 / speed + 1.0) / h)):
            world.advance(h)
        return -float(world.bodies.of(row)["vel"][0][0]) / speed


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
def test_a_robot_that_rams_a_pinned_fuel_rebounds_with_the_mean_restitution(speed):
    """Each contact stores half of the energy, so e^2 is the mean of both, though 55 kg is 250 times the mass of a fuel.

    The robot reverses slowly, within a quarter of a second, in which the foam relaxes: this changes e by up to 0.05.
    Steps of 0.25 ms give the same within 5 %.
    """
    wall, bumper = FUEL.restitution * WALL.restitution, FUEL.restitution * BUMPER.restitution
    coarse = returned(speed, 0.001)
    assert coarse == pytest.approx(math.sqrt(0.5 * (wall**2 + bumper**2)), abs=0.05)
    assert returned(speed, 0.00025) == pytest.approx(coarse, rel=0.05)


@pytest.mark.parametrize(("inch", "pound"), [(0.5, 20.6), (0.75, 42.0), (1.0, 77.0)])
def test_foam_under_a_load_rests_at_the_depth_that_the_maker_states(inch, pound):
    """A fuel as heavy as the load on AndyMark's plates rests at their depth 400 steps after it fell, within 3 %."""
    with PhysicsWorld() as world:
        pieces = awake(world, replace(FUEL, mass=pounds(pound)), [(4.0, 4.0, R + 0.01)])
        for _ in range(400):
            world.advance(0.005)
        assert R - pieces.state.pos[0, 2] == pytest.approx(inches(inch), rel=0.03)


@pytest.mark.parametrize("mass", [0.0027, 0.04, 0.2])
@pytest.mark.parametrize("restitution", [0.3, 0.6, 1.0])
def test_a_heap_of_light_stiff_balls_never_gains_energy(mass, restitution):
    """27 balls as stiff as their mass allows fall 0.5 m; kinetic plus potential energy never grows."""
    radius = 0.04
    kind = GamePieceConfig(name="Ball", shape=Sphere(radius), mass=mass, restitution=restitution)
    rng = np.random.default_rng(2)
    grid = np.array([(i, j, k) for i in range(3) for j in range(3) for k in range(3)])
    places = (2.02 * radius * grid + rng.normal(0.0, 1e-4, (27, 3)) + (4.0, 4.0, 0.5)).tolist()
    with PhysicsWorld(floor=replace(CARPET, restitution=0.8)) as world:
        balls = awake(world, kind, places)
        b = world.balls.balls
        levels = [mass * GRAVITY * balls.state.pos[:, 2].sum()]
        for _ in range(200):
            world.advance(0.005)
            moving = 0.5 * mass * (b.vel**2).sum() + 0.2 * mass * radius**2 * (b.spin**2).sum()
            levels.append(moving + mass * GRAVITY * b.pos[:, 2].sum())
        assert max(levels) <= levels[0] * 1.0001
        assert levels[-1] < 0.8 * levels[0], "and it has met the floor"


def test_stiff_contacts_do_not_change_the_step_of_other_balls():
    """A ball rolls to the same place whether or not two others hit each other with 12 m/s across the field."""
    ends = []
    for count in (1, 3):
        with PhysicsWorld() as world:
            pieces = awake(world, FUEL, [(3.0, 2.0, R), (12.0, 6.0, 1.0), (12.3, 6.0, 1.0)][:count])
            pieces.state.vel[0] = 2.0, 0.3, 0.0
            pieces.state.vel[1:count, 0] = (6.0, -6.0)[: count - 1]
            for _ in range(60):
                world.advance(0.005)
            ends.append((pieces.state.pos[0].tolist(), pieces.state.vel[0].tolist()))
            if count == 3:
                closing = pieces.state.vel[2, 0] - pieces.state.vel[1, 0]
                assert closing == pytest.approx(12.0 * FUEL.restitution**2, abs=12.0 * 0.04), "they have hit each other"
    assert ends[0] == ends[1]


def test_a_row_of_fuel_squeezed_at_a_wall_comes_to_rest_and_transmits_the_force():
    """A robot presses four fuel at a wall with 120 N for 2 s: the row is still, and foam at the wall has F(d) = 120 N.

    A smooth tube keeps the row from buckling.
    """
    with PhysicsWorld(floor=None, gravity=1e-9) as world:
        world.add_static("wall", Box((0.3, 4.0, 4.0)), (5.15, 4.0, 1.0), surface=WALL)
        for y, z in ((-1, 0), (1, 0), (0, -1), (0, 1)):
            place = (4.7, 4.0 + y * (R + 0.0505), 1.0 + z * (R + 0.0505))
            world.add_static(f"side {y} {z}", Box((0.6, 0.1, 0.1)), place, surface=FRICTIONLESS)
        pieces = awake(world, FUEL, [(5.0 - R - 2.0 * R * k, 4.0, 1.0) for k in range(4)])
        row = world.add_robot_body(
            "robot", Box((1.0, 0.1, 0.1)), mass=55.0, surface=BUMPER, center_of_mass=(0.0, 0.0, 0.0),
            inertia=(5.0, 5.0, 5.0), pos=(5.0 - 8.0 * R - 0.501, 4.0, 1.0),
        )  # fmt: skip
        body = world.bodies.of(row)
        for _ in range(2000):
            body["vel"] = (float(body["vel"][0][0]) + 1e-3 * 120.0 / 55.0, 0.0, 0.0)
            body["rate"] = 0.0
            world.advance(0.001)
        depth = R - (5.0 - float(pieces.state.pos[0, 0]))
        curve = FUEL.stiffness
        assert curve.linear * depth + curve.cubic * depth**3 == pytest.approx(120.0, rel=0.02)
        assert np.abs(pieces.state.vel).max() < 5e-3, "a step too long for the foam would shake them with 0.5 m/s"
