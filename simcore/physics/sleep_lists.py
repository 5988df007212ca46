"""Who sleeps, and the lists of the awake that MuJoCo goes through."""

from __future__ import annotations

from typing import Any

import numpy as np

from simcore.typing import BoolArray, IntArray

__all__ = ["SleepLists"]

_AWAKE = -11  # MuJoCo's value of a tree that is fully awake
_STATIC = -1  # its state of a body of the world


class SleepLists:
    """Sleep of all moving bodies of a model; each is a tree of its own.

    Args:
        data: The `MjData`.
        count: Number of moving bodies.
    """

    def __init__(self, data: Any, count: int) -> None:
        self.asleep: BoolArray = np.zeros(count, dtype=bool)
        """By body; call `mark` after a change."""
        self.fixed: BoolArray = np.zeros(count, dtype=bool)
        """Which of those asleep are part of the world for now, by body; call `mark` after a change."""
        self.awake: IntArray = np.arange(count)
        """Numbers of the bodies that are awake, in rising order."""
        self._d = data
        self._numbers = np.arange(count, dtype=np.int32)
        self._six = np.arange(6, dtype=np.int32)
        self._is_changed = True

    def mark(self) -> None:
        """Say that `asleep` has changed."""
        self._is_changed = True

    def write(self) -> None:
        """Bring the lists up to date, if `asleep` has changed."""
        if not self._is_changed:
            return
        d, asleep, fixed, numbers = self._d, self.asleep, self.asleep & self.fixed, self._numbers
        awake = ~asleep
        self.awake = np.nonzero(awake)[0]
        d.tree_asleep[:] = np.where(asleep & ~fixed, numbers, _AWAKE)
        d.tree_awake[:] = awake
        d.body_awake[1:] = np.where(fixed, _STATIC, awake)  # it refuses contacts with those asleep
        count, n = len(self.awake), len(asleep)
        d.body_awake_ind[0] = 0
        d.body_awake_ind[1 : count + 1] = self.awake + 1
        d.parent_awake_ind[:n] = numbers + 1  # the parent of each is the world
        d.dof_awake_ind[: 6 * count] = (6 * self.awake[:, None] + self._six).ravel()
        d.ntree_awake = count
        d.nbody_awake, d.nparent_awake, d.nv_awake = count + 1, n, 6 * count
        self._is_changed = False

    def keep_awake(self) -> None:
        """Undo MuJoCo's own count of how long each stands still: it would put it to sleep."""
        self._d.tree_asleep[self.awake] = _AWAKE
        self._d.tree_asleep[self.asleep & self.fixed] = _AWAKE
