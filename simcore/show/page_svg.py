"""The parts of a page that need no script: the field from above, its key, and charts, as SVG."""

from __future__ import annotations

import math
from html import escape

import numpy as np

from simcore.show.charts import Chart, bounds, thinned
from simcore.show.scene import CARPET, GRID, HIT, INK, MISS, PATH, Scene, tint
from simcore.telemetry.recording import Recording
from simcore.typing import FloatArray

__all__ = ["PLOT", "field_svg", "figure_html", "key_html"]

_MARGIN = 35  # [cm] around the field
PLOT = {"total": 420, "left": 40, "width": 370, "top": 8, "height": 140, "bottom": 168}
"""Where a chart's axes are, in units of its SVG; page.js needs it too."""


def field_svg(recording: Recording, scene: Scene, end: float) -> str:
    """The field from above in centimeters, with paths and shots; what moves is drawn over it by the script."""
    length, width = (100.0 * size for size in scene.field_size)

    def points(rows: FloatArray) -> str:
        return " ".join(f"{100.0 * x:.0f},{width - 100.0 * y:.0f}" for x, y in rows[:, :2].tolist())

    box = f"{-_MARGIN} {-_MARGIN} {length + 2 * _MARGIN:.0f} {width + 2 * _MARGIN:.0f}"
    parts = [
        f'<svg viewBox="{box}" role="img" aria-label="the field from above">',
        f'<rect width="{length:.0f}" height="{width:.0f}" fill="{CARPET}"/>',
    ]
    for name, corners in scene.field_outlines:
        fill, stroke = tint(name)
        parts.append(
            f'<polygon points="{points(corners)}" fill="{fill}" stroke="{stroke}" opacity=".75">'
            f"<title>{escape(name)}</title></polygon>"
        )
    for robot in scene.robots:
        path = recording.path(robot.pose_key)
        color = PATH if len(scene.robots) == 1 else tint(robot.alliance)[1]
        step = max(1, len(path) // 1000)
        if len(path):
            way = np.vstack((path[::step], path[-1:]))
            parts.append(
                f'<polyline points="{points(way)}" fill="none" stroke="{color}" stroke-width="4" opacity=".8"/>'
            )
    for shot in scene.shots:
        if len(shot.points):
            color = HIT if shot.scored else MISS
            tip = f"{'hit' if shot.scored else 'miss'}, shot at {shot.time:.2f} s by robot {shot.robot}"
            x, y = shot.points[-1, :2]
            flight = (
                f'<polyline points="{points(shot.points)}" fill="none" stroke="{color}" stroke-width="2" opacity=".6"/>'
            )
            end_of_it = f'<circle cx="{100 * x:.0f}" cy="{width - 100 * y:.0f}" r="5" fill="{color}" stroke="#fff"/>'
            parts.append(f'<g class="shot"><title>{tip}</title>{flight}{end_of_it}</g>')
    parts.append('<g class="end">')
    for name, rows in recording.pieces_at(end).items():
        look = scene.look(name)
        colors = f'fill="{look.color}" stroke="{look.edge_color}"'
        if look.size is None:
            shapes = [
                f'<circle cx="{100 * x:.0f}" cy="{width - 100 * y:.0f}" r="{100 * look.reach:.1f}" {colors}/>'
                for x, y in rows[:, :2].tolist()
            ]
        else:
            shapes = [f'<polygon points="{points(corners)}" {colors}/>' for corners in look.corners(rows)]
        parts += shapes
    parts.append("</g></svg>")
    return "\n".join(parts)


def key_html(scene: Scene) -> str:
    """What each color means."""

    def line(color: str, text: str) -> str:
        return f'<span><svg><line y1="6" y2="6" x2="20" stroke="{color}" stroke-width="3"/></svg> {escape(text)}</span>'

    misses = len(scene.shots) - scene.hits
    path = [line(PATH, "path of the robot")] if len(scene.robots) == 1 else []
    shots = [line(HIT, f"shots that scored ({scene.hits})"), line(MISS, f"shots that missed ({misses})")]
    return " ".join(
        (
            *path,
            *(shots if scene.shots else []),
            *(
                line(look.color, f"{name.lower()} (darker and larger: in the air)")
                for name, look in scene.pieces.items()
            ),
            "<span>space plays, arrows step, charts follow the pointer</span>",
        )
    )


def figure_html(chart: Chart, start: float, end: float) -> str:
    """One chart as SVG, and above it its title and the values at the cursor."""
    low, high = bounds(chart)
    left, right, top, bottom = PLOT["left"], PLOT["left"] + PLOT["width"], PLOT["top"], PLOT["top"] + PLOT["height"]

    def across(time: float) -> float:
        return left + (time - start) / ((end - start) or 1.0) * (right - left)

    def down(value: float) -> float:
        return top + (high - value) / (high - low) * (bottom - top)

    parts = [f'<svg viewBox="0 0 {PLOT["total"]} {PLOT["bottom"]}">']
    for level in _ticks(low, high, 5):
        y = down(level)
        parts.append(f'<line x1="{left}" x2="{right}" y1="{y:.1f}" y2="{y:.1f}" stroke="{GRID}"/>')
        parts.append(f'<text x="{left - 5}" y="{y + 4:.1f}" text-anchor="end">{level:g}</text>')
    for time in _ticks(start, end, 7):
        parts.append(f'<text x="{across(time):.1f}" y="{PLOT["bottom"] - 5}" text-anchor="middle">{time:g}</text>')
    if chart.limit is not None and low <= chart.limit <= high:
        y, label = down(chart.limit), escape(f"{chart.limit_label} {chart.limit:g} {chart.unit}")
        parts.append(
            f'<line x1="{left}" x2="{right}" y1="{y:.1f}" y2="{y:.1f}" stroke="{INK}" '
            f'stroke-dasharray="4 3"/><text x="{right}" y="{y - 4:.1f}" text-anchor="end">{label}</text>'
        )
    caption = [f"<strong>{escape(chart.title)}{f' [{escape(chart.unit)}]' if chart.unit else ''}</strong>"]
    for curve in chart.curves:
        thin = thinned(curve)
        steps: list[str] = []
        previous = None
        for time, value in zip(thin.times.tolist(), thin.values.tolist(), strict=True):
            if not math.isfinite(value):
                continue
            if curve.is_stepped and previous is not None and value != previous:
                steps.append(f"{across(time):.1f},{down(previous):.1f}")
            steps.append(f"{across(time):.1f},{down(value):.1f}")
            previous = value
        parts.append(f'<polyline points="{" ".join(steps)}" fill="none" stroke="{curve.color}" stroke-width="1.5"/>')
        caption.append(
            f'<span><i style="background:{curve.color}"></i> {escape(curve.label)} <span class="value"></span></span>'
        )
    parts.append(f'<line class="cursor" visibility="hidden" y1="{top}" y2="{bottom}" stroke="{INK}"/></svg>')
    return f"<figure><figcaption>{''.join(caption)}</figcaption>{''.join(parts)}</figure>"


def _ticks(low: float, high: float, most: int) -> list[float]:
    """Round numbers within a range, at most so many.

    >>> _ticks(0.0, 20.0, 5)
    [0.0, 5.0, 10.0, 15.0, 20.0]
    """
    span = high - low
    if not span > 0.0:
        return [low]
    step = next(
        s for s in (m * 10.0 ** math.floor(math.log10(span / most)) for m in (1, 2, 2.5, 5, 10, 20)) if span / s <= most
    )
    return [round(k * step, 10) for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]
