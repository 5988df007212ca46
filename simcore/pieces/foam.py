"""Foam under load: stiff to a blow, soft to what holds it, and stiffer the more it is squeezed.

A standard linear solid with a spring that stiffens: a contact has the stiffness of a blow at first; while it is held,
its stiffness relaxes to that of the static curve F = static d + stiffening d^3 at the depth d where it is now.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.quantities import DURATION, STIFFNESS, Quantity, require_fields
from simcore.typing import FloatArray

__all__ = ["FoamStiffness", "relax"]

_HELD = 40.0
"""Loads below are not followed [N]: a foam ball would give way by 8 mm instead of 0.4, and heaps be soft."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FoamStiffness:
    """How foam gives way on one side: force over depth."""

    dynamic: float
    """Of a blow [N/m]."""
    static: float
    """Of the first millimeters of a load that stays [N/m]."""
    stiffening: float
    """What is added with the square of the depth [N/m^3]."""
    relaxation: float = 0.075
    """Time in which 63 % of the way from the one to the other is gone [s]."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            "FoamStiffness",
            dynamic=STIFFNESS,
            static=STIFFNESS,
            stiffening=Quantity("N/m^3", 0.0, 1e12),
            relaxation=DURATION,
        )


def relax(foam: FoamStiffness, stiffness: FloatArray, dynamic: FloatArray, depth: FloatArray, dt: float) -> FloatArray:
    """Stiffness of contacts after dt [N/m], shape (n,).

    Args:
        foam: What the pieces are made of.
        stiffness: Before [N/m], shape (n,).
        dynamic: To a blow [N/m], shape (n,).
        depth: How deep each is squeezed [m], shape (n,).
        dt: Time [s].
    """
    curve = np.minimum(foam.static + foam.stiffening * np.square(depth), dynamic)
    goal = np.where(stiffness * depth > _HELD, curve, dynamic)
    share = -math.expm1(-dt / foam.relaxation)
    return np.maximum(stiffness + share * (goal - stiffness), np.where(goal < dynamic, curve, 0.0))
