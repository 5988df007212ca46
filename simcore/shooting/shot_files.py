"""A shooter table as files: CSV, JSON, and Python that pastes into robot code."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from simcore.shooting.shot_check import FlightCheck
from simcore.shooting.shot_table import ShotTable, ShotTableRow

__all__ = ["table_csv", "table_json", "table_python"]

_KEPT = 0.9
"""Half way between two rows at least this part of the worse of their shares must go in; else there is a gap."""
_COLUMNS = ("elevation_deg", "hood_turns", "speed_mps", "wheel_rps", "lead_deg", "time_of_flight_s")
"""What robot code needs of a row."""


_UNITS = {"rad": ("deg", 180.0 / math.pi), "m/s": ("mps", 1.0), "m": ("m", 1.0), "s": ("s", 1.0), "sd": ("sd", 1.0)}
_VALUES = (
    ("bearing", "rad"), ("elevation", "rad"), ("hood", "turns"), ("speed", "m/s"), ("wheel", "rps"), ("lead", "rad"),
    ("time_of_flight", "s"), ("entry_angle", "rad"), ("by_board", ""), ("slowest", "m/s"), ("fastest", "m/s"),
    ("flattest", "rad"), ("steepest", "rad"), ("margin", "sd"),
)  # fmt: skip
"""Attributes of a row, and their units there or, of what turns, in the file."""


def row_values(row: ShotTableRow, check: FlightCheck | None = None) -> dict[str, Any]:
    """A row by the names of its columns, unit and all; None for what there is not."""
    values: dict[str, Any] = {
        "distance_m": row.distance,
        "radial_mps": row.radial,
        "tangential_mps": row.tangential,
        "feasible": row.is_feasible,
        "problem": row.problem,
    }
    for name, unit in _VALUES:
        number = getattr(row, "wheel_speed" if name == "wheel" else name)
        suffix, factor = _UNITS.get(unit, (unit, 1.0 / math.tau))
        if isinstance(number, float):
            number = round(number * factor, 4) if math.isfinite(number) else None
        values[f"{name}_{suffix}" if suffix else name] = number if row.is_feasible else None
    shares = {"share": row.share, "between": row.between, "check": None if check is None else check.found}
    for name, share in shares.items():
        for end, part in (("", "value"), ("_lower", "lower"), ("_upper", "upper")):
            values[f"{name}{end}"] = None if share is None else round(getattr(share, part), 4)
        values[f"{name}_shots"] = None if share is None else share.n
    values["check_holds"] = None if check is None else check.holds
    return values


def _rows(table: ShotTable, checks: Sequence[FlightCheck]) -> list[dict[str, Any]]:
    of_row = {id(check.row): check for check in checks}
    return [row_values(row, of_row.get(id(row))) for row in table.rows]


def table_csv(table: ShotTable, checks: Sequence[FlightCheck] = ()) -> str:
    """A line a row; what there is not is left empty."""
    rows = _rows(table, checks)
    stream = io.StringIO()
    writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue()


def table_json(table: ShotTable, checks: Sequence[FlightCheck] = ()) -> str:
    """All rows, and what they are of."""
    return json.dumps({**_head(table), "rows": _rows(table, checks)}, indent=1, allow_nan=False) + "\n"


def _head(table: ShotTable) -> dict[str, Any]:
    task = table.task
    return {
        "game": task.game.name,
        "target": task.zone.name,
        "piece": task.kind.name,
        "wheels": list(task.shooter.wheels),
        "hood": task.shooter.hood,
        "exit_efficiency": task.shooter.exit_efficiency,
        "scatter": table.scatter.text,
    }


def table_python(table: ShotTable) -> str:
    """A module without imports but `bisect`, whose `shot_at` interpolates between the rows."""
    head = _head(table)
    axes: Mapping[str, list[float]] = {
        "DISTANCES": sorted({row.distance for row in table.rows}),
        "RADIAL": sorted({row.radial for row in table.rows}),
        "TANGENTIAL": sorted({row.tangential for row in table.rows}),
    }
    lines = [
        f'"""Shots at {head["target"]} ({head["game"]}), made by `simcore shots`; see docs/shots.md.',
        "",
        f"Shooter with an exit efficiency of {head['exit_efficiency']:g}. Rows with None have no shot.",
        '"""',
        "",
        "from bisect import bisect_right",
        "",
        f"COLUMNS = {_COLUMNS!r}",
        '"""Of a shot: over the horizontal, the hood\'s mechanism, of the piece, of the wheels, its direction from',
        'that to the target (counter-clockwise), and from the muzzle to the opening."""',
    ]
    units = {"DISTANCES": "from the robot's middle to the target's", "RADIAL": "of the robot toward the target",
             "TANGENTIAL": "of the robot to the left, looking at the target"}  # fmt: skip
    for name, axis in axes.items():
        unit = "m" if name == "DISTANCES" else "m/s"
        lines.append(f"{name} = {tuple(axis)!r}  # [{unit}] {units[name]}")
    lines.append("SHOTS = {")
    gaps: list[tuple[float, float, float]] = []
    for row in table.rows:
        key = (row.distance, row.radial, row.tangential)
        values = row_values(row)
        shot = tuple(values[name] for name in _COLUMNS) if row.is_feasible else None
        note = row.problem
        if row.share is not None:
            where = f", off the board, at a bearing of {math.degrees(row.bearing):.0f} deg alone"
            note = f"{row.share.value:.1%} go in{where if row.by_board else ''}"
        lines.append(f"    {key!r}: {shot!r},  # {note}")
        if row.between is not None and row.share is not None:
            after = next(
                other
                for other in table.rows
                if other.distance > row.distance and (other.radial, other.tangential) == key[1:]
            )
            worse = min(row.share.value, after.share.value if after.share is not None else 0.0)
            if row.between.value < _KEPT * worse:
                gaps.append(key)
    lines += ["}", f"GAPS = {set(gaps) if gaps else set()!r}", _GAPS_TEXT, "", "", _LOOKUP]
    return "\n".join(lines)


_GAPS_TEXT = '"""Rows from which on, up to the next distance, shots half way between do not go in as these do."""'
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
