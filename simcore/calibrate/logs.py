"""Readers of log files: SysId's JSON, CSV, and WPILOG from DataLogManager, SysId, AdvantageKit or URCL.

Sources: `AnalysisManager.cpp` and `JSONConverter.cpp` of SysId's analyzer in WPILib 2020 to 2023 for the columns of
SysId's JSON; WPILib's `SysIdRoutineLog` for the names of entries; the module `urcl` lists the sources for URCL.
"""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from simcore.calibrate.signals import Signal
from simcore.calibrate.urcl import urcl_signals
from simcore.errors import LogError
from simcore.telemetry.wpilog import LogColumn, read_log
from simcore.typing import FloatArray

__all__ = ["Log", "open_log"]


@dataclass(frozen=True, slots=True, eq=False)
class Log:
    """Contents of a log file: signals by name, and the tests that the log marks."""

    path: Path
    signals: Mapping[str, Signal]
    tests: Sequence[tuple[str, float, float]] = ()
    """Tests marked in the log: name, begin and end [s]; empty for a log without marks."""
    kind: str = ""
    """Kind of the tested mechanism in a SysId file, e.g. `Drivetrain`, `Simple`, `Arm` or `Elevator`; empty if unknown.
    """
    meters_per_turn: float | None = None
    """Distance per wheel turn according to a log with positions in turns [m]; None if the log gives no distance."""
    notes: Sequence[str] = field(default_factory=tuple)
    """Assumptions made while reading the log."""


def open_log(path: Path) -> Log:
    """Read a log file; the suffix and the content of the file determine the format.

    Raises:
        LogError: If the file cannot be read, or if the format is unknown or only another tool can read the format.
    """
    suffix = path.suffix.lower()
    if suffix in (".wpilog", ".wpilogxz"):
        return _wpilog(path)
    if suffix == ".hoot" or suffix == ".revlog":
        raise LogError(f"{path.name}: convert it to WPILOG first: AdvantageScope, File > Export Data..., or owlet")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise LogError(f"cannot read the log {str(path)!r}: {getattr(error, 'strerror', None) or error}") from error
    return _sysid_json(path, text) if text.lstrip().startswith("{") else _csv(path, text)


# --- CSV ------------------------------------------------------------------------------------------------------------

_TIME = re.compile(r"^(t|time|timestamp|seconds)(?:[ _\[(]*(s|sec|seconds|ms|us)?[\])]?)$", re.IGNORECASE)
_SECONDS = {"ms": 1e-3, "us": 1e-6}


def _csv(path: Path, text: str) -> Log:
    rows = [row for row in csv.reader(text.splitlines()) if row and not row[0].startswith("#")]
    if len(rows) < 3:
        raise LogError(
            f"{path.name}: no table: the first line must name the columns, and each further line have their values"
        )
    head = [name.strip() for name in rows[0]]
    times = next(((k, found) for k, name in enumerate(head) if (found := _TIME.match(name))), None)
    if times is None:
        raise LogError(f"{path.name}: no time column: name one t_s; it has {', '.join(head)}")
    label = next((k for k, name in enumerate(head) if name.lower() in ("test", "run")), None)
    numbers = []
    for line, row in enumerate(rows[1:], 2):
        try:
            numbers.append([math.nan if k == label or not cell.strip() else float(cell) for k, cell in enumerate(row)])
        except ValueError as error:
            raise LogError(f"{path.name}, line {line}: {error}") from error
        if len(row) != len(head):
            raise LogError(f"{path.name}, line {line}: {len(row)} values for {len(head)} columns")
    table, (at, found) = np.array(numbers), times
    table[:, at] *= _SECONDS.get(found[2] or "s", 1.0)
    tests: list[tuple[str, float, float]] = []
    if label is not None:  # times of each test may start at 0, so place the tests one after another
        names, start = [row[label].strip() for row in rows[1:]], 0
        for end in range(1, len(names) + 1):
            if end == len(names) or names[end] != names[start]:
                table[start:end, at] += (tests[-1][2] + 1.0 if tests else 0.0) - table[start, at]
                tests.append((names[start], float(table[start, at]), float(table[end - 1, at])))
                start = end
    signals = {}
    for k, name in enumerate(head):
        known = np.isfinite(table[:, k]) & np.isfinite(table[:, at])
        if k not in (at, label) and known.any():
            signals[name] = Signal(table[known, at], table[known, k])
    return Log(path, signals, tests)


# --- SysId, 2020 to 2023 --------------------------------------------------------------------------------------------

_TESTS = ("slow-forward", "slow-backward", "fast-forward", "fast-backward", "track-width")
_COLUMNS = {
    9: ("left volts", "right volts", "left position", "right position", "left velocity", "right velocity", "yaw",
        "rate"),
    10: ("battery", "autospeed", "left volts", "right volts", "left position", "right position", "left velocity",
         "right velocity", "yaw"),
    4: ("volts", "position", "velocity"),
}  # fmt: skip
"""Columns after the time column, by the total number of columns.

Rows of 9 are drivetrains of 2021 to 2023, rows of 10 are drivetrains of 2020, and rows of 4 are mechanisms.
"""


def _sysid_json(path: Path, text: str) -> Log:
    try:
        data = json.loads(text)
    except ValueError as error:
        raise LogError(f"{path.name} is not valid JSON: {error}") from error
    found = [name for name in _TESTS if isinstance(data.get(name), list) and len(data[name]) > 2]
    if not found:
        raise LogError(f"{path.name} is not a SysId file: it has none of {', '.join(_TESTS)} with rows")
    widths = {len(row) for name in found for row in data[name]}
    if len(widths) != 1 or (width := widths.pop()) not in _COLUMNS:
        raise LogError(f"{path.name}: rows of SysId files have 4, 9 or 10 numbers, got {sorted(widths) or width}")
    tests: list[tuple[str, float, float]] = []
    tables = []
    for name in found:
        table = np.array(data[name], dtype=np.float64)
        table[:, 0] += (tests[-1][2] + 1.0 if tests else 0.0) - table[0, 0]
        tests.append((name, float(table[0, 0]), float(table[-1, 0])))
        tables.append(table)
    rows = np.vstack(tables)
    unit, per_turn = str(data.get("units", "Rotations")), float(data.get("unitsPerRotation", 1.0))
    size = {"meters": 1.0, "feet": 0.3048, "inches": 0.0254}.get(unit.lower())
    signals = {}
    for name, column in zip(_COLUMNS[width], rows[:, 1:].T, strict=True):
        is_turns = name.endswith(("position", "velocity"))  # SysId applies its units per rotation later
        signals[name] = Signal(rows[:, 0], column, "turns" if is_turns else "")
    return Log(path, signals, tests, str(data.get("test", "")), None if size is None else size * per_turn)


# --- WPILOG -----------------------------------------------------------------------------------------------------------

_ARRAYS = {"double[]": "<f8", "float[]": "<f4"}
_STATE = "struct:SwerveModuleState[]"
_POSITIONS = "struct:SwerveModulePosition[]"


def _wpilog(path: Path) -> Log:
    log = read_log(path)
    signals: dict[str, Signal] = dict(urcl_signals(log))
    for key, column in log.columns.items():
        if not len(column):
            continue
        if column.type in ("double", "float", "int64"):
            times, values = log.series(key)
            signals[key] = Signal(times, values, _unit_of(column), is_kept=True)
        elif column.type == "struct:Rotation2d":
            signals[key] = Signal(column.times, _structs(column)[:, 0], "rad", is_kept=True)
        elif column.type in (_POSITIONS, _STATE) or column.type in _ARRAYS:
            signals |= _parts(key, column)
    tests = []
    for key, column in log.columns.items():
        if column.type == "string" and ("sysid-test-state" in key or "SysIdTestState" in key):
            tests += _states(column, log.span[1])
    return Log(path, signals, tests)


def _unit_of(column: LogColumn) -> str:
    """Return the unit in the metadata of an entry: the JSON field `unit`, or the whole text if the text is not JSON."""
    try:
        return str(json.loads(column.metadata or "{}").get("unit", ""))
    except (ValueError, AttributeError):
        return column.metadata


def _structs(column: LogColumn, width: int = 1) -> FloatArray:
    return np.array([np.frombuffer(column.payload(k)[: 8 * width], "<f8") for k in range(len(column))])


def _parts(key: str, column: LogColumn) -> dict[str, Signal]:
    """Return one signal for each array element of an entry, by signal name.

    Samples with fewer elements than the longest sample are skipped.
    """
    dtype = _ARRAYS.get(column.type, "<f8")
    rows = [np.frombuffer(raw[: len(raw) // int(dtype[2]) * int(dtype[2])], dtype)
            for raw in (column.payload(k) for k in range(len(column)))]  # fmt: skip
    width = max(map(len, rows))
    keep = [k for k, row in enumerate(rows) if len(row) == width and width]
    if not keep:
        return {}
    table, times = np.array([rows[k] for k in keep], dtype=np.float64), column.times[keep]
    names = {_STATE: ("speed_mps", "angle_rad"), _POSITIONS: ("position_m", "angle_rad")}.get(column.type)
    if names is None:
        return {f"{key}[{k}]": Signal(times, table[:, k], is_kept=True) for k in range(width)}
    return {f"{key}[{k // 2}]/{names[k % 2]}": Signal(times, table[:, k], is_kept=True) for k in range(width)}


def _states(column: LogColumn, end: float) -> list[tuple[str, float, float]]:
    """Return name, begin and end [s] of each test in an entry of SysId's test states, e.g. `quasistatic-forward`.

    The state `none` separates tests. The last test ends at `end` [s].
    """
    words = [str(column.value(k)) for k in range(len(column))]
    tests, start = [], 0
    for k in range(1, len(words) + 1):
        if k == len(words) or words[k] != words[start]:
            until = float(column.times[k]) if k < len(words) else end
            if words[start] not in ("none", ""):
                tests.append((words[start], float(column.times[start]), until))
            start = k
    return tests
