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
PYPROJECT = ROOT / "pyproject.toml"
EXAMPLE = ROOT / "examples" / "rebuilt_robot"

Scenario = Callable[..., dict[str, Any]]


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
    """Copies a robot project; returns what writes its tests and runs pytest, or another command, in the copy."""
    require_vendors()

    def copy(source: Path) -> Callable[..., tuple[int, str]]:
        folder = tmp_path / "robot"
        shutil.copytree(source, folder, ignore=shutil.ignore_patterns("__pycache__", "tests", "test_output"))
        (folder / "tests").mkdir()
        if not (folder / "deploy").exists():
            shutil.copy(ROBOTS / "shared" / "measures.py", folder)

        def run(text: str, *arguments: str, command: tuple[str, ...] = ("-m", "pytest", "-q"), **environment: str):
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
            return done.returncode, done.stdout + done.stderr

        run.folder = folder
        return run

    return copy


@pytest.fixture
def project(project_of):
    """The example, as `project_of` copies it."""
    return project_of(EXAMPLE)
