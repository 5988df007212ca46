"""Which pieces come to rest, which sleepers wake, and what the engine does to those that sleep.

A piece sleeps when it has been slow for a while: under gravity nothing stays slow in the air, so a sleeper is always
supported. It wakes before anything can reach it. Of the others, those that a knock or a push may come to within the
tick are loose: all that touch what can be hit, and all that touch these. The engine moves them when something touches
them, and those that really move join the awake. The rest are fixed, as statics are: then they cost next to nothing, and
end the chain of touching pieces that one awake piece keeps awake in the engine.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from simcore.geometry.rotation import Vector
from simcore.physics.world import PhysicsWorld
from simcore.pieces.pool import PiecePool, PieceStatus
from simcore.pieces.reach import Footprint, WakeSettings, close_pairs, touching_chain
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["SETTLE_PERIOD", "Sleeping", "WedgedPieces"]

SETTLE_PERIOD = 2
"""Ticks from one look for pieces that have come to rest to the next."""
_DISTURBED = 1e-4  # [m]; a sleeper that the engine moved farther in a tick is awake: 5 mm/s
_ROCKING = 0.08  # [m/s]; pieces that are no balls count as slow below this: they rock on an edge, but do not roll on
_TURNING = 0.5  # [rad/s]; pieces that are no balls do not sleep while they turn faster
_STILL = 1e-3  # [m/s]
_RETURN = 0.2  # share of the way back to its place that a wedged piece goes in a sub-step
_REBOUND = 1.5  # speed of a piece that a robot hits, in parts of the robot's
_AWAKE = int(PieceStatus.AWAKE)


class Sleeping:
    """Finds the pieces that come to rest, and the sleepers that wake.

    Args:
        world: Where the bodies live.
        pool: The pieces.
        settings: When pieces sleep and wake.
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
        self.is_fixed = np.zeros(len(pool.rows), dtype=bool)
        """Which of the sleepers nothing moves until they are loosened or woken, shape (slots,)."""
        self._ticks = 0
        self.guarded = np.zeros(len(pool.rows), dtype=bool)
        """Which slots are within reach of a moving robot, and may not sleep, shape (slots,)."""

    def disturb(self, slot: int) -> None:
        """A piece moves: the time in which it must be slow begins anew."""
        self._slow[slot] = 0
        self.is_fixed[slot] = False

    def stop(self, slot: int) -> None:
        """A piece has come to rest: it sleeps until something touches it, and where nothing can it is fixed."""
        self._world.engine.sleep(self._pool.rows[slot])
        self.is_fixed[slot] = False
        if not self._pool.state.touchable[slot]:
            self._fix(np.array([slot]))

    def _fix(self, slots: IntArray) -> None:
        """Let nothing move some sleepers."""
        if len(slots):
            self._pool.state.pos[slots] = self._world.engine.centers(self._pool.rows_of(slots))  # the last one for long
        for slot in slots.tolist():
            self._world.engine.fix(self._pool.rows[slot])
        self.is_fixed[slots] = True

    def _loosen(self, slots: IntArray) -> None:
        """Let what touches some sleepers move them."""
        for slot in slots[self.is_fixed[slots]].tolist():
            self._world.engine.sleep(self._pool.rows[slot])
        self.is_fixed[slots] = False

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
        self._fix_and_loosen(asleep, reached, knocked, near)
        self._ticks += 1
        return asleep[reached]

    def _fix_and_loosen(self, asleep: IntArray, reached: BoolArray, knocked: BoolArray, near: IntArray) -> None:
        """Loosen all that touches what is knocked, and fix now and then the others.

        Args:
            asleep: Slots of the sleepers that the engine sees, shape (n,).
            reached: Which of them wake, shape (n,).
            knocked: Which of `near` something can hit within the tick, shape (m,).
            near: Slots of the sleepers and of the awake after them, shape (m,).
        """
        pool, count = self._pool, len(asleep)
        is_fixed = self.is_fixed[asleep]
        is_due = self._ticks % self._p.slow_ticks == 0 and not is_fixed.all()
        if not (is_due or np.count_nonzero(knocked[:count] & is_fixed)):
            return
        hidden = (pool.is_frozen & ~pool.state.touchable).nonzero()[0]
        slots = np.concatenate((near, hidden))
        first = np.concatenate((knocked, np.zeros(len(hidden), dtype=bool)))
        loose = touching_chain(pool.state.pos.take(slots, axis=0), pool.radius.take(slots), first)
        for slot in hidden[loose[len(near) :]].tolist():
            pool.set_touchable(slot, True)
            self.stop(slot)
        self._loosen(asleep[loose[:count] & is_fixed & ~reached])
        if is_due:
            self._fix(asleep[~(loose[:count] | is_fixed)])

    def at_rest(self, awake: IntArray) -> IntArray:
        """Which of the awake pieces have been slow for long enough; to be asked every `SETTLE_PERIOD` ticks.

        Args:
            awake: Slots that the engine moves, shape (n,).
        """
        state, p = self._pool.state, self._p
        vel = state.vel.take(awake, axis=0)
        speed2 = np.einsum("ij,ij->i", vel, vel)
        slow = (speed2 < np.square(self._slow_speed[awake])) & (state.status[awake] == _AWAKE)
        self._slow[awake] = np.where(slow, self._slow[awake] + SETTLE_PERIOD, 0)
        # what has been slow for long and stands still is at no apex: half the time is enough
        is_calm = speed2 < _STILL * _STILL
        enough = np.where(is_calm, p.slow_ticks // 2, p.slow_ticks)
        ready = awake[(self._slow[awake] >= enough) & ~self.guarded[awake]]
        others = ready[~self._pool.is_ball[ready]]
        if len(others):  # they can turn on the spot
            spin = self._world.engine.velocities(self._pool.rows_of(others))[:, 3:]
            turning = others[np.einsum("ij,ij->i", spin, spin) > _TURNING * _TURNING]
            ready = np.setdiff1d(ready, turning, assume_unique=True)
        return ready

    def read(self, dt: float) -> None:
        """Follow the sleepers that are loose: those that the engine moved in the last dt [s] join the awake."""
        loose = (self._pool.state.touchable & self._pool.is_frozen & ~self.is_fixed).nonzero()[0]
        if len(loose):
            self.follow(loose, dt)

    def follow(self, slots: IntArray, dt: float) -> IntArray:
        """Read where sleepers are, and wake those that the engine has moved in the last dt [s]; returns the others."""
        state = self._pool.state
        now = self._world.engine.centers(self._pool.rows_of(slots))
        way = now - state.pos.take(slots, axis=0)
        moved = np.abs(way).max(axis=1, initial=0.0)
        state.pos[slots] = now
        self._pool.changes += bool(np.count_nonzero(moved))
        woken = moved > _DISTURBED
        state.vel[slots[woken]] = way[woken] / dt
        for slot in slots[woken].tolist():
            self._wake(slot)
        asleep: IntArray = slots[~woken]
        return asleep


class WedgedPieces:
    """Pieces that are wedged in where they were staged, and come free when something pulls or pushes hard enough.

    A wedged piece sleeps. While it is awake it is held before each sub-step. What others pushed and pulled it with in
    the last one is known from the velocity that they gave it: m v / h. The hold pushes back with as much, so that it
    carries what lies on it, and leads the piece back to its place. It comes free for good when this and its weight are
    more than the force that holds it, or when a robot takes it.

    Args:
        world: Where the bodies live.
        pool: The pieces.
    """

    def __init__(self, world: PhysicsWorld, pool: PiecePool) -> None:
        self._world = world
        self._pool = pool
        n = len(pool.rows)
        self._force = np.zeros(n)  # 0: not wedged
        self._places: dict[int, Vector] = {}
        # of those held in the last sub-step: velocity at its start [m/s], and what held it against the pull [m/s^2]
        self._given: dict[int, tuple[Vector, Vector]] = {}
        self._h = 0.0  # of the last sub-step
        self._mass = pool.mass
        self.is_used = False
        """Whether any piece is wedged."""
        self._seen: IntArray | None = None  # slots that were awake, and those of them that are wedged
        self._wedged: IntArray = np.zeros(0, dtype=np.int64)

    def wedge(self, slot: int, force: float) -> None:
        """Wedge a piece in where it is; it comes free at a force [N]."""
        self._force[slot] = force
        self._places[slot] = self._world.engine.pose(self._pool.rows[slot])[0]
        self.is_used = True
        self._seen = None

    def free(self, slots: IntArray) -> None:
        """Let pieces come free."""
        self._force[slots] = 0.0
        self.is_used = bool(self._force.any())
        self._seen = None

    def hold(self, h: float, awake: IntArray) -> None:
        """Hold the awake ones for the next sub-step of h [s], or let them come free."""
        if awake is not self._seen:
            self._seen, self._wedged = awake, awake[self._force[awake] > 0.0]
        slots = self._wedged
        if len(slots):
            slots = slots[self._pool.state.status[slots] == _AWAKE]
        if not len(slots) and not self._given:
            self._h = h
            return
        engine = self._world.engine
        before, self._h = self._h or h, h
        given, self._given = self._given, {}
        for slot in slots.tolist():
            row, mass = self._pool.rows[slot], self._mass[slot]
            weight = mass * self._world.gravity
            was = given.get(slot)
            vel = engine.velocity(row)[0]
            pushed = [0.0, 0.0, 0.0]
            if was is not None:
                pushed = [(v - start) / before - hold for v, start, hold in zip(vel, *was, strict=True)]
            if math.hypot(mass * pushed[0], mass * pushed[1], mass * pushed[2] - weight) > self._force[slot]:
                self.free(np.array([slot]))
                continue
            way = zip(engine.pose(row)[0], self._places[slot], strict=True)
            x, y, z = (_RETURN * (place - at) / h for at, place in way)
            ax, ay, az = (-push for push in pushed)  # a force: a speed against the pull would bounce off what is there
            self._given[slot] = (x, y, z), (ax, ay, az)
            engine.set_velocity(row, (x, y, z), (0.0, 0.0, 0.0))
            engine.apply_forces([row], np.array([[mass * ax, mass * ay, mass * az + weight]]))
