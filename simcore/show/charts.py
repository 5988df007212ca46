"""Charts of a run, computed from the recorded telemetry."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from simcore.show.palette import color, tint
from simcore.show.run_events import BROWNOUT, score_keys
from simcore.show.run_track import RunTrack
from simcore.telemetry.recording import Recording, newest_rows
from simcore.telemetry.snapshot import Snapshot, key_in_words
from simcore.typing import FloatArray

__all__ = ["Chart", "Curve", "charts_of", "thinned", "value_at"]

_POSE_ERROR = "/PoseError"  # end of a made-up key: distance between true and estimated pose, not published
_TICK_BUDGET = 20.0  # [ms]
_SETPOINT = re.compile(r"/Debug/(\w+?)(VelocityRPS|PositionRot)Setpoint$")
_QUANTITIES = (
    ("HeightM", "height", "m"), ("AngleDeg", "angle", "deg"), ("ExtendedPct", "extended", "%"),
    ("VelocityRPS", "velocity", "turns/s"),
)  # fmt: skip
"""Quantities of a mechanism, most important first: end of the telemetry key, name and unit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Curve of a chart: one value over time."""

    label: str
    times: FloatArray
    """Times of the points [s], shape (n,)."""
    values: FloatArray
    """Values of the points, shape (n,)."""
    is_stepped: bool = False
    """Whether the curve is drawn in steps, because the value is constant between two points."""
    key: str = ""
    """Telemetry key of the values; empty if the values are computed from several keys."""
    color: str = ""
    """Color of the curve as a CSS value; empty for the chart's next color."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Chart:
    """Curves over time on common axes."""

    title: str
    unit: str
    curves: Sequence[Curve]
    limit: float | None = None
    """Critical value, drawn as a line if a curve comes close to the value; None without a limit."""
    limit_label: str = ""
    from_zero: bool = True
    group: str = ""
    """Heading of a collapsed section with this chart; empty if the chart is always visible."""


def charts_of(track: RunTrack) -> list[Chart]:
    """Return the charts of a run, most important first; charts without recorded data are left out."""
    recording, scene = track.recording, track.scene
    robots = list(enumerate(scene.robots))
    several, of_each = len(robots) > 1, ", by robot" if len(robots) > 1 else ""

    def each(key: str, one: str) -> list[tuple[str, str]]:
        return [((robot.name or str(number)) if several else one, f"{robot.prefix}/{key}") for number, robot in robots]

    pieces = scene.piece_names
    currents = each("Debug/BatteryCurrent", "battery")
    if len(robots) == 1:
        currents.append(("drivetrain", f"{scene.robots[0].prefix}/Debug/DrivetrainCurrent"))
    score = [
        replace(curve, color=tint(curve.label)[1]) for curve in _curves(recording, score_keys(scene), is_stepped=True)
    ]
    held = _curves(recording, each("Intake/HeldCount", "in the robot"), is_stepped=True)
    work = [(f"awake {pieces}", "Sim/Performance/AwakePieces"), ("sub-steps", "Sim/Performance/SubSteps")]
    volts = _curves(recording, each("Debug/BatteryVoltageMin", "lowest of each tick"))
    volts = [_with_extremes(recording, curve, robot.prefix) for curve, (_, robot) in zip(volts, robots, strict=False)]
    volts = volts or _curves(recording, each("Debug/BatteryVoltage", "at its terminals"))  # for logs of old versions
    slips = _curves(recording, each("Robot/WheelSlip", "fastest"))
    many = "battery" if len(robots) > 2 else ""  # too many curves for one visible chart
    charts = [
        Chart(title="Score", unit="points", curves=score),
        Chart(title=f"Battery{of_each}", unit="V", curves=volts, limit=BROWNOUT, limit_label="brownout",
              from_zero=False, group=many),
        Chart(title=f"{pieces.capitalize()} held{of_each}", unit="pieces", curves=held),
        Chart(title=f"Current{of_each}", unit="A", curves=_curves(recording, currents), group=many),
        Chart(title=f"Pose estimate off by{of_each}", unit="m", curves=_pose_errors(track)),
        Chart(title=f"Sliding tires{of_each}", unit="m/s", curves=slips),
        *(chart for number, robot in robots
          for chart in _mechanism_charts(recording, robot.prefix, scene.label(number) if several else "")),
        Chart(title="Tick time", unit="ms", limit=_TICK_BUDGET, limit_label="budget",
              group="computer",
              curves=_curves(recording, [("wall time of a tick", "Sim/Performance/TickMs")])),
        Chart(title="Work", unit="count", curves=_curves(recording, work, is_stepped=True),
              group="computer"),
    ]  # fmt: skip
    inks = {robot.name: color(robot.ink) for robot in scene.robots if robot.ink}  # on a page of two runs
    return [
        replace(chart, curves=[replace(curve, color=inks.get(curve.label, curve.color)) for curve in chart.curves])
        for chart in charts
        if chart.curves
    ]


def _curves(recording: Recording, wanted: Iterable[tuple[str, str]], *, is_stepped: bool = False) -> list[Curve]:
    """Return a curve for each pair of label and key whose key was recorded."""
    return [
        Curve(label=label, times=times, values=values, is_stepped=is_stepped, key=key)
        for label, key in wanted
        if recording.has(key)
        for times, values in (recording.series(key),)
        if len(times)
    ]


def _with_extremes(recording: Recording, curve: Curve, prefix: str) -> Curve:
    """Return a battery voltage curve that also has the minima between recorded rows.

    The curve is unchanged if the minima were not recorded.
    """
    if not recording.has(f"{prefix}/Debug/BatteryVoltageLowest"):
        return curve
    lowest = recording.series(f"{prefix}/Debug/BatteryVoltageLowest")[1]
    falls = np.diff(lowest, prepend=lowest[0]) < 0.0
    return replace(curve, values=np.where(falls, np.minimum(lowest, curve.values), curve.values))


def _pose_errors(track: RunTrack) -> list[Curve]:
    """Return a curve for each robot with an estimated pose: the distance between the true and estimated positions [m].

    Values are NaN before the last time at which the robot was placed on the field before driving.
    """
    curves = []
    for number, ((times, true), (at, believed)) in enumerate(zip(track.robots, track.estimates, strict=True)):
        if not (len(times) and len(at)):
            continue
        rows = newest_rows(times, at)
        values = np.hypot(*(believed[:, :2] - true[rows, :2]).T)
        values[at < track.began(number)] = math.nan
        label = (track.scene.robots[number].name or str(number)) if len(track.robots) > 1 else "estimate to truth"
        key = f"{track.scene.robots[number].prefix}{_POSE_ERROR}"
        curves.append(Curve(label=label, times=at, values=values, key=key))
    return curves


def _mechanism_charts(recording: Recording, prefix: str, group: str) -> Iterable[Chart]:
    """Yield charts of closed loops with setpoints, of other moving mechanisms, and of all mechanism currents."""
    head = f"{prefix}/Debug/"
    known = set()
    for key in recording.keys:
        found = _SETPOINT.search(key)
        if found and key == f"{prefix}{found[0]}":
            known.add(f"{head}{found[1]}")
            yield replace(_setpoint_chart(recording, f"{head}{found[1]}", found[2], key), group=group)
    for key in [key for key in recording.keys if key.startswith(head) and key.endswith("VelocityRPS")]:
        stem = key.removesuffix("VelocityRPS")
        looks = [] if stem in known else [look for look in _QUANTITIES if recording.has(stem + look[0])]
        for suffix, quantity, unit in looks[:1]:
            values = recording.series(stem + suffix)[1]
            if len(values) and np.ptp(values) > 0.01 * max(1.0, float(np.abs(values).max())):
                curves = _curves(recording, [("is", stem + suffix)])
                yield Chart(title=f"{_name(stem)} {quantity}", unit=unit, curves=curves, from_zero=False, group=group)
    currents = [key for key in recording.keys if key.startswith(head) and key.endswith("CurrentA")]
    named = [(key_in_words(key.removeprefix(head).removesuffix("CurrentA")), key) for key in currents]
    for first in range(0, len(named), 4):
        curves = _curves(recording, named[first : first + 4])
        yield Chart(title="Mechanism currents", unit="A", curves=curves, group=group)


def _setpoint_chart(recording: Recording, stem: str, kind: str, wanted: str) -> Chart:
    """Return a chart of the measured value and the setpoint of a closed loop.

    If the height or angle of the mechanism was recorded, convert positions in turns to this height or angle.
    """
    if kind == "VelocityRPS":
        curves = _curves(recording, [("is", stem + kind), ("set-point", wanted)])
        return Chart(title=f"{_name(stem)} velocity", unit="turns/s", curves=curves)
    curves = _curves(recording, [("is", stem + kind), ("set-point", wanted)])
    for suffix, quantity, unit in _QUANTITIES[:-1]:
        if recording.has(stem + suffix) and len(curves) == 2 and np.ptp(curves[0].values) > 1e-6:
            at, values = recording.series(stem + suffix)
            turns = curves[0].values[newest_rows(curves[0].times, at)]
            slope, zero = np.polyfit(turns, values, 1).tolist()  # the relation is linear
            is_so = _curves(recording, [("is", stem + suffix)])[0]
            want = replace(curves[1], values=slope * curves[1].values + zero, key="")
            return Chart(title=f"{_name(stem)} {quantity}", unit=unit, curves=[is_so, want], from_zero=False)
    return Chart(title=f"{_name(stem)} position", unit="turns", curves=curves)


def _name(stem: str) -> str:
    """Return the name of a mechanism in words, from the common stem of the mechanism's telemetry keys."""
    return key_in_words(stem.rpartition("/")[2]).capitalize()


def value_at(snapshot: Snapshot, key: str) -> float | None:
    """Return the value of a curve's key in a snapshot, rounded for display; None if missing or not finite."""
    if key.endswith(_POSE_ERROR):
        prefix = key.removesuffix(_POSE_ERROR)
        true, believed = (snapshot.poses.get(f"{prefix}/Robot/{name}") for name in ("Pose3d", "EstimatedPose"))
        return None if true is None or believed is None else round(math.dist(true[:2], believed[:2]), 3)
    value = snapshot.doubles.get(key, snapshot.integers.get(key))
    return None if value is None or not math.isfinite(value) else round(value, 4)


def thinned(curve: Curve, buckets: int = 400) -> Curve:
    """Return a curve with fewer points: both ends, and the lowest and highest point of each of `buckets` parts.

    A curve with at most two points per part is unchanged.
    """
    n = len(curve.times)
    if n <= 2 * buckets:
        return curve
    edges = np.linspace(0, n, buckets + 1).astype(int)
    keep = {0, n - 1}
    for start, end in pairwise(edges.tolist()):
        part = curve.values[start:end]
        keep |= {int(start + part.argmin()), int(start + part.argmax())}
    rows = np.array(sorted(keep))
    return replace(curve, times=curve.times[rows], values=curve.values[rows])
