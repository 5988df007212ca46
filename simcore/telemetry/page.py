"""The summary of a run as one HTML file: it plays the run, and needs nothing but a browser.

Field and curves are SVG, drawn here; a script in the page moves robots, pieces and a time cursor. Nothing is loaded
from anywhere, and the page forbids itself to.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from simcore.telemetry.charts import Chart, bounds, charts_of, thinned
from simcore.telemetry.output import output_error
from simcore.telemetry.recording import Recording
from simcore.telemetry.scene import Scene
from simcore.telemetry.summary import planar
from simcore.typing import FloatArray

__all__ = ["write_page"]

_HERE = Path(__file__).parent
_MOST_FRAMES = 800
_TINT = {"blue": ("#9db4dd", "#2f5fae"), "red": ("#e3a9a6", "#b3312b"), "": ("#b4b9c0", "#7d858f")}
_HIT, _MISS, _PATH = "#0e8a43", "#e0620d", "#6a3fb5"
_MARGIN = 35  # [cm] around the field
_PLOT = {"total": 420, "left": 40, "width": 370, "top": 8, "height": 140, "bottom": 168}


def write_page(path: str | Path, recording: Recording, scene: Scene, *, title: str = "run", subtitle: str = "") -> None:
    """Write the page; missing folders are made.

    Args:
        path: By custom a `.html` file.
        recording: The run.
        scene: What it took place on.
        title: In large letters, and of the browser's tab.
        subtitle: Under it; line breaks are kept.

    Raises:
        OutputError: The file cannot be written.
    """
    path = Path(path)
    times = recording.times
    start, end = (float(times[0]), float(times[-1])) if len(times) else (0.0, 0.0)
    charts = [(chart, [thinned(curve) for curve in chart.curves]) for chart in charts_of(recording, scene)]
    run = {
        "start": round(start, 3),
        "end": round(end, 3),
        "width": round(100.0 * scene.field_size[1]),
        "radius": round(100.0 * scene.piece_radius, 1),
        "robots": [
            {
                "color": _TINT.get(robot.alliance, _TINT[""])[1],
                "length": round(100.0 * robot.bumpers[0]),
                "width": round(100.0 * robot.bumpers[1]),
            }
            for robot in scene.robots
        ],
        "frames": _frames(recording, scene),
        "charts": [
            [{"times": _short(curve.times, 3), "values": _short(curve.values, 3)} for curve in curves]
            for _, curves in charts
        ],
        "plot": _PLOT,
    }
    figures = "\n".join(_figure(chart, start, end) for chart, _ in charts)
    text = _PAGE.format(
        title=escape(title),
        subtitle=f'<p class="note">{escape(subtitle)}</p>' if subtitle else "",
        facts="".join(
            f"<li><span>{escape(name)}</span><b>{escape(value)}</b></li>" for name, value in _facts(recording, scene)
        ),
        field=_field(recording, scene, end),
        key=_key(scene),
        charts=figures,
        style=_HERE.joinpath("page.css").read_text(encoding="utf-8"),
        script=_HERE.joinpath("page.js").read_text(encoding="utf-8"),
        # "</script>" in a name must not end the script that carries it
        run=json.dumps(run, separators=(",", ":"), allow_nan=False).replace("</", "<\\/"),
    )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise output_error("page", path, error) from error


_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<title>{title}</title>
<style>
{style}</style>
</head>
<body>
<h1>{title}</h1>
{subtitle}
<ul class="facts">{facts}</ul>
<div class="field">
{field}
<canvas></canvas>
</div>
<div class="bar" hidden>
<button type="button">Play</button>
<input type="range" aria-label="time">
<output></output>
<select aria-label="speed"><option value="0.25">1/4 x</option><option value="1" selected>1 x</option>
<option value="2">2 x</option><option value="4">4 x</option><option value="16">16 x</option></select>
</div>
<p class="key">{key}</p>
<div class="charts">
{charts}
</div>
<script type="application/json" id="run">{run}</script>
<script>
{script}</script>
</body>
</html>
"""


def _facts(recording: Recording, scene: Scene) -> list[tuple[str, str]]:
    """The numbers that people ask for first."""
    facts: list[tuple[str, str]] = []
    for name, key in (("blue", "Sim/Score/Blue"), ("red", "Sim/Score/Red")):
        if recording.has(key):
            facts.append((f"{name} points", f"{recording.series(key)[1][-1]:.0f}"))
    if scene.shots:
        facts.append(("shots hit", f"{scene.hits} of {len(scene.shots)}"))
    if len(scene.intakes):
        facts.append((f"{scene.piece_name} taken in", str(len(scene.intakes))))
    path = planar(recording, scene.robots[0].pose_key) if scene.robots else np.empty((0, 3))
    if len(path):
        facts.append(("driven", f"{np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).sum():.1f} m"))
    volts = f"{scene.robots[0].prefix}/Debug/BatteryVoltage" if scene.robots else ""
    if recording.has(volts):
        facts.append(("lowest battery", f"{recording.series(volts)[1].min():.2f} V"))
    times = recording.times
    if len(times):
        facts.append(("simulated", f"{times[-1]:.2f} s"))
    return facts


def _frames(recording: Recording, scene: Scene) -> list[dict[str, Any]]:
    """Robots [cm, cm, rad] and what changed among the pieces, so that a page of 20 s is half a megabyte."""
    times = recording.times
    if not len(times):
        return []
    keys = [key for key in recording.keys if key.startswith("Sim/GamePieces/")]
    marks = recording.array_times(keys[0]) if keys else times[:: max(1, len(times) // 300)]
    marks = np.unique(np.append(marks[:: -(-len(marks) // _MOST_FRAMES)], times[-1]))
    robots = []
    for robot in scene.robots:
        if recording.has(robot.pose_key):
            robots.append((recording.poses(robot.pose_key)[0], planar(recording, robot.pose_key)))
        else:
            robots.append((np.empty(0), np.empty((0, 3))))
    before: Counter[int] = Counter()
    frames = []
    for time in marks.tolist():
        now = Counter(_places(recording.places(time)))
        poses: list[list[float] | None] = []
        for at, rows in robots:
            row = int(np.searchsorted(at, time + 1e-9)) - 1
            x, y, yaw = rows[row] if row >= 0 else (math.nan,) * 3
            poses.append([round(100.0 * x, 1), round(100.0 * y, 1), round(float(yaw), 3)] if row >= 0 else None)
        come, gone = now - before, before - now
        frames.append(
            {
                "time": round(time, 3),
                "robots": poses,
                "come": sorted(come.elements()),
                "gone": sorted(gone.elements()),
            }
        )
        before = now
    return frames


def _places(centers: FloatArray) -> list[int]:
    """A whole number per piece: its place to the centimeter, its height to the decimeter; page.js takes them apart."""
    centers = centers[np.isfinite(centers).all(axis=1)]
    x = np.clip(np.rint(100.0 * centers[:, 0]) + 500, 0, 65535).astype(np.int64)
    y = np.clip(np.rint(100.0 * centers[:, 1]) + 500, 0, 2047).astype(np.int64)
    z = np.clip(10.0 * centers[:, 2], 0, 15).astype(np.int64)
    return ((x * 2048 + y) * 16 + z).tolist()  # type: ignore[no-any-return]


def _short(values: FloatArray, digits: int) -> list[float]:
    """Rounded; what is not finite becomes 0, for JSON knows no other numbers."""
    return [
        int(v) if v == int(v) else v for v in np.round(np.nan_to_num(values, posinf=0.0, neginf=0.0), digits).tolist()
    ]


# --- field --------------------------------------------------------------------------------------------------------


def _field(recording: Recording, scene: Scene, end: float) -> str:
    """The field from above in centimeters, with paths and shots; what moves is drawn over it by the script."""
    length, width = (100.0 * size for size in scene.field_size)

    def points(rows: FloatArray) -> str:
        return " ".join(f"{100.0 * x:.0f},{width - 100.0 * y:.0f}" for x, y in rows[:, :2].tolist())

    box = f"{-_MARGIN} {-_MARGIN} {length + 2 * _MARGIN:.0f} {width + 2 * _MARGIN:.0f}"
    parts = [
        f'<svg viewBox="{box}" role="img" aria-label="the field from above">',
        f'<rect width="{length:.0f}" height="{width:.0f}" fill="#d3d6da"/>',
    ]
    for name, corners in scene.field_outlines:
        fill, stroke = _TINT[next((a for a in ("blue", "red") if name.lower().startswith(a)), "")]
        parts.append(
            f'<polygon points="{points(corners)}" fill="{fill}" stroke="{stroke}" opacity=".75">'
            f"<title>{escape(name)}</title></polygon>"
        )
    for robot in scene.robots:
        path = planar(recording, robot.pose_key)
        color = _PATH if len(scene.robots) == 1 else _TINT.get(robot.alliance, _TINT[""])[1]
        step = max(1, len(path) // 1000)
        if len(path):
            way = np.vstack((path[::step], path[-1:]))
            parts.append(
                f'<polyline points="{points(way)}" fill="none" stroke="{color}" stroke-width="4" opacity=".8"/>'
            )
    for shot in scene.shots:
        if len(shot.points):
            color = _HIT if shot.scored else _MISS
            tip = f"{'hit' if shot.scored else 'miss'}, shot at {shot.time:.2f} s by robot {shot.robot}"
            x, y = shot.points[-1, :2]
            parts.append(
                f'<g class="shot"><title>{tip}</title><polyline points="{points(shot.points)}" fill="none" stroke="{color}" '
                f'stroke-width="2" opacity=".6"/><circle cx="{100 * x:.0f}" cy="{width - 100 * y:.0f}" r="5" '
                f'fill="{color}" stroke="#fff"/></g>'
            )
    parts.append('<g class="end">')
    for x, y, _ in recording.places(end).tolist():
        parts.append(
            f'<circle cx="{100 * x:.0f}" cy="{width - 100 * y:.0f}" r="{100 * scene.piece_radius:.1f}" '
            'fill="#ffd923" stroke="#7d6400"/>'
        )
    parts.append("</g></svg>")
    return "\n".join(parts)


def _key(scene: Scene) -> str:
    def line(color: str, text: str) -> str:
        return f'<span><svg><line y1="6" y2="6" x2="20" stroke="{color}" stroke-width="3"/></svg> {escape(text)}</span>'

    misses = len(scene.shots) - scene.hits
    path = [line(_PATH, "path of the robot")] if len(scene.robots) == 1 else []
    return " ".join(
        (
            *path,
            line(_HIT, f"shots that scored ({scene.hits})"),
            line(_MISS, f"shots that missed ({misses})"),
            line("#ffd923", f"{scene.piece_name} (darker and larger: in the air)"),
            "<span>space plays, arrows step, charts follow the pointer</span>",
        )
    )


# --- charts -------------------------------------------------------------------------------------------------------


def _figure(chart: Chart, start: float, end: float) -> str:
    """One chart as SVG, and above it its title and the values at the cursor."""
    low, high = bounds(chart)
    p = _PLOT

    def across(time: float) -> float:
        return p["left"] + (time - start) / ((end - start) or 1.0) * p["width"]

    def down(value: float) -> float:
        return p["top"] + (high - value) / (high - low) * p["height"]

    parts = [f'<svg viewBox="0 0 {p["total"]} {p["bottom"]}">']
    for level in _ticks(low, high, 5):
        y = down(level)
        parts.append(
            f'<line x1="{p["left"]}" x2="{p["left"] + p["width"]}" y1="{y:.1f}" y2="{y:.1f}" stroke="#dfe2e6"/>'
        )
        parts.append(f'<text x="{p["left"] - 5}" y="{y + 4:.1f}" text-anchor="end">{level:g}</text>')
    for time in _ticks(start, end, 7):
        parts.append(f'<text x="{across(time):.1f}" y="{p["bottom"] - 5}" text-anchor="middle">{time:g}</text>')
    if chart.limit is not None and low <= chart.limit <= high:
        y, label = down(chart.limit), escape(f"{chart.limit_label} {chart.limit:g} {chart.unit}")
        parts.append(
            f'<line x1="{p["left"]}" x2="{p["left"] + p["width"]}" y1="{y:.1f}" y2="{y:.1f}" stroke="#20242b" '
            f'stroke-dasharray="4 3"/><text x="{p["left"] + p["width"]}" y="{y - 4:.1f}" text-anchor="end">{label}</text>'
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
    parts.append(
        f'<line class="cursor" visibility="hidden" y1="{p["top"]}" y2="{p["top"] + p["height"]}" stroke="#20242b"/></svg>'
    )
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
