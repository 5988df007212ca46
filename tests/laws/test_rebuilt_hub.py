"""Fuel meets the generated hub in PyBullet: it falls through the throat, and none stays on top."""

import math
from pathlib import Path

import numpy as np
import pytest

from games.rebuilt import dimensions as dim
from games.rebuilt.field import FIELD
from simcore.world.field import FieldGeometry
from simcore.world.shapes import Box, Hull

pybullet = pytest.importorskip("pybullet", reason="needs PyBullet, of which Python 3.14 has no wheel: steps it by hand")

MODEL = Path(__file__).resolve().parents[2] / "models" / "rebuilt" / "field_collision.obj"
RADIUS, MASS = 0.075, 0.215
TICK, STEPS = 0.02, 5


@pytest.fixture
def bullet():
    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0, 0, -9.80665, physicsClientId=client)
    pybullet.setPhysicsEngineParameter(
        contactBreakingThreshold=0.001, deterministicOverlappingPairs=1, physicsClientId=client
    )
    pybullet.setTimeStep(TICK / STEPS, client)
    yield client
    pybullet.disconnect(client)


def build(client, keep):
    for element in FieldGeometry.load(MODEL).elements:
        if not keep(element.name):
            continue
        if isinstance(element.shape, Box):
            half = [length / 2.0 for length in element.shape.size]
            shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
        else:
            assert isinstance(element.shape, Hull)
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_MESH, vertices=element.shape.points.tolist(), physicsClientId=client
            )
        body = pybullet.createMultiBody(0, shape, basePosition=element.position.tolist(), physicsClientId=client)
        pybullet.changeDynamics(body, -1, lateralFriction=0.5, restitution=0.8, physicsClientId=client)


def add_ball(client, position, velocity=(0.0, 0.0, 0.0)):
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=RADIUS, physicsClientId=client)
    ball = pybullet.createMultiBody(MASS, shape, basePosition=list(position), physicsClientId=client)
    pybullet.changeDynamics(
        ball, -1, lateralFriction=0.8, restitution=0.55, linearDamping=0, angularDamping=0, physicsClientId=client
    )
    pybullet.resetBaseVelocity(ball, list(velocity), physicsClientId=client)
    return ball


def place(client, ball):
    return np.array(pybullet.getBasePositionAndOrientation(ball, physicsClientId=client)[0])


def in_throat(position, center):
    """Return whether the ball center is below the throat, above the base and inside the hexagon."""
    x, y, z = position
    inside = math.hypot(x - center[0], y - center[1]) < dim.HUB_THROAT_CIRCUMRADIUS
    return inside and dim.HUB_BOX_TOP < z < dim.HUB_THROAT_HEIGHT


def step(client, ticks, visit):
    for _ in range(ticks):
        for _ in range(STEPS):
            pybullet.stepSimulation(client)
        visit()


@pytest.mark.parametrize("alliance", ["blue", "red"])
def test_fuel_above_the_opening_falls_through_the_throat(bullet, alliance):
    """30 balls in groups of 3, scored and removed as in the game; each passes within 4 s."""
    build(bullet, lambda name: name.startswith(f"{alliance}_hub"))
    center = dim.HUB_CENTER if alliance == "blue" else FIELD.symmetry.flip_point(*dim.HUB_CENTER)
    rng = np.random.default_rng(2026)
    scored = 0
    for _ in range(10):
        balls = []
        while len(balls) < 3:
            x, y = rng.uniform(-0.5, 0.5, 2)
            # ball center above the hexagon, 0.1 m away from its edges and the backboard
            if max(abs(x), abs(x / 2) + abs(y) * math.sqrt(3) / 2) < dim.HUB_OPENING_APOTHEM - 0.1:
                height = 2.0 + 0.3 * len(balls)
                balls.append(add_ball(bullet, (center[0] + x, center[1] + y, height), (*rng.normal(0, 0.3, 2), -1.0)))

        def remove_scored(balls=balls):
            nonlocal scored
            for ball in list(balls):
                if in_throat(place(bullet, ball), center):
                    pybullet.removeBody(ball, physicsClientId=bullet)
                    balls.remove(ball)
                    scored += 1

        step(bullet, 200, remove_scored)
        for ball in balls:
            position = place(bullet, ball)
            assert position[2] < dim.HUB_BOX_TOP, f"stuck in or on the hub at {position}"
            pybullet.removeBody(ball, physicsClientId=bullet)
    assert scored >= 29  # 95 % of 30: a ball may bounce out over the rim; in a longer trial 120 of 120 passed


def test_no_ball_stays_on_top_of_the_hub(bullet):
    """Balls dropped all over the hub, inside and outside the opening, score or reach the ground within 6 s."""
    build(bullet, lambda name: name.startswith("blue_hub"))
    cx, cy = dim.HUB_CENTER
    rng = np.random.default_rng(7)
    for _ in range(8):
        balls = [
            add_ball(bullet, (cx + x, cy + y, 2.2 + 0.4 * i))
            for i, (x, y) in enumerate(rng.uniform(-0.66, 0.66, (5, 2)))
            if x < 0.45
        ]

        def remove_done(balls=balls):
            for ball in list(balls):
                position = place(bullet, ball)
                if in_throat(position, (cx, cy)) or position[2] < 0.5:
                    pybullet.removeBody(ball, physicsClientId=bullet)
                    balls.remove(ball)

        step(bullet, 300, remove_done)
        assert not balls, [place(bullet, ball) for ball in balls]


@pytest.mark.parametrize("speed", [10.0, 20.0, 30.0])
def test_no_ball_enters_the_hub_from_the_side(bullet, speed):
    """No shot at the skirt between base and rim, from all around, enters the volume under the throat."""
    build(bullet, lambda name: name.startswith("blue_hub"))
    cx, cy = dim.HUB_CENTER
    pybullet.setTimeStep(0.09 / max(speed, 18.0), bullet)
    for angle in np.arange(0.0, math.tau, math.tau / 24):
        for height in (1.3, 1.5, 1.7):
            outward = np.array([math.cos(angle), math.sin(angle)])
            start = np.array([cx, cy]) + 1.0 * outward
            ball = add_ball(bullet, (*start, height), (*(-speed * outward), 0.0))
            for _ in range(60):
                pybullet.stepSimulation(bullet)
                x, y, z = place(bullet, ball)
                is_inside = math.hypot(x - cx, y - cy) < dim.HUB_THROAT_CIRCUMRADIUS and z < dim.HUB_OPENING_HEIGHT
                assert not is_inside, f"from {math.degrees(angle):.0f} degrees at z = {height}: at {x, y, z}"
            pybullet.removeBody(ball, physicsClientId=bullet)
