"""Intervals of sweeps hold the truth as often as they say, however alike runs of one seed are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ndtri

from simcore.sweep.results import Results
from simcore.sweep.sweep_statistics import seed_share

from .made_sweep import described, runs_of

SEEDS = (3, 5, 10, 20, 50)
CORRELATIONS = (0.0, 0.2, 0.5, 0.8, 0.95)


def shares_held(seeds, correlation, runs, draws):
    """How often the interval has the true share in it.

    Gaussian luck of seed and run, and a success where their sum is below a limit; true shares from 5 to 95 %.
    """
    generator = np.random.default_rng([seeds, int(100 * correlation), runs])
    names = np.repeat(np.arange(seeds), runs)
    held = 0
    for _ in range(draws):
        true = generator.uniform(0.05, 0.95)
        own, common = generator.normal(size=(seeds, runs)), generator.normal(size=(seeds, 1))
        luck = math.sqrt(correlation) * common + math.sqrt(1.0 - correlation) * own
        share = seed_share((luck < ndtri(true)).ravel(), names)
        held += share.lower <= true <= share.upper
    return held / draws


def differences_held(seeds, correlation, runs, draws):
    """How often it has the true difference: 2, but otherwise in each seed and, less so, in each pair of a seed."""
    points = {"x": np.repeat((0.0, 1.0), runs), "y": np.tile(np.arange(float(runs)), 2)}
    rows = runs_of(points, lambda values, seed: {"score": 0.0}, seeds=seeds)
    changed = np.array([row["x"] == 1.0 for row in rows])  # by point, then seed
    generator = np.random.default_rng([seeds, int(100 * correlation), runs])
    held = 0
    for _ in range(draws):
        own, common = generator.normal(size=(runs, seeds)), generator.normal(size=(1, seeds))
        change = 2.0 + math.sqrt(correlation) * common + math.sqrt(1.0 - correlation) * own
        score = np.tile(generator.normal(0.0, 10.0, seeds), 2 * runs)
        score[changed] += change.ravel()
        scored = [{**row, "score": value} for row, value in zip(rows, score.tolist(), strict=True)]
        found = Results(scored, described("x", "y")).paired("x", 0.0, 1.0, "score")
        held += found.lower <= 2.0 <= found.upper
    return held / draws


@pytest.mark.parametrize("seeds", SEEDS)
@pytest.mark.parametrize(
    ("held", "runs", "many", "few"),
    [(shares_held, (2, 4, 8), 10_000, 400), (differences_held, (4,), 1_000, 60)],
    ids=["shares", "differences"],
)
def test_intervals_hold_the_truth_as_often_as_they_say(seeds, held, runs, many, few, whole):
    """92 to 98 % of the draws, within 3.5 standard deviations of their number."""
    draws = many if whole else few
    air = 3.5 * math.sqrt(0.95 * 0.05 / draws)
    for correlation in CORRELATIONS if whole else (0.0, 0.5, 0.95):
        for count in runs:
            found = held(seeds, correlation, count, draws)
            assert 0.92 - air <= found <= 0.98 + air, (correlation, count)
