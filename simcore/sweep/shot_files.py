"""Conversion of a shot table to CSV, to a Python module for robot code, and to an HTML page with charts."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from simcore.match.scatter import Scatter
from simcore.show.report import chart, headline, report_page, series, table
from simcore.sweep.shot_table import ShotTable, ShotTableRow

__all__ = ["table_cells", "table_csv", "table_page", "table_python"]

_COLUMNS = ("elevation_deg", "hood_turns", "speed_mps", "wheel_rps", "time_of_flight_s")
"""Columns of the Python module for robot code."""


def _values(row: ShotTableRow) -> dict[str, Any]:
    """Return the values of a row by column name, rounded to four decimals; None for missing values."""
    values = {
        "distance_m": row.stand.distance, "feasible": not row.problem, "problem": row.problem, **row.shot,
        "share": row.share,
    }  # fmt: skip
    return {name: round(value, 4) if isinstance(value, float) else value for name, value in values.items()}


def table_csv(shots: ShotTable) -> str:
    """Return the table as CSV text with a header line and one line per row; missing values are empty."""
    rows = [_values(row) for row in shots.rows]
    stream = io.StringIO()
    writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue()


def table_cells(shots: ShotTable) -> tuple[list[str], list[list[str]]]:
    """Return the column headers, and the cells of each row as text, for the console and the page."""
    heads = [
        "distance",
        "elevation",
        "hood",
        "speed",
        "wheels",
        "flight",
        "speed may be",
        "elevation may be",
        "goes in",
    ]
    lines = []
    for row in shots.rows:
        shot, line = row.shot, [f"{row.stand.distance:g} m"]
        if row.share is None:
            line += [row.problem]
        else:
            speed, elevation = shot["speed_mps"], shot["elevation_deg"]
            line += [
                f"{elevation:.1f} deg",
                "" if shot["hood_turns"] is None else f"{360.0 * shot['hood_turns']:.1f} deg",
                f"{speed:.2f} m/s",
                f"{shot['wheel_rps']:.1f} turns/s",
                f"{shot['time_of_flight_s']:.2f} s",
                " ".join(f"{shot[end] / speed - 1.0:+.0%}" for end in ("slowest_mps", "fastest_mps")),
                " ".join(f"{shot[end] - elevation:+.0f}" for end in ("flattest_deg", "steepest_deg")) + " deg",
                f"{row.share:.1%}",
            ]
        lines.append(line + [""] * (len(heads) - len(line)))
    return heads, lines


def table_python(shots: ShotTable) -> str:
    """Return the text of a Python module with the table and a function `shot_at`, which interpolates between rows."""
    task, lines = shots.task, ""
    for row in shots.rows:
        values = _values(row)
        shot = None if row.share is None else tuple(values[name] for name in _COLUMNS)
        note = row.problem if row.share is None else f"{row.share:.1%} go in"
        lines += f"    {row.stand.distance!r}: {shot!r},  # {note}\n"
    return _MODULE.format(
        target=task.zone.name, game=task.game.name, efficiency=task.shooter.exit_efficiency, columns=_COLUMNS,
        shots=lines,
    )  # fmt: skip


_MODULE = '''"""Shots at {target} ({game}), made by `simcore shots`; see docs/shots.md.

Shooter with an exit efficiency of {efficiency:g}. Rows with None have no shot.
"""

from bisect import bisect_right

COLUMNS = {columns!r}
"""Elevation above the horizontal, turns of the hood's mechanism, speeds of the piece and of the wheels, and time
from the muzzle to the opening."""
SHOTS = {{  # by distance from the robot's center to the target's [m]
{shots}}}


def shot_at(distance):
    """Return the shot by name of its columns, interpolated; None outside the table or next to a row without a shot."""
    distances = list(SHOTS)
    if not distances[0] <= distance <= distances[-1]:
        return None
    high = min(bisect_right(distances, distance), len(distances) - 1)
    low = max(0, high - 1)
    share = 0.0 if high == low else (distance - distances[low]) / (distances[high] - distances[low])
    near, far = SHOTS[distances[low]], SHOTS[distances[high]]
    if share == 0.0:
        far = near
    if near is None or far is None:
        return None
    mixed = [None if a is None else a + share * (b - a) for a, b in zip(near, far)]
    return dict(zip(COLUMNS, mixed))
'''


# --- page -------------------------------------------------------------------------------------------------------------


def table_page(shots: ShotTable) -> str:
    """Return an HTML page with the shot that has the largest margin, the table, and curves over distance."""
    task, good = shots.task, shots.feasible
    blocks: list[Mapping[str, object]] = []
    if good:
        best = max(good, key=lambda row: row.shot["margin_sd"])
        text = f"{best.shot['wheel_rps']:.0f} turns/s from {best.stand.distance:g} m"
        tilt = f"{best.shot['elevation_deg']:.1f} deg, {best.shot['speed_mps']:.2f} m/s"
        detail = f"the shot with the best margin, {best.shot['margin_sd']:.1f} standard deviations: {tilt}"
        blocks.append(headline(text, f"{detail}; {best.share:.1%} of scattered shots go in"))
    else:
        blocks.append(headline("No shot goes in", "the table says why"))
    heads, lines = table_cells(shots)
    blocks.append(table(heads, lines, f"Shots at {task.zone.name} with all {len(task.barrels)} barrels"))
    blocks += _curves(good)
    spreads = "the default scatter" if shots.scatter == Scatter() else f"scatter {shots.scatter.text}"
    subtitle = f"{task.game.heading}, {task.kind.name.lower()}, {spreads}"
    return report_page(f"Shots at {task.zone.name}", blocks, subtitle=subtitle)


def _curves(good: Sequence[ShotTableRow]) -> Iterator[Mapping[str, object]]:
    """Yield charts over distance: speed, elevation, wheel speed, and the percentage of scattered shots that go in."""
    if not good:
        return
    at = [row.stand.distance for row in good]
    for title, unit, name, low, high in (
        ("Speed of the shot and what still goes in", "m/s", "speed_mps", "slowest_mps", "fastest_mps"),
        ("Elevation and what still goes in", "deg", "elevation_deg", "flattest_deg", "steepest_deg"),
        ("Wheels", "turns/s", "wheel_rps", "", ""),
    ):
        least, most = ([row.shot[end] for row in good] if end else None for end in (low, high))
        curve = series("", at, [row.shot[name] for row in good], low=least, high=most)
        yield chart(title, [curve], x_label="distance [m]", y_label=unit)
    share = series("", at, [100.0 * (row.share or 0.0) for row in good], kind="dots")
    yield chart("Scattered shots that go in", [share], x_label="distance [m]", y_label="%", from_zero=True)
