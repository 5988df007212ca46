"""Command `simcore init`: writes a `simcore.toml` next to robot.py, with the devices that the program builds."""

from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError, OutputError
from simcore.install_text import is_source, shared_requirement
from simcore.loop.step import prepare
from simcore.match.registry import installed_games
from simcore.robot_file.key_tables import read_toml
from simcore.robot_file.reader import read_settings
from simcore.robot_file.template import FILE_NAME, template

__all__ = ["add_arguments", "find_robot_py", "run", "survey"]

_LOOK_SECONDS = 180.0  # a laptop imports a robot program in 10 to 20 s, a busy laptop in 60 s
_NOT_LINKED = ("ctre_sim", "logs", "__pycache__", "networktables.json")
"""Names of files and folders that programs write; through a link, the survey would write into the project."""
_LEFT_BEHIND = (
    *("__pycache__/", "ctre_sim/", "logs/", "out/", "test_output/", "networktables.json", "networktables.json.bck"),
    *("simgui.json", "simgui-window.json", "*.wpilog", "*.hoot"),
)
"""Lines for .gitignore; `simgui-ds.json` is missing because teams share its keyboard and gamepad setup."""
_OWN_SIMULATION = re.compile(r"\bsim_state\b|\bSpark\w*Sim\b|SimCollection\b|\bset_raw_rotor_position\b")
_WORKFLOW = Path(__file__).with_name("robot-tests.yml")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `simcore init`."""
    parser.add_argument(
        "folder", nargs="?", type=Path, default=Path(), help="the robot project, or its robot.py (default: here)"
    )
    parser.add_argument("--all", action="store_true", help="write all other keys too, in comments")
    parser.add_argument("--force", action="store_true", help="overwrite the file if it is there")
    parser.add_argument(
        "--ci", action="store_true", help="write a GitHub workflow that runs the robot tests, and nothing else"
    )
    parser.add_argument("--source", default="", metavar="ADDRESS", help="with --ci: git+https://... of simcore")
    parser.add_argument("--no-look", action="store_true", help="do not start the robot program to find its devices")


def run(args: argparse.Namespace) -> int:
    """Write `simcore.toml` and .gitignore and start the program with the file, or write the workflow with `--ci`.

    Returns:
        Exit status: 1 if the program does not start with the file, else 0.

    Raises:
        ConfigError: There is no robot.py, the program does not load, or the file exists and `--force` is missing.
        OutputError: A file cannot be written.
    """
    robot_file = find_robot_py(args.folder)
    if args.ci:
        written = write_workflow(robot_file, source=args.source, force=args.force)
        print(f"wrote {written}; commit and push it: GitHub then runs the robot tests at every push")
        return 0
    path = robot_file.parent / FILE_NAME
    if path.exists() and not args.force:
        raise ConfigError(f"{path} already exists; simcore init --force overwrites it")
    if not args.no_look:
        prepare()  # the first compilation on a computer takes longer than the allowed start of a program
    found = {} if args.no_look else survey(robot_file)
    if "error" in found:
        raise ConfigError(
            f"the robot program does not load ({found['error']}), so nothing is written; fix that first, or write the "
            "file without looking at it: simcore init --no-look"
        )
    for line in _survey_report(found, is_asked=not args.no_look):
        print(line)
    if found and _simulates_itself(robot_file.parent):
        for m in found.get("motors", ()):
            m["turns_freely"] = False
            m["remark"] = m["remark"] or "your program has its own simulation, which may move it"
    game = next(iter(installed_games()), "")
    try:
        problem = _write_table(path, found, robot_file, game=game, every=args.all, starts=not args.no_look)
        ignore = write_ignored(_project_of(robot_file))
    except OSError as error:
        raise OutputError(f"cannot write {error.filename or path}: {error.strerror}") from error
    wrote = f"wrote {path}{f' and {ignore}' if ignore else ''}"
    if problem:
        print(f"{wrote}; but the program does not start with it: {problem}")
        return 1
    main = "" if path.parent.resolve() == Path().resolve() else f"--main {robot_file} "
    print(f"{wrote}; now: python -m robotpy {main}sim --simcore")
    return 0


def _write_table(path: Path, found: dict[str, Any], robot_file: Path, *, game: str, every: bool, starts: bool) -> str:
    """Write a `simcore.toml`, without the `[drivetrain]` table if that table prevents the program from starting.

    Args:
        path: Path of the file to write.
        found: Survey of the program; if the table is omitted, `drivetrain` is replaced with the problem.
        robot_file: Path of the program.
        game: Name of the game to play; empty for no game in the file.
        every: Whether to add all other keys in comments.
        starts: Whether to start the program with the file; False to only read the file.

    Returns:
        Error message if the program does not start (without `starts`, if the file is invalid); empty otherwise.
    """
    while True:
        path.write_text(template(found, game=game, every=every), encoding="utf-8")
        try:
            read_settings(path)
            answer = survey(robot_file, "described", "started") if starts else {}
            if "error" in answer:  # the program has loaded without the file
                return str(answer["error"])
            problem = str(answer.get("start_problem", ""))
        except ConfigError as error:
            problem = str(error)
        if not problem or "rows" not in found.get("drivetrain", {}):
            return problem
        found["drivetrain"] = {"problem": f"the drivetrain that was found cannot be written as a table: {problem}"}
        print(found["drivetrain"]["problem"])


def _survey_report(found: dict[str, Any], *, is_asked: bool) -> list[str]:
    """Format the results of the survey as lines of text, or the reason for missing results as one line."""
    if not is_asked:
        return ["did not start the robot program: fill in the mechanisms by hand"]
    if "not_modelled" in found and not any(found.get(what) for what in ("motors", "ports", "cameras")):
        return [f"could not survey the robot program ({found['not_modelled']}): fill in the mechanisms by hand"]
    motors, ports, cameras = (found.get(what, ()) for what in ("motors", "ports", "cameras"))
    drivetrain = found.get("drivetrain", {})
    said = list(drivetrain.get("lines", ()))
    said += [drivetrain["problem"]] if "problem" in drivetrain else []
    said += [f"found {len(motors)} motors or groups of motors besides the drivetrain"] if motors else []
    said += [f"found {len(ports)} devices on ports of the roboRIO, solenoids and sensors"] if ports else []
    if cameras:
        names = ", ".join(camera.get("name") or camera["maker"] for camera in cameras)
        unplaced = ", ".join(camera["name"] for camera in cameras if "name" in camera and "source" not in camera)
        where = f"; say in the file where {unplaced} sit" if unplaced else ""
        said.append(f"found {len(cameras)} camera{'s' * (len(cameras) > 1)}: {names}{where}")
    return said


def _simulates_itself(folder: Path) -> bool:
    """Return whether a Python file in a program's folder contains calls that write to simulated motors."""
    files = [path for path in folder.rglob("*.py") if not _is_foreign(path.relative_to(folder))]
    return any(_OWN_SIMULATION.search(path.read_text(encoding="utf-8", errors="replace")) for path in files)


def write_ignored(project: Path) -> Path | None:
    """Add the files that runs leave behind to .gitignore, without repeating or removing lines.

    Args:
        project: Folder in which teams start the program.

    Returns:
        Path of .gitignore if it was changed, else None.
    """
    path = project / ".gitignore"
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    known = {line.strip().strip("/") for line in text.splitlines()}
    new = [line for line in _LEFT_BEHIND if line.strip("/") not in known]
    if not new:
        return None
    gap = "" if not text else "\n" if text.endswith("\n") else "\n\n"
    path.write_text(
        f"{text}{gap}# what `robotpy sim` and simcore leave behind\n{chr(10).join(new)}\n", encoding="utf-8"
    )
    return path


def find_robot_py(place: Path) -> Path:
    """Return the main file of a program from a path in or above the program's folder.

    Args:
        place: Main file, which is returned unchanged, or a folder with robot.py up to three levels down.

    Raises:
        ConfigError: There is no robot.py, several are at the same depth, or the folder is simcore's own.
    """
    if place.is_file():
        return place
    if is_source(place):
        raise ConfigError(
            f"{place.resolve()} is simcore's own folder: go to that of your robot.py, or name it: simcore init FOLDER"
        )
    for depth in ("robot.py", "*/robot.py", "*/*/robot.py", "*/*/*/robot.py"):
        found = sorted(p for p in place.glob(depth) if not _is_foreign(p.relative_to(place)))
        if len(found) == 1:
            return found[0]
        if found:
            names = ", ".join(str(p) for p in found)
            raise ConfigError(f"{len(found)} robot.py in {place.resolve()}: name one of them: simcore init {names}")
    raise ConfigError(
        f"no robot.py in {place.resolve()}: go to your robot project, or name its folder: simcore init FOLDER"
    )


def _is_foreign(path: Path) -> bool:
    """Return whether a path is hidden, or inside a virtual environment, a build folder or the tests."""
    return any(
        part.startswith(".") or part in ("venv", "env", "site-packages", "node_modules", "build", "dist", "tests")
        for part in path.parts
    )


def _project_of(robot_file: Path) -> Path:
    """Return the folder in which teams start the program.

    This is the nearest folder above robot.py with a pyproject.toml, or else the folder of robot.py.
    """
    folder = robot_file.resolve().parent
    return next((f for f in (folder, *folder.parents) if (f / "pyproject.toml").is_file()), folder)


# --- workflow ---------------------------------------------------------------------------------------------------------


def write_workflow(robot_file: Path, *, source: str, force: bool) -> Path:
    """Write a workflow for the robot tests into the git repository of a project, and return its path.

    Args:
        robot_file: Path of the project's robot.py.
        source: Address from which GitHub can install simcore; empty for the address of this installation.
        force: Whether to overwrite an existing file.

    Raises:
        ConfigError: The file exists and `force` is false, the project is not in a git repository, or the source of
            simcore is unknown.
        OutputError: The file cannot be written.
    """
    project = robot_file.resolve().parent
    root = next((folder for folder in (project, *project.parents) if (folder / ".git").exists()), None)
    if root is None:
        raise ConfigError(f"{project} is not in a git repository: `git init` makes one")
    simcore = shared_requirement("phoenix6", "robotpy", source=source)
    if not simcore:
        raise ConfigError(
            "simcore was installed from a folder of this computer, which GitHub cannot reach: say where GitHub gets "
            "it, as in `simcore init --ci --source git+https://...`, with the address of simcore's repository"
        )
    path = root / ".github" / "workflows" / _WORKFLOW.name
    if path.exists() and not force:
        raise ConfigError(f"{path} already exists; simcore init --ci --force overwrites it")
    packages = shlex.join([simcore, *_packages(project)])
    packages += " -r requirements.txt" if (project / "requirements.txt").is_file() else ""
    text = _WORKFLOW.read_text(encoding="utf-8").replace("PACKAGES", packages)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text.replace("FOLDER", project.relative_to(root).as_posix()), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from error
    return path


def _packages(project: Path) -> list[str]:
    """Return the packages that RobotPy installs for a project, according to pyproject.toml."""
    file = project / "pyproject.toml"
    settings: dict[str, Any] = read_toml(file).get("tool", {}).get("robotpy", {}) if file.is_file() else {}
    extras = ",".join(settings.get("components", ()))
    robotpy = f"robotpy[{extras}]" if extras else "robotpy"
    robotpy += f"=={settings['robotpy_version']}" if "robotpy_version" in settings else ""
    return [robotpy, *settings.get("requires", ())]


# --- survey of the program --------------------------------------------------------------------------------------------


def survey(robot_file: Path, *options: str) -> dict[str, Any]:
    """Start the robot program in a separate process and return the devices that the program builds.

    Args:
        robot_file: Path of the project's robot.py.
        options: Command-line options of `simcore.robotcode.sim.robot_survey`.

    Returns:
        Results of the survey. A key `error` gives the reason if the program cannot be built; a key `not_modelled` gives
        the reason if simcore does not model a device, even with `RobotBase.isReal()` true.
    """
    for module in ("phoenix6", "wpilib"):
        if find_spec(module) is None:
            return {"error": f"{module} is not installed"}
    robot_file = robot_file.resolve()  # because the survey runs in another folder
    answer = _run_survey(robot_file, options)
    return _run_survey(robot_file, (*options, "real")) if "not_modelled" in answer else answer


def _run_survey(robot_file: Path, options: Sequence[str]) -> dict[str, Any]:
    """Run the survey in a separate process and return the results, or an `error` if no results arrive."""
    project = _project_of(robot_file)
    path = [
        str(Path(__file__).resolve().parents[2]),
        str(project),
        *filter(None, [os.environ.get("PYTHONPATH")]),
    ]
    try:
        # in a separate folder, because programs and libraries write files to the working directory
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as scratch:
            _link_contents(project, Path(scratch))
            done = subprocess.run(
                [sys.executable, "-m", "simcore.robotcode.sim.robot_survey", str(robot_file), *options],
                cwd=scratch,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(path)},
                capture_output=True,
                text=True,
                timeout=_LOOK_SECONDS,
                check=False,
            )
    except subprocess.TimeoutExpired:
        return {"error": f"it did not start within {_LOOK_SECONDS:.0f} s"}
    line = next((line for line in reversed(done.stdout.splitlines()) if line.startswith('{"')), None)
    if line is None:
        return {"error": f"it ended with code {done.returncode}"}
    answer: dict[str, Any] = json.loads(line)
    return answer


def _link_contents(project: Path, scratch: Path) -> None:
    """Link the data files and folders of a project into the folder of the survey, if the system allows links."""
    for entry in project.iterdir():
        if entry.name.startswith(".") or entry.name in _NOT_LINKED or entry.suffix == ".py":
            continue
        try:
            (scratch / entry.name).symlink_to(entry, target_is_directory=entry.is_dir())
        except OSError:
            return
