"""How many sub-steps a tick needs."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError
from simcore.physics.substeps import Substepping, Surroundings

speed = st.floats(0.0, 55.0)


@given(speed, st.floats(0.0, 6.0), st.sampled_from(Surroundings))
def test_nothing_moves_farther_than_its_limit_below_the_cap(piece, robot, near):
    rule = Substepping()
    n = rule.count(0.02, piece, robot, near)
    limit = {
        Surroundings.OPEN: rule.robot_move,
        Surroundings.RAMP: rule.robot_ramp_move,
        Surroundings.WALL: rule.robot_ramp_move,
    }[near]
    assert 1 <= n <= rule.cap
    assert piece * 0.02 / n <= rule.max_move * (1.0 + 1e-9)
    if n < rule.cap:
        assert robot * 0.02 / n <= limit * (1.0 + 1e-9)
    fewest = 1 if near is Surroundings.OPEN else 4  # steps of 5 ms
    assert n >= fewest
    if n > fewest:  # and no more of them than that takes
        assert max(piece * 0.02 / rule.max_move, robot * 0.02 / limit) > n - 1


def test_a_quiet_tick_is_one_step_and_a_wild_one_stops_at_the_cap():
    assert Substepping().count(0.02, 0.0) == 1
    assert Substepping(cap=8).count(0.02, 1e6) == 8


@given(st.floats(0.01, 0.5))
def test_a_game_of_small_balls_gets_shorter_steps_in_proportion(radius):
    """Neither a ball nor a bumper gets past a center: both limits stay below the radius."""
    rule = Substepping.for_balls(radius)
    assert rule.robot_move < rule.max_move < radius
    assert rule.max_move <= Substepping().max_move
    assert rule.count(0.02, 3.0) >= 3.0 * 0.02 / radius


def test_forty_meters_per_second_need_twelve():
    """40 m/s x 20 ms = 0.8 m; 0.8 / 0.07 = 11.4."""
    assert Substepping().count(0.02, 40.0) == 12


@pytest.mark.parametrize(
    "setting",
    [{"max_move": 0.0}, {"max_move": math.nan}, {"robot_move": -1.0}, {"robot_contact_step": math.inf}, {"cap": 0}],
)
def test_settings_that_cannot_work_are_refused(setting):
    with pytest.raises(ConfigError, match=next(iter(setting))):
        Substepping(**setting)
