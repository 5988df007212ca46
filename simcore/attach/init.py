"""`simcore init`: writes a commented `simcore.toml` beside robot.py, with the motors that the program builds."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

from simcore.attach.read import FILE_NAME
from simcore.attach.template import FoundMotor, template
from simcore.errors import ConfigError, OutputError

__all__ = ["add_arguments", "look_at_robot", "run"]

_LOOK_SECONDS = 20.0


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
            f"no robot.py in {folder.resolve()}: go to the folder of your robot project, or name it: simcore init FOLDER"
        )
    if path.exists() and not args.force:
        raise ConfigError(f"{path} is there already; simcore init --force overwrites it")
    motors: list[FoundMotor] | None = None
    if args.no_look:
        print("not looked at the robot program: fill in the mechanisms by hand")
    else:
        motors, why_not = look_at_robot(folder)
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


def look_at_robot(folder: Path) -> tuple[list[FoundMotor] | None, str]:
    """Build the robot in a process of its own and ask it for its motors.

    Returns:
        The motors, and ""; or None, and why not.
    """
    for module in ("phoenix6", "wpilib"):
        if find_spec(module) is None:
            return None, f"{module} is not installed"
    try:
        done = subprocess.run(
            [sys.executable, "-m", "simcore.robotpy.look", str(folder.resolve() / "robot.py")],
            capture_output=True,
            text=True,
            timeout=_LOOK_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return None, f"it did not start within {_LOOK_SECONDS:.0f} s"
    answer = next((line for line in reversed(done.stdout.splitlines()) if line.startswith('{"motors"')), None)
    if answer is None:
        said = [line for line in done.stderr.splitlines() if line.strip()]
        return None, said[-1].strip() if said else "it said nothing"
    return [
        FoundMotor(**{**m, "followers": tuple(m["followers"]), "opposed": tuple(m["opposed"])})
        for m in json.loads(answer)["motors"]
    ], ""
