"""Names for the arrays, suppliers and words that packages hand each other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["Alliance", "BoolArray", "FloatArray", "FloatSupplier", "IntArray", "alliance_in"]

Alliance: TypeAlias = Literal["blue", "red"]
_ALLIANCES: tuple[Alliance, ...] = ("blue", "red")

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int64]
BoolArray: TypeAlias = npt.NDArray[np.bool_]

FloatSupplier: TypeAlias = Callable[[], float]
"""Called once a tick for one number."""


def alliance_in(name: str) -> Alliance | None:
    """`blue` or `red`, if that is the first word of a name of something; otherwise None.

    >>> alliance_in("blue_tower"), alliance_in("RedShelf"), alliance_in("bluebird")
    ('blue', 'red', None)
    """
    for alliance in _ALLIANCES:
        if name[: len(alliance)].lower() == alliance and not name[len(alliance) :][:1].islower():
            return alliance
    return None
