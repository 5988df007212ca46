"""How many steps of the engine robots need in a tick."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError
from simcore.physics.substeps import Substepping, Surroundings


@given(st.floats(0.0, 6.0), st.sampled_from(Surroundings))
def test_no_robot_moves_farther_than_its_limit_below_the_cap(speed, near):
    rule = Substepping()
    n = rule.robot_count(0.02, speed, near)
    limit = rule.robot_move if near is Surroundings.OPEN else rule.robot_ramp_move
    assert 1 <= n <= rule.cap
    if n < rule.cap:
        assert speed * 0.02 / n <= limit * (1.0 + 1e-9)
    fewest = 1 if near is Surroundings.OPEN else 4  # steps of 5 ms
    assert n >= fewest
    if n > fewest:  # and no more of them than that takes
        assert speed * 0.02 / limit > n - 1


def test_a_quiet_tick_is_one_step_and_a_wild_one_stops_at_the_cap():
    assert Substepping().robot_count(0.02, 0.0) == 1
    assert Substepping(cap=8).robot_count(0.02, 1e6) == 8


@pytest.mark.parametrize(
    "setting", [{"robot_move": -1.0}, {"robot_move": math.nan}, {"robot_contact_step": math.inf}, {"cap": 0}]
)
def test_settings_that_cannot_work_are_refused(setting):
    with pytest.raises(ConfigError, match=next(iter(setting))):
        Substepping(**setting)
