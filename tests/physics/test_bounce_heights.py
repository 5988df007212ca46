"""How high and how deep balls bounce: closed forms, at every phase of the hit and at any number of sub-steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.match.motion import Motion
from simcore.physics.contact_law import CARPET, WALL, TerrainSurface, hit_ball, hit_surface
from simcore.physics.shapes import Box, Sphere
from simcore.physics.world import PhysicsWorld
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.piece_manager import GamePieceManager

DT = 0.02
RADIUS = 0.075
FUEL = GamePieceConfig(name="Fuel", shape=Sphere(RADIUS), mass=0.215, friction=0.8, restitution=0.55)
HARD = TerrainSurface(name="hard", friction=1.0, restitution=1.0)


def tick(world: PhysicsWorld, pieces: GamePieceManager, substeps: int | None = None) -> int:
    motion = Motion(world, pieces=pieces)
    motion.tick(steps=None if substeps is None else (substeps, 1))
    return motion.substeps


def apex_after_a_drop(world: PhysicsWorld, heights: np.ndarray, substeps: int | None, fast: float = 0.0) -> np.ndarray:
    """Highest place of the lowest point after the first bounce [m], of balls far apart, each with its own phase."""
    pieces = GamePieceManager(world, [(FUEL, len(heights) + 1)], field_size=(60.0, 20.0))
    places = np.column_stack((2.0 + np.arange(len(heights)), np.full(len(heights), 4.0), RADIUS + heights))
    slots = pieces.spawn("Fuel", places)
    if fast:
        pieces.hold(pieces.stage("Fuel", 1), 0)
        pieces.launch(0, (1.0, 15.0, 8.0), (fast, 0.0, 0.0))
    path = []
    for _ in range(math.ceil(2.2 * math.sqrt(2 * heights.max() / world.gravity) / DT) + 10):
        tick(world, pieces, substeps)
        path.append(pieces.state.pos[slots, 2] - RADIUS)
    path = np.array(path)
    apexes = []
    for column, height in enumerate(heights):
        z = path[int(math.sqrt(2 * height / world.gravity) / DT) + 1 :, column]
        top = next(i for i in range(1, len(z) - 1) if z[i] >= z[i + 1] and z[i] >= z[i - 1])
        before, here, after = z[top - 1 : top + 2]  # the parabola through the three highest
        apexes.append(here + (after - before) ** 2 / (8 * (2 * here - before - after)))
    return np.array(apexes)


@pytest.mark.parametrize("surface", [CARPET, HARD], ids=lambda s: s.name)
@pytest.mark.parametrize("height", [0.3, 1.0, 2.5])
@pytest.mark.parametrize("substeps", [1, 2, 5, 16])
def test_a_ball_rises_to_e_squared_of_its_drop(surface, height, substeps):
    """Forty phases of the hit within a tick: the apex is e^2 h, within 1 %, on both engines."""
    phases = height + np.linspace(0.0, math.sqrt(2 * 9.80665 * height) * DT, 40, endpoint=False)
    e = FUEL.restitution * surface.restitution
    with PhysicsWorld(floor=surface) as world:
        apexes = apex_after_a_drop(world, phases, substeps)
    assert np.median(apexes / (e * e * phases)) == pytest.approx(1.0, abs=0.01)
    assert apexes == pytest.approx(e * e * phases, rel=0.01, abs=2e-4)


@pytest.mark.parametrize("fast", [10.0, 30.0])
def test_a_bounce_does_not_depend_on_a_fast_ball_elsewhere(fast):
    """It forces sub-steps on all."""
    heights = np.linspace(1.0, 1.2, 10)
    with PhysicsWorld() as world:
        alone = apex_after_a_drop(world, heights, None)
    with PhysicsWorld() as world:
        busy = apex_after_a_drop(world, heights, None, fast)
    assert busy == pytest.approx(alone, rel=0.02)


@pytest.mark.parametrize("thickness", [0.05, 0.3])
@pytest.mark.parametrize("angle", [0.0, 0.6])
@pytest.mark.parametrize("speed", [10.0, 30.0, 40.0])
def test_a_fast_ball_is_never_deep_in_a_wall(thickness, angle, speed):
    """At most 30 mm in at the end of any tick, and it comes back with the pair's restitution."""
    with PhysicsWorld() as world:
        world.add_static("wall", Box((thickness, 20.0, 6.0)), (8.0 + thickness / 2, 8.0, 3.0), surface=WALL)
        pieces = GamePieceManager(world, [(FUEL, 1)], field_size=(40.0, 20.0))
        slots = pieces.stage("Fuel", 1)
        deepest = -1.0
        for phase in range(12):
            pieces.hold(slots, 0)
            place = (4.0 + phase * speed * DT / 12, 6.0, 2.5)
            pieces.launch(0, place, (speed * math.cos(angle), speed * math.sin(angle), 0.0))
            for _ in range(math.ceil(5.0 / speed / math.cos(angle) / DT) + 1):
                tick(world, pieces)
                deepest = max(deepest, float(pieces.state.pos[slots[0], 0]) + RADIUS - 8.0)
            back = float(pieces.state.vel[slots[0], 0])
            e = FUEL.restitution * WALL.restitution
            assert back == pytest.approx(-e * speed * math.cos(angle), rel=0.05)
        assert -0.5 * speed * DT < deepest < 0.03


# --- the law of an impact -------------------------------------------------------------------------------------------


def test_a_ball_that_grips_keeps_two_sevenths_of_its_slip():
    """A solid ball without spin that hits with grip leaves rolling: 5/7 of its speed along the surface."""
    velocity, spin = hit_surface(
        (2.0, 0.0, -3.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), radius=0.1, restitution=0.5, friction=10.0
    )
    assert velocity == pytest.approx((2.0 * 5 / 7, 0.0, 1.5))
    assert spin == pytest.approx((0.0, velocity[0] / 0.1, 0.0))


def test_a_ball_that_slides_loses_mu_times_the_normal_impulse():
    velocity, _ = hit_surface(
        (5.0, 0.0, -2.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), radius=0.1, restitution=0.5, friction=0.1
    )
    assert velocity == pytest.approx((5.0 - 0.1 * 1.5 * 2.0, 0.0, 1.0))


def test_two_balls_keep_momentum_and_angular_momentum():
    masses, radii, normal = (0.2, 0.5), (0.05, 0.1), np.array((0.6, 0.0, 0.8))
    before_v, before_w = np.array([(-2.0, 0.3, -3.0), (1.0, 0.0, 0.5)]), np.array([(3.0, -20.0, 4.0), (0.0, 10.0, 0.0)])
    v, w = hit_ball(
        tuple(map(tuple, before_v)), tuple(map(tuple, before_w)), tuple(normal),
        radii=radii, masses=masses, restitution=0.4, friction=0.3,
    )  # fmt: skip
    v, w, m = np.array(v), np.array(w), np.array(masses)[:, None]
    assert (m * v).sum(axis=0) == pytest.approx((m * before_v).sum(axis=0))
    assert (v[0] - v[1]) @ normal == pytest.approx(-0.4 * (before_v[0] - before_v[1]) @ normal)
    arms = np.array([radii[0] * normal, -radii[1] * normal])  # centers, seen from the touching point
    inertia = 0.4 * m * np.array(radii)[:, None] ** 2
    moment = lambda v, w: (inertia * w + m * np.cross(arms, v)).sum(axis=0)  # noqa: E731
    assert moment(v, w) == pytest.approx(moment(before_v, before_w))
