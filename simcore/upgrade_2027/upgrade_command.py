"""`simcore upgrade-2027 FOLDER`: the copy of a robot project that runs on the libraries of 2027."""

from __future__ import annotations

import argparse
import ast
import re
import shutil
from pathlib import Path

from simcore.errors import ConfigError, OutputError
from simcore.upgrade_2027.names_2027 import REQUIREMENTS, SPARKS
from simcore.upgrade_2027.source_rewriter import names_of_project, rewrite

__all__ = ["add_arguments", "run", "upgrade", "upgrade_settings"]

_LEFT_OUT = shutil.ignore_patterns(
    "__pycache__", ".*", "ctre_sim", "*.wpilog", "networktables.json*", "venv", "test_output"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="of last season's robot project, with its robot.py")
    parser.add_argument("--to", type=Path, metavar="FOLDER", help="where the copy goes (default: FOLDER_2027)")


def run(args: argparse.Namespace) -> int:
    """Write the copy, and list what was not decided; returns 0.

    Raises:
        ConfigError: There is no robot project in the folder, or a file of it is no Python.
        OutputError: There is something at the place of the copy.
    """
    folder = args.folder.resolve()
    to = args.to or folder.with_name(f"{folder.name}_2027")
    notes = upgrade(folder, to)
    for path, line, text in notes:
        print(f"{path}:{line}: {text}")
    print(f"\n{to}: the copy for 2027; {len(notes)} places to look at. Then: robotpy sim --simcore, robotpy test")
    return 0


def upgrade(folder: Path, to: Path) -> list[tuple[Path, int, str]]:
    """Write the copy of a project; returns what a person has to look at: file, line and a sentence.

    Raises:
        ConfigError: There is no robot project in the folder, or a file of it is no Python.
        OutputError: There is something at the place of the copy.
    """
    if not (folder / "robot.py").is_file():
        raise ConfigError(f"{folder} has no robot.py: give the folder of a robot project")
    if to.exists():
        raise OutputError(f"{to} is there already: delete it, or give another folder with --to")
    if to.resolve().is_relative_to(folder.resolve()):
        raise ConfigError(f"{to} is inside of {folder}: give a folder beside it with --to")
    texts = {}
    for path in sorted(folder.rglob("*.py")):
        place = path.relative_to(folder)
        if not any(part.startswith(".") or part in ("venv", "__pycache__") for part in place.parts):
            texts[place] = path.read_text(encoding="utf-8")
    own, trees = set(), {}
    for place, text in texts.items():
        try:
            trees[place] = ast.parse(text)
        except SyntaxError as error:
            raise ConfigError(f"{folder / place}, line {error.lineno}: {error.msg}") from error
    own = names_of_project(trees.values()) | {part for place in texts for part in place.with_suffix("").parts}
    shutil.copytree(folder, to, ignore=_LEFT_OUT)
    notes = []
    for place, text in texts.items():
        done = rewrite(text, own)
        (to / place).write_text(done.text, encoding="utf-8")
        notes += [(place, line, note) for line, note in done.notes]
        if f"{SPARKS}." in done.text or f"from {SPARKS} " in done.text:
            shutil.copy(Path(__file__).with_name(f"{SPARKS}.txt"), to / f"{SPARKS}.py")
    settings = to / "pyproject.toml"
    if settings.is_file():
        text, found = upgrade_settings(settings.read_text(encoding="utf-8"))
        settings.write_text(text, encoding="utf-8")
        notes += [(Path("pyproject.toml"), line, note) for line, note in found]
    if (folder / "physics.py").is_file():
        notes.append(
            (Path("physics.py"), 1, "found by `robotpy sim --simcore` and by tests; without the flag by nothing")
        )
    return notes


def upgrade_settings(text: str) -> tuple[str, list[tuple[int, str]]]:
    """The pyproject.toml of 2027, and what a person has to look at: line and sentence.

    >>> upgrade_settings('requires = ["phoenix6>=26.1,<27", "robotpy-pathplannerlib>=2026.1"]')[0]
    'requires = ["phoenix6>=26.70.0a2,<27"]'
    """
    notes: list[tuple[int, str]] = []
    lines = []
    for number, line in enumerate(text.splitlines(keepends=True), start=1):
        new = re.sub(r'^(\s*robotpy_version\s*=\s*)"[^"]*"', r'\1"2027.0.0a7"', line)
        new = new.replace("[tool.robotpy.pyfrc]", "[tool.robotpy.testing]")
        for item in re.findall(r'"([A-Za-z][\w-]*)\s*(?:\[[^]]*\])?\s*[<>=~!][^"]*"', new):
            quoted = re.compile(rf'"{item}[^"\w-][^"]*"')
            if item.lower() in REQUIREMENTS:
                new = quoted.sub(f'"{REQUIREMENTS[item.lower()]}"', new)
            elif item.lower().startswith(("robotpy-", "photonlibpy", "pyfrc")):
                new = re.sub(rf",?\s*{quoted.pattern}", "", new) if "[" in new else quoted.sub("", new)
                notes.append((number, f"{item} has no release for 2027 that works with 2027.0.0a7: left out"))
        lines.append(new)
    return "".join(lines), notes
