"""When nothing on the field has moved for so long that nothing needs to be looked for before a tick."""

from __future__ import annotations

import math
from collections.abc import Sequence

from simcore.pieces.wake_grid import Footprint

__all__ = ["Stillness"]

_STILL = 1e-5  # [m/s]; the engine leaves a robot that stands 1e-8
_CARRIED = 1e-3  # [m]; one that is farther from where it stood was put elsewhere


class Stillness:
    """Counts the ticks in which no piece was awake and no robot moved.

    Args:
        ticks: How many of them it takes: until then chunks fall quiet, and sleepers are sorted.
    """

    def __init__(self, ticks: int) -> None:
        self._ticks = ticks
        self._count = 0
        self._robots: Sequence[Footprint] = ()
        self.is_reached = False
        """Whether nothing has moved for that long."""

    def end(self) -> None:
        """Count anew."""
        self._count = 0

    def begin_tick(self, moving: int, robots: Sequence[Footprint]) -> None:
        """See what moves.

        Args:
            moving: How many pieces the engine moves.
            robots: Where robots are.
        """
        if moving or not self._stand(robots):
            self._count = 0
            self._robots = robots
        self._count += 1
        self.is_reached = self._count > self._ticks

    def _stand(self, robots: Sequence[Footprint]) -> bool:
        return len(robots) == len(self._robots) and all(
            now.speed < _STILL and math.hypot(now.x - then.x, now.y - then.y) < _CARRIED
            for now, then in zip(robots, self._robots, strict=True)
        )
