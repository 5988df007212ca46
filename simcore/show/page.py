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

from simcore.show.charts import charts_of, thinned
from simcore.show.page_svg import PLOT, field_svg, figure_html, key_html
from simcore.show.scene import PieceLook, Scene, tint
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import output_error
from simcore.typing import FloatArray

__all__ = ["write_page"]

_HERE = Path(__file__).parent
_MOST_FRAMES = 800
_PIECES = "Sim/GamePieces/"


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
        "pieces": [
            {
                "isRound": look.size is None,
                "reach": round(100.0 * look.reach, 1),
                "color": look.color,
                "air": look.air_color,
                "edge": look.edge_color,
            }
            for look in map(scene.look, _types(recording))
        ],
        "robots": [
            {
                "color": tint(robot.alliance)[1],
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
        "plot": PLOT,
    }
    figures = "\n".join(figure_html(chart, start, end) for chart, _ in charts)
    text = _PAGE.format(
        title=escape(title),
        subtitle=f'<p class="note">{escape(subtitle)}</p>' if subtitle else "",
        facts="".join(
            f"<li><span>{escape(name)}</span><b>{escape(value)}</b></li>" for name, value in _facts(recording, scene)
        ),
        field=field_svg(recording, scene, end),
        key=key_html(scene),
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
    """Score, shots, distance, lowest voltage and duration."""
    facts: list[tuple[str, str]] = []
    for name, key in (("blue", "Sim/Score/Blue"), ("red", "Sim/Score/Red")):
        if recording.has(key):
            facts.append((f"{name} points", f"{recording.series(key)[1][-1]:.0f}"))
    if scene.shots:
        facts.append(("shots hit", f"{scene.hits} of {len(scene.shots)}"))
    elif recording.has("Sim/Shots") and recording.has("Sim/Hits"):
        hits, shots = (recording.series(key)[1][-1] for key in ("Sim/Hits", "Sim/Shots"))
        facts.append(("shots hit", f"{hits:.0f} of {shots:.0f}"))
    if len(scene.intakes):
        facts.append((f"{scene.piece_names} taken in", str(len(scene.intakes))))
    whose = " by robot 0" if len(scene.robots) > 1 else ""
    path = recording.path(scene.robots[0].pose_key) if scene.robots else np.empty((0, 3))
    if len(path):
        facts.append((f"driven{whose}", f"{np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).sum():.1f} m"))
    volts = f"{scene.robots[0].prefix}/Debug/BatteryVoltage" if scene.robots else ""
    if recording.has(volts):
        facts.append(
            (f"battery{whose.replace('by', 'of')}, lowest of all ticks", f"{recording.series(volts)[1].min():.2f} V")
        )
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
            robots.append((recording.poses(robot.pose_key)[0], recording.path(robot.pose_key)))
        else:
            robots.append((np.empty(0), np.empty((0, 3))))
    types = _types(recording)
    before: Counter[int] = Counter()
    frames = []
    for time in marks.tolist():
        pieces = recording.pieces_at(time)
        now = Counter(
            code for kind, name in enumerate(types) for code in _piece_codes(pieces[name], scene.look(name), kind)
        )
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


def _types(recording: Recording) -> list[str]:
    """Types of pieces in the order of their numbers in the page."""
    return [key.removeprefix(_PIECES) for key in recording.keys if key.startswith(_PIECES)]


def _piece_codes(rows: FloatArray, look: PieceLook, kind: int) -> list[int]:
    """A whole number below 2^53 for each piece; page.js takes it apart.

    From the lowest bit: height in decimeters (4 bits), y and x in centimeters and 500 (11 and 16), number of the type
    (4), and of a box its outline: heading in 64ths of half a turn, width and length in 63rds of twice the reach (6
    bits each).
    """
    rows = rows[np.isfinite(rows).all(axis=1)]
    x = np.clip(np.rint(100.0 * rows[:, 0]) + 500, 0, 65535).astype(np.int64)
    y = np.clip(np.rint(100.0 * rows[:, 1]) + 500, 0, 2047).astype(np.int64)
    z = np.clip(10.0 * rows[:, 2], 0, 15).astype(np.int64)
    outline = np.zeros(len(rows), dtype=np.int64)
    if look.size is not None:
        length, width, heading = look.rectangles(rows).T
        across, along = (np.rint(63.0 * size / (2.0 * look.reach)).astype(np.int64) for size in (width, length))
        outline = (along * 64 + across) * 64 + np.rint(64.0 * heading / np.pi).astype(np.int64) % 64
    codes: list[int] = ((((outline * 16 + kind % 16) * 65536 + x) * 2048 + y) * 16 + z).tolist()
    return codes


def _short(values: FloatArray, digits: int) -> list[float]:
    """Rounded; what is not finite becomes 0, for JSON knows no other numbers."""
    return [
        int(v) if v == int(v) else v for v in np.round(np.nan_to_num(values, posinf=0.0, neginf=0.0), digits).tolist()
    ]
