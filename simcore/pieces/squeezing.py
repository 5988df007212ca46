"""How hard pieces are squeezed: the one measure that the length of steps follows, and that foam yields to.

All contacts of pieces are springs and dampers, always. A solver needs short steps where they carry load from one side
of a piece to the other: between a robot and a wall, at the foot of a heap. What a piece is hit with, however hard, has
no other side. So the measure is what contacts on opposite sides have in common: half of the sum of their depths less
the length of the sum of their depths as vectors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from simcore.physics.contact_law import relax
from simcore.physics.engine import Contacts
from simcore.physics.world import PhysicsWorld
from simcore.pieces.pool import PiecePool
from simcore.pieces.reach import TOUCH, Footprint, lengths
from simcore.typing import FloatArray, IntArray

__all__ = ["Squeezing", "squeezes"]

_PERIOD = 6
"""Ticks from one look at a heap to the next, while robots press nothing: it takes longer to build up."""
_LIGHT, _HEAVY = 2.0, 6.0  # [N]; six balls of 0.2 kg lie on one before it is squeezed by the second
_LONGEST, _SHORTEST = 0.02, 0.005
"""[s], of steps up to the one and from the other. 100 balls, 7 deep: overlaps of 4 mm at 10 ms, 1.4 mm at 5 ms."""
_CRUSH, _LEAST = 0.011, 0.0025  # [m, s], move of a robot a step that may press a piece against something, and shortest
_AHEAD = 0.6  # [m]; from a robot's corner to what it may press a piece against within a tick
_MEMORY = 0.1  # [s], in which the measure falls to 1/e where it is no longer found


class Squeezing:
    """Measures how hard pieces are squeezed, lets their foam yield, and chooses the longest step.

    Args:
        world: Where the bodies live.
        pool: The pieces.
    """

    def __init__(self, world: PhysicsWorld, pool: PiecePool) -> None:
        self._world = world
        self._pool = pool
        self._slot_of = np.full(max(pool.rows, default=-1) + 1, -1, dtype=np.int64)
        self._slot_of[pool.rows] = np.arange(len(pool.rows))
        self._dynamic = np.array([1.0 if s.stiffness is None else s.stiffness for s in pool.surfaces])
        self._stiffness = self._dynamic.copy()
        self._yields = np.array([kind.foam is not None for kind in pool.types], dtype=bool)[pool.state.kind]
        self._soft = np.zeros(len(pool.rows), dtype=bool)
        self._before = np.zeros(len(pool.rows))
        self._ticks = self._seen = 0
        self._since = 0.0
        self.force = 0.0
        """The hardest squeeze, of now or a moment ago [N]."""

    def longest_step(self, awake: IntArray, robots: Sequence[Footprint], dt: float) -> float:
        """Longest step of a tick to come [s].

        Args:
            awake: Slots that the engine moves, shape (n,).
            robots: Where robots are.
            dt: Length of the tick [s].
        """
        share = (self.force - _LIGHT) / (_HEAVY - _LIGHT)
        step = math.inf if share <= 0.0 else _LONGEST + (_SHORTEST - _LONGEST) * min(share, 1.0)
        for robot in robots:
            if robot.speed > _CRUSH / _LONGEST and self._may_crush(awake, robot, dt):
                step = min(step, max(_CRUSH / robot.speed, _LEAST))
        return step

    def _may_crush(self, awake: IntArray, robot: Footprint, dt: float) -> bool:
        """Whether a robot can reach a piece within a tick that can reach something solid."""
        state, reach = self._pool.state, math.hypot(robot.half_length, robot.half_width) + _AHEAD
        if not len(awake) or self._world.is_open(robot.x, robot.y, reach):
            return False
        pos = state.pos.take(awake, axis=0)
        reaches = self._pool.radius[awake] + (robot.speed + lengths(state.vel.take(awake, axis=0))) * dt + TOUCH
        near = (robot.gap(pos) < reaches).nonzero()[0]
        return len(near) > 0 and bool(self._world.near_solid(pos[near], reaches[near]).any())

    def read(self, awake: IntArray, dt: float) -> None:
        """Measure after a tick of dt [s]; `awake` are the slots that the engine moves, shape (n,)."""
        self._ticks += 1
        self._since += dt
        self.force = min(self.force, _HEAVY) * math.exp(-dt / _MEMORY)
        if not len(awake):
            return
        is_due = self._ticks % _PERIOD < 2 and self._is_heaped()
        if not (self.force >= _LIGHT or is_due or self._is_robot_pressing()):
            return
        contacts = self._world.engine.contacts()
        force = self._forces(contacts)
        lasting = np.minimum(force, self._before) if self._seen == self._ticks - 1 else np.zeros(len(force))
        self._before, self._seen = force, self._ticks
        self.force = max(self.force, float(lasting.max(initial=0.0)))
        self._yield(lasting / self._stiffness)
        if np.count_nonzero(self._soft):
            self._part_once(contacts.rows)

    def _is_heaped(self) -> bool:
        """Whether what lies higher than on the carpet weighs enough to squeeze what is below it."""
        state, pool = self._pool.state, self._pool
        high = state.touchable & (state.pos[:, 2] > 2.0 * pool.radius)
        return bool(self._world.gravity * pool.mass @ high > _HEAVY)

    def _is_robot_pressing(self) -> bool:
        """Whether a piece that a robot touches has something on its other side, too."""
        engine, slot_of = self._world.engine, self._slot_of
        for robot in self._world.robot_rows:
            rows = np.unique(engine.contacts(robot).rows)
            for row in rows[(rows >= 0) & (rows < len(slot_of))].tolist():
                if slot_of[row] < 0:
                    continue
                around = engine.contacts(row)
                if squeezes(np.where(around.rows == row, 0, -1), around.force, 1)[0] > _LIGHT:
                    return True
        return False

    def _part_once(self, rows: IntArray) -> None:
        """Find anew where soft balls touch something twice: each of the springs would bear as much as the only one."""
        pairs, times = np.unique(np.sort(rows, axis=1), axis=0, return_counts=True)
        for row in np.intersect1d(pairs[times > 1], self._pool.rows_of((self._soft & self._pool.is_ball).nonzero()[0])):
            self._world.engine.renew_contacts(int(row))

    def _forces(self, contacts: Contacts) -> FloatArray:
        """How hard each piece is squeezed [N], shape (slots,)."""
        if len(contacts.rows) < 2:
            return np.zeros(len(self._pool.rows))
        known = np.append(self._slot_of, -1)  # what is no piece
        rows = contacts.rows
        slots = known[np.where((rows >= 0) & (rows < len(self._slot_of)), rows, len(self._slot_of))]
        return squeezes(slots, contacts.force, len(self._pool.rows))

    def _yield(self, depth: FloatArray) -> None:
        """Let foam give way to what squeezes it, or stiffen again."""
        since, self._since = min(self._since, _MEMORY), 0.0
        slots = (self._yields & ((depth > 0.0) | self._soft)).nonzero()[0]
        if not len(slots):
            return
        state, pool = self._pool.state, self._pool
        for kind in np.unique(state.kind[slots]).tolist():
            foam = pool.types[kind].foam
            assert foam is not None
            mine = slots[state.kind[slots] == kind]
            now = relax(foam, self._stiffness[mine], self._dynamic[mine], depth[mine], since)
            for slot, stiffness in zip(mine.tolist(), now.tolist(), strict=True):
                self._world.engine.set_stiffness(pool.rows[slot], stiffness)
            self._stiffness[mine] = now
            self._soft[mine] = now < self._dynamic[mine]


def squeezes(slots: IntArray, force: FloatArray, count: int) -> FloatArray:
    """How hard bodies are squeezed between others, level or upright [N], shape (count,).

    Args:
        slots: Of the two bodies of each contact, -1 for one that is not asked about, shape (n, 2).
        force: On the first, field frame [N], shape (n, 3).
        count: Of bodies.
    """
    who, push = slots.T.ravel(), np.concatenate((force, -force))
    asked = who >= 0
    who, push = who[asked], push[asked]
    x, y, z = (np.bincount(who, push[:, axis], count) for axis in range(3))
    level = np.bincount(who, np.hypot(push[:, 0], push[:, 1]), count) - np.hypot(x, y)
    upright = np.bincount(who, np.abs(push[:, 2]), count) - np.abs(z)
    force_: FloatArray = 0.5 * np.maximum(level, upright)
    return force_
