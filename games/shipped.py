"""Files that come with a game: inside an installed package, or in the source tree."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

__all__ = ["shipped"]


def shipped(package: str, installed: str, source: str) -> Path:
    """A file or folder of a game.

    Args:
        package: Of the game, e.g. `games.rebuilt`.
        installed: Its path in the package's folder `models`.
        source: Its path in the source tree's folder `models`.
    """
    packaged = Path(str(resources.files(package))) / "models" / installed
    return packaged if packaged.exists() else Path(__file__).resolve().parents[1] / "models" / source
