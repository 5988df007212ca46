"""A run as one HTML file: it plays the run, and needs nothing but a browser.

Field, pieces, robots and curves are drawn here, by the same code as pictures and animations; a script in the page moves
and shows them. Nothing is loaded from anywhere, and the page forbids itself to.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from simcore.show.charts import PLOT, Chart, chart_drawing, charts_of, thinned
from simcore.show.field_drawing import FieldDrawing, side_view
from simcore.show.match_tables import RobotRow, cycles_html, period_rows, periods_html, robot_rows, use_rows
from simcore.show.palette import css_variables
from simcore.show.picture import legend
from simcore.show.place_board import PlaceBoard
from simcore.show.robot_side import robot_side
from simcore.show.run_events import BoardItem, RunEvent, board_of, ending_of, events_of, phases_of
from simcore.show.run_track import RunTrack, Table
from simcore.show.scene import Scene
from simcore.show.shots import intake_places, shot_rows, shots_of
from simcore.show.svg import document
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import write_text
from simcore.typing import FloatArray

__all__ = ["page_style", "write_page"]

_HERE = Path(__file__).parent
_MOST_FRAMES = 800
_MARKS = {
    "mode": "\u25b6", "put": "\u21e9", "hit": "\u25cf", "miss": "\u2715", "flying": "\u25cb", "score": "\u002b",
    "slip": "\u2248", "bump": "\u25b2", "brown-out": "\u25bc", "foul": "\u25c6", "placed": "\u25a3",
}  # fmt: skip
_ROWS = ("mode put", "hit miss flying", "placed score foul", "slip bump brown-out")
"""Of the time line, by the kinds of their events."""


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
    track = RunTrack(recording, scene)
    shots = shots_of(recording, scene)
    field = FieldDrawing(track, shots)
    events = events_of(recording, scene, shots)
    start, end = track.span
    charts = charts_of(track)
    board, places = board_of(recording), PlaceBoard(recording, scene)
    taken = intake_places(recording)
    robots = robot_rows(track, shots) if len(scene.robots) > 1 else []  # one robot's way and shots are told anyway
    frames, tables = _frames(track)
    side = robot_side(track, track.frame_times(_MOST_FRAMES))
    heat = field.heat_maps()
    layers = "".join(
        f'<g class="heat" data-heat="{name}" visibility="hidden">{cells}</g>' for name, cells in heat.items()
    )
    counts = places.field_counts(start, field.width)
    still = "".join((field.ground(), layers, field.paths(), field.intake_marks(taken), field.shot_traces()))
    run = {
        "start": round(start, 3),
        "end": round(end, 3),
        "height": round(field.width),
        "kinds": [track.kinds.count(kind) for kind in range(len(track.types))],
        "round": [scene.look(name).size is None for name in track.types],
        "first": [[row, *values] for row, values in enumerate(tables.tolist())],
        "frames": frames,
        "board": [
            [[round(time, 2), text] for time, text in zip(item.times, item.texts, strict=True)] for item in board
        ],
        "phases": phases_of(recording),
        "cells": {name: [[round(time, 2), count] for time, count in cell] for name, cell in places.steps().items()},
        "side": side and side[1],
        "charts": [_curve_data(chart) for chart in charts],
        "plot": PLOT,
    }
    from_side = side_view(scene, shots)
    text = _PAGE.format(
        title=escape(title),
        subtitle="".join(f'<p class="note">{escape(text)}</p>' for text in (subtitle, *ending_of(recording)) if text),
        facts="".join(
            f"<li><span>{escape(name)}</span><b>{escape(value)}</b></li>" for name, value in _facts(track)
        ),
        board="".join(_board_html(item, start) for item in board),
        field=field.drawing(field.symbols(), still, f'<g id="now">{field.moment(start)}</g>', counts),
        heat="".join(f'<label><input type="checkbox" data-heat="{name}"> heat map: {name}</label>' for name in heat),
        places=(_ROBOT.format(" 0" if len(scene.robots) > 1 else "", side[0]) if side else "")
        + "".join(_places_html(places, alliance, start) for alliance in places.alliances),
        timeline=_timeline_html(events, start, end),
        key=_key_html(field, len(taken)),
        events=_events_html(events),
        periods=periods_html(period_rows(track, shots)) if robots else "",
        cycles=cycles_html(robots),
        shots=_shots_html(track, shots, robots),
        side=_SIDE.format(from_side) if from_side else "",
        charts="\n".join(_figure_html(chart, start, end) for chart in charts),
        style=page_style(),
        script="".join(_HERE.joinpath(name).read_text(encoding="utf-8") for name in ("match_sounds.js", "page.js")),
        # neither "</script>" nor "<!--<script>" in a name may end the script that carries it, or keep it from ending
        run=json.dumps(run, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
    )  # fmt: skip
    write_text("page", path, text)


def page_style() -> str:
    """The style sheet of all pages, with the colors for light and dark."""
    return css_variables() + _HERE.joinpath("page.css").read_text(encoding="utf-8")


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
<ul class="board" aria-label="score board">{board}
<li class="off" hidden><span>pose estimate off by</span><b></b></li></ul>
<div class="field">
{field}
</div>
<div class="bar" hidden>
<button type="button" id="play" aria-label="play or pause (space)">Play</button>
<input type="range" aria-label="time (arrow keys; home and end)">
<output></output>
<select aria-label="speed"><option value="0.25">0.25x</option><option value="0.5">0.5x</option>
<option value="1" selected>1x</option><option value="2">2x</option><option value="4">4x</option></select>
</div>
{timeline}
<div class="places">{places}</div>
<div class="key">{key}{heat}<span class="keys" hidden>keys: <kbd>space</kbd> plays, <kbd>&larr;</kbd>
<kbd>&rarr;</kbd> step 0.1 s (with <kbd>shift</kbd> 1 s), <kbd>home</kbd> <kbd>end</kbd></span></div>
<div class="tables">{periods}{shots}{cycles}{events}</div>
<div class="charts">
{side}
{charts}
</div>
<script type="application/json" id="run">{run}</script>
<script>
{script}</script>
</body>
</html>
"""


_SIDE = '<figure class="side"><figcaption><strong>Shots from the side</strong></figcaption>{}</figure>'


_ROBOT = """<figure class="of-robot" hidden>
<figcaption><strong>Robot{} from its right</strong><span></span></figcaption>{}</figure>"""


def _facts(track: RunTrack) -> list[tuple[str, str]]:
    """What the whole run came to."""
    recording, scene = track.recording, track.scene

    def last(key: str) -> float | None:
        return float(recording.series(key)[1][-1]) if recording.has(key) and len(recording.series(key)[1]) else None

    facts = []
    for alliance in ("Blue", "Red", "Old", "New"):
        points = last(f"Sim/Score/{alliance}")
        if points is not None:
            facts.append((f"score {alliance.lower()}", f"{points:.0f}"))
    shots, hits, taken = (last(f"Sim/{name}") for name in ("Shots", "Hits", "TakenIn"))
    if shots and hits is not None:
        facts.append(("shots hit", f"{hits:.0f} of {shots:.0f}"))
    if taken:
        facts.append((f"{scene.piece_names} taken in", f"{taken:.0f}"))
    several = len(scene.robots) > 1
    if scene.robots:
        prefix = scene.robots[0].prefix
        driven, volts, offs = (
            last(f"{prefix}/{key}") for key in ("Robot/DistanceDriven", "Debug/BatteryVoltageLowest", "Debug/Brownouts")
        )
        if driven is not None:
            facts.append((f"driven{' by robot 0' if several else ''}", f"{driven:.1f} m"))
        whose = " of robot 0" if several else ""
        if volts is not None:
            facts.append((f"lowest battery voltage{whose}", f"{volts:.2f} V"))
        if offs:
            facts.append((f"brown-outs{whose}", f"{offs:.0f}"))
    if len(recording):
        facts.append(("simulated", f"{track.span[1]:.2f} s"))
    return facts


def _frames(track: RunTrack) -> tuple[list[dict[str, Any]], Table]:
    """Robots, and what changed among the pieces, so that a page of 20 s is half a megabyte; and the first table.

    A piece that changed is `row, holder, x, y, scale_x, scale_y, angle, in_air` of `Placed`; of a ball, whose symbol
    needs no more, `row, holder, x, y, scale, in_air`; of one that is nowhere any more `row, -1`.
    """
    first = before = track.table(track.span[0])
    frames = []
    kinds = np.array(track.kinds)
    is_round = np.array([track.scene.look(name).size is None for name in track.types] or [True])
    for time in track.frame_times(_MOST_FRAMES):
        table = track.table(time)
        moved = []
        for row in np.nonzero((table != before).any(axis=1))[0].tolist():
            holder, x, y, scale_x, scale_y, angle, in_air = table[row].tolist()
            if holder < 0:
                moved.append([row, holder])
            elif is_round[kinds[row]]:
                moved.append([row, holder, x, y, scale_x, in_air])
            else:
                moved.append([row, holder, x, y, scale_x, scale_y, angle, in_air])
        robots = range(len(track.robots))
        frames.append(
            {
                "time": round(time, 3),
                "robots": [_pose(track.robot_at(number, time)) for number in robots],
                "ghosts": [_pose(track.robot_at(number, time, estimate=True)) for number in robots],
                "active": [int(track.intake_is_active(number, time)) for number in robots],
                "moved": moved,
            }
        )
        before = table
    return frames, first


def _pose(pose: tuple[float, float, float] | None) -> list[float] | None:
    """In centimeters and radians."""
    return None if pose is None else [round(100.0 * pose[0], 1), round(100.0 * pose[1], 1), round(pose[2], 3)]


def _curve_data(chart: Chart) -> list[dict[str, list[float]]]:
    return [{"times": _short(thin.times, 3), "values": _short(thin.values, 3)} for thin in map(thinned, chart.curves)]


def _figure_html(chart: Chart, start: float, end: float) -> str:
    """One chart, and above it its title and the values at the cursor."""
    caption = [f"<strong>{escape(chart.title)} [{escape(chart.unit)}]</strong>"]
    for curve in chart.curves:
        dashes = f' stroke-dasharray="{curve.dashes}"' if curve.dashes else ""
        mark = f'<svg viewBox="0 0 20 6"><path d="M0 3h20" stroke="{curve.color}" stroke-width="2.5"{dashes}/></svg>'
        caption.append(f'<span>{mark} {escape(curve.label)} <span class="value"></span></span>')
    drawing = chart_drawing(chart, start, end)
    return f'<figure class="chart"><figcaption>{"".join(caption)}</figcaption>{drawing}</figure>'


def _places_html(places: PlaceBoard, alliance: str, time: float) -> str:
    heading = f"<figcaption><strong>{escape(places.heading(alliance))}</strong></figcaption>"
    return f"<figure>{heading}{places.board(alliance, time)}</figure>"


def _key_html(field: FieldDrawing, taken: int) -> str:
    marks = legend(field, intakes=taken)
    return "".join(f"<span>{document((-14, -8, 32, 16), mark)} {escape(words)}</span>" for mark, words in marks)


def _timeline_html(events: Sequence[RunEvent], start: float, end: float) -> str:
    """Rows of marks over the time; each is a button that goes there."""
    rows = []
    for kinds in _ROWS:
        mine = [event for event in events if event.kind in kinds.split()]
        marks = []
        for event in mine:
            at = 100.0 * (event.time - start) / ((end - start) or 1.0)
            tip = escape(f"{event.time:.2f} s: {event.text}")
            marks.append(
                f'<button type="button" tabindex="-1" class="{event.kind}" style="left:{at:.2f}%" title="{tip}" '
                f'data-to="{event.time:.2f}">{_MARKS[event.kind]}</button>'
            )
        if mine:
            rows.append(f'<div class="row"><span>{_row_name(kinds, mine)}</span><div>{"".join(marks)}</div></div>')
    return f'<div class="timeline" aria-hidden="true">{"".join(rows)}</div>' if rows else ""


def _row_name(kinds: str, events: Sequence[RunEvent]) -> str:
    """Those of a row's kinds that there are."""
    return ", ".join(kind for kind in kinds.split() if any(event.kind == kind for event in events))


def _events_html(events: Sequence[RunEvent]) -> str:
    """The same as a list, for readers without a pointer."""
    if not events:
        return ""
    lines = "".join(
        f'<li><button type="button" data-to="{event.time:.2f}">{event.time:.2f} s</button> '
        f'<span class="{event.kind}" aria-hidden="true">{_MARKS[event.kind]}</span> {escape(event.text)}</li>'
        for event in events
    )
    return f"<details><summary>Events ({len(events)})</summary><ol>{lines}</ol></details>"


def _shots_html(track: RunTrack, shots: Sequence[Any], robots: Sequence[RobotRow]) -> str:
    """Shots by robot, and in a run of several robots where the seconds of each went."""
    if not shots:
        return ""
    count = len(track.scene.robots)
    heads = "".join(f"<th scope=col>{f'robot {number}' if count > 1 else 'all'}</th>" for number in range(count))
    rows = "".join(
        f"<tr><th scope=row>{escape(name)}</th>{''.join(f'<td>{escape(value)}</td>' for value in values)}</tr>"
        for name, values in [*shot_rows(shots, count), *(use_rows(robots) if robots else [])]
    )
    name, kind = (f"Robots, {len(shots)} shots", "shots several") if robots else (f"Shots ({len(shots)})", "shots")
    return (
        f'<details open class="{kind}"><summary>{name}</summary><div class="wide"><table>'
        f"<thead><tr><td></td>{heads}</tr></thead><tbody>{rows}</tbody></table></div></details>"
    )


def _board_html(item: BoardItem, time: float) -> str:
    kind = item.label if item.label in ("blue", "red", "period") else "other"
    return f'<li class="{kind}"><span>{escape(item.label)}</span><b>{escape(item.at(time))}</b></li>'


def _short(values: FloatArray, digits: int) -> list[float]:
    """Rounded; what is not finite becomes 0, for JSON knows no other numbers."""
    found = np.round(np.nan_to_num(values, posinf=0.0, neginf=0.0), digits).tolist()
    return [int(value) if math.isfinite(value) and value == int(value) else value for value in found]
