"""Matches of random players: no piece is lost, nothing is in a wall or outside, and memory does not grow."""

from __future__ import annotations

import gc

import numpy as np
import psutil
import pytest
from match_laws import match_of, require_one_owner

from simcore.match.registry import find_game
from simcore.players.player import SKILLS

pytestmark = pytest.mark.slow

_DEEPEST = 0.05  # [m]; bumpers give way by some centimeters where one robot rams another
_GROWTH = 60e6  # [B] of 45 matches


def drawn_lineup(game, rng):
    """Up to three players of any role and level for each alliance, at least one for blue."""
    roles = sorted(game.roles)
    return {
        side: ",".join(f"{rng.choice(roles)}:{rng.integers(1, len(SKILLS) + 1)}" for _ in range(rng.integers(least, 4)))
        for side, least in (("blue", 1), ("red", 0))
    }


def require_laws(match):
    require_one_owner(match)
    length, width = match.game.field.size
    for robot in match.robots:
        x, y, _ = robot.chassis.pose
        assert 0.0 < x < length and 0.0 < y < width and -0.05 < robot.chassis.pos[2] < 1.0, (robot.number, x, y)
        depth = match.world.engine.depth(robot.chassis.row)
        assert depth < _DEEPEST, f"robot {robot.number} is {depth:.3f} m deep at {match.time:.2f} s"
    loose = match.pieces.state.pos[match.pieces.on_field()]
    assert (loose[:, 2] > -0.01).all(), "nothing has sunk into the carpet"


@pytest.mark.parametrize("name", ["rebuilt", "reefscape"])
def test_laws_hold_in_matches_of_random_players(name, whole, engine_name):
    """A minute of each from any time of the match on, or, as a sample, some seconds of two."""
    if engine_name == "mujoco" and not whole:
        pytest.skip("sampled: --whole plays on both engines")
    game, used = find_game(name), 0
    options = [option.name for option in game.options if option.in_matches]
    for seed in range(50 if whole else 2):
        rng = np.random.default_rng(seed)
        sides, at = drawn_lineup(game, rng), rng.uniform(0.0, game.clock.duration - 20.0)
        with match_of(game, sides, at=at, seed=seed, options=options) as match:
            for _ in range(30 if whole else 3):
                match.play(2.0)
                require_laws(match)
            assert sum(own.distance for own in match.record.robots) > 0.0 or "idle" in str(sides)
        gc.collect()
        if seed == 5:
            used = psutil.Process().memory_info().rss
    assert not whole or psutil.Process().memory_info().rss - used < _GROWTH
