"""A shooter table as files: CSV, Python that pastes into robot code, and a page with charts."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from simcore.match.scatter import Scatter
from simcore.shooting.shot_table import ShotTable, ShotTableRow
from simcore.show.report import chart, headline, heat, paragraph, report_page, series, table

__all__ = ["table_cells", "table_csv", "table_page", "table_python"]

_COLUMNS = ("elevation_deg", "hood_turns", "speed_mps", "wheel_rps", "lead_deg", "time_of_flight_s")
"""Columns of a row that robot code needs."""
_MOST_BANDS = 16  # on the page
_EDGE = 3  # cells around what goes in


def _values(row: ShotTableRow) -> dict[str, Any]:
    """Return a row by the names of its columns, unit and all; None for what there is not."""
    distance, _, radial, tangential = row.stand
    values: dict[str, Any] = {
        "distance_m": distance, "radial_mps": radial, "tangential_mps": tangential, "feasible": not row.problem,
        "problem": row.problem, **row.shot, "share": row.share, "between": row.between,
    }  # fmt: skip
    for name, value in values.items():
        if isinstance(value, float):
            values[name] = round(value, 4) if math.isfinite(value) else None
    return values


def table_csv(shots: ShotTable) -> str:
    """Return a line a row; what there is not is left empty."""
    rows = [_values(row) for row in shots.rows]
    stream = io.StringIO()
    writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue()


def table_cells(shots: ShotTable) -> tuple[list[str], list[list[str]]]:
    """Return heads and cells of the table as people read it, on the console and on the page."""
    is_moving = any(row.stand.radial or row.stand.tangential for row in shots.rows)
    heads = ["distance", *(["radial", "tangential"] if is_moving else []), "elevation", "hood", "speed", "wheels"]
    heads += [*(["lead"] if is_moving else []), "flight", "speed may be", "elevation may be", "goes in", "between"]
    lines = []
    for row in shots.rows:
        (distance, _, radial, tangential), shot = row.stand, row.shot
        line = [f"{distance:g} m", *([f"{radial:g} m/s", f"{tangential:g} m/s"] if is_moving else [])]
        if row.share is None:
            line += [row.problem]
        else:
            speed, elevation = shot["speed_mps"], shot["elevation_deg"]
            line += [
                f"{elevation:.1f} deg",
                "" if shot["hood_turns"] is None else f"{360.0 * shot['hood_turns']:.1f} deg",
                f"{speed:.2f} m/s",
                f"{shot['wheel_rps']:.1f} turns/s",
                *([f"{shot['lead_deg']:.1f} deg"] if is_moving else []),
                f"{shot['time_of_flight_s']:.2f} s",
                " ".join(f"{shot[end] / speed - 1.0:+.0%}" for end in ("slowest_mps", "fastest_mps")),
                " ".join(f"{shot[end] - elevation:+.0f}" for end in ("flattest_deg", "steepest_deg")) + " deg",
                f"{row.share:.1%}",
                "" if row.between is None else f"{row.between:.1%}",
            ]
        lines.append(line + [""] * (len(heads) - len(line)))
    return heads, lines


def table_python(shots: ShotTable) -> str:
    """Return a module without imports but `bisect`, whose `shot_at` interpolates between the rows."""
    task, lines, gaps = shots.task, "", set()
    for row in shots.rows:
        key, shot, note = (row.stand.distance, *row.stand[2:]), None, row.problem
        if row.share is not None:
            values = _values(row)
            shot = tuple(values[name] for name in _COLUMNS)
            note = f"{row.share:.1%} go in"
        lines += f"    {key!r}: {shot!r},  # {note}\n"
        gaps |= {key} if row.is_gap else set()
    axes = zip(*((row.stand.distance, *row.stand[2:]) for row in shots.rows), strict=True)
    distances, radial, tangential = (tuple(sorted(set(axis))) for axis in axes)
    return _MODULE.format(
        target=task.zone.name, game=task.game.name, efficiency=task.shooter.exit_efficiency, columns=_COLUMNS,
        distances=distances, radial=radial, tangential=tangential, shots=lines, gaps=gaps,
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


# --- page -------------------------------------------------------------------------------------------------------------


def table_page(shots: ShotTable) -> str:
    """Return the page: the row with the best margin, the table, curves over distance, and what goes in of each row."""
    task, good = shots.task, shots.feasible
    blocks: list[Mapping[str, object]] = []
    if good:
        best = max(good, key=lambda row: row.shot["margin_sd"])
        text = f"{best.shot['wheel_rps']:.0f} turns/s from {best.stand.distance:g} m{_motion(best)}"
        tilt = f"{best.shot['elevation_deg']:.1f} deg, {best.shot['speed_mps']:.2f} m/s"
        detail = f"the shot with the best margin, {best.shot['margin_sd']:.1f} standard deviations: {tilt}"
        blocks.append(headline(text, f"{detail}; {best.share:.1%} of scattered shots go in"))
    else:
        blocks.append(headline("No shot goes in", "the table says why"))
    heads, lines = table_cells(shots)
    blocks.append(table(heads, lines, f"Shots at {task.zone.name} with all {len(task.barrels)} barrels"))
    blocks += _curves(good)
    bands = [row for row in shots.rows if row.band is not None and row.band.inside.any()][:_MOST_BANDS]
    if bands:
        blocks.append(paragraph("What goes in from each distance, by elevation and speed; the cross is the shot."))
    blocks += [_band(row) for row in bands]
    spreads = "the default scatter" if shots.scatter == Scatter() else f"scatter {shots.scatter.text}"
    subtitle = f"{task.game.heading}, {task.kind.name.lower()}, {spreads}"
    return report_page(f"Shots at {task.zone.name}", blocks, subtitle=subtitle)


def _motion(row: ShotTableRow) -> str:
    _, _, radial, tangential = row.stand
    return f", moving {radial:g} / {tangential:g} m/s" if radial or tangential else ""


def _curves(good: Sequence[ShotTableRow]) -> Iterator[Mapping[str, object]]:
    """Make charts over distance with a curve for each velocity of the robot."""
    rows = sorted(good, key=lambda row: (row.stand[2:], row.stand.distance))
    moving = [list(some) for _, some in groupby(rows, key=lambda row: row.stand[2:])]
    for title, unit, name, low, high in (
        ("Speed of the shot", "m/s", "speed_mps", "slowest_mps", "fastest_mps"),
        ("Elevation", "deg", "elevation_deg", "flattest_deg", "steepest_deg"),
        ("Wheels", "turns/s", "wheel_rps", "", ""),
    ):
        curves = []
        for some in moving if len(good) > 1 else ():
            x, y = [row.stand.distance for row in some], [row.shot[name] for row in some]
            least, most = ([row.shot[end] for row in some] if end else None for end in (low, high))
            curves.append(series(_motion(some[0]).removeprefix(", "), x, y, low=least, high=most))
        if curves:
            yield chart(
                f"{title}{' and what still goes in' if low else ''}", curves, x_label="distance [m]", y_label=unit
            )
    names = [f"{row.stand.distance:g} m{_motion(row)}" for row in rows]
    if rows:
        share = series("", range(len(rows)), [100.0 * (row.share or 0.0) for row in rows], kind="bars")
        yield chart("Scattered shots that go in", [share], x_names=names, y_label="%")


def _band(row: ShotTableRow) -> Mapping[str, object]:
    """Make the map of what goes in, cut to it and its surroundings."""
    band = row.band
    assert band is not None
    up, across = (np.nonzero(band.inside.any(axis=axis))[0] for axis in (1, 0))
    tall, wide = (slice(max(0, some[0] - _EDGE), some[-1] + _EDGE + 1) for some in (up, across))
    cells = np.where(band.inside[tall, wide], 1.0, math.nan)
    shot = [] if row.problem else [(row.speed, math.degrees(row.elevation), "")]
    return heat(
        f"{row.stand.distance:g} m{_motion(row)}", band.speeds[wide].round(4).tolist(),
        np.degrees(band.elevations[tall]).round(3).tolist(), list(cells), x_label="speed [m/s]",
        y_label="elevation [deg]", marks=shot, has_scale=False,
    )  # fmt: skip
