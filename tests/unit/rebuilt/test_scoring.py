"""Which hub counts when: 2026 manual, MATCH PERIODS and HUB status."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from games.rebuilt.field import scoring_zones
from games.rebuilt.scoring import MATCH, RebuiltRules
from simcore.match.game import RobotEntry
from simcore.match.scoring import ScoreEvent

ZONE = {zone.alliance: zone for zone in scoring_zones()}
OTHER = {"blue": "red", "red": "blue"}
SHIFTS = [(33.0 + 25.0 * i, 58.0 + 25.0 * i) for i in range(4)]
"""Simulated time of shifts 1-4 [s]: 20 auto + 3 pause + 10 transition, then 25 s each."""


class Rules(RebuiltRules):
    """Of a match of which only the clock runs."""

    def __init__(self, seed: int = 0, own: str = "blue") -> None:
        timer, rng = SimpleNamespace(time=0.0), np.random.default_rng(seed)
        entry = RobotEntry(alliance=own)  # type: ignore[arg-type]
        super().__init__(
            SimpleNamespace(entries=(entry,), rules_rng=rng, timer=timer, practice=False, options=())  # type: ignore[arg-type]
        )

    def fuel(self, alliance: str, time: float) -> int:
        """A fuel of an alliance scores at a time; its points."""
        self.match.timer.time = time
        points = self.worth(ZONE[alliance])
        self.scored(ScoreEvent(time, ZONE[alliance].name, ZONE[alliance].alliance, points, 0))
        return points


def game(winner: str | None = "blue", seed: int = 0) -> Rules:
    rules = Rules(seed)
    if winner:
        rules.fuel(winner, 5.0)
    return rules


def test_the_match_is_two_minutes_forty_and_a_pause_of_three_seconds():
    assert MATCH.duration == 20.0 + 3.0 + 140.0
    assert [MATCH.start(f"shift {i + 1}") for i in range(4)] == [start for start, _ in SHIFTS]
    assert MATCH.start("end game") == MATCH.duration - 30.0


@pytest.mark.parametrize("winner", ["blue", "red"])
def test_who_wins_auto_is_inactive_in_shifts_one_and_three_and_the_other_in_two_and_four(winner):
    rules = game(winner)
    assert rules.first_inactive == winner
    for i, (start, end) in enumerate(SHIFTS):
        off = winner if i % 2 == 0 else OTHER[winner]
        for time in (start + 3.0, (start + end) / 2, end - 0.02):
            assert not rules.is_active(off, time)
            assert rules.is_active(OTHER[off], time)


@pytest.mark.parametrize("alliance", ["blue", "red"])
@pytest.mark.parametrize("time", [0.0, 19.98, 21.5, 23.0, 32.98, 133.0, 162.98])
def test_both_hubs_count_in_auto_transition_and_end_game(alliance, time):
    assert game().is_active(alliance, time)


@pytest.mark.parametrize(("time", "points"), [(33.0, 1), (35.98, 1), (36.0, 0), (57.98, 0), (58.0, 1)])
def test_fuel_counts_for_three_seconds_after_the_hub_went_inactive_and_again_when_it_is_active(time, points):
    assert game("blue").fuel("blue", time) == points


@pytest.mark.parametrize(("time", "points"), [(162.98, 1), (163.0, 1), (165.98, 1), (166.0, 0), (1000.0, 0)])
def test_fuel_counts_for_three_seconds_after_the_end(time, points):
    assert game().fuel("red", time) == points


def test_a_tie_is_decided_by_chance_once_and_by_both_in_turn():
    coins = {game(None, seed).first_inactive for seed in range(20)}
    assert coins == {"blue", "red"}
    rules = game(None, 3)
    first = rules.first_inactive
    rules.fuel("blue", 5.0)
    rules.fuel("red", 6.0)
    assert rules.first_inactive == first, "one to one is a tie again"


def test_auto_fuel_that_lands_in_the_pause_still_decides_and_teleop_fuel_does_not():
    rules = game("red")
    rules.fuel("blue", 20.5)
    rules.fuel("blue", 22.98)
    assert rules.first_inactive == "blue"
    for _ in range(10):
        rules.fuel("red", 25.0)
    assert rules.first_inactive == "blue"


@pytest.mark.parametrize("seed", range(6))
def test_the_coin_of_a_red_match_is_that_of_the_blue_one_flipped(seed):
    assert {Rules(seed, "blue").first_inactive, Rules(seed, "red").first_inactive} == {"blue", "red"}


def test_game_data_comes_with_teleop_and_an_auto_begins_without_fuel():
    rules = game("red")
    for time, data in ((5.0, ""), (22.98, ""), (23.0, "R"), (160.0, "R")):
        rules.match.timer.time = time
        assert rules.game_data() == data
    assert rules.breakdown() == {"BlueAutoFuel": 0, "RedAutoFuel": 1}
    rules.start_mode("teleop")
    assert rules.breakdown()["RedAutoFuel"] == 1
    rules.start_mode("auto")
    assert rules.breakdown() == {"BlueAutoFuel": 0, "RedAutoFuel": 0}


def test_in_practice_both_hubs_count_all_the_time():
    rules = game("blue")
    assert not rules.is_active("blue", 50.0)
    rules.match.practice = True
    assert all(rules.is_active(alliance, time) for alliance in ZONE for time in (10.0, 50.0, 75.0, 200.0))
