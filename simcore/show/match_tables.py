"""Tables for the page of a run: the score sheet, and the shots, cycles and use of time of each robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from simcore.show.run_track import RunTrack
from simcore.show.shots import ShotTrace, shot_rows
from simcore.telemetry.recording import Recording, newest_rows
from simcore.telemetry.snapshot import key_in_words
from simcore.typing import BoolArray, FloatArray
from simcore.units import TICK

__all__ = [
    "USES", "Cell", "RobotRow", "Table", "robot_rows", "score_sheet", "tables_of", "use_rows", "verdict",
]  # fmt: skip

USES = ("shooting", "collecting", "driving", "standing", "disabled")
"""Categories for the time of a robot. If several categories apply, `disabled` counts, otherwise the first one."""

_BURST = 3.0  # [s]; a longer pause between two shots ends a cycle
_AIMING = 0.5  # [s]; time before and after a shot that counts as shooting
_MOVING = 0.2  # [m/s]; a slower robot counts as standing

Cell: TypeAlias = "str | list[float | str]"
"""Text of a cell, or a time [s] and the text of a link to that time."""


@dataclass(frozen=True, slots=True)
class Table:
    """Table on the page of a run: title, column headers, rows, and layout options."""

    title: str
    head: list[str]
    rows: list[list[Cell]]
    is_open: bool = False
    is_wide: bool = False

    def data(self) -> dict[str, object]:
        """Return the table as a dictionary for the player."""
        return {"title": self.title, "head": self.head, "rows": self.rows, "open": self.is_open, "wide": self.is_wide}


@dataclass(frozen=True, slots=True)
class RobotRow:
    """Statistics of one robot of a match."""

    number: int
    alliance: str
    shots: int
    hits: int
    cycles: tuple[tuple[float, int, int], ...]
    """Time of the first shot [s], number of hits, and number of shots for each cycle. A pause of 3 s ends a cycle."""
    seconds: dict[str, float]
    """Time in each category of `USES` [s]; the sum is the duration of the run."""


def robot_rows(track: RunTrack, shots: Sequence[ShotTrace]) -> list[RobotRow]:
    """Return the statistics of each robot of a run."""
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
    """Return table rows about cycles and the use of time: a label, and one value for each robot."""
    rows = [("cycles", [str(len(robot.cycles)) for robot in robots])]
    rows += [("pieces a cycle", [f"{robot.shots / max(1, len(robot.cycles)):.1f}" for robot in robots])]
    return rows + [(use, [f"{robot.seconds[use]:.1f} s" for robot in robots]) for use in USES]


def tables_of(track: RunTrack, shots: Sequence[ShotTrace]) -> list[Table]:
    """Return the tables of a page.

    A page of several robots has tables of the robots and of the cycles, and in a match a score sheet. A page of one
    robot has a table of the shots.
    """
    scene = track.scene
    several = len(scene.robots) > 1
    tables = []
    sheet = score_sheet(track.recording)
    is_match = several and not any(robot.score_key for robot in scene.robots)
    if sheet and is_match:
        tables.append(Table("Score sheet", ["", "blue", "red"], sheet, is_open=True))
    robots = robot_rows(track, shots) if several else []
    rows = shot_rows(shots, len(scene.robots)) if shots else []
    if robots:
        line_up = [("alliance", [robot.alliance for robot in robots])] if is_match else []
        line_up += [("plays", [look.role for look in scene.robots])] if any(look.role for look in scene.robots) else []
        heads = ["", *(look.name or f"robot {number}" for number, look in enumerate(scene.robots))]
        cells: list[list[Cell]] = [[name, *values] for name, values in [*line_up, *rows, *use_rows(robots)]]
        title = f"Robots, {len(shots)} shots" if shots and is_match else "Robots"  # no sum over two runs
        tables.append(Table(title, heads, cells, is_open=True, is_wide=True))
    elif rows:
        cells = [[name, *values] for name, values in rows]
        tables.append(Table(f"Shots ({len(shots)})", ["", "all"], cells, is_open=True))
    most = max((len(robot.cycles) for robot in robots), default=0)
    if most:
        cells = []
        for one in robots:
            bursts: list[Cell] = [[time, f"{time:.0f} s: {hits} of {tried}"] for time, hits, tried in one.cycles]
            cells += [[scene.label(one.number), *bursts]] if bursts else []
        tables.append(Table("Cycles by robot", ["", *map(str, range(1, most + 1))], cells, is_wide=True))
    return tables


def score_sheet(recording: Recording) -> list[list[Cell]]:
    """Return one row per scored item with the final values of blue and red, and a last row with the total scores.

    Items that are zero for both alliances are left out. If no item is left, the result is empty.
    """
    rows: dict[str, list[Cell]] = {}
    for column, alliance in enumerate(("Blue", "Red"), 1):
        head = f"Sim/Score/{alliance}/"
        for key in recording.keys:
            if key.startswith(head):
                row = rows.setdefault(key.removeprefix(head), [_words(key.removeprefix(head)), "0", "0"])
                row[column] = f"{recording.series(key)[1][-1]:.0f}"
    found = [row for row in rows.values() if row[1:] != ["0", "0"]]
    return found and [*found, ["score", *(_final(recording, alliance) for alliance in ("Blue", "Red"))]]


def verdict(track: RunTrack) -> str:
    """Return the winner and the score as text, or only the points if all robots are in the same alliance."""
    blue, red = (int(_final(track.recording, alliance)) for alliance in ("Blue", "Red"))
    sides = {robot.alliance for robot in track.scene.robots}
    if len(sides) == 1:
        return f"{red if sides == {'red'} else blue} points"
    who = "blue wins" if blue > red else "red wins" if red > blue else "a tie"
    return f"{who}, {max(blue, red)} to {min(blue, red)}"


# --- inside -------------------------------------------------------------------------------------------------------


def _alliances(track: RunTrack) -> list[str]:
    """Return the alliance of each robot at the end of the run; an empty string if no alliance was recorded."""
    recording = track.recording
    keys = [f"{robot.prefix}/Robot/IsRed" for robot in track.scene.robots]
    return [("red" if recording.series(key)[1][-1] else "blue") if recording.has(key) else "" for key in keys]


def _words(key: str) -> str:
    """Convert a key of the score sheet to words, e.g. `goalScore/auto1Points` to `goal score: auto 1 points`."""
    return ": ".join(map(key_in_words, key.split("/")))


def _final(recording: Recording, alliance: str) -> str:
    key = f"Sim/Score/{alliance}"
    return f"{recording.series(key)[1][-1]:.0f}" if recording.has(key) else "0"


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
    """Divide the time of a run among the categories of `USES`, and return the time in each category [s].

    Args:
        times: Times of the rows [s], shape (n,).
        enabled: Whether the robot is enabled at each time, shape (n,).
        uses: Whether each category applies at each time, in the order of `USES`, shape (n,) each.
    """
    steps = np.diff(times, prepend=times[0] - TICK) if len(times) else np.zeros(0)
    left, found = enabled.copy(), dict.fromkeys(USES, 0.0)
    for name, is_so in zip(USES, uses, strict=False):
        found[name] = float(steps[left & is_so].sum())
        left &= ~is_so
    found["standing"] = float(steps[left].sum())
    found["disabled"] = float(steps[~enabled].sum())
    return {name: round(seconds, 6) for name, seconds in found.items()}  # a log and its run show equal values
