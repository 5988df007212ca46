"""`simcore init --ci`: a GitHub workflow that runs a project's robot tests and keeps what failed ones leave."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError, OutputError
from simcore.install_text import shared_requirement
from simcore.robot_file.key_tables import read_toml

__all__ = ["workflow_text", "write_workflow"]

_NAME = "robot-tests.yml"
_WORKFLOW = """\
# Written by `simcore init --ci`: runs the robot tests of this project in simulation.
name: robot tests

on: [push, pull_request]

permissions:
  contents: read

jobs:
  robot-tests:
    runs-on: ubuntu-24.04
    timeout-minutes: 30
    defaults:
      run:
        working-directory: {folder}
    steps:
      - uses: actions/checkout@de0fac2e4500dabe0009e67214ff5f5447ce83dd # v6.0.2
        with:
          persist-credentials: false
      - uses: actions/setup-python@a309ff8b426b58ec0e2a45f0f869d46889d02405 # v6.2.0
        with:
          python-version: "3.12"
          cache: pip
          cache-dependency-path: .github/workflows/{name}
      - run: python -m pip install {packages}
      - run: python -m pytest
      - if: failure() # log and page of each failed test
        uses: actions/upload-artifact@b7c566a772e6b6bfb58ed0dc250532a479d7789f # v6.0.0
        with:
          name: failed-robot-tests
          path: {output}
          if-no-files-found: ignore
"""


def write_workflow(robot_file: Path, *, source: str, force: bool) -> Path:
    """Write the workflow into the repository of a robot project.

    Args:
        robot_file: Its robot.py.
        source: From where pip can install simcore there; empty: from where it was installed here.
        force: Overwrite one that is there.

    Raises:
        ConfigError: It is there already, the project is in no git repository, or nobody knows where simcore is from.
        OutputError: It cannot be written.
    """
    project = robot_file.resolve().parent
    root = next((folder for folder in (project, *project.parents) if (folder / ".git").exists()), None)
    if root is None:
        raise ConfigError(f"{project} is in no git repository: `git init` makes one")
    simcore = shared_requirement("phoenix6", "robotpy", source=source)
    if not simcore:
        raise ConfigError(
            "simcore is from a folder of this computer that is no clone, which GitHub cannot reach: say where it gets "
            "it, as in `simcore init --ci --source git+https://...`, with the address of simcore's repository"
        )
    path = root / ".github" / "workflows" / _NAME
    if path.exists() and not force:
        raise ConfigError(f"{path} is there already; simcore init --ci --force overwrites it")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(workflow_text(project, root, simcore), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from error
    return path


def workflow_text(project: Path, root: Path, simcore: str) -> str:
    """The workflow of a project in a folder of a repository, with the requirement that brings simcore."""
    folder = project.relative_to(root).as_posix()
    packages = [simcore, *_packages(project)]
    listed = " ".join(f'"{name}"' for name in packages)
    listed += " -r requirements.txt" if (project / "requirements.txt").is_file() else ""
    output = "test_output" if folder == "." else f"{folder}/test_output"
    return _WORKFLOW.format(folder=json.dumps(folder), name=_NAME, packages=listed, output=json.dumps(output))


def _packages(project: Path) -> list[str]:
    """What RobotPy installs for a project, by its pyproject.toml."""
    file = project / "pyproject.toml"
    told: dict[str, Any] = read_toml(file).get("tool", {}).get("robotpy", {}) if file.is_file() else {}
    extras = ",".join(told.get("components", ()))
    robotpy = "robotpy" + (f"[{extras}]" if extras else "")
    robotpy += f"=={told['robotpy_version']}" if "robotpy_version" in told else ""
    return [robotpy, *told.get("requires", ())]
