"""Names for the arrays, suppliers and words that packages hand each other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["Alliance", "BoolArray", "BoolSupplier", "FloatArray", "FloatSupplier", "IntArray"]

Alliance: TypeAlias = Literal["blue", "red"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int64]
BoolArray: TypeAlias = npt.NDArray[np.bool_]

FloatSupplier: TypeAlias = Callable[[], float]
"""Called once a tick for one number."""
BoolSupplier: TypeAlias = Callable[[], bool]
"""Called once a tick for one fact."""
