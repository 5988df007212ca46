"""Shares, intervals and differences, compared with published values and closed forms."""

import math

import numpy as np
import pytest
from each_case import each
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtri

from simcore.errors import ConfigError
from simcore.sweep.sweep_statistics import paired_difference, wilson_share


@each(
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
def test_the_wilson_interval_agrees_with_published_tables(k, n, lower, upper):
    share = wilson_share(k, n)
    assert (share.lower, share.upper) == pytest.approx((lower, upper), abs=5e-5)


@given(n=st.integers(1, 2000), data=st.data(), confidence=st.floats(0.5, 0.999))
def test_the_interval_ends_where_the_score_test_just_accepts(n, data, confidence):
    """At each end p0, the count is z standard deviations of p0 away: (p - p0)^2 n = z^2 p0 (1 - p0)."""
    k = data.draw(st.integers(0, n))
    share = wilson_share(k, n, confidence)
    z = ndtri(0.5 + confidence / 2)
    assert 0.0 <= share.lower <= share.value <= share.upper <= 1.0
    for end in {share.lower, share.upper} - {0.0, 1.0}:
        assert n * (share.value - end) ** 2 == pytest.approx(z * z * end * (1 - end), rel=1e-6, abs=1e-9)
    mirror = wilson_share(n - k, n, confidence)
    assert mirror.lower == pytest.approx(1 - share.upper, abs=1e-12)


def test_invalid_counts_and_confidences_are_refused():
    with pytest.raises(ConfigError, match="0 <= k <= n, got 3 of 2"):
        wilson_share(3, 2)
    with pytest.raises(ConfigError, match=r"between 0 and 1, e\.g\. 0\.95, got 95"):
        wilson_share(1, 2, 95)
    nothing = wilson_share(0, 0)
    assert (nothing.lower, nothing.upper, str(nothing)) == (0.0, 1.0, "0 of 0") and math.isnan(nothing.value)


def test_a_known_difference_is_found_in_noise_common_to_the_seeds():
    """Seeds scatter by 10; variants differ by 2 with a scatter of 1, which two unpaired groups of 40 would not show.

    The interval of the mean is about that of Student's t: 2.023 s / sqrt(40) to both sides.
    """
    generator = np.random.default_rng(5)
    luck, own = generator.normal(0.0, 10.0, 40), generator.normal(0.0, 1.0, 40)
    found = paired_difference(luck, luck + 2.0 + own)
    assert found.mean == pytest.approx(2.0 + own.mean()) and found.lower < 2.0 < found.upper
    assert found.upper - found.lower == pytest.approx(2 * 2.0227 * own.std(ddof=1) / math.sqrt(40), rel=0.06)
    assert found.is_clear and found.n == 40
    assert found == paired_difference(luck, luck + 2.0 + own), "drawn alike every time"


@settings(max_examples=15)
@given(shift=st.integers(-5, 5), values=st.lists(st.integers(0, 50), min_size=2, max_size=30))
def test_a_difference_without_scatter_is_exact(shift, values):
    found = paired_difference(values, [value + shift for value in values])
    assert found.mean == found.lower == found.upper == shift
    assert (found.more, found.less) == ((len(values), 0) if shift > 0 else (0, len(values)) if shift else (0, 0))
    assert found.is_clear == bool(shift)


def test_invalid_pairs_are_refused():
    for first, second in (([1.0], [2.0]), ([1.0, 2.0], [1.0]), ([1.0, math.nan], [1.0, 2.0])):
        with pytest.raises(ConfigError, match="a paired difference needs"):
            paired_difference(first, second)


@pytest.mark.parametrize(("seeds", "least"), [(3, 0.9), (10, 0.92), (50, 0.93)])
@pytest.mark.parametrize("draw", ["normal", "exponential"])
def test_intervals_of_paired_differences_have_about_their_stated_coverage(seeds, least, draw, whole, monkeypatch):
    """For few seeds with skewed differences, the mean is in an interval less often than 95 %, as with any interval."""
    monkeypatch.setattr("simcore.sweep.sweep_statistics._RESAMPLES", 400)
    rng, count = np.random.default_rng(3), 2000 if whole else 300
    skew = 0.07 if draw == "exponential" else 0.0
    changes = getattr(rng, draw)(size=(count, seeds)) + 0.7
    mean = 0.7 + (1.0 if draw == "exponential" else 0.0)
    found = [paired_difference(np.zeros(seeds), change) for change in changes]
    covered = float(np.mean([one.lower <= mean <= one.upper for one in found]))
    assert least - skew - 0.02 <= covered <= 0.99
    wrong = np.mean([paired_difference(np.zeros(seeds), change - mean).is_clear for change in changes])
    assert wrong == pytest.approx(1.0 - covered, abs=0.02)


def test_a_difference_below_the_printed_digits_counts_as_zero():
    """Results of the same code differ in the last bits; three digits are printed."""
    first = np.linspace(20.0, 30.0, 50)
    for second in (first + 6e-10, first * (1.0 + 2e-4)):
        difference = paired_difference(first, second)
        assert not difference.is_clear and (difference.mean, difference.more, difference.less) == (0.0, 0, 0)
    assert paired_difference(np.zeros(50), np.full(50, 6e-10)).mean == 0.0, "nothing next to nothing"
    assert paired_difference(first, first + 0.1).is_clear
    assert paired_difference(np.zeros(50), np.full(50, 1e-3)).is_clear
