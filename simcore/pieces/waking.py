"""Which sleepers wake in a tick, and which of the others something may touch.

A sleeper wakes before anything can reach it. One that nothing can touch for now is fixed: a static to the engine. It is
loosened while a knock may come to it along a row within the tick, while an awake piece lies beside it, and while a slow
robot is near, which may push a row none of whose pieces moves by itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from simcore.pieces.pool import PiecePool
from simcore.pieces.sleeping import Sleeping
from simcore.pieces.touching import TOUCH, close_pairs
from simcore.pieces.wake_grid import Footprint, WakeSettings
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["Waking"]

_CHAIN = 1.0  # [m]; from a robot's bumpers to the farthest piece that it can push by others
_KNOCK, _FAR_KNOCK = 0.35, 3.0  # [m]; how far a knock gets along a row in two ticks, and the hardest
_KNOCK_GROWTH, _HARD = 1.0, 2.5  # [s, m/s]; between: ten balls at 4 m/s
_REBOUND = 1.5  # speed of a piece that a robot hits, in parts of the robot's
_PUSHING = 0.3  # [m/s]; a slower robot may push a row of pieces that touch, none of which moves by itself
_FIX_PERIOD = 4  # ticks


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
        state = self._pool.state
        asleep = (state.touchable & self._pool.is_frozen).nonzero()[0]
        self.guarded[:] = False
        moving = [robot for robot in robots if robot.speed > robot.waking_speed]
        knocked: BoolArray = np.zeros(len(asleep), dtype=bool)
        if moving:
            near = np.concatenate((asleep, awake))
            pos, radius = state.pos.take(near, axis=0), self._pool.radius.take(near)
        for robot in moving:
            x, y = robot.beyond(pos)
            grow = radius + (robot.speed * dt + self._p.margin)  # what both can move in a tick
            inside = (x < grow) & (y < grow)
            low, high = robot.heights
            if low > -math.inf or high < math.inf:
                inside &= (pos[:, 2] > low - grow) & (pos[:, 2] < high + grow)
            self.guarded[near[inside]] = True
            away2 = np.square(np.maximum(x[: len(asleep)], 0.0)) + np.square(np.maximum(y[: len(asleep)], 0.0))
            knocked |= away2 < float(_knock_range(_REBOUND * robot.speed)) ** 2
        to_wake = self.guarded[asleep]
        fast = speed > self._p.waking_speed
        if len(asleep) and np.count_nonzero(fast):
            far = reach[fast] + _knock_range(speed[fast])
            reached, ahead = self._reached(awake[fast], reach[fast], asleep, far)
            to_wake |= reached
            knocked |= ahead
        if len(asleep):
            self._sort(asleep, to_wake, knocked, awake[~fast], robots)
        self._ticks += 1
        return asleep[to_wake]

    def _sort(
        self,
        asleep: IntArray,
        to_wake: BoolArray,
        knocked: BoolArray,
        slow: IntArray,
        robots: Sequence[Footprint],
    ) -> None:
        """Loosen the sleepers that something may touch, and fix now and then those that nothing can.

        Args:
            asleep: All that the engine sees, shape (n,).
            to_wake: Which of them wake, shape (n,).
            knocked: Which of them a knock could get to along a row, shape (n,).
            slow: Slots that are awake and wake nobody.
            robots: Where robots are.
        """
        is_due = self._ticks % _FIX_PERIOD == 0
        if not (is_due or np.count_nonzero(knocked)):
            return
        loose = knocked
        if is_due:
            if len(slow):
                loose |= self._reached(slow, 2.0 * self._pool.radius[slow] + TOUCH, asleep)[0]
            for robot in robots:
                if robot.speed < _PUSHING:
                    loose |= robot.gap(self._pool.state.pos.take(asleep, axis=0)) < _CHAIN
            self._sleeping.fix(asleep[~(loose | to_wake)])
        self._sleeping.loosen(asleep[loose & ~to_wake])

    def _reached(
        self, movers: IntArray, reach: FloatArray, sleepers: IntArray, far: FloatArray | None = None
    ) -> tuple[BoolArray, BoolArray]:
        """Which sleepers are in reach of a moving piece, and which not too far ahead of one, shape (sleepers,) each.

        Args:
            movers: Slots, shape (n,).
            reach: Of each [m], shape (n,).
            sleepers: Slots.
            far: How far ahead of each is asked about [m], at least its reach, shape (n,); None: nothing is.
        """
        state, wide = self._pool.state, reach if far is None else far
        a, b = state.pos.take(movers, axis=0), state.pos.take(sleepers, axis=0)
        hit: BoolArray = np.zeros(len(b), dtype=bool)
        ahead: BoolArray = np.zeros(len(b), dtype=bool)
        i, j, close2 = close_pairs(a, b, wide)
        if not len(i):
            return hit, ahead
        hit[j[close2 < np.square(reach).take(i)]] = True
        if far is not None:
            vel = state.vel.take(movers, axis=0)
            along = np.einsum("ij,ij->i", b.take(j, axis=0) - a.take(i, axis=0), vel.take(i, axis=0))
            wide2 = (0.5 * np.einsum("ij,ij->i", vel, vel)).take(i) * close2  # a cone of 45 degrees
            ahead[j[(along > 0.0) & (along * along > wide2)]] = True
        return hit, ahead


def _knock_range(speed: FloatArray | float) -> FloatArray | float:
    """How far a knock of each speed [m/s] gets along a row in two ticks [m]."""
    return np.minimum(np.maximum(_KNOCK_GROWTH * (speed - _HARD), _KNOCK), _FAR_KNOCK)
