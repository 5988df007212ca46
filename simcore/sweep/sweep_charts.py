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
from simcore.show.svg import document, element, line, polyline, ticks, words
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
    frame = _Frame(float(edges[0]), float(edges[-1]), 0.0, 1.08 * float(counts.max()), zero_based=True)
    parts = [frame.grid(_axis(name, unit), "runs")]
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
        frame = _Frame(left, right, low, high, zero_based=is_share)
        marks = {number_text(value): value for value in numbers} if len(numbers) <= 6 else None
    else:
        frame = _Frame(-0.5, len(points) - 0.5, low, high, zero_based=is_share)
        marks = {_short(number_text(point.at)): float(row) for row, point in enumerate(points)}
    parts = [frame.grid(factor, _axis(name, unit), marks=marks)]
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
    length, width = scene.field_size
    across, up = math.ceil(length / _CELL), math.ceil(width / _CELL)
    inside = np.clip(places, 0.0, (length - 1e-6, width - 1e-6))
    counts, _, _ = np.histogram2d(
        inside[:, 0], inside[:, 1], bins=(across, up), range=((0.0, across * _CELL), (0.0, up * _CELL))
    )
    most = float(counts.max()) or 1.0
    size = 100.0 * _CELL
    cells = []
    for i, k in zip(*(rows.tolist() for rows in np.nonzero(counts)), strict=True):
        ((x, y),) = field.points(np.array([[i * _CELL, (k + 1) * _CELL]])).tolist()
        tip = element("title", f"{counts[i, k]:.0f} at x {(i + 0.5) * _CELL:g} m, y {(k + 0.5) * _CELL:g} m")
        strength = 0.25 + 0.7 * math.sqrt(counts[i, k] / most)
        cells.append(element("rect", tip, x=x, y=y, width=size, height=size, opacity=strength))
    return field.drawing(field.ground(), element("g", *cells, fill=color(ink)))


# --- axes ---------------------------------------------------------------------------------------------------------


class _Frame:
    """Axes of a chart, from values to places of the drawing."""

    def __init__(self, left: float, right: float, low: float, high: float, *, zero_based: bool = False) -> None:
        self.left, self.right = left, right
        air = 0.0 if zero_based else 0.06 * (high - low)
        self.low, self.high = low - air, high + air

    def x(self, value: float) -> float:
        """To the right."""
        return _LEFT + (value - self.left) / ((self.right - self.left) or 1.0) * (_RIGHT - _LEFT)

    def y(self, value: float) -> float:
        """Down."""
        return _TOP + (self.high - value) / ((self.high - self.low) or 1.0) * (_BOTTOM - _TOP)

    def grid(self, below: str, aside: str, *, marks: dict[str, float] | None = None) -> str:
        """Levels, scale and names of the axes; `marks` in place of round numbers on the lower one."""
        parts = []
        for level in ticks(self.low, self.high, 5):
            parts.append(line(_LEFT, self.y(level), _RIGHT, self.y(level), stroke=color("grid")))
            parts.append(words(_LEFT - 6, self.y(level) + 4, number_text(level), _LETTERS, anchor="end"))
        along = marks or {number_text(value): value for value in ticks(self.left, self.right, 7)}
        for text, value in along.items():
            parts.append(words(self.x(value), _BOTTOM + 16, text, _LETTERS, anchor="middle"))
        parts.append(line(_LEFT, _BOTTOM, _RIGHT, _BOTTOM, stroke=color("control")))
        parts.append(words((_LEFT + _RIGHT) / 2, _BOTTOM + 34, below, _LETTERS, anchor="middle"))
        turned = f"translate(12 {(_TOP + _BOTTOM) / 2:g}) rotate(-90)"
        parts.append(words(0.0, 0.0, aside, _LETTERS, anchor="middle", transform=turned))
        return element("g", *parts)


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
