"""Published piece poses are those of the bodies: position and attitude."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore import Match
from simcore.match.game import PieceSupply
from simcore.pieces.kinds import GamePieceConfig
from simcore.world.rotation import from_yaw
from simcore.world.shapes import Box, Sphere

BALL = GamePieceConfig(name="Ball", shape=Sphere(0.1), mass=0.3, friction=1.0, restitution=0.0)
CRATE = GamePieceConfig(name="Crate", shape=Box((0.4, 0.3, 0.2)), mass=1.0, friction=0.8, restitution=0.1)


def test_a_rolling_ball_turns_by_the_distance_over_its_radius():
    """Rolling means v = w r, so the turn between two times is the distance over r."""
    with Match.bare(pieces=[PieceSupply(BALL, 1)]) as match:
        slots = match.pieces.spawn("Ball", np.array([[8.0, 4.0, 0.1]]))
        match.pieces.push(slots, np.array([[1.0, 0.0, 0.0]]))
        match.play(0.5)

        def seen() -> tuple[float, np.ndarray]:
            row = match.snapshot().pose_arrays["Sim/GamePieces/Ball"][0]
            return float(row[0]), row[3:]

        x, before = seen()
        match.play(0.2)
        x_later, after = seen()
        turn = 2.0 * math.acos(min(1.0, abs(float(before @ after))))
        assert x_later - x > 0.05
        # the engine applies rolling resistance to the spin first: the rim lags by up to 2 % within a tick
        assert turn == pytest.approx((x_later - x) / 0.1, rel=0.03)


def test_a_crate_keeps_its_attitude_asleep_and_awake():
    with Match.bare(pieces=[PieceSupply(CRATE, 1)]) as match:
        slot = match.pieces.stage("Crate", 1)
        match.pieces.hold(slot, 0)
        quat = from_yaw(0.7)
        match.pieces.launch(0, (8.0, 4.0, 0.1), (0.0, 0.0, 0.0), slot=int(slot[0]), quat=quat, flying=False)
        for seconds in (0.1, 2.0):  # awake, then asleep
            match.play(seconds)
            row = match.snapshot().pose_arrays["Sim/GamePieces/Crate"][0]
            assert row[3:] == pytest.approx((quat[3], *quat[:3]), abs=0.01)
        assert match.pieces.awake.size == 0
