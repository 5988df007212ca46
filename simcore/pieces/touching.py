"""Which pieces touch: along such a chain a push, a knock or a load is passed on."""

from __future__ import annotations

import numpy as np

from simcore.typing import BoolArray, FloatArray

__all__ = ["TOUCH", "distances2", "touching_chain"]

TOUCH = 0.005
"""Pieces and bumpers this near count as touching [m]."""


def distances2(a: FloatArray, b: FloatArray) -> FloatArray:
    """Squares of the distances of places (n, k) to others (m, k) [m^2], shape (n, m); axis by axis, twice as fast."""
    squares: FloatArray = np.subtract.outer(a[:, 0], b[:, 0])
    squares *= squares
    for axis in range(1, a.shape[1]):
        way = np.subtract.outer(a[:, axis], b[:, axis])
        way *= way
        squares += way
    return squares


def touching_chain(pos: FloatArray, radius: FloatArray, first: BoolArray, most_links: int | None = None) -> BoolArray:
    """Which of some pieces touch one of the first, or one that does, and so on; the first are among them, shape (n,).

    Args:
        pos: Centers [m], shape (n, 3).
        radius: Of the pieces [m], shape (n,).
        first: Where chains begin, shape (n,).
        most_links: Longest chain; None: any.
    """
    found = front = first
    links = 0
    while front.any() and links != most_links:
        left = np.nonzero(~found)[0]
        away2 = distances2(pos[left], pos[front])
        reach = np.add.outer(radius[left], radius[front] + TOUCH)
        front = np.zeros(len(first), dtype=bool)
        front[left] = (away2 < reach * reach).any(axis=1)
        found = found | front
        links += 1
    return found
