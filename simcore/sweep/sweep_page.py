"""Text summary and HTML pages of the results of a sweep."""

from __future__ import annotations

import math
import shlex
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from simcore.match.registry import installed_games
from simcore.show.report import chart, headline, report_page, series, share, table
from simcore.sweep.results import MOST_VALUES, Condition, Results
from simcore.sweep.sweep_statistics import PERCENTILES, PairedDifference, percentiles
from simcore.typing import FloatArray

__all__ = ["comparison_page", "number_text", "summary_text", "sweep_page"]

Block = dict[str, object]
_MOST_RUNS = 10
_MOST_ERRORS = 20
_MOST_DISTRIBUTIONS = 6
_BINS = 24
_SEEN = 1e-3
_NAMES = {
    "score": "points", "distance_m": "distance driven [m]", "min_battery_v": "lowest battery voltage [V]",
    "seconds": "duration [s]", "taken_in": "taken in", "last_shot_s": "time of the last shot [s]",
    "hit_share": "share of hits", "flying": "in the air at the end",
}  # fmt: skip
"""Labels of metrics on the page, by column name; the label of any other metric is the column name."""
_HEADS = ("metric", *("median" if q == 50 else f"{q:g} %" for q in PERCENTILES))


def summary_text(results: Results, condition: str = "") -> str:
    """Return a summary for the terminal: counts, success rates, effects of factors, percentiles and errors.

    Args:
        results: Results of a sweep.
        condition: Condition of a success; empty for no condition.
    """
    lines = [_counts(results)]
    if condition:
        lines += ["", f"{condition}: {results.success(condition)}"]
        few = [factor for factor in results.factors if len(results.factor_values(factor)) <= MOST_VALUES]
        shares = ((factor, *row) for factor in few for row in results.success_by(factor, condition).items())
        lines += [f"  {factor} = {number_text(value)}: {share}" for factor, value, share in shares]
    main = _main_metric(results, condition)
    differences = [_difference_text(*row) for row in results.differences(main)] if main else []
    if differences:
        lines += ["", f"{main} with the same seeds:", *(f"  {text}" for text in differences)]
    if rows := [[name, *map(number_text, cells)] for name, *cells in _percentile_rows(results)]:
        width = max(len(row[0]) for row in rows)
        lines += [
            "",
            *(f"{name:{width}}{''.join(f'  {cell:>7}' for cell in cells)}" for name, *cells in (_HEADS, *rows)),
        ]
    if results.failures:
        lines += ["", f"{_count(len(results.failures), 'run')} ended with an error:"]
        errors = Counter(row["error"] for row in results.failures).most_common(5)
        lines += [f"  {error} ({_count(count, 'run')})" for error, count in errors]
    return "\n".join(lines)


def sweep_page(results: Results, condition: str, folder: Path) -> str:
    """Return the HTML page of a sweep: success rate, charts over the factors, distributions and tables of runs.

    Args:
        results: Results of the sweep.
        condition: Condition of a success; empty for no condition.
        folder: Folder of the store. The page quotes the folder in the command that repeats a run.
    """
    blocks = [_headline(results, condition)]
    if condition and (found := results.success(condition)).n:
        text = f"{found.value:.0%} of {found.n} runs, black: 95 % interval"
        blocks.append(share(found.value, found.lower, found.upper, text))
    main = _main_metric(results, condition)
    for factor in results.factors:
        blocks += _responses(results, factor, condition, main)
    blocks += [_distribution(metric, {"": results}) for metric in _spread_metrics(results)[:_MOST_DISTRIBUTIONS]]
    if rows := _percentile_rows(results):
        blocks.append(table(_HEADS, rows, "Metrics of all runs"))
    return report_page(_title(results), [*blocks, *_run_tables(results, main, folder)])


def comparison_page(results: Results, metric: str, difference: PairedDifference, folder: Path) -> str:
    """Return the HTML page that compares two variants: the two values of the first factor.

    Charts show the distributions of both variants on common axes.

    Args:
        results: Results of both variants.
        metric: Column or condition to compare.
        difference: Paired difference of the metric, second variant minus first variant.
        folder: Folder of the store. The page quotes the folder in the command that repeats a run.
    """
    factor = results.factors[0]
    old, new = results.factor_values(factor)
    sides = {
        str(value): Results([row for row in results.rows if row[factor] == value], results.experiment)
        for value in (old, new)
    }
    medians = [[name, *side.percentiles(metric, PERCENTILES), len(side.finished)] for name, side in sides.items()]
    verdict = "A clear difference" if difference.is_clear else "No clear difference"
    blocks = [
        headline(f"{verdict}: {metric} {difference.mean:+.3g}", f"{metric}, {new} minus {old}: {difference}"),
    ]
    varied = dict.fromkeys([*(name for name in [metric] if name in results.metrics), *_spread_metrics(results)])
    blocks += [_distribution(name, sides) for name in [*varied][:_MOST_DISTRIBUTIONS]]
    blocks.append(table((*_HEADS, "runs"), medians, f"{metric} of each"))
    return report_page(f"{old} against {new}", [*blocks, *_run_tables(results, "", folder)])


# --- text ---------------------------------------------------------------------------------------------------------


def number_text(value: float | str) -> str:
    """Format a number with three significant digits, or as a whole number from 1000 on; text is unchanged.

    >>> [number_text(value) for value in (0.30000000000000004, 32, 1234.567, -0.0, "left")]
    ['0.3', '32', '1235', '0', 'left']
    """
    if isinstance(value, str):
        return value
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value + 0.0:.3g}"


def _headline(results: Results, condition: str) -> Block:
    """Return the headline block: the success rate, or the median of the main metric if `condition` is empty.

    If no run has a metric, the headline is the number of runs.
    """
    counts = _counts(results)
    if condition:
        share = results.success(condition)
        return headline(f"{share.k} of {share.n}, {share.interval}", f"{condition}; 95 % interval; {counts}")
    main = _main_metric(results)
    if not main:
        return headline(counts)
    low, middle, high = map(number_text, results.percentiles(main, (5, 50, 95)))
    return headline(f"{_name(main)}: {middle}, from {low} to {high}", f"median, 5 and 95 %; {counts}")


def _title(results: Results) -> str:
    experiment = results.experiment
    game = experiment.game or next(iter(installed_games()), "the newest game")
    what = game if experiment.project is None else Path(experiment.project).resolve().name
    sides = {side: "as varied" if side in results.factors else getattr(experiment, side) for side in ("red", "blue")}
    if any(sides.values()):
        return f"Sweep: {what}, matches, {', '.join(f'{side} {who}' for side, who in sides.items() if who)}"
    return f"Sweep: {what}, {f'auto {experiment.auto}' if experiment.auto else 'its first auto'}"


def _counts(results: Results) -> str:
    points, seeds = ({row[name] for row in results.rows} for name in ("point", "seed"))
    varied = f" at {_count(len(points), 'point')} of {', '.join(results.factors)}" if results.factors else ""
    errors = f"; {len(results.failures)} ended with an error" if results.failures else ""
    return f"{_count(len(results.rows), 'run')}{varied}, {_count(len(seeds), 'seed')}{errors}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _difference_text(factor: str, first: float | str, value: float | str, difference: PairedDifference) -> str:
    return f"{factor} = {number_text(value)} against {number_text(first)}: {difference}"


def _name(metric: str) -> str:
    return _NAMES.get(metric, metric)


# --- metrics ------------------------------------------------------------------------------------------------------


def _main_metric(results: Results, condition: str = "") -> str:
    """Return the name of the metric for the charts over the factors; empty if no run has a metric.

    Metrics that differ between runs have priority: first the metrics in the condition, then the score, then all others.
    """
    first, varied = [*(Condition(condition).names if condition else ()), "score"], _varied_metrics(results)
    wanted = [*(name for name in first if name in varied), *varied, *first]
    return next((name for name in wanted if name in results.metrics), "")


def _varied_metrics(results: Results) -> list[str]:
    """Return the metrics that differ between runs.

    If several metrics have the same value in every run, return only the first of these metrics.
    """
    found: dict[tuple[Any, ...], str] = {}
    for name in results.metrics:
        values = tuple(row.get(name) for row in results.finished)
        if len({*values} - {None}) > 1:
            found.setdefault(values, name)
    return list(found.values())


def _spread_metrics(results: Results) -> list[str]:
    """Return the metrics with a range over all runs that exceeds 0.1 % of the largest absolute value, and 0.001."""
    found = []
    for name in _varied_metrics(results):
        values = results.values(name)
        values = values[np.isfinite(values)]
        if len(values) and np.ptp(values) > _SEEN * max(1.0, float(np.abs(values).max())):
            found.append(name)
    return found


def _percentile_rows(results: Results) -> list[list[Any]]:
    kept = [name for name in (_main_metric(results), "score") if name in results.metrics]  # even if these do not vary
    metrics = dict.fromkeys((*kept, *_varied_metrics(results)))
    return [[name, *results.percentiles(name, PERCENTILES)] for name in metrics]


# --- blocks -------------------------------------------------------------------------------------------------------


def _responses(results: Results, factor: str, condition: str, main: str) -> Iterator[Block]:
    """Yield charts of the success rate and of the main metric over a factor.

    For a factor with more than 12 values, the only chart shows the main metric of each run as a point.
    """
    values = results.factor_values(factor)
    has_few = len(values) <= MOST_VALUES
    if condition and has_few:
        shares = results.success_by(factor, condition).items()
        points = [(value, share.value, share.lower, share.upper) for value, share in shares]
        yield _over(f"{condition} over {factor}", factor, points, "share of successes, 95 % interval")
    if not main:
        return
    column, numbers = [row[factor] for row in results.finished], results.values(main)
    title = f"{_name(main)} over {factor}"
    if has_few:
        parts = [(value, percentiles(numbers[[own == value for own in column]], (50, 5, 95))) for value in values]
        yield _over(title, factor, [(value, *part) for value, part in parts], "median, 90 % of the runs")
    else:
        points = [(at, number, number, number) for at, number in sorted(zip(column, numbers.tolist(), strict=True))]
        yield _over(title, factor, points, f"{_name(main)} of each run")


def _over(title: str, factor: str, points: Sequence[tuple[Any, ...]], label: str) -> Block:
    at, middle, low, high = ([point[k] for point in points] for k in range(4))
    names = [number_text(value) for value in at] if any(isinstance(value, str) for value in at) else None
    x = at if names is None else list(range(len(at)))
    return chart(title, [series("", x, middle, low=low, high=high, kind="dots")], x_label=factor, y_label=label,
                 x_names=names)  # fmt: skip


def _distribution(metric: str, sides: dict[str, Results]) -> Block:
    """Return a histogram of a metric over all runs, with bars for one set of results and steps for several sets."""
    values = {name: side.values(metric) for name, side in sides.items()}
    values = {name: found[np.isfinite(found)] for name, found in values.items()}
    edges = _bin_edges(np.concatenate([*values.values()]))
    middles = 0.5 * (edges[:-1] + edges[1:])
    kind = "bars" if len(sides) == 1 else "steps"
    curves = [series(name, middles, np.histogram(found, edges)[0], kind=kind) for name, found in values.items()]
    medians = [(float(np.median(found)), f"median {name}".strip()) for name, found in values.items() if len(found)]
    return chart(f"{_name(metric)} of all runs", curves, x_label=_name(metric), y_label="runs", marks=medians,
                 from_zero=True)  # fmt: skip


def _bin_edges(values: FloatArray) -> FloatArray:
    """Return the edges of up to about 24 histogram bins; the bins of whole numbers are centered on whole numbers."""
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    if np.array_equal(values, np.round(values)):
        step = max(1, math.ceil((high - low + 1) / _BINS))
        edges: FloatArray = np.arange(low - 0.5, high + step + 0.5, step)
        return edges if len(edges) > 1 else np.array([low - 0.5, low + 0.5])
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        return np.array([low - 0.5, low + 0.5])
    return np.linspace(low, high, min(_BINS, 1 + round(math.sqrt(len(values)) * 1.5)) + 1)


def _run_tables(results: Results, main: str, folder: Path) -> Iterator[Block]:
    """Yield a table of the 10 runs with the lowest main metric, and a table of the first 20 failed runs."""
    heads = ("run", "seed", *results.factors)
    again = f"to see one: simcore sweep --out {shlex.quote(str(folder))} --repeat RUN"
    known = [row for row in results.finished if main and row.get(main) is not None]
    lowest = sorted(known, key=lambda row: (row[main], row["run"]))[:_MOST_RUNS]
    columns = (*heads, *_varied_metrics(results)[:6])
    for title, names, runs in (
        (f"Runs with the lowest {_name(main)}", columns, lowest),
        ("Runs that ended with an error", (*heads, "error"), results.failures[:_MOST_ERRORS]),
    ):
        if runs:
            yield table(names, [[row.get(name) for name in names] for row in runs], f"{title}; {again}")
