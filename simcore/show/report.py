"""A report as one HTML file: blocks of text, tables and drawings, in the frame of a run's page and drawn by its script.

A block is a JSON object, made and checked by the functions below; `simcore/show/player/report.js` shows them in order.
Numbers that are not finite become null: an empty cell, a gap in a curve.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError
from simcore.show.page import page_frame
from simcore.show.palette import COLORS, color

if TYPE_CHECKING:
    from simcore.show.solids import Solid

__all__ = ["chart", "field_map", "headline", "heat", "paragraph", "report_page", "robot_views", "series", "table"]

_SHAPES = ("line", "dots", "bars", "steps")
_Values = Sequence[float | None] | np.ndarray[Any, Any]


def report_page(title: str, blocks: Sequence[Mapping[str, object]], *, subtitle: str = "") -> str:
    """Return the page that shows blocks in their order, which needs nothing but a browser.

    Args:
        title: Heading, and the title of the browser's tab.
        blocks: Made by the functions of this module.
        subtitle: Text under the heading; line breaks are kept.
    """
    note = f'<p class="note">{escape(subtitle)}</p>\n' if subtitle else ""
    text = json.dumps(_plain(blocks), separators=(",", ":"), allow_nan=False)
    return page_frame(title, f"{note}<main></main>\n", {"report": text.encode()})


def headline(text: str, detail: str = "") -> dict[str, object]:
    """Make a line in large letters, with details in small ones below."""
    return {"kind": "headline", "text": text, "detail": detail}


def paragraph(text: str) -> dict[str, object]:
    """Make a paragraph; line breaks are kept."""
    return {"kind": "paragraph", "text": text}


def table(columns: Sequence[str], rows: Sequence[Sequence[object]], caption: str = "") -> dict[str, object]:
    """Make a table of texts, numbers and None; columns of numbers stand to the right.

    Raises:
        ConfigError: A row has another length than the head.
    """
    for number, row in enumerate(rows):
        if len(row) != len(columns):
            raise ConfigError(f"table {caption!r}: row {number} has {len(row)} cells for {len(columns)} columns")
    return {"kind": "table", "columns": list(columns), "rows": [list(row) for row in rows], "caption": caption}


def series(
    name: str, x: _Values, y: _Values, *, low: _Values | None = None, high: _Values | None = None,
    kind: str = "line", ink: str = "", dashes: str | None = None,
) -> dict[str, object]:  # fmt: skip
    """Make one series of a chart.

    Args:
        name: In the legend; empty for the only one.
        x: Positions, rising, shape (n,).
        y: Values, shape (n,); None and NaN are gaps.
        low: Lower ends of a band (of lines) or of whiskers (of dots and bars), shape (n,).
        high: Upper ends, shape (n,).
        kind: `line`, `dots`, `bars` or `steps`.
        ink: Name of a color of the palette; empty: the chart's next one.
        dashes: An SVG dash pattern; None: the chart's next one.

    Raises:
        ConfigError: Lengths differ, or there is no such kind or color.
    """
    parts = {"x": x, "y": y} | ({} if low is None else {"low": low}) | ({} if high is None else {"high": high})
    sizes = {key: len(part) for key, part in parts.items()}
    if len(set(sizes.values())) > 1:
        raise ConfigError(f"series {name!r}: x, y, low and high need equal lengths, got {sizes}")
    if (low is None) != (high is None):
        raise ConfigError(f"series {name!r}: low and high come together")
    if kind not in _SHAPES:
        raise ConfigError(f"series {name!r}: kind must be one of {', '.join(_SHAPES)}, got {kind!r}")
    look = {"color": _ink(ink)} if ink else {}
    return {"name": name, "kind": kind, **parts, **look, **({} if dashes is None else {"dashes": dashes})}


def chart(
    title: str, curves: Sequence[Mapping[str, object]], *, x_label: str = "", y_label: str = "",
    marks: Sequence[tuple[float, str]] = (), levels: Sequence[tuple[float, str]] = (),
    x_names: Sequence[str] | None = None, from_zero: bool = False,
) -> dict[str, object]:  # fmt: skip
    """Make a chart of several `series`.

    Args:
        title: Above it.
        curves: Made by `series`.
        x_label: Quantity and unit of the x axis.
        y_label: Quantity and unit of the y axis.
        marks: Vertical lines: x and label.
        levels: Horizontal lines: y and label.
        x_names: Names in place of the numbers 0, 1, 2, ... on the x axis.
        from_zero: Whether the y axis includes 0.
    """
    return {
        "kind": "chart", "title": title, "series": list(curves), "xLabel": x_label, "yLabel": y_label,
        "marks": [{"x": x, "label": label} for x, label in marks],
        "levels": [{"y": y, "label": label} for y, label in levels],
        "xNames": None if x_names is None else list(x_names), "fromZero": from_zero,
    }  # fmt: skip


def heat(
    title: str, x: Sequence[float | str], y: Sequence[float | str], values: Sequence[_Values], *, x_label: str = "",
    y_label: str = "", unit: str = "", marks: Sequence[tuple[float, float, str]] = (), has_scale: bool = True,
) -> dict[str, object]:  # fmt: skip
    """Make a grid of colored cells.

    Args:
        title: Above it.
        x: Middles of the columns, rising, or their names.
        y: Middles of the rows, rising, or their names.
        values: One row each of `y`, shape (len(y), len(x)); None and NaN stay empty.
        x_label: Quantity and unit of the x axis.
        y_label: Quantity and unit of the y axis.
        unit: Unit of the values.
        marks: Crosses: x, y and label.
        has_scale: Whether a bar of colors tells values.

    Raises:
        ConfigError: The grid is empty or has another shape than its axes.
    """
    sizes = {len(row) for row in values}
    if not len(x) or len(values) != len(y) or sizes != {len(x)}:
        raise ConfigError(f"heat map {title!r}: {len(y)} rows of {len(x)} cells wanted, got {len(values)} of {sizes}")
    return {
        "kind": "heat", "title": title, **_axis("x", x), **_axis("y", y), "values": list(values), "xLabel": x_label,
        "yLabel": y_label, "unit": unit, "scale": has_scale,
        "marks": [{"x": at, "y": up, "label": label} for at, up, label in marks],
    }  # fmt: skip


def field_map(
    title: str, size: tuple[float, float], outlines: Sequence[tuple[str, Sequence[Sequence[float]]]],
    points: Sequence[Mapping[str, object]], *, unit: str = "", point_size: float | None = None,
) -> dict[str, object]:  # fmt: skip
    """Make a map of the field from above, with points on it.

    Args:
        title: Above it.
        size: Length and width of the field [m].
        outlines: A color and the corners (x, y) [m] of each element.
        points: Each with `x` and `y` [m], and any of `value`, `label` and `ink` (a color of the palette).
        unit: Unit of the values.
        point_size: Radius of a point [m]; None: by their number.

    Raises:
        ConfigError: A point has no place, or a color that the palette does not have.
    """
    dots = []
    for point in points:
        missing = {"x", "y"} - point.keys()
        if missing:
            raise ConfigError(f"map {title!r}: a point has no {' and no '.join(sorted(missing))}: {dict(point)}")
        dot = {key: value for key, value in point.items() if key != "ink"}
        dots.append(dot | ({"color": _ink(str(point["ink"]))} if point.get("ink") else {}))
    return {
        "kind": "field_map", "title": title, "size": list(size), "unit": unit, "pointSize": point_size,
        "outlines": [[paint, [list(corner) for corner in corners]] for paint, corners in outlines], "points": dots,
    }  # fmt: skip


def robot_views(title: str, solids: Sequence[tuple[str, Solid]]) -> dict[str, object]:
    """Make a drawing of a robot from above and from its right side, to scale, of named solids in the robot frame."""
    shapes = [
        {
            "name": name, "color": one.color, "opacity": one.opacity, "points": one.vertices.round(4).tolist(),
            "faces": one.faces.tolist(),
        }
        for name, one in solids
    ]  # fmt: skip
    return {"kind": "robot", "title": title, "solids": shapes}


def _axis(name: str, middles: Sequence[float | str]) -> dict[str, object]:
    if any(isinstance(one, str) for one in middles):
        return {name: list(range(len(middles))), f"{name}Names": [str(one) for one in middles]}
    return {name: list(middles)}


def _ink(name: str) -> str:
    if name not in COLORS:
        raise ConfigError(f"no color named {name!r}. Known: {', '.join(COLORS)}")
    return color(name)


def _plain(value: object) -> object:
    """Return what JSON can say of a block: arrays as lists, numbers that are not finite as None."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(part) for part in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    assert value is None or isinstance(value, str | int), f"a block holds a {type(value).__name__}"
    return value
