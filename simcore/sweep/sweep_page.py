"""Results of a sweep as text for a terminal, and as a page that a browser draws."""

from __future__ import annotations

import logging
import math
import shlex
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from simcore.errors import SimcoreError
from simcore.match.registry import installed_games
from simcore.show.palette import tint
from simcore.show.report import chart, field_map, headline, heat, report_page, series, table
from simcore.show.scene import Scene, bare_scene
from simcore.sweep.one_run import game_of
from simcore.sweep.results import MOST_VALUES, Condition, Results, Row
from simcore.sweep.run_metrics import LANDINGS, landings_of
from simcore.sweep.sweep_statistics import PERCENTILES, PairedDifference, percentiles, wilson_share
from simcore.telemetry.sinks import write_text
from simcore.typing import FloatArray

__all__ = ["comparison_page", "number_text", "save_page", "scene_of_results", "summary_text", "sweep_page"]

_log = logging.getLogger(__name__)

Block = dict[str, object]
_MOST_RUNS = 10
_MOST_ERRORS = 20
_MOST_DISTRIBUTIONS = 6
_BINS = 24
_PARTS = 8  # of the runs, where a factor has more values than are shown each
_CELL = 0.25  # [m], of a map of landings
_NAMES = {
    "score": "points", "distance_m": "way driven [m]", "min_battery_v": "lowest battery voltage [V]",
    "seconds": "duration [s]", "taken_in": "taken in", "last_shot_s": "time of the last shot [s]",
    "hit_share": "share of hits", "flying": "in the air at the end",
}  # fmt: skip
"""Readers' names of metrics whose names are those of columns."""
_HEADS = ("metric", *("median" if q == 50 else f"{q:g} %" for q in PERCENTILES))


def summary_text(results: Results, condition: str = "") -> str:
    """Return what a terminal shows: counts, what factors change, shares of success, percentiles.

    Args:
        results: Of a sweep.
        condition: Of a success; empty: nothing is.
    """
    lines = [_counts(results)]
    if condition:
        lines += ["", f"{condition}: {results.success(condition)}"]
        lines += [f"  {name}: {share}" for name, share in _shares(results, condition)]
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


def sweep_page(results: Results, condition: str, folder: Path, scene: Scene | None) -> str:
    """Return the page of a sweep.

    Args:
        results: Of it.
        condition: Of a success; empty: nothing is.
        folder: Of its store, for the command that repeats a run.
        scene: The bare field, for maps of landings; None: none.
    """
    blocks = [_headline(results, condition)]
    main = _main_metric(results, condition)
    for factor in results.factors:
        blocks += _responses(results, factor, condition, main)
    blocks += _mean_table(results, condition or main)
    if rows := _percentile_rows(results):
        blocks.append(table(_HEADS, rows, "Metrics of all runs"))
    blocks += [_distribution(metric, {"": results}) for metric in _varied_metrics(results)[:_MOST_DISTRIBUTIONS]]
    blocks += _landing_maps({"": results}, scene)
    return report_page(_title(results), [*blocks, *_run_tables(results, main, folder)])


def comparison_page(
    results: Results, metric: str, difference: PairedDifference, folder: Path, scene: Scene | None
) -> str:
    """Return the page of two variants, the values of the first factor, both on each axis; arguments as `sweep_page`.

    Args:
        results: Of both.
        metric: Column or condition that is compared.
        difference: Of this metric.
        folder: Of the store.
        scene: The bare field, for maps of landings; None: none.
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
        headline(f"{verdict}: {metric} {difference.mean:+.3g}", f"{metric}, {new} less {old}: {difference}"),
        table((*_HEADS, "runs"), medians, f"{metric} of each"),
        _by_seed(results, metric, sides),
    ]
    varied = dict.fromkeys([*(name for name in [metric] if name in results.metrics), *_varied_metrics(results)])
    blocks += [_distribution(name, sides) for name in [*varied][:_MOST_DISTRIBUTIONS]]
    blocks += _landing_maps(sides, scene)
    return report_page(f"{old} against {new}", [*blocks, *_run_tables(results, "", folder)])


def save_page(text: str, folder: Path) -> Path:
    """Write `page.html`; missing folders are made.

    Raises:
        OutputError: It cannot be written.
    """
    path = folder / "page.html"
    write_text("page", path, text)
    return path


def scene_of_results(results: Results) -> Scene | None:
    """Return the bare field of the game, where runs have shots on it."""
    if LANDINGS not in results.columns:
        return None
    try:
        return bare_scene(game_of(results.experiment.game))
    except SimcoreError as error:  # its package may have changed since the runs were played
        _log.warning("maps without the field: %s", error)
        return None


# --- words --------------------------------------------------------------------------------------------------------


def number_text(value: float | str) -> str:
    """Return a number with as many digits as a reader needs; words stay as they are.

    >>> [number_text(value) for value in (0.30000000000000004, 32, 1234.567, -0.0, "left")]
    ['0.3', '32', '1235', '0', 'left']
    """
    if isinstance(value, str):
        return value
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value + 0.0:.3g}"


def _headline(results: Results, condition: str) -> Block:
    """Say in one line how often it works; without a condition the median of the main metric."""
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
    what = experiment.project or experiment.game or next(iter(installed_games()), "the newest game")
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


def _shares(results: Results, condition: str) -> list[tuple[str, object]]:
    """Return shares of successes of each value of each factor that has few."""
    return [
        (f"{factor} = {number_text(value)}", share)
        for factor in results.factors
        if len(results.factor_values(factor)) <= MOST_VALUES
        for value, share in results.success_by(factor, condition).items()
    ]


def _name(metric: str) -> str:
    return _NAMES.get(metric, metric)


# --- metrics ------------------------------------------------------------------------------------------------------


def _main_metric(results: Results, condition: str = "") -> str:
    """Return the metric that is drawn over everything; empty: there is none.

    The first of the condition, else the score, if they differ between runs, else the first that does.
    """
    first, varied = [*(Condition(condition).names if condition else ()), "score"], _varied_metrics(results)
    wanted = [*(name for name in first if name in varied), *varied, *first]
    return next((name for name in wanted if name in results.metrics), "")


def _varied_metrics(results: Results) -> list[str]:
    """Return metrics that are not the same in all runs; of several with equal values in each run the first."""
    found: dict[tuple[Any, ...], str] = {}
    for name in results.metrics:
        values = tuple(row.get(name) for row in results.finished)
        if len({*values} - {None}) > 1:
            found.setdefault(values, name)
    return list(found.values())


def _percentile_rows(results: Results) -> list[list[Any]]:
    kept = [name for name in (_main_metric(results), "score") if name in results.metrics]  # whether they vary or not
    metrics = dict.fromkeys((*kept, *_varied_metrics(results)))
    return [[name, *results.percentiles(name, PERCENTILES)] for name in metrics]


# --- blocks -------------------------------------------------------------------------------------------------------


def _responses(results: Results, factor: str, condition: str, main: str) -> Iterator[Block]:
    """Draw the share of successes and the main metric over a factor."""
    if condition:
        held = results.succeeded(condition)
        shares = [(at, wilson_share(int(held[rows].sum()), len(rows))) for at, rows in _groups(results.rows, factor)]
        points = [(at, share.value, share.lower, share.upper) for at, share in shares]
        yield _over(f"{condition} over {factor}", factor, points, "share of successes, 95 % interval")
    if main:
        values, points = results.values(main), []
        for at, rows in _groups(results.finished, factor):
            low, middle, high = percentiles(values[rows], (5, 50, 95))
            points.append((at, middle, low, high))
        yield _over(f"{_name(main)} over {factor}", factor, points, "median, 90 % of the runs")


def _over(title: str, factor: str, points: Sequence[tuple[Any, float, float, float]], label: str) -> Block:
    at, middle, low, high = ([point[k] for point in points] for k in range(4))
    names = None if all(not isinstance(value, str) for value in at) else [number_text(value) for value in at]
    x = at if names is None else list(range(len(at)))
    return chart(title, [series("", x, middle, low=low, high=high, kind="dots")], x_label=factor, y_label=label,
                 x_names=names)  # fmt: skip


def _groups(rows: Sequence[Row], factor: str) -> list[tuple[float | str, list[int]]]:
    """Group numbers of rows by values of the factor, or by the middles of parts where there are many."""
    column = [row[factor] for row in rows]
    known = list(dict.fromkeys(column))
    if any(isinstance(value, str) for value in known):
        return [(value, [n for n, own in enumerate(column) if own == value]) for value in known]
    if len(known) <= MOST_VALUES:
        return [(float(value), [n for n, own in enumerate(column) if own == value]) for value in sorted(known)]
    parts = np.array_split(np.argsort(column, kind="stable"), _PARTS)
    return [(float(np.median([column[n] for n in part])), part.tolist()) for part in parts]


def _mean_table(results: Results, metric: str) -> Iterator[Block]:
    """Tell means of a metric over the first two factors that have few values each."""
    factors = [name for name in results.factors if 2 <= len(results.factor_values(name)) <= MOST_VALUES]
    if not metric or len(factors) < 2:
        return
    down, across = factors[:2]
    cells: dict[tuple[Any, Any], list[float]] = {}
    for row, value in zip(results.finished, results.values(metric).tolist(), strict=True):
        if math.isfinite(value):
            cells.setdefault((row[down], row[across]), []).append(value)
    rows, columns = results.factor_values(down), results.factor_values(across)
    means = [[float(np.mean(cells[at, of])) if (at, of) in cells else math.nan for of in columns] for at in rows]
    yield heat(f"Mean {_name(metric)}", [number_text(value) for value in columns],
               [number_text(value) for value in rows], means, x_label=across, y_label=down)  # fmt: skip


def _distribution(metric: str, sides: dict[str, Results]) -> Block:
    """Count runs by their value of a metric: of one side in bars, of two in steps on one axis."""
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
    """Return edges of bars: whole numbers in the middle of theirs, else some 24 equal ones."""
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    if np.array_equal(values, np.round(values)):
        step = max(1, math.ceil((high - low + 1) / _BINS))
        edges: FloatArray = np.arange(low - 0.5, high + step + 0.5, step)
        return edges if len(edges) > 1 else np.array([low - 0.5, low + 0.5])
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        return np.array([low - 0.5, low + 0.5])
    return np.linspace(low, high, min(_BINS, 1 + round(math.sqrt(len(values)) * 1.5)) + 1)


def _by_seed(results: Results, metric: str, sides: dict[str, Results]) -> Block:
    """Draw the metric of each seed, both sides on one axis."""
    curves = []
    for name, side in sides.items():
        found: dict[int, list[float]] = {}
        for row, value in zip(side.finished, side.values(metric).tolist(), strict=True):
            found.setdefault(row["seed"], []).append(value)
        seeds = sorted(found)
        curves.append(series(name, seeds, [float(np.mean(found[seed])) for seed in seeds], kind="dots"))
    return chart(f"{_name(metric)} by seed", curves, x_label="seed", y_label=_name(metric))


def _landing_maps(sides: dict[str, Results], scene: Scene | None) -> Iterator[Block]:
    """Draw where hits and misses came down, counted in cells of 25 cm."""
    if scene is None:
        return
    outlines = [(tint(name)[0], corners.tolist()) for name, corners in scene.field_outlines]
    length, width = scene.field_size
    for side, results in sides.items():
        for what, places in landings_of(row.get(LANDINGS) for row in results.finished).items():
            cells = Counter(map(tuple, np.floor(np.clip(places, 0.0, (length, width)) / _CELL).tolist()))
            points = [
                {"x": _CELL * (x + 0.5), "y": _CELL * (y + 0.5), "value": count, "label": f"{count} {what}"}
                for (x, y), count in cells.items()
            ]
            if points:
                title = f"{side}: where {what} came down" if side else f"Where {what} came down"
                yield field_map(f"{title} ({len(places)})", scene.field_size, outlines, points, unit=what,
                                point_size=0.5 * _CELL)  # fmt: skip


def _run_tables(results: Results, main: str, folder: Path) -> Iterator[Block]:
    """List runs with the lowest main metric, and those that failed."""
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
