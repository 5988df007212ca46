"""Pieces against closed forms, on the real engine."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from simcore.match.motion import Motion
from simcore.physics.contact_law import CARPET, TerrainSurface
from simcore.physics.shapes import Box, Cylinder, Sphere
from simcore.physics.world import PhysicsWorld
from simcore.pieces.aerodynamics import Aerodynamics
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.piece_manager import GamePieceManager
from simcore.units import GRAVITY

SUBSTEPS = [1, 2, 3, 5, 10]
HARD = TerrainSurface(name="hard", friction=1.0, restitution=1.0)


def ball(aerodynamics: Aerodynamics | None = None) -> GamePieceConfig:
    return GamePieceConfig(
        name="Ball", shape=Sphere(0.075), mass=0.215, friction=0.8, restitution=0.5, aerodynamics=aerodynamics
    )


def play(world: PhysicsWorld, pieces: GamePieceManager, seconds: float, substeps: int) -> None:
    motion = Motion(world, pieces=pieces)
    for _ in range(round(seconds / 0.02)):
        motion.tick(steps=(substeps, 1))


@pytest.mark.parametrize("substeps", SUBSTEPS)
@pytest.mark.parametrize("restitution", [0.15, 0.5, 0.8])
@pytest.mark.parametrize("speed", [1.0, 3.0, 8.0])
def test_a_bounce_keeps_its_configured_restitution(substeps, restitution, speed):
    """Speed out over speed in, without gravity, whatever the phase of the hit within a step."""
    with PhysicsWorld(floor=HARD, gravity=1e-9) as world:
        for phase in np.linspace(0.0, 1.0, 5, endpoint=False):
            row = world.add_piece_body(
                "ball",
                Sphere(0.075),
                mass=0.2,
                surface=TerrainSurface(name="ball", friction=0.8, restitution=restitution),
                pos=(float(phase) * 10.0, 0.0, 0.075 + 0.2 + phase * speed * 0.02 / substeps),
            )
            world.set_velocity(row, (0.0, 0.0, -speed))
            for _ in range(math.ceil(0.25 / speed / 0.02) + 2):
                world.step(0.02, substeps=substeps)
            out = world.engine.velocity(row)[0][2] / speed
            assert out == pytest.approx(restitution, abs=0.05)


def roll(substeps: int, speed: float = 2.0) -> float:
    with PhysicsWorld(floor=CARPET) as world:
        pieces = GamePieceManager(world, [(ball(), 1)], field_size=(60.0, 20.0))
        slots = pieces.spawn("Ball", np.array([[2.0, 4.0, 0.075]]))
        pieces._wake(int(slots[0]))
        world.set_velocity(pieces._pool.rows[0], (speed, 0.0, 0.0), (0.0, speed / 0.075, 0.0))
        pieces.state.vel[0] = (speed, 0.0, 0.0)
        play(world, pieces, 8.0, substeps)
        assert len(pieces.awake) == 0, "it came to rest"
        return float(pieces.state.pos[0, 0]) - 2.0


def test_rolling_distance_follows_the_rolling_resistance_at_any_substep():
    """A pair with lever c decelerates a solid ball by c g / (1.4 r); x = v^2 / 2a."""
    lever = CARPET.rolling * 0.8
    expected = 2.0**2 / (2.0 * lever * GRAVITY / (1.4 * 0.075))
    distances = [roll(n) for n in (1, 4, 10)]
    assert distances == pytest.approx([expected] * 3, rel=0.02)
    assert max(distances) / min(distances) < 1.02


def rolling_ball(speed: float, heading: float, substeps: int, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Place and velocity of a ball that rolled for some time."""
    with PhysicsWorld(floor=CARPET) as world:
        row = world.add_piece_body("ball", Sphere(0.075), mass=0.2, surface=ball().surface, pos=(0.0, 0.0, 0.075))
        world.step(0.02, substeps=substeps)
        vx, vy = speed * math.cos(heading), speed * math.sin(heading)
        world.set_velocity(row, (vx, vy, 0.0), (-vy / 0.075, vx / 0.075, 0.0))
        for _ in range(round(seconds / 0.02)):
            world.step(0.02, substeps=substeps)
        return np.array(world.engine.pose(row)[0]), np.array(world.engine.velocity(row)[0])


ROLLING = CARPET.rolling * 0.8 * GRAVITY / (1.4 * 0.075)
"""What a ball loses on carpet [m/s^2]."""


@pytest.mark.parametrize("heading", [0.0, 15.0, 45.0, 100.0, 210.0])
def test_a_ball_rolls_straight_and_equally_far_in_every_direction(heading):
    """x = v^2 / 2a, along its heading."""
    (x, y, _), _ = rolling_ball(2.0, math.radians(heading), 2, 5.0)
    assert math.hypot(x, y) == pytest.approx(2.0**2 / (2.0 * ROLLING), rel=0.01)
    assert math.remainder(math.atan2(y, x) - math.radians(heading), math.tau) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("substeps", [1, 4, 8, 16])
@pytest.mark.parametrize("speed", [0.5, 1.0, 3.0])
def test_a_slow_ball_loses_speed_as_a_fast_one(speed, substeps):
    """v = v0 - a t, whatever the speed and the sub-steps."""
    seconds = min(0.5, 0.8 * speed / ROLLING)
    seconds = round(seconds / 0.02) * 0.02
    _, (vx, _, _) = rolling_ball(speed, 0.0, substeps, seconds)
    assert speed - vx == pytest.approx(ROLLING * seconds, rel=0.01)


def fly(config: GamePieceConfig, substeps: int, velocity: tuple[float, float, float], seconds: float) -> np.ndarray:
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(config, 1)], field_size=(40.0, 20.0))
        pieces.hold(pieces.stage("Ball", 1), 0)
        pieces.launch(0, (1.0, 4.0, 0.5), velocity)
        play(world, pieces, seconds, substeps)
        return pieces.state.pos[0].copy()


@pytest.mark.parametrize("substeps", SUBSTEPS)
@pytest.mark.parametrize(("speed", "elevation"), [(8.0, 60.0), (12.0, 50.0), (20.0, 30.0)])
def test_a_drag_flight_agrees_with_the_differential_equation(substeps, speed, elevation):
    config = ball(Aerodynamics(drag_coefficient=0.47))
    k = config.air.drag
    angle = math.radians(elevation)
    velocity = (speed * math.cos(angle), 0.0, speed * math.sin(angle))

    def motion(_t, y):
        return [*y[3:], *(-k * np.linalg.norm(y[3:]) * y[3:] + (0.0, 0.0, -GRAVITY))]

    solution = solve_ivp(motion, (0.0, 1.2), [1.0, 4.0, 0.5, *velocity], rtol=1e-10, atol=1e-12)
    expected = solution.y[:3, -1]
    got = fly(config, substeps, velocity, 1.2)
    length = np.linalg.norm(expected - (1.0, 4.0, 0.5))
    assert np.linalg.norm(got - expected) < 0.005 * length


def test_a_vacuum_flight_is_the_parabola_at_any_substep():
    for substeps in SUBSTEPS:
        got = fly(ball(), substeps, (5.0, 0.0, 6.0), 1.0)
        assert got == pytest.approx([6.0, 4.0, 0.5 + 6.0 - GRAVITY / 2], abs=1e-6)


def test_backspin_lifts_by_the_configured_slope():
    """a = (rho A / 2 m) Cl v^2: a short time, so that v hardly turns."""
    config = ball(Aerodynamics(drag_coefficient=0.47, lift_slope=1.0))
    with PhysicsWorld() as world:
        heights = []
        for spin in (0.0, -100.0):
            pieces = GamePieceManager(world, [(config, 1)], field_size=(40.0, 20.0))
            pieces.hold(pieces.stage("Ball", 1), 0)
            pieces.launch(0, (1.0, 4.0, 2.0), (10.0, 0.0, 0.0), (0.0, spin, 0.0))
            play(world, pieces, 0.2, 2)
            heights.append(pieces.state.pos[0, 2])
            pieces.score(np.array([0]))
    ratio = 0.075 * 100.0 / 10.0
    lift = config.air.drag / 0.47 * ratio / (1.0 + ratio / config.aerodynamics.lift_limit) * 10.0**2
    assert heights[1] - heights[0] == pytest.approx(0.5 * lift * 0.2**2, rel=0.05)


def test_four_hundred_balls_woken_at_once_stay_calm():
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(ball(), 400)], field_size=(16.0, 8.0))
        grid = np.array([[5 + 0.155 * i, 1 + 0.155 * j, 0.075] for i in range(20) for j in range(20)])
        slots = pieces.spawn("Ball", grid)
        for slot in slots:
            pieces._wake(int(slot))
        fastest = 0.0
        for _ in range(100):
            play(world, pieces, 0.02, 1)
            fastest = max(fastest, float(np.linalg.norm(pieces.state.vel, axis=1).max()))
        assert fastest < 0.05
        assert np.abs(pieces.state.pos - grid).max() < 0.002


@pytest.mark.parametrize("shape", [Cylinder(0.06, 0.3), Box((0.3, 0.3, 0.28))])
def test_other_shapes_stand_fall_and_sleep(shape):
    config = GamePieceConfig(name="Ball", shape=shape, mass=0.5)
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(config, 2)], field_size=(16.0, 8.0))
        pieces.spawn("Ball", np.array([[2.0, 2.0, 1.0], [4.0, 2.0, config.rest_height]]))
        assert len(pieces.awake) == 1, "only the one in the air"
        play(world, pieces, 3.0, 2)
        assert len(pieces.awake) == 0
        assert pieces.state.pos[1] == pytest.approx([4.0, 2.0, config.rest_height], abs=1e-9)
        assert 0.0 < pieces.state.pos[0, 2] <= config.bounding_radius + 0.002


@pytest.mark.parametrize("substeps", [1, 2, 5])
@pytest.mark.parametrize("speed", [0.05, 0.2, 0.6])
def test_a_ball_on_a_rail_slows_down_and_stays_where_it_stops(speed, substeps):
    """v = v0 - a t with a = c f g / (1.4 r), at any sub-step, and rest after v0^2 / 2a."""
    rail = TerrainSurface(name="rail", friction=0.5, restitution=0.3, rolling=0.001)
    rate = 0.001 * ball().surface.friction * GRAVITY / (1.4 * 0.075)
    with PhysicsWorld() as world:
        world.add_static("rail", Box((16.0, 0.3, 0.5)), (0.0, 0.0, 0.25), surface=rail)
        row = world.add_piece_body("ball", Sphere(0.075), mass=0.215, surface=ball().surface, pos=(-4.0, 0.0, 0.575))
        world.step(0.02, substeps=substeps)
        world.set_velocity(row, (speed, 0.0, 0.0), (0.0, speed / 0.075, 0.0))
        start = world.engine.pose(row)[0][0]
        half = round(0.5 * speed / rate / 0.02)
        for _ in range(half):
            world.step(0.02, substeps=substeps)
        assert speed - world.engine.velocity(row)[0][0] == pytest.approx(rate * half * 0.02, rel=0.02, abs=0.001)
        for _ in range(half + 100):
            world.step(0.02, substeps=substeps)
        assert abs(world.engine.velocity(row)[0][0]) < 0.002
        assert world.engine.pose(row)[0][0] - start == pytest.approx(speed**2 / (2.0 * rate), rel=0.05, abs=0.002)


def test_a_ball_rolls_against_its_own_resistance_on_all_things():
    """On a shelf as on the carpet: (c_shelf f_ball + c_ball f_shelf) g / (1.4 r)."""
    soft = replace(ball(), rolling=0.004).surface
    shelf = TerrainSurface(name="shelf", friction=0.5, restitution=0.3, rolling=0.001)
    with PhysicsWorld(floor=CARPET) as world:
        world.add_static("shelf", Box((4.0, 1.0, 0.2)), (0.0, 0.0, 1.0), surface=shelf)
        row = world.add_piece_body("ball", Sphere(0.075), mass=0.215, surface=soft, pos=(-1.0, 0.0, 1.175))
        world.step(0.02, substeps=2)
        world.set_velocity(row, (1.0, 0.0, 0.0), (0.0, 1.0 / 0.075, 0.0))
        for _ in range(50):
            world.step(0.02, substeps=2)
        lever = 0.001 * 0.8 + 0.004 * 0.5
        lost = lever * GRAVITY / (1.4 * 0.075)
        assert 1.0 - world.engine.velocity(row)[0][0] == pytest.approx(lost, rel=0.1)
