"""REBUILT, the game of 2026: fuel, hubs and bumps. Loading it loads no physics engine."""

from games.rebuilt.game import REBUILT, RebuiltSim

__all__ = ["REBUILT", "RebuiltSim"]
