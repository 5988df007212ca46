"""The balls that may have impacts in a tick, as arrays: where each is, how it moves, and which pairs may meet.

Pairs are looked for once a tick, by what each ball can move in it. What an impact sends elsewhere looks around itself.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.rotation import Vector
from simcore.physics.contact_law import ENGINE_SPEED
from simcore.physics.world import PhysicsWorld
from simcore.pieces.pool import PiecePool
from simcore.pieces.reach import lengths
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["Arc", "BallRows", "swept_pairs"]

_SKIN = 0.002  # [m]
_END = 1e-9  # [s], of a tick: what is left then is rounding


class Arc:
    """One ball in a part of a tick, from its last impact on; between impacts, pairs are looked for along its chord."""

    __slots__ = (
        *("acc", "base", "changes", "chord", "is_flying", "is_landing", "is_touched", "number", "pos", "radius"),
        *("slot", "spin", "surfaces", "time", "vel"),
    )

    def __init__(self, number: int, slot: int, radius: float, pos: Vector, vel: Vector, spin: Vector) -> None:
        self.number, self.slot, self.radius = number, slot, radius
        self.pos, self.vel, self.spin = pos, vel, spin
        self.acc: Vector = (0.0, 0.0, 0.0)
        self.is_flying = self.is_landing = self.is_touched = False
        self.time = 0.0
        self.changes = self.surfaces = 0
        self.base, self.chord = pos, vel

    @property
    def is_free(self) -> bool:
        """Whether it flies, and nothing carries it."""
        return self.is_flying and not self.is_landing

    def at(self, time: float) -> Vector:
        """Where it is at a time of the part [m]."""
        t, (x, y, z), (vx, vy, vz), (ax, ay, az) = time - self.time, self.pos, self.vel, self.acc
        s = 0.5 * t * t
        return x + vx * t + ax * s, y + vy * t + ay * s, z + vz * t + az * s

    def velocity(self, time: float) -> Vector:
        """Its velocity at a time of the part [m/s]."""
        t, (vx, vy, vz), (ax, ay, az) = time - self.time, self.vel, self.acc
        return vx + ax * t, vy + ay * t, vz + az * t

    def aim(self, h: float) -> None:
        """Find the chord of the rest of the part of h [s]: its velocity, and where it was at time 0."""
        half, now = 0.5 * (h - self.time), self.time
        (x, y, z), (vx, vy, vz), (ax, ay, az) = self.pos, self.vel, self.acc
        vx, vy, vz = vx + half * ax, vy + half * ay, vz + half * az
        self.chord = vx, vy, vz
        self.base = x - now * vx, y - now * vy, z - now * vz


class BallRows:
    """All balls on the field in a tick, one a row.

    Args:
        world: Where the bodies live.
        pool: The pieces.
        slots: Of the balls, shape (n,).
        is_flying: Which of all slots fly.
        pos: Centers [m], shape (n, 3).
        vel: [m/s], shape (n, 3).
        dt: Time left in the tick [s].
    """

    def __init__(
        self,
        world: PhysicsWorld,
        pool: PiecePool,
        slots: IntArray,
        is_flying: BoolArray,
        pos: FloatArray,
        vel: FloatArray,
        dt: float,
    ) -> None:
        self._world, self._pool, self._is_flying, self._left = world, pool, is_flying, dt
        self.slots = slots
        self.number = np.full(len(pool.rows), -1, dtype=np.int64)
        """Row of each slot, -1 for none, shape (slots,)."""
        self.number[slots] = np.arange(len(slots))
        self.radius = pool.radius[slots]
        self._rows = np.concatenate((pos, vel, np.zeros((len(slots), 6))), axis=1)
        self.pos, self.vel, self._spin, self.acc = (self._rows[:, k : k + 3] for k in (0, 3, 6, 9))
        self._is_first = True
        self.is_beside = np.zeros(len(slots), dtype=bool)
        """Which of those that lie may meet the field, a robot or the floor, shape (n,)."""
        self._is_frozen = self._is_exact = pool.is_frozen[slots]
        speed, drift = lengths(vel), world.gravity * dt  # what velocities may change by, impacts left out
        self.reach: FloatArray = self.radius + speed * dt + np.where(self._is_frozen, 0.0, drift * dt) + _SKIN
        """How far from `pos` any point of each may be within the tick if nothing hits it [m], shape (n,)."""
        i, j = swept_pairs(pos, self.reach, 2.0 * speed > ENGINE_SPEED - drift)
        away, closing = pos[j] - pos[i], vel[j] - vel[i]
        along = np.einsum("ij,ij->i", away, closing)
        far = self.radius[i] + self.radius[j] + _SKIN
        may = (speed[i] + speed[j] > ENGINE_SPEED - drift) & (along < 2.0 * drift * far)
        self.pairs = i[may], j[may]
        """Which may meet by what they do now, shape (pairs,) each."""
        self._struck: list[tuple[int, int]] = []  # pairs that impacts have made
        self._homes: FloatArray | None = None  # places since the last hit of each, and reach in the rest of the tick

    def begin_part(
        self, h: float, flying: IntArray, pos: FloatArray, vel: FloatArray, spin: FloatArray, acc: FloatArray
    ) -> None:
        """Take in how the balls are that fly, and those that lie and may have impacts, at the start of a part.

        Args:
            h: Its length [s].
            flying: Numbers of all balls that fly, shape (n,).
            pos: Of these [m], shape (n, 3).
            vel: [m/s], shape (n, 3).
            spin: [rad/s], shape (n, 3).
            acc: [m/s^2], shape (n, 3).
        """
        self._h, self._left, self._is_frozen = h, self._left - h, self._pool.is_frozen[self.slots]
        if self._struck:
            self.pairs = tuple(np.concatenate((self.pairs, np.array(self._struck).T), axis=1))
            self._struck.clear()
        may = self.is_beside.copy()
        may[self.pairs[0]] = may[self.pairs[1]] = True
        may[self._is_frozen | self._is_flying[self.slots]] = False
        awake = may.nonzero()[0]
        rows, engine = self._pool.rows_of(self.slots[awake]), self._world.engine
        if not self._is_first:  # else they are where they were as the tick began
            self.pos[awake] = engine.centers(rows)
        self._rows[awake, 3:9], self._is_first = engine.velocities(rows), False
        self.pos[flying], self.vel[flying], self._spin[flying], self.acc[flying] = pos, vel, spin, acc
        self._is_exact = self._is_frozen.copy()
        self._is_exact[awake] = self._is_exact[flying] = True

    def is_frozen(self, number: int) -> bool:
        """Whether a ball sleeps."""
        return bool(self._is_frozen[number])

    def flies(self, numbers: IntArray) -> BoolArray:
        """Which of some balls fly, shape (n,)."""
        flies: BoolArray = self._is_flying[self.slots[numbers]]
        return flies

    def at_start(self, numbers: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Places [m], chords [m/s] and radii [m] of balls that fly or may have impacts, as they begin the part."""
        pull = np.where(self.flies(numbers)[:, None], (0.5 * self._h) * self.acc[numbers], 0.0)
        return self.pos[numbers], self.vel[numbers] + pull, self.radius[numbers]

    def arc(self, number: int) -> Arc:
        """How a ball begins the part."""
        slot, radius = int(self.slots[number]), float(self.radius[number])
        if not self._is_exact[number]:
            engine, row = self._world.engine, self._pool.rows[slot]
            return Arc(number, slot, radius, engine.pose(row)[0], *engine.velocity(row))
        x, y, z, u, v, w, a, b, c, d, e, f = self._rows[number].tolist()
        arc = Arc(number, slot, radius, (x, y, z), (u, v, w), (a, b, c))
        if self._is_flying[slot]:
            arc.is_flying, arc.acc = True, (d, e, f)
            arc.aim(self._h)
        return arc

    def strike(self, arc: Arc) -> None:
        """Take in how a ball goes on from its last impact in this part: what it may meet in the rest of the tick."""
        self.is_beside[arc.number] = True
        if self._left > _END:
            self._struck += [(arc.number, m) for m in self.around(arc, self._h + self._left)]

    def around(self, arc: Arc, end: float) -> list[int]:
        """Rows of the balls that a ball may meet from its last impact to a time of the part [s], rising."""
        n, (x, y, z), (u, v, w), now = arc.number, arc.pos, arc.chord, arc.time
        speed, rest = math.sqrt(u * u + v * v + w * w), self._h + self._left - now
        if self._homes is None:
            self._homes = np.vstack((self.pos.T, self.reach))
        homes = self._homes
        homes[0, n], homes[1, n], homes[2, n] = x, y, z
        homes[3, n] = arc.radius + rest * (speed + rest * self._world.gravity) + _SKIN
        own = arc.radius + (end - now) * speed
        away = homes - np.array(((x,), (y,), (z,), (-own,)))
        away *= away
        found: list[int] = (away[0] + away[1] + away[2] < away[3]).nonzero()[0].tolist()
        found.remove(n)
        return found


def swept_pairs(pos: FloatArray, reach: FloatArray, moves: BoolArray) -> tuple[IntArray, IntArray]:
    """Pairs of places (n, 3) nearer to each other than the sum of both reaches (n,) [m], each once.

    Places are sorted into lines as wide as two reaches, and along these by x.

    Args:
        pos: [m], shape (n, 3).
        reach: [m], shape (n,).
        moves: Pairs of which neither does are left out, shape (n,).

    >>> places = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.3, 0.0, 0.0]])
    >>> i, j = swept_pairs(places, np.array([0.2, 0.2, 0.2]), np.array([True, False, False]))
    >>> i.tolist(), j.tolist()
    ([0], [2])
    """
    movers, most, x = moves.nonzero()[0], float(reach.max(initial=0.0)), pos[:, 0]
    side = 2.0 * most + _SKIN
    length = float(np.ptp(x)) + 2.0 * side if len(x) else side
    key = np.floor(pos[:, 1] / side) * length + x
    order = key.argsort(kind="stable")
    ranked, own = key[order], reach[movers] + most
    middle = key[movers] + np.array([[-length], [0.0], [length]])  # on the line before, its own, and the next
    low = ranked.searchsorted(middle - own).ravel()
    count = ranked.searchsorted(middle + own).ravel() - low
    i = np.tile(movers, 3).repeat(count)
    j = order[np.arange(len(i)) + (low - count.cumsum() + count).repeat(count)]
    away, room = pos[i] - pos[j], reach[i] + reach[j]
    near = (np.einsum("ij,ij->i", away, away) < room * room) & ((i < j) | ~moves[j]) & (i != j)
    i, j = i[near], j[near]
    return np.minimum(i, j), np.maximum(i, j)
