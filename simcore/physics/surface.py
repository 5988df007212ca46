"""What things are made of: the friction, bounce and rolling resistance of a touching pair.

A pair's friction and restitution are the products of both sides' values. A rolling pair resists with the torque
`(rolling_a * friction_b + rolling_b * friction_a) * normal_force`. These rules are Bullet's own, so a surface acts on
every pair that touches it, and nothing is hidden in a table of pairs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.quantities import FRACTION, FRICTION, ROBOT_HEIGHT, STIFFNESS, require_fields

__all__ = ["CARPET", "FRICTIONLESS", "POLYCARBONATE", "PRESETS", "RUBBER", "WALL", "TerrainSurface", "contact_damping"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TerrainSurface:
    """The contact material of one body. Make variants with `dataclasses.replace`."""

    name: str
    friction: float
    """Coulomb friction coefficient factor [-]."""
    restitution: float
    """Bounce factor, speed out over speed in of a pair is the product of both [-], 0 to 1."""
    rolling: float = 0.0
    """Rolling resistance lever arm [m]: a ball of radius r, friction f decelerates by rolling * f * g / (1.4 r)."""
    stiffness: float | None = None
    """Of a contact that is held, force over depth [N/m]; None: rigid. A pair gives way by the sum of both depths."""

    def __post_init__(self) -> None:
        require_fields(
            self, self.name, friction=FRICTION, restitution=FRACTION, rolling=ROBOT_HEIGHT, stiffness=STIFFNESS
        )


_DAMPING_RATIOS = {"bullet": 8.0, "mujoco": 4.0}
"""Of contacts, to critical: what was squeezed comes out slowly, and a hit does not bounce twice. MuJoCo's springs are
taken at the end of a step; with 8 there, a tube that spins where it lies does not stop."""


def contact_damping(engine: str, stiffness: float, mass: float) -> float:
    """Damping of the contacts of a body [N s/m], from its stiffness [N/m] and mass [kg]."""
    return 2.0 * _DAMPING_RATIOS[engine] * math.sqrt(stiffness * mass)


# Estimates, +-30 %: nobody has published measurements of FRC field materials against foam balls. Against a foam ball
# (friction 0.8, restitution 0.55) they give mu / e: carpet 0.8 / 0.28, wall 0.4 / 0.44, bumper 0.96 / 0.25,
# polycarbonate 0.24 / 0.5; a ball rolling on carpet slows by 0.45 m/s^2.
CARPET = TerrainSurface(name="CARPET", friction=1.0, restitution=0.5, rolling=0.006)
WALL = TerrainSurface(name="WALL", friction=0.5, restitution=0.8, rolling=0.001)
RUBBER = TerrainSurface(name="RUBBER", friction=1.2, restitution=0.45, rolling=0.005)
POLYCARBONATE = TerrainSurface(name="POLYCARBONATE", friction=0.3, restitution=0.9, rolling=0.0005)
FRICTIONLESS = TerrainSurface(name="FRICTIONLESS", friction=0.0, restitution=0.0)

PRESETS = {s.name: s for s in (CARPET, WALL, RUBBER, POLYCARBONATE, FRICTIONLESS)}
"""The built-in surfaces by name."""
