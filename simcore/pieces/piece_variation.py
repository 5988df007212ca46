"""By how much single pieces differ from what is said of their kind."""

from __future__ import annotations

from dataclasses import dataclass

from simcore.typing import FloatArray

__all__ = ["PieceVariation"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PieceVariation:
    """Factors of single pieces, one per slot of the pool, shape (n,).

    Mass and restitution are those of the bodies in the engine, too. The diameter changes what the air and a shooter's
    wheels do to a piece, and its spin; as a body it keeps the size of its kind: half of 1 % of a diameter of 15 cm is
    less than the 3 mm within which contacts are looked for.
    """

    mass: FloatArray
    diameter: FloatArray
    restitution: FloatArray
    drag: FloatArray
    """Of the drag coefficient."""
