"""When a sweep may stop: every point must be known as well as asked for, by whole rounds of seeds, each row once."""

from __future__ import annotations

from simcore.sweep.api import _Rounds
from simcore.sweep.experiment import Experiment, StopRule
from simcore.sweep.factors import Factor


def rounds(seeds=60, **stop):
    experiment = Experiment(factors=(Factor("robot.mass", (45.0, 60.0)),), seeds=range(seeds), stop=StopRule(**stop))
    return _Rounds(experiment, experiment.runs())


def row(number, score, error=""):
    return {"run": number, "point": number % 2, "seed": number // 2, "score": score, "robot.mass": 45.0, "error": error,
            "digest": "0", "version": "1", "cpu_seconds": 1.0}  # fmt: skip


def test_until_is_about_all_points_and_not_the_first_or_their_mean():
    """The first point holds always, so 25 runs know its share by 7 %; the second holds every other time: by 18 %."""
    made = rounds(condition="score > 0.5", width=0.1, least=10)
    for seed in range(30):
        made.add(row(2 * seed, 1.0))
        made.add(row(2 * seed + 1, float(seed % 2)))
    assert not made.is_over
    for_one = rounds(condition="score > 0.5", width=0.1, least=10)
    for seed in range(30):
        for_one.add(row(2 * seed, 1.0))
        for_one.add(row(2 * seed + 1, 1.0))
    assert for_one.is_over


def test_a_round_counts_when_all_its_points_are_there_in_whatever_order():
    made = rounds(errors=1)
    made.add(row(1, 0.0, error="lost"))
    assert not made.is_over, "the other point of the seed is not there yet"
    made.add(row(3, 1.0))
    made.add(row(0, 1.0))
    assert made.is_over and sorted(one["run"] for one in made.counted) == [0, 1]


def test_a_rule_that_is_met_at_once_is_asked_after_the_least_number_of_seeds_and_of_many_every_tenth():
    for least, end in ((12, 12), (103, 110)):
        made = rounds(seeds=130, condition="score > 0.5", width=0.49, least=least)
        for number in range(2 * 130):
            made.add(row(number, 1.0))
        assert len(made.counted) == 2 * end
