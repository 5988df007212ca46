"""One picture of a run: the field from above, where the robot drove, what became of the fuel, and every shot."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError, OutputError, require_positive
from simcore.show.charts import Chart
from simcore.show.colors import CARPET, FUEL, FUEL_EDGE, GRID, HIT, INK, MISS, MUTED, rgb, tint
from simcore.show.plot import draw_chart
from simcore.show.scene import ShotTrace
from simcore.telemetry.output import output_error, require_writable
from simcore.typing import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_match"]

_GRID_ON_CARPET = "#c3c7cc"
_PATH = ("#b59ae6", "#2a0e5e")  # first to last second
_FORMATS = ("pdf", "png", "svg")
_LEFT = 0.72  # [in]; left edge of everything
_CHARTS_IN_A_ROW, _CHART_ROW = 3, 2.5  # [-], [in]


def draw_match(
    path: str | Path,
    *,
    field_outlines: Sequence[tuple[str, FloatArray]],
    field_size: tuple[float, float],
    robot_path: FloatArray,
    fuel_start: FloatArray,
    fuel_end: FloatArray,
    shots: Sequence[ShotTrace] = (),
    intakes: FloatArray | None = None,
    title: str = "",
    subtitle: str = "",
    bumpers: tuple[float, float] = (0.8, 0.8),
    path_period: float = 0.02,
    fuel_radius: float = 0.075,
    others: Sequence[tuple[str, FloatArray]] = (),
    charts: Sequence[Chart] = (),
) -> None:
    """Draw a run as a picture 1600 pixels wide, robot and fuel to scale; missing folders are made.

    Args:
        path: A `.png`, `.svg` or `.pdf` file.
        field_outlines: Name and corners of each field element from above [m], shape (n, 2). A name that begins with
            `blue` or `red` is tinted so.
        field_size: Length and width of the field [m].
        robot_path: `x, y, yaw` of the robot at every `path_period` [m, m, rad], shape (n, 3).
        fuel_start: Centers before the run [m], shape (n, 3).
        fuel_end: Centers after it [m], shape (n, 3).
        shots: Flights in the order they were shot.
        intakes: Where fuel was taken in [m], shape (n, 3).
        title: In large letters.
        subtitle: Under it, in small ones.
        bumpers: Length and width over the bumpers [m].
        path_period: Time between two rows of `robot_path` [s].
        fuel_radius: As drawn [m].
        others: Alliance and path of each further robot, as `robot_path`.
        charts: Curves over time, three in a row under the field; each row adds 250 pixels to the 1000 of the rest.

    Raises:
        OutputError: The picture cannot be written there, or as that kind of file.
        ConfigError: An array of another shape, or a size that is not > 0.
    """
    for name, size in (("field_size", field_size), ("bumpers", bumpers)):
        require_positive("draw_match", f"{name}[0]", size[0], "m")
        require_positive("draw_match", f"{name}[1]", size[1], "m")
    require_positive("draw_match", "path_period", path_period, "s")
    require_positive("draw_match", "fuel_radius", fuel_radius, "m")
    robot = _rows("robot_path", robot_path, 3)
    before, after = _rows("fuel_start", fuel_start, 3), _rows("fuel_end", fuel_end, 3)
    taken = _rows("intakes", np.empty((0, 3)) if intakes is None else intakes, 3)
    flights = [(_rows(f"shots[{i}].points", shot.points, 3), shot.scored) for i, shot in enumerate(shots)]
    outlines = [(name, _rows(name, corners, 2)) for name, corners in field_outlines]
    path = Path(path)
    kind = path.suffix.lower().lstrip(".")
    if kind not in _FORMATS:
        raise OutputError(f"cannot draw {str(path)!r}: pictures end in {', '.join('.' + f for f in _FORMATS)}")
    require_writable("picture", path)

    try:
        from matplotlib.figure import Figure  # takes half a second, and needs no screen and no pyplot
    except ImportError as error:
        raise OutputError(
            f"cannot draw the picture {str(path)!r}: {error}. `python -m pip install matplotlib` brings what it needs"
        ) from error

    rows = -(-len(charts) // _CHARTS_IN_A_ROW)
    height = 10.0 + _CHART_ROW * rows
    figure = Figure(figsize=(16, height), dpi=100, facecolor="white")

    def axes_at(left: float, top: float, across: float, up: float) -> Axes:
        """Axes by their place from the upper left corner of the picture [in]."""
        return figure.add_axes((left / 16.0, 1.0 - (top + up) / height, across / 16.0, up / height))

    length, width = field_size
    margin = 0.35
    shape = (width + 2 * margin) / (length + 2 * margin)
    across = min(13.3, 6.9 / shape)  # [in] for the field's length and a margin around it
    up = across * shape
    top = axes_at(_LEFT, 0.95, across, up)
    side = axes_at(_LEFT, 0.95 + up + 0.42, across, 10.0 - 0.95 - up - 0.58 - 0.42)
    for axes in (top, side):
        axes.set_xlim(-margin, length + margin)
        axes.tick_params(labelsize=9, colors=MUTED, length=3)
        for spine in axes.spines.values():
            spine.set_visible(False)

    _draw_field(top, outlines, field_size, margin)
    _draw_fuel(top, before, after, taken, fuel_radius)
    seconds = _draw_robot(top, robot, bumpers, path_period)
    for alliance, path_of_other in others:
        _draw_other(top, alliance, path_of_other, bumpers)
    for points, scored in flights:
        _draw_flight(top, points[:, 0], points[:, 1], scored)
        _draw_flight(side, points[:, 0], points[:, 2], scored)
    _draw_side(side, flights, length)

    for number, chart in enumerate(charts):
        row, column = divmod(number, _CHARTS_IN_A_ROW)
        axes = axes_at(_LEFT + 5.15 * column, 10.0 + _CHART_ROW * row + 0.3, 4.45, _CHART_ROW - 0.75)
        draw_chart(axes, chart, is_last=row == rows - 1)

    left = _LEFT / 16.0
    head: dict[str, Any] = {"va": "center", "parse_math": False}
    figure.text(left, 1.0 - 0.37 / height, title, fontsize=19, fontweight="bold", color=INK, **head)
    figure.text(left, 1.0 - 0.72 / height, subtitle, fontsize=11.5, color=MUTED, **head)
    hits = sum(scored for _, scored in flights)
    counts = {"before": len(before), "after": len(after), "taken": len(taken), "hits": hits}
    _draw_legend(figure, counts, len(flights) - hits)
    if seconds > 0.0:
        _draw_time_bar(axes_at(14.29, 3.6, 0.18, 2.8), figure, seconds)
    try:
        figure.savefig(path, format=kind)
    except OSError as error:
        raise output_error("picture", path, error) from error


def _rows(name: str, array: FloatArray, columns: int) -> FloatArray:
    """The finite rows of an array that must have so many columns."""
    rows = np.asarray(array, dtype=np.float64)
    if rows.size == 0:
        return np.empty((0, columns))
    if rows.ndim != 2 or rows.shape[1] != columns:
        raise ConfigError(f"draw_match: {name} needs shape (n, {columns}), got {rows.shape}")
    return rows[np.isfinite(rows).all(axis=1)]


def _draw_field(axes: Axes, outlines: Sequence[tuple[str, FloatArray]], size: tuple[float, float], edge: float) -> None:
    from matplotlib.patches import Polygon, Rectangle

    length, width = size
    axes.set_aspect("equal")
    axes.set_ylim(-edge, width + edge)
    axes.set_ylabel("y [m]", fontsize=9, color=MUTED, labelpad=2)
    carpet = axes.add_patch(Rectangle((0.0, 0.0), length, width, facecolor=CARPET, edgecolor="none", zorder=0))
    axes.set_xticks(range(0, int(length) + 1, 2))
    axes.set_yticks(range(0, int(width) + 1, 2))
    axes.grid(True, color=_GRID_ON_CARPET, linewidth=0.8, zorder=0.5)
    axes.set_axisbelow(True)
    for line in axes.get_xgridlines() + axes.get_ygridlines():
        line.set_clip_path(carpet)
    for name, corners in outlines:
        fill, stroke = tint(name)
        axes.add_patch(Polygon(corners, facecolor=fill, edgecolor=stroke, linewidth=1.0, alpha=0.75, zorder=1))
    axes.plot([0, length], [0, 0], color=INK, linewidth=2, zorder=1.5)
    axes.plot([0, length], [width, width], color=INK, linewidth=2, zorder=1.5)
    for x, alliance in ((0.0, "blue"), (length, "red")):
        axes.plot([x, x], [0, width], color=tint(alliance)[1], linewidth=4, zorder=1.5)


def _draw_fuel(axes: Axes, before: FloatArray, after: FloatArray, taken: FloatArray, radius: float) -> None:
    from matplotlib.collections import EllipseCollection

    looks = (
        (before, {"facecolors": "none", "edgecolors": FUEL_EDGE, "linewidths": 0.7, "alpha": 0.6, "zorder": 2}),
        (after, {"facecolors": FUEL, "edgecolors": FUEL_EDGE, "linewidths": 0.7, "zorder": 3}),
    )
    for centers, look in looks:
        size = np.full(len(centers), 2.0 * radius)
        places: dict[str, Any] = {"offsets": centers[:, :2], "offset_transform": axes.transData}
        axes.add_collection(EllipseCollection(size, size, np.zeros(len(centers)), units="xy", **places, **look))
    axes.scatter(taken[:, 0], taken[:, 1], marker="+", s=26, color=_PATH[1], linewidths=1.1, zorder=3.2)


def _draw_robot(axes: Axes, robot: FloatArray, bumpers: tuple[float, float], period: float) -> float:
    """Path and outlines, darker with time; returns how long it took [s]."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.patches import Polygon

    if not len(robot):
        return 0.0
    shade = LinearSegmentedColormap.from_list("path", _PATH)
    seconds = (len(robot) - 1) * period
    lines = np.stack((robot[:-1, :2], robot[1:, :2]), axis=1)
    axes.add_collection(
        LineCollection(list(lines), array=np.arange(len(lines)), cmap=shade, linewidths=2.6, zorder=4, capstyle="round")
    )
    step = max(1, round(max(1.0, seconds / 30.0) / period))  # every second, fewer in a long match
    last = len(robot) - 1
    for row in (*range(0, last, step), last):
        outline = _outline(robot[row], bumpers)
        is_end, color = row == last, shade(row / max(last, 1))
        edge = 2.0 if is_end or row == 0 else 0.9
        face = (*color[:3], 0.35) if is_end else "none"
        axes.add_patch(Polygon(outline, facecolor=face, edgecolor=color, linewidth=edge, zorder=4.5 + is_end))
        # the front bumper, bold
        axes.plot(outline[:2, 0], outline[:2, 1], color=color, linewidth=edge + 1.8, zorder=4.6 + is_end)
    apart = 0.0 if np.hypot(*(robot[-1, :2] - robot[0, :2])) > bumpers[0] else 13.0  # labels side by side
    for row, text, color, shift in ((0, "START", shade(0.35), apart), (last, "END", shade(1.0), -apart)):
        axes.annotate(
            text,
            (float(robot[row, 0]), float(robot[row, 1])),
            (0.0, shift),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=8,
            fontweight="bold",
            color="white",
            bbox={"boxstyle": "round,pad=0.25", "facecolor": color, "edgecolor": "white", "linewidth": 0.8},
            zorder=9,
        )
    return seconds


def _draw_flight(axes: Axes, along: FloatArray, up: FloatArray, scored: bool) -> None:
    color = HIT if scored else MISS
    axes.plot(along, up, color=color, linewidth=1.1, alpha=0.65, zorder=6 + 0.1 * (not scored))
    axes.plot(
        along[-1:], up[-1:], "o", color=color, markersize=4.5, markeredgecolor="white", markeredgewidth=0.6, zorder=7
    )


def _draw_side(axes: Axes, flights: Sequence[tuple[FloatArray, bool]], length: float) -> None:
    from matplotlib.ticker import MaxNLocator

    highest = max((float(points[:, 2].max()) for points, _ in flights if len(points)), default=0.0)
    axes.set_ylim(0.0, max(2.5, highest + 0.25))
    axes.set_xticks(range(0, int(length) + 1, 2))
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=5))
    axes.set_facecolor("#f3f4f6")
    axes.grid(True, color=GRID, linewidth=0.8)
    axes.axhline(0.0, color=INK, linewidth=2)
    axes.set_xlabel("x [m]", fontsize=9, color=MUTED, labelpad=2)
    axes.set_ylabel("height z [m]", fontsize=9, color=MUTED, labelpad=2)
    axes.set_title("Shots from the side", fontsize=10, color=INK, loc="left", pad=4)
    if not flights:
        axes.text(0.5, 0.5, "no shots", transform=axes.transAxes, ha="center", va="center", color=MUTED)


def _draw_legend(figure: Figure, counts: dict[str, int], misses: int) -> None:
    from matplotlib.lines import Line2D

    ring: dict[str, Any] = {"marker": "o", "linestyle": "none", "markersize": 9, "markeredgecolor": FUEL_EDGE}
    dot: dict[str, Any] = {"marker": "o", "markersize": 5, "linewidth": 1.6}
    handles = [
        Line2D([], [], **ring, markerfacecolor="none", label=f"fuel before ({counts['before']})"),
        Line2D([], [], **ring, markerfacecolor=FUEL, label=f"fuel after ({counts['after']})"),
        Line2D([], [], marker="+", linestyle="none", color=_PATH[1], label=f"taken in ({counts['taken']})"),
        Line2D([], [], **dot, color=HIT, label=f"hit ({counts['hits']})"),
        Line2D([], [], **dot, color=MISS, label=f"miss ({misses})"),
        Line2D([], [], color=_PATH[1], linewidth=3, label="robot, front bold"),
    ]
    look: dict[str, Any] = {"frameon": False, "fontsize": 10, "labelspacing": 0.9, "handlelength": 1.6}
    corner = (14.1 / 16.0, 1.0 - 1.0 / figure.get_figheight())
    figure.legend(handles=handles, loc="upper left", bbox_to_anchor=corner, labelcolor=INK, **look)


def _draw_time_bar(axes: Axes, figure: Figure, seconds: float) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    shades = ScalarMappable(Normalize(0.0, seconds), LinearSegmentedColormap.from_list("path", _PATH))
    figure.colorbar(shades, cax=axes)
    axes.set_ylabel("time along the path [s]", fontsize=10, color=INK)
    axes.tick_params(labelsize=9, colors=MUTED, length=3)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _draw_other(axes: Axes, alliance: str, path: FloatArray, bumpers: tuple[float, float]) -> None:
    """Path of a further robot, and where it ended."""
    from matplotlib.patches import Polygon

    if not len(path):
        return
    color = tint(alliance)[1]
    axes.plot(path[:, 0], path[:, 1], color=color, linewidth=1.8, alpha=0.8, zorder=3.6)
    outline = _outline(path[-1], bumpers)
    axes.add_patch(
        Polygon(
            outline, facecolor=(*(part / 255 for part in rgb(color)), 0.3), edgecolor=color, linewidth=2.0, zorder=4.4
        )
    )
    axes.plot(outline[:2, 0], outline[:2, 1], color=color, linewidth=3.8, zorder=4.5)


def _outline(pose: FloatArray, bumpers: tuple[float, float]) -> FloatArray:
    """Corners of a robot at `x, y, yaw`, the two of the front first, shape (4, 2)."""
    x, y, yaw = pose
    corners = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) * 0.5 * np.array(bumpers)
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    return np.asarray(corners @ turn + (x, y))
