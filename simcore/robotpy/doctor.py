"""`simcore doctor`: looks at this computer and this folder, and says what to do."""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Iterator, Mapping
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from simcore.robotpy.checks import computer_checks, install_checks, project_checks
from simcore.robotpy.checks.findings import Finding, Level

if TYPE_CHECKING:
    from simcore.match.game import Game
    from simcore.match.match import Match

__all__ = ["add_arguments", "examine", "print_findings", "read_settings", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("--folder", type=Path, default=Path(), help="your robot project (default: here)")
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of a table")
    parser.add_argument("--no-physics", action="store_true", help="leave out the second of physics at the end")


def run(args: argparse.Namespace) -> int:
    """Look at everything and print it; 0 if nothing failed, 1 otherwise."""
    findings = list(examine(args.folder, with_physics=not args.no_physics))
    failed = any(finding.level is Level.FAIL for finding in findings)
    if args.json:
        rows = [{"check": f.check, "level": f.level.value, "text": f.text, "advice": f.advice} for f in findings]
        print(json.dumps({"ok": not failed, "findings": rows}))
    else:
        print_findings(findings, Console())
    return int(failed)


def examine(folder: Path, *, with_physics: bool = True) -> Iterator[Finding]:
    """All findings, the deepest causes first."""
    installed = {
        (distribution.metadata["Name"] or "").lower().replace("_", "-"): distribution.version
        for distribution in metadata.distributions()
    }
    version = sys.version_info[:3]
    yield install_checks.check_python(version)
    system, machine = platform.system(), platform.machine()
    yield install_checks.check_wheels(system, machine, version, _glibc())
    yield install_checks.check_engine(installed, _load_engine, install_checks.engine_of(system, machine, version[:2]))
    yield from install_checks.check_requirements(installed, _requirements())
    yield install_checks.check_year(installed)
    yield install_checks.check_loop(_prepare_loop)
    yield computer_checks.check_ports(computer_checks.is_taken, computer_checks.owner_of)
    yield computer_checks.check_screen(platform.system(), os.environ, installed)
    yield project_checks.check_writable(folder)
    yield project_checks.check_robot_file(folder)
    yield project_checks.check_physics_file(folder)
    yield project_checks.check_settings_file(folder, read_settings)
    yield project_checks.check_device_settings(folder, time.time())
    yield project_checks.check_stored_values(folder)
    finding, game = computer_checks.check_games(_games)
    yield finding
    if game is not None and with_physics:
        yield from computer_checks.check_speed(lambda: _match(game), time.perf_counter)


def print_findings(findings: list[Finding], console: Console) -> None:
    """Print a table for 80 columns and more, and under it what to do; plain ASCII where a terminal knows no more."""
    ascii_only = not console.encoding.lower().replace("-", "").startswith("utf")
    table = Table(box=box.ASCII if ascii_only else box.ROUNDED, width=min(console.width, 110))
    table.add_column("")
    table.add_column("what", no_wrap=True)
    table.add_column("found, and what to do", ratio=1, overflow="fold")
    colors = {Level.OK: "green", Level.WARN: "yellow", Level.FAIL: "bold red"}
    for finding in findings:
        shown = escape(_printable(finding.text, console))
        if finding.advice:
            shown += f"\n[bold]do this:[/bold] {escape(_printable(finding.advice, console))}"
        color = colors[finding.level]
        table.add_row(f"[{color}]{finding.level.value}[/{color}]", escape(finding.check), shown)
    console.print(table)
    bad, odd = (sum(f.level is level for f in findings) for level in (Level.FAIL, Level.WARN))
    if bad:
        console.print(f"[bold red]{bad} of these cannot work.[/bold red] Start with the first.")
    else:
        console.print(f"[green]Nothing stands in the way.[/green]{f' {odd} to know of.' if odd else ''}")


def _printable(text: str, console: Console) -> str:
    return text.encode(console.encoding, "replace").decode(console.encoding)


def _glibc() -> tuple[int, int] | None:
    library, version = platform.libc_ver()
    parts = version.split(".")
    return (int(parts[0]), int(parts[1])) if library == "glibc" and len(parts) >= 2 else None


def _load_engine() -> None:
    from simcore.physics.world import PhysicsWorld

    PhysicsWorld().close()


def _prepare_loop() -> Path | None:
    from simcore.loop.compiled import cache_folder
    from simcore.physics.world import prepare_loop

    prepare_loop()
    return cache_folder


def _requirements() -> list[str] | None:
    try:
        return metadata.requires("simcore") or []
    except metadata.PackageNotFoundError:
        return None


def _games() -> Mapping[str, Game]:
    from simcore.match.registry import installed_games

    return installed_games()


def _match(game: Game) -> Match:
    from simcore.match.match import Match

    return Match(game)


def read_settings(path: Path) -> object:
    """Read and check a simcore.toml."""
    from simcore.robot_file import reader  # it needs numpy and wpimath, which may be what is missing

    return reader.read_settings(path)
