"""Fixtures that run scenarios in separate processes and folders, since Phoenix 6 keeps configurations in ./ctre_sim."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import simcore

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = Path(simcore.__file__).resolve().parents[1]
"""Folder of the tested simcore: this checkout, or the site folder of its wheel."""
SCENARIOS = Path(__file__).parent / "scenarios"
ROBOTS = Path(__file__).parent / "robots"
PYPROJECT = ROOT / "pyproject.toml"
EXAMPLE = ROOT / "examples" / "rebuilt_robot"

ROBOTPY_TEST = ("-m", "robotpy", "test", "--", "-q")
"""Command line that runs the tests of a robot project; pytest options may follow."""

Scenario = Callable[..., dict[str, Any]]
Python = Callable[..., tuple[int, str]]

# --- files as PathPlanner writes them ---------------------------------------------------------------------------------

DRAWN = {
    "team_generated": (
        {"robotWidth": 0.85, "robotLength": 0.85, "robotMass": 55.0, "robotMOI": 5.5, "driveWheelRadius": 0.0508,
         "driveGearing": 6.746, "maxDriveSpeed": 4.58, "driveMotorType": "krakenX60FOC", "driveCurrentLimit": 80.0},
        (0.273, 0.273),
        {"Ahead": (2.0, 0.0, (2.0, 1.2), (3.0, 2.6))},
        {"Ahead": ["Ahead"]},
    ),
    "own_paths": (
        {"robotWidth": 0.86, "robotLength": 0.88, "robotMass": 57.0, "robotMOI": 6.2, "driveWheelRadius": 0.0381,
         "driveGearing": 4.714, "maxDriveSpeed": 4.8, "driveMotorType": "NEO", "driveCurrentLimit": 50.0},
        (0.33655, 0.33655),
        {"into depot": (2.0, 0.0, (2.6, 5.6), (1.3, 5.6), (0.62, 5.62)), "across": (1.0, 0.0, (0.62, 5.62), (0.6, 6.3)),
         "back across": (1.0, 0.0, (0.6, 6.3), (0.55, 5.6)),
         "to hub": (2.0, -30.4, (0.55, 5.6), (1.4, 5.55), (2.3, 5.4))},
        {"depot": ["!take in", "into depot", "across", "back across", "across", "back across", "!stow", "to hub",
                   ("!shoot", 6.5), "!stop"]},
    ),
}  # fmt: skip
"""Settings by robot: dimensions, place of the front left module, paths (top speed, final heading, points), autos.

An auto is a list of steps; `!` marks a named command, with a time limit [s] if there is one.
"""


def draw_autos(folder: Path, robot: str) -> None:
    """Write settings, paths and autos of a robot in `DRAWN` into a copy of its project."""
    measures, (x, y), paths, autos = DRAWN[robot]
    corners = {"fl": (x, y), "fr": (x, -y), "bl": (-x, y), "br": (-x, -y)}
    limits = {"defaultMaxVel": 3.0, "defaultMaxAccel": 3.5, "defaultMaxAngVel": 360.0, "defaultMaxAngAccel": 540.0}
    settings = {
        **{"holonomicMode": True, "pathFolders": [], "autoFolders": [], "robotFeatures": [], "bumperOffsetX": 0.0},
        **{"defaultNominalVoltage": 12.0, "robotTrackwidth": 2.0 * y, "wheelCOF": 1.2, "bumperOffsetY": 0.0, **limits},
        **{f"{name}Module{axis}": v for name, at in corners.items() for axis, v in zip("XY", at, strict=True)},
        **measures,
    }
    deploy = folder / "deploy" / "pathplanner"
    for place in (deploy / "paths", deploy / "autos"):
        place.mkdir(parents=True)
    (deploy / "settings.json").write_text(json.dumps(settings))
    for name, (speed, heading, *points) in paths.items():
        (deploy / "paths" / f"{name}.path").write_text(json.dumps(_path(speed, heading, points)))
    for name, steps in autos.items():
        command = {"type": "sequential", "data": {"commands": [_step(step) for step in steps]}}
        auto = {"version": "2025.0", "command": command, "resetOdom": True, "folder": None, "choreoAuto": False}
        (deploy / "autos" / f"{name}.auto").write_text(json.dumps(auto))


def _path(speed: float, heading: float, points: list[tuple[float, float]]) -> dict[str, Any]:
    """Return a path through points, with control points at thirds of the way to the next point."""

    def control(k: int, other: int) -> dict[str, float] | None:
        if not 0 <= other < len(points):
            return None
        (x, y), (u, v) = points[k], points[other]
        return {"x": x + (u - x) / 3.0, "y": y + (v - y) / 3.0}

    lists = ("rotationTargets", "constraintZones", "pointTowardsZones", "eventMarkers")
    return {
        "version": "2025.0",
        "waypoints": [
            {"anchor": {"x": x, "y": y}, "prevControl": control(k, k - 1), "nextControl": control(k, k + 1),
             "isLocked": False, "linkedName": None}
            for k, (x, y) in enumerate(points)
        ],
        **{name: [] for name in lists},
        "globalConstraints": {
            **{"maxVelocity": speed, "maxAcceleration": 3.0, "maxAngularVelocity": 360.0},
            **{"maxAngularAcceleration": 540.0, "nominalVoltage": 12.0, "unlimited": False},
        },
        "goalEndState": {"velocity": 0.0, "rotation": heading},
        "idealStartingState": {"velocity": 0.0, "rotation": 0.0},
        **{"reversed": False, "folder": None, "useDefaultConstraints": False},
    }  # fmt: skip


def _step(step: str | tuple[str, float]) -> dict[str, Any]:
    if isinstance(step, tuple):
        wait = {"type": "wait", "data": {"waitTime": step[1]}}
        return {"type": "race", "data": {"commands": [_step(step[0]), wait]}}
    if step.startswith("!"):
        return {"type": "named", "data": {"name": step[1:]}}
    return {"type": "path", "data": {"pathName": step}}


def require_vendors() -> None:
    """Skip the test if a library that robot code needs is not installed."""
    for module in ("phoenix6", "wpilib", "commands2", "pyfrc"):
        if find_spec(module) is None and not (module == "pyfrc" and find_spec("wpilib.testing")):
            pytest.skip(f"needs {module}: pip install .[phoenix6,robotpy]")


@pytest.fixture(scope="session")
def scenario(tmp_path_factory, distribution) -> Scenario:
    """Return a function that runs a scenario and returns its report, or skips on a machine too busy for real time."""
    require_vendors()

    def run(
        name: str, *args: str, timeout: float = 90.0, path: tuple[Path, ...] = (), **environment: str
    ) -> dict[str, Any]:
        places = os.pathsep.join(map(str, (*path, distribution, PACKAGES, SCENARIOS)))
        done = subprocess.run(
            [sys.executable, str(SCENARIOS / f"{name}.py"), *args],
            cwd=tmp_path_factory.mktemp(name),
            env={
                **os.environ,
                **environment,
                "PYTHONPATH": places,
            },
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )
        assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
        result = json.loads(next(line for line in reversed(done.stdout.splitlines()) if line.startswith("{")))
        if result["lateness_ms"] > 5.0:
            pytest.skip(f"machine too busy for real time: physics came {result['lateness_ms']:.1f} ms late (p99)")
        return {**result, "output": done.stdout + done.stderr}

    return run


@pytest.fixture(scope="session")
def install() -> Callable[[Path, str, dict[str, str]], None]:
    """Return a function that writes a distribution as pip installs it: name and entry points by group."""

    def install(folder: Path, name: str, entry_points: dict[str, str]) -> None:
        info = folder / f"{name}-0.1.0.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.1.0\nSummary: {name}\n")
        rows = "".join(f"[{group}]\n{lines}\n" for group, lines in entry_points.items())
        (info / "entry_points.txt").write_text(rows)

    return install


@pytest.fixture(scope="session")
def distribution(tmp_path_factory, install) -> Path:
    """Return a folder for PYTHONPATH with the entry points of this checkout and nothing else."""
    folder = tmp_path_factory.mktemp("site")
    declared = re.findall(r'\[project\.(scripts|entry-points\.\S+)\]\n((?:\w+ = "[^"]+"\n)+)', PYPROJECT.read_text())
    groups = {kind.removeprefix("entry-points.").strip('"'): rows.replace('"', "") for kind, rows in declared}
    install(folder, "simcore", groups)
    return folder


@pytest.fixture(scope="session")
def python(distribution) -> Python:
    """Return a function that runs Python in a folder with simcore installed and returns status and output."""

    def run(
        folder: Path, *arguments: str, path: tuple[Path, ...] = (), on_screen: bool = False, **environment: str
    ) -> tuple[int, str]:
        places = [*map(str, (*path, distribution, PACKAGES)), *filter(None, [os.environ.get("PYTHONPATH")])]
        done = subprocess.run(
            [sys.executable, *arguments],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(places), **environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT if on_screen else subprocess.PIPE,  # interleaved as on a screen
            text=True,
            timeout=900,  # ends a hanging process; a busy machine needs ten times as long as an idle one
            check=False,
        )
        return done.returncode, (done.stderr or "") + done.stdout

    return run


@pytest.fixture
def project_of(tmp_path, python):
    """Return a function that makes a robot project from a folder, the text of robot.py or texts by file.

    It returns a function that writes the tests of the project and runs them, or another command.
    """
    require_vendors()

    def make(source: Path | str | dict[str, str]) -> Callable[..., tuple[int, str]]:
        folder = tmp_path / "robot"
        if isinstance(source, Path):
            shutil.copytree(source, folder, ignore=shutil.ignore_patterns("__pycache__", "tests", "test_output"))
            if source.name in DRAWN:
                draw_autos(folder, source.name)
        else:
            folder.mkdir()
            for name, text in ({"robot.py": source} if isinstance(source, str) else source).items():
                (folder / name).write_text(text)
        (folder / "tests").mkdir()
        if not isinstance(source, Path) or source.parent == ROBOTS:
            for library in (ROBOTS / "shared").glob("*.py"):
                shutil.copy(library, folder)

        def run(text: str, *arguments: str, command: tuple[str, ...] = ROBOTPY_TEST, **options: Any):
            (folder / "tests" / "test_robot.py").write_text(text)
            return python(folder, *command, *arguments, **options)

        run.folder = folder
        return run

    return make


@pytest.fixture
def project(project_of):
    """Return the REBUILT example as copied by `project_of`."""
    return project_of(EXAMPLE)
