"""What came of a sweep as one HTML file without network, its drawings as pictures, and as text for a terminal."""

from __future__ import annotations

import logging
import math
import re
import shlex
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import SimcoreError
from simcore.match.registry import installed_games
from simcore.show.page import page_style
from simcore.show.raster import save_drawing
from simcore.sweep.one_run import game_of
from simcore.sweep.results import MOST_VALUES, ColumnExpression, Results, Row
from simcore.sweep.sweep_charts import (
    ChartPoint,
    distribution_chart,
    heat_map,
    landings_of,
    number_text,
    response_chart,
)
from simcore.sweep.sweep_statistics import PERCENTILES, PairedDifference, Share, seed_share
from simcore.telemetry.sinks import write_text
from simcore.typing import FloatArray

if TYPE_CHECKING:
    from simcore.show.scene import Scene

__all__ = ["ResultDrawing", "drawings_of", "save_results", "summary_text"]

_log = logging.getLogger(__name__)

_MOST_RUNS = 10
_MOST_ERRORS = 20
_MOST_DISTRIBUTIONS = 6
_PARTS = 8  # of the runs, where a factor has more values than are shown each
_NARROW, _WIDE = 720, 1200  # of pictures [px]
_UNITS = {"score": "points", "distance_m": "m", "min_battery_v": "V", "seconds": "s", "last_shot_s": "s"}
_NAMES = {
    "distance_m": "way driven", "min_battery_v": "lowest battery voltage", "seconds": "duration",
    "taken_in": "taken in", "last_shot_s": "time of the last shot", "hit_share": "share of hits",
}  # fmt: skip
"""What a reader calls metrics whose names are those of columns."""
_HEADS = ("metric", *("median" if q == 50 else f"{q:g} %" for q in PERCENTILES))


def summary_text(results: Results, condition: str = "") -> str:
    """What a terminal shows: counts, what factors change, shares of success, percentiles.

    Args:
        results: Of a sweep.
        condition: What a success is; empty: that of the experiment's stop rule, if it has one.
    """
    condition = condition or results.experiment.stop.condition
    lines = [_headline(results)]
    main = _main_metric(results, condition)
    differences = [_difference_text(*row) for row in results.differences(main)] if main else []
    if differences:
        lines += ["", f"{main} with the same seeds:", *(f"  {text}" for text in differences)]
    if condition:
        (_, share), *groups = _shares(results, condition)
        lines += ["", f"{condition}: {share}", *(f"  {name}: {share}" for name, share in groups)]
    rows = _percentile_rows(results)
    if rows:
        width = max(len(name) for name, *_ in rows)
        lines += [
            "",
            *(f"{name:{width}}{''.join(f'  {cell:>7}' for cell in cells)}" for name, *cells in (_HEADS, *rows)),
        ]
    if results.failures:
        lines += ["", f"{_count(len(results.failures), 'run')} ended with an error:"]
        errors = Counter(row["error"] for row in results.failures).most_common(5)
        lines += [f"  {error} ({_count(count, 'run')})" for error, count in errors]
    return "\n".join(lines)


def save_results(
    results: Results,
    folder: str | Path,
    condition: str = "",
    *,
    scene: Scene | None = None,
    compared: PairedDifference | None = None,
) -> dict[str, Path]:
    """Write `results.csv`, `page.html` and `pictures/*.png`; missing folders are made.

    Args:
        results: Of a sweep.
        folder: Where to.
        condition: What a success is; empty: that of the experiment's stop rule, if it has one.
        scene: The bare field, for heat maps of `landings`; None: that of the game.
        compared: Of two values of the first factor: what is said of their difference, as it was judged; the page is
            about these two then.

    Returns:
        The files by their names.

    Raises:
        OutputError: One cannot be written.
    """
    folder = Path(folder)
    condition = condition or results.experiment.stop.condition
    if scene is None and "landings" in results.columns:
        from simcore.show.scene import bare_scene

        try:
            scene = bare_scene(game_of(results.experiment.game))
        except SimcoreError as error:  # its package may have changed since the runs were played
            _log.warning("pictures without the field: %s", error)
    drawings = drawings_of(results, condition, scene) if compared is None else _of_each(results, condition, scene)
    written = [results.save_table(folder), folder / "page.html"]
    write_text("page", written[-1], _page(results, drawings, condition, folder, compared))
    for drawing in drawings:
        path = folder / "pictures" / drawing.file_name
        save_drawing(drawing.drawing, path, _WIDE if drawing.is_wide else _NARROW)
        written.append(path)
    return {path.name: path for path in written}


def _of_each(results: Results, condition: str, scene: Scene | None) -> list[ResultDrawing]:
    """The drawings of each of two values that are compared: runs of both together say nothing."""
    first, *rest = results.experiment.factors
    found = []
    for value in first.values:
        mine = [{k: v for k, v in row.items() if k != first.name} for row in results.rows if row[first.name] == value]
        one = Results(mine, replace(results.experiment, factors=tuple(rest)))
        found += [replace(drawing, title=f"{value}: {drawing.title}") for drawing in drawings_of(one, condition, scene)]
    return found


def _page(
    results: Results,
    drawings: Sequence[ResultDrawing],
    condition: str,
    folder: Path,
    compared: PairedDifference | None,
) -> str:
    figures = "\n".join(
        f'<figure class="{"side" if drawing.is_wide else "chart"}"><figcaption><strong>{escape(drawing.title)}</strong>'
        f" <span>{escape(drawing.note)}</span></figcaption>{drawing.drawing}</figure>"
        for drawing in drawings
    )
    main = _main_metric(results, condition)
    heads = ("run", "seed", *results.factors)
    known = [row for row in results.finished if main and row.get(main) is not None]
    lowest = sorted(known, key=lambda row: (row[main], row["run"]))[:_MOST_RUNS]
    again = f"To see one: simcore sweep --out {shlex.quote(str(folder))} --repeat RUN"
    tables = _mean_table(results, condition or main)
    tables += _table(f"Runs with the lowest {main}. {again}", (*heads, *_varied_metrics(results)[:6]), lowest)
    tables += _table(f"Runs that ended with an error. {again}", (*heads, "error"), results.failures[:_MOST_ERRORS])
    return _PAGE.format(
        title=escape(_title(results) if compared is None else " against ".join(_compared(results))),
        summary=escape(summary_text(results, condition) if compared is None else _comparison(results, compared)),
        figures=figures,
        tables=tables,
        style=page_style(),
    )


_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<title>{title}</title>
<style>
{style}.wide th, .wide td {{ white-space: nowrap; }}
.tables {{ grid-template-columns: minmax(0, 1fr); }}
</style>
</head>
<body>
<h1>{title}</h1>
<pre class="wide">{summary}</pre>
<div class="charts">
{figures}
</div>
<div class="tables">{tables}</div>
</body>
</html>
"""


def _compared(results: Results) -> list[str]:
    """The two values that are compared, the older one first."""
    return [str(value) for value in results.experiment.factors[0].values]


def _comparison(results: Results, difference: PairedDifference) -> str:
    """Of two values: their difference as it was judged, and medians of each."""
    lines, name, main = [_headline(results), f"difference: {difference}"], results.factors[0], _main_metric(results)
    for value in _compared(results) if main else ():
        own = [row[main] for row in results.finished if str(row[name]) == value and row.get(main) is not None]
        lines.append(f"median {main}, {value}: {number_text(float(np.median(own)))}" if own else f"{value}: no run")
    return "\n".join(lines)


# --- words --------------------------------------------------------------------------------------------------------


def _title(results: Results) -> str:
    experiment = results.experiment
    what = experiment.project or experiment.game or next(iter(installed_games()), "the newest game")
    sides = {side: "as varied" if side in results.factors else getattr(experiment, side) for side in ("red", "blue")}
    if any(sides.values()):
        return f"Sweep: {what}, matches, {', '.join(f'{side} {who}' for side, who in sides.items() if who)}"
    return f"Sweep: {what}, {f'auto {experiment.auto}' if experiment.auto else 'its first auto'}"


def _headline(results: Results) -> str:
    points, seeds = ({row[name] for row in results.rows} for name in ("point", "seed"))
    varied = f" at {_count(len(points), 'point')} of {', '.join(results.factors)}" if results.factors else ""
    failed = len(results.failures)
    errors = f"; {failed} ended with an error" if failed else ""
    return f"{_count(len(results.rows), 'run')}{varied}, {_count(len(seeds), 'seed')}{errors}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _difference_text(factor: str, first: float | str, value: float | str, difference: PairedDifference) -> str:
    return f"{factor} = {number_text(value)} against {number_text(first)}: {difference}"


def _main_metric(results: Results, condition: str = "") -> str:
    """The metric that is drawn over everything; empty: there is none.

    The first of the condition, else the score, if they differ between runs, else the first that does.
    """
    first, varied = [*(ColumnExpression(condition).names if condition else ()), "score"], _varied_metrics(results)
    wanted = [*(name for name in first if name in varied), *varied, *first]
    return next((name for name in wanted if name in results.metrics), "")


def _varied_metrics(results: Results) -> list[str]:
    """Metrics that are not the same in all runs; of several with equal values in each run the first."""
    found: dict[tuple[Any, ...], str] = {}
    for name in results.metrics:
        values = tuple(row.get(name) for row in results.finished)
        if len({*values} - {None}) > 1:
            found.setdefault(values, name)
    return list(found.values())


def _percentiles(values: FloatArray, at: Sequence[float]) -> list[float]:
    """Of those that are known; not a number where none is."""
    known = values[np.isfinite(values)]
    return np.percentile(known, at).tolist() if len(known) else [math.nan] * len(at)


def _shares(results: Results, condition: str) -> list[tuple[str, Share]]:
    """Of all runs, then of each value of the factors that have few."""
    shares = [("all", results.success(condition))]
    for factor in results.factors:
        if len(results.factor_values(factor)) in range(2, MOST_VALUES + 1):
            found = results.success_by(factor, condition)
            shares += [(f"{factor} = {number_text(value)}", share) for value, share in found.items()]
    return shares


def _percentile_rows(results: Results) -> list[list[str]]:
    kept = [name for name in (_main_metric(results), "score") if name in results.metrics]  # the same in all runs or not
    metrics = dict.fromkeys((*kept, *_varied_metrics(results)))
    return [[name, *map(number_text, _percentiles(results.values(name), PERCENTILES))] for name in metrics]


def _mean_table(results: Results, metric: str) -> str:
    """Means of a metric over the first two factors of which both have few values."""
    factors = [name for name in results.factors if 2 <= len(results.factor_values(name)) <= MOST_VALUES]
    if not metric or len(factors) < 2:
        return ""
    down, across = factors[:2]
    cells: dict[tuple[Any, Any], list[float]] = {}
    for row, value in zip(results.finished, results.values(metric).tolist(), strict=True):
        if math.isfinite(value):
            cells.setdefault((row[down], row[across]), []).append(value)
    names = {f"{across} = {number_text(value)}": value for value in results.factor_values(across)}
    rows = [
        {down: at, **{name: float(np.mean(cells[at, value])) for name, value in names.items() if (at, value) in cells}}
        for at in results.factor_values(down)
    ]
    return _table(f"Mean {metric}", (down, *names), rows)


def _table(title: str, names: Sequence[str], runs: Sequence[Row]) -> str:
    """A table of runs that can be folded; nothing without runs."""
    head = "".join(f"<th scope=col>{escape(name)}</th>" for name in names)
    body = ""
    for run in runs:
        first, *cells = ("" if run.get(name) is None else escape(number_text(run[name])) for name in names)
        body += f"<tr><th scope=row>{first}</th>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"
    table = f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'
    return f"<details open><summary>{escape(title)}</summary>{table}</details>" if runs else ""


# --- drawings -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ResultDrawing:
    """One drawing."""

    title: str
    drawing: str
    """SVG."""
    note: str = ""
    """What its marks mean."""
    is_wide: bool = False
    """Whether it takes a row of its own."""

    @property
    def file_name(self) -> str:
        """Of its picture.

        >>> ResultDrawing("score >= 30 over robot.mass", "").file_name
        'score_30_over_robot.mass.png'
        """
        return re.sub(r"[^\w.]+", "_", self.title.lower()).strip("_") + ".png"


def drawings_of(results: Results, condition: str = "", scene: Scene | None = None) -> list[ResultDrawing]:
    """All drawings, what matters most first.

    Args:
        results: Of a sweep.
        condition: What a success is; empty: nothing is.
        scene: The bare field, for heat maps; None: none.
    """
    return list(_drawings(results, condition, scene))


def _drawings(results: Results, condition: str, scene: Scene | None) -> Iterator[ResultDrawing]:
    main = _main_metric(results, condition)
    if condition:
        held = results.succeeded(condition)
        for factor in results.factors:
            points = [_share_point(at, held[rows], results, rows) for at, rows in _groups(results.rows, factor)]
            chart = response_chart(points, factor, "share of successes", is_share=True)
            yield ResultDrawing(f"{condition} over {factor}", chart, "whiskers: 95 % interval")
    if main:
        said = {row[0]: f"{_difference_text(*row)}; " for row in reversed(results.differences(main))}
        values = results.values(main)
        for factor in results.factors:
            points = [_median_point(at, values[rows]) for at, rows in _groups(results.finished, factor)]
            chart = response_chart(points, factor, main, _UNITS.get(main, ""))
            note = f"{said.get(factor, '')}median; whiskers: 90 % of the runs"
            yield ResultDrawing(f"{main} over {factor}", chart, note)
    for metric in _varied_metrics(results)[:_MOST_DISTRIBUTIONS]:
        name = _NAMES.get(metric, metric)
        chart = distribution_chart(results.values(metric), name, _UNITS.get(metric, ""))
        yield ResultDrawing(f"{name} of all runs", chart, "median solid; dashed: 5 and 95 %")
    if scene is not None:
        for name, places in landings_of(row.get("landings") for row in results.finished).items():
            if len(places):
                drawing = heat_map(scene, places, "hit" if name == "hits" else "miss")
                yield ResultDrawing(f"Where {name} came down", drawing, f"{len(places)}", is_wide=True)


def _groups(rows: Sequence[Row], factor: str) -> list[tuple[float | str, list[int]]]:
    """Values of a factor, or the middles of parts where there are many, with the numbers of the rows that have them."""
    column = [row[factor] for row in rows]
    known = list(dict.fromkeys(column))
    if any(isinstance(value, str) for value in known):
        return [(value, [n for n, own in enumerate(column) if own == value]) for value in known]
    if len(known) <= MOST_VALUES:
        return [(float(value), [n for n, own in enumerate(column) if own == value]) for value in sorted(known)]
    parts = np.array_split(np.argsort(column, kind="stable"), _PARTS)
    return [(float(np.median([column[n] for n in part])), part.tolist()) for part in parts]


def _share_point(at: float | str, held: Any, results: Results, rows: list[int]) -> ChartPoint:
    share = seed_share(held, [results.rows[n]["seed"] for n in rows])
    return ChartPoint(at=at, middle=share.value, low=share.lower, high=share.upper, text=str(share))


def _median_point(at: float | str, values: FloatArray) -> ChartPoint:
    low, middle, high = _percentiles(values, (5, 50, 95))
    text = f"median {number_text(middle)}, {number_text(low)} to {number_text(high)} in {len(values)} runs"
    return ChartPoint(at=at, middle=middle, low=low, high=high, text=text)
