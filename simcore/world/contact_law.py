"""Surfaces of bodies, and the contact springs and dampers that the engines use for a pair of surfaces.

- **Pairs.** The friction and the restitution of a pair are the products of the two surfaces' factors. The rolling
resistance torque is `(rolling_a * friction_b + rolling_b * friction_a) * normal_force`. No table of pairs is needed.
- **Load.** A contact is a spring and a damper: f = k x - c v. The depths of two soft surfaces add.

`simcore.loop.contact` contains the contact law of balls.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from simcore.quantities import (
    FRACTION,
    FRICTION,
    ROBOT_HEIGHT,
    STIFFNESS,
    Quantity,
    require_fields,
)
from simcore.typing import FloatArray

__all__ = [
    "BUMPER",
    "BUMPER_CLOTH",
    "CARPET",
    "FOAM",
    "FOAM_STIFFNESS",
    "FRICTIONLESS",
    "OVERLAP_TIME",
    "POLYCARBONATE",
    "RUBBER",
    "WALL",
    "FoamStiffness",
    "TerrainSurface",
    "contact_damping",
    "contact_spring",
    "pair_friction",
    "pair_restitution",
    "pair_rolling",
]

_Value = TypeVar("_Value", float, FloatArray)

# --- springs, dampers and overlaps ----------------------------------------------------------------------------------

_DAMPING_RATIO = 8.0
"""Damping ratio of contacts on PyBullet [-]; with this ratio a compressed contact recovers slowly, so a body that hits
a surface bounces only once."""
OVERLAP_TIME = 0.5
"""Time constant of the correction of overlaps on PyBullet [s]; a faster correction would increase the bounce."""
_STRONGEST = (1.0, 0.2)
"""Largest c h / m of a contact on MuJoCo [-]: for contacts without friction and restitution, and for all others.

h is the step. MuJoCo makes the friction cone convex. A body that starts to slide at a speed v therefore jumps up at a
speed of up to mu v c h / m. At 2 m/s a tube on carpet jumps by 1 mm.
"""
_LEAST_RATIO = 0.5  # damping ratio for the limit on springs: half a period with friction takes 15 steps or more
# --- materials ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class TerrainSurface:
    """Contact properties of a body's surface. Make variants with `dataclasses.replace`."""

    name: str
    friction: float
    """Friction factor [-]; the coefficient of friction of a pair is the product of the two factors."""
    restitution: float
    """Restitution factor, 0 to 1 [-]; the coefficient of restitution of a pair is the product of the two factors."""
    rolling: float = 0.0
    """Rolling resistance lever arm [m]; a ball of radius r and friction factor f decelerates at
    rolling * f * g / (1.4 r)."""
    stiffness: float | None = None
    """Stiffness under load [N/m]; None for a rigid surface. The two surfaces of a pair act as springs in series."""

    def __post_init__(self) -> None:
        require_fields(
            self, self.name, friction=FRICTION, restitution=FRACTION, rolling=ROBOT_HEIGHT, stiffness=STIFFNESS
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class FoamStiffness:
    """Stiffness of foam on one side of a ball: force F = linear d + cubic d^3 at depth d."""

    linear: float
    """Stiffness at small depths [N/m]."""
    cubic: float
    """Coefficient of the cubic term [N/m^3]."""

    def __post_init__(self) -> None:
        require_fields(self, "FoamStiffness", linear=STIFFNESS, cubic=Quantity("N/m^3", 0.0, 1e12))


# Estimates, +-30 %: no measurements of FRC field materials against foam balls are published. With a foam ball
# (friction 0.8, restitution 0.55) the pairs have mu / e: carpet 0.8 / 0.28, wall 0.4 / 0.44, bumper 0.96 / 0.25,
# polycarbonate 0.24 / 0.5; a ball rolling on carpet decelerates by 0.45 m/s^2.
CARPET = TerrainSurface(name="CARPET", friction=1.0, restitution=0.5, rolling=0.006)
WALL = TerrainSurface(name="WALL", friction=0.5, restitution=0.8, rolling=0.001)
RUBBER = TerrainSurface(name="RUBBER", friction=1.2, restitution=0.45, rolling=0.005)
POLYCARBONATE = TerrainSurface(name="POLYCARBONATE", friction=0.3, restitution=0.9, rolling=0.0005)
FRICTIONLESS = TerrainSurface(name="FRICTIONLESS", friction=0.0, restitution=0.0)

BUMPER = replace(RUBBER, name="BUMPER", restitution=0.25)
"""Surface of a bumper (noodles under fabric) against game pieces; the coefficient of restitution of two bumpers is
0.06."""
BUMPER_CLOTH = 0.7
"""Friction factor of bumper cloth against walls and robots [-].

The coefficient of friction is 0.49 between two bumpers and 0.35 between a bumper and a wall.

Source: team 971 measured 0.5 for Cordura on Cordura, 0.3 for ballistic nylon on Cordura and 0.25 for sailcloth on
Cordura (Chief Delphi, "Bumper Material", post 1381897, 2014). No measurement of cloth on polycarbonate is published.
The value is an estimate, +-30 %.
"""
FOAM_STIFFNESS = 1e5
"""Stiffness of dense foam [N/m]: a force of 600 N compresses a game piece at a wall by 6 mm on each side.

The value is an estimate, within a factor of 3.
"""
FOAM = TerrainSurface(name="FOAM", friction=0.8, restitution=0.5, stiffness=FOAM_STIFFNESS)
"""Surface of a foam piece, the default for game pieces."""

# --- pairs ----------------------------------------------------------------------------------------------------------


def pair_friction(a: _Value, b: _Value) -> _Value:
    """Compute the coefficient of friction of a pair from the friction factors [-], or of n pairs, shape (n,)."""
    return a * b


def pair_restitution(a: _Value, b: _Value) -> _Value:
    """Compute the coefficient of restitution of a pair from the restitution factors [-], or of n pairs, shape (n,)."""
    return a * b


def pair_rolling(rolling_a: _Value, friction_a: _Value, rolling_b: _Value, friction_b: _Value) -> _Value:
    """Compute the rolling resistance lever arm of a pair [m], or of n pairs, shape (n,)."""
    return rolling_a * friction_b + rolling_b * friction_a


def contact_damping(stiffness: float, mass: float) -> float:
    """Compute the contact damping of a body on PyBullet [N s/m] from stiffness [N/m] and mass [kg]."""
    return 2.0 * _DAMPING_RATIO * math.sqrt(stiffness * mass)


def contact_spring(restitution: float, friction: float, stiffness: float, mass: float, h: float) -> tuple[float, float]:
    """Compute spring and damper of a contact on MuJoCo, divided by the mass: k / m [1/s^2] and c / m [1/s].

    Args:
        restitution: Coefficient of restitution of the pair [-]; values below 0.13 act as 0.13.
        friction: Coefficient of friction of the pair [-].
        stiffness: Stiffness of the pair, infinite for a rigid pair [N/m]; the function limits the stiffness to a value
            that is stable in steps of h.
        mass: Mass of the lighter body [kg].
        h: Longest step of the contact [s].
    """
    from simcore.loop.bumpers import DAMPING_RATIOS  # imported here, so that importing a surface needs no Numba

    places = np.linspace(0.0, 1.0, len(DAMPING_RATIOS))
    ratio = min(1.0, float(np.interp(restitution, places, DAMPING_RATIOS)))
    strongest = _STRONGEST[friction + restitution > 0.0] / h
    spring = min(stiffness / mass, (0.5 * strongest / max(ratio, _LEAST_RATIO)) ** 2)
    return spring, 2.0 * ratio * math.sqrt(spring)
