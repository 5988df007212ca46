"""Where pieces are put down by hand: on the carpet, inside the field, on nothing and in nothing."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from simcore.physics.world import PhysicsWorld
from simcore.pieces.footprint import Footprint
from simcore.pieces.kinds import GamePieceConfig
from simcore.typing import FloatArray

__all__ = ["free_place"]

_INSIDE = 0.3  # [m], from the edge of the field to the nearest middle of a piece: within an arm's reach over the rail
_SPACING = 0.01  # [m], between pieces that are put down
_MOST_TRIES = 4000


def free_place(
    world: PhysicsWorld,
    kind: GamePieceConfig,
    near: tuple[float, float],
    taken: FloatArray,
    *,
    robots: Sequence[Footprint],
    field_size: tuple[float, float],
) -> tuple[float, float, float]:
    """The free place on the carpet that is nearest to a place.

    Args:
        world: Whose solid elements and ramps are in the way.
        kind: What is put down.
        near: Where, field frame [m]; places outside the field count as the nearest inside.
        taken: Centers of the pieces that lie there already, shape (n, 3), each as large as this one.
        robots: Where robots are.
        field_size: Length and width [m].

    Returns:
        Center of the piece [m]. In a field without any free place, above the middle of the search.
    """
    radius, height = kind.bounding_radius, kind.rest_height
    length, width = field_size
    x = min(max(near[0], _INSIDE), length - _INSIDE)
    y = min(max(near[1], _INSIDE), width - _INSIDE)
    apart = 2.0 * radius + _SPACING
    for dx, dy in _spiral(apart):
        place = np.array((x + dx, y + dy, height))
        if not (_INSIDE <= place[0] <= length - _INSIDE and _INSIDE <= place[1] <= width - _INSIDE):
            continue
        if len(taken) and (((taken - place) ** 2).sum(axis=1) < apart * apart).any():
            continue
        if any(robot.gap(place[None])[0] < radius for robot in robots):
            continue
        reach = np.array((radius, radius, height - 0.01))
        if world.is_free((place - reach).tolist(), (place + reach).tolist()):
            return float(place[0]), float(place[1]), height
    return x, y, height + 1.0


def _spiral(spacing: float) -> Iterator[tuple[float, float]]:
    """Offsets [m] around the middle, nearest first: rings `spacing` apart with places `spacing` apart."""
    yield 0.0, 0.0
    tries, ring = 1, 1
    while tries < _MOST_TRIES:
        count = math.floor(2.0 * math.pi * ring)
        for number in range(count):
            angle = 2.0 * math.pi * number / count
            yield ring * spacing * math.cos(angle), ring * spacing * math.sin(angle)
        tries += count
        ring += 1
