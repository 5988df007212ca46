"""Results of a sweep: success rates, percentiles, and paired differences between runs with equal seeds.

A success is a run that meets a condition on the columns, e.g. `score >= 30` or `hits == shots and brownouts == 0`.
"""

from __future__ import annotations

import csv
import io
import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from simcore.errors import ConfigError, UnknownNameError
from simcore.sweep.sweep_statistics import (
    PERCENTILES,
    PairedDifference,
    Share,
    paired_difference,
    percentiles,
    wilson_share,
)
from simcore.telemetry.sinks import write_text
from simcore.typing import FloatArray

if TYPE_CHECKING:
    from simcore.sweep.experiment import Experiment

__all__ = ["MOST_VALUES", "TABLE_NAME", "Condition", "Results", "Row"]

Row = Mapping[str, Any]
"""Results of one run: values of `run`, `point`, `seed`, the factors, the metrics, `digest`, `version`, `error`
and `cpu_seconds`."""

TABLE_NAME = "results.csv"
MOST_VALUES = 12
"""Largest number of values of a factor for which summaries and pages show each value separately."""
_BEFORE, _AFTER = ("run", "point", "seed"), ("digest", "version", "error", "cpu_seconds")
_COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "<=": operator.le, ">=": operator.ge, "==": operator.eq, "!=": operator.ne, "<": operator.lt, ">": operator.gt,
}  # fmt: skip
_COMPARISON = re.compile(r"\s*([^<>=!]*[^<>=!\s])\s*(<=|>=|==|!=|<|>)\s*([^<>=!]*[^<>=!\s])\s*")


class Condition:
    """Condition on the row of a run: one or more comparisons of columns and numbers, joined by `and`.

    >>> condition = Condition("score >= 30 and hits == shots")
    >>> condition.names
    ('score', 'hits', 'shots')
    >>> condition.holds({"score": 31, "hits": 4, "shots": 4, "error": ""})
    True

    Raises:
        ConfigError: If the text is not a condition.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._parts: list[tuple[str, str, str | float]] = []
        for part in re.split(r"\band\b", text):
            found = _COMPARISON.fullmatch(part)
            if found is None:
                raise ConfigError(
                    f"{text!r} is not a condition: compare columns, as in 'score >= 30 and hits == shots' (with "
                    f"{' '.join(_COMPARISONS)}, joined by 'and')"
                )
            number = found[3]
            try:
                self._parts.append((found[1], found[2], float(number)))
            except ValueError:
                self._parts.append((found[1], found[2], number))

    @property
    def names(self) -> tuple[str, ...]:
        """Columns named in the condition, in order and without repetition."""
        sides = (side for left, _, right in self._parts for side in (left, right) if isinstance(side, str))
        return tuple(dict.fromkeys(sides))

    def holds(self, row: Row) -> bool:
        """Return whether a run ended without an error, has all columns of the condition, and meets the condition.

        Raises:
            ConfigError: If a column contains text.
        """
        if row["error"]:
            return False
        for name, sign, other in self._parts:
            sides = [row.get(name), row.get(other) if isinstance(other, str) else other]
            if any(isinstance(side, str) for side in sides):
                raise ConfigError(f"{self.text!r} compares words: choose numeric columns")
            if None in sides or not _COMPARISONS[sign](*sides):
                return False
        return True


@dataclass(frozen=True, slots=True)
class Results:
    """Rows of all runs of an experiment, with methods for statistics.

    A run that ended with an error has no metrics, is not a success, and is left out of percentiles.
    """

    rows: Sequence[Row]
    """Rows of the runs, sorted by run number."""
    experiment: Experiment
    """Experiment of the runs."""

    def __post_init__(self) -> None:
        missing = [name for name in (*_BEFORE, "error") for row in self.rows if name not in row]
        if missing:
            raise ConfigError(f"Results: a row has no {missing[0]}; it has {list(self.rows[0])}")
        object.__setattr__(self, "rows", tuple(sorted(self.rows, key=lambda row: row["run"])))

    # --- columns ----------------------------------------------------------------------------------------------------

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of all columns: run, point, seed, factors, metrics, digest, version, error, cpu_seconds."""
        found = dict.fromkeys(name for row in self.rows for name in row)
        outside = (*_BEFORE, *self.factors, *_AFTER)
        return (*_BEFORE, *self.factors, *(name for name in found if name not in outside), *_AFTER)

    @property
    def factors(self) -> tuple[str, ...]:
        """Names of the experiment's factors."""
        return tuple(factor.name for factor in self.experiment.factors)

    @property
    def metrics(self) -> tuple[str, ...]:
        """Names of the metrics that have a number in at least one run and text in none."""
        found = []
        for name in self.columns[len(_BEFORE) + len(self.factors) : -len(_AFTER)]:
            values = [row[name] for row in self.rows if row.get(name) is not None]
            if values and not any(isinstance(value, str) for value in values):
                found.append(name)
        return tuple(found)

    @property
    def finished(self) -> list[Row]:
        """Rows of the runs that ended without an error."""
        return [row for row in self.rows if not row["error"]]

    @property
    def failures(self) -> list[Row]:
        """Rows of the runs that ended with an error."""
        return [row for row in self.rows if row["error"]]

    def values(self, metric: str) -> FloatArray:
        """Return the values of a metric in the runs without an error, shape (n,); NaN for runs without the metric.

        Args:
            metric: Name of a column, or a condition; the values of a condition are 1 for true and 0 for false.

        Raises:
            ConfigError: If a column contains text, or the text is not a valid condition.
            UnknownNameError: If a column does not exist.
        """
        if metric not in self.columns and any(sign in metric for sign in _COMPARISONS):
            condition = self._condition(metric)
            return np.array([float(condition.holds(row)) for row in self.finished])
        if metric not in self.columns and self.finished:  # if all runs failed, no metric was measured
            raise UnknownNameError("column", metric, self.columns)
        found = [row.get(metric) for row in self.finished]
        if any(isinstance(value, str) for value in found):
            raise ConfigError(f"{metric!r} is text, not a number: choose one of {', '.join(self.metrics)}")
        return np.array([math.nan if value is None else float(value) for value in found])

    def factor_values(self, factor: str) -> list[Any]:
        """Return the distinct values of a factor, sorted if all values are numbers, otherwise in the order of the rows.

        Raises:
            UnknownNameError: If the factor does not exist.
        """
        if factor not in self.factors:
            raise UnknownNameError("factor", factor, self.factors)
        found = list(dict.fromkeys(row[factor] for row in self.rows))
        return found if any(isinstance(value, str) for value in found) else sorted(found)

    def _condition(self, text: str) -> Condition:
        condition = Condition(text)
        for name in condition.names:
            if name not in self.columns and self.finished:
                raise UnknownNameError("column", name, self.columns)
        return condition

    # --- statistics -------------------------------------------------------------------------------------------------

    def succeeded(self, condition: str) -> npt.NDArray[np.bool_]:
        """Return whether each run ended without an error and meets a condition, shape (n,).

        Raises:
            ConfigError: If the text is not a condition.
            UnknownNameError: If a column does not exist.
        """
        asked = self._condition(condition)
        return np.array([asked.holds(row) for row in self.rows], bool)

    def success(self, condition: str) -> Share:
        """Return the fraction of all runs that meet a condition, with Wilson's interval.

        Failed runs count as runs that do not meet the condition.

        Raises:
            ConfigError: If the text is not a condition.
            UnknownNameError: If a column does not exist.
        """
        held = self.succeeded(condition)
        return wilson_share(int(held.sum()), len(held))

    def success_by(self, factor: str, condition: str) -> dict[Any, Share]:
        """Return the success rate for each value of a factor, in the order of `factor_values`.

        Errors are those of `success` and `factor_values`.
        """
        held = self.succeeded(condition)
        found = {}
        for value in self.factor_values(factor):
            mine = held[[row[factor] == value for row in self.rows]]
            found[value] = wilson_share(int(mine.sum()), len(mine))
        return found

    def percentiles(self, metric: str, at: Sequence[float] = PERCENTILES) -> list[float]:
        """Return the percentiles `at` (0 to 100) of a metric; NaN if no run has the metric.

        Errors are those of `values`.
        """
        return percentiles(self.values(metric), at)

    def paired(self, factor: str, first: float | str, second: float | str, metric: str) -> PairedDifference:
        """Return the mean change of a metric when a factor changes from one value to another.

        The two runs of a pair have the same seed and the same values of all other factors. Pairs with the same seed are
        not independent, so the mean of these pairs counts as one pair.

        Args:
            factor: Name of the factor.
            first: Value of the factor before the change.
            second: Value of the factor after the change.
            metric: Name of a column, or a condition to compare success rates.

        Raises:
            ConfigError: If fewer than two seeds have pairs, or several runs have equal seed and factor values.
            UnknownNameError: If the factor, a value or the column does not exist.
        """
        known = self.factor_values(factor)
        for value in (first, second):
            if value not in known:
                raise UnknownNameError(f"value of {factor}", str(value), map(str, known))
        same = ["seed", *(name for name in self.factors if name != factor)]
        sides: dict[Any, dict[tuple[Any, ...], float]] = {first: {}, second: {}}
        for row, number in zip(self.finished, self.values(metric).tolist(), strict=True):
            if row[factor] in sides and not math.isnan(number):
                key = tuple(row[name] for name in same)
                if key in sides[row[factor]]:
                    raise ConfigError(f"paired: several runs have the same {', '.join(same)}")
                sides[row[factor]][key] = number
        seeds: dict[int, list[tuple[float, float]]] = {}
        for key in sorted(sides[first].keys() & sides[second].keys()):
            seeds.setdefault(key[0], []).append((sides[first][key], sides[second][key]))
        if len(seeds) < 2:
            raise ConfigError(
                f"paired: needs 2 common seeds or more, got {len(seeds)} with {factor} = {first} and {second}"
            )
        before, after = np.array([np.mean(pairs, axis=0) for pairs in seeds.values()]).T
        return paired_difference(before, after)

    def differences(self, metric: str) -> list[tuple[str, Any, Any, PairedDifference]]:
        """Return the change of a metric from the first value of each factor to every other value of the factor.

        Args:
            metric: Name of a column, or a condition.

        Returns:
            Factor, first value, other value and paired difference for each change, clear differences first. Factors
            with more than 12 values and values with fewer than 2 common seeds are left out.
        """
        found = []
        for factor in self.factors:
            first, *values = self.factor_values(factor)
            for value in values if len(values) < MOST_VALUES else ():
                with suppress(ConfigError):  # no common seeds
                    found.append((factor, first, value, self.paired(factor, first, value, metric)))
        return sorted(found, key=lambda row: not row[3].is_clear)

    # --- as a file --------------------------------------------------------------------------------------------------

    def save_table(self, folder: str | Path) -> Path:
        """Write all rows to `results.csv` in a folder, e.g. for pandas, and return the path of the file.

        Missing folders are created.

        Raises:
            OutputError: If the file cannot be written.
        """
        text = io.StringIO()
        writer = csv.DictWriter(text, self.columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(self.rows)
        path = Path(folder) / TABLE_NAME
        write_text("table", path, text.getvalue())
        return path
