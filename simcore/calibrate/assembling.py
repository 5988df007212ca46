"""Conversion of the signals of a log to runs with common sample times, in meters or radians."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from simcore.calibrate.logs import Log
from simcore.calibrate.runs import TICK, Run, thinned_run
from simcore.calibrate.signals import SIZES, Signal, find_roles, unit_of
from simcore.errors import LogError
from simcore.typing import FloatArray

__all__ = ["assembled"]

_ON = 0.3  # [V], minimum voltage of driven motors
_PAUSE = 0.6  # [s], pause without voltage that ends a drive
_BEFORE = 0.2  # [s], time kept before the start of a drive
_LONGEST = 30.0  # [s], longest drive
_SHORTEST = 0.5  # [s], shortest drive
_STILL = 0.02  # [m] or [rad], largest motion of a robot at rest
_STANDS = 0.01  # fraction of the free speed at the logged voltage, below which a robot is at rest


def assembled(
    log: Log, *, sided: bool, radius: float | None, volts_per_speed: float, gearing: float,
    devices: Mapping[str, str] | None = None, said: Mapping[str, str] | None = None, about: str = "",
) -> tuple[list[Run], list[str]]:  # fmt: skip
    """Return the runs in a log, with common sample times and SI units, and notes on the assumptions made.

    Args:
        log: Log to convert.
        sided: Whether to keep the left and right sides separate, for a tank drive.
        radius: Wheel radius of the robot, or drum radius of an elevator [m]; None for a mechanism that turns.
        volts_per_speed: Back-EMF constant [V s/m], or [V s/rad] if `radius` is None.
        gearing: Rotor turns per turn of the wheel or mechanism [-].
        devices: Side of each drive motor by the motor's name in logs, as in `find_roles`.
        said: Signals by role given by the user, as in `find_roles`.
        about: Word in the names of the wanted mechanism's signals, as in `find_roles`.

    Raises:
        LogError: If a signal is missing, nothing moves in the log, or the values are impossible for the robot.
    """
    for role, name in (said or {}).items():
        if name not in log.signals:
            raise LogError(f"--signal {role}: {log.path.name} has no signal {name!r}; {_list(log)}")
    roles = find_roles(log.signals, devices or {}, said or {}, about)
    sides = ("left", "right") if sided else ("",)
    volts = _sided(roles, "volts", sides)
    ways = _sided(roles, "way", sides)
    is_speed = ways is None
    ways = _sided(roles, "speed", sides) if is_speed else ways
    for what, found in (("volts", volts), ("way", ways)):
        if found is None:
            wanted = " and ".join(f"{side}_{what}".lstrip("_") for side in sides)
            raise LogError(
                f"{log.path.name}: which signals are {wanted}? Name them: --signal {wanted.split()[0]}=NAME; "
                f"{_list(log)}"
            )
    assert volts is not None and ways is not None
    notes = list(log.notes)
    others = {
        name: next((some[0] for (what, _), some in roles.items() if what == name), None)
        for name in ("yaw", "ground", "bus")
    }
    amps, totals = ([n for (what, _), some in roles.items() if what == quantity for n in some]
                    for quantity in ("amps", "total"))  # fmt: skip
    totals = [name for name in totals if "total" in name.lower()][:1] or totals  # a total, else one per motor
    runs = []
    for name, begin, end in log.tests or _drives(log, [one for some in volts for one in some]):
        times = _grid(log, ways[0][0], begin, end)
        if len(times) < _SHORTEST / TICK:
            continue
        columns = [np.mean([_held(log.signals[one], times) for one in some], axis=0) for some in volts]
        moved = [np.mean([_moved(log.signals[one], times, is_speed) for one in some], axis=0) for some in ways]
        first = [column[0] for column in moved]
        extra = {key: None if one is None else _read(log.signals[one], times) for key, one in others.items()}
        for key in ("yaw", "ground"):
            if extra[key] is not None:
                extra[key] = extra[key] - extra[key][0]  # type: ignore[index]
        if extra["bus"] is not None and (totals or amps):  # battery power equals motor power
            drawn = np.sum([np.abs(_read(log.signals[one], times)) for one in totals or amps], axis=0)
            power = np.abs(np.mean(columns, axis=0)) / np.maximum(extra["bus"], 1.0)
            extra["amps"] = drawn if totals else drawn * power
        run = Run(name, times - times[0], np.column_stack(columns), np.column_stack(moved) - first, **extra,
                  origin=0.0 if is_speed else float(np.mean(first)))  # fmt: skip
        runs.append(thinned_run(run))
    if not runs:
        raise LogError(f"{log.path.name}: nothing moves in it: no motor gets more than {_ON:g} V for {_SHORTEST:g} s")
    seen = _speed_seen(runs, volts_per_speed)
    if seen < _STANDS and max(run.span for run in runs) < 10.0 * _STILL:
        most = max(float(np.abs(run.volts).max()) for run in runs)
        raise LogError(
            f"{log.path.name}: the robot stands still: with up to {most:.1f} V its wheels move "
            f"{max(run.span for run in runs):.3f} m; log a run in which it drives"
        )
    unit = unit_of(ways[0][0], log.signals[ways[0][0]].unit)
    if others["yaw"] is not None and unit_of(str(others["yaw"]), log.signals[str(others["yaw"])].unit) == "deg":
        runs = [replace(run, yaw=None if run.yaw is None else run.yaw * SIZES["deg"]) for run in runs]
    if unit == "rpm":
        runs, unit = [replace(run, way=run.way / 60.0) for run in runs], "turns"
    runs, said_unit = _in_si(log, runs, unit, radius, seen, gearing)
    said_unit += _require_sides(log.path.name, runs)
    return [run for run in runs if run.span > _STILL], [*notes, *said_unit]


def _list(log: Log) -> str:
    names = sorted(log.signals)
    more = f" and {len(names) - 40} more" if len(names) > 40 else ""
    return f"it has {', '.join(names[:40])}{more}" if names else "it has no numeric signals"


def _sided(roles: Mapping[tuple[str, str], list[str]], quantity: str, sides: Sequence[str]) -> list[list[str]] | None:
    """Return one list of signal names of a quantity for each side, or a single list of all names without sides.

    Return None if a list would be empty.
    """
    if sides == ("",):
        some = [name for (what, _), names in roles.items() if what == quantity for name in names]
        return [some] if some else None
    found = [roles.get((quantity, side), []) for side in sides]
    return found if all(found) else None


def _grid(log: Log, name: str, begin: float, end: float) -> FloatArray:
    """Return the sample times of a run between two times [s].

    If the signal `name` has evenly spaced samples, the result is the times of these samples, otherwise a 20 ms grid.
    """
    times = log.signals[name].times
    times = times[(times >= begin - 1e-9) & (times <= end + 1e-9)]
    steps = np.diff(times)
    if len(times) > 10 and not log.signals[name].is_kept and steps.max() < 3.0 * max(float(np.median(steps)), 1e-3):
        kept: FloatArray = times[np.concatenate([[True], steps > 1e-6])]
        return kept
    if len(times) < 2 and not log.tests:
        return times
    grid: FloatArray = np.arange(begin, end, TICK)
    return grid


def _held(signal: Signal, times: FloatArray) -> FloatArray:
    """Return the mean of a signal between each time [s] and the next, shape (n,).

    A sample is valid until the next sample. The signal is 0 before the first sample.
    """
    fine = np.concatenate([times, [times[-1] + TICK]])
    parts = np.linspace(0.0, 1.0, 4, endpoint=False)
    at = fine[:-1, None] + parts * np.diff(fine)[:, None]
    rows = np.searchsorted(signal.times, at + 1e-6, side="right") - 1
    values: FloatArray = np.where(rows < 0, 0.0, signal.values[np.maximum(rows, 0)]).mean(axis=1)
    return values


def _read(signal: Signal, times: FloatArray) -> FloatArray:
    """Return the values of a signal at given times [s] by linear interpolation.

    If the signal was logged only on change, each value is held until 20 ms before the next value.
    """
    stamps, values = signal.times, signal.values
    if signal.is_kept and len(stamps) > 1:
        late = np.flatnonzero(np.diff(stamps) > 1.5 * TICK)
        stamps = np.insert(stamps, late + 1, stamps[late + 1] - TICK)
        values = np.insert(values, late + 1, values[late])
    read: FloatArray = np.interp(times, stamps, values)
    return read


def _moved(signal: Signal, times: FloatArray, is_speed: bool) -> FloatArray:
    read = _read(signal, times)
    if not is_speed:
        return read
    way: FloatArray = np.concatenate([[0.0], np.cumsum(0.5 * (read[1:] + read[:-1]) * np.diff(times))])
    return way


def _drives(log: Log, names: Sequence[str]) -> list[tuple[str, float, float]]:
    """Return the parts of a log in which the motors are driven: name, begin and end [s] of each part.

    A part begins 0.2 s before a voltage exceeds 0.3 V, and ends 0.3 s into a pause of at least 0.6 s, or after 30 s.
    Parts with less than 0.5 s of voltage are left out.
    """
    stamps = np.unique(np.concatenate([log.signals[name].times for name in names]))
    grid = np.arange(stamps[0], stamps[-1], TICK)
    if not len(grid):
        return []
    volts = np.max([np.abs(_held(log.signals[name], grid)) for name in names], axis=0)
    on = np.flatnonzero(volts > _ON)
    if not len(on):
        return []
    breaks = np.flatnonzero(np.diff(on) * TICK > _PAUSE)
    firsts, lasts = np.concatenate([[on[0]], on[breaks + 1]]), np.concatenate([on[breaks], [on[-1]]])
    return [
        (f"drive at {grid[a]:.1f} s", max(float(grid[0]), float(grid[a]) - _BEFORE),
         min(float(grid[b]) + 0.5 * _PAUSE, float(grid[a]) + _LONGEST))
        for a, b in zip(firsts.tolist(), lasts.tolist(), strict=True)
        if (b - a) * TICK > _SHORTEST
    ]  # fmt: skip


# --- units and plausibility -------------------------------------------------------------------------------------------


def _in_si(
    log: Log, runs: list[Run], unit: str, radius: float | None, seen: float, gearing: float
) -> tuple[list[Run], list[str]]:
    """Return the runs with distances in meters, or angles in radians, and notes on guessed units.

    Args:
        log: Log of the runs.
        runs: Runs with distances or angles in the log's unit.
        unit: Unit of distances or angles in the log; empty if the log gives no unit.
        radius: Wheel radius or drum radius [m]; None for a mechanism that turns.
        seen: Ratio from `_speed_seen`.
        gearing: Rotor turns per turn of the wheel or mechanism [-].

    Raises:
        LogError: If the motion in the unit of the log is far faster or slower than the voltage allows.
    """
    circumference = 1.0 if radius is None else radius
    sizes = {"turns": math.tau * circumference, "rad": circumference, "deg": SIZES["deg"] * circumference,
             "turns of the rotor": math.tau * circumference / gearing,
             "rad of the rotor": circumference / gearing}  # fmt: skip
    sizes |= {} if radius is None else {name: SIZES[name] for name in ("m", "in", "ft")}
    notes = []
    size = sizes.get(unit)
    if unit == "turns" and log.meters_per_turn is not None and radius is not None:
        ratio = log.meters_per_turn / sizes["turns"]
        if abs(ratio - 1.0) > 0.1:
            size = log.meters_per_turn
        elif abs(ratio - 1.0) > 0.005:
            notes.append(f"a turn is {log.meters_per_turn:.4f} m by the log and {sizes['turns']:.4f} m by the "
                         "robot's wheels: the wheels' value is used")  # fmt: skip
    off = {name: abs(math.log(max(one * seen, 1e-9) / _USUAL)) for name, one in sizes.items()}
    likely = min(off, key=lambda name: off[name])
    rotor = f"{unit} of the rotor"
    if size is not None and off.get(rotor, _ODD) < _ODD < abs(math.log(max(size * seen, 1e-9) / _USUAL)):
        size = sizes[rotor]
        notes.append(f"{unit} are taken to be the rotor's, judging by how fast the voltage can turn it")
    if size is None or abs(math.log(max(size * seen, 1e-9) / _USUAL)) > _ODD:
        if size is not None or off[likely] > _ODD:
            guess = f" It would fit as {likely}" if off[likely] < _ODD else ""
            raise LogError(
                f"{log.path.name}: if it is in {unit or likely}, it moves {(size or sizes[likely]) * seen:.3g} times "
                "as fast as its motors can turn it at the logged voltage: is the unit, the gearing or the wheel "
                f"wrong?{guess}" + (": name the column so, or correct the robot" if guess else "")
            )
        notes.append(
            f"positions are taken to be in {likely}, judging by how fast the voltage can turn it; the log names no unit"
        )
        size = sizes[likely]
    return [replace(run, way=size * run.way, origin=size * run.origin) for run in runs], notes


_USUAL = 0.85  # typical fraction of the speed that the volts allow
_ODD = 0.55  # largest deviation from the typical fraction, as a logarithm: a factor of 1.7 either way


def _speed_seen(runs: Sequence[Run], volts_per_speed: float) -> float:
    """Return the ratio of the speed, in the unit of the log, to the free speed at the logged voltage.

    The result is the 75th percentile over all samples at high voltage, or 0 without such samples.

    Raises:
        LogError: If the robot moves backward at positive voltage.
    """
    ratios, signs = [], []
    for run in runs:
        volts, way = run.volts.mean(axis=1), run.way.mean(axis=1)
        if np.abs(volts).max() < _ON:
            continue
        speeds = np.gradient(way, run.times)
        kernel = np.ones(9) / 9.0
        speeds, level = (np.convolve(one, kernel, "same") for one in (speeds, volts))
        fast = np.abs(level) > 0.6 * np.abs(level).max()
        ratios += (np.abs(speeds[fast]) * volts_per_speed / np.abs(level[fast])).tolist()
        signs += np.sign(speeds[fast] * level[fast]).tolist()
    if signs and np.mean(signs) < -0.5:
        raise LogError(
            "it moves backward at positive voltage: change the sign of either voltages or positions in the log"
        )
    return float(np.quantile(ratios, 0.75)) if ratios else 0.0


def _require_sides(name: str, runs: Sequence[Run]) -> list[str]:
    """Check that the left and right sides of the voltages and of the distances agree.

    Returns:
        List with a note if the yaw of the gyro contradicts the sides, otherwise an empty list.

    Raises:
        LogError: If the sides of either the voltages or the distances are swapped.
    """
    if runs[0].way.shape[1] == 1:
        return []
    apart, turned = [], []
    for run in runs:
        if run.yaw is not None and abs(run.yaw[-1]) > 0.05:
            turned.append(float((run.way[-1, 1] - run.way[-1, 0]) * run.yaw[-1]))
        more, speeds = run.volts[:, 1] - run.volts[:, 0], np.gradient(run.way[:, 1] - run.way[:, 0], run.times)
        if np.abs(more).max() > 1.0:
            apart.append(float(np.sum(more * speeds)))
    if apart and sum(apart) < 0.0:
        raise LogError(
            f"{name}: the side with the higher voltage moves less far: left and right are swapped in either voltages "
            "or positions"
        )
    if turned and sum(turned) < 0.0:
        note = (
            "left and right are swapped, or the gyro counts clockwise: it turns right when the right side moves farther"
        )
        return [note]
    return []
