"""Which places are near elements of the field, by bounding boxes: they never move, so the engine need not be asked."""

from __future__ import annotations

import numpy as np

from simcore.geometry.rotation import Quaternion, Vector, matrix
from simcore.physics.shapes import Shape, bounding_box
from simcore.typing import BoolArray, FloatArray

__all__ = ["StaticBoxes"]


class StaticBoxes:
    """Bounding boxes of elements of the field, field frame."""

    def __init__(self) -> None:
        self._boxes: list[tuple[FloatArray, FloatArray]] = []
        self._corners: tuple[FloatArray, FloatArray] | None = None

    def add(self, shape: Shape, pos: Vector, quat: Quaternion) -> None:
        """Add a static whose origin is at a place [m], with its attitude."""
        low, high = bounding_box(shape)
        if quat != (0.0, 0.0, 0.0, 1.0):
            axes = matrix(quat)
            if not (np.isfinite(low).all() and np.isfinite(high).all()):
                low, high = np.full(3, -np.inf), np.full(3, np.inf)
            else:
                middle, half = axes @ (0.5 * (low + high)), np.abs(axes) @ (0.5 * (high - low))
                low, high = middle - half, middle + half
        self._boxes.append((low + pos, high + pos))
        self._corners = None

    def are_near(self, pos: FloatArray, reach: FloatArray) -> BoolArray:
        """Whether one of the boxes is within reach of each place, shape (n,).

        Args:
            pos: Places [m], shape (n, 3).
            reach: Of each [m], shape (n,).
        """
        if not self._boxes or not len(pos):
            return np.zeros(len(pos), dtype=bool)
        if self._corners is None:
            low, high = (np.array(corners) for corners in zip(*self._boxes, strict=True))
            self._corners = low.T[:, None, :].copy(), high.T[:, None, :].copy()
        distance2 = np.zeros((len(pos), len(self._boxes)))
        for axis, (low, high) in enumerate(zip(*self._corners, strict=True)):
            x = pos[:, axis, None]
            away = np.maximum(np.maximum(low - x, x - high), 0.0)
            distance2 += away * away
        near: BoolArray = np.any(distance2 < np.square(reach)[:, None], axis=1)
        return near
