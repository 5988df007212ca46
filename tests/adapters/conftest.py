"""Runs scenarios in processes and folders of their own: Phoenix 6 keeps configurations in ./ctre_sim."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = Path(__file__).parent / "scenarios"
EXAMPLE = ROOT / "examples" / "rebuilt_robot"

Scenario = Callable[..., dict[str, Any]]


@pytest.fixture(scope="session")
def scenario(tmp_path_factory) -> Scenario:
    """Runs a scenario by name and returns its report; skips where the machine is too busy for real time."""
    for module in ("phoenix6", "wpilib", "commands2", "pyfrc", "pybullet"):
        if find_spec(module) is None:
            pytest.skip(f"needs {module}: pip install simcore[phoenix6,robotpy]")

    def run(name: str, *args: str, timeout: float = 90.0, **environment: str) -> dict[str, Any]:
        done = subprocess.run(
            [sys.executable, str(SCENARIOS / f"{name}.py"), *args],
            cwd=tmp_path_factory.mktemp(name),
            env={**os.environ, **environment, "PYTHONPATH": os.pathsep.join((str(ROOT), str(SCENARIOS)))},
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


@pytest.fixture
def project(tmp_path):
    """A copy of the example with tests of our own; returns what writes them and runs pytest."""
    for module in ("phoenix6", "wpilib", "commands2", "pyfrc", "pybullet"):
        if find_spec(module) is None:
            pytest.skip(f"needs {module}: pip install simcore[phoenix6,robotpy]")
    folder = tmp_path / "robot"
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns("__pycache__", "tests", "test_output"))
    (folder / "tests").mkdir()

    def run(text: str, *arguments: str, command: tuple[str, ...] = ("-m", "pytest", "-q"), **environment: str):
        (folder / "tests" / "test_robot.py").write_text(text)
        named = () if find_spec("simcore") and _is_installed() else ("-p", "simcore.robotpy.pytest_plugin")
        if named and command[1] == "robotpy":
            pytest.skip("needs an installed simcore: pip install -e .")
        done = subprocess.run(
            [sys.executable, *command, *named, *arguments],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
            capture_output=True,
            text=True,
            timeout=240,
            check=False,
        )
        return done.returncode, done.stdout + done.stderr

    run.folder = folder
    return run


def _is_installed() -> bool:
    from importlib.metadata import entry_points

    return any(e.value == "simcore.robotpy.pytest_plugin" for e in entry_points(group="pytest11"))
