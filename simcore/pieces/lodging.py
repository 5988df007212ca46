"""Pieces that are wedged in where they were staged, and come free when something pulls or pushes hard enough.

A lodged piece sleeps. While it is awake it is put back before each sub-step. What others pushed and pulled it with in
the last one is known from the velocity that they gave it: m v / h. It comes free for good when this and its weight
are more than it is lodged with, when something is deep in it, or when a robot takes it.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.rotation import Quaternion, Vector
from simcore.physics.world import PhysicsWorld
from simcore.pieces.pool import PiecePool, PieceStatus
from simcore.typing import IntArray

__all__ = ["Lodging"]

_DEEP = 0.02  # [m]; what a thing that moves slowly pushes into a piece that does not give way


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
        self._anchors: dict[int, tuple[Vector, Quaternion]] = {}
        self._h = 0.0  # of the last sub-step
        self._mass = pool.mass
        self.is_used = False
        """Whether any piece is lodged."""

    def lodge(self, slot: int, force: float) -> None:
        """Wedge a piece in where it is; it comes free at a force [N]."""
        self._force[slot] = force
        self._anchors[slot] = self._world.engine.pose(self._pool.rows[slot])
        self.is_used = True

    def free(self, slots: IntArray) -> None:
        """Let pieces come free."""
        self._force[slots] = 0.0
        self.is_used = bool(self._force.any())

    def hold(self, h: float, awake: IntArray) -> None:
        """Hold the awake ones for the next sub-step of h [s], or let them come free."""
        slots = awake[(self._force[awake] > 0.0) & (self._pool.state.status[awake] == PieceStatus.AWAKE)]
        if not len(slots):
            return
        engine = self._world.engine
        before, self._h = self._h or h, h
        for slot in slots.tolist():
            row, mass = self._pool.rows[slot], self._mass[slot]
            (x, y, z), _ = engine.velocity(row)
            weight = mass * self._world.gravity
            force = math.hypot(mass * x / before, mass * y / before, mass * z / before - weight)
            if force > self._force[slot] or engine.overlap(row) > _DEEP:
                self.free(np.array([slot]))
            else:
                engine.set_pose(row, *self._anchors[slot])
                engine.apply_forces([row], np.array([[0.0, 0.0, weight]]))
