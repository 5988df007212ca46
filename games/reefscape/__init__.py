"""REEFSCAPE, the 2025 game: coral, algae and a reef. Importing this package loads no physics engine."""

from games.reefscape.game import REEFSCAPE

__all__ = ["REEFSCAPE"]
