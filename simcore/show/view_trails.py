"""The lines behind flying pieces: where each was in the last moments."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from simcore.typing import FloatArray

__all__ = ["Trails"]

_KEEP = 1.5  # [s] for which a piece of the line stays
_GAP = 0.5  # [s]; after a longer time without news all begins anew


class Trails:
    """Follows pieces by their ids.

    >>> trails = Trails()
    >>> for i in range(4):
    ...     trails.update(0.02 * i, [7, 9], np.array([[0.2 * i, 0.0, 1.0], [0.2 * i, 0.16, 1.0]]))
    >>> trails.segments().shape
    (6, 2, 3)
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all, e.g. after a jump in time."""
        self._last: dict[int, FloatArray] = {}
        self._lines: list[tuple[float, FloatArray]] = []
        self._time = -np.inf

    def update(self, time: float, ids: Sequence[int], points: FloatArray) -> None:
        """Note where the pieces that fly are now.

        Args:
            time: [s].
            ids: Which pieces.
            points: Where each is [m], shape (n, 3).
        """
        if not self._time <= time <= self._time + _GAP:
            self.clear()
        if time > self._time:
            before, self._last, self._time = self._last, dict(zip(ids, points, strict=False)), time
            new = [(before[piece], point) for piece, point in self._last.items() if piece in before]
            if new:
                self._lines.append((time, np.array(new)))
        self._lines = [line for line in self._lines if time - line[0] < _KEEP]

    def segments(self) -> FloatArray:
        """Pieces of line [m], shape (m, 2, 3)."""
        return np.concatenate([lines for _, lines in self._lines]) if self._lines else np.zeros((0, 2, 3))
