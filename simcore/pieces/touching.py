"""Which pieces touch: along such a chain a push, a knock or a load is passed on."""

from __future__ import annotations

import numpy as np

from simcore.typing import BoolArray, FloatArray

__all__ = ["TOUCH", "touching_chain"]

TOUCH = 0.005
"""Pieces and bumpers this near count as touching [m]."""


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
        away = pos[left][:, None, :] - pos[front][None, :, :]
        reach = radius[left][:, None] + radius[front][None, :] + TOUCH
        front = np.zeros(len(first), dtype=bool)
        front[left] = (np.einsum("ijk,ijk->ij", away, away) < reach * reach).any(axis=1)
        found = found | front
        links += 1
    return found
