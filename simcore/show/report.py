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

if TYPE_CHECKING:
    from simcore.show.solids import Solid

__all__ = ["chart", "headline", "paragraph", "report_page", "robot_model", "series", "share", "table"]

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
    name: str, x: _Values, y: _Values, *, low: _Values | None = None, high: _Values | None = None, kind: str = "line"
) -> dict[str, object]:  # fmt: skip
    """Make one series of a chart.

    Args:
        name: Name in the legend; empty for the only one.
        x: Positions, rising, shape (n,).
        y: Values, shape (n,); None and NaN are gaps.
        low: Lower ends of a band (of lines) or of whiskers (of dots and bars), shape (n,).
        high: Upper ends, shape (n,).
        kind: `line`, `dots`, `bars` or `steps`.

    Raises:
        ConfigError: Lengths differ, or there is no such kind.
    """
    parts = {"x": x, "y": y} | ({} if low is None else {"low": low}) | ({} if high is None else {"high": high})
    sizes = {key: len(part) for key, part in parts.items()}
    if len(set(sizes.values())) > 1:
        raise ConfigError(f"series {name!r}: x, y, low and high need equal lengths, got {sizes}")
    if (low is None) != (high is None):
        raise ConfigError(f"series {name!r}: low and high come together")
    if kind not in _SHAPES:
        raise ConfigError(f"series {name!r}: kind must be one of {', '.join(_SHAPES)}, got {kind!r}")
    return {"name": name, "kind": kind, **parts}


def chart(
    title: str, curves: Sequence[Mapping[str, object]], *, x_label: str = "", y_label: str = "",
    marks: Sequence[tuple[float, str]] = (), x_names: Sequence[str] | None = None, from_zero: bool = False,
) -> dict[str, object]:  # fmt: skip
    """Make a chart of several `series`.

    Args:
        title: Above it.
        curves: Made by `series`.
        x_label: Quantity and unit of the x axis.
        y_label: Quantity and unit of the y axis.
        marks: Vertical lines: x and label.
        x_names: Names in place of the numbers 0, 1, 2, ... on the x axis.
        from_zero: Whether the y axis includes 0.
    """
    return {
        "kind": "chart", "title": title, "series": list(curves), "xLabel": x_label, "yLabel": y_label,
        "marks": [{"x": x, "label": label} for x, label in marks],
        "xNames": None if x_names is None else list(x_names), "fromZero": from_zero,
    }  # fmt: skip


def share(value: float, low: float, high: float, text: str) -> dict[str, object]:
    """Make a bar of a share of 1 with the interval around it, and a text below."""
    return {"kind": "share", "value": value, "low": low, "high": high, "text": text}


def robot_model(title: str, bumpers: tuple[float, float], solids: Sequence[tuple[str, Solid]]) -> dict[str, object]:
    """Make a robot in three dimensions with its measures.

    Args:
        title: Above it.
        bumpers: Length and width over the bumpers [m].
        solids: Names and solids in the robot frame; those without a name are the robot itself, whose height is told.
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
