"""One chart of a run, drawn by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simcore.show.charts import Chart, bounds, thinned
from simcore.show.colors import GRID, INK, MUTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_chart"]


def draw_chart(axes: Axes, chart: Chart, *, is_last: bool) -> None:
    """Draw curves and limit; only the last row of charts names the time axis."""
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
