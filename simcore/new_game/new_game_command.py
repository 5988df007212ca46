"""Command `simcore new-game NAME`, which writes the package of a new game from a template.

The package runs and passes its tests without changes.
"""

from __future__ import annotations

import argparse
import keyword
import re
from collections.abc import Iterable
from importlib import resources
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from simcore.errors import ConfigError, OutputError
from simcore.match.registry import installed_games
from simcore.quantities import Quantity, number_flag

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

__all__ = ["add_arguments", "run", "write_game"]

_NAME = re.compile(r"[a-z][a-z0-9_]{1,30}")

_YEAR = Quantity("", 1992, 2100, is_whole=True)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments and options of `simcore new-game`."""
    parser.add_argument("name", metavar="NAME", help="name of the game: lower-case letters, digits and _, e.g. discs")
    parser.add_argument(
        "--year",
        type=number_flag(_YEAR),
        help="year of the game (default: below those of the installed ones, so that they stay the default)",
    )
    parser.add_argument("--folder", type=Path, metavar="FOLDER", help="folder to write to (default: ./NAME)")


def run(args: argparse.Namespace) -> int:
    """Write the package of a new game, print the written files and the next steps, and return exit status 0.

    Raises:
        ConfigError: If the name or the year is invalid.
        OutputError: If the folder is not empty or cannot be written.
    """
    year = args.year or _year_below(game.year for game in installed_games().values())
    folder = args.folder or Path(args.name)
    written = write_game(args.name, year=year, folder=folder)
    for path in written:
        print(path)
    print(
        f"\nPlay it, test it:\n\n    cd {folder}\n    python -m pip install -e .\n    simcore play {args.name}\n"
        f"    python -m pytest\n\nIts year is {year}, in game.py: the newest game is played if none is named.\n"
        "Its README.md says what to change, and in which order."
    )
    return 0


def _year_below(years: Iterable[int]) -> int:
    """Return the year before the newest of the years, so the newest installed game remains the default.

    Without years, return the first valid year.
    """
    return max(years, default=int(_YEAR.least) + 1) - 1


def write_game(name: str, *, year: int, folder: Path) -> list[Path]:
    """Write the package of a new game, with the tests, from the template.

    Args:
        name: Name of the game and of the package.
        year: Year of the game.
        folder: Folder for the package; the folder must be new or empty.

    Returns:
        Paths of the written files, in a useful reading order.

    Raises:
        ConfigError: If the name or the year is invalid.
        OutputError: If the folder is not empty or cannot be written.
    """
    if not _NAME.fullmatch(name) or keyword.iskeyword(name) or name in ("simcore", "games", "tests"):
        raise ConfigError(
            "a game's name is 2 to 31 lower-case letters, digits and '_', begins with a letter and is not a Python "
            f"keyword, e.g. 'discs'; got {name!r}"
        )
    if name in entry_points(group="simcore.games").names or find_spec(name) is not None:
        raise ConfigError(f"{name!r} is a game or module that is installed; choose another, e.g. 'my_{name}'")
    if not _YEAR.least <= year <= _YEAR.most:
        raise ConfigError(f"year must be {_YEAR.least} to {_YEAR.most}, got {year}")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise OutputError(f"{str(folder)!r} is there already and not empty; name another --folder")
    values = {"name": name, "NAME": name.upper(), "Name": _title(name), "year": str(year)}
    written = []
    try:
        for source, target in _files(name):
            text = source.read_text(encoding="utf-8")
            for key, value in values.items():
                text = text.replace(f"@{key}@", value)
            path = folder / target
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="\n")
            written.append(path)
    except OSError as error:
        raise OutputError(f"cannot write to {str(folder)!r}: {error.strerror or error}") from error
    return written


def _title(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("_"))


def _files(name: str) -> list[tuple[Traversable, str]]:
    """Return each template file, and the relative path of the file to write for the game `name`."""
    template = resources.files("simcore.new_game") / "template"
    package = ("dimensions", "field", "pieces", "staging", "rules", "robot", "autos", "game")
    return [
        (template / "README.md.txt", "README.md"),
        (template / "pyproject.toml.txt", "pyproject.toml"),
        (template / "init.py.txt", f"{name}/__init__.py"),
        *((template / f"{module}.py.txt", f"{name}/{module}.py") for module in package),
        (template / "test_game.py.txt", f"tests/test_{name}.py"),
    ]
