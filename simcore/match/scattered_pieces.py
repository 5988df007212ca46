"""What scatter makes of game pieces."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from simcore.match.scatter import ScatterDraws
from simcore.pieces.piece_variation import PieceVariation
from simcore.typing import FloatArray

__all__ = ["piece_variation"]


def piece_variation(draws: ScatterDraws, counts: Sequence[int]) -> PieceVariation:
    """Factors of all pieces of a match.

    Args:
        draws: Of the match.
        counts: How many there are of each kind, in the order of the pool.
    """
    return PieceVariation(
        mass=_each("piece_mass", draws, counts, _even),
        diameter=_each("piece_diameter", draws, counts, _even),
        restitution=_each("restitution", draws, counts, _normal),
        drag=_each("drag", draws, counts, _normal),
    )


def _each(
    name: str,
    draws: ScatterDraws,
    counts: Sequence[int],
    factors: Callable[[np.random.Generator, float, int], FloatArray],
) -> FloatArray:
    size: float = getattr(draws.scatter, name)
    rows = [factors(draws.generator(name, kind), size, count) for kind, count in enumerate(counts)]
    return np.concatenate([np.ones(0), *rows])


def _even(rng: np.random.Generator, size: float, count: int) -> FloatArray:
    return 1.0 + rng.uniform(-size, size, count)


def _normal(rng: np.random.Generator, size: float, count: int) -> FloatArray:
    return np.exp(size * rng.standard_normal(count))
