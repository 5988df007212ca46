"""What a camera may find on the field besides tags, and what can stand in its way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from simcore.geometry.quaternion import Quaternion, Vector
from simcore.typing import BoolArray, FloatArray

__all__ = ["Scene", "SightLines", "hidden_by_spheres"]

_CARPET = 1.2  # radii; a ball whose center is higher does not lie on the carpet
_NOTHING: FloatArray = np.zeros((0, 3))


class SightLines(Protocol):
    """Rays against the field and its robots."""

    def blocked(self, robot: int, start: Vector, ends: Sequence[Sequence[float]]) -> list[bool]:
        """Which of the straight lines from `start` to `ends` meet the field or another robot.

        Args:
            robot: The one that carries the camera; its own body is transparent.
            start: The camera, field frame [m].
            ends: What it looks at, field frame [m]: n points.
        """
        ...


@dataclass(slots=True)
class Scene:
    """The field at one moment."""

    robots: Mapping[int, tuple[Vector, Quaternion]] = field(default_factory=dict)
    """True pose of each robot that carries cameras, by its number, field frame."""
    pieces: FloatArray = field(default_factory=lambda: _NOTHING)
    """Centers of all pieces, field frame [m], shape (n, 3)."""
    is_there: BoolArray | None = None
    """Which of them are on the field, to be seen, shape (n,); None: all."""
    piece_radius: float = 0.0
    """Of each [m]."""
    sight: SightLines | None = None
    """None: nothing but pieces is in the way."""
    _high: FloatArray | None = field(default=None, repr=False)

    def above(self, height: float) -> FloatArray:
        """Pieces that may reach above a height [m]: of a field full of fuel on the carpet, seen from above, none."""
        if self._high is None:
            is_high: BoolArray = self.pieces[:, 2] > _CARPET * self.piece_radius
            if self.is_there is not None:
                is_high &= self.is_there
            self._high = self.pieces[is_high]
        if height > (_CARPET + 1.0) * self.piece_radius:
            return self._high
        return self.pieces if self.is_there is None else self.pieces[self.is_there]


def hidden_by_spheres(start: Vector, points: FloatArray, centers: FloatArray, radius: float) -> BoolArray | None:
    """Which lines of sight pass through a ball.

    Args:
        start: The camera [m].
        points: What it looks at [m], shape (n, 3).
        centers: Of the balls [m], shape (m, 3).
        radius: Of each [m].

    Returns:
        Shape (n,); None if there is no ball between their heights.
    """
    # A ball that lies below all lines of sight hides nothing: that is nearly all fuel, and one comparison.
    lowest = min(start[2], float(points[:, 2].min())) - radius
    highest = max(start[2], float(points[:, 2].max())) + radius
    z = centers[:, 2]
    near = centers[(z > lowest) & (z < highest)]
    if not len(near):
        return None
    ray, ball = points - start, near - start
    length2 = np.einsum("ij,ij->i", ray, ray)
    along = (ray @ ball.T) / length2[:, None]  # fraction of the line at which it is nearest to the ball
    at = np.clip(along, 0.0, 1.0)
    gap2 = np.einsum("ij,ij->i", ball, ball)[None, :] - (2.0 * along - at) * at * length2[:, None]
    hidden: BoolArray = (gap2 < radius * radius).any(axis=1)
    return hidden
