"""Coral and algae, the game pieces of REEFSCAPE."""

from __future__ import annotations

from games.reefscape.dimensions import ALGAE_DIAMETER, CORAL_INNER_DIAMETER, CORAL_LENGTH, CORAL_OUTER_DIAMETER
from simcore.pieces.aerodynamics import Aerodynamics
from simcore.pieces.kinds import GamePieceConfig
from simcore.world.shapes import Sphere, tube

__all__ = ["ALGAE", "CORAL"]

CORAL = GamePieceConfig(
    name="Coral",
    shape=tube(
        length=CORAL_LENGTH,
        outer_radius=CORAL_OUTER_DIAMETER / 2.0,
        inner_radius=CORAL_INNER_DIAMETER / 2.0,
    ),
    color="#f4f1ea",
    mass=0.65,  # 4 in Sch 40 cellular-core PVC; published masses are 0.5 to 0.8 kg
    friction=0.35,  # estimate: PVC on carpet 0.3 to 0.4
    restitution=0.6,  # estimate: 0.25 to 0.35 on carpet
    rolling=0.0023,  # estimate: a coral on its side slows down by 0.4 m/s^2
    stiffness=1e5,  # pipe with a stiffness of 46 psi (ASTM F891) between plates: 95 kN/m at this length
)
"""Config of the game piece coral."""

ALGAE = GamePieceConfig(
    name="Algae",
    shape=Sphere(ALGAE_DIAMETER / 2.0),
    color="#2f9e8f",
    mass=0.45,  # estimate: not in the manual; teams report 0.40 to 0.45 kg
    friction=0.7,  # estimate: rubber on carpet 0.6 to 0.8
    restitution=0.9,  # estimate: 0.65 for a hard wall, and 0.45 for the carpet, which absorbs more of a light ball
    rolling=0.012,  # estimate: an algae slows down by 0.45 m/s^2
    stiffness=8e3,  # estimate: stiffness 2 pi r p of a playground ball at 7 kPa
    aerodynamics=Aerodynamics(drag_coefficient=0.47),  # value of a smooth ball
)
"""Config of the game piece algae."""
