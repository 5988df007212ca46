"""REBUILT, the game of 2026: fuel, hubs and bumps. Importing this package loads no physics engine."""

from games.rebuilt.game import REBUILT, RebuiltSim

__all__ = ["REBUILT", "RebuiltSim"]
