"""What came of a sweep as one HTML file without network, and as text for a terminal."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simcore.match.registry import find_game
from simcore.show.page import page_style
from simcore.show.raster import save_drawing
from simcore.sweep.one_run import game_of
from simcore.sweep.result_drawings import (
    ResultDrawing,
    difference_text,
    drawings_of,
    effects_of,
    main_metric,
    varied_metrics,
)
from simcore.sweep.results import MOST_VALUES, Results
from simcore.sweep.sweep_charts import number_text
from simcore.sweep.sweep_statistics import PERCENTILES, PairedDifference, Share
from simcore.telemetry.sinks import write_text

if TYPE_CHECKING:
    from simcore.show.scene import Scene

__all__ = ["save_results", "summary_text", "write_results_page"]

_MOST_RUNS = 10
_MOST_ERRORS = 20
_NARROW, _WIDE = 720, 1200  # of pictures [px]
_HEADS = ("metric", *("median" if q == 50 else f"{q:g} %" for q in PERCENTILES))

Table = tuple[Sequence[str], list[list[str]]]


def summary_text(results: Results, condition: str = "") -> str:
    """What a terminal shows: counts, what factors change, shares of success, percentiles, what matters most.

    Args:
        results: Of a sweep.
        condition: What a success is; empty: that of the experiment's stop rule, if it has one.
    """
    condition = condition or results.experiment.stop.condition
    lines = [_headline(results)]
    main = main_metric(results, condition)
    differences = [difference_text(row) for row in results.differences(main)] if main else []
    if differences:
        lines += ["", f"{main} with the same seeds:", *(f"  {text}" for text in differences)]
    if condition:
        (_, share), *groups = _shares(results, condition)
        lines += ["", f"{condition}: {share}", *(f"  {name}: {share}" for name, share in groups)]
    heads, rows = _percentile_table(results)
    if rows:
        lines += ["", *_aligned([list(heads), *rows])]
    effects = _effect_table(results, main)
    if effects[1]:
        lines += ["", f"what moves {main}:", *_aligned([list(effects[0]), *effects[1]])]
    failures = results.failures
    if len(failures):
        lines += ["", f"{_count(len(failures), 'run')} ended with an error:"]
        lines += [
            f"  {said} ({_count(count, 'run')})" for said, count in failures["error"].value_counts().head(5).items()
        ]
    return "\n".join(lines)


def save_results(
    results: Results,
    folder: str | Path,
    condition: str = "",
    *,
    scene: Scene | None = None,
    compared: PairedDifference | None = None,
) -> dict[str, Path]:
    """Write `results.parquet`, `results.csv`, `page.html` and `pictures/*.png`; missing folders are made.

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
    if scene is None and "landings" in results.table.columns:
        from simcore.show.scene import bare_scene

        scene = bare_scene(game_of(results.experiment.game))
    drawings = drawings_of(results, condition, scene) if compared is None else _of_each(results, condition, scene)
    written = [*results.save_tables(folder), folder / "page.html"]
    write_results_page(written[-1], results, drawings, condition, compared)
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
        mine = results.table[results.table[first.name] == value].drop(columns=first.name)
        one = Results(mine, replace(results.experiment, factors=tuple(rest)))
        found += [replace(drawing, title=f"{value}: {drawing.title}") for drawing in drawings_of(one, condition, scene)]
    return found


def write_results_page(
    path: str | Path,
    results: Results,
    drawings: Sequence[ResultDrawing],
    condition: str = "",
    compared: PairedDifference | None = None,
) -> None:
    """Write the page; missing folders are made.

    Args:
        path: By custom a `.html` file.
        results: Of a sweep.
        drawings: On it.
        condition: What a success is; empty: nothing is.
        compared: As in `save_results`.

    Raises:
        OutputError: The file cannot be written.
    """
    path = Path(path)
    main = main_metric(results, condition)
    figures = "\n".join(
        f'<figure class="{"side" if drawing.is_wide else "chart"}"><figcaption><strong>{escape(drawing.title)}</strong>'
        f" <span>{escape(drawing.note)}</span></figcaption>{drawing.drawing}</figure>"
        for drawing in drawings
    )
    tables = "".join(
        _table_html(title, *table)
        for title, table in (
            (f"{main} with the same seeds", _difference_table(results, main, compared)),
            (f"Share of {condition}", _share_table(results, condition)),
            ("Percentiles of all runs", _percentile_table(results)),
            (f"What moves {main}", _effect_table(results, main)),
            (f"Runs with the lowest {main}. To see one: {_replay(path)}", _lowest_table(results, main)),
            (f"Runs that ended with an error. To see one: {_replay(path)}", _error_table(results)),
        )
        if table[1]
    )
    facts = "".join(
        f"<li><span>{escape(k)}</span><b>{escape(v)}</b></li>" for k, v in _facts(results, condition, compared)
    )
    text = _PAGE.format(
        title=escape(_title(results) if compared is None else " against ".join(_compared(results))),
        note=escape(_headline(results)),
        facts=facts,
        figures=figures,
        tables=tables,
        style=page_style(),
    )
    write_text("page", path, text)


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
<p class="note">{note}</p>
<ul class="facts">{facts}</ul>
<div class="charts">
{figures}
</div>
<div class="tables">{tables}</div>
</body>
</html>
"""


# --- words --------------------------------------------------------------------------------------------------------


def _title(results: Results) -> str:
    experiment = results.experiment
    what = experiment.project or experiment.game or find_game(None, say=str).name
    sides = {side: "as varied" if side in results.factors else getattr(experiment, side) for side in ("red", "blue")}
    if any(sides.values()):
        return f"Sweep: {what}, matches, {', '.join(f'{side} {who}' for side, who in sides.items() if who)}"
    return f"Sweep: {what}, {f'auto {experiment.auto}' if experiment.auto else 'its first auto'}"


def _headline(results: Results) -> str:
    table = results.table
    points, seeds = table["point"].nunique(), table["seed"].nunique()
    varied = f" at {_count(points, 'point')} of {', '.join(results.factors)}" if results.factors else ""
    failed = len(results.failures)
    errors = f"; {failed} ended with an error" if failed else ""
    return f"{_count(len(table), 'run')}{varied}, {_count(seeds, 'seed')}{errors}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _facts(results: Results, condition: str, compared: PairedDifference | None = None) -> Iterator[tuple[str, str]]:
    table = results.table
    yield "runs", str(len(table))
    if compared is not None:
        name, metric = results.experiment.factors[0].name, main_metric(results, condition)
        yield "difference", str(compared)
        for value in _compared(results) if metric else ():
            middle = results.whole[results.whole[name].astype(str) == value][metric].median()
            yield f"median {metric}, {value}", number_text(float(middle))
        return
    if condition:
        share = results.success(condition)
        yield condition, f"{100 * share.value:.0f} %"
        yield "95 % interval of it", f"{100 * share.lower:.0f} to {100 * share.upper:.0f} %"
    main = main_metric(results, condition)
    if main:
        low, middle, high = results.percentiles(main, (5, 50, 95)).iloc[0]
        yield f"median {main}", number_text(middle)
        yield f"{main} of 90 % of the runs", f"{number_text(low)} to {number_text(high)}"
    if len(results.failures):
        yield "errors", str(len(results.failures))
    if "cpu_seconds" in table:
        yield "processor time a run", f"{table['cpu_seconds'].median():.1f} s"


# --- tables -------------------------------------------------------------------------------------------------------


def _share_table(results: Results, condition: str) -> Table:
    heads = ("runs", "successes", "share", "95 % interval")
    rows = []
    if condition:
        rows = [
            [name, f"{share.k} of {share.n}", f"{100 * share.value:.0f} %",
             f"{100 * share.lower:.0f} to {100 * share.upper:.0f} %"]
            for name, share in _shares(results, condition)
        ]  # fmt: skip
    return heads, rows


def _compared(results: Results) -> list[str]:
    """The two values that are compared, the older one first."""
    return [str(value) for value in results.experiment.factors[0].values]


def _difference_table(results: Results, metric: str, compared: PairedDifference | None) -> Table:
    heads = ("factor", "from", "to", "difference")
    if compared is not None:  # as it was judged: an interval of its own would be another one
        return heads, [[results.experiment.factors[0].name, *_compared(results), str(compared)]]
    found = results.differences(metric) if metric else []
    return heads, [[name, number_text(first), number_text(value), str(by)] for name, first, value, by in found]


def _shares(results: Results, condition: str) -> list[tuple[str, Share]]:
    """Of all runs, then of each value of the factors that have few."""
    shares = [("all", results.success(condition))]
    for factor in results.factors:
        if results.table[factor].nunique() in range(2, MOST_VALUES + 1):
            found = results.success_by(factor, condition)
            shares += [(f"{factor} = {number_text(value)}", share) for value, share in found.items()]
    return shares


def _percentile_table(results: Results) -> Table:
    rows = []
    kept = [name for name in (main_metric(results), "score") if name in results.metrics]  # the same in all runs or not
    varied = [name for name in varied_metrics(results) if name not in kept]
    for metric in (*dict.fromkeys(kept), *varied):
        values = results.percentiles(metric).iloc[0]
        rows.append([metric, *(number_text(float(value)) for value in values)])
    return _HEADS, rows


def _effect_table(results: Results, metric: str) -> Table:
    effects = effects_of(results, metric) if metric and results.factors else ()
    heads: tuple[str, ...] = ("factor", effects[0].method if effects else "", "at lowest", "at highest")
    has_total = any(math.isfinite(effect.total) for effect in effects)
    rows = []
    for effect in effects:
        margin = f" ± {effect.margin:.2g}" if math.isfinite(effect.margin) else ""
        ends = [f"{number_text(effect.at_low)} ({number_text(effect.low)})"]
        ends.append(f"{number_text(effect.at_high)} ({number_text(effect.high)})")
        total = [number_text(effect.total)] if has_total else []
        rows.append([effect.factor, f"{number_text(effect.index)}{margin}", *total, *ends])
    return ((*heads[:2], "with others", *heads[2:]) if has_total else heads), rows


def _replay(path: str | Path) -> str:
    """The command that plays a run again, with its page."""
    return f"simcore sweep --out {shlex.quote(str(Path(path).parent))} --repeat RUN"


def _lowest_table(results: Results, metric: str) -> Table:
    if not metric:
        return (), []
    runs = results.whole.sort_values([metric, "run"]).head(_MOST_RUNS)
    heads = ("run", "seed", *results.factors, *varied_metrics(results)[:6])
    return heads, [[_cell(row[name]) for name in heads] for _, row in runs.iterrows()]


def _error_table(results: Results) -> Table:
    heads = ("run", "seed", *results.factors, "error")
    runs = results.failures.sort_values("run").head(_MOST_ERRORS)
    return heads, [[_cell(row[name]) for name in heads] for _, row in runs.iterrows()]


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else number_text(float(value))


def _table_html(title: str, heads: Sequence[str], rows: list[list[str]]) -> str:
    head = "".join(f"<th scope=col>{escape(name)}</th>" for name in heads)
    body = "".join(
        f"<tr><th scope=row>{escape(row[0])}</th>{''.join(f'<td>{escape(cell)}</td>' for cell in row[1:])}</tr>"
        for row in rows
    )
    return (
        f'<details open><summary>{escape(title)}</summary><div class="wide"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div></details>"
    )


def _aligned(rows: list[list[str]]) -> list[str]:
    """Columns under each other, the first to the left and the others to the right."""
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.rjust(width) if k else cell.ljust(width) for k, (cell, width) in
                  enumerate(zip(row, widths, strict=True))).rstrip()
        for row in rows
    ]  # fmt: skip
