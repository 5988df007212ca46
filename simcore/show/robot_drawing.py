"""A described robot as one picture: from above and from the left, to scale, with a legend."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.show.figure_file import new_figure, picture_path, save_figure
from simcore.show.robot_sketch import RobotSketch, SketchWay
from simcore.show.scene import GRID, HIT, INK, MISS, MUTED, PATH, tint
from simcore.typing import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_robot"]

_COLORS = {
    "intake": HIT,
    "shooter": MISS,
    "storage": "#b08900",
    "camera": "#0f7c8f",
    "claw": PATH,
    "hook": "#a3195b",
    "way": "#2f5fae",
}
_FRONT = tint("blue")[1]
_WHITE: dict[str, Any] = {
    "fontsize": 8.5, "fontweight": "bold", "color": "white", "ha": "center", "va": "center", "zorder": 9,
}  # fmt: skip
_WIDE, _VIEW_TOP, _VIEW_HIGH = 16.0, 1.15, 6.55  # [in]
_VIEW_LEFT, _VIEW_WIDE, _GAP = 0.75, 7.0, 0.75  # [in]
_LEGEND_ROW, _LEGEND_COLUMNS = 0.29, 2  # [in], [-]
_MARGIN = 0.12  # [m]
_ABOVE, _SIDE = (0, 1), (0, 2)  # columns of a point in the two views


def draw_robot(path: str | Path, sketch: RobotSketch, *, title: str, subtitle: str = "") -> None:
    """Draw a robot from above and from its right side, both to one scale; missing folders are made.

    Args:
        path: A `.png`, `.svg` or `.pdf` file.
        sketch: What is drawn.
        title: In large letters.
        subtitle: Under it, in small ones.

    Raises:
        OutputError: The picture cannot be written there, or as that kind of file.
    """
    path = picture_path(path)

    ways = [way for way in sketch.ways if len(way.way)]
    rows = -(-(len(sketch.notes) + bool(ways)) // _LEGEND_COLUMNS)
    high = _VIEW_TOP + _VIEW_HIGH + 0.75 + _LEGEND_ROW * rows + 0.1
    figure = new_figure(path, (_WIDE, high))
    points = sketch.points()
    low, top = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
    low[2] = min(low[2], -_MARGIN)
    size = top - low
    scale = min(_VIEW_WIDE / size[0], _VIEW_HIGH / max(size[1], size[2]))  # [in/m]
    for number, (columns, name) in enumerate(((_ABOVE, "from above"), (_SIDE, "from its right side"))):
        left = _VIEW_LEFT + number * (_VIEW_WIDE + _GAP)
        axes = figure.add_axes(
            (left / _WIDE, 1.0 - (_VIEW_TOP + _VIEW_HIGH) / high, _VIEW_WIDE / _WIDE, _VIEW_HIGH / high)
        )
        _frame(axes, low, top, columns, scale)
        axes.set_title(name, fontsize=11, color=MUTED, loc="left", pad=6)
        _draw_view(axes, sketch, columns)
    head: dict[str, Any] = {"va": "center", "parse_math": False}
    figure.text(_VIEW_LEFT / _WIDE, 1.0 - 0.38 / high, title, fontsize=19, fontweight="bold", color=INK, **head)
    figure.text(_VIEW_LEFT / _WIDE, 1.0 - 0.72 / high, subtitle, fontsize=11.5, color=MUTED, **head)
    _draw_legend(figure, sketch, ways, high, rows)
    save_figure(figure, path)


def _frame(axes: Axes, low: FloatArray, top: FloatArray, columns: tuple[int, int], scale: float) -> None:
    """Axes in meters with a grid of 10 cm, the robot in their middle; both views have the same scale."""
    from matplotlib.ticker import MultipleLocator

    across, up = columns
    middle_x, half_x = 0.5 * (low[across] + top[across]), 0.5 * _VIEW_WIDE / scale
    half_y = 0.5 * _VIEW_HIGH / scale
    # on the floor: what is left over is above the robot
    middle_y = low[up] + half_y if up == _SIDE[1] else 0.5 * (low[up] + top[up])
    axes.set_xlim(middle_x - half_x, middle_x + half_x)
    axes.set_ylim(middle_y - half_y, middle_y + half_y)
    axes.set_aspect("equal")
    step = 0.2 if half_x < 1.2 else 0.5
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MultipleLocator(step))
        axis.set_minor_locator(MultipleLocator(step / 2))
    axes.grid(True, which="major", color=GRID, linewidth=0.9)
    axes.grid(True, which="minor", color=GRID, linewidth=0.4)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=9, colors=MUTED, length=0, which="both")
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set_xlabel("x, to the front [m]", fontsize=9.5, color=MUTED)
    axes.set_ylabel("y, to the left [m]" if up == _ABOVE[1] else "z, up [m]", fontsize=9.5, color=MUTED)


def _draw_view(axes: Axes, sketch: RobotSketch, columns: tuple[int, int]) -> None:
    from matplotlib.patches import Polygon

    is_above = columns == _ABOVE
    if is_above:
        _draw_from_above(axes, sketch)
    else:
        _draw_from_the_side(axes, sketch)
    for volume in sketch.volumes:
        color = _COLORS[volume.role]
        outline = _hull(volume.corners[:, columns])
        look: dict[str, Any] = {"facecolor": "none", "linestyle": (0, (4, 3)), "alpha": 0.8}
        if not volume.is_outline:
            strength = {"camera": 0.13, "storage": 0.10}.get(volume.role, 0.28)
            look = {"facecolor": (*_rgb(color), strength)}
        axes.add_patch(Polygon(outline, edgecolor=color, linewidth=1.3, zorder=5, **look))
        if volume.tag:
            apex = volume.role == "camera"
            center = volume.corners[0, columns] if apex else outline.mean(axis=0)
            if volume.role == "storage":  # out of the way of what stands in it
                center = np.array([outline[:, 0].min() + 0.035, outline[:, 1].max() - 0.03])
            _tag(axes, volume.tag, center, color)
    labels: dict[tuple[float, float], list[str]] = {}
    for way in sketch.ways:
        at = _draw_way(axes, way, columns)
        if at is not None:
            labels.setdefault((round(at[0], 2), round(at[1], 2)), []).append(way.name)
    for place, names in labels.items():
        axes.annotate(
            ", ".join(names), place, (6, 5), textcoords="offset points", fontsize=8.5, color=_COLORS["way"], zorder=9,
            bbox={"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.75},
        )  # fmt: skip
    for arrow in sketch.arrows:
        start, end = arrow.start[list(columns)], arrow.end[list(columns)]
        color = _COLORS["shooter"]
        width, alpha = (1.6, 0.45) if arrow.is_faint else (3.0, 1.0)
        if math.dist(start, end) > 0.02:
            shape = {"arrowstyle": "-|>,head_width=0.35,head_length=0.7", "color": color, "linewidth": width}
            axes.annotate(
                "",
                _point(end),
                _point(start),
                arrowprops={**shape, "alpha": alpha, "shrinkA": 0, "shrinkB": 0},
                zorder=8,
            )
        axes.plot(*start, "o", color=color, markersize=6, markeredgecolor="white", zorder=8.5)
        if arrow.tag:
            _tag(axes, arrow.tag, start + (start - end) / max(math.dist(start, end), 1e-9) * 0.05, color)


def _draw_from_above(axes: Axes, sketch: RobotSketch) -> None:
    from matplotlib.patches import FancyBboxPatch, Rectangle

    (length, width), thick = sketch.bumper, sketch.bumper_thickness
    fill, edge = tint("blue")
    corner: dict[str, Any] = {"boxstyle": f"round,pad=0,rounding_size={0.4 * thick:.4f}", "linewidth": 1.4}
    axes.add_patch(
        FancyBboxPatch((-length / 2, -width / 2), length, width, facecolor=fill, edgecolor=edge, zorder=2, **corner)
    )
    inner = (length - 2 * thick, width - 2 * thick)
    axes.add_patch(
        Rectangle(
            (-inner[0] / 2, -inner[1] / 2), *inner, facecolor="#f6f7f9", edgecolor=edge, linewidth=0.8, zorder=2.1
        )
    )
    for name, x, y in sketch.wheels:
        r = sketch.wheel_radius
        axes.add_patch(Rectangle((x - r, y - 0.019), 2 * r, 0.038, facecolor=INK, edgecolor="none", zorder=3))
        inward = -1.0 if y > 0.0 else 1.0
        reach = min(abs(x) + r, 0.5 * inner[0] - 0.012)  # its name stays inside of the frame
        edge_x, side = (reach, "right") if x > 0.0 else (-reach, "left")
        axes.text(edge_x, y + inward * 0.045, name, fontsize=8, color=MUTED, ha=side, va="center", zorder=3.1)
    front = (length - thick) / 2
    band = Rectangle(
        (length / 2 - thick, -inner[1] / 2), thick, inner[1], facecolor=_FRONT, edgecolor="none", zorder=2.2
    )
    axes.add_patch(band)
    for y in (-1.0, 0.0, 1.0):
        axes.plot(front, y * inner[1] / 3, marker=">", color="white", markersize=10, zorder=9)
    for y in (-0.5, 0.5):
        axes.text(front, y * inner[1] / 3, "FRONT", rotation=-90, **_WHITE)
    axes.plot(0.0, 0.0, "+", color=MUTED, markersize=11, zorder=3)


def _draw_from_the_side(axes: Axes, sketch: RobotSketch) -> None:
    from matplotlib.patches import Circle, FancyBboxPatch, Rectangle

    length, (low, high) = sketch.bumper[0], sketch.bumper_heights
    fill, edge = tint("blue")
    axes.axhline(0.0, color=INK, linewidth=2.2, zorder=1.5)
    thick = sketch.bumper_thickness
    frame = length - 2 * thick
    axes.add_patch(
        Rectangle((-frame / 2, high), frame, sketch.height - high, facecolor="#f6f7f9", edgecolor=edge, linewidth=0.8,
                  linestyle=(0, (2, 2)), zorder=1.8)
    )  # fmt: skip
    for x in {round(x, 6) for _, x, _ in sketch.wheels}:
        axes.add_patch(Circle((x, sketch.wheel_radius), sketch.wheel_radius, facecolor=INK, edgecolor="none", zorder=2))
    corner = f"round,pad=0,rounding_size={0.25 * thick:.4f}"
    axes.add_patch(
        FancyBboxPatch((-length / 2, low), length, high - low, boxstyle=corner, facecolor=(*_rgb(fill), 0.85),
                       edgecolor=edge, linewidth=1.4, zorder=2.2)
    )  # fmt: skip
    axes.text(length / 2 - 0.03, 0.5 * (low + high), "FRONT \u25b6", **(_WHITE | {"ha": "right"}))


def _draw_way(axes: Axes, way: SketchWay, columns: tuple[int, int]) -> tuple[float, float] | None:
    """The joint, the link to what it carries, and the way of that from stop to stop.

    Returns:
        Where its name goes; None: it is not seen in this view.
    """
    color, pick = _COLORS["way"], list(columns)
    joint = way.link[0, pick]
    if way.has_place and np.ptp(way.link[:, pick], axis=0).max() > 1e-6:
        axes.plot(*way.link[:, pick].T, color=color, linewidth=3.2, alpha=0.55, solid_capstyle="round", zorder=6)
    has_way = len(way.way) and np.ptp(way.way[:, pick], axis=0).max() > 5e-3
    if has_way:
        places = way.way[:, pick]
        axes.plot(*places.T, color=color, linewidth=1.3, linestyle=(0, (5, 2)), zorder=6)
        shape = {"arrowstyle": "-|>,head_width=0.22,head_length=0.5", "color": color, "linewidth": 1.3}
        axes.annotate(
            "", _point(places[-1]), _point(places[-3]), arrowprops={**shape, "shrinkA": 0, "shrinkB": 0}, zorder=6.1
        )
        axes.plot(*places[0], "|" if columns == _ABOVE else "_", color=color, markersize=8, zorder=6.1)
    is_seen_along = abs(way.axis[2 if columns == _ABOVE else 1]) > 0.9
    if not (has_way or is_seen_along):
        return None
    if way.has_place:
        axes.plot(*joint, "o", color="white", markersize=7, markeredgecolor=color, markeredgewidth=1.6, zorder=6.2)
    return _point(way.way[-1, pick] if has_way else joint)


def _draw_legend(figure: Figure, sketch: RobotSketch, ways: Sequence[SketchWay], high: float, rows: int) -> None:
    notes = [(note.tag, _COLORS[note.role], note.text) for note in sketch.notes]
    if ways:
        notes.append(("", _COLORS["way"], "dashed: the way of a mechanism, its arrow at the end of positive motion"))
    for number, (tag, color, text) in enumerate(notes):
        column, row = divmod(number, rows)
        x = (_VIEW_LEFT + column * (_WIDE - _VIEW_LEFT) / _LEGEND_COLUMNS) / _WIDE
        y = 1.0 - (_VIEW_TOP + _VIEW_HIGH + 0.85 + _LEGEND_ROW * row) / high
        badge = {"boxstyle": "round,pad=0.22", "facecolor": color, "edgecolor": "none"}
        bold: dict[str, Any] = {"fontsize": 8.5, "fontweight": "bold", "color": "white", "ha": "center"}
        figure.text(x + 0.008, y, tag or "--", va="center", bbox=badge, **bold)
        figure.text(x + 0.024, y, text, fontsize=10, color=INK, va="center", parse_math=False)


def _tag(axes: Axes, tag: str, at: FloatArray, color: str) -> None:
    badge = {"boxstyle": "round,pad=0.22", "facecolor": color, "edgecolor": "white", "linewidth": 0.8}
    look: dict[str, Any] = {"fontsize": 8.5, "fontweight": "bold", "color": "white", "ha": "center", "va": "center"}
    axes.text(float(at[0]), float(at[1]), tag, bbox=badge, zorder=10, clip_on=True, **look)


def _point(row: FloatArray) -> tuple[float, float]:
    return float(row[0]), float(row[1])


def _rgb(color: str) -> tuple[float, float, float]:
    r, g, b = (int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return r, g, b


def _hull(points: FloatArray) -> FloatArray:
    """Corners of the convex hull, counter-clockwise, shape (n, 2)."""
    ordered = sorted({(round(float(x), 9), round(float(y), 9)) for x, y in points})

    def half(rows: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        chain: list[tuple[float, float]] = []
        for x, y in rows:
            while len(chain) > 1 and (chain[-1][0] - chain[-2][0]) * (y - chain[-2][1]) <= (
                chain[-1][1] - chain[-2][1]
            ) * (x - chain[-2][0]):
                chain.pop()
            chain.append((x, y))
        return chain[:-1]

    return np.array(half(ordered) + half(ordered[::-1]) or ordered)
