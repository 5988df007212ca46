"""Drawings of many runs: distributions, values over a factor, where shots came down."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from simcore.show.field_drawing import FieldDrawing
from simcore.show.palette import color
from simcore.show.run_track import RunTrack
from simcore.show.scene import Scene
from simcore.show.svg import Axes, document, element, line, polyline, words
from simcore.telemetry.recording import Recording
from simcore.typing import FloatArray

__all__ = [
    "ChartPoint", "distribution_chart", "heat_map", "landings_of", "number_text", "response_chart",
]  # fmt: skip

_WIDTH, _LEFT, _RIGHT = 400.0, 52.0, 388.0
_TOP, _BOTTOM, _HEIGHT = 10.0, 180.0, 222.0
_LETTERS = 12.0
_BINS = 24
_CELL = 0.25  # [m], of a heat map


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartPoint:
    """A value with what it may vary by, at one value of a factor."""

    at: float | str
    """Value of the factor."""
    middle: float
    low: float
    """Lower end of the whisker."""
    high: float
    """Upper end."""
    text: str = ""
    """Said where a pointer rests on it."""


def number_text(value: float | str) -> str:
    """A number with as many digits as a reader wants; words stay as they are.

    >>> [number_text(value) for value in (0.30000000000000004, 32, 1234.567, -0.0, "left")]
    ['0.3', '32', '1235', '0', 'left']
    """
    if isinstance(value, str):
        return value
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value + 0.0:.3g}"


def distribution_chart(values: FloatArray, name: str, unit: str = "") -> str:
    """How often each value came: bars, the median solid, the 5th and 95th percentile dashed.

    Whole numbers have bars of whole numbers.

    Args:
        values: Of the runs; those that are not finite are left out. Shape (n,).
        name: Of the metric.
        unit: Of it.
    """
    values = values[np.isfinite(values)]
    if not len(values):
        return document((0, 0, _WIDTH, _HEIGHT), words(_WIDTH / 2, _HEIGHT / 2, "no run has it", 14, anchor="middle"))
    edges = _bin_edges(values)
    counts, _ = np.histogram(values, edges)
    frame = _axes(float(edges[0]), float(edges[-1]), 0.0, 1.08 * float(counts.max()), zero_based=True)
    parts = [frame.grid(_axis(name, unit), "runs", size=_LETTERS)]
    for start, end, count in zip(edges[:-1].tolist(), edges[1:].tolist(), counts.tolist(), strict=True):
        if count:
            left, top = frame.x(start), frame.y(count)
            tip = element("title", f"{number_text(start)} to {number_text(end)}: {count} runs")
            look = {"fill": color("path"), "fill_opacity": 0.45, "stroke": color("path")}
            parts.append(
                element("rect", tip, x=left, y=top, width=max(1.0, frame.x(end) - left), height=_BOTTOM - top, **look)
            )
    marks = dict(zip(("5 %", "median", "95 %"), np.percentile(values, (5, 50, 95)).tolist(), strict=True))
    for label, value in marks.items():
        dashes = None if label == "median" else "4 3"
        at = frame.x(value)
        look = {"stroke": color("ink"), "stroke_dasharray": dashes, "stroke_width": 1.6}
        tip = element("title", f"{label} {number_text(value)}")
        parts.append(element("g", tip, line(at, _TOP, at, _BOTTOM, **look)))
    return _document(parts, f"distribution of {name}")


def response_chart(
    points: Sequence[ChartPoint], factor: str, name: str, unit: str = "", *, is_share: bool = False
) -> str:
    """A value over a factor, each with its whisker; joined by a line where the factor is a number.

    Args:
        points: In order of the factor.
        factor: Its name.
        name: Of the metric.
        unit: Of it.
        is_share: Whether the axis is that of a share, 0 to 1.
    """
    known = [point for point in points if math.isfinite(point.middle)]
    low, high = (0.0, 1.0) if is_share else _span([p.low for p in known] + [p.high for p in known])
    numbers = [point.at for point in points if not isinstance(point.at, str)]
    is_numeric = len(numbers) == len(points)
    if is_numeric:
        left, right = _span(numbers, air=0.05)
        frame = _axes(left, right, low, high, zero_based=is_share)
        marks = {number_text(value): value for value in numbers} if len(numbers) <= 6 else None
    else:
        frame = _axes(-0.5, len(points) - 0.5, low, high, zero_based=is_share)
        marks = {_short(number_text(point.at)): float(row) for row, point in enumerate(points)}
    parts = [frame.grid(factor, _axis(name, unit), size=_LETTERS, marks=marks)]
    places = []
    for row, point in enumerate(points):
        if not math.isfinite(point.middle):
            continue
        x = frame.x(float(point.at) if is_numeric else float(row))
        y, top, bottom = frame.y(point.middle), frame.y(point.high), frame.y(point.low)
        places.append((x, y))
        look = {"stroke": color("path"), "stroke_width": 1.6}
        whisker = line(x, top, x, bottom, **look) + line(x - 4, top, x + 4, top, **look)
        whisker += line(x - 4, bottom, x + 4, bottom, **look)
        tip = element("title", point.text or number_text(point.middle))
        dot = element("circle", cx=x, cy=y, r=4.5, fill=color("path"), stroke=color("paper"))
        parts.append(element("g", tip, whisker, dot))
    if is_numeric:
        parts.insert(1, polyline(places, stroke=color("path"), stroke_width=1.6, opacity=0.6))
    return _document(parts, f"{name} over {factor}")


# --- the field --------------------------------------------------------------------------------------------------------


def landings_of(texts: Iterable[object]) -> Mapping[str, FloatArray]:
    """Places of hits and misses from the metric `landings` of runs.

    >>> {name: rows.tolist() for name, rows in landings_of(["[[4.6, 4.0, 1.8, 1], [3.0, 4.0, 0.1, 0]]", None]).items()}
    {'hits': [[4.6, 4.0]], 'misses': [[3.0, 4.0]]}

    Args:
        texts: Of each run a JSON list of `x, y, z, scored`; what is no text is a run without.

    Returns:
        `hits` and `misses`: x, y in the field frame [m], shape (n, 2).
    """
    rows = [row for text in texts if isinstance(text, str) for row in json.loads(text)]
    table = np.array(rows, dtype=float).reshape(len(rows), 4 if not rows else len(rows[0]))
    has_scored = table[:, -1] > 0.5
    return {"hits": table[has_scored, -4:-2], "misses": table[~has_scored, -4:-2]}


def heat_map(scene: Scene, places: FloatArray, ink: str) -> str:
    """The field with cells of 25 cm, the denser the more came down there.

    Args:
        scene: The bare field.
        places: x, y in the field frame [m], shape (n, 2); those beside the field are counted in its outermost cells.
        ink: Name of a color.
    """
    field = FieldDrawing(RunTrack(Recording(), scene), ())
    return field.drawing(field.ground(), field.heat(places, ink, cell=_CELL))


# --- axes ---------------------------------------------------------------------------------------------------------


def _axes(left: float, right: float, low: float, high: float, *, zero_based: bool = False) -> Axes:
    """From the left to the right value, with air around the lowest and highest one if the scale has no zero."""
    air = 0.0 if zero_based else 0.06 * (high - low)
    box = (_LEFT, _TOP, _RIGHT - _LEFT, _BOTTOM - _TOP)
    return Axes(box, (left, low - air), (right, high + air))


def _document(parts: Sequence[str], label: str) -> str:
    return document((0, 0, _WIDTH, _HEIGHT), *parts, role="img", aria_label=label)


def _axis(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _span(values: Sequence[float], air: float = 0.0) -> tuple[float, float]:
    """Lowest and highest, with air around them; never empty."""
    found = [value for value in values if math.isfinite(value)]
    low, high = (min(found), max(found)) if found else (0.0, 1.0)
    width = (high - low) or max(1.0, 0.1 * abs(low))
    middle = 0.5 * (low + high)
    half = 0.5 * width * (1.0 + 2.0 * air)
    return middle - half, middle + half


def _bin_edges(values: FloatArray) -> FloatArray:
    """Of bars: whole numbers in the middle of theirs, else some 24 equal ones."""
    low, high = float(values.min()), float(values.max())
    if np.array_equal(values, np.round(values)):
        step = max(1, math.ceil((high - low + 1) / _BINS))
        edges: FloatArray = np.arange(low - 0.5, high + step + 0.5, step)
        return edges if len(edges) > 1 else np.array([low - 0.5, low + 0.5])
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        return np.array([low - 0.5, low + 0.5])
    return np.linspace(low, high, min(_BINS, 1 + round(math.sqrt(len(values)) * 1.5)) + 1)


def _short(text: str) -> str:
    return text if len(text) <= 14 else f"{text[:12]}…"
