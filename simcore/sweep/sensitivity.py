"""Which factor matters most: designs of points that can tell, and effects of factors ranked, by SALib.

A design is a set of points in the unit cube; a factor turns its coordinate into a value by its range or distribution.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError, VendorError
from simcore.install_text import install_command
from simcore.typing import FloatArray
from simcore.units import plain_sum

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "FactorEffect", "main_effects", "morris_effects", "morris_points", "ranked", "saltelli_points", "sobol_effects",
    "spread_effects",
]  # fmt: skip

_MORRIS_LEVELS = 4  # of a factor: SALib's and the literature's usual number
_SEED = 0  # of resampling: the same runs have the same intervals
_LEAST_SPREAD = 40  # points below which first-order indices of scattered points are noise


@dataclass(frozen=True, slots=True, kw_only=True)
class FactorEffect:
    """How much one factor moves a metric."""

    factor: str
    index: float
    """Its share of the metric's variance, 0 to 1; of Morris the mean size of a change, in the metric's unit."""
    margin: float
    """Half the 95 % interval of the index; not a number where the design cannot tell."""
    total: float
    """Share of the variance with all it does together with others; not a number but for Saltelli's design."""
    low: float | str
    """Lowest value of the factor, or lower end of the tenth of the runs with its lowest values."""
    high: float | str
    """The highest."""
    at_low: float
    """Mean of the metric there."""
    at_high: float
    method: str
    """What the index is: `variance share`, `Sobol index` or `Morris mu*`."""

    @property
    def swing(self) -> float:
        """What the metric changes by from the lowest value to the highest."""
        return self.at_high - self.at_low


def ranked(effects: Sequence[FactorEffect]) -> tuple[FactorEffect, ...]:
    """The factor that matters most first; by total indices where there are any."""
    return tuple(sorted(effects, key=lambda effect: -_rank(effect)))


def _rank(effect: FactorEffect) -> float:
    value = effect.index if math.isnan(effect.total) else effect.total
    return -math.inf if math.isnan(value) else value


# --- designs ------------------------------------------------------------------------------------------------------


def morris_points(count: int, factors: int, seed: int = 0) -> FloatArray:
    """Trajectories of Morris: each changes one factor after the other. Cheap: some 10 trajectories rank 20 factors.

    The levels are the middles of equal parts of the unit interval, so that distributions without ends work, too.

    Args:
        count: Trajectories; each has one point more than there are factors.
        factors: How many factors.
        seed: Of the trajectories.

    Returns:
        Points in the unit cube, shape (count * (factors + 1), factors).

    Source: M. Morris, Technometrics 33 (1991) 161; F. Campolongo et al., Env. Mod. & Softw. 22 (2007) 1509.
    """
    _require_counts(count, factors)
    points: FloatArray = _salib("sample.morris").sample(_problem(factors), count, num_levels=_MORRIS_LEVELS, seed=seed)
    return (points * (_MORRIS_LEVELS - 1) + 0.5) / _MORRIS_LEVELS


def saltelli_points(count: int, factors: int, seed: int = 0) -> FloatArray:
    """Saltelli's design for Sobol indices: first-order and total ones. Dear: some hundred times (factors + 2) points.

    Args:
        count: Base samples, a power of two.
        factors: How many factors.
        seed: Of the scrambling.

    Returns:
        Points in the unit cube, shape (count * (factors + 2), factors).

    Source: A. Saltelli et al., Comp. Phys. Comm. 181 (2010) 259.
    """
    _require_counts(count, factors)
    if count & (count - 1):
        raise ConfigError(f"a design for Sobol indices wants a power of two of samples, e.g. 64, got {count}")
    points: FloatArray = _salib("sample.sobol").sample(_problem(factors), count, calc_second_order=False, seed=seed)
    return points


def _require_counts(count: int, factors: int) -> None:
    if count < 2 or factors < 2:
        raise ConfigError(f"a sensitivity design wants 2 samples and 2 factors or more, got {count} and {factors}")


# --- effects ------------------------------------------------------------------------------------------------------


def morris_effects(points: pd.DataFrame, factors: Sequence[str], metric: pd.Series) -> list[FactorEffect]:
    """Mean sizes of elementary effects (mu*), in the metric's unit for a whole range of a factor.

    Trajectories of which a point has no value are left out.

    Args:
        points: A row a point in the design's order, with a column a factor.
        factors: Their names.
        metric: Its value at each point.

    Raises:
        ConfigError: Fewer than two whole trajectories.
    """
    unit = _ranks_of(points, factors)
    # middles of the parts back to the levels that the design has moved on
    levels = np.round(unit * (_MORRIS_LEVELS - 1)) / (_MORRIS_LEVELS - 1)
    kept = _whole_blocks(metric, len(factors) + 1, least=2)
    found = _salib("analyze.morris").analyze(
        _problem(len(factors)), levels[kept], metric.to_numpy(float)[kept], num_levels=_MORRIS_LEVELS, seed=_SEED
    )
    # SALib divides by a step of its levels, 2/3; on the middles of the parts it is 1/2 of a factor's range.
    size, margin = (
        _MORRIS_LEVELS / (_MORRIS_LEVELS - 1) * np.asarray(found[name]) for name in ("mu_star", "mu_star_conf")
    )
    return _effects(points, factors, metric, size, margin, "Morris mu*")


def sobol_effects(points: pd.DataFrame, factors: Sequence[str], metric: pd.Series) -> list[FactorEffect]:
    """First-order and total Sobol indices from Saltelli's design.

    Args:
        points: A row a point in the design's order, with a column a factor.
        factors: Their names.
        metric: Its value at each point.

    Raises:
        ConfigError: Fewer than two whole blocks of the design have values.
    """
    kept = _whole_blocks(metric, len(factors) + 2, least=2)
    values = metric.to_numpy(float)[kept]
    if values.std() == 0.0:
        zero = np.zeros(len(factors))
        return _effects(points, factors, metric, zero, zero, "Sobol index", total=zero)
    found = _salib("analyze.sobol").analyze(_problem(len(factors)), values, calc_second_order=False, seed=_SEED)
    first, margin, total = (np.asarray(found[name]) for name in ("S1", "S1_conf", "ST"))
    return _effects(points, factors, metric, first, margin, "Sobol index", total=total)


def spread_effects(points: pd.DataFrame, factors: Sequence[str], metric: pd.Series) -> list[FactorEffect]:
    """First-order Sobol indices from scattered points: random, Latin hypercube, Sobol sequence (RBD-FAST).

    Args:
        points: A row a point, with a column a factor.
        factors: Their names.
        metric: Its value at each point; those without one are left out.

    Raises:
        ConfigError: Fewer than 40 points.

    Source: S. Tarantola et al., Rel. Eng. & Syst. Safety 91 (2006) 717; J.-Y. Tissot, C. Prieur, ibid. 107 (2012) 205.
    """
    kept = np.isfinite(metric.to_numpy(float))
    if kept.sum() < _LEAST_SPREAD:
        raise ConfigError(
            f"sensitivity: {int(kept.sum())} scattered points cannot tell factors apart: sample {_LEAST_SPREAD} or more"
        )
    values = metric.to_numpy(float)[kept]
    if values.std() == 0.0:
        zero = np.zeros(len(factors))
        return _effects(points, factors, metric, zero, zero, "Sobol index")
    unit = _ranks_of(points, factors)[kept]
    # Waves that are looked at: with 10, as usual, the intervals of 40 points divide by zero.
    waves = min(10, len(values) // 10)
    found = _salib("analyze.rbd_fast").analyze(_problem(len(factors)), unit, values, M=waves, seed=_SEED)
    return _effects(points, factors, metric, np.asarray(found["S1"]), np.asarray(found["S1_conf"]), "Sobol index")


def main_effects(runs: pd.DataFrame, factors: Sequence[str], metric: pd.Series) -> list[FactorEffect]:
    """Of a grid or a list: the share of the metric's variance within seeds that lies between the values of each factor.

    Seeds are blocks: what a seed does to all its runs is taken out first, for all values of a factor share it. The rest
    is what factors do together, and otherwise in each seed. From each share is taken what that rest alone would give it
    by chance (epsilon squared); with many runs of a full grid what is left are first-order Sobol indices of its values.
    Words, e.g. names of autos, count as values, too.

    Args:
        runs: A row a run, with a column `seed` and one a factor.
        factors: Their names.
        metric: Its value in each run.

    Source: T. L. Kelley, PNAS 21 (1935) 554; blocks: R. A. Fisher, The Design of Experiments (1935).
    """
    own = metric - metric.groupby(runs["seed"]).transform("mean")
    total = float(own @ own)
    between, freedom = [], []
    for factor in factors:
        groups = own.groupby(runs[factor])
        means = groups.transform("mean")
        between.append(float(means @ means))
        freedom.append(groups.ngroups - 1)
    left, rest = len(metric) - runs["seed"].nunique() - int(np.sum(freedom)), total - plain_sum(between)
    noise = max(rest, 0.0) / left if left > 0 else 0.0
    shares = [max(0.0, b - f * noise) / total if total > 0.0 else 0.0 for b, f in zip(between, freedom, strict=True)]
    nobody = np.full(len(factors), np.nan)
    return _effects(runs, factors, metric, np.array(shares), nobody, "variance share")


def _effects(
    points: pd.DataFrame,
    factors: Sequence[str],
    metric: pd.Series,
    index: FloatArray,
    margin: FloatArray,
    method: str,
    *,
    total: FloatArray | None = None,
) -> list[FactorEffect]:
    found = []
    for row, factor in enumerate(factors):
        low, high, at_low, at_high = _ends(points[factor], metric)
        found.append(
            FactorEffect(
                factor=factor,
                index=float(index[row]),
                margin=float(margin[row]),
                total=math.nan if total is None else float(total[row]),
                low=low,
                high=high,
                at_low=at_low,
                at_high=at_high,
                method=method,
            )
        )
    return found


def _ends(column: pd.Series, metric: pd.Series) -> tuple[Any, Any, float, float]:
    """Lowest and highest value of a factor and the means of the metric there.

    A factor of many values stands for its lowest and highest tenth; words are ordered by the metric's mean.
    """
    if column.dtype.kind not in "fiub":
        means = metric.groupby(column).mean().sort_values()
        return means.index[0], means.index[-1], float(means.iloc[0]), float(means.iloc[-1])
    low, high = float(column.min()), float(column.max())
    lowest, highest = column == low, column == high
    if column.nunique() > 10:
        lowest, highest = column <= column.quantile(0.1), column >= column.quantile(0.9)
    return low, high, float(metric[lowest].mean()), float(metric[highest].mean())


def _ranks_of(points: pd.DataFrame, factors: Sequence[str]) -> FloatArray:
    """Coordinates of points by the order of their values, each from 0 to 1, shape (n, factors).

    An order is all that the indices need, whatever distribution has made the values.
    """
    columns = []
    for factor in factors:
        column = points[factor]
        if column.dtype.kind not in "fiub":
            raise ConfigError(f"sensitivity: {factor} has words for values, which only a grid or a list can judge")
        codes = np.unique(column.to_numpy(float), return_inverse=True)[1]
        columns.append(codes / max(1, codes.max()))
    return np.column_stack(columns)


def _whole_blocks(metric: pd.Series, size: int, *, least: int) -> Any:
    """Rows of the blocks of a design in which each point has a value, shape (n,)."""
    has_value = np.isfinite(metric.to_numpy(float))
    blocks = has_value[: len(has_value) // size * size].reshape(-1, size).all(axis=1)
    if blocks.sum() < least:
        raise ConfigError(f"sensitivity: {int(blocks.sum())} whole blocks of {size} runs; want {least} or more")
    return np.concatenate((np.repeat(blocks, size), np.zeros(len(has_value) % size, bool)))


def _problem(factors: int) -> dict[str, Any]:
    return {"num_vars": factors, "names": [f"x{k}" for k in range(factors)], "bounds": [[0.0, 1.0]] * factors}


def _salib(module: str) -> Any:
    try:
        return import_module(f"SALib.{module}")
    except ImportError as error:
        raise VendorError(f"sensitivity needs SALib: {install_command('sweep')}") from error
