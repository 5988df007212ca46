"""`simcore doctor`: versions, imports, the project's folder, and a second of physics; each finding is one sentence."""

from __future__ import annotations

import argparse
import json
import math
import platform
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

from packaging.markers import default_environment
from packaging.requirements import InvalidRequirement, Requirement
from packaging.version import Version
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from simcore.errors import ConfigError
from simcore.install_text import install_command, shared_requirement
from simcore.season import installed_seasons, mixed_seasons
from simcore.units import TICK

if TYPE_CHECKING:
    from simcore.match.game import Game

__all__ = ["PORTS", "Finding", "add_arguments", "run"]

OLDEST, NEWEST = (3, 10), (3, 14)
_ADVISED = "3.13"  # the newest for which both engines have wheels
ENGINES = ("pybullet", "pybullet-arm64", "mujoco", "mujoco-core")
"""Distributions of which one must be there. From 4 on, mujoco is a viewer around mujoco-core; before, it is whole."""
PORTS = {5810: "NetworkTables 4", 1735: "NetworkTables 3", 1250: "Phoenix Tuner X", 3300: "`robotpy sim --ws-server`"}
"""Of a robot program, and who does not find it when another program has them."""
_LIBRARIES = {
    **{"wpilib": "wpilib", "pyntcore": "ntcore", "phoenix6": "phoenix6", "robotpy-rev": "rev", "robotpy-navx": "navx"},
    **{"robotpy-ctre": "phoenix5", "photonlibpy": "photonlibpy", "robotpy-commands-v2": "commands2"},
}
"""Distributions that robot code imports, and their modules."""
_WPILIB = re.compile(r"wpilib|pyntcore|robotpy-(hal|wpi\w+|apriltag|cscore|fields|commands-v2|native-.*)")
"""Distributions of WPILib itself, which are of one release."""
_ROBOTS = ("roborio", "systemcore")  # what `platform_machine` is as RobotPy reads requirements for a robot
_LAPTOPS = " and ".join(f'platform_machine != "{robot}"' for robot in _ROBOTS)
_TICKS, _WARM_UP = 50, 10  # a simulated second; the first ticks pay for caches
_SLOW = 8.0  # [ms]; robot code, Phoenix 6 and the window want the rest of the 20
_RECENT = 12 * 3600.0  # [s]; what was written since is probably of this very session


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the report."""

    check: str
    """What was looked at, in a word or two."""
    text: str
    """What is there."""
    advice: str = ""
    """What to do about it; empty where all is well."""
    level: str = "ok"
    """`ok`; `warn`: it works, but somebody will wonder; `fail`: it cannot work."""


_warn, _fail = partial(Finding, level="warn"), partial(Finding, level="fail")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("--folder", type=Path, default=Path(), help="your robot project (default: here)")
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of a table")
    parser.add_argument("--no-physics", action="store_true", help="leave out the second of physics at the end")


def run(args: argparse.Namespace) -> int:
    """Look at everything and print it; 0 if nothing failed, 1 otherwise."""
    findings = list(_examine(args.folder, with_physics=not args.no_physics))
    failed = any(finding.level == "fail" for finding in findings)
    if args.json:
        print(json.dumps({"ok": not failed, "findings": [asdict(finding) for finding in findings]}))
    else:
        print_findings(findings, Console())
    return int(failed)


def _examine(folder: Path, *, with_physics: bool) -> Iterator[Finding]:
    """All findings, the deepest causes first."""
    everything = [(one.metadata["Name"] or "", one.version) for one in metadata.distributions()]
    installed = {name.lower().replace("_", "-"): version for name, version in everything}
    yield check_python(sys.version_info[:3])
    yield check_engine(installed)
    yield from check_requirements(installed, metadata.requires("simcore") if "simcore" in installed else None)
    yield check_season(installed)
    yield check_imports([module for name, module in _LIBRARIES.items() if name in installed])
    yield check_loop()
    yield check_ports()
    yield from check_folder(folder, time.time())
    finding, game = check_games()
    yield finding
    if game is not None and with_physics:
        yield check_run(game)


def check_python(version: tuple[int, int, int]) -> Finding:
    """Whether simcore runs on this Python."""
    shown = f"{'.'.join(map(str, version))}, {platform.system()} {platform.machine()}"
    if OLDEST <= version[:2] <= NEWEST:
        return Finding("Python", shown)
    wanted = f"simcore runs on {OLDEST[0]}.{OLDEST[1]} to {NEWEST[0]}.{NEWEST[1]}"
    venv = f"`py -{_ADVISED} -m venv .venv` on Windows, `python{_ADVISED} -m venv .venv` elsewhere"
    return _fail("Python", f"{shown}: {wanted}", f"install Python {_ADVISED} beside it; {venv}, then install in there")


def check_engine(installed: Mapping[str, str]) -> Finding:
    """Whether a physics engine is installed, none of them twice, and it loads."""
    found = {name: installed[name] for name in ENGINES if name in installed}
    shown = ", ".join(f"{name} {version}" for name, version in found.items())
    whole_mujoco = Version(found.get("mujoco", "4")).major < 4
    for pair, is_twice in ((ENGINES[:2], True), (ENGINES[2:], whole_mujoco)):
        if is_twice and all(name in found for name in pair):
            advice = f"`python -m pip uninstall -y {' '.join(pair)}`, then `python -m pip install {pair[1]}`"
            return _fail("engine", f"{shown}: the same files twice", advice)
    if not found:
        advice = "`python -m pip install pybullet-arm64` (on Intel and AMD, too); where that has no wheel, `mujoco`"
        return _fail("engine", "no physics engine is installed", advice)
    try:
        from simcore.physics.world import PhysicsWorld  # as all that is imported below, it may be what is missing

        PhysicsWorld().close()
    except Exception as error:
        again = f"`python -m pip install --force-reinstall --no-deps {' '.join(found)}`"
        return _fail("engine", f"{shown} does not load: {error}", again)
    return Finding("engine", shown)


def check_requirements(installed: Mapping[str, str], requires: Sequence[str] | None) -> Iterator[Finding]:
    """Whether everything that simcore asks for is there, in a version that it knows.

    Args:
        installed: Version by name of everything installed.
        requires: Of simcore, as its metadata says; None: simcore itself is not installed.
    """
    if requires is None:
        said = "runs from a folder and is not installed: `robotpy sim --simcore` and other programs do not find it"
        yield _warn("simcore", said, install_command())
        return
    yield Finding("simcore", installed.get("simcore", ""))
    around = {key: str(value) for key, value in default_environment().items()}
    seasons = installed_seasons((name, installed[name]) for name in ("wpilib", "pyntcore") if name in installed)
    for extra in ("", *(f"robotpy{year}" for year in list(seasons)[-1:])):
        wanted = [r for r in map(Requirement, requires) if r.name not in ENGINES and _is_of(r, extra, around)]
        there = {r.name: installed[r.name] for r in wanted if r.name in installed}
        wrong = [f"{r.name} is missing" for r in wanted if r.name not in there]
        wrong += [
            f"{r.name} {there[r.name]} is not {r.specifier}"
            for r in wanted
            if r.name in there and not r.specifier.contains(there[r.name], prereleases=True)
        ]
        check, names = (f"extra [{extra}]", [extra]) if extra else ("packages", [])
        if extra and not there:
            yield _warn(check, "not installed", f"{install_command(*names)}, if you want it")
        elif wrong:
            yield _fail(check, "; ".join(wrong), install_command(*names, upgrade=True))
        else:
            yield Finding(check, ", ".join(map(" ".join, there.items())))


def _is_of(requirement: Requirement, extra: str, environment: Mapping[str, str]) -> bool:
    """Whether a requirement belongs to an extra (empty: to simcore itself) on this computer."""
    marker = requirement.marker
    is_base = marker is None or marker.evaluate({**environment, "extra": ""})
    if marker is None or not extra:
        return is_base and not extra
    return not is_base and marker.evaluate({**environment, "extra": extra})


def check_season(installed: Mapping[str, str]) -> Finding:
    """Which season is installed, and what of it is not final. Its libraries share binaries: they are of one release."""
    seasons = installed_seasons(installed.items())
    if mixed := mixed_seasons(seasons):
        said, _, advice = mixed.rpartition(": ")
        return _fail("WPILib", said, advice)
    if not seasons:
        return _fail("WPILib", "nothing of WPILib is installed", install_command("robotpy"))
    ((year, found),) = seasons.items()
    ours = {name: Version(version) for name, version in installed.items() if _WPILIB.fullmatch(name)}
    if not ours:
        return _fail("WPILib", f"{', '.join(found)} without WPILib of {year}", install_command(f"robotpy{year}"))
    newest = max(version.release[:2] for version in ours.values())
    behind = [name for name, version in ours.items() if version.release[:2] != newest]
    if behind:
        said = ", ".join(f"{name} {ours[name]}" for name in behind)
        advice = f"`python -m pip install --upgrade {' '.join(behind)}`"
        return _warn("WPILib", f"two releases: {said} beside {newest[0]}.{newest[1]}", advice)
    unready = [text for text in found if Version(text.split()[1]).is_prerelease and "-native-" not in text]
    alpha = f"; not final yet: {', '.join(unready)}" if unready else ""
    return Finding("WPILib", f"season {year}: {newest[0]}.{newest[1]}{alpha}")


def check_imports(modules: Sequence[str]) -> Finding:
    """Whether installed libraries of robot code can be imported; in a process of its own, as some end theirs."""
    code = "import importlib, sys\nfor name in sys.argv[1:]: print(name, flush=True); importlib.import_module(name)"
    done = subprocess.run([sys.executable, "-c", code, *modules], capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return Finding("imports", ", ".join(modules) or "nothing of robot code is installed")
    name = (done.stdout.split() or ["Python"])[-1]
    why = (done.stderr.strip().splitlines() or [f"it ended with code {done.returncode}"])[-1]
    return _fail("imports", f"{name} does not load: {why}", "install it again, of the same release as WPILib")


def check_loop() -> Finding:
    """Whether the physics' loop is compiled, and where that is kept."""
    try:
        from simcore.loop.compiled import cache_folder
        from simcore.loop.step import prepare

        prepare()
    except Exception as error:  # Numba's own errors are many
        return _fail("loop", f"the physics cannot be compiled: {error}", "python -m pip install --upgrade numba")
    if cache_folder is None:
        said = "the physics is compiled anew in every run, for half a minute: no folder to keep it in can be written"
        return _warn("loop", said, "let your user write ~/.cache, or set XDG_CACHE_HOME to a folder that it can")
    return Finding("loop", f"the physics is compiled, and kept in {cache_folder}")


def check_ports() -> Finding:
    """Whether another program has a port of ours."""
    if not (found := [port for port in PORTS if is_taken(port)]):
        return Finding("ports", f"{', '.join(map(str, PORTS))} are free")
    who = f"`netstat -ano | findstr :{found[0]}`" if sys.platform == "win32" else f"`lsof -i :{found[0]}`"
    said = ", ".join(f"{port} ({PORTS[port]})" for port in found)
    return _warn("ports", f"another program has {said}", f"end the other robot program or simulation: {who} names it")


def is_taken(port: int) -> bool:
    """Whether a program listens on a TCP port of this computer."""
    with socket.socket() as probe:
        option = "SO_EXCLUSIVEADDRUSE" if sys.platform == "win32" else "SO_REUSEADDR"  # what is closing does not count
        probe.setsockopt(socket.SOL_SOCKET, getattr(socket, option), 1)
        try:
            probe.bind(("", port))
        except OSError:
            return True
    return False


def check_folder(folder: Path, now: float) -> Iterator[Finding]:
    """The robot project at a time of day [s since 1970]: program, simcore.toml, and what earlier runs left in it."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            yield Finding("folder", "can be written")
    except OSError as error:
        said = f"cannot write to {str(folder.resolve())!r}: {error.strerror or error}"
        level = _warn if folder.is_dir() else _fail
        yield level("folder", said, "run in a folder of your own: logs, pages and device settings go there")
    if (folder / "robot.py").is_file():
        yield Finding("robot.py", "found")
    else:
        yield _warn("robot.py", f"not in {str(folder.resolve())!r}", "go to your robot code's folder first")
    try:
        from simcore.robot_file.reader import read_settings

        read_settings(folder / "simcore.toml")
        yield Finding("simcore.toml", "can be read, or is not there")
    except Exception as error:
        yield _fail("simcore.toml", str(error), "correct that line")
    yield from check_requires(folder / "pyproject.toml")
    devices = sorted((folder / "ctre_sim").glob("*.dat"))
    age = now - max((path.stat().st_mtime for path in devices), default=now)
    if age > _RECENT:
        said = f"Phoenix will load settings of {len(devices)} devices, {age / 3600.0:.0f} hours old"
        yield _warn("ctre_sim", said, f"what your code no longer sets comes from there: delete {folder / 'ctre_sim'}")
    stored = folder / "networktables.json"
    if stored.is_file() and stored.stat().st_size > len("[]\n"):
        said = "networktables.json keeps values of an earlier run: Preferences and choosers come back from it"
        yield _warn("stored values", said, "delete the file if a value seems old")


def check_requires(file: Path) -> Iterator[Finding]:
    """Whether `[tool.robotpy] requires` in a pyproject.toml brings simcore to a team's laptops and not to its robot."""
    try:
        from simcore.robot_file.key_tables import read_toml

        told = read_toml(file).get("tool", {}).get("robotpy") if file.is_file() else None
        if told is None:
            return
        ours = [one for one in map(Requirement, told.get("requires", [])) if one.name == "simcore"]
    except (ConfigError, InvalidRequirement, AttributeError, TypeError) as error:
        yield _fail("pyproject.toml", str(error), "correct that line")
        return
    line = shared_requirement("phoenix6", "robotpy") or "simcore[phoenix6,robotpy] @ git+https://..."
    advice = f"write into requires: '{line.replace('==', '>=')}; {_LAPTOPS}'"
    if " @ " in line:  # whose markers RobotPy does not look at
        advice = f"write '{line}' into requirements-sim.txt (in requires it would be for the robot, too), and on each "
        advice += "laptop `python -m pip install -r requirements-sim.txt`"
    environments = [{"platform_machine": robot} for robot in _ROBOTS]
    if any(one.url or one.marker is None or any(map(one.marker.evaluate, environments)) for one in ours):
        yield _warn("pyproject.toml", "its requires has simcore for the robot, too, where it cannot be", advice)
    elif not ours:
        yield _warn("pyproject.toml", "its requires brings no simcore to other laptops", advice)
    else:
        yield Finding("pyproject.toml", "its requires brings simcore to laptops alone")


def check_games() -> tuple[Finding, Game | None]:
    """Whether there is a game to play, and it loads; and the newest one."""
    broken: list[str] = []
    try:
        from simcore.match.registry import installed_games

        games = installed_games(say=broken.append)
    except Exception as error:  # a library that simcore needs may be what is missing
        return _fail("game", f"games cannot be loaded: {type(error).__name__}: {error}", install_command()), None
    if not games:
        said = "; ".join(broken) or "no game is installed"
        return _fail("game", said, "correct it, or uninstall its package" if broken else install_command()), None
    newest, *others = (f"{game.name} ({game.year})" for game in games.values())
    also = f", the newest, is played if none is named; also installed: {', '.join(others)}" if others else ""
    first = next(iter(games.values()))
    if broken:
        said = "\n".join([newest + also, *broken])
        return _warn("game", said, "correct what is left out, or uninstall its package; the others play"), first
    return Finding("game", newest + also), first


def check_run(game: Game) -> Finding:
    """Play a second of a game with a robot that drives, and compare a tick with its 20 ms."""
    took = []
    try:
        from simcore.match.match import Match
        from simcore.robot.fixed_wheel_drive import TankDrive

        with Match(game) as match:
            robot = match.robots[0]
            start, drive = robot.chassis.pose, robot.drive
            for _ in range(_WARM_UP + _TICKS):
                before = time.perf_counter()
                drive.set_chassis_speeds(1.0, 0.0, *(() if isinstance(drive, TankDrive) else (0.0,)))
                match.tick()
                took.append(1e3 * (time.perf_counter() - before))
            moved = math.dist(robot.chassis.pose[:2], start[:2])
    except Exception as error:
        return _fail("run", f"the match does not run: {error}", "install simcore again: parts of it are missing")
    if not moved > 0.5:
        return _fail("run", f"a robot that drives at 1 m/s moved {moved:.2f} m in 1.2 s", "report it, with this table")
    return _of_speed(game.name, statistics.median(took[_WARM_UP:]))


def _of_speed(game: str, median: float) -> Finding:
    """Whether a tick of so many ms leaves robot code the time that it needs."""
    text = f"a second of {game}: a tick takes {median:.1f} of its 20 ms, {1e3 * TICK / median:.0f} x real time"
    if median <= _SLOW:
        return Finding("run", text)
    level = _fail if median > 1e3 * TICK else _warn
    return level("run", text, "plug in the charger, close other programs; robot code needs the rest of the 20 ms")


def print_findings(findings: list[Finding], console: Console) -> None:
    """Print a table for 80 columns and more; plain ASCII where a terminal knows no more."""
    ascii_only = not console.encoding.lower().replace("-", "").startswith("utf")
    table = Table(box=box.ASCII if ascii_only else box.ROUNDED, width=min(console.width, 110))
    table.add_column("")
    table.add_column("what", no_wrap=True)
    table.add_column("found, and what to do", ratio=1, overflow="fold")
    for f in findings:
        text = f"{f.text}\ndo this: {f.advice}" if f.advice else f.text
        printable = text.encode(console.encoding, "replace").decode(console.encoding)
        color = {"ok": "green", "warn": "yellow", "fail": "bold red"}[f.level]
        table.add_row(f"[{color}]{f.level}[/{color}]", escape(f.check), escape(printable))
    console.print(table)
    bad, odd = (sum(f.level == level for f in findings) for level in ("fail", "warn"))
    if bad:
        console.print(f"[bold red]{bad} of these cannot work.[/bold red] Start with the first.")
    else:
        console.print(f"[green]Nothing stands in the way.[/green]{f' {odd} to know of.' if odd else ''}")
