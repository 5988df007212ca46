"""Tuning: the optimum is found, a study goes on as if it had never stopped, and other studies are not mixed in."""

from __future__ import annotations

import math

import pytest

from simcore.errors import ConfigError
from simcore.sweep.experiment import Experiment
from simcore.sweep.factors import parse_factor
from simcore.sweep.tuning import Tuning, tune


def off(run) -> float:
    """How far the robot's mass is from 52 kg."""
    mass = run.match.robots[0].config.drivetrain.mass
    if mass > 59.0:
        raise RuntimeError("too heavy")
    return abs(mass - 52.0)


def tuning(**changes):
    experiment = Experiment(game="crates:CRATES", seconds=0.02, seeds=(0,), metrics=(f"{__name__}:off",))
    factors = (parse_factor("robot.mass=uniform(40,60)"),)
    return Tuning(**{"experiment": experiment, "factors": factors, "metric": "off", **changes})


def told(result):
    return [(trial.number, trial.values, trial.value) for trial in result.trials if not trial.error]


def test_a_study_goes_on_where_it_was_and_finds_the_optimum(tmp_path):
    """Six trials and ten more are the sixteen of one call, to the bit; the best is near the optimum."""
    storage = f"sqlite:///{tmp_path / 'study.db'}"
    seen = []
    first = tune(tuning(), 6, storage=storage, on_trial=seen.append)
    result = tune(tuning(), 16, storage=storage, on_trial=seen.append)
    at_once = tune(tuning(), 16)
    assert [trial.number for trial in seen] == list(range(16)) and len(first.trials) == 6
    assert told(result) == told(at_once)
    assert result.as_it_is == pytest.approx(7.0)  # its 45 kg
    assert result.best is not None and result.best.value < 1.0
    failed = [trial for trial in result.trials if trial.error]
    assert all("too heavy" in trial.error and math.isnan(trial.value) for trial in failed)
    most = tune(tuning(direction="maximize"), 2)
    assert most.best is not None and most.best.value == max(value for _, _, value in told(most))
    with pytest.raises(ConfigError, match="of other runs, another metric"):
        tune(tuning(metric="2 * off"), 17, storage=storage)


def test_what_cannot_be_tuned_is_refused():
    with pytest.raises(ConfigError, match="needs ends"):
        tuning(factors=(parse_factor("robot.mass=normal(50,2)"),))
    with pytest.raises(ConfigError, match="nothing to tune"):
        tuning(factors=())
