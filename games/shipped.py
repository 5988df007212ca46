"""Paths of files shipped with a game, in an installed package or in the source tree."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

__all__ = ["shipped"]


def shipped(game: str, name: str) -> Path:
    """Return the path of a file or folder shipped with a game.

    Args:
        game: Name of the game's package in `games`.
        name: Path relative to `models` in the installed package, or to `models/<game>` in the source tree.

    Returns:
        Path in the installed package if the path exists there, otherwise the path in the source tree.
    """
    packaged = Path(str(resources.files(f"games.{game}"))) / "models" / name
    return packaged if packaged.exists() else Path(__file__).resolve().parents[1] / "models" / game / name
