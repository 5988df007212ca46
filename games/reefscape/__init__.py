"""REEFSCAPE, the game of 2025: coral on the reef, algae off it. Loading it loads no physics engine."""

from games.reefscape.game import REEFSCAPE

__all__ = ["REEFSCAPE"]
