"""Pieces that are no balls come to what they meet, not into it.

The engines find a contact at the start of the step after it, when something thin is already deep in a floor or through
a wall. Balls have `impact_events`; another shape flies until it may touch something. If it would then get into that in
the coming sub-step, it goes only as far as it, and has its velocity again when the step is over: then the engine plays
the impact, from the outside.
The piece is late by a part of a sub-step, which is all that it costs.

Engines find one place of contact at a time for anything but balls and boxes, so that a tube which lands flat turns
about one edge until the next step finds the other. Steps are short while such pieces move.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from simcore.geometry.rotation import matrix
from simcore.physics.shapes import Box, Compound, Shape, Sphere, outline_points, parts_of
from simcore.physics.world import PhysicsWorld
from simcore.pieces.pool import PiecePool
from simcore.pieces.reach import lengths
from simcore.typing import FloatArray, IntArray

__all__ = ["Approach"]

_STEP = 0.004  # [s], longest; a tube that rolls is 8 to 14 % late by then, 35 % with 20 ms
_SUNK = 0.004  # [m]; what is deeper in the floor is put back on it
_PLAIN = 0.005, 0.00125  # [m, s], move and shortest step: a disc that falls flat from 1.3 m sinks by 3 mm (5 ms: 33 mm)
_PARTS = 0.02, 0.0025  # the same of what has more than one part, so more places of contact


class Approach:
    """Shortens the last step before an impact.

    Args:
        world: Where the bodies live.
        pool: The pieces.
    """

    def __init__(self, world: PhysicsWorld, pool: PiecePool) -> None:
        self._world = world
        self._pool = pool
        self._is_fine = np.array([_needs_fine_steps(kind.shape) for kind in pool.types], dtype=bool)[pool.state.kind]
        limits = [_PARTS if isinstance(kind.shape, Compound) else _PLAIN for kind in pool.types]
        self._move, self._shortest = np.array(limits).reshape(-1, 2)[pool.state.kind].T
        self._corners = [
            outline_points(kind.shape) if _needs_fine_steps(kind.shape) else np.zeros((0, 3)) for kind in pool.types
        ]
        self.has_fine = bool(self._is_fine.any())
        """Whether there are pieces that need short steps while they move."""
        self._others = {row for row, ball in zip(pool.rows, pool.is_ball.tolist(), strict=True) if not ball}
        self.is_needed = bool(self._others)
        """Whether there are pieces that are no balls."""
        self._held_back: list[tuple[int, FloatArray]] = []

    def longest_step(self, awake: IntArray) -> float:
        """Put back on the floor what was pressed into it; the longest step that the awake slots allow [s]."""
        world, slots = self._world, awake[self._is_fine[awake]]
        if not len(slots):
            return math.inf
        twist = world.engine.velocities(self._pool.rows_of(slots))
        rim = lengths(twist[:, :3])
        rim += self._pool.radius[slots] * lengths(twist[:, 3:])
        if world.floor is not None:
            self._lift(slots)
        each = np.maximum(self._shortest[slots], self._move[slots] / np.maximum(rim, 1e-6))
        return min(_STEP, float(each.min()))

    def _lift(self, slots: IntArray) -> None:
        """Put pieces that were pressed into the floor back on it: PyBullet finds no contact of what is all inside."""
        state, engine = self._pool.state, self._world.engine
        for slot in slots[state.pos[slots, 2] < self._pool.radius[slots]].tolist():
            row = self._pool.rows[slot]
            (x, y, z), quat = engine.pose(row)
            depth = -z - float((self._corners[int(state.kind[slot])] @ matrix(quat)[2]).min(initial=math.inf))
            if depth > _SUNK:
                (vx, vy, vz), spin = engine.velocity(row)
                engine.set_pose(row, (x, y, z + depth), quat)
                engine.set_velocity(row, (vx, vy, max(vz, 0.0)), spin)
                state.pos[slot, 2] += depth

    def finish(self) -> None:
        """Give the pieces that were held back in the last sub-step the velocity that was taken from them."""
        engine = self._world.engine
        for row, lost in self._held_back:
            engine.set_velocities([row], engine.velocities([row]) + lost)
        self._held_back.clear()

    def begin_step(self, h: float, rows: Sequence[int]) -> None:
        """Hold back the pieces that would get into something.

        Args:
            h: Length of the sub-step to come [s].
            rows: Engine rows of the pieces that can move.
        """
        engine, fall = self._world.engine, self._world.gravity * h
        for row in rows:
            if row in self._others:
                share = engine.free_share(row, h)
                if share < 1.0:
                    lost = (1.0 - share) * engine.velocities([row])
                    lost[0, 2] -= (1.0 - share) * fall  # what gravity adds in this step, as well
                    engine.set_velocities([row], engine.velocities([row]) - lost)
                    self._held_back.append((row, lost))


def _needs_fine_steps(shape: Shape) -> bool:
    return not all(isinstance(part.shape, Sphere | Box) for part in parts_of(shape))
