"""Reports: self-contained HTML files with blocks of text, tables and charts.

A block is a JSON object. The functions of this module make and check blocks, and `simcore/show/player/report.js` shows
the blocks in order. Numbers that are not finite become null and are shown as an empty cell or a gap in a curve.
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

if TYPE_CHECKING:
    from simcore.show.solids import Solid

__all__ = ["chart", "headline", "paragraph", "report_page", "robot_model", "series", "share", "table"]

_SHAPES = ("line", "dots", "bars", "steps")
_Values = Sequence[float | None] | np.ndarray[Any, Any]


def report_page(title: str, blocks: Sequence[Mapping[str, object]], *, subtitle: str = "") -> str:
    """Return a self-contained HTML page that shows blocks in order.

    Args:
        title: Heading, and title of the browser tab.
        blocks: Blocks made by the functions of this module.
        subtitle: Text under the heading; line breaks are kept.
    """
    note = f'<p class="note">{escape(subtitle)}</p>\n' if subtitle else ""
    text = json.dumps(_plain(blocks), separators=(",", ":"), allow_nan=False)
    return page_frame(title, f"{note}<main></main>\n", {"report": text.encode()})


def headline(text: str, detail: str = "") -> dict[str, object]:
    """Return a block with a line in large type and details in small type below."""
    return {"kind": "headline", "text": text, "detail": detail}


def paragraph(text: str) -> dict[str, object]:
    """Return a block with a paragraph of text; line breaks are kept."""
    return {"kind": "paragraph", "text": text}


def table(columns: Sequence[str], rows: Sequence[Sequence[object]], caption: str = "") -> dict[str, object]:
    """Return a block with a table of texts and numbers; None is an empty cell.

    The page aligns columns of numbers to the right.

    Raises:
        ConfigError: If the length of a row differs from the number of columns.
    """
    for number, row in enumerate(rows):
        if len(row) != len(columns):
            raise ConfigError(f"table {caption!r}: row {number} has {len(row)} cells for {len(columns)} columns")
    return {"kind": "table", "columns": list(columns), "rows": [list(row) for row in rows], "caption": caption}


def series(
    name: str, x: _Values, y: _Values, *, low: _Values | None = None, high: _Values | None = None, kind: str = "line"
) -> dict[str, object]:  # fmt: skip
    """Return one series for `chart`.

    Args:
        name: Name in the legend; may be empty for the only series.
        x: x values in ascending order, shape (n,).
        y: y values, shape (n,); None and NaN are gaps.
        low: Lower ends of a band (for lines) or of whiskers (for dots and bars), shape (n,).
        high: Upper ends of the band or the whiskers, shape (n,).
        kind: `line`, `dots`, `bars` or `steps`.

    Raises:
        ConfigError: If the lengths differ, only one of `low` and `high` is given, or the kind does not exist.
    """
    parts = {"x": x, "y": y} | ({} if low is None else {"low": low}) | ({} if high is None else {"high": high})
    sizes = {key: len(part) for key, part in parts.items()}
    if len(set(sizes.values())) > 1:
        raise ConfigError(f"series {name!r}: x, y, low and high need equal lengths, got {sizes}")
    if (low is None) != (high is None):
        raise ConfigError(f"series {name!r}: low and high must be given together")
    if kind not in _SHAPES:
        raise ConfigError(f"series {name!r}: kind must be one of {', '.join(_SHAPES)}, got {kind!r}")
    return {"name": name, "kind": kind, **parts}


def chart(
    title: str, curves: Sequence[Mapping[str, object]], *, x_label: str = "", y_label: str = "",
    marks: Sequence[tuple[float, str]] = (), x_names: Sequence[str] | None = None, from_zero: bool = False,
) -> dict[str, object]:  # fmt: skip
    """Return a block with a chart of one or more `series`.

    Args:
        title: Title above the chart.
        curves: Series made by `series`.
        x_label: Quantity and unit of the x axis.
        y_label: Quantity and unit of the y axis.
        marks: x value and label of each vertical line.
        x_names: Labels for x = 0, 1, 2, ... on the x axis, instead of numbers.
        from_zero: Whether the y axis includes 0.
    """
    return {
        "kind": "chart", "title": title, "series": list(curves), "xLabel": x_label, "yLabel": y_label,
        "marks": [{"x": x, "label": label} for x, label in marks],
        "xNames": None if x_names is None else list(x_names), "fromZero": from_zero,
    }  # fmt: skip


def share(value: float, low: float, high: float, text: str) -> dict[str, object]:
    """Return a block with a bar for `value` (0 to 1), a confidence interval from `low` to `high`, and a text below."""
    return {"kind": "share", "value": value, "low": low, "high": high, "text": text}


def robot_model(title: str, bumpers: tuple[float, float], solids: Sequence[tuple[str, Solid]]) -> dict[str, object]:
    """Return a block with a three-dimensional drawing of a robot, labeled with the dimensions of the robot.

    Args:
        title: Title above the drawing.
        bumpers: Length and width over the bumpers [m].
        solids: Names and solids in the robot frame. Solids without a name are the body of the robot and determine the
            height in the drawing.
    """
    shapes = [
        {
            "name": name, "color": one.color, "opacity": one.opacity, "points": one.vertices.round(4).tolist(),
            "faces": one.faces.tolist(),
        }
        for name, one in solids
    ]  # fmt: skip
    return {"kind": "robot", "title": title, "bumpers": list(bumpers), "solids": shapes}


def _plain(value: object) -> object:
    """Convert a block to plain JSON types: arrays to lists, and numbers that are not finite to None."""
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
