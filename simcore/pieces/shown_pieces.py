"""What pieces on the field look like from outside; nothing is made anew while none of them moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from simcore.pieces.pool import PiecePool
from simcore.typing import FloatArray, IntArray

__all__ = ["ShownPieces"]


class ShownPieces:
    """Slots and poses by kind: the same read-only arrays until the pool says that something has changed.

    Args:
        pool: The pieces.
        attitudes: Of slots, as w, x, y, z, shape (n, 4).
    """

    def __init__(self, pool: PiecePool, attitudes: Callable[[IntArray], FloatArray]) -> None:
        self._pool = pool
        self._attitudes = attitudes
        self._changes = -1
        self._kept: dict[int, tuple[IntArray, FloatArray]] = {}

    def of(self, kind: int) -> tuple[IntArray, FloatArray]:
        """Slots of a kind on the field or in the air, rising, shape (n,), and their rows x, y, z, qw, qx, qy, qz.

        Args:
            kind: Its number.
        """
        pool = self._pool
        if pool.changes != self._changes:
            self._changes = pool.changes
            self._kept.clear()
        if kind not in self._kept:
            slots = np.array((pool.is_on_field & (pool.state.kind == kind)).nonzero()[0])
            rows = np.empty((len(slots), 7))
            rows[:, :3] = pool.state.pos[slots]
            rows[:, 3:] = self._attitudes(slots)
            slots.setflags(write=False)
            rows.setflags(write=False)
            self._kept[kind] = slots, rows
        return self._kept[kind]
