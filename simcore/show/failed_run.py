"""Files of a failed test: log and page of the run, and a sentence with their places."""

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
_BUMPERS = (0.8, 0.8)  # [m]; telemetry does not say how large robots are
_LONGEST = 100  # letters of a file name


@dataclass(frozen=True, slots=True, kw_only=True)
class FailedRunFiles:
    """The files that were written; printed as one sentence."""

    page: Path | None = None
    log: Path | None = None
    problems: tuple[str, ...] = ()
    """Reasons why files are missing, a sentence each."""

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
    """Write log and page of a run, also one that ended badly or is still running; raises nothing.

    Args:
        recording: The run, kept by `game.sinks.append(recording)` before its first tick.
        folder: Made if missing; files of the same name are overwritten.
        name: Name of the files, without suffix; characters that a file system forbids are replaced.
        scene: Scene from `game.scene()`, also after the game was closed; None: an empty field as large as the run.
        title: Title in large letters; None: the name.
        note: Under it, e.g. what the test expected.

    Returns:
        Where everything is; what could not be written is a sentence in `problems`.
    """
    stem = Path(folder) / safe_name(name)
    if not len(recording):
        return FailedRunFiles(problems=("no tick was recorded before the end",))
    title = title or name
    problems: list[str] = []
    # Each file is written even if another fails: the log first, for it needs nothing but a disk.
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
        except Exception as error:  # the test's own failure is what matters, whatever happens here
            discard_empty(path)
            problems.append(f"no {kind}: {error}")
    return FailedRunFiles(**written, problems=tuple(problems))


def write_log(recording: Recording, path: str | Path) -> None:
    """Write what was recorded as a `.wpilog`, as a `WpilogSink` of the same `bulk_period` would have done.

    Raises:
        OutputError: The file cannot be written.
    """
    with WpilogSink(path, bulk_period=recording.bulk_period) as sink:
        for snapshot in recording.snapshots():
            sink.write(snapshot)


def empty_scene(recording: Recording) -> Scene:
    """Return a bare field that covers all motion, with the recorded robots, for a game without a scene."""
    robots = recorded_robots(recording)
    places = [recording.path(robot.pose_key)[:, :2] for robot in robots]
    farthest = [rows.max(axis=0) for rows in places if len(rows)]
    x, y = (max((float(corner[i]) for corner in farthest), default=0.0) for i in (0, 1))
    return Scene(field_size=(max(x + 1.0, 2.0), max(y + 1.0, 2.0)), robots=robots)


def recorded_robots(recording: Recording) -> tuple[RobotLook, ...]:
    """Return the robots of a recording by number; the first is included even if it was not recorded."""
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
    """Turn any text into a file name that is valid on every system.

    >>> safe_name("test_auto[red/3] äöü?")
    'test_auto_red_3_äöü'
    >>> safe_name("nul"), safe_name("..")
    ('_nul', 'run')
    """
    kept = re.sub(r"[^\w.-]+", "_", name).strip("._")[:_LONGEST].rstrip("._")
    return f"_{kept}" if _RESERVED.match(kept) else kept or "run"
