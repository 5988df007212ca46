"""Events and score board of a run, computed from the telemetry."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import numpy as np

from simcore.errors import UnknownNameError
from simcore.match.runner import NOTHING
from simcore.show.scene import Scene
from simcore.show.shots import ShotTrace
from simcore.telemetry.recording import Recording, newest_rows
from simcore.telemetry.snapshot import Snapshot, key_in_words
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import TICK

__all__ = [
    "BROWNOUT", "ChangeRecord", "EventKind", "RunEvent", "board_now", "changing_rows", "counts_now", "ending_of",
    "events_of", "failure_of", "lamps_now", "phases_of", "score_keys",
]  # fmt: skip

EventKind = Literal[
    "mode", "put", "hit", "miss", "pass", "flying", "score", "slip", "bump", "brownout", "foul", "placed"
]

_Value = TypeVar("_Value")

_SLIP = 0.5  # [m/s]; sliding speed of a tire from which a slip is reported
_BUMP = 0.6  # [m/s] in a tick, i.e. 30 m/s^2: twice the acceleration that tires allow
_MOST_LIGHTS = 24  # largest number of squares for an LED strip
_TOLD = frozenset(f"Sim/Match/{name}" for name in ("Time", "TimeLeft", "Period", "Enabled", "Game", "LastFoul"))
_LIGHTS = re.compile(r"^Sim/(?:Robots/\d+/)?Lights/([^/]+)/Colors$")
_LAMP = re.compile(r"^Sim/Match/((?:Blue|Red)\w+)(Active|Light)$")
_OBJECT = re.compile(r"<(?:\w+\.)*(\w+) object at 0x[0-9a-f]+>")
_WANTED = re.compile(r"assert ([^<>=!]+) (>=|<=|==|>|<) ([^<>=!]+)")
_SIGNS = {">=": "at least", "<=": "at most", "==": "exactly", ">": "more than", "<": "less than"}
_TOGETHER = 0.5  # [s]; repetitions within this time count as one event
BROWNOUT = 6.75
"""Brownout voltage of a roboRIO 2 [V], for logs without `BrownedOut`."""


@dataclass(frozen=True, slots=True)
class RunEvent:
    """Event of a run for the event list and the time line of a page."""

    time: float
    """Simulated time of the event [s]."""
    kind: EventKind
    text: str


def events_of(recording: Recording, scene: Scene, shots: Sequence[ShotTrace]) -> list[RunEvent]:
    """Return the events of a run in order of time.

    Events are mode changes, shots, scores, placed pieces, fouls, placements of robots, sliding tires, bumps and
    brownouts.
    """
    events = [RunEvent(time, "mode", text) for time, text in zip(*_modes(recording), strict=True)]
    for shot in shots:
        whose = f"{scene.label(shot.robot)}: " if len(scene.robots) > 1 else ""
        side = f", {shot.side}" if shot.side else ""
        speed = f", {shot.speed:.1f} m/s" if math.isfinite(shot.speed) else ""
        numbers = f" ({shot.distance:.1f} m{speed})" if shot.is_over else " at the end"
        what = "passed on" if shot.result == "pass" else f"shot, {shot.result}{side}"
        events.append(RunEvent(shot.time, shot.result, f"{whose}{what}{numbers}"))
    for label, key in score_keys(scene):
        events += [RunEvent(time, "score", f"{label} {rise:+.0f}") for time, rise in _rises(recording, key)]
    for key in recording.keys:
        if key.startswith("Sim/Placed/"):
            name = key_in_words(key.removeprefix("Sim/Placed/"))
            events += [RunEvent(time, "placed", f"placed, {name} {rise:+.0f}") for time, rise in _rises(recording, key)]
    if recording.has("Sim/Match/LastFoul"):
        for time, text in zip(*_changes(*recording.strings("Sim/Match/LastFoul")), strict=True):
            events.append(RunEvent(time, "foul", text.partition(" ")[2]))
    for number, robot in enumerate(scene.robots):
        whose = f"{scene.label(number)}: " if len(scene.robots) > 1 else ""
        events += [RunEvent(t, kind, whose + text) for t, kind, text in _troubles(recording, robot.prefix)]
    return sorted(events, key=lambda event: event.time)


def board_now(snapshot: Snapshot, scene: Scene) -> list[tuple[str, str]]:
    """Return the label and the text of each line of the score board for a snapshot.

    The text of an LED strip is `led:` and the colors of the LEDs, e.g. `led:ff0000,00ff00`.
    """
    items = []
    match, scores = snapshot.strings, snapshot.integers
    if "Sim/Match/Period" in match or "Sim/Match/Enabled" in snapshot.booleans:
        words = [match.get("Sim/Match/Period", "")]
        words += [] if snapshot.booleans.get("Sim/Match/Enabled", True) else ["disabled"]
        items.append(("period", ", ".join(filter(None, words))))
    left = snapshot.doubles.get("Sim/Match/TimeLeft")
    if left is not None:
        seconds = math.ceil(left - 1e-6)
        items.append(("time left", f"{seconds // 60}:{seconds % 60:02d}"))
    items += [(label, str(scores[key])) for label, key in score_keys(scene) if key in scores]
    for key, value in {**snapshot.booleans, **scores, **match}.items():
        if key.startswith("Sim/Match/") and key not in _TOLD and not _LAMP.match(key) and value not in NOTHING:
            text = ("yes" if value else "no") if isinstance(value, bool) else str(value)
            items.append((key_in_words(key.removeprefix("Sim/Match/")), text))
    if scores.get("Sim/Shots") and len(scene.robots) == 1:
        items.append(("hits", f"{scores.get('Sim/Hits', 0)} of {scores['Sim/Shots']} shots"))
    held = [scores.get(f"{robot.prefix}/Intake/HeldCount") for robot in scene.robots]
    if any(count is not None for count in held):
        items.append(("held", ", ".join(_told(scene, held))))
    volts = [snapshot.doubles.get(f"{robot.prefix}/Debug/BatteryVoltage") for robot in scene.robots]
    if len(volts) == 1 and volts[0] is not None:
        items.append(("battery", f"{volts[0]:.1f} V"))
    for key, colors in snapshot.integer_arrays.items():
        if found := _LIGHTS.match(key):
            step = max(1, math.ceil(len(colors) / _MOST_LIGHTS))
            strip = ",".join(f"{color:06x}" if color >= 0 else "" for color in colors[::step].tolist())
            items.append((found[1], f"led:{strip}"))
    return items


def changing_rows(recording: Recording, scene: Scene) -> IntArray:
    """Return the indices of the rows at which the results of `board_now`, `lamps_now` or `counts_now` may change."""
    levels = {level.key for level in scene.levels}
    shown = {key for _, key in score_keys(scene)} | {"Sim/Shots", "Sim/Hits"}
    shown |= {f"{robot.prefix}/Intake/HeldCount" for robot in scene.robots}
    shown |= {f"{robot.prefix}/Debug/BatteryVoltage" for robot in scene.robots if len(scene.robots) == 1}
    found = set(recording.times[:1].tolist())
    for key in recording.keys:
        if key in levels or _LIGHTS.match(key):
            rows = recording.integers(key)
            found.update(_changes([time for time, _ in rows], [numbers.tobytes() for _, numbers in rows])[0])
        elif key in shown or (key.startswith("Sim/Match/") and key != "Sim/Match/Time"):
            found.update(_changes(*_shown_values(recording, key))[0])
    return np.nonzero(np.isin(recording.times, [*found]))[0]


class ChangeRecord:
    """Record of the changes of named values during a run, with None for a value that is no longer present."""

    def __init__(self) -> None:
        self.found: dict[str, dict[str, list[Any]]] = {}
        """Lists `times` [s] and `values` of the changes, by the name of the value."""

    def take(self, time: float, items: Iterable[tuple[str, object]]) -> None:
        """Compare all current values (name and value) with the last values, and record the changes at a time [s]."""
        for name, value in (dict.fromkeys(self.found) | dict(items)).items():
            changes = self.found.setdefault(name, {"times": [], "values": []})
            if not changes["values"] or changes["values"][-1] != value:
                changes["times"].append(round(time, 3))
                changes["values"].append(value)


def counts_now(snapshot: Snapshot, scene: Scene) -> dict[str, int]:
    """Return the number of pieces in each scoring place (key `<level>/<number>`) and on each level (key `<level>`)."""
    found: dict[str, int] = {}
    for level in scene.levels:
        counts = snapshot.integer_arrays.get(level.key, ())
        found |= {f"{level.name}/{number}": int(count) for number, count in enumerate(counts)}
        found[level.name] = int(np.sum(counts))
    return found


def score_keys(scene: Scene) -> list[tuple[str, str]]:
    """Return the label and the telemetry key of each score: one per alliance, or per robot on a page of two runs."""
    names = [robot.name for robot in scene.robots if robot.score_key]
    keys = [robot.score_key for robot in scene.robots if robot.score_key]
    return list(zip(names, keys, strict=True)) or [("blue", "Sim/Score/Blue"), ("red", "Sim/Score/Red")]


def lamps_now(snapshot: Snapshot) -> dict[str, str]:
    """Return the states of lit field elements by name prefix of the element in the field model.

    `Sim/Match/BlueGoalActive` gives `on` or `off` for `blue_goal...`. `Sim/Match/BlueGoalLight` gives the state in the
    game's words; pages also show `pulsing` and `purple`.
    """
    states = {key: "on" if is_on else "off" for key, is_on in snapshot.booleans.items()} | dict(snapshot.strings)
    return {
        key_in_words(match[1]).replace(" ", "_"): state for key, state in states.items() if (match := _LAMP.match(key))
    }


def phases_of(recording: Recording) -> list[tuple[float, str, float]]:
    """Return the time [s], text and time left [s] at each change of the match period or of the enabled state.

    The texts are the states of `_modes`. The list is empty if the recording has no match clock.
    """
    if not recording.has("Sim/Match/TimeLeft"):
        return []
    at, left = recording.series("Sim/Match/TimeLeft")
    times, words = _modes(recording)
    return [*zip(times, words, left[newest_rows(at, np.array(times))].tolist(), strict=True)]


def ending_of(recording: Recording) -> list[str]:
    """Return the recorded failure of a run's test and the recorded warnings; empty if neither was recorded."""
    texts = [recording.strings(key)[1][-1] for key in ("Sim/Failure", "Sim/Warnings") if recording.has(key)]
    return [_OBJECT.sub(r"\1", text) for text in texts]


def failure_of(recording: Recording) -> str:
    """Return a sentence with the failure of a run's test and the end time of the run [s]; empty if no test failed."""
    if not recording.has("Sim/Failure"):
        return ""
    said = recording.strings("Sim/Failure")[1][-1].partition("\n")[0].removeprefix("AssertionError: ")
    if match := _WANTED.fullmatch(said):
        got, sign, wanted = match.groups()
        said = f"got {got}, wanted {_SIGNS[sign]} {wanted}"
    return f"{said}, at {recording.times[-1]:.2f} s"


# --- inside -------------------------------------------------------------------------------------------------------


def _told(scene: Scene, counts: Sequence[int | None]) -> list[str]:
    """Return the count of each robot as text, with the label of the robot if the scene has several robots.

    Robots with a count of None are left out.
    """
    known = [(number, count) for number, count in enumerate(counts) if count is not None]
    return [str(count) if len(counts) == 1 else f"{scene.label(number)} {count}" for number, count in known]


def _modes(recording: Recording) -> tuple[list[float], list[str]]:
    """Return the times [s] at which the match period or the enabled state changes, and the new state at each time.

    A state is the name of the period, e.g. `teleop`, or `teleop, disabled` while robots are disabled.
    """
    times, names = recording.times, [""] * len(recording)
    if recording.has("Sim/Match/Period"):
        at, periods = recording.strings("Sim/Match/Period")
        rows = newest_rows(at, times)
        names = [periods[row] for row in rows.tolist()]
    if recording.has("Sim/Match/Enabled"):
        at, enabled = recording.series("Sim/Match/Enabled")
        rows = newest_rows(at, times)
        names = [
            name if on else ", ".join(filter(None, (name, "disabled")))
            for name, on in zip(names, enabled[rows].tolist(), strict=True)
        ]
    return _changes(times, names)


def _shown_values(recording: Recording, key: str) -> tuple[FloatArray, Sequence[object]]:
    """Return the times [s] and values of a number or text, with the match clock rounded up to whole seconds."""
    try:
        times, values = recording.series(key)
    except UnknownNameError:
        return recording.strings(key)
    return times, (np.ceil(values - 1e-6) if key == "Sim/Match/TimeLeft" else values).tolist()


def _changes(times: FloatArray | list[float], values: Sequence[_Value]) -> tuple[list[float], list[_Value]]:
    """Return the time and the value at the start of each sequence of equal values."""
    rows = [row for row, value in enumerate(values) if not row or value != values[row - 1]]
    return [float(times[row]) for row in rows], [values[row] for row in rows]


def _rises(recording: Recording, key: str) -> list[tuple[float, float]]:
    """Return the time [s] and the amount of each change of a count; changes less than 0.5 s apart are merged."""
    if not recording.has(key):
        return []
    times, counts = recording.series(key)
    found: list[tuple[float, float]] = []
    last = -1e9
    for row in np.nonzero(np.diff(counts))[0].tolist():
        time, rise = float(times[row + 1]), float(counts[row + 1] - counts[row])
        if found and time - last < _TOGETHER:
            found[-1] = (found[-1][0], found[-1][1] + rise)
        else:
            found.append((time, rise))
        last = time
    return found


def _troubles(recording: Recording, prefix: str) -> list[tuple[float, EventKind, str]]:
    found: list[tuple[float, EventKind, str]] = []
    if recording.has(f"{prefix}/Robot/LastPlacement"):
        times, counts = recording.series(f"{prefix}/Robot/Placements")
        at, texts = recording.strings(f"{prefix}/Robot/LastPlacement")
        for row in (np.nonzero(np.diff(counts))[0] + 1).tolist():
            found.append(
                (float(times[row]), "put", f"put there, {texts[int(np.searchsorted(at, times[row] + 1e-9)) - 1]}")
            )
    if recording.has(f"{prefix}/Robot/WheelSlip"):
        times, slip = recording.series(f"{prefix}/Robot/WheelSlip")
        for start, end in _stretches(times, slip > _SLIP):
            most = slip[(times >= start) & (times <= end)].max()
            found.append((start, "slip", f"tires slide for {end - start + TICK:.2f} s, up to {most:.1f} m/s"))
    if recording.has(f"{prefix}/Robot/Pose3d"):
        times, poses = recording.poses(f"{prefix}/Robot/Pose3d")
        speed = np.diff(poses[:, :2], axis=0) / np.maximum(np.diff(times), 1e-6)[:, None]
        jump = np.linalg.norm(np.diff(speed, axis=0), axis=1)
        steps = np.diff(times)
        is_smooth = (np.abs(steps[1:] - steps[:-1]) < 1e-6) & (np.linalg.norm(speed, axis=1)[1:] < 10.0)
        for start, end in _stretches(times[1:-1], (jump > _BUMP) & is_smooth):
            most = jump[(times[1:-1] >= start) & (times[1:-1] <= end)].max()
            found.append((start, "bump", f"bump: {most:.1f} m/s within a tick"))
    if recording.has(f"{prefix}/Debug/BrownedOut"):
        times, flags = recording.series(f"{prefix}/Debug/BrownedOut")
        low = flags > 0.5
        if recording.has(f"{prefix}/Debug/Brownouts"):  # also brownouts between two rows
            low |= np.diff(recording.series(f"{prefix}/Debug/Brownouts")[1], prepend=0.0) > 0.0
    elif recording.has(f"{prefix}/Debug/BatteryVoltage"):
        times, volts = recording.series(f"{prefix}/Debug/BatteryVoltage")
        low = volts < BROWNOUT
    else:
        return found
    for start, end in _stretches(times, low):
        found.append((start, "brownout", f"brownout, {end - start + TICK:.2f} s"))
    return found


def _stretches(times: FloatArray, is_so: BoolArray) -> list[tuple[float, float]]:
    """Return the first and last time [s] of each interval in which a condition holds; merge gaps of less than 0.5 s."""
    found: list[tuple[float, float]] = []
    for time in times[is_so].tolist():
        if found and time - found[-1][1] < _TOGETHER:
            found[-1] = (found[-1][0], time)
        else:
            found.append((time, time))
    return found
