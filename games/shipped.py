"""Files shipped with a game: inside an installed package, or in the source tree."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

__all__ = ["shipped"]


def shipped(game: str, name: str) -> Path:
    """Return the path of a file or folder of a game.

    Args:
        game: Name of its package in `games`.
        name: Path in `models` of the installed package, and in `models/<game>` of the source tree.
    """
    packaged = Path(str(resources.files(f"games.{game}"))) / "models" / name
    return packaged if packaged.exists() else Path(__file__).resolve().parents[1] / "models" / game / name
