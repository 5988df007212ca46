"""Statistics of many runs: success rates and paired differences with confidence intervals, and percentiles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from simcore.errors import ConfigError
from simcore.typing import FloatArray

__all__ = ["CONFIDENCE", "PERCENTILES", "PairedDifference", "Share", "paired_difference", "percentiles", "wilson_share"]

CONFIDENCE = 0.95
"""Default confidence level of intervals."""
PERCENTILES = (5.0, 25.0, 50.0, 75.0, 95.0)
_RESAMPLES, _AT_ONCE = 2000, 1_000_000  # resampled means, and numbers drawn at once


@dataclass(frozen=True, slots=True)
class Share:
    """Success rate with a confidence interval.

    >>> print(wilson_share(38, 50))
    38 of 50 = 76 % (95 % interval 63 to 86 %)
    """

    k: int
    """Number of successes."""
    n: int
    """Number of trials."""
    lower: float
    """Lower end of the interval of the success rate, 0 to 1."""
    upper: float
    """Upper end of the interval of the success rate, 0 to 1."""
    confidence: float = CONFIDENCE
    """Confidence level of the interval, 0 to 1."""

    @property
    def value(self) -> float:
        """Success rate, 0 to 1; NaN without trials."""
        return self.k / self.n if self.n else math.nan

    @property
    def interval(self) -> str:
        """Interval of the success rate as text, e.g. `84 to 100 %`."""
        return f"{100 * self.lower:.0f} to {100 * self.upper:.0f} %"

    def __str__(self) -> str:
        if not self.n:
            return "0 of 0"
        return f"{self.k} of {self.n} = {100 * self.value:.0f} % ({100 * self.confidence:g} % interval {self.interval})"


def wilson_share(k: int, n: int, confidence: float = CONFIDENCE) -> Share:
    """Return a success rate with Wilson's score interval.

    The interval is valid also for few runs and for success rates near 0 and 1.

    >>> share = wilson_share(10, 10)
    >>> round(share.lower, 3), share.upper
    (0.722, 1.0)

    Args:
        k: Number of successes.
        n: Number of runs; for 0 the interval is 0 to 1.
        confidence: Confidence level of the interval.

    Raises:
        ConfigError: If not 0 <= k <= n, or the confidence is not between 0 and 1.

    Source: E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209; L. Brown, T. Cai, A. DasGupta, Stat. Sci. 16 (2001) 101.
    """
    if not 0.0 < confidence < 1.0:
        raise ConfigError(f"a confidence is a number between 0 and 1, e.g. {CONFIDENCE}, got {confidence}")
    if not 0 <= k <= n:
        raise ConfigError(f"wilson_share needs 0 <= k <= n, got {k} of {n}")
    if n == 0:
        return Share(0, 0, 0.0, 1.0, confidence)
    z, p = NormalDist().inv_cdf(0.5 + 0.5 * confidence), k / n
    middle = p + z * z / (2.0 * n)
    half = z * math.sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n))
    scale = 1.0 + z * z / n
    # for 0 and n successes, the formula gives 0 and 1 apart from rounding
    return Share(
        k, n, 0.0 if k == 0 else (middle - half) / scale, 1.0 if k == n else (middle + half) / scale, confidence
    )


def percentiles(values: FloatArray, at: Sequence[float] = PERCENTILES) -> list[float]:
    """Return the percentiles `at` (0 to 100) of the finite values; NaN if no value is finite.

    >>> percentiles([1.0, 2.0, math.nan, 3.0], (0, 50))
    [1.0, 2.0]
    """
    known = np.asarray(values)[np.isfinite(values)]
    found: list[float] = np.percentile(known, at).tolist() if len(known) else [math.nan] * len(at)
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class PairedDifference:
    """Mean difference between two variants that were run with the same seeds, with a 95 % confidence interval."""

    n: int
    """Number of pairs, one per seed."""
    mean: float
    """Mean of the second variant minus the first."""
    lower: float
    """Lower end of the 95 % interval of the mean."""
    upper: float
    """Upper end of the 95 % interval of the mean."""
    more: int
    """Number of seeds in which the second variant has the higher value."""
    less: int
    """Number of seeds in which the second variant has the lower value."""

    @property
    def is_clear(self) -> bool:
        """Whether the interval excludes 0."""
        return self.lower > 0.0 or self.upper < 0.0

    def __str__(self) -> str:
        return (
            f"{self.mean:+.3g} (95 % interval {self.lower:+.3g} to {self.upper:+.3g}), {self.n} seeds: "
            f"{self.more} more, {self.less} less, {self.n - self.more - self.less} equal"
        )


def paired_difference(first: Sequence[float] | FloatArray, second: Sequence[float] | FloatArray) -> PairedDifference:
    """Return the mean difference of paired values with a 95 % bootstrap interval.

    A bootstrap interval of few pairs is too narrow. The function therefore widens the interval by the ratio of the
    Student's t interval to the bootstrap interval of normally distributed differences. Differences that are too small
    to change a printed number (relative 0.0005, absolute 1e-6) count as zero.

    >>> print(paired_difference([1, 4, 2, 3], [2, 5, 3, 4]))
    +1 (95 % interval +1 to +1), 4 seeds: 4 more, 0 less, 0 equal

    Args:
        first: Value of the first variant for each seed, shape (n,).
        second: Value of the second variant for each seed, in the order of `first`, shape (n,).

    Raises:
        ConfigError: If the shapes differ, there are fewer than two pairs, or a value is not finite.

    Source: T. Hesterberg, Am. Stat. 69 (2015) 371, "expanded" percentile interval.
    """
    from scipy.special import ndtri, stdtrit

    a, b = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    if a.shape != b.shape or a.ndim != 1 or len(a) < 2:
        raise ConfigError(f"a paired difference needs two rows of at least 2 values, got shapes {a.shape}, {b.shape}")
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise ConfigError("a paired difference needs finite values")
    # printed numbers have three digits: smaller differences count as zero
    differences = np.where(np.isclose(a, b, rtol=5e-4, atol=1e-6), 0.0, b - a)
    n, mean, rng = len(differences), float(differences.mean()), np.random.default_rng(0)
    rows = max(1, _AT_ONCE // n)
    parts = [min(rows, _RESAMPLES - done) for done in range(0, _RESAMPLES, rows)]
    means = np.concatenate([rng.choice(differences, (part, n)).mean(axis=1) for part in parts])
    tail = 0.5 - 0.5 * CONFIDENCE
    widening = math.sqrt(n / (n - 1)) * float(stdtrit(n - 1, tail) / ndtri(tail))
    lower, upper = mean + widening * (np.percentile(means, (100.0 * tail, 100.0 - 100.0 * tail)) - mean)
    return PairedDifference(
        n=n, mean=mean, lower=float(lower), upper=float(upper),
        more=int(np.count_nonzero(differences > 0.0)), less=int(np.count_nonzero(differences < 0.0)),
    )  # fmt: skip
