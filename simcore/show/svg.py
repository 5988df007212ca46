"""Elements of SVG as text: the one language that page, pictures and animations are drawn in."""

from __future__ import annotations

import math
from collections.abc import Iterable
from html import escape

from simcore.show.palette import color
from simcore.typing import FloatArray

__all__ = ["document", "element", "line", "nested", "points", "polygon", "polyline", "ticks", "words"]


def element(name: str, *inside: str, **attributes: object) -> str:
    """One element; `_` in an attribute's name becomes `-`, numbers are rounded to hundredths, None is left out.

    >>> element("circle", r=2.50001, stroke_width=1)
    '<circle r="2.5" stroke-width="1"/>'
    """
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{_value(value)}"'
        for key, value in attributes.items()
        if value is not None
    )
    body = "".join(inside)
    return f"<{name}{written}>{body}</{name}>" if body else f"<{name}{written}/>"


def _value(value: object) -> str:
    if isinstance(value, float):
        return f"{round(value, 2):g}" if abs(value) < 1e5 else f"{value:.0f}"
    return escape(str(value))


def points(rows: Iterable[Iterable[float]] | FloatArray) -> str:
    """Corners as `x,y x,y`.

    >>> points([(1.0, 2.25), (3.0, 4.0)])
    '1,2.2 3,4'
    """
    return " ".join(f"{round(x, 1):g},{round(y, 1):g}" for x, y in rows)


def polygon(rows: Iterable[Iterable[float]] | FloatArray, *inside: str, **attributes: object) -> str:
    """A closed area."""
    return element("polygon", *inside, points=points(rows), **attributes)


def polyline(rows: Iterable[Iterable[float]] | FloatArray, **attributes: object) -> str:
    """A line through points, not filled."""
    return element("polyline", points=points(rows), fill="none", **attributes)


def line(x1: float, y1: float, x2: float, y2: float, **attributes: object) -> str:
    """A straight line."""
    return element("line", x1=x1, y1=y1, x2=x2, y2=y2, **attributes)


def words(
    x: float,
    y: float,
    text: str,
    size: float,
    *,
    ink: str = "",
    anchor: str = "start",
    bold: bool = False,
    **attributes: object,
) -> str:
    """A line of text, its base line at y; muted if no ink is named."""
    weight = {"font_weight": "bold"} if bold else {}
    return element(
        "text", escape(text), x=x, y=y, fill=ink or color("muted"), **weight, font_size=size, text_anchor=anchor,
        **attributes,
    )  # fmt: skip


def document(box: tuple[float, float, float, float], *inside: str, **attributes: object) -> str:
    """A whole drawing: left, top, width and height of what is seen, and its elements."""
    view = " ".join(f"{round(number, 1):g}" for number in box)
    return element(
        "svg", *inside, xmlns="http://www.w3.org/2000/svg", viewBox=view,
        font_family="system-ui, 'Segoe UI', Roboto, Arial, sans-serif", **attributes,
    )  # fmt: skip


def nested(drawing: str, x: float, y: float, width: float, height: float) -> str:
    """A drawing within another one, at a place and in a size."""
    return drawing.replace("<svg ", f'<svg x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" ', 1)


def ticks(low: float, high: float, most: int) -> list[float]:
    """Round numbers within a range, at most so many.

    >>> ticks(0.0, 20.0, 5)
    [0.0, 5.0, 10.0, 15.0, 20.0]
    """
    span = high - low
    if not span > 0.0:
        return [low]
    power = 10.0 ** math.floor(math.log10(span / most))
    step = next(step for step in (factor * power for factor in (1, 2, 2.5, 5, 10, 20)) if span / step <= most)
    return [round(k * step, 10) for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]
