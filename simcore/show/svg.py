"""Elements of SVG as text: the one language that page, pictures and animations are drawn in."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from html import escape

from simcore.show.palette import color
from simcore.typing import FloatArray

__all__ = ["Axes", "document", "element", "line", "nested", "points", "polygon", "polyline", "ticks", "words"]


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


class Axes:
    """A plot in a drawing: from values to places, and a grid with numbers.

    Args:
        box: Left, top, width and height of the plot.
        low: Values at its left and lower edge.
        high: Values at its right and upper edge.
    """

    def __init__(
        self, box: tuple[float, float, float, float], low: tuple[float, float], high: tuple[float, float]
    ) -> None:
        self.box, self.low, self.high = box, low, high

    def x(self, value: float) -> float:
        """To the right."""
        return self.box[0] + (value - self.low[0]) / ((self.high[0] - self.low[0]) or 1.0) * self.box[2]

    def y(self, value: float) -> float:
        """Down."""
        return self.box[1] + (self.high[1] - value) / ((self.high[1] - self.low[1]) or 1.0) * self.box[3]

    def grid(
        self,
        below: str,
        aside: str,
        *,
        size: float = 11.5,
        most: tuple[int, int] = (7, 5),
        is_ruled: bool = False,
        marks: Mapping[str, float] | None = None,
    ) -> str:
        """Levels, numbers and names of the axes.

        Args:
            below: Name of the lower axis.
            aside: Of the left one.
            size: Of the letters.
            most: Numbers along either.
            is_ruled: Draw upright lines, too.
            marks: Words and their values along the lower axis, in place of numbers.
        """
        left, top, width, height = self.box
        right, bottom, parts = left + width, top + height, []
        for level in ticks(self.low[1], self.high[1], most[1]):
            parts.append(line(left, self.y(level), right, self.y(level), stroke=color("grid")))
            parts.append(words(left - 5, self.y(level) + 4, f"{level:g}", size, anchor="end"))
        along = {f"{value:g}": value for value in ticks(self.low[0], self.high[0], most[0])} if marks is None else marks
        for text, value in along.items():
            if is_ruled:
                parts.append(line(self.x(value), top, self.x(value), bottom, stroke=color("grid")))
            parts.append(words(self.x(value), bottom + 16, text, size, anchor="middle"))
        parts.append(words(left + width / 2, bottom + 33, below, size, anchor="middle"))
        turned = f"translate({left - 34:g} {top + height / 2:g}) rotate(-90)"
        parts.append(words(0.0, 0.0, aside, size, anchor="middle", transform=turned))
        return element("g", *parts)


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
