"""The runs of a sweep and what they say: shares of success, percentiles, differences on common seeds.

What is asked of runs is text: `score >= 30`, `hits == shots and brownouts == 0`, `hits / shots`.
"""

from __future__ import annotations

import ast
import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from simcore.errors import ConfigError, UnknownNameError, VendorError
from simcore.sweep.sweep_statistics import (
    CONFIDENCE,
    PERCENTILES,
    PairedDifference,
    Share,
    paired_difference,
    seed_share,
)
from simcore.telemetry.sinks import write_text
from simcore.typing import FloatArray

if TYPE_CHECKING:
    import pandas as pd

    from simcore.sweep.experiment import Experiment

__all__ = ["MOST_VALUES", "TABLE_NAME", "ColumnExpression", "Results", "Row", "read_rows"]

Row = Mapping[str, Any]
"""Of a run: `run`, `point`, `seed`, a value for each factor and metric, `digest`, `version`, `error`, `cpu_seconds`."""

TABLE_NAME = "results.csv"
MOST_VALUES = 12
"""Of a factor that are told and shown each."""
_BEFORE, _AFTER = ("run", "point", "seed"), ("digest", "version", "error", "cpu_seconds")
_TEXTS = ("digest", "version", "error")
"""Columns that are text even where they look like numbers."""


@dataclass(frozen=True, slots=True)
class Results:
    """All runs of an experiment.

    A run that ended with an error has no metrics: it is no success, and in no percentile.
    """

    rows: Sequence[Row]
    """A row a run, by number."""
    experiment: Experiment
    """What was asked for."""

    def __post_init__(self) -> None:
        missing = [name for name in (*_BEFORE, "error") for row in self.rows if name not in row]
        if missing:
            raise ConfigError(f"Results: a row has no {missing[0]}; it has {list(self.rows[0])}")
        object.__setattr__(self, "rows", tuple(sorted(self.rows, key=lambda row: row["run"])))

    # --- columns ----------------------------------------------------------------------------------------------------

    @property
    def table(self) -> pd.DataFrame:
        """All runs as a table of pandas, a row each; what could not be measured is NaN.

        Raises:
            VendorError: pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError as error:
            raise VendorError("a table of runs needs pandas: `python -m pip install pandas`") from error
        found = pd.DataFrame(list(self.rows), columns=list(self.columns))
        return found.astype(dict.fromkeys(self.metrics, float)) if self.rows else found

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of all columns in their order: run, point, seed, factors, metrics, and how the run ended."""
        found = dict.fromkeys(name for row in self.rows for name in row)
        outside = (*_BEFORE, *self.factors, *_AFTER)
        return (*_BEFORE, *self.factors, *(name for name in found if name not in outside), *_AFTER)

    @property
    def factors(self) -> tuple[str, ...]:
        """Names of what was varied."""
        return tuple(factor.name for factor in self.experiment.factors)

    @property
    def metrics(self) -> tuple[str, ...]:
        """Names of the columns of numbers that runs have brought."""
        found = []
        for name in self.columns[len(_BEFORE) + len(self.factors) : -len(_AFTER)]:
            values = [row[name] for row in self.rows if row.get(name) is not None]
            if values and not any(isinstance(value, str) for value in values):
                found.append(name)
        return tuple(found)

    @property
    def finished(self) -> list[Row]:
        """The runs without an error."""
        return [row for row in self.rows if not row["error"]]

    @property
    def failures(self) -> list[Row]:
        """The runs with one."""
        return [row for row in self.rows if row["error"]]

    def values(self, metric: str) -> FloatArray:
        """A metric of the finished runs, not a number where it could not be measured, shape (n,).

        Args:
            metric: A column, or an expression of columns, e.g. `hits / shots`.

        Raises:
            ConfigError: It cannot be read, or is text.
            UnknownNameError: There is no such column.
        """
        expression, found = self._expression(metric), [math.nan] * len(self.finished)
        for number, row in enumerate(self.finished):
            if expression.is_known(row):
                value = expression.value(row)
                if isinstance(value, str):
                    raise ConfigError(f"{metric!r} is text, no number: choose one of {', '.join(self.metrics)}")
                found[number] = float(value)
        return np.array(found)

    def factor_values(self, factor: str) -> list[Any]:
        """The different values of a factor: numbers by size, words in the order in which they were given.

        Raises:
            UnknownNameError: There is no such factor.
        """
        if factor not in self.factors:
            raise UnknownNameError("factor", factor, self.factors)
        found = list(dict.fromkeys(row[factor] for row in self.rows))
        return found if any(isinstance(value, str) for value in found) else sorted(found)

    def _expression(self, text: str) -> ColumnExpression:
        expression = ColumnExpression(text, self.columns)
        for name in expression.names:
            if name not in self.columns and self.finished:  # where all have failed nothing was measured
                raise UnknownNameError("column", name, self.columns)
        return expression

    # --- statistics -------------------------------------------------------------------------------------------------

    def succeeded(self, condition: str) -> npt.NDArray[np.bool_]:
        """Whether each run was a success, shape (n,).

        Args:
            condition: As `success` takes it.
        """
        expression = self._expression(condition)
        return np.array([_succeeded(row, expression) for row in self.rows], bool)

    def success(self, condition: str, *, confidence: float = CONFIDENCE) -> Share:
        """How often a condition held, with an interval that takes runs of one seed for as alike as they are.

        Args:
            condition: Of columns, e.g. `score >= 30` or `hits == shots and brownouts == 0`.
            confidence: Of the interval.

        Raises:
            ConfigError: It is no condition.
            UnknownNameError: There is no such column.
        """
        return self._share(self.succeeded(condition), np.full(len(self.rows), True), confidence)

    def success_by(self, factor: str, condition: str, *, confidence: float = CONFIDENCE) -> dict[Any, Share]:
        """The same for each value of a factor, in their order.

        Raises:
            ConfigError: It is no condition.
            UnknownNameError: There is no such column or factor.
        """
        held = self.succeeded(condition)
        return {
            value: self._share(held, np.array([row[factor] == value for row in self.rows]), confidence)
            for value in self.factor_values(factor)
        }

    def _share(self, held: npt.NDArray[np.bool_], chosen: npt.NDArray[np.bool_], confidence: float) -> Share:
        seeds = np.array([row["seed"] for row in self.rows])
        return seed_share(held[chosen], seeds[chosen], confidence)

    def percentiles(self, metric: str, at: Sequence[float] = PERCENTILES, *, by: Sequence[str] = ()) -> pd.DataFrame:
        """A table of percentiles of a metric, a column each; 50 is the median.

        Args:
            metric: A column, or an expression of columns, e.g. `hits / shots`.
            at: Which percentiles.
            by: Factors; a row for each combination of their values. Without any there is one row.

        Raises:
            ConfigError: A percentile that is not from 0 to 100, or an expression that cannot be read.
            UnknownNameError: There is no such column or factor.
            VendorError: pandas is not installed.
        """
        if not all(0.0 <= q <= 100.0 for q in at):
            raise ConfigError(f"percentiles are numbers from 0 to 100, got {list(at)}")
        for factor in by:
            self.factor_values(factor)
        runs = Results(self.finished, self.experiment).table.assign(**{metric: self.values(metric)})
        shares = [q / 100.0 for q in at]
        found = runs.groupby(list(by))[metric].quantile(shares).unstack() if by else runs[[metric]].quantile(shares).T
        return found.set_axis(list(at), axis=1)

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
                f"paired: want 2 common seeds or more, got {len(seeds)} with {factor} = {first} and {second}"
            )
        before, after = np.array([np.mean(pairs, axis=0) for pairs in seeds.values()]).T
        return judge(before, after, confidence)

    def differences(self, metric: str) -> list[tuple[str, Any, Any, PairedDifference]]:
        """What each value of a factor changes against its first one; clear ones first.

        Args:
            metric: A column or an expression.

        Returns:
            Factor, first value, value and difference; of factors with 2 to 12 values that have common seeds.
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
        """Write `results.csv`, which `read_rows` reads; missing folders are made.

        Raises:
            OutputError: It cannot be written.
        """
        text = io.StringIO()
        writer = csv.DictWriter(text, self.columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(self.rows)
        path = Path(folder) / TABLE_NAME
        write_text("table", path, text.getvalue())
        return path


def read_rows(folder: str | Path) -> list[Row]:
    """The rows that `Results.save_table` wrote.

    Raises:
        ConfigError: There are none.
    """
    path = Path(folder) / TABLE_NAME
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            return [
                {name: text if name in _TEXTS else _plain(text) for name, text in row.items()}
                for row in csv.DictReader(stream)
            ]
    except OSError as error:
        raise ConfigError(f"{folder} has no {TABLE_NAME}: its sweep has not come to an end") from error


def _plain(text: str) -> Any:
    """What a cell has been: a number, a word, or nothing."""
    for kind in (int, float):
        with suppress(ValueError):
            return kind(text)
    return text or None


# --- expressions --------------------------------------------------------------------------------------------------

_EXAMPLE = "want columns, numbers, + - * /, comparisons, and, or, not, e.g. 'score >= 30 and brownouts == 0'"
_ALLOWED = (
    *(ast.Expression, ast.BoolOp, ast.boolop, ast.UnaryOp, ast.Not, ast.USub, ast.BinOp, ast.Add, ast.Sub, ast.Mult),
    *(ast.Div, ast.Compare, ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Constant),
)


class ColumnExpression(ast.NodeTransformer):
    """An expression of columns: names, numbers, words in quotes, `+ - * /`, comparisons, `and`, `or`, `not`.

    >>> ColumnExpression("hits / shots >= 0.9 and battery.charge < 1").names
    ['hits', 'shots', 'battery.charge']

    Args:
        text: Of the expression.
        columns: Names that are taken whole, whatever is in them.

    Raises:
        ConfigError: It is none of these.
    """

    def __init__(self, text: str, columns: Sequence[str] = ()) -> None:
        self.text = text
        self.names: list[str] = []
        """Columns that it reads, in order."""
        if text in columns:  # which may have any characters
            self.names.append(text)
            tree: Any = ast.parse(f"row[{text!r}]", mode="eval")
        else:
            try:
                tree = ast.fix_missing_locations(self.visit(ast.parse(text.strip(), mode="eval")))
            except (SyntaxError, RecursionError) as error:
                raise ConfigError(f"{text!r} cannot be read: {_EXAMPLE}") from error
        self._code = compile(tree, "expression", "eval")

    def is_known(self, row: Row) -> bool:
        """Whether a row has all that it reads."""
        return all(row.get(name) is not None and row[name] == row[name] for name in self.names)

    def value(self, row: Row) -> Any:
        """Its value in a row that has all that it reads: True or False of a condition, NaN where it divides by zero.

        Raises:
            ConfigError: It calculates with words.
        """
        try:
            return eval(self._code, {"__builtins__": {}}, {"row": row})
        except ZeroDivisionError:
            return math.nan
        except TypeError as error:
            raise ConfigError(f"{self.text!r} calculates with words: {_EXAMPLE}") from error

    def condition(self, row: Row) -> bool:
        """Its value in a row, which is true or false; false where it divides by zero.

        Raises:
            ConfigError: It is something else.
        """
        value = self.value(row)
        if not isinstance(value, bool) and value == value:
            raise ConfigError(f"{self.text!r} is no condition: compare it with something, e.g. 'score >= 30'")
        return value is True

    def generic_visit(self, node: ast.AST) -> ast.AST:
        """Refuse what is no part of an expression, and turn names into columns of the row."""
        name = _dotted(node)
        if name is not None:
            if name not in self.names:
                self.names.append(name)
            return ast.Subscript(ast.Name("row", ast.Load()), ast.Constant(name), ast.Load())
        if not isinstance(node, _ALLOWED):
            raise ConfigError(f"{self.text!r} has {ast.unparse(node)!r} in it: {_EXAMPLE}")
        sides = (node.left, node.right) if isinstance(node, ast.BinOp) else ()
        if any(isinstance(getattr(side, "value", None), str) for side in sides):
            raise ConfigError(f"{self.text!r} calculates with words: {_EXAMPLE}")
        return super().generic_visit(node)


def _dotted(node: ast.AST) -> str | None:
    """A name, or names joined by dots; None for anything else."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute) and (owner := _dotted(node.value)) is not None:
        return f"{owner}.{node.attr}"
    return None


def _succeeded(row: Row, expression: ColumnExpression) -> bool:
    return not row["error"] and expression.is_known(row) and expression.condition(row)
