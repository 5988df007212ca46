"""A shooter table as files: CSV, JSON, Python that pastes into robot code, and a picture of what goes in."""

from __future__ import annotations

import csv
import io
import json
import math
import textwrap
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from simcore.shooting.shot_table import Check, ShotBand, ShotTable, ShotTableRow, stretches
from simcore.show.palette import color
from simcore.show.raster import save_drawing, writable_picture
from simcore.show.svg import Axes, document, element, line, nested, words

__all__ = ["draw_bands", "table_csv", "table_json", "table_python"]

_COLUMNS = ("elevation_deg", "hood_turns", "speed_mps", "wheel_rps", "lead_deg", "time_of_flight_s")
"""What robot code needs of a row."""
_Checks = Mapping[int, Check]
_WIDTH, _ABREAST = 1400.0, 4  # [px]
_PANEL = (320.0, 250.0)
_PLOT = (46.0, 26.0, 262.0, 176.0)  # left, top, width, height of the axes in a panel
_MOST = 16  # panels


def _values(row: ShotTableRow, check: Check | None = None) -> dict[str, Any]:
    """A row by the names of its columns, unit and all; None for what there is not."""
    distance, _, radial, tangential = row.stand
    values: dict[str, Any] = {
        "distance_m": distance, "radial_mps": radial, "tangential_mps": tangential, "feasible": not row.problem,
        "problem": row.problem,
    }  # fmt: skip
    for name, number in row.shot.items():
        is_number = isinstance(number, float)
        values[name] = None if is_number and not math.isfinite(number) else round(number, 4) if is_number else number
    for name, share in {"share": row.share, "between": row.between, "check": check and check.found}.items():
        for end, part in (("", "value"), ("_lower", "lower"), ("_upper", "upper"), ("_shots", "n")):
            number = None if share is None else getattr(share, part)
            values[f"{name}{end}"] = round(number, 4) if isinstance(number, float) else number
    values["check_holds"] = check and check.holds
    return values


def table_csv(table: ShotTable, checks: _Checks) -> str:
    """A line a row; what there is not is left empty. Checks are by the number of their row."""
    rows = [_values(row, checks.get(number)) for number, row in enumerate(table.rows)]
    stream = io.StringIO()
    writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue()


def table_json(table: ShotTable, checks: _Checks) -> str:
    """All rows, and what they are of."""
    task = table.task
    head = {
        "game": task.game.name,
        "target": task.zone.name,
        "piece": task.kind.name,
        "wheels": list(task.shooter.wheels),
        "hood": task.shooter.hood,
        "exit_efficiency": task.shooter.exit_efficiency,
        "scatter": table.scatter.text,
    }
    rows = [_values(row, checks.get(number)) for number, row in enumerate(table.rows)]
    return json.dumps({**head, "rows": rows}, indent=1, allow_nan=False) + "\n"


def table_python(table: ShotTable) -> str:
    """A module without imports but `bisect`, whose `shot_at` interpolates between the rows."""
    task, shots, gaps = table.task, "", set()
    for row in table.rows:
        key, shot, note = (row.stand.distance, *row.stand[2:]), None, row.problem
        if row.share is not None:
            values = _values(row)
            shot = tuple(values[name] for name in _COLUMNS)
            bearing = f", off the board: at a bearing of {values['bearing_deg']:.0f} deg alone"
            where = bearing if row.shot["by_board"] else ""
            note = f"{row.share.value:.1%} go in{where}"
        shots += f"    {key!r}: {shot!r},  # {note}\n"
        gaps |= {key} if row.is_gap else set()
    axes = zip(*((row.stand.distance, *row.stand[2:]) for row in table.rows), strict=True)
    distances, radial, tangential = (tuple(sorted(set(axis))) for axis in axes)
    return _MODULE.format(
        target=task.zone.name, game=task.game.name, efficiency=task.shooter.exit_efficiency, columns=_COLUMNS,
        distances=distances, radial=radial, tangential=tangential, shots=shots, gaps=gaps,
    ) + _LOOKUP  # fmt: skip


_MODULE = '''"""Shots at {target} ({game}), made by `simcore shots`; see docs/shots.md.

Shooter with an exit efficiency of {efficiency:g}. Rows with None have no shot.
"""

from bisect import bisect_right

COLUMNS = {columns!r}
"""Of a shot: over the horizontal, the hood's mechanism, of the piece, of the wheels, its direction from
that to the target (counter-clockwise), and from the muzzle to the opening."""
DISTANCES = {distances!r}  # [m] from the robot's middle to the target's
RADIAL = {radial!r}  # [m/s] of the robot toward the target
TANGENTIAL = {tangential!r}  # [m/s] of the robot to the left, looking at the target
SHOTS = {{
{shots}}}
GAPS = {gaps!r}
"""Rows from which on, up to the next distance, shots half way between do not go in as these do."""


'''
_LOOKUP = '''def shot_at(distance, radial=0.0, tangential=0.0):
    """The shot by name of its columns, interpolated; None outside of the table and where it has a gap."""
    corners = [((), 1.0)]
    for axis, value in ((DISTANCES, distance), (RADIAL, radial), (TANGENTIAL, tangential)):
        if not axis[0] <= value <= axis[-1]:
            return None
        low = max(0, min(bisect_right(axis, value) - 1, len(axis) - 2))
        high = min(low + 1, len(axis) - 1)
        share = 0.0 if high == low else (value - axis[low]) / (axis[high] - axis[low])
        ends = ((axis[low], 1.0 - share), (axis[high], share))
        corners = [(key + (end,), weight * part) for key, weight in corners for end, part in ends if part > 0.0]
    shots = [(SHOTS[key], weight) for key, weight in corners]
    if any(shot is None for shot, _ in shots) or (distance not in DISTANCES and any(key in GAPS for key, _ in corners)):
        return None
    return {
        name: None if shots[0][0][k] is None else sum(weight * shot[k] for shot, weight in shots)
        for k, name in enumerate(COLUMNS)
    }
'''


# --- picture ----------------------------------------------------------------------------------------------------------


def draw_bands(path: str | Path, table: ShotTable) -> None:
    """Draw a panel for each row, the first sixteen; missing folders are made.

    Args:
        path: A `.png`, `.svg` or `.pdf` file.
        table: What is drawn.

    Raises:
        OutputError: The picture cannot be written there, or as that kind of file.
    """
    path, task, rows = writable_picture(path), table.task, table.rows[:_MOST]
    low, high = map(math.degrees, task.elevations)
    bands = [row.band for row in rows if row.band is not None]
    drawn = [s for band in bands for s in band.speeds[band.inside.any(axis=0)].tolist()]
    drawn = drawn or [task.min_speed, task.max_speed]
    box = (0.95 * min(drawn), 1.05 * max(drawn), low - 4.0, high + 4.0)
    parts = [
        words(40.0, 44.0, f"Shots that go into {task.zone.name}", 27, ink=color("ink"), bold=True),
        words(40.0, 72.0, "elevation over speed, by distance, from all barrels; cross: the shot of the table; its "
              "arms: how far speed and elevation alone may be off", 15),
    ]  # fmt: skip
    width, height = _PANEL
    for number, row in enumerate(rows):
        y, x = divmod(number, _ABREAST)
        parts.append(nested(_panel(row, box), 40.0 + x * (width + 10.0), 90.0 + y * (height + 14.0), width, height))
    bottom = 100.0 + math.ceil(len(rows) / _ABREAST) * (height + 14.0)
    save_drawing(document((0.0, 0.0, _WIDTH, bottom), *parts), path, round(_WIDTH))


def _panel(row: ShotTableRow, box: tuple[float, float, float, float]) -> str:
    """One row: axes, band and shot."""
    left, top, width, _ = _PLOT
    slow, fast, flat, steep = box
    axes = Axes(_PLOT, (slow, flat), (fast, steep))

    def across(speed: float) -> float:
        return axes.x(min(max(speed, slow), fast))

    def down(elevation_deg: float) -> float:
        return axes.y(min(max(elevation_deg, flat), steep))

    distance, _, radial, tangential = row.stand
    moving = f", moving {radial:g} / {tangential:g} m/s" if radial or tangential else ""
    parts = [words(left, top - 9.0, f"{distance:g} m{moving}", 14, ink=color("ink"), bold=True)]
    parts.append(axes.grid("speed [m/s]", "[deg]", most=(6, 6), is_ruled=True))
    if row.band is not None:
        parts.append(element("g", *_runs(row.band, across, down), fill=color("hit"), opacity=0.45))
    if row.share is not None:
        parts.append(words(left + width, top - 9.0, f"{row.share.value:.1%} go in", 12, anchor="end"))
        shot, look = row.shot, {"stroke": color("ink"), "stroke_width": 1.8}
        x, y = across(shot["speed_mps"]), down(shot["elevation_deg"])
        parts.append(line(across(shot["slowest_mps"]), y, across(shot["fastest_mps"]), y, **look))
        parts.append(line(x, down(shot["flattest_deg"]), x, down(shot["steepest_deg"]), **look))
        parts.append(element("circle", cx=x, cy=y, r=4.0, fill=color("ink")))
    for number, text in enumerate(textwrap.wrap(row.problem, 34, break_long_words=False, break_on_hyphens=False)):
        parts.append(words(left + 0.5 * width, top + 80.0 + 18.0 * number, text, 13, anchor="middle"))
    return document((0.0, 0.0, *_PANEL), *parts)


def _runs(band: ShotBand, across: Callable[[float], float], down: Callable[[float], float]) -> list[str]:
    """A bar for each unbroken stretch of speeds of each elevation that is drawn."""
    bars = []
    half = 0.5 * math.degrees(float(band.elevations[1] - band.elevations[0]))
    for elevation, inside in zip(np.degrees(band.elevations).tolist(), band.inside, strict=True):
        y, bottom = down(elevation + half), down(elevation - half)
        for first, last in stretches(inside) if bottom > y else ():
            start, end = across(float(band.speeds[first])), across(float(band.speeds[last]))
            bars.append(element("rect", x=start, y=y, width=max(1.0, end - start), height=bottom - y))
    return bars
