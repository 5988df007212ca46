"""Which pieces come to rest, and what the engine does to those that sleep.

A piece sleeps when it has been slow for a while: under gravity nothing stays slow in the air, so a sleeper is always
supported. The engine moves sleepers when something touches them; those that really move join the awake. Sleepers that
nothing can touch for now are fixed, as statics are: then they cost next to nothing, and end the chain of touching
pieces that one awake piece keeps awake in the engine.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from simcore.physics.world import PhysicsWorld
from simcore.pieces.pool import PiecePool, PieceStatus
from simcore.pieces.touching import close_pairs
from simcore.pieces.wake_grid import WakeSettings
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["SETTLE_PERIOD", "Sleeping"]

SETTLE_PERIOD = 2
"""Ticks from one look for pieces that have come to rest to the next."""
_AUDIT_PERIOD = 6  # readings of the sleepers
_STIRRED = 1e-4  # [m]; a sleeper that the engine moved farther in a tick is awake: 5 mm/s
_PUSHED = 2e-5  # [m]; one that it moved less has only been looked at by the engine, not pressed
_SHIFT = 3e-4  # [m]; a ball in a heap that moves farther between two readings is not fixed yet, others if they move
_ROCKING = 0.08  # [m/s]; pieces that are no balls count as slow below this: they rock on an edge, but do not roll on
_TURNING = 0.5  # [rad/s]; pieces that are no balls do not sleep while they turn faster
_DEEP = 0.005  # [m]; a piece that is this deep in something does not sleep
_STILL = 1e-3  # [m/s]
_AWAKE = int(PieceStatus.AWAKE)


class Sleeping:
    """Finds the pieces that come to rest, and the sleepers that no longer are.

    Args:
        world: Where the bodies live.
        pool: The pieces.
        settings: When pieces sleep.
        wake: Lets a sleeping piece move: called with its slot.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        pool: PiecePool,
        settings: WakeSettings,
        wake: Callable[[int], None],
    ) -> None:
        self._world = world
        self._pool = pool
        self._p = settings
        self._wake = wake
        self._slow = np.zeros(len(pool.rows), dtype=np.int64)  # ticks
        self._slow_speed = np.where(pool.is_ball, settings.slow_speed, _ROCKING)
        self.stirred: IntArray = np.zeros(0, dtype=np.int64)
        """Sleepers that the engine had moved a little when they were last read."""
        self._has_others = not bool(pool.is_ball.all())
        self._readings = 0
        self._gives_way = np.zeros(len(pool.rows), dtype=bool)  # sleepers that moved before the last reading
        self._may_shift = np.where(pool.is_ball, _SHIFT, 0.0)
        self.is_fixed = np.zeros(len(pool.rows), dtype=bool)
        """Which of the sleepers nothing moves until they are loosened or woken, shape (slots,)."""

    def stir(self, slot: int) -> None:
        """A piece moves: the time in which it must be slow begins anew."""
        self._slow[slot] = 0
        self.is_fixed[slot] = False

    def stop(self, slot: int) -> None:
        """A piece has come to rest: it sleeps until something touches it, and where nothing can it is fixed."""
        self._world.engine.sleep(self._pool.rows[slot])
        self.is_fixed[slot] = False
        if not self._pool.state.touchable[slot]:
            self._fix(np.array([slot]))

    def fix(self, slots: IntArray) -> None:
        """Let nothing move those of some sleepers that nothing can touch for a while now."""
        self._fix(slots[~(self._gives_way[slots] | self.is_fixed[slots])])

    def _fix(self, slots: IntArray) -> None:
        if len(slots):
            self._pool.state.pos[slots] = self._world.engine.centers(self._pool.rows_of(slots))  # the last one for long
        for slot in slots.tolist():
            self._world.engine.fix(self._pool.rows[slot])
        self.is_fixed[slots] = True

    def loosen(self, slots: IntArray) -> None:
        """Let what touches some sleepers move them."""
        for slot in slots[self.is_fixed[slots]].tolist():
            self._world.engine.sleep(self._pool.rows[slot])
        self.is_fixed[slots] = False

    def at_rest(self, awake: IntArray, guarded: BoolArray) -> IntArray:
        """Which of the awake pieces have been slow for long enough; to be asked every `SETTLE_PERIOD` ticks.

        Args:
            awake: Slots that the engine moves, shape (n,).
            guarded: Which slots may not sleep, shape (slots,).
        """
        state, p = self._pool.state, self._p
        vel = state.vel.take(awake, axis=0)
        speed2 = np.einsum("ij,ij->i", vel, vel)
        slow = (speed2 < np.square(self._slow_speed[awake])) & (state.status[awake] == _AWAKE)
        self._slow[awake] = np.where(slow, self._slow[awake] + SETTLE_PERIOD, 0)
        # what has been slow for long and stands still is at no apex: half the time is enough
        is_calm = speed2 < _STILL * _STILL
        enough = np.where(is_calm, p.slow_ticks // 2, p.slow_ticks)
        ready = awake[(self._slow[awake] >= enough) & ~guarded[awake]]
        others = ready[~self._pool.is_ball[ready]] if self._has_others else ready[:0]
        if len(others):  # they can turn on the spot
            spin = self._world.engine.velocities(self._pool.rows_of(others))[:, 3:]
            turning = others[np.einsum("ij,ij->i", spin, spin) > _TURNING * _TURNING]
            ready = np.setdiff1d(ready, turning, assume_unique=True)
        return ready

    def are_deep(self, slots: IntArray) -> BoolArray:
        """Which pieces are squeezed, shape (n,): the engine would push them out as soon as they wake."""
        if not len(slots):
            return np.zeros(0, dtype=bool)
        state, radius, world = self._pool.state, self._pool.radius, self._world
        pos = state.pos.take(slots, axis=0)
        doubtful = world.near_solid(pos, radius[slots])
        others = state.touchable.nonzero()[0]
        i, j, away2 = close_pairs(pos, state.pos.take(others, axis=0), radius[slots] + radius.max())
        reach = radius[slots][i] + radius[others][j] - _DEEP
        near = (away2 < reach * reach) & (slots[i] != others[j])
        i, j = i[near], others[j[near]]
        doubtful[i] = True
        deep: BoolArray = np.zeros(len(slots), dtype=bool)
        deep[i[self._pool.is_ball[slots[i]] & self._pool.is_ball[j]]] = True
        if self._has_others:
            doubtful |= ~self._pool.is_ball[slots]
        for number in np.nonzero(doubtful & ~deep)[0].tolist():
            deep[number] = world.engine.overlap(self._pool.rows[int(slots[number])]) > _DEEP
        return deep

    def read(self, dt: float) -> None:
        """Follow the sleepers that the engine woke by touch in the last dt [s]: those that move join the awake.

        Those that hardly move stay asleep, and are stopped now and then, all at once: one awake body keeps all that it
        touches awake in the engine, and awake bodies cost time.
        """
        state = self._pool.state
        asleep = (state.touchable & self._pool.is_frozen & ~self.is_fixed).nonzero()[0]
        self._readings += 1
        if not len(asleep):
            self.stirred = asleep
            return
        still, moved = self.follow(asleep, dt)
        pushed = moved > _PUSHED
        self.stirred = still[pushed]
        self._gives_way[still] = moved > self._may_shift[still]
        if self._readings % _AUDIT_PERIOD == 0:
            doubtful = still[pushed]
            deep = doubtful[self.are_deep(doubtful)]
            for slot in deep.tolist():
                self._wake(slot)
            if np.count_nonzero(moved):
                for slot in np.setdiff1d(still, deep, assume_unique=True).tolist():
                    self._world.engine.sleep(self._pool.rows[slot])

    def follow(self, slots: IntArray, dt: float) -> tuple[IntArray, FloatArray]:
        """Read where sleepers are: which stay asleep, and how far the engine has moved each of those all the same."""
        now = self._world.engine.centers(self._pool.rows_of(slots))
        way = now - self._pool.state.pos.take(slots, axis=0)
        moved: FloatArray = np.abs(way).max(axis=1, initial=0.0)
        self._pool.state.pos[slots] = now
        self._pool.changes += bool(np.count_nonzero(moved))
        woken = moved > _STIRRED
        self._pool.state.vel[slots[woken]] = way[woken] / dt
        for slot in slots[woken].tolist():
            self._wake(slot)
        return slots[~woken], moved[~woken]
