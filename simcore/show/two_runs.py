"""Page that replays two runs together: the field of the first run, with the robots, shots and scores of both runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path
from typing import TypeVar

import numpy as np

from simcore.show.log_page import recording_of, scene_of_log
from simcore.show.page import write_page
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import read_log

__all__ = ["merged", "write_page_of_two"]

_OWN = ("Sim/Robot/", "Sim/Debug/", "Sim/Intake/")
_OF_ONE = ("Sim/Robots/", "Sim/Score/", "Sim/Placed/", "Sim/Performance/")
_FLYING = "Sim/InFlight"
_OF_BOTH = (_FLYING, "Sim/Held")
_SUMS = ("Sim/Shots", "Sim/Hits", "Sim/TakenIn")
_SCORES = ("Sim/Score/Old", "Sim/Score/New")
_INKS = ("path", "miss")
_APART = 100_000  # offset of the second run's piece ids and shot numbers
_EVENTS_APART = {
    "Sim/NewestShots": (_APART, _APART, 0, 0), "Sim/NewestHits": (_APART, _APART), "Sim/NewestTakenIn": (_APART, 0, 0)
}  # fmt: skip
_NONE = np.empty(0, np.int64)
_Value = TypeVar("_Value")


def write_page_of_two(
    path: str | Path, old: str | Path, new: str | Path, *, names: tuple[str, str], title: str = "", subtitle: str = ""
) -> None:
    """Write a page that shows robot 0 of two logs together, with a name and a color for each run.

    Args:
        path: Path of the page, usually with the suffix `.html`.
        old: Path of the first log; the page shows the pieces on the field from this log.
        new: Path of the second log.
        names: Names of the first and of the second run.
        title: Heading of the page.
        subtitle: Text next to the heading.

    Raises:
        LogError: If a log cannot be read or contains no run of a simulation.
        OutputError: If the page cannot be written.
    """
    both = merged(recording_of(read_log(old)), recording_of(read_log(new)))
    scene = scene_of_log(both)
    robots = [
        replace(look, name=name, ink=ink, score_key=key)
        for look, name, ink, key in zip(scene.robots, names, _INKS, _SCORES, strict=False)
    ]
    write_page(path, both, replace(scene, robots=robots), title=title, subtitle=subtitle)


def merged(old: Recording, new: Recording) -> Recording:
    """Merge two runs tick by tick into one recording with the duration of the longer run.

    The recording has robot 0 of both runs, the pieces in all robots of both runs, and all shots. The pieces on the
    field are those of the old run. `Sim/Score/Old` and `Sim/Score/New` are the points of the robots' alliances.
    """
    both = Recording(seconds=max(1.0, *(float(run.times[-1]) for run in (old, new))), bulk_period=old.bulk_period)
    last: list[Snapshot | None] = [None, None]
    for pair in zip_longest(old.snapshots(), new.snapshots()):
        last = [now or _landed(before) for now, before in zip(pair, last, strict=True)]
        if last[0] is not None and last[1] is not None:
            both.write(_both(last[0], last[1]))
    return both


def _landed(end: Snapshot | None) -> Snapshot | None:
    """Return a copy of the last snapshot of a run without pieces in flight, for the time after the end of the run."""
    if end is None:
        return None
    poses = {key: rows[:0] if key.startswith(_FLYING) else rows for key, rows in end.pose_arrays.items()}
    ids = {key: rows[:0] if key.startswith(_FLYING) else rows for key, rows in end.integer_arrays.items()}
    return replace(end, pose_arrays=poses, integer_arrays=ids)


def _both(old: Snapshot, new: Snapshot) -> Snapshot:
    integers = {key: value for key, value in _kept(old.integers, new.integers).items() if key not in _SUMS}
    for key, run in zip(_SCORES, (old, new), strict=True):
        is_red = run.booleans.get("Sim/Robot/IsRed", False)
        integers[key] = run.integers.get(f"Sim/Score/{'Red' if is_red else 'Blue'}", 0)
    poses, ids = _kept(old.pose_arrays, new.pose_arrays), _kept(old.integer_arrays, new.integer_arrays)
    for key, rows in new.pose_arrays.items():
        if key.startswith(_OF_BOTH):
            poses[key] = np.concatenate((old.pose_arrays.get(key, rows[:0]), rows))
    for key, numbers in new.integer_arrays.items():
        if key.startswith(_OF_BOTH):
            own = numbers + _APART if "Ids" in key else numbers
            ids[key] = np.concatenate((old.integer_arrays.get(key, numbers[:0]), own))
    for key, apart in _EVENTS_APART.items():
        events = new.integer_arrays.get(key, _NONE).reshape(-1, len(apart)) + apart
        if key == "Sim/NewestShots":
            events[:, 2] = 1  # the robot
        ids[key] = np.concatenate((old.integer_arrays.get(key, _NONE), events.ravel()))
    return Snapshot(
        time=max(old.time, new.time),
        tick=max(old.tick, new.tick),
        poses=_kept(old.poses, new.poses),
        pose_arrays=poses,
        state_arrays=_kept(old.state_arrays, new.state_arrays),
        doubles=_kept(old.doubles, new.doubles),
        integers=integers,
        booleans=_kept(old.booleans, new.booleans),
        integer_arrays=ids,
        strings=_kept(old.strings, new.strings),
    )


def _kept(old: Mapping[str, _Value], new: Mapping[str, _Value]) -> dict[str, _Value]:
    """Return the old run's values of robot 0, pieces and match, and the new run's values of robot 0 as robot 1."""
    kept = {key: value for key, value in old.items() if not key.startswith(_OF_ONE)}
    return kept | {f"Sim/Robots/1/{key.removeprefix('Sim/')}": v for key, v in new.items() if key.startswith(_OWN)}
