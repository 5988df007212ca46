"""Least-squares fit with confidence intervals that account for correlated errors and differences between runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from simcore.typing import FloatArray

__all__ = ["Estimate", "Fit", "Parameter", "fit"]

_CONFIDENCE = 0.975  # one-sided confidence of each end of an interval
_BLOCKS = 10  # minimum number of blocks for the jackknife
_FIRST, _AGAIN = 12, 4  # largest number of evaluations from a first guess, and from a fit to nearly the same data
_LEAST = 4  # minimum number of blocks for a meaningful jackknife
Model = Callable[[FloatArray], Sequence[FloatArray]]
"""Function from parameter values to the errors of each run, each of shape (n,)."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """Parameter of a fit, with start value and bounds."""

    name: str
    start: float
    lower: float
    upper: float
    scale: float
    """Typical deviation from `start`; the solver scales the parameter by this value."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """Estimated value with a 95 % confidence interval."""

    value: float
    low: float
    high: float

    @property
    def share(self) -> float:
        """Half-width of the interval divided by the value [-]; infinite for a value of 0."""
        return 0.5 * (self.high - self.low) / abs(self.value) if self.value else math.inf

    def mapped(self, function: Callable[[float], float]) -> Estimate:
        """Return the estimate of a monotonic function of the value, with the transformed interval."""
        low, high = sorted((function(self.low), function(self.high)))
        return Estimate(function(self.value), low, high)

    def around(self, other: float) -> Estimate:
        """Return the estimate with the interval extended to include another value."""
        return Estimate(self.value, min(self.low, other), max(self.high, other))


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Best-fit parameters in the order of `names`, and estimates with confidence intervals by name."""

    names: tuple[str, ...]
    values: FloatArray
    estimates: dict[str, Estimate]

    def __getitem__(self, name: str) -> float:
        return float(self.values[self.names.index(name)])


def fit(
    model: Model, parameters: Sequence[Parameter], *, values: Sequence[float] | None = None, noise: float = 0.0
) -> Fit:
    """Fit parameters by least squares to all runs, and return the parameters with 95 % confidence intervals.

    The half-width of each interval is the largest of up to three estimates. The first estimate uses the scatter of the
    errors, with a sample size reduced by the autocorrelation of the errors. The other estimates are jackknives that
    leave out one block of data or one run.

    Args:
        model: Function from parameter values to the errors of each run.
        parameters: Parameters to fit.
        values: Start values; None for the `start` of each parameter.
        noise: Known lower bound of the standard deviation of one error, in the unit of the errors.
    """
    scale = np.array([p.scale for p in parameters])
    lower, upper = (np.array([getattr(p, end) for p in parameters]) for end in ("lower", "upper"))
    start = np.array([p.start for p in parameters] if values is None else values)

    def off(x: FloatArray) -> FloatArray:
        return np.concatenate(model(x * scale))

    result = least_squares(
        off, np.clip(start, lower + 1e-6 * scale, upper - 1e-6 * scale) / scale, bounds=(lower / scale, upper / scale),
        diff_step=np.full(len(scale), 0.02), xtol=1e-3, ftol=1e-4, gtol=1e-10,
        max_nfev=_FIRST if values is None else _AGAIN,
    )  # fmt: skip
    sizes = [len(errors) for errors in model(result.x * scale)]
    halves = _halves(result.fun, np.asarray(result.jac), sizes, noise) * scale
    found = result.x * scale
    estimates = {
        p.name: Estimate(float(x), float(max(x - half, p.lower)), float(min(x + half, p.upper)))
        for p, x, half in zip(parameters, found, halves, strict=True)
    }
    return Fit(tuple(p.name for p in parameters), found, estimates)


def _halves(errors: FloatArray, jacobian: FloatArray, sizes: Sequence[int], noise: float) -> FloatArray:
    """Return the half-widths of the 95 % confidence intervals of the p scaled parameters, shape (p,).

    Args:
        errors: Errors at the best fit, shape (n,).
        jacobian: Derivatives of the errors with respect to the scaled parameters, shape (n, p).
        sizes: Number of errors of each run.
        noise: Known lower bound of the standard deviation of one error.
    """
    n, p = jacobian.shape
    information = jacobian.T @ jacobian + 1e-12 * np.eye(p)
    ends = np.cumsum(sizes)
    runs = [slice(end - size, end) for end, size in zip(ends.tolist(), sizes, strict=True)]
    variance = max(noise**2, float(errors @ errors) / max(1, n - p) * max(_correlation_time(errors[r]) for r in runs))
    white = student.ppf(_CONFIDENCE, max(1, n - p)) * np.sqrt(variance * np.diag(np.linalg.inv(information)))
    found: FloatArray = white
    pieces = math.ceil(_BLOCKS / len(runs))
    parts = [part for run in runs for part in np.array_split(np.arange(run.start, run.stop), pieces) if len(part)]
    for blocks in ([slice(int(part[0]), int(part[-1]) + 1) for part in parts], runs):
        if len(blocks) > max(p, _LEAST - 1):
            found = np.maximum(found, _jackknife(errors, jacobian, information, blocks))
    return found


def _correlation_time(errors: FloatArray) -> float:
    """Return the integrated autocorrelation time of errors [samples].

    The time is 1 plus twice the sum of the autocorrelations before the first lag with a correlation <= 0.
    """
    centered = errors - errors.mean() if len(errors) > 3 else errors
    total, power = 1.0, float(centered @ centered)
    for lag in range(1, len(centered) // 2):
        correlation = float(centered[lag:] @ centered[:-lag]) / max(power, 1e-300)
        if correlation <= 0.0:
            break
        total += 2.0 * correlation
    return total


def _jackknife(
    errors: FloatArray, jacobian: FloatArray, information: FloatArray, blocks: Sequence[slice]
) -> FloatArray:
    """Return the half-widths of the 95 % intervals from a first-order jackknife over blocks, shape (p,)."""
    g, p = len(blocks), jacobian.shape[1]
    moved = np.array([
        np.linalg.solve(information - jacobian[b].T @ jacobian[b] + 1e-9 * information.trace() / p * np.eye(p),
                        jacobian[b].T @ errors[b])
        for b in blocks
    ])  # fmt: skip
    spread = (g - 1) / g * np.sum((moved - moved.mean(axis=0)) ** 2, axis=0)
    half: FloatArray = student.ppf(_CONFIDENCE, g - 1) * np.sqrt(spread)
    return half
