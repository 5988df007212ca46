"""The runs of a sweep as a table, and what they say: shares of success, percentiles, differences, sensitivities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.sweep.column_expressions import evaluate, names_in, no_condition
from simcore.sweep.sensitivity import (
    FactorEffect,
    main_effects,
    morris_effects,
    ranked,
    sobol_effects,
    spread_effects,
)
from simcore.sweep.sweep_statistics import (
    CONFIDENCE,
    PERCENTILES,
    PairedDifference,
    Share,
    paired_difference,
    seed_share,
)
from simcore.telemetry.sinks import output_error

if TYPE_CHECKING:
    import pandas as pd

    from simcore.sweep.experiment import Experiment

__all__ = ["BESIDE_METRICS", "MOST_VALUES", "Results"]

BESIDE_METRICS = ("run", "point", "seed", "digest", "version", "error", "cpu_seconds")
"""Columns of every table that are neither factors nor metrics: three before them, the others after."""
MOST_VALUES = 12
"""Of a factor that are told and shown each."""


@dataclass(frozen=True, slots=True)
class Results:
    """All runs of an experiment.

    A run that ended with an error has no metrics: it is no success, and in no percentile.
    """

    table: pd.DataFrame
    """A row a run: `run`, `point`, `seed`, a column a factor and a metric, `digest`, `version`, `error`,
    `cpu_seconds`."""
    experiment: Experiment
    """What was asked for."""

    def __post_init__(self) -> None:
        missing = [name for name in ("run", "point", "seed", "error") if name not in self.table.columns]
        if missing:
            raise ConfigError(
                f"Results: the table has no column {', '.join(missing)}; it has {list(self.table.columns)}"
            )

    # --- columns ----------------------------------------------------------------------------------------------------

    @property
    def factors(self) -> tuple[str, ...]:
        """Names of what was varied."""
        return tuple(factor.name for factor in self.experiment.factors)

    @property
    def metrics(self) -> tuple[str, ...]:
        """Names of the columns of numbers that runs have brought."""
        outside = {*BESIDE_METRICS, *self.factors}
        return tuple(str(name) for name in self.table.columns if name not in outside and self._is_number(name))

    def _is_number(self, name: str) -> bool:
        return self.table[name].dtype.kind in "fiub"

    @property
    def whole(self) -> pd.DataFrame:
        """The runs without an error."""
        return self.table[self.table["error"].fillna("") == ""]

    @property
    def failures(self) -> pd.DataFrame:
        """The runs with one."""
        return self.table[self.table["error"].fillna("") != ""]

    # --- statistics -------------------------------------------------------------------------------------------------

    def succeeded(self, condition: str) -> pd.Series:
        """Whether each run of the table was a success.

        Args:
            condition: As `success` takes it.
        """
        held = evaluate(self.table, condition)
        if held.dropna().map(lambda value: not isinstance(value, (bool, np.bool_))).any():
            raise no_condition(condition)
        held = held.fillna(False).astype(bool) & (self.table["error"].fillna("") == "")
        named = [name for name in names_in(condition) if name in self.table.columns]
        return held & self.table[named].notna().all(axis=1)

    def success(self, condition: str, *, confidence: float = CONFIDENCE) -> Share:
        """How often a condition held, with an interval that takes runs of one seed for as alike as they are.

        Args:
            condition: Of columns, e.g. `score >= 30` or `hits == shots and brownouts == 0`.
            confidence: Of the interval.

        Raises:
            ConfigError: It is no condition.
            UnknownNameError: There is no such column.
        """
        return seed_share(self.succeeded(condition), self.table["seed"], confidence)

    def success_by(self, factor: str, condition: str, *, confidence: float = CONFIDENCE) -> dict[Any, Share]:
        """The same for each value of a factor, in their order.

        Raises:
            ConfigError: It is no condition.
            UnknownNameError: There is no such column or factor.
        """
        self._require_factor(factor)
        groups = self.succeeded(condition).groupby(self.table[factor], sort=True)
        return {value: seed_share(held, self.table.loc[held.index, "seed"], confidence) for value, held in groups}

    def percentiles(self, metric: str, at: Sequence[float] = PERCENTILES, *, by: Sequence[str] = ()) -> pd.DataFrame:
        """Percentiles of a metric, a column each; 50 is the median.

        Args:
            metric: A column, or an expression of columns, e.g. `hits / shots`.
            at: Which percentiles.
            by: Factors; a row for each combination of their values. Without any there is one row.

        Raises:
            ConfigError: A percentile that is not from 0 to 100, or an expression that cannot be read.
            UnknownNameError: There is no such column or factor.
        """
        import pandas as pd

        if not all(0.0 <= q <= 100.0 for q in at):
            raise ConfigError(f"percentiles are numbers from 0 to 100, got {list(at)}")
        values = self._values(metric)
        if not by:
            return pd.DataFrame([np.nanpercentile(values, at) if values.notna().any() else [np.nan] * len(at)],
                                columns=list(at), index=[metric])  # fmt: skip
        for factor in by:
            self._require_factor(factor)
        groups = values.groupby([self.whole[factor] for factor in by], sort=True)
        return groups.quantile([q / 100.0 for q in at]).unstack().set_axis(list(at), axis=1)

    def paired(
        self,
        factor: str,
        first: float | str,
        second: float | str,
        metric: str,
        *,
        confidence: float = CONFIDENCE,
        judge: Callable[..., PairedDifference] = paired_difference,
    ) -> PairedDifference:
        """What it changes to set a factor from one value to another: runs of the same seed are compared.

        Runs are pairs that have the same seed and the same values of all other factors; pairs of one seed, which share
        its luck, count as their mean.

        Args:
            factor: What differs.
            first: Its value before.
            second: Its value after.
            metric: A column or an expression; of a condition it is the share of successes.
            confidence: Of the interval.
            judge: `sequential_difference` where the number of seeds follows from what they have shown.

        Raises:
            ConfigError: There are not two seeds with pairs.
            UnknownNameError: There is no such factor, value or column.
        """
        import pandas as pd

        self._require_factor(factor)
        known = sorted(self.table[factor].unique().tolist())
        for value in (first, second):
            if value not in known:
                raise UnknownNameError(f"value of {factor}", str(value), map(str, known))
        same = ["seed", *(name for name in self.factors if name != factor)]
        runs = self.whole[same].assign(value=self._values(metric)).dropna(subset="value")
        sides = [runs[self.whole.loc[runs.index, factor] == value] for value in (first, second)]
        if any(side.duplicated(same).any() for side in sides):
            raise ConfigError(f"paired: several runs have the same {', '.join(same)}")
        pairs = pd.merge(*sides, on=same, suffixes=("_first", "_second")).sort_values(same)
        means = pairs.groupby("seed")[["value_first", "value_second"]].mean()
        if len(means) < 2:
            raise ConfigError(
                f"paired: want 2 common seeds or more, got {len(means)} with {factor} = {first} and {second}"
            )
        return judge(means["value_first"].to_numpy(), means["value_second"].to_numpy(), confidence)

    def differences(self, metric: str) -> list[tuple[str, Any, Any, PairedDifference]]:
        """What each value of a factor changes against its first one: clear ones first, by how much factors matter.

        Args:
            metric: A column or an expression.

        Returns:
            Factor, first value, value and difference; of factors with 2 to 12 values that have common seeds.
        """
        found = []
        try:
            order = [effect.factor for effect in self.sensitivity(metric)]
        except ConfigError:  # the design cannot tell them apart
            order = list(self.factors)
        for factor in order:
            values = self.table[factor].unique().tolist()
            if not isinstance(values[0], str):  # words stay in the order in which they were given
                values.sort()
            for value in values[1:] if len(values) <= MOST_VALUES else ():
                with suppress(ConfigError):  # no common seeds
                    found.append((factor, values[0], value, self.paired(factor, values[0], value, metric)))
        return sorted(found, key=lambda row: not row[3].is_clear)

    def sensitivity(self, metric: str) -> tuple[FactorEffect, ...]:
        """Effects of all factors on a metric, the largest first.

        How they are computed follows from the design of the experiment: of a grid or a list from all runs, of other
        designs from the mean of each point's seeds.

        Args:
            metric: A column or an expression; of a condition it is the share of successes.

        Raises:
            ConfigError: There is no factor, or there are too few points for the design.
            UnknownNameError: There is no such column.
        """
        if not self.factors:
            raise ConfigError("sensitivity: nothing was varied; --set gives a factor values")
        points = self.by_point(metric)
        means = points.pop("value")
        design = self.experiment.design
        has_own_values = any(points[factor].nunique() == len(points) for factor in self.factors)
        if design == "points" and has_own_values and len(points) > 2:
            design = "random"  # points that somebody else has scattered
        if design in _OF_DESIGNS:
            return ranked(_OF_DESIGNS[design](points, self.factors, means))
        runs = self.whole.sort_values("run")
        values = self._values(metric)[runs.index].dropna()
        return ranked(main_effects(runs.loc[values.index], self.factors, values))

    def by_point(self, metric: str) -> pd.DataFrame:
        """The mean of a metric over the seeds of each point.

        Args:
            metric: A column or an expression.

        Returns:
            A row a point in their order, with the factors and `value`, which is not a number where no run had one.
        """
        names = list(self.factors)
        points = self.table.drop_duplicates("point").set_index("point").sort_index()[names]
        return points.assign(value=self._values(metric).groupby(self.whole["point"]).mean().reindex(points.index))

    def _values(self, metric: str) -> pd.Series:
        """Of the runs without an error, as numbers."""
        values = evaluate(self.whole, metric)
        if values.dtype.kind not in "fiub":
            raise ConfigError(f"{metric!r} is text, no number: choose one of {', '.join(self.metrics)}")
        return values.astype(float)

    def _require_factor(self, name: str) -> None:
        if name not in self.factors:
            raise UnknownNameError("factor", name, self.factors)

    # --- what is left of them ---------------------------------------------------------------------------------------

    def save_tables(self, folder: str | Path) -> tuple[Path, Path]:
        """Write `results.parquet` and `results.csv`; missing folders are made.

        Raises:
            OutputError: They cannot be written.
        """
        folder = Path(folder)
        parquet, csv = folder / "results.parquet", folder / "results.csv"
        path = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
            path = parquet
            self.table.to_parquet(parquet, index=False)
            path = csv
            self.table.to_csv(csv, index=False)
        except OSError as error:
            raise output_error("table", path, error) from error
        return parquet, csv


_OF_DESIGNS = {
    "morris": morris_effects,
    "saltelli": sobol_effects,
    "random": spread_effects,
    "latin": spread_effects,
    "sobol": spread_effects,
}
