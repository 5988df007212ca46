"""Figures of many runs with how sure they are: a share of successes, percentiles, a difference on common seeds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from simcore.errors import ConfigError
from simcore.typing import FloatArray

__all__ = ["CONFIDENCE", "PERCENTILES", "PairedDifference", "Share", "paired_difference", "wilson_share"]

CONFIDENCE = 0.95
"""Of an interval, if nothing else is asked for."""
PERCENTILES = (5.0, 25.0, 50.0, 75.0, 95.0)
_RESAMPLES = 4000  # the ends of an interval then vary by some 2 % of its width from seed to seed
_AT_ONCE = 2_000_000  # numbers drawn at once, at most: 16 MB


@dataclass(frozen=True, slots=True)
class Share:
    """So many of so many, and between which true shares such a count is no surprise.

    >>> print(wilson_share(38, 50))
    38 of 50 = 76 % (95 % interval 63 to 86 %)
    """

    k: int
    """Runs, or whatever else was tried, with success."""
    n: int
    """All of them."""
    lower: float
    """Lower end of the interval, 0 to 1."""
    upper: float
    """Its upper end."""
    confidence: float = CONFIDENCE
    """How often such intervals hold the true share."""

    @property
    def value(self) -> float:
        """The share itself; not a number without runs."""
        return self.k / self.n if self.n else math.nan

    def __str__(self) -> str:
        if not self.n:
            return "0 of 0"
        ends = f"{100 * self.lower:.0f} to {100 * self.upper:.0f} %"
        return f"{self.k} of {self.n} = {100 * self.value:.0f} % ({100 * self.confidence:g} % interval {ends})"


def wilson_share(k: int, n: int, confidence: float = CONFIDENCE) -> Share:
    """A share with Wilson's score interval, which holds for few runs and for shares near 0 and 1, too.

    >>> share = wilson_share(10, 10)
    >>> round(share.lower, 3), share.upper
    (0.722, 1.0)

    Args:
        k: Runs with success.
        n: All runs; of none nothing is known, and the interval is 0 to 1.
        confidence: Of the interval.

    Raises:
        ConfigError: Not 0 <= k <= n, or a confidence that is not between 0 and 1.

    Source: E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209; L. Brown, T. Cai, A. DasGupta, Stat. Sci. 16 (2001) 101.
    """
    from scipy.special import ndtri

    _require_confidence(confidence)
    if not 0 <= k <= n:
        raise ConfigError(f"wilson_share: want 0 <= k <= n, got {k} of {n}")
    if n == 0:
        return Share(0, 0, 0.0, 1.0, confidence)
    z = float(ndtri(0.5 + 0.5 * confidence))
    p = k / n
    middle = p + z * z / (2 * n)
    half = z * math.sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n))
    scale = 1.0 + z * z / n
    # at the ends the formula gives 0 and 1 but for rounding
    lower = 0.0 if k == 0 else (middle - half) / scale
    upper = 1.0 if k == n else (middle + half) / scale
    return Share(k, n, lower, upper, confidence)


@dataclass(frozen=True, slots=True, kw_only=True)
class PairedDifference:
    """What a variant changes, run against run of the same seed."""

    n: int
    """Pairs."""
    mean: float
    """Of the second variant less the first."""
    lower: float
    """Lower end of the interval of the mean."""
    upper: float
    """Its upper end."""
    more: int
    """Pairs in which the second variant has the higher value."""
    less: int
    """Pairs in which it has the lower one."""
    p_value: float
    """How often chance alone makes such a difference, by Wilcoxon's signed-rank test; 1 where all pairs are equal."""
    confidence: float = CONFIDENCE
    """Of the interval."""

    @property
    def is_clear(self) -> bool:
        """Whether the interval leaves out 0."""
        return self.lower > 0.0 or self.upper < 0.0

    def __str__(self) -> str:
        equal = self.n - self.more - self.less
        return (
            f"{self.mean:+.3g} ({100 * self.confidence:g} % interval {self.lower:+.3g} to {self.upper:+.3g}), "
            f"{self.n} pairs: {self.more} more, {self.less} less, {equal} equal, p = {self.p_value:.2g}"
        )


def paired_difference(
    first: Sequence[float] | FloatArray, second: Sequence[float] | FloatArray, confidence: float = CONFIDENCE
) -> PairedDifference:
    """The mean difference of pairs, its interval by the bootstrap, and Wilcoxon's test.

    The bootstrap draws pairs with a generator of a fixed seed: the same pairs have the same interval. Of fewer than ten
    pairs it is too narrow.

    Args:
        first: Values of the first variant, shape (n,).
        second: Those of the second, of the same seeds in the same order.
        confidence: Of the interval.

    Raises:
        ConfigError: Fewer than two pairs, values that are not finite, or a confidence that is not between 0 and 1.
    """
    from scipy.stats import wilcoxon

    _require_confidence(confidence)
    a, b = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    if a.shape != b.shape or a.ndim != 1 or len(a) < 2:
        raise ConfigError(f"paired_difference: want two rows of at least 2 values, got shapes {a.shape} and {b.shape}")
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise ConfigError("paired_difference: want finite values")
    differences = b - a
    ends = np.quantile(_resampled_means(differences), [0.5 - 0.5 * confidence, 0.5 + 0.5 * confidence])
    return PairedDifference(
        n=len(differences),
        mean=float(differences.mean()),
        lower=float(ends[0]),
        upper=float(ends[1]),
        more=int(np.count_nonzero(differences > 0.0)),
        less=int(np.count_nonzero(differences < 0.0)),
        p_value=float(wilcoxon(differences).pvalue) if differences.any() else 1.0,
        confidence=confidence,
    )


def _require_confidence(confidence: float) -> None:
    if not 0.0 < confidence < 1.0:
        raise ConfigError(f"a confidence is a number between 0 and 1, e.g. {CONFIDENCE}, got {confidence}")


def _resampled_means(values: FloatArray) -> FloatArray:
    """Means of samples with replacement, as many as there are resamples."""
    generator = np.random.default_rng(0)
    n = len(values)
    step = max(1, _AT_ONCE // n)
    means: list[npt.NDArray[np.float64]] = []
    for start in range(0, _RESAMPLES, step):
        rows = generator.integers(0, n, (min(step, _RESAMPLES - start), n))
        means.append(values[rows].mean(axis=1))
    return np.concatenate(means)
