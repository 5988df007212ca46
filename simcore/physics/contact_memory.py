"""What the contacts of a step did, found again in the next step by the pair of shapes that touch.

Friction that holds a heap is a force without motion: a solver that only asks for rest forgets it from step to step, and
what it holds creeps. So the force across each normal is kept, as the extension of a spring would be (Cundall and
Strack, 1979), beside the sliding that a contact had.
"""

from __future__ import annotations

import numpy as np

from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["ContactMemory"]

_MOST_OF_PAIR = 64  # contacts of two shapes


class ContactMemory:
    """Contacts of the last step, those of one pair in the order in which they were found.

    Args:
        shapes: Number of shapes in the world.
    """

    def __init__(self, shapes: int) -> None:
        self._shapes = shapes
        self._keys: IntArray = np.zeros(0, dtype=np.int64)
        self._sliding: FloatArray = np.zeros(0)
        self._friction: FloatArray = np.zeros((0, 3))

    def keep(self, a: IntArray, b: IntArray, pushes: BoolArray, sliding: FloatArray, friction: FloatArray) -> None:
        """Replace what is known by the contacts of a step that push, n of all.

        Args:
            a: First shapes, shape (n,).
            b: Second shapes, shape (n,).
            pushes: Which of them push, shape (n,).
            sliding: Speed that goes with each [m/s], shape (n,).
            friction: Force across each normal, field frame [N], shape (n, 3).
        """
        keys = self._keys_of(a, b)[pushes]
        order = np.argsort(keys)
        self._keys = keys[order]
        self._sliding, self._friction = sliding[pushes][order], friction[pushes][order]

    def recall(self, a: IntArray, b: IntArray) -> tuple[BoolArray, FloatArray, FloatArray]:
        """Which contacts are known, shape (n,), and their sliding and friction; those of others mean nothing."""
        if not len(self._keys):
            n = len(a)
            return np.zeros(n, dtype=bool), np.zeros(n), np.zeros((n, 3))
        keys = self._keys_of(a, b)
        at = np.minimum(np.searchsorted(self._keys, keys), len(self._keys) - 1)
        return self._keys[at] == keys, self._sliding[at], self._friction[at]

    def _keys_of(self, a: IntArray, b: IntArray) -> IntArray:
        """A number of its own for each contact, shape (n,)."""
        pair = a.astype(np.int64) * self._shapes + b
        order = np.argsort(pair, kind="stable")
        ordered = pair[order]
        keys = np.empty_like(pair)
        keys[order] = ordered * _MOST_OF_PAIR + (np.arange(len(pair)) - np.searchsorted(ordered, ordered))
        return keys
