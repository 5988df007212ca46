"""REBUILT, the 2026 game: fuel, hubs and bumps. Importing this package loads no physics engine."""

from games.rebuilt.game import REBUILT, RebuiltSim

__all__ = ["REBUILT", "RebuiltSim"]
