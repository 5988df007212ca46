"""Pieces that are wedged in where they were staged, and come free when something pulls or pushes hard enough.

A lodged piece sleeps. While it is awake it is held before each sub-step. What others pushed and pulled it with in the
last one is known from the velocity that they gave it: m v / h. The hold pushes back with as much, so that it carries
what lies on it, and leads the piece back to its place. It comes free for good when this and its weight are more than it
is lodged with, or when a robot takes it.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.rotation import Vector
from simcore.physics.world import PhysicsWorld
from simcore.pieces.pool import PiecePool, PieceStatus
from simcore.typing import IntArray

__all__ = ["Lodging"]

_AWAKE = int(PieceStatus.AWAKE)
_RETURN = 0.2  # share of the way back to its place that a piece goes in a sub-step


class Lodging:
    """Holds lodged pieces.

    Args:
        world: Where the bodies live.
        pool: The pieces.
    """

    def __init__(self, world: PhysicsWorld, pool: PiecePool) -> None:
        self._world = world
        self._pool = pool
        n = len(pool.rows)
        self._force = np.zeros(n)  # 0: not lodged
        self._places: dict[int, Vector] = {}
        # of those held in the last sub-step: velocity at its start [m/s], and what held it against the pull [m/s^2]
        self._given: dict[int, tuple[Vector, Vector]] = {}
        self._h = 0.0  # of the last sub-step
        self._mass = pool.mass
        self.is_used = False
        """Whether any piece is lodged."""
        self._seen: IntArray | None = None  # slots that were awake, and those of them that are lodged
        self._lodged: IntArray = np.zeros(0, dtype=np.int64)

    def lodge(self, slot: int, force: float) -> None:
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
            self._seen, self._lodged = awake, awake[self._force[awake] > 0.0]
        slots = self._lodged
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
