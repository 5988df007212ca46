"""Least squares with intervals, against closed forms."""

import numpy as np
import pytest
from each_case import each

from simcore.calibrate.fitting import Estimate, Parameter, fit

LINE = (Parameter("slope", 0.5, -10.0, 10.0, 1.0), Parameter("start", 0.1, -10.0, 10.0, 1.0))
X = np.linspace(0.0, 1.0, 40)


def line(rng, runs=5, walk=0.0):
    """Return errors of a line with slope 2 and start 1: white noise of 0.1, and an offset for each run."""
    data = [1.0 + 2.0 * X + rng.normal(0.0, 0.1, len(X)) + walk * rng.normal() for _ in range(runs)]
    return lambda v: [v[0] * X + v[1] - y for y in data]


def test_with_white_noise_the_interval_is_at_least_as_wide_as_the_textbook_interval():
    """The variance of a slope is s^2 / sum (x - mean)^2."""
    found = fit(line(np.random.default_rng(1)), LINE)
    sxx = 5 * float(np.sum((X - X.mean()) ** 2))
    assert found["slope"] == pytest.approx(2.0, abs=4.0 * 0.1 / sxx**0.5)
    half = 0.5 * (found.estimates["slope"].high - found.estimates["slope"].low)
    assert 0.9 * 1.96 * 0.1 / sxx**0.5 < half < 3.0 * 1.96 * 0.1 / sxx**0.5


@each("walk", [0.0, 0.3])
def test_intervals_contain_the_truth_even_if_runs_differ(walk):
    """Intervals contain the true value in 95 % of fits; fewer than 51 of 60 occur once in 1000 (binomial)."""
    held = [fit(line(np.random.default_rng(seed), walk=walk), LINE).estimates["start"] for seed in range(60)]
    assert sum(one.low <= 1.0 <= one.high for one in held) >= 51


def test_a_known_scatter_sets_a_minimum_interval():
    """The half width for one value with an error of sigma is Student's t times sigma."""
    found = fit(lambda v: [np.full(9, v[0] - 3.0)], [Parameter("x", 1.0, 0.0, 9.0, 1.0)], noise=0.6)
    half = 0.5 * (found.estimates["x"].high - found.estimates["x"].low)
    assert found["x"] == pytest.approx(3.0, abs=1e-3) and half == pytest.approx(2.306 * 0.6 / 9**0.5, rel=1e-3)


def test_a_decreasing_function_swaps_the_bounds_of_an_interval():
    assert Estimate(2.0, 1.0, 4.0).mapped(lambda x: 1.0 / x) == Estimate(0.5, 0.25, 1.0)
    assert Estimate(2.0, 1.0, 4.0).share == 0.75
