"""The summary of a run as one picture: the field from above with paths, shots and pieces, and the curves under it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError
from simcore.quantities import DURATION, require
from simcore.show.charts import Chart, charts_of, draw_chart
from simcore.show.figure_file import new_figure, picture_path, save_figure
from simcore.show.scene import CARPET, GRID, HIT, INK, MISS, MUTED, PieceLook, RobotLook, Scene, rgb, tint
from simcore.telemetry.recording import Recording
from simcore.typing import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_match", "draw_summary"]

_GRID_ON_CARPET = "#c3c7cc"
_PATH = ("#b59ae6", "#2a0e5e")  # first to last second
_LEFT = 0.72  # [in]; left edge of everything
_CHARTS_IN_A_ROW, _CHART_ROW = 3, 2.5  # [-], [in]


def draw_summary(path: str | Path, recording: Recording, scene: Scene, *, title: str = "", subtitle: str = "") -> None:
    """Draw what was recorded.

    Args:
        path: A `.png`, `.svg` or `.pdf` file; missing folders are made.
        recording: The run.
        scene: What it took place on.
        title: In large letters.
        subtitle: Under it, in small ones.

    Raises:
        OutputError: The picture cannot be written there, or as that kind of file.
    """
    times = recording.times
    draw_match(
        path,
        scene,
        robot_paths=[recording.path(robot.pose_key) for robot in scene.robots],
        pieces_before=recording.pieces_at(float(times[0]) if len(times) else 0.0),
        pieces_after=recording.pieces_at(float(times[-1]) if len(times) else 0.0),
        path_period=float(np.median(np.diff(times))) if len(times) > 1 else 0.02,
        charts=charts_of(recording, scene),
        title=title,
        subtitle=subtitle,
    )


def draw_match(
    path: str | Path,
    scene: Scene,
    *,
    robot_paths: Sequence[FloatArray] = (),
    pieces_before: Mapping[str, FloatArray] | None = None,
    pieces_after: Mapping[str, FloatArray] | None = None,
    path_period: float = 0.02,
    charts: Sequence[Chart] = (),
    title: str = "",
    subtitle: str = "",
) -> None:
    """Draw a run as a picture 1600 pixels wide, robots and pieces to scale; missing folders are made.

    Args:
        path: A `.png`, `.svg` or `.pdf` file.
        scene: Field, robots, looks of pieces, and shots.
        robot_paths: `x, y, yaw` of each robot of the scene at every `path_period` [m, m, rad], shape (n, 3) each.
        pieces_before: Pose rows of the pieces by type before the run, shape (n, 7) each.
        pieces_after: The same after it.
        path_period: Time between two rows of a path [s].
        charts: Curves over time, three in a row under the field; each row adds 250 pixels to the 1000 of the rest.
        title: In large letters.
        subtitle: Under it, in small ones.

    Raises:
        OutputError: The picture cannot be written there, or as that kind of file.
        ConfigError: An array of another shape, another number of paths than of robots, or a period that is not > 0.
    """
    require("draw_match", "path_period", path_period, DURATION)
    if robot_paths and len(robot_paths) != len(scene.robots):
        raise ConfigError(f"draw_match: {len(robot_paths)} robot_paths for {len(scene.robots)} robots of the scene")
    paths = [_rows(f"robot_paths[{i}]", rows, 3) for i, rows in enumerate(robot_paths)]
    before = {name: _rows(f"pieces_before[{name!r}]", rows, 7) for name, rows in (pieces_before or {}).items()}
    after = {name: _rows(f"pieces_after[{name!r}]", rows, 7) for name, rows in (pieces_after or {}).items()}
    flights = [(_rows(f"shots[{i}].points", shot.points, 3), shot.scored) for i, shot in enumerate(scene.shots)]
    outlines = [(name, _rows(name, corners, 2)) for name, corners in scene.field_outlines]
    path = picture_path(path)

    rows = -(-len(charts) // _CHARTS_IN_A_ROW)
    height = 10.0 + _CHART_ROW * rows
    figure = new_figure(path, (16.0, height))

    def axes_at(left: float, top: float, across: float, up: float) -> Axes:
        """Axes by their place from the upper left corner of the picture [in]."""
        return figure.add_axes((left / 16.0, 1.0 - (top + up) / height, across / 16.0, up / height))

    length, width = scene.field_size
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

    _draw_field(top, outlines, scene.field_size, margin)
    taken = _rows("intakes", scene.intakes, 3)
    _draw_pieces(top, scene, before, after, taken)
    seconds = _draw_robot(top, paths[0], scene.robots[0].bumpers, path_period) if paths else 0.0
    for robot, rows_of_other in zip(scene.robots[1:], paths[1:], strict=False):
        _draw_other(top, robot, rows_of_other)
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
    _draw_legend(figure, scene, before, after)
    if seconds > 0.0:
        _draw_time_bar(axes_at(14.29, 3.6, 0.18, 2.8), figure, seconds)
    save_figure(figure, path)


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


def _draw_pieces(
    axes: Axes,
    scene: Scene,
    before: Mapping[str, FloatArray],
    after: Mapping[str, FloatArray],
    taken: FloatArray,
) -> None:
    for pieces, is_filled in ((before, False), (after, True)):
        for name, rows in pieces.items():
            look = scene.look(name)
            style = {"facecolors": look.color, "zorder": 3} if is_filled else {"facecolors": "none", "alpha": 0.6}
            _add_outlines(axes, look, rows, {"edgecolors": look.edge_color, "linewidths": 0.7, "zorder": 2} | style)
    axes.scatter(taken[:, 0], taken[:, 1], marker="+", s=26, color=_PATH[1], linewidths=1.1, zorder=3.2)


def _add_outlines(axes: Axes, look: PieceLook, rows: FloatArray, style: dict[str, Any]) -> None:
    from matplotlib.collections import EllipseCollection, PolyCollection

    if look.size is None:
        size = np.full(len(rows), 2.0 * look.reach)
        centers: dict[str, Any] = {"offsets": rows[:, :2], "offset_transform": axes.transData}
        axes.add_collection(EllipseCollection(size, size, np.zeros(len(rows)), units="xy", **centers, **style))
    else:
        axes.add_collection(PolyCollection(list(look.corners(rows)), **style))


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


def _draw_legend(
    figure: Figure, scene: Scene, before: Mapping[str, FloatArray], after: Mapping[str, FloatArray]
) -> None:
    from matplotlib.lines import Line2D

    handles = []
    for name in dict.fromkeys((*scene.pieces, *before, *after)):
        look = scene.look(name)
        mark: dict[str, Any] = {"marker": "o" if look.size is None else "s", "linestyle": "none", "markersize": 9}
        for when, pieces, color in (("before", before, "none"), ("after", after, look.color)):
            text = f"{name.lower()} {when} ({len(pieces.get(name, ()))})"
            handles.append(Line2D([], [], **mark, markeredgecolor=look.edge_color, markerfacecolor=color, label=text))
    dot: dict[str, Any] = {"marker": "o", "markersize": 5, "linewidth": 1.6}
    handles += [
        Line2D([], [], marker="+", linestyle="none", color=_PATH[1], label=f"taken in ({len(scene.intakes)})"),
        Line2D([], [], **dot, color=HIT, label=f"hit ({scene.hits})"),
        Line2D([], [], **dot, color=MISS, label=f"miss ({len(scene.shots) - scene.hits})"),
        Line2D([], [], color=_PATH[1], linewidth=3, label="robot, front bold"),
    ]
    text_look: dict[str, Any] = {"frameon": False, "fontsize": 10, "labelspacing": 0.9, "handlelength": 1.6}
    corner = (14.1 / 16.0, 1.0 - 1.0 / figure.get_figheight())
    figure.legend(handles=handles, loc="upper left", bbox_to_anchor=corner, labelcolor=INK, **text_look)


def _draw_time_bar(axes: Axes, figure: Figure, seconds: float) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    shades = ScalarMappable(Normalize(0.0, seconds), LinearSegmentedColormap.from_list("path", _PATH))
    figure.colorbar(shades, cax=axes)
    axes.set_ylabel("time along the path [s]", fontsize=10, color=INK)
    axes.tick_params(labelsize=9, colors=MUTED, length=3)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _draw_other(axes: Axes, robot: RobotLook, path: FloatArray) -> None:
    """Path of a further robot, and where it ended."""
    from matplotlib.patches import Polygon

    if not len(path):
        return
    color = tint(robot.alliance)[1]
    axes.plot(path[:, 0], path[:, 1], color=color, linewidth=1.8, alpha=0.8, zorder=3.6)
    outline = _outline(path[-1], robot.bumpers)
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
