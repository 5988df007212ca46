"""The curves of a run: which telemetry becomes which chart, for picture and page alike."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from simcore.show.scene import GRID, HIT, INK, MISS, MUTED, PATH, Scene, tint
from simcore.telemetry.recording import Recording
from simcore.typing import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Chart", "Curve", "bounds", "charts_of", "draw_chart", "thinned"]

_EACH_ROBOT = (PATH, HIT, MISS, INK, tint("blue")[1], tint("red")[1])
BROWNOUT = 6.75  # [V]; of a roboRIO 2
TICK_BUDGET = 20.0  # [ms]


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """One line of a chart."""

    label: str
    color: str
    times: FloatArray
    """[s], shape (n,)."""
    values: FloatArray
    """Shape (n,)."""
    is_stepped: bool = False
    """A count, which keeps its value until it jumps."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Chart:
    """Curves over time on common axes."""

    title: str
    unit: str
    curves: Sequence[Curve]
    limit: float | None = None
    """A level that matters, drawn where the values come near it."""
    limit_label: str = ""
    from_zero: bool = True


def charts_of(recording: Recording, scene: Scene) -> list[Chart]:
    """The charts of a run; what was not published is left out."""
    robots = list(enumerate(scene.robots))
    several = len(robots) > 1

    def name(number: int, one: str) -> str:
        return str(number) if several else one

    def each(key: str, one: str, *, is_stepped: bool = False) -> Iterable[tuple[str, str, str, bool]]:
        for number, robot in robots:
            yield name(number, one), _EACH_ROBOT[number % 6], f"{robot.prefix}/{key}", is_stepped

    currents = list(each("Debug/BatteryCurrent", "battery"))
    if len(robots) == 1:
        currents.append(("drivetrain", MISS, f"{scene.robots[0].prefix}/Debug/DrivetrainCurrent", False))
    pieces, by_robot = scene.piece_names, ", by robot" if several else ""
    wanted: list[tuple[str, str, Iterable[tuple[str, str, str, bool]], float | None, str, bool]] = [
        (
            "Score",
            "points",
            [("blue", tint("blue")[1], "Sim/Score/Blue", True), ("red", tint("red")[1], "Sim/Score/Red", True)],
            None,
            "",
            True,
        ),
        (f"Battery{by_robot}", "V", each("Debug/BatteryVoltage", "at its terminals"), BROWNOUT, "brown-out", False),
        (
            "Tick time",
            "ms",
            [("wall time of a tick", INK, "Sim/Performance/TickMs", False)],
            TICK_BUDGET,
            "budget",
            True,
        ),
        (
            f"{pieces.capitalize()} held{by_robot}",
            "",
            each("Intake/HeldCount", "in the robot", is_stepped=True),
            None,
            "",
            True,
        ),
        (f"Current{by_robot}", "A", currents, None, "", True),
        (
            "Work",
            "",
            [
                (f"awake {pieces}", PATH, "Sim/Performance/AwakePieces", True),
                ("sub-steps", MISS, "Sim/Performance/SubSteps", True),
            ],
            None,
            "",
            True,
        ),
    ]
    charts = []
    for title, unit, lines, limit, label, from_zero in wanted:
        curves = [
            Curve(label=text, color=color, times=times, values=values, is_stepped=is_stepped)
            for text, color, key, is_stepped in lines
            if recording.has(key)
            for times, values in (recording.series(key),)
            if len(times)
        ]
        if curves:
            charts.append(
                Chart(title=title, unit=unit, curves=curves, limit=limit, limit_label=label, from_zero=from_zero)
            )
    return charts


def bounds(chart: Chart) -> tuple[float, float]:
    """Lowest and highest value to show, with some air; the limit too, if the values come within a third of it."""
    values = np.concatenate([curve.values for curve in chart.curves])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    if chart.from_zero:
        low, high = min(low, 0.0), max(high, 0.0)
    if chart.limit is not None and low - 0.5 * abs(chart.limit) <= chart.limit <= high + 0.5 * abs(chart.limit):
        low, high = min(low, chart.limit), max(high, chart.limit)
    span = high - low or 1.0
    high = low + span
    return (low - 0.06 * span if low < 0.0 or not chart.from_zero else low), high + 0.10 * span


def thinned(curve: Curve, buckets: int = 400) -> Curve:
    """The same curve with the lowest and the highest point of each of so many parts: what an eye can see of it."""
    n = len(curve.times)
    if n <= 2 * buckets:
        return curve
    edges = np.linspace(0, n, buckets + 1).astype(int)
    keep = {0, n - 1}
    for start, end in pairwise(edges.tolist()):
        part = curve.values[start:end]
        keep |= {int(start + part.argmin()), int(start + part.argmax())}
    rows = np.array(sorted(keep))
    return Curve(
        label=curve.label,
        color=curve.color,
        times=curve.times[rows],
        values=curve.values[rows],
        is_stepped=curve.is_stepped,
    )


def draw_chart(axes: Axes, chart: Chart, *, is_last: bool) -> None:
    """Draw curves and limit with matplotlib; only the last row of charts names the time axis."""
    low, high = bounds(chart)
    for curve in chart.curves:
        style = "steps-post" if curve.is_stepped else "default"
        thin = thinned(curve)
        axes.plot(thin.times, thin.values, color=curve.color, linewidth=1.5, drawstyle=style, label=curve.label)
    axes.set_ylim(low, high)
    if chart.limit is not None and low <= chart.limit <= high:
        axes.axhline(chart.limit, color=INK, linewidth=1.0, linestyle=(0, (4, 3)))
        place = (1.0, chart.limit)
        axes.text(
            *place,
            f"{chart.limit_label} {chart.limit:g} {chart.unit} ",
            transform=axes.get_yaxis_transform(),
            ha="right",
            va="bottom",
            fontsize=8.5,
            color=MUTED,
        )
    axes.set_xlim(min(float(c.times[0]) for c in chart.curves), max(float(c.times[-1]) for c in chart.curves) + 1e-9)
    axes.set_title(
        f"{chart.title} [{chart.unit}]" if chart.unit else chart.title,
        fontsize=10.5,
        fontweight="bold",
        color=INK,
        loc="left",
        pad=5,
    )
    axes.grid(True, color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.set_facecolor("#f7f8f9")
    axes.tick_params(labelsize=9, colors=MUTED, length=3)
    for spine in axes.spines.values():
        spine.set_visible(False)
    if is_last:
        axes.set_xlabel("time [s]", fontsize=9, color=MUTED, labelpad=2)
    # a fixed place: looking for the best one costs a tenth of a second
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.01, 0.97),
        ncols=len(chart.curves),
        frameon=False,
        fontsize=9,
        handlelength=1.2,
        columnspacing=1.0,
        labelcolor=INK,
        borderaxespad=0.3,
    )
