"""Runs scenarios in processes and folders of their own: Phoenix 6 keeps configurations in ./ctre_sim."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = Path(__file__).parent / "scenarios"

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
