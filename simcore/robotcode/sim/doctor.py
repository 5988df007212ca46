"""`simcore doctor`: check the versions, imports and a second of physics, and give advice for each problem."""

from __future__ import annotations

import argparse
import ast
import json
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from simcore.install_text import install_command
from simcore.season import installed_seasons, mixed_seasons
from simcore.units import TICK

__all__ = ["Finding", "add_arguments", "run"]

OLDEST, NEWEST = (3, 10), (3, 14)
_ADVISED = "3.13"  # newest Python version with wheels for both engines
_SHOWN = ("simcore", "numpy", "numba", "pybullet-arm64", "pybullet", "mujoco-core", "mujoco")
_EXTRAS = {"phoenix6": "phoenix6", "rev": "rev", "navx": "navx", "photonlibpy": "photonvision"} | dict.fromkeys(
    ("wpilib", "wpimath", "wpiutil", "hal", "ntcore", "commands2"), "robotpy"
)
"""Extra of simcore that installs a module, by the name of the module that robot code imports."""
_TICKS, _WARM_UP = 50, 10  # one simulated second, after ticks that fill caches
_SLOW = 8.0  # largest tick time without a warning; robot code, Phoenix 6 and the window need the rest of the 20 ms [ms]


@dataclass(frozen=True, slots=True)
class Finding:
    """Result of one check: one row of the printed table."""

    check: str
    """Subject of the check, in a word or two."""
    text: str
    """Result of the check."""
    advice: str = ""
    """Advice to fix the problem; empty without a problem."""
    level: str = "ok"
    """Severity: `ok`, `warn` (may behave unexpectedly) or `fail` (cannot work)."""


_warn, _fail = partial(Finding, level="warn"), partial(Finding, level="fail")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `simcore doctor` to a parser."""
    parser.add_argument("--folder", type=Path, default=Path(), help="your robot project (default: here)")
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of a table")
    parser.add_argument("--no-physics", action="store_true", help="leave out the second of physics at the end")


def run(args: argparse.Namespace) -> int:
    """Run all checks and print the findings as a table or JSON; return exit status 1 if a check failed, else 0."""
    found = [(one.metadata["Name"] or "", one.version) for one in metadata.distributions()]
    installed = {name.lower().replace("_", "-"): version for name, version in found}
    findings = [check_python(sys.version_info[:3]), check_versions(installed), *check_imports(args.folder)]
    findings += [] if args.no_physics else check_run()
    failed = any(finding.level == "fail" for finding in findings)
    if args.json:
        print(json.dumps({"ok": not failed, "findings": [asdict(finding) for finding in findings]}))
    else:
        print_findings(findings, Console())
    return int(failed)


def check_python(version: tuple[int, int, int]) -> Finding:
    """Check whether simcore supports a Python version (major, minor, micro), and return the finding."""
    shown = f"{'.'.join(map(str, version))}, {platform.system()} {platform.machine()}"
    if OLDEST <= version[:2] <= NEWEST:
        return Finding("Python", shown)
    wanted = f"simcore runs on {OLDEST[0]}.{OLDEST[1]} to {NEWEST[0]}.{NEWEST[1]}"
    venv = f"`py -{_ADVISED} -m venv .venv` on Windows, `python{_ADVISED} -m venv .venv` elsewhere"
    return _fail(
        "Python",
        f"{shown}: {wanted}",
        f"install Python {_ADVISED} next to it; {venv}, then install simcore in that environment",
    )


def check_versions(installed: Mapping[str, str]) -> Finding:
    """Check that simcore and WPILib are installed, and that WPILib and vendor libraries are for the same season.

    Args:
        installed: Version of each installed package, by name in lower case with hyphens.

    Returns:
        Finding with the installed versions or the first problem.
    """
    seasons = installed_seasons(installed.items())
    shown = [f"{name} {installed[name]}" for name in _SHOWN if name in installed]
    shown += [text for found in seasons.values() for text in found if "-native-" not in text]
    if mixed := mixed_seasons(seasons):
        said, _, advice = mixed.rpartition(": ")
        return _fail("versions", said, advice)
    if "simcore" not in installed:
        said = "simcore runs from a folder and is not installed: `robotpy sim --simcore` does not find it"
        return _warn("versions", said, install_command())
    if not seasons:
        return _warn("versions", f"{', '.join(shown)}; no WPILib", f"for robot code: {install_command('robotpy')}")
    return Finding("versions", ", ".join(shown))


def check_imports(folder: Path) -> Iterator[Finding]:
    """Yield a finding for each imported library that is missing or fails, and a finding about all other libraries.

    If the folder contains no robot.py, the function yields only a warning.
    """
    if not (folder / "robot.py").is_file():
        yield _warn("robot.py", f"not in {str(folder.resolve())!r}", "go to your robot code's folder first")
        return
    loaded = []
    for name, file in sorted(_imported(folder).items()):
        if find_spec(name) is None:
            package = install_command(_EXTRAS[name]) if name in _EXTRAS else f"install the package that has {name}"
            yield _fail("imports", f"{file} imports {name}, which is not installed", package)
            continue
        done = subprocess.run([sys.executable, "-c", f"import {name}"], capture_output=True, text=True, check=False)
        if done.returncode == 0:
            loaded.append(name)
        else:
            why = (done.stderr.strip().splitlines() or [f"it ended with code {done.returncode}"])[-1]
            yield _fail("imports", f"{name} does not load: {why}", "install it again, of the same release as WPILib")
    yield Finding("imports", f"robot.py is here; {', '.join(loaded) or 'no other library'} can be imported")


def _imported(folder: Path) -> dict[str, str]:
    """Return the first file that imports each library, by library name.

    The search covers module-level imports in all files of the project except tests. The result excludes the standard
    library and the project's own modules.
    """
    found: dict[str, str] = {}
    for file in (*sorted(folder.glob("*.py")), *sorted(folder.glob("[!.t]*/*.py"))):
        try:
            body = ast.parse(file.read_text(encoding="utf-8", errors="replace")).body
        except SyntaxError:
            continue  # the program itself reports the syntax error and its location
        for node in body:
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module or ""]
            for name in {module.split(".")[0] for module in names} - sys.stdlib_module_names:
                if not (folder / name).is_dir() and not (folder / f"{name}.py").is_file():
                    found.setdefault(name, file.relative_to(folder).as_posix())
    return found


def check_run() -> Iterator[Finding]:
    """Play a second of the newest game; yield findings about invalid games, errors and the median time of a tick."""
    left_out: list[str] = []
    took = []
    try:
        from simcore.match.match import Match
        from simcore.match.registry import installed_games

        games = installed_games(say=left_out.append)
        for text in left_out:
            yield _warn("game", text, "correct it, or uninstall its package; the other games work")
        names = ", ".join(f"{game.name} ({game.year})" for game in games.values())
        with Match(next(iter(games.values()))) as match:
            engine = match.world.engine_name
            for _ in range(_WARM_UP + _TICKS):
                before = time.perf_counter()
                match.tick()
                took.append(1e3 * (time.perf_counter() - before))
    except StopIteration:
        yield _fail("run", "no game is installed", install_command())
        return
    except Exception as error:  # a library that simcore needs may be missing
        yield _fail("run", f"the match does not run: {type(error).__name__}: {error}", install_command(upgrade=True))
        return
    median = statistics.median(took[_WARM_UP:])
    speed = f"a tick takes {median:.1f} of its 20 ms, {1e3 * TICK / median:.0f} x real time"
    text = f"games: {names}; a second of the first on {engine}: {speed}"
    if median <= _SLOW:
        yield Finding("run", text)
        return
    level = _fail if median > 1e3 * TICK else _warn
    yield level("run", text, "plug in the charger, close other programs; robot code needs the rest of the 20 ms")


def print_findings(findings: list[Finding], console: Console) -> None:
    """Print the findings as a table at most 110 columns wide, and the number of problems or warnings."""
    table = Table(width=min(console.width, 110))
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
        console.print(f"[bold red]{bad} of these must be fixed.[/bold red] Start with the first.")
    else:
        console.print(f"[green]No problems found.[/green]{f' Warnings: {odd}.' if odd else ''}")
