"""Shares, intervals and differences against published values and closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import fdtri, ndtri
from scipy.stats import binom

from simcore.errors import ConfigError
from simcore.sweep.results import Results
from simcore.sweep.sweep_statistics import paired_difference, seed_share, sequential_difference, wilson_share

from .made_sweep import described, runs_of


@pytest.mark.parametrize(
    ("k", "n", "lower", "upper"),
    [
        # R. Newcombe, Statistics in Medicine 17 (1998) 857, table I, method 3: score without continuity correction
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0000, 0.1611),
        (1, 29, 0.0061, 0.1718),
        # by hand: z = 1.959964, (0.76 + 0.038415 -+ 0.124460) / 1.076829
        (38, 50, 0.6259, 0.8570),
    ],
)
def test_wilsons_interval_is_that_of_published_tables(k, n, lower, upper):
    share = wilson_share(k, n)
    assert (share.lower, share.upper) == pytest.approx((lower, upper), abs=5e-5)


@given(n=st.integers(1, 2000), data=st.data(), confidence=st.floats(0.5, 0.999))
def test_the_ends_are_where_the_score_test_just_holds(n, data, confidence):
    """At each end p0 the count is z standard deviations of p0 away: (p - p0)^2 n = z^2 p0 (1 - p0)."""
    k = data.draw(st.integers(0, n))
    share = wilson_share(k, n, confidence)
    z = ndtri(0.5 + confidence / 2)
    assert 0.0 <= share.lower <= share.value <= share.upper <= 1.0
    for end in {share.lower, share.upper} - {0.0, 1.0}:
        assert n * (share.value - end) ** 2 == pytest.approx(z * z * end * (1 - end), rel=1e-6, abs=1e-9)
    mirror = wilson_share(n - k, n, confidence)
    assert mirror.lower == pytest.approx(1 - share.upper, abs=1e-12)


def test_the_interval_holds_the_true_share_about_as_often_as_it_says():
    """Exact coverage from the binomial distribution: on average over p within 1 % of 95 %."""
    n = 50
    shares = [wilson_share(k, n) for k in range(n + 1)]
    coverage = [
        sum(binom.pmf(k, n, p) for k, share in enumerate(shares) if share.lower <= p <= share.upper)
        for p in np.linspace(0.05, 0.95, 37)
    ]
    assert np.mean(coverage) == pytest.approx(0.95, abs=0.01) and min(coverage) > 0.9


def test_impossible_counts_and_confidences_are_refused():
    with pytest.raises(ConfigError, match="0 <= k <= n, got 3 of 2"):
        wilson_share(3, 2)
    with pytest.raises(ConfigError, match=r"between 0 and 1, e\.g\. 0\.95, got 95"):
        wilson_share(1, 2, 95)
    nothing = wilson_share(0, 0)
    assert (nothing.lower, nothing.upper, str(nothing)) == (0.0, 1.0, "0 of 0") and math.isnan(nothing.value)


def test_a_known_difference_comes_out_of_noise_that_the_seeds_share():
    """Seeds scatter by 10, variants differ by 2 with a scatter of 1: pairs see it, two unpaired groups of 40 would not.

    The interval of the mean is that of Student's t: 2.023 s / sqrt(40) to both sides.
    """
    generator = np.random.default_rng(5)
    luck, own = generator.normal(0.0, 10.0, 40), generator.normal(0.0, 1.0, 40)
    found = paired_difference(luck, luck + 2.0 + own)
    assert found.mean == pytest.approx(2.0 + own.mean()) and found.lower < 2.0 < found.upper
    assert found.upper - found.lower == pytest.approx(2 * 2.0227 * own.std(ddof=1) / math.sqrt(40), rel=1e-4)
    assert found.is_clear and found.p_value < 1e-6 and found.n == 40


@settings(max_examples=15)  # an exact test each
@given(shift=st.integers(-5, 5), values=st.lists(st.integers(0, 50), min_size=2, max_size=30))
def test_a_difference_without_scatter_is_exact(shift, values):
    found = paired_difference(values, [value + shift for value in values])
    assert found.mean == found.lower == found.upper == shift
    assert (found.more, found.less) == ((len(values), 0) if shift > 0 else (0, len(values)) if shift else (0, 0))
    assert found.is_clear == bool(shift) and (shift or found.p_value == 1.0)


def test_runs_of_which_one_seed_has_most_are_worth_as_much_as_that_seed_leaves():
    """8, 1 and 1 runs that came out alike: a run shares its seed with 66 / 10 others on average, itself included.

    Ten runs are worth 10 / 6.6, with which Wilson's interval of ten of ten ends at 1 / (1 + z^2 / 1.52).
    """
    z = ndtri(0.975)
    share = seed_share([True] * 10, [0] * 8 + [1, 2])
    assert share.lower == pytest.approx(1.0 / (1.0 + z * z * 6.6 / 10.0)) and share.upper == 1.0


def test_the_correlation_of_seeds_with_unequal_runs_is_its_limit_by_the_analysis_of_variance():
    """With n0 runs a seed the ratio of mean squares over its F is 1 + n0 rho / (1 - rho); n0 = (n - sum m^2 / n) / 2.

    Of three seeds with 6, 3 and 3 runs; rho is read from the interval, at whose ends the score test just holds.
    """
    held, seeds = [1, 1, 1, 1, 1, 0, 1, 1, 0, 0, 0, 1], [0] * 6 + [1] * 3 + [2] * 3
    share, z = seed_share(held, seeds), ndtri(0.975)
    worth = z * z * share.lower * (1.0 - share.lower) / (share.value - share.lower) ** 2
    rho = (12.0 / worth - 1.0) / (54.0 / 12.0 - 1.0)
    between = (6 * (5 / 6 - 8 / 12) ** 2 + 3 * (1 / 3 - 8 / 12) ** 2) / 2.0
    within = (6 * 5 / 36 + 3 * 2 / 9 + 3 * 2 / 9) / 9.0
    ratio = between / within / fdtri(2, 9, 0.35)
    assert 0.0 < rho < 1.0 and 1.0 + (12.0 - 54.0 / 12.0) / 2.0 * rho / (1.0 - rho) == pytest.approx(ratio)


def test_what_is_no_pair_is_refused():
    for first, second in (([1.0], [2.0]), ([1.0, 2.0], [1.0]), ([1.0, math.nan], [1.0, 2.0])):
        with pytest.raises(ConfigError, match="a paired difference wants"):
            paired_difference(first, second)


@pytest.mark.parametrize("correlation", [0.0, 0.3, 0.6, 0.95])
@pytest.mark.parametrize("seeds", [3, 5, 10, 20, 50])
def test_intervals_of_shares_cover_what_they_say(seeds, correlation, whole):
    """By simulation, four runs a seed, on average over shares: 92 to 98 %, and 2 standard errors of the simulation."""
    if not whole and (seeds in (5, 20) or correlation == 0.3):
        pytest.skip("sampled: --whole plays it")
    count, rng = 2000 if whole else 300, np.random.default_rng(seeds)
    shares, rows, covered = (0.3, 0.5, 0.8, 0.95), np.repeat(np.arange(seeds), 4), 0
    for share in shares:
        chance = np.full((count, seeds), share)  # of success with each seed: a beta distribution has the correlation
        if correlation:
            rest = (1.0 - correlation) / correlation
            chance = rng.beta(share * rest, (1.0 - share) * rest, (count, seeds))
        for held in rng.random((count, seeds, 4)) < chance[..., None]:
            interval = seed_share(held.ravel(), rows)
            covered += interval.lower <= share <= interval.upper
    error = 2.0 * (0.05 * 0.95 / (count * len(shares))) ** 0.5
    assert 0.92 - error <= covered / (count * len(shares)) <= 0.98 + error


@pytest.mark.parametrize("seeds", [3, 10, 50])
def test_intervals_of_paired_differences_cover_what_they_say(seeds):
    """Differences that are normal, with a part common to both of a seed, of 0 to 0.95 of the variance."""
    rng, count = np.random.default_rng(3), 400
    for common in (0.0, 0.5, 0.95):
        both = rng.normal(scale=common**0.5, size=(count, seeds))
        first, second = both + rng.normal(scale=(1.0 - common) ** 0.5, size=(2, count, seeds))
        found = [paired_difference(a, b + 0.7) for a, b in zip(first, second, strict=True)]
        covered = np.mean([one.lower <= 0.7 <= one.upper for one in found])
        assert covered == pytest.approx(0.95, abs=0.033)  # 3 standard errors of the simulation


def test_a_sure_gain_in_ten_of_ten_pairs_is_clear():
    values = np.random.default_rng(4).normal(20.0, 5.0, 10)
    found = paired_difference(values, values + 1.0)
    assert found.is_clear and found.more == 10 and found.mean == pytest.approx(1.0) and found.p_value < 0.01


@pytest.mark.parametrize("judge", [paired_difference, sequential_difference])
def test_a_difference_below_what_figures_are_printed_with_is_none(judge):
    """The same code against itself differs by the last bits; three digits are printed."""
    first = np.linspace(20.0, 30.0, 50)
    for second in (first + 6e-10, first * (1.0 + 2e-4)):
        difference = judge(first, second)
        assert not difference.is_clear and (difference.mean, difference.more, difference.less) == (0.0, 0, 0)
        assert difference.p_value == 1.0
    assert judge(np.zeros(50), np.full(50, 6e-10)).mean == 0.0, "nothing beside nothing"
    assert judge(first, first + 0.1).is_clear
    assert judge(np.zeros(50), np.full(50, 1e-3)).is_clear


# --- intervals of sweeps hold the truth as often as they say, however alike runs of one seed are --------------------


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
