"""What a match came to: points and shots by period, and by robot its cycles and where its seconds went."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from simcore.show.run_track import RunTrack
from simcore.show.shots import ShotTrace
from simcore.telemetry.recording import Recording, newest_rows
from simcore.typing import BoolArray, FloatArray
from simcore.units import TICK

__all__ = ["USES", "PeriodRow", "RobotRow", "cycles_html", "period_rows", "periods_html", "robot_rows", "use_rows"]

USES = ("shooting", "collecting", "driving", "standing", "disabled")
"""What a robot does with a second; the first that is true."""

_BURST = 3.0  # [s]; shots that are farther apart belong to different cycles
_AIMING = 0.5  # [s] before and after a shot that count as shooting
_MOVING = 0.2  # [m/s]


@dataclass(frozen=True, slots=True)
class PeriodRow:
    """One period of a match."""

    name: str
    start: float
    """[s]"""
    end: float
    """[s]"""
    points: dict[str, int]
    """Scored in it, by alliance; with what fouls of the other one gave."""
    shots: dict[str, tuple[int, int]]
    """Hits and shots that left in it, by alliance."""


@dataclass(frozen=True, slots=True)
class RobotRow:
    """One robot of a match."""

    number: int
    alliance: str
    shots: int
    hits: int
    cycles: tuple[tuple[float, int, int], ...]
    """First shot [s], hits and shots of each; shots without a pause of 3 s are one cycle."""
    seconds: dict[str, float]
    """By `USES` [s]; together the whole run."""


def period_rows(track: RunTrack, shots: Sequence[ShotTrace]) -> list[PeriodRow]:
    """The periods of a run in their order; none of a run whose telemetry names none."""
    recording = track.recording
    if not recording.has("Sim/Match/Period"):
        return []
    at, names = recording.strings("Sim/Match/Period")
    first = [row for row, name in enumerate(names) if not row or name != names[row - 1]]
    starts = [float(at[row]) for row in first]
    sides = _alliances(track)
    rows = []
    for row, start, end in zip(first, starts, [*starts[1:], track.span[1]], strict=True):
        points, tried = {}, {}
        for alliance in ("blue", "red"):
            key = f"Sim/Score/{alliance.capitalize()}"
            if recording.has(key):
                points[alliance] = round(
                    _at(recording, key, end - 0.5 * TICK) - _at(recording, key, start - 0.5 * TICK)
                )
            mine = [shot for shot in shots if start <= shot.time < end and sides[shot.robot] == alliance]
            tried[alliance] = (len([shot for shot in mine if shot.scored]), len(mine))
        rows.append(PeriodRow(names[row], start, end, points, tried))
    if rows and shots:  # what counted in the last tick is the last period's
        last = rows[-1]
        for alliance in last.points:
            key = f"Sim/Score/{alliance.capitalize()}"
            last.points[alliance] += round(
                float(recording.series(key)[1][-1]) - _at(recording, key, last.end - 0.5 * TICK)
            )
    return rows


def robot_rows(track: RunTrack, shots: Sequence[ShotTrace]) -> list[RobotRow]:
    """What each robot of a run did."""
    recording, sides = track.recording, _alliances(track)
    times = recording.times
    enabled = np.ones(len(times), dtype=bool)
    if recording.has("Sim/Match/Enabled"):
        enabled = _values(recording, "Sim/Match/Enabled", times) > 0.5
    rows = []
    for number, robot in enumerate(track.scene.robots):
        mine = [shot for shot in shots if shot.robot == number]
        cycles: list[list[ShotTrace]] = []
        for shot in mine:
            if cycles and shot.time - cycles[-1][-1].time < _BURST:
                cycles[-1].append(shot)
            else:
                cycles.append([shot])
        at, places = track.robots[number]
        speed = np.zeros(len(times))
        if len(at) > 1:
            moved = np.linalg.norm(np.diff(places[:, :2], axis=0), axis=1) / np.maximum(np.diff(at), 1e-6)
            speed = np.interp(times, at[1:], moved)
        intake = np.zeros(len(times), dtype=bool)
        if recording.has(f"{robot.prefix}/Debug/IntakeZoneActive"):
            intake = _values(recording, f"{robot.prefix}/Debug/IntakeZoneActive", times) > 0.5
        seconds = _seconds(times, enabled, _near(times, [shot.time for shot in mine]), intake, speed > _MOVING)
        found = tuple((one[0].time, len([shot for shot in one if shot.scored]), len(one)) for one in cycles)
        hits = len([shot for shot in mine if shot.scored])
        rows.append(RobotRow(number, sides[number], len(mine), hits, found, seconds))
    return rows


def use_rows(robots: Sequence[RobotRow]) -> list[tuple[str, list[str]]]:
    """Cycles of each robot and what it did with its time, as rows of a table: a name, and a value a robot."""
    rows = [("cycles", [str(len(robot.cycles)) for robot in robots])]
    rows += [("pieces a cycle", [f"{robot.shots / max(1, len(robot.cycles)):.1f}" for robot in robots])]
    return rows + [(use, [f"{robot.seconds[use]:.1f} s" for robot in robots]) for use in USES]


def periods_html(rows: Sequence[PeriodRow]) -> str:
    """Points and shots of each period as a table whose buttons go there; empty without periods."""
    if not rows:
        return ""
    lines = []
    for row in rows:
        cells = []
        for alliance in ("blue", "red"):
            hits, tried = row.shots[alliance]
            cells += [f"{row.points.get(alliance, 0):+d}", f"{hits} of {tried}"]
        lines.append(
            f'<tr><th scope=row><button type="button" data-to="{row.start:.2f}">{row.start:.0f} s</button> '
            f"{escape(row.name)}</th>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"
        )
    heads = "".join(f"<th scope=col>{one}</th>" for one in ("blue points", "shots hit", "red points", "shots hit"))
    return (
        f'<details open class="several"><summary>Periods ({len(rows)})</summary><div class="wide"><table>'
        f"<thead><tr><td></td>{heads}</tr></thead><tbody>{''.join(lines)}</tbody></table></div></details>"
    )


def cycles_html(robots: Sequence[RobotRow]) -> str:
    """The cycles of each robot as a list whose buttons go there; empty without any."""
    lines = "".join(
        f"<li>robot {row.number}: "
        + ", ".join(
            f'<button type="button" data-to="{time:.2f}">{time:.0f} s</button> {hits} of {tried}'
            for time, hits, tried in row.cycles
        )
        + "</li>"
        for row in robots
        if row.cycles
    )
    return f"<details><summary>Cycles by robot</summary><ol>{lines}</ol></details>" if lines else ""


# --- inside -------------------------------------------------------------------------------------------------------


def _alliances(track: RunTrack) -> list[str]:
    """Of each robot, as it was at last; empty where the log does not say."""
    recording = track.recording
    keys = [f"{robot.prefix}/Robot/IsRed" for robot in track.scene.robots]
    return [("red" if recording.series(key)[1][-1] else "blue") if recording.has(key) else "" for key in keys]


def _at(recording: Recording, key: str, time: float) -> float:
    """The newest value at a time [s]; 0 before the first."""
    at, values = recording.series(key)
    row = int(np.searchsorted(at, time)) - 1
    return float(values[row]) if row >= 0 else 0.0


def _values(recording: Recording, key: str, times: FloatArray) -> FloatArray:
    at, values = recording.series(key)
    found: FloatArray = values[newest_rows(at, times)]
    return found


def _near(times: FloatArray, shots: Sequence[float]) -> BoolArray:
    near: BoolArray = np.zeros(len(times), dtype=bool)
    for shot in shots:
        near[np.searchsorted(times, shot - _AIMING) : np.searchsorted(times, shot + _AIMING)] = True
    return near


def _seconds(times: FloatArray, enabled: BoolArray, *uses: BoolArray) -> dict[str, float]:
    """Shares a run's seconds between `USES`, each second with the first use that is true; disabled goes before all."""
    steps = np.diff(times, prepend=times[0] - TICK) if len(times) else np.zeros(0)
    left, found = enabled.copy(), dict.fromkeys(USES, 0.0)
    for name, is_so in zip(USES, uses, strict=False):
        found[name] = float(steps[left & is_so].sum())
        left &= ~is_so
    found["standing"] = float(steps[left].sum())
    found["disabled"] = float(steps[~enabled].sum())
    return found
