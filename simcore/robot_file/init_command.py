"""`simcore init`: writes a commented `simcore.toml` beside robot.py, with the motors that the program builds."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError, OutputError
from simcore.robot_file.robot_settings import FILE_NAME
from simcore.robot_file.template import FoundMotor, template

__all__ = ["add_arguments", "find_motors", "run", "survey"]

_LOOK_SECONDS = 60.0  # it takes 3 to 6; on a busy computer several times that


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """What `simcore init` takes."""
    parser.add_argument("folder", nargs="?", type=Path, default=Path(), help="where robot.py is (default: here)")
    parser.add_argument("--force", action="store_true", help=f"overwrite a {FILE_NAME} that is there")
    parser.add_argument("--no-look", action="store_true", help="do not start the robot program to find its motors")


def run(args: argparse.Namespace) -> int:
    """Write the file.

    Raises:
        ConfigError: There is no robot.py, or the file is there already.
        OutputError: The folder cannot be written.
    """
    folder: Path = args.folder
    path = folder / FILE_NAME
    if not (folder / "robot.py").is_file():
        raise ConfigError(
            f"no robot.py in {folder.resolve()}: go to your robot project, or name its folder: simcore init FOLDER"
        )
    if path.exists() and not args.force:
        raise ConfigError(f"{path} is there already; simcore init --force overwrites it")
    motors: list[FoundMotor] | None = None
    if args.no_look:
        print("not looked at the robot program: fill in the mechanisms by hand")
    else:
        motors, why_not = find_motors(folder)
        if why_not:
            print(f"could not look at the robot program ({why_not}): fill in the mechanisms by hand")
    try:
        path.write_text(template(motors), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from error
    if motors:
        print(f"found {len(motors)} motors or groups of motors besides the drivetrain")
    print(f"wrote {path}; now: python -m robotpy sim --simcore")
    return 0


def find_motors(folder: Path) -> tuple[list[FoundMotor] | None, str]:
    """Build the robot in a process of its own and ask it for its motors.

    Returns:
        The motors, and ""; or None, and why not.
    """
    answer, why_not = survey(folder, "simcore.robotpy.motor_survey")
    if answer is None:
        return None, why_not
    return [
        FoundMotor(**{**m, "followers": tuple(m["followers"]), "opposed": tuple(m["opposed"])})
        for m in answer["motors"]
    ], ""


def survey(folder: Path, module: str) -> tuple[dict[str, Any] | None, str]:
    """Build the robot program in a process of its own, and let a module of ours ask it.

    Args:
        folder: Where robot.py is.
        module: Is run with the path of robot.py, and prints its answer as a line of JSON.

    Returns:
        The answer, and ""; or None, and why not.
    """
    for needed in ("phoenix6", "wpilib"):
        if find_spec(needed) is None:
            return None, f"{needed} is not installed"
    path = [str(Path(__file__).resolve().parents[2]), *filter(None, [os.environ.get("PYTHONPATH")])]
    try:
        # In a folder of its own: devices keep their configurations in ./ctre_sim.
        with tempfile.TemporaryDirectory() as scratch:
            done = subprocess.run(
                [sys.executable, "-m", module, str(folder.resolve() / "robot.py")],
                cwd=scratch,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(path)},
                capture_output=True,
                text=True,
                timeout=_LOOK_SECONDS,
                check=False,
            )
    except subprocess.TimeoutExpired:
        return None, f"it did not start within {_LOOK_SECONDS:.0f} s"
    line = next((line for line in reversed(done.stdout.splitlines()) if line.startswith('{"')), None)
    answer: dict[str, Any] = {"error": f"it ended with code {done.returncode}"} if line is None else json.loads(line)
    if "error" in answer:
        return None, answer["error"]
    return answer, ""
