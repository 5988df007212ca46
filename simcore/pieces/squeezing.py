"""How hard pieces are squeezed: the one measure that the length of steps follows, and that foam yields to.

All contacts of pieces are springs and dampers, always. A solver needs short steps where they carry load from one side
of a piece to the other: between a robot and a wall, at the foot of a heap. What a piece is hit with, however hard, has
no other side. So the measure is what contacts on opposite sides have in common: half of the sum of their depths less
the length of the sum of their depths as vectors.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.physics.engine import Contacts
from simcore.physics.world import PhysicsWorld
from simcore.pieces.foam import relax
from simcore.pieces.pool import PiecePool
from simcore.typing import FloatArray

__all__ = ["Squeezing", "squeezes"]

_PERIOD = 4
"""Ticks from one look at all contacts to the next, while robots press nothing: a heap takes longer to build up."""
_LIGHT, _HEAVY = 4.0, 12.0  # [N]; six fuel lie on one before it is squeezed by the second
_LONGEST, _SHORTEST = 0.02, 0.005
"""[s], of steps up to the one and from the other. 100 balls, 7 deep: overlaps of 4 mm at 10 ms, 1.4 mm at 5 ms."""
_MEMORY = 0.1  # [s], in which the measure falls to 1/e where it is no longer found
_SHALLOW = 4e-5
"""[m]; contacts that are less deep are left out: 4 N at a stiffness of 1e5 N/m, the weight of two fuel."""


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
        self._ticks = 0
        self._since = 0.0
        self.force = 0.0
        """The hardest squeeze, of now or a moment ago [N]."""

    @property
    def longest_step(self) -> float:
        """Longest step of the tick to come [s]."""
        share = (self.force - _LIGHT) / (_HEAVY - _LIGHT)
        if share <= 0.0:
            return math.inf
        return _LONGEST + (_SHORTEST - _LONGEST) * min(share, 1.0)

    def read(self, dt: float) -> None:
        """Measure after a tick of dt [s]."""
        self._ticks += 1
        self._since += dt
        self.force *= math.exp(-dt / _MEMORY)
        if self.force < _LIGHT and self._ticks % _PERIOD and not self._is_robot_pressing():
            return
        depth = self._depths(self._world.engine.contacts())
        self.force = max(self.force, float((depth * self._stiffness).max(initial=0.0)))
        self._yield(depth)

    def _is_robot_pressing(self) -> bool:
        """Whether a piece that a robot touches has something on its other side, too."""
        engine, slot_of = self._world.engine, self._slot_of
        for robot in self._world.robot_rows:
            pressed = engine.contacts(robot)
            others = np.unique(pressed.rows[pressed.depth > _SHALLOW].ravel())
            for row in others[(others < len(slot_of)) & (others >= 0)].tolist():
                slot = slot_of[row]
                if slot >= 0 and self._depths(engine.contacts(row))[slot] * self._stiffness[slot] > _LIGHT:
                    return True
        return False

    def _depths(self, contacts: Contacts) -> FloatArray:
        """How deep each piece is squeezed, shape (slots,)."""
        deep = contacts.depth > _SHALLOW
        if np.count_nonzero(deep) < 2:
            return np.zeros(len(self._pool.rows))
        rows, normal, depth = contacts.rows[deep], contacts.normal[deep], contacts.depth[deep]
        known = np.append(self._slot_of, -1)  # what is no piece
        slots = known[np.where((rows >= 0) & (rows < len(self._slot_of)), rows, len(self._slot_of))]
        give = np.where(slots >= 0, 1.0 / self._stiffness[slots], 0.0)
        share = depth[:, None] * give / np.maximum(give.sum(axis=1), 1e-300)[:, None]
        return squeezes(slots, normal, share, len(self._pool.rows))

    def _yield(self, depth: FloatArray) -> None:
        """Let foam give way to what squeezes it, or stiffen again."""
        since, self._since = self._since, 0.0
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


def squeezes(slots: np.ndarray, normal: FloatArray, depth: FloatArray, count: int) -> FloatArray:
    """How deep bodies are squeezed between others [m], shape (count,).

    Args:
        slots: Of the two bodies of each contact, -1 for one that is not asked about, shape (n, 2).
        normal: From the second to the first, shape (n, 3).
        depth: Of each of the two in the contact [m], shape (n, 2).
        count: Of bodies.
    """
    who = np.concatenate((slots[:, 0], slots[:, 1]))
    size = np.concatenate((depth[:, 0], depth[:, 1]))
    push = size[:, None] * np.concatenate((normal, -normal))
    asked = who >= 0
    who, size, push = who[asked], size[asked], push[asked]
    total = np.bincount(who, size, count)
    net2 = sum((np.bincount(who, push[:, axis], count) ** 2 for axis in range(3)), np.zeros(count))
    return 0.5 * (total - np.sqrt(net2))
