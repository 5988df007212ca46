"""Functions that write the log and the page of a failed test's run, and that describe a recorded run as a scene."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from simcore.show.page import write_page
from simcore.show.scene import RobotLook, Scene
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import discard_empty
from simcore.telemetry.wpilog import WpilogSink

__all__ = ["FailedRunFiles", "save_failed_run", "write_log"]

_RESERVED = re.compile(r"(?i)^(con|prn|aux|nul|com\d|lpt\d)(\.|$)")
_OTHERS = re.compile(r"^Sim/Robots/(\d+)/Robot/Pose3d$")
_BUMPERS = (0.8, 0.8)  # [m]; assumed, because telemetry has no robot sizes
_LONGEST = 100  # [characters]; longest file name


@dataclass(frozen=True, slots=True, kw_only=True)
class FailedRunFiles:
    """Paths of the files written for a failed test; `str()` returns a sentence with the paths."""

    page: Path | None = None
    log: Path | None = None
    problems: tuple[str, ...] = ()
    """Reasons why files are missing, one sentence each."""

    def __str__(self) -> str:
        found = {"page": self.page, "log": self.log}
        written = [f"{kind} {path}" for kind, path in found.items() if path is not None]
        said = [f"look at the run: {', '.join(written)}"] if written else ["nothing of the run could be kept"]
        return "; ".join((*said, *self.problems))


def save_failed_run(
    recording: Recording,
    folder: str | Path,
    *,
    name: str = "run",
    scene: Scene | None = None,
    title: str = "",
    note: str = "",
) -> FailedRunFiles:
    """Write the log and the page of a run that may have ended early, and report errors in the result.

    Args:
        recording: Recording of the run, which `game.sinks.append(recording)` adds before the first tick.
        folder: Folder for the files, created if missing; existing files are overwritten.
        name: File name without suffix; characters that file systems forbid are replaced.
        scene: Scene of the run, from `game.scene()`; None for an empty field that is large enough for the motion.
        title: Heading of the page; empty to use `name`.
        note: Text under the heading, e.g. the test's expectation.

    Returns:
        Paths of the files, with a sentence in `problems` for each file that could not be written.
    """
    stem = Path(folder) / safe_name(name)
    if not len(recording):
        return FailedRunFiles(problems=("no tick was recorded before the end",))
    title = title or name
    problems: list[str] = []
    # Each file is written even if the other fails. The log comes first, because it needs only a disk.
    files: dict[str, tuple[Path, Callable[[Path], None]]] = {
        "log": (stem.with_name(stem.name + ".wpilog"), lambda path: write_log(recording, path)),
        "page": (
            stem.with_name(stem.name + ".html"),
            lambda path: write_page(path, recording, scene or empty_scene(recording), title=title, subtitle=note),
        ),
    }
    written = {}
    for kind, (path, write) in files.items():
        try:
            write(path)
            written[kind] = path
        except Exception as error:  # an error here must not hide the test's own failure
            discard_empty(path)
            problems.append(f"no {kind}: {error}")
    return FailedRunFiles(**written, problems=tuple(problems))


def write_log(recording: Recording, path: str | Path) -> None:
    """Write a recording as the `.wpilog` that a `WpilogSink` with the same `bulk_period` would have written.

    Raises:
        OutputError: If the file cannot be written.
    """
    with WpilogSink(path, bulk_period=recording.bulk_period) as sink:
        for snapshot in recording.snapshots():
            sink.write(snapshot)


def empty_scene(recording: Recording) -> Scene:
    """Return a scene with the recorded robots on an empty field that is large enough for the motion of the robots."""
    robots = recorded_robots(recording)
    places = [recording.path(robot.pose_key)[:, :2] for robot in robots]
    farthest = [rows.max(axis=0) for rows in places if len(rows)]
    x, y = (max((float(corner[i]) for corner in farthest), default=0.0) for i in (0, 1))
    return Scene(field_size=(max(x + 1.0, 2.0), max(y + 1.0, 2.0)), robots=robots)


def recorded_robots(recording: Recording) -> tuple[RobotLook, ...]:
    """Return the looks of the recorded robots in order of robot number; robot 0 is always included."""
    others = sorted(int(match[1]) for match in map(_OTHERS.match, recording.keys) if match)
    robots = []
    for prefix in ("Sim", *(f"Sim/Robots/{number}" for number in others)):
        is_red = f"{prefix}/Robot/IsRed"
        red = recording.has(is_red) and bool(recording.series(is_red)[1][-1])
        plays = f"{prefix}/Robot/Player"
        role = recording.strings(plays)[1][-1] if recording.has(plays) else ""
        robots.append(RobotLook(prefix=prefix, alliance="red" if red else "blue", bumpers=_BUMPERS, role=role))
    return tuple(robots)


def safe_name(name: str) -> str:
    """Convert any text to a file name that is valid on every operating system, cut to about 100 characters.

    >>> safe_name("test_auto[red/3] äöü?")
    'test_auto_red_3_äöü'
    >>> safe_name("nul"), safe_name("..")
    ('_nul', 'run')
    """
    kept = re.sub(r"[^\w.-]+", "_", name).strip("._")[:_LONGEST].rstrip("._")
    return f"_{kept}" if _RESERVED.match(kept) else kept or "run"
