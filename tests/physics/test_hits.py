"""Hits of balls that roll or lie: as binary hits in their order say, and never with more energy after than before."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.match.game import PieceSupply
from simcore.match.match import Match
from simcore.physics.shapes import Sphere
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.pool import PieceStatus
from simcore.units import GRAVITY, TICK

RADIUS, MASS = 0.075, 0.215
INERTIA = 0.4 * MASS * RADIUS**2
PITCH = 0.152
PRESSED = 0.0005
"""By how much contacts may lift a ball that lies, half of the engines' contact distance [m]."""


def ball(e: float, friction: float = 0.0) -> GamePieceConfig:
    """A ball whose hits on its like have a restitution e."""
    return GamePieceConfig(
        name="Ball", shape=Sphere(RADIUS), mass=MASS, friction=friction, restitution=math.sqrt(e), rolling=0.0
    )


def binary_hits(e: float, speed: float, start: float, seconds: float) -> np.ndarray:
    """Velocities along a row of six equal balls, the first of which comes from `start` before it [m/s]."""
    x, v, now = np.array([-start, *(PITCH * i for i in range(5))]), np.array([speed, 0.0, 0.0, 0.0, 0.0, 0.0]), 0.0
    while True:
        closing = v[:-1] - v[1:]
        gap = np.maximum(np.diff(x) - 2 * RADIUS, 0.0)
        times = np.where(closing > 1e-9, gap / np.maximum(closing, 1e-9), np.inf)
        k = int(times.argmin())
        if now + times[k] > seconds:
            return v
        x, now = x + times[k] * v, now + times[k]
        middle, half = 0.5 * (v[k] + v[k + 1]), 0.5 * e * closing[k]
        v[k], v[k + 1] = middle - half, middle + half


# PyBullet: gentler hits than 0.3 m/s are its own, whose springs push with a sixth of the closing speed: a row that
# comes to one speed in inelastic hits keeps differences of up to 0.05 m/s
@pytest.mark.parametrize("speed", [1.0, 3.0, 6.0])
@pytest.mark.parametrize("e", [0.3, 1.0])
def test_a_row_of_sleepers_passes_a_hit_on_in_binary_hits(e, speed, engine_name):
    with Match.bare(start=(14.0, 7.0, 0.0), pieces=[PieceSupply(ball(e), 6)], engine=engine_name) as match:
        row = match.pieces.spawn("Ball", np.array([(4.0 + PITCH * i, 4.0, RADIUS) for i in range(5)]))
        shot = match.pieces.spawn("Ball", np.array([(3.7, 4.0, RADIUS)]))
        match.play(0.2)
        match.pieces.push(shot, np.array([[speed, 0.0, 0.0]]))
        seconds = TICK * math.ceil((0.3 / speed + 0.2) / TICK)
        match.play(seconds)
        measured = match.pieces.state.vel[[*shot, *row], 0]
    expected = binary_hits(e, speed, 0.3, seconds)
    gentle = 0.05 if engine_name == "bullet" and e < 1.0 else 0.0
    assert measured == pytest.approx(expected, rel=0.05, abs=max(gentle, 0.002 * speed))
    assert measured.sum() == pytest.approx(speed, rel=0.005)


def energy(match: Match) -> float:
    """Of all balls: of motion, of spin and of height over the carpet [J]."""
    pieces, engine, total = match.pieces, match.world.engine, 0.0
    for slot in pieces.on_field().tolist():
        row = pieces._pool.rows[slot]
        if pieces.state.status[slot] == PieceStatus.IN_FLIGHT:
            flying = pieces._flying
            height, vel, spin = flying._pos[slot, 2], flying._vel[slot], flying._spin[slot]
        else:
            height, (vel, spin) = engine.pose(row)[0][2], engine.velocity(row)
        total += 0.5 * MASS * float(np.square(vel).sum()) + 0.5 * INERTIA * float(np.square(spin).sum())
        total += MASS * GRAVITY * (height - RADIUS)
    return total


@pytest.mark.parametrize("seed", [0, 3, 4, 8, 10, 12, 16, 19])
def test_balls_that_roll_into_each_other_walls_and_a_robot_never_gain_energy(seed, engine_name):
    """5 to 30 balls, e 0 to 1, 0.3 to 6 m/s; by what contacts may lift those that lie, energy may rise."""
    rng = np.random.default_rng(seed)
    count, e, speed = int(rng.integers(5, 31)), float(rng.uniform(0.0, 1.0)), float(rng.uniform(0.3, 6.0))
    kind = ball(e, float(rng.choice([0.0, 0.3, 0.8])))
    with Match.bare(
        start=(1.5, 1.5, 0.3), size=(3.0, 3.0), pieces=[PieceSupply(kind, count)], engine=engine_name
    ) as match:
        match.play(0.5)
        places: list[np.ndarray] = []
        while len(places) < count:
            place = rng.uniform(0.12, 2.88, 2)
            if np.abs(place - 1.5).max() > 0.75 and all(math.dist(place, p) > 0.1502 for p in places):
                places.append(place)
        slots = match.pieces.spawn("Ball", np.column_stack((places, np.full(count, RADIUS))))
        angle, speeds = rng.uniform(0.0, math.tau, count), speed * rng.uniform(0.0, 1.0, count)
        match.pieces.push(slots, np.column_stack((speeds * np.cos(angle), speeds * np.sin(angle), np.zeros(count))))
        lowest, rise = energy(match), 0.0
        for _ in range(100):
            match.tick()
            now = energy(match)
            rise, lowest = max(rise, now - lowest), min(lowest, now)
        assert len(match.pieces.on_field()) == count
    assert rise < count * MASS * GRAVITY * PRESSED
