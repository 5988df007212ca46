"""The games that are installed: entry points of the group `simcore.games`, each a `Game`."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from simcore.errors import ConfigError, UnknownNameError
from simcore.install_text import install_command
from simcore.match.game import Game

__all__ = ["GROUP", "NO_GAME", "find_game", "installed_games", "practice_field"]

GROUP = "simcore.games"
"""Of the entry points; the name of each is the game's."""

NO_GAME = "none"
"""Name by which the empty field is chosen."""

_BESIDE = Path(__file__).resolve().parents[2]
"""The folder that simcore lies in."""

_log = logging.getLogger(__name__)


def installed_games() -> dict[str, Game]:
    """All games by name, the newest year first.

    Raises:
        ConfigError: An entry point is not a game.
    """
    games: dict[str, Game] = {}
    for point in entry_points(group=GROUP):
        game = _load(point)
        if not isinstance(game, Game):
            raise ConfigError(f"entry point {point.name!r} of {GROUP} must be a Game, got {point.value}")
        if game.name != point.name:
            raise ConfigError(f"entry point {point.name!r} of {GROUP} is the game {game.name!r}: name it so")
        if games.setdefault(game.name, game) is not game:
            raise ConfigError(f"two games are named {game.name!r}, one of them {point.value}: uninstall or rename one")
    return dict(sorted(games.items(), key=lambda item: (-item[1].year, item[0])))


def practice_field(size: tuple[float, float] = (16.0, 8.0)) -> Game:
    """No year's game: carpet and a wall, without pieces and tags.

    Args:
        size: Length and width [m].
    """
    return replace(Game.bare(size=size), name=NO_GAME, title=f"no game ({size[0]:g} x {size[1]:g} m of carpet)")


def find_game(name: str | None = None, *, say: Callable[[str], object] | None = None) -> Game:
    """The game of a name; None: the newest, which is said if there are several.

    Args:
        name: Of the game, or `none`: the empty field.
        say: Told which game was taken, if it was not named; None: the log.

    Raises:
        UnknownNameError: No game of that name is installed; the error carries the nearest names.
        ConfigError: No game is installed at all, or the name is that of an auto.
    """
    if name == NO_GAME:
        return practice_field()
    games = installed_games()
    if not games:
        raise ConfigError(f"no game is installed (entry points {GROUP}); {install_command()} brings one")
    if name is None:
        newest = next(iter(games.values()))
        if len(games) > 1:
            others = ", ".join(other for other in games if other != newest.name)
            (say or _log.info)(f"game {newest.name} ({newest.year}), the newest; also installed: {others}")
        return newest
    if name not in games:
        for game in games.values():
            if name in game.autos:
                raise ConfigError(f"no game named {name!r}: it is an auto of {game.name}, as in `--auto {name}`")
        raise UnknownNameError("game", name, games)
    return games[name]


def _load(point: EntryPoint) -> object:
    """What an entry point names, also where a robot project has a `games.py` or a package `games` of its own.

    That one comes first on the path and stays what `import games` gives; modules of the folder beside simcore are then
    found as well.
    """
    first, dot, _ = point.module.partition(".")
    folder = str(_BESIDE / first)
    if dot and (_BESIDE / first).is_dir():
        package = import_module(first)
        path = list(getattr(package, "__path__", ()))
        if folder not in path:
            package.__path__ = [*path, folder]
    return point.load()
