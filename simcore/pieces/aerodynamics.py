"""Aerodynamics of flying game pieces: quadratic drag and spin lift, as factors for `simcore.loop.contact`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from simcore.quantities import FACTOR, MASS, POSITIVE, ROBOT_LENGTH, Quantity, require, require_fields
from simcore.typing import FloatArray

__all__ = [
    "Aerodynamics",
    "AirFactors",
    "air_factors",
    "drag_acceleration",
]


_SPIN_TORQUE = 0.044
"""Torque coefficient of a sphere spinning in still air, torque / (rho omega^2 r^5 / 2) [-].

The value is 6.45 / sqrt(Re) + 32.1 / Re at 60 rad/s and r = 0.075 m (O. Sawatzki, Acta Mechanica 9, 159, 1970). The
spin of a ball then decreases by 1 % per second.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Aerodynamics:
    """Aerodynamic coefficients of a piece, and air density.

    The lift coefficient increases with the spin ratio S = r omega / v (omega perpendicular to the velocity) and
    saturates: Cl = slope S / (1 + slope S / limit).

    Lift is off by default, because no values are published for smooth foam balls. Even the sign is unknown: a smooth
    ball may curve in the opposite direction (reverse Magnus effect). Teams with measurements can set `lift_slope`. An
    example shows the possible error. With a slope of 1 (Cl 0.32 at a spin ratio of 1), a ball of 0.15 m and 0.215 kg
    that rolls off a hood at 10.5 m/s lands 8 % shorter at 68 degrees (0.48 m of 6 m), and 6 % farther at 45 degrees.

    Source: A baseball has slope 1.92 and limit 0.48, from Cl = 1.120 S / (0.583 + 2.333 S) in A. Nathan's trajectory
    calculator (as printed at coryfront.in/sports/alans-physical-model). Cl depends on S and hardly on the speed:
    Nathan, Am. J. Phys. 76, 119 (2008).
    """

    drag_coefficient: float = 0.47
    """Drag coefficient [-]; the default is for a smooth sphere at 5-15 m/s. Foam balls may have 0.40-0.55."""
    lift_slope: float = 0.0
    """Lift coefficient divided by spin ratio, in the limit of slow spin [-]; 0 for no lift."""
    lift_limit: float = 0.48
    """Lift coefficient in the limit of fast spin [-]."""
    air_density: float = 1.2
    """Air density [kg/m^3]; the default is for 20 degrees Celsius at sea level."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            drag_coefficient=FACTOR,
            lift_slope=FACTOR,
            lift_limit=POSITIVE,
            air_density=Quantity("kg/m^3", 0.0, 100.0),
        )


class AirFactors(NamedTuple):
    """Factors for the aerodynamic accelerations of one piece, or of n pieces with arrays of shape (n,)."""

    drag: float | FloatArray = 0.0
    """Drag factor k = rho Cd A / (2 m), deceleration divided by speed squared [1/m]."""
    lift: float | FloatArray = 0.0
    """Lift factor rho A r slope / (2 m), acceleration divided by omega x v at slow spin [-]."""
    lift_saturation: float | FloatArray = 0.0
    """Saturation length of the lift, r slope / limit [m]."""
    spin_drag: float | FloatArray = 0.0
    """Spin drag factor, angular deceleration divided by angular velocity squared [-]."""


def air_factors(aerodynamics: Aerodynamics, *, radius: float, mass: float) -> AirFactors:
    """Compute the aerodynamic factors of a ball.

    Args:
        aerodynamics: Aerodynamic coefficients and air density.
        radius: Radius r [m]; the frontal area is A = pi r^2.
        mass: Mass [kg].

    Raises:
        ConfigError: If the radius or the mass is not above zero.

    >>> round(air_factors(Aerodynamics(), radius=0.075, mass=0.215).drag, 4)
    0.0232
    """
    require("air_factors", "radius", radius, ROBOT_LENGTH)
    require("air_factors", "mass", mass, MASS)
    per_coefficient = 0.5 * aerodynamics.air_density * math.pi * radius * radius / mass  # [1/m]
    return AirFactors(
        drag=per_coefficient * aerodynamics.drag_coefficient,
        lift=per_coefficient * aerodynamics.lift_slope * radius,
        lift_saturation=aerodynamics.lift_slope * radius / aerodynamics.lift_limit,
        spin_drag=1.25 * _SPIN_TORQUE * aerodynamics.air_density * radius**3 / mass,
    )


def drag_acceleration(velocity: FloatArray, drag: float | FloatArray) -> FloatArray:
    """Compute the acceleration from quadratic drag, a = -k |v| v [m/s^2], shape (n, 3).

    Args:
        velocity: Velocities relative to the air [m/s], shape (n, 3).
        drag: Drag factor k [1/m], one value for all pieces, or one per piece, shape (n,).
    """
    result: FloatArray = velocity * (-drag * _lengths(velocity))[:, None]
    return result


def _lengths(rows: FloatArray) -> FloatArray:
    """Return the lengths of vectors (n, 3), shape (n,)."""
    norm: FloatArray = np.sqrt(np.einsum("ij,ij->i", rows, rows))
    return norm
