"""Which sleepers wake in a tick, and which of the others something may touch.

A sleeper wakes before anything can reach it. The others are fixed, statics to the engine, but for those that a knock or
a push may come to within the tick: all that touch what can be hit, and all that touch these, are loosened before it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from simcore.pieces.pool import PiecePool
from simcore.pieces.reach import Footprint, WakeSettings, close_pairs, touching_chain
from simcore.pieces.sleeping import Sleeping
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["Waking"]

_REBOUND = 1.5  # speed of a piece that a robot hits, in parts of the robot's


class Waking:
    """Chooses the sleepers that wake, and sorts the others.

    Args:
        pool: The pieces.
        sleeping: What the engine does to sleepers.
        settings: When pieces wake.
    """

    def __init__(self, pool: PiecePool, sleeping: Sleeping, settings: WakeSettings) -> None:
        self._pool = pool
        self._sleeping = sleeping
        self._p = settings
        self._ticks = 0
        self.guarded = np.zeros(len(pool.rows), dtype=bool)
        """Which slots are within reach of a moving robot, and may not sleep, shape (slots,)."""

    def choose(
        self, awake: IntArray, speed: FloatArray, reach: FloatArray, robots: Sequence[Footprint], dt: float
    ) -> IntArray:
        """The sleepers to wake before a tick; the others are fixed or loosened.

        Args:
            awake: Slots that the engine moves, shape (n,).
            speed: Of each [m/s], shape (n,).
            reach: How far from its center each may touch another's center within the tick [m], shape (n,).
            robots: Where robots are.
            dt: Length of the tick [s].
        """
        state, margin = self._pool.state, self._p.margin
        asleep = (state.touchable & self._pool.is_frozen).nonzero()[0]
        near = np.concatenate((asleep, awake))
        pos, radius = state.pos.take(near, axis=0), self._pool.radius.take(near)
        reached: BoolArray = np.zeros(len(near), dtype=bool)
        knocked: BoolArray = np.zeros(len(near), dtype=bool)
        for robot in robots:
            x, y = robot.beyond(pos)
            way = _REBOUND * robot.speed * dt
            grow = radius + (robot.speed * dt + margin)  # what both can move in a tick
            low, high = robot.heights
            level = (pos[:, 2] > low - grow) & (pos[:, 2] < high + grow)
            knocked |= level & (x < grow + 2.0 * way) & (y < grow + 2.0 * way)
            if robot.speed > robot.waking_speed:
                reached |= level & (x < grow) & (y < grow)
        self.guarded[:] = False
        self.guarded[near[reached]] = True
        is_fast = speed > self._p.waking_speed
        movers = (is_fast | knocked[len(asleep) :]).nonzero()[0]
        if len(movers) and len(asleep):
            near_by = reach[movers]
            i, j, away2 = close_pairs(pos[len(asleep) + movers], pos[: len(asleep)], near_by + speed[movers] * dt)
            knocked[j] = True
            reached[j[is_fast[movers[i]] & (away2 < np.square(near_by).take(i))]] = True
        reached = reached[: len(asleep)]
        self._sort(asleep, reached, knocked, near)
        self._ticks += 1
        return asleep[reached]

    def _sort(self, asleep: IntArray, reached: BoolArray, knocked: BoolArray, near: IntArray) -> None:
        """Loosen all that touches what is knocked, and fix now and then the others.

        Args:
            asleep: Slots of the sleepers that the engine sees, shape (n,).
            reached: Which of them wake, shape (n,).
            knocked: Which of `near` something can hit within the tick, shape (m,).
            near: Slots of the sleepers and of the awake after them, shape (m,).
        """
        pool, count = self._pool, len(asleep)
        is_fixed = self._sleeping.is_fixed[asleep]
        is_due = self._ticks % self._p.slow_ticks == 0 and not is_fixed.all()
        if not (is_due or np.count_nonzero(knocked[:count] & is_fixed)):
            return
        hidden = (pool.is_frozen & ~pool.state.touchable).nonzero()[0]
        slots = np.concatenate((near, hidden))
        first = np.concatenate((knocked, np.zeros(len(hidden), dtype=bool)))
        loose = touching_chain(pool.state.pos.take(slots, axis=0), pool.radius.take(slots), first)
        for slot in hidden[loose[len(near) :]].tolist():
            pool.set_touchable(slot, True)
            self._sleeping.stop(slot)
        self._sleeping.loosen(asleep[loose[:count] & is_fixed & ~reached])
        if is_due:
            self._sleeping.fix(asleep[~(loose[:count] | is_fixed)])
