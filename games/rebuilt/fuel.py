"""Fuel, the game piece of REBUILT."""

from __future__ import annotations

from simcore.pieces.aerodynamics import Aerodynamics
from simcore.pieces.kinds import GamePieceConfig
from simcore.units import inches, pounds
from simcore.world.contact_law import FoamStiffness
from simcore.world.shapes import Sphere

__all__ = ["FUEL"]

FUEL = GamePieceConfig(
    name="Fuel",
    shape=Sphere(inches(5.91) / 2),  # high-density foam ball of 5.91 in, game manual (arena, FUEL)
    color="#ffd923",
    mass=0.5 * (pounds(0.448) + pounds(0.500)),  # the manual's range, 0.203 to 0.227 kg
    friction=0.8,  # estimate, +-30 %: foam on carpet; no published measurement
    # AndyMark's report on the scoring element, as cited by rebuilt-sim-2026: 20.6, 42 and 77 lb at 1, 1.5 and 2 in of
    # compression between two plates, half of it on each side; this curve gives 20.6, 42.1 and 77.1 lb.
    stiffness=FoamStiffness(linear=5.13e3, cubic=1.296e7),
    restitution=0.55,  # drop test onto a hard floor by denbot/2026-RebuiltHubSimulation
    aerodynamics=Aerodynamics(drag_coefficient=0.47),  # no measurement for the foam ball; 0.40 to 0.55 is plausible
)
"""Config of the game piece fuel."""
