"""Runs scenarios in processes and folders of their own: Phoenix 6 keeps configurations in ./ctre_sim."""

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
"""The folder of the simcore that is tested: this checkout, or where its wheel is installed."""
SCENARIOS = Path(__file__).parent / "scenarios"
ROBOTS = Path(__file__).parent / "robots"
LIBRARIES = ("measures.py", "questnav.py", "logged_robot.py")
"""Of `robots/shared`: what robot programs there have beside them."""
PYPROJECT = ROOT / "pyproject.toml"
EXAMPLE = ROOT / "examples" / "rebuilt_robot"

ROBOTPY_TEST = ("-m", "robotpy", "test", "--", "-q")
"""What runs the tests of a robot project; options of pytest may follow."""

Scenario = Callable[..., dict[str, Any]]

# --- what PathPlanner's window writes --------------------------------------------------------------------------------

DRAWN = {
    "team_paths": (
        {"robotWidth": 0.76, "robotLength": 0.88, "robotMass": 57.0, "robotMOI": 6.2, "driveWheelRadius": 0.0508,
         "driveGearing": 6.12, "maxDriveSpeed": 4.9, "driveMotorType": "krakenX60FOC", "driveCurrentLimit": 80.0},
        (0.2731, 0.2731),
        {"into depot": (2.0, 0.0, (2.6, 5.6), (1.3, 5.6), (0.62, 5.62)), "across": (1.0, 0.0, (0.62, 5.62), (0.6, 6.3)),
         "back across": (1.0, 0.0, (0.6, 6.3), (0.55, 5.6)),
         "to hub": (2.0, -30.4, (0.55, 5.6), (1.4, 5.55), (2.3, 5.4))},
        {"depot": ["!take in", "into depot", "across", "back across", "across", "back across", "!stow", "to hub",
                   ("!shoot", 6.5), "!stop"]},
    ),
    "team_generated": (
        {"robotWidth": 0.85, "robotLength": 0.85, "robotMass": 55.0, "robotMOI": 5.5, "driveWheelRadius": 0.0508,
         "driveGearing": 6.746, "maxDriveSpeed": 4.58, "driveMotorType": "krakenX60FOC", "driveCurrentLimit": 80.0},
        (0.273, 0.273),
        {"Ahead": (2.0, 0.0, (2.0, 1.2), (3.0, 2.6))},
        {"Ahead": ["Ahead"]},
    ),
}  # fmt: skip
"""By robot: its measures, the place of its front left module, paths (top speed, last heading, points), autos by steps:
`!` begins a named command, which a number ends after so many seconds."""
DRAWN["own_paths"] = (
    {"robotWidth": 0.86, "robotLength": 0.88, "robotMass": 57.0, "robotMOI": 6.2, "driveWheelRadius": 0.0381,
     "driveGearing": 4.714, "maxDriveSpeed": 4.8, "driveMotorType": "NEO", "driveCurrentLimit": 50.0},
    (0.33655, 0.33655),
    *DRAWN["team_paths"][2:],
)  # fmt: skip


def draw_autos(folder: Path, robot: str) -> None:
    """Write settings, paths and autos of a robot of `DRAWN` into a copy of its project; of others nothing."""
    if robot not in DRAWN:
        return
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
    """Through points, with control points at thirds of the way to the next."""

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


@pytest.fixture(scope="session")
def drawn() -> Callable[[Path, str], None]:
    """See `draw_autos`."""
    return draw_autos


def require_vendors() -> None:
    """Skip where a library that robot code needs is not installed."""
    for module in ("phoenix6", "wpilib", "commands2", "pyfrc"):
        if find_spec(module) is None and not (module == "pyfrc" and find_spec("wpilib.testing")):
            pytest.skip(f"needs {module}: pip install .[phoenix6,robotpy]")


@pytest.fixture(scope="session")
def scenario(tmp_path_factory, distribution) -> Scenario:
    """Runs a scenario by name and returns its report; skips where the machine is too busy for real time."""
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
    """Leaves in a folder for PYTHONPATH what pip leaves of a distribution: its name and its entry points by group."""

    def install(folder: Path, name: str, entry_points: dict[str, str]) -> None:
        info = folder / f"{name}-0.1.0.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.1.0\nSummary: {name}\n")
        rows = "".join(f"[{group}]\n{lines}\n" for group, lines in entry_points.items())
        (info / "entry_points.txt").write_text(rows)

    return install


@pytest.fixture(scope="session")
def distribution(tmp_path_factory, install) -> Path:
    """A folder for PYTHONPATH in which this checkout is installed: its entry points, and nothing else."""
    folder = tmp_path_factory.mktemp("site")
    declared = re.findall(r'\[project\.(scripts|entry-points\.\S+)\]\n((?:\w+ = "[^"]+"\n)+)', PYPROJECT.read_text())
    groups = {kind.removeprefix("entry-points.").strip('"'): rows.replace('"', "") for kind, rows in declared}
    install(folder, "simcore", groups)
    return folder


@pytest.fixture
def project_of(tmp_path, distribution):
    """Copies a robot project; returns what writes its tests and runs them, or another command, in the copy."""
    require_vendors()

    def copy(source: Path) -> Callable[..., tuple[int, str]]:
        folder = tmp_path / "robot"
        shutil.copytree(source, folder, ignore=shutil.ignore_patterns("__pycache__", "tests", "test_output"))
        (folder / "tests").mkdir()
        if source.parent == ROBOTS and source.name in DRAWN:
            draw_autos(folder, source.name)
        elif not (folder / "deploy").exists():
            for library in LIBRARIES:
                shutil.copy(ROBOTS / "shared" / library, folder)

        def run(text: str, *arguments: str, command: tuple[str, ...] = ROBOTPY_TEST, **environment: str):
            (folder / "tests" / "test_robot.py").write_text(text)
            path = os.pathsep.join(map(str, (distribution, PACKAGES)))
            done = subprocess.run(
                [sys.executable, *command, *arguments],
                cwd=folder,
                env={**os.environ, "PYTHONPATH": path, **environment},
                capture_output=True,
                text=True,
                timeout=900,  # ends what hangs; a busy machine needs ten times as long as an idle one
                check=False,
            )
            return done.returncode, done.stderr + done.stdout

        run.folder = folder
        return run

    return copy


@pytest.fixture
def project(project_of):
    """The example, as `project_of` copies it."""
    return project_of(EXAMPLE)
