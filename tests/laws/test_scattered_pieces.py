"""Pieces that vary from their kind: effect of each factor on flight, bounce and hits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from simcore.match.game import PieceSupply
from simcore.match.match import Match
from simcore.match.scatter import Scatter, ScatterDraws, piece_variation
from simcore.pieces.aerodynamics import Aerodynamics
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.pool import PieceStatus
from simcore.world.shapes import Sphere

pytestmark = pytest.mark.engines("bullet")

N = 12
BALL = GamePieceConfig(name="Ball", shape=Sphere(0.1), mass=0.3, restitution=0.8, aerodynamics=Aerodynamics())
APART = np.column_stack([np.arange(N) + 1.0, np.full(N, 4.0), np.full(N, 1.2)])


def match_with(**spreads) -> tuple[Match, dict[str, np.ndarray]]:
    """Return a match with a row of balls in the air on a bare field, and their factors."""
    scatter = replace(Scatter.none(), **spreads)
    variation = piece_variation(ScatterDraws(scatter, 4), (N,))
    match = Match.bare(pieces=(PieceSupply(BALL, N),), start=(2.0, 7.0, 0.0), scatter=scatter, seed=4)
    match.pieces.spawn("Ball", APART)
    return match, {name: getattr(variation, name) for name in ("mass", "diameter", "restitution", "drag")}


def test_drag_falls_with_mass_and_grows_with_area_and_drag_coefficient():
    """Equal throws: after 0.3 s at 9 m/s they differ as their k does; v = v0 / (1 + k v0 t) along a line."""
    match, factors = match_with(piece_mass=0.3, piece_diameter=0.1, drag=0.2)
    with match:
        slots = match.pieces.on_field()
        k = np.array([match.pieces.air_of(slot).drag for slot in slots.tolist()])
        assert k == pytest.approx(BALL.air.drag * factors["drag"] * factors["diameter"] ** 2 / factors["mass"])
        assert match.pieces.mass == pytest.approx(BALL.mass * factors["mass"])
        match.pieces.push(slots, np.tile((0.0, -9.0, 4.0), (N, 1)), flying=True)
        match.play(0.3)
        start = np.array((0.0, -9.0, 4.0))
        speed, pos = np.tile(start, (N, 1)), APART.copy()
        for _ in range(300):  # integrate the differential equation by small midpoint steps
            half = speed + 0.0005 * (-k[:, None] * np.linalg.norm(speed, axis=1)[:, None] * speed - (0, 0, 9.80665))
            change = -k[:, None] * np.linalg.norm(half, axis=1)[:, None] * half - (0, 0, 9.80665)
            pos += 0.001 * half
            speed += 0.001 * change
        assert np.ptp(pos[:, 1]) > 0.02, "they spread by centimeters"
        assert match.pieces.state.pos[slots] == pytest.approx(pos, abs=2e-3)


def test_a_hit_moves_light_pieces_faster():
    """A ball of nominal mass M hits each piece head-on: v' = (1 + e) v M / (m + M)."""
    match, factors = match_with(piece_mass=0.4)
    with match:
        balls = match.world.balls.balls
        slots = match.pieces.on_field()
        assert balls.mass[slots] == pytest.approx(BALL.mass * factors["mass"])
        for slot in slots[1:].tolist():
            balls.pos[0], balls.vel[0] = balls.pos[slot] - (0.21, 0.0, 0.0), (3.0, 0.0, 0.0)
            balls.vel[slot] = balls.spin[slot] = balls.spin[0] = 0.0
            balls.status[[0, slot]] = PieceStatus.AWAKE
            for _ in range(10):
                match.world.advance(0.002)
            pair = balls.mass[0] * 3.0 / (balls.mass[0] + balls.mass[slot])
            assert balls.vel[slot, 0] == pytest.approx((1.0 + BALL.restitution**2) * pair, rel=0.03)


def test_bounce_height_varies_with_restitution():
    """From 1.1 m: v out = e v in, so the first apex is e^2 of the drop; air drag takes 3 % each way."""
    match, factors = match_with(restitution=0.15)
    with match:
        slots = match.pieces.on_field()
        highest, has_turned = np.zeros(N), np.zeros(N, dtype=bool)
        for _ in range(50):
            match.tick()
            state = match.pieces.state
            has_turned |= state.vel[slots, 2] > 0.5
            highest = np.where(has_turned, np.maximum(highest, state.pos[slots, 2]), 0.0)
        e = np.minimum(1.0, BALL.restitution * factors["restitution"]) * 0.5  # of the carpet
        assert (highest - 0.1) / 1.1 == pytest.approx(e**2, rel=0.08, abs=0.025)  # e within 0.03
        assert np.corrcoef(highest, e**2)[0, 1] > 0.99, "e of a hit is within 0.01, by where in a step it begins"
