"""Which drawings show what came of a sweep: chosen by what was varied and measured, named for files and titles."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError
from simcore.sweep.column_expressions import names_in
from simcore.sweep.landing_map import heat_map, landings_of
from simcore.sweep.results import MOST_VALUES, Results
from simcore.sweep.sensitivity import FactorEffect
from simcore.sweep.sweep_charts import (
    ChartPoint,
    distribution_chart,
    number_text,
    response_chart,
    response_map,
    tornado_chart,
)
from simcore.sweep.sweep_statistics import PairedDifference, seed_share

if TYPE_CHECKING:
    import pandas as pd

    from simcore.show.scene import Scene

__all__ = ["ResultDrawing", "difference_text", "drawings_of", "effects_of", "main_metric", "varied_metrics"]

_UNITS = {"score": "points", "distance_m": "m", "min_battery_v": "V", "seconds": "s", "last_shot_s": "s"}
_NAMES = {
    "distance_m": "way driven", "min_battery_v": "lowest battery voltage", "seconds": "duration",
    "taken_in": "taken in", "last_shot_s": "time of the last shot", "hit_share": "share of hits",
}  # fmt: skip
"""What a reader calls metrics whose names are those of columns."""
_MOST_DISTRIBUTIONS = 6
_PARTS = 8


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

        >>> ResultDrawing("What moves score >= 30", "").file_name
        'what_moves_score_30.png'
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
    main = main_metric(results, condition)
    if condition:
        for factor in results.factors:
            points = _share_points(results, factor, condition)
            chart = response_chart(points, factor, "share of successes", is_share=True)
            yield ResultDrawing(f"{condition} over {factor}", chart, "whiskers: 95 % interval")
    if main:
        said = {row[0]: f"{difference_text(row)}; " for row in reversed(results.differences(main))}
        for factor in results.factors:
            chart = response_chart(_median_points(results, factor, main), factor, main, _UNITS.get(main, ""))
            note = f"{said.get(factor, '')}median; whiskers: 90 % of the runs"
            yield ResultDrawing(f"{main} over {factor}", chart, note)
        effects = effects_of(results, main)
        if len(effects) > 1:
            chart = tornado_chart(effects, main, _UNITS.get(main, ""))
            note = "mean where a factor is lowest (outlined) and highest (filled)"
            yield ResultDrawing(f"What moves {main}", chart, note)
            ground = _map_of(results, condition or main, effects)
            if ground is not None:
                yield ground
    for metric in varied_metrics(results)[:_MOST_DISTRIBUTIONS]:
        values = results.whole[metric].to_numpy(float)
        name = _NAMES.get(metric, metric)
        chart = distribution_chart(values, name, _UNITS.get(metric, ""))
        yield ResultDrawing(f"{name} of all runs", chart, "median solid; dashed: 5 and 95 %")
    if scene is not None and "landings" in results.table.columns:
        for name, places in landings_of(results.whole["landings"]).items():
            if len(places):
                ink = "hit" if name == "hits" else "miss"
                yield ResultDrawing(
                    f"Where {name} came down", heat_map(scene, places, ink), f"{len(places)}", is_wide=True
                )


def main_metric(results: Results, condition: str = "") -> str:
    """The metric that is drawn over everything; empty: there is none.

    The first of the condition, else the score, if they differ between runs, else the first that does.
    """
    first, varied = [*(names_in(condition) if condition else ()), "score"], varied_metrics(results)
    wanted = [*(name for name in first if name in varied), *varied, *first]
    return next((name for name in wanted if name in results.metrics), "")


def difference_text(row: tuple[str, Any, Any, PairedDifference]) -> str:
    """A row of `Results.differences` as a sentence."""
    factor, first, value, difference = row
    return f"{factor} = {number_text(value)} against {number_text(first)}: {difference}"


def varied_metrics(results: Results) -> list[str]:
    """Metrics that are not the same in all runs; of several with equal values in each run the first."""
    found: dict[tuple[float, ...], str] = {}
    for name in results.metrics:
        values = results.whole[name]
        if values.nunique() > 1:
            found.setdefault(tuple(values.to_numpy(float).tolist()), name)
    return list(found.values())


def effects_of(results: Results, metric: str) -> tuple[FactorEffect, ...]:
    """Sensitivities; empty where the design cannot tell them."""
    try:
        return results.sensitivity(metric)
    except ConfigError:
        return ()


def _groups(column: pd.Series) -> pd.Series:
    """The value of a factor that each run stands for: its own, or the middle of a part where there are many."""
    import pandas as pd

    if column.nunique() <= MOST_VALUES or column.dtype.kind not in "fiu":
        return column
    part = pd.qcut(column, _PARTS, labels=False, duplicates="drop")
    return column.groupby(part).transform("median")


def _share_points(results: Results, factor: str, condition: str) -> list[ChartPoint]:
    points = []
    for value, held in results.succeeded(condition).groupby(_groups(results.table[factor]), sort=True):
        share = seed_share(held, results.table.loc[held.index, "seed"])
        points.append(
            ChartPoint(at=_plain(value), middle=share.value, low=share.lower, high=share.upper, text=str(share))
        )
    return points


def _median_points(results: Results, factor: str, metric: str) -> list[ChartPoint]:
    runs = results.whole
    points = []
    for value, rows in runs[metric].astype(float).groupby(_groups(runs[factor]), sort=True):
        known = rows.dropna()
        low, middle, high = np.percentile(known, (5, 50, 95)).tolist() if len(known) else (math.nan,) * 3
        text = f"median {number_text(middle)}, {number_text(low)} to {number_text(high)} in {len(known)} runs"
        points.append(ChartPoint(at=_plain(value), middle=middle, low=low, high=high, text=text))
    return points


def _map_of(results: Results, metric: str, effects: tuple[FactorEffect, ...]) -> ResultDrawing | None:
    """Of the two factors that matter most, if both have few values."""
    first, second = (effect.factor for effect in effects[:2])
    points = results.by_point(metric)
    if max(points[first].nunique(), points[second].nunique()) > MOST_VALUES:
        return None
    grid = points.pivot_table(index=second, columns=first, values="value", aggfunc="mean")
    if grid.size < 4:
        return None
    columns, rows = [_plain(value) for value in grid.columns], [_plain(value) for value in grid.index]
    ground = response_map(columns, rows, grid.to_numpy(float), first, second)
    return ResultDrawing(f"{metric} over {first} and {second}", ground, "mean of all seeds")


def _plain(value: Any) -> float | str:
    return value if isinstance(value, str) else float(value)
