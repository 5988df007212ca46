"""Type aliases shared by several packages: arrays, suppliers and literals."""

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
"""Supplier of one number, called once per tick."""


def alliance_in(name: str) -> Alliance | None:
    """Return `blue` or `red` if this color is the first word of a name, regardless of case; None for any other name.

    >>> alliance_in("blue_tower"), alliance_in("RedShelf"), alliance_in("bluebird")
    ('blue', 'red', None)
    """
    for alliance in _ALLIANCES:
        if name[: len(alliance)].lower() == alliance and not name[len(alliance) :][:1].islower():
            return alliance
    return None
