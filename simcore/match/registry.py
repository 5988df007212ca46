"""Installed games: each entry point of the group `simcore.games` is a `Game`.

`find_game` with a name imports only the named game. `installed_games` omits games that fail to load.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path

from simcore.errors import ConfigError, UnknownNameError, start_sentence
from simcore.install_text import install_command
from simcore.match.game import Game

__all__ = [
    "GROUP", "NO_GAME", "find_game", "game_names", "game_point", "installed_games", "known_game", "practice_field",
]  # fmt: skip

GROUP = "simcore.games"
"""Name of the entry point group; the name of an entry point is the name of a game."""

NO_GAME = "none"
"""Name that selects an empty field instead of a game."""

_OWN = "simcore"  # distribution whose games win if another package uses the same name
_BESIDE = Path(__file__).resolve().parents[2]
"""Folder that contains the packages `simcore` and `games`."""

_log = logging.getLogger(__name__)


def installed_games(*, say: Callable[[str], object] = str) -> dict[str, Game]:
    """Load all installed games, and return the games that load without errors, by name, newest year first.

    Args:
        say: Function called with a one-line message, with file and line, for each game that fails to load.
    """
    games = {name: game for name in game_names() if (game := known_game(name, say=say)) is not None}
    return dict(sorted(games.items(), key=lambda item: (-item[1].year, item[0])))


def game_names() -> list[str]:
    """Return the names of all installed games in alphabetical order, without loading the games."""
    return sorted(_points())


def known_game(name: str | None, *, say: Callable[[str], object] = str) -> Game | None:
    """Load a game by name; return None if the game is not installed or fails to load.

    Args:
        name: Name of the game, e.g. from a log.
        say: Function called with a one-line message if the game fails to load (with file and line), or if another
            package also has a game of this name.
    """
    points = _points().get(name or "", [])
    try:
        game = _load(name or "", points) if points else None
    except ConfigError as error:
        say(f"left out: {error}")
        return None
    for point in points[1:]:
        say(f"left out: game {name} of the package {_package(point)}: simcore has one of that name: rename it")
    return game


def practice_field(size: tuple[float, float] = (16.0, 8.0)) -> Game:
    """Return the game `none`: a carpet surrounded by a wall, without pieces, zones, autos or AprilTags.

    Args:
        size: Length and width of the field [m].
    """
    return replace(Game.bare(size=size), name=NO_GAME, title=f"no game ({size[0]:g} x {size[1]:g} m of carpet)")


def find_game(name: str | None = None, *, say: Callable[[str], object] | None = None) -> Game:
    """Return a game by name, or the newest installed game if the name is None.

    Args:
        name: Name of the game, or `none` for the empty field.
        say: Function called with a one-line message about the default choice and each game that fails; None to log.

    Raises:
        UnknownNameError: If no game of this name is installed; the message suggests similar names.
        ConfigError: If no game is installed, the game fails to load, or the name is the name of an auto or a year.
    """
    if name == NO_GAME:
        return practice_field()
    points = _points()
    if name in points:
        return _load(name, points[name])
    games = installed_games(say=str if name else say or _log.warning)
    for game in games.values():
        if name in game.autos:
            raise ConfigError(f"no game named {name!r}: it is an auto of {game.name}, as in `--auto {name}`")
        if name == str(game.year):
            raise ConfigError(f"no game named {name!r}: the game of {game.year} is {game.name}")
    if name is not None and points:
        raise UnknownNameError("game", name, points)
    if not games:
        raise ConfigError(f"no game is installed (entry points {GROUP}); {install_command()} installs one")
    newest, *others = games.values()
    if others:
        also = ", ".join(other.name for other in others)
        (say or _log.info)(f"game {newest.name} ({newest.year}), the newest; also installed: {also}")
    return newest


def game_point(name: str) -> EntryPoint:
    """Return the entry point of an installed game.

    Raises:
        KeyError: If no game of this name is installed.
    """
    return _points()[name][0]


def _points() -> dict[str, list[EntryPoint]]:
    """Return the entry points of each installed game, by name of the game.

    An entry point of simcore's own distribution is the first in the list.
    """
    found: dict[str, dict[str, EntryPoint]] = {}
    for point in entry_points(group=GROUP):
        found.setdefault(point.name, {}).setdefault(point.value, point)
    return {name: sorted(points.values(), key=lambda p: _package(p) != _OWN) for name, points in found.items()}


def _package(point: EntryPoint) -> str:
    """Return the name of an entry point's distribution, or the entry point's value if there is no distribution."""
    return point.value if point.dist is None else point.dist.name


def _load(name: str, points: list[EntryPoint]) -> Game:
    """Load a game from the first entry point in a list.

    Raises:
        ConfigError: If several packages other than simcore provide the game, if the import fails (the message states
            the file and line), or if the entry point is not a `Game` of this name.
    """
    point = points[0]
    if len(points) > 1 and _package(point) != _OWN:
        packages = " and ".join(f"{_package(point)} ({point.value})" for point in points)
        raise ConfigError(f"game {name}: {packages} all provide a game of that name: uninstall or rename one")
    try:
        game = _imported(point)
    except (Exception, SystemExit) as error:  # any failure of another package's import
        package = _place_of(point)
        why = start_sentence(error, package, base=package.parent)
        raise ConfigError(f"game {name} of the package {_package(point)} does not load: {why}") from None
    if not isinstance(game, Game):
        raise ConfigError(
            f"game {name} of the package {_package(point)}: {point.value} must be a Game, got {game!r:.80}"
        )
    if game.name != name:
        raise ConfigError(f"entry point {name!r} of {GROUP} is the game {game.name!r}: give it that name")
    return game


def _place_of(point: EntryPoint) -> Path:
    """Return the folder of an entry point's top-level package, or the file of a module; `os.devnull` if unknown."""
    try:
        spec = find_spec(point.module.partition(".")[0])
    except (ImportError, ValueError):
        spec = None
    if spec is None:
        return Path(os.devnull)
    return Path(next(iter(spec.submodule_search_locations or (spec.origin or os.devnull,))))


def _imported(point: EntryPoint) -> object:
    """Import and return the object of an entry point, even if a robot project has a module or package named `games`.

    The function appends the `games` folder next to simcore to the `__path__` of the project's `games`. In the project,
    `import games` still returns the project's own module.
    """
    first, dot, _ = point.module.partition(".")
    folder = str(_BESIDE / first)
    if dot and (_BESIDE / first).is_dir():
        package = import_module(first)
        path = list(getattr(package, "__path__", ()))
        if folder not in path:
            package.__path__ = [*path, folder]
    return point.load()
