"""REEFSCAPE, the game of 2025: coral on the reef, algae off it. Importing this package loads no physics engine."""

from games.reefscape.game import REEFSCAPE

__all__ = ["REEFSCAPE"]
