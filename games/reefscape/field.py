"""The field of REEFSCAPE: its mesh, its materials, what robots hang on, and where algae go through a wall."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from games.reefscape import dimensions as dim
from games.shipped import shipped
from simcore.geometry.symmetry import FieldSymmetry
from simcore.geometry.zones import BoxZone
from simcore.match.game import FieldDefinition
from simcore.match.scoring import Alliance, ScoringZone
from simcore.physics.surface import POLYCARBONATE, WALL
from simcore.robot.climber import Rung

__all__ = ["ALLIANCES", "FIELD", "FIELD_SIZE", "cage_rungs", "flipped_box", "other_alliance", "scoring_zones"]

ALLIANCES: tuple[Alliance, Alliance] = ("blue", "red")
FIELD_SIZE = (dim.FIELD_LENGTH, dim.FIELD_WIDTH)
"""Length and width [m]."""

# Estimates: friction of PVC on steel pipe is 0.2 to 0.3, on the HDPE of troughs and chutes the same.
_PIPE = replace(WALL, name="PIPE", friction=0.7, restitution=0.6)
_NET = replace(WALL, name="NET", friction=0.8, restitution=0.15, rolling=0.01)

_SURFACES = {
    "*": WALL,
    "*_alliance_wall": POLYCARBONATE,
    "*_station_*": POLYCARBONATE,
    "*_reef_*": _PIPE,
    "*_net_*": _NET,
}
_SYMMETRY = FieldSymmetry("rotate", FIELD_SIZE)


def other_alliance(alliance: Alliance) -> Alliance:
    """The opponent."""
    return "red" if alliance == "blue" else "blue"


def cage_rungs(depth: Literal["shallow", "deep"]) -> tuple[Rung, ...]:
    """What a climber can hang on: the upper end of a cage, on each of the six places, along y."""
    bottom = dim.CAGE_DEEP_BOTTOM if depth == "deep" else dim.CAGE_SHALLOW_BOTTOM
    z, half = bottom + dim.CAGE_HEIGHT, dim.CAGE_SIZE / 2.0
    rungs = []
    for alliance in ALLIANCES:
        for number, y in enumerate(dim.CAGE_YS):
            start, end = _SYMMETRY.points_of(alliance, (dim.CAGE_X, y - half, z), (dim.CAGE_X, y + half, z))
            rungs.append(Rung(name=f"{alliance}_{depth}_cage_{number}", start=start, end=end))
    return tuple(rungs)


FIELD = FieldDefinition(
    size=FIELD_SIZE,
    symmetry=_SYMMETRY,
    mesh=shipped("reefscape", "field_collision.obj"),
    materials=_SURFACES,
    tags="2025-welded",
    rungs=cage_rungs("deep") + cage_rungs("shallow"),
)
"""The whole field. A cage hangs shallow or deep, as a team says before a match: here both rungs are there, and the one
that a robot hangs on is the one that it chose."""


def flipped_box(
    low: tuple[float, float, float], high: tuple[float, float, float], alliance: Alliance
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Smallest and largest corner of an alliance's box that blue has between two corners [m]."""
    (x0, y0, z0), (x1, y1, z1) = _SYMMETRY.points_of(alliance, low, high)
    return (min(x0, x1), min(y0, y1), z0), (max(x0, x1), max(y0, y1), z1)


def scoring_zones() -> tuple[ScoringZone, ...]:
    """The processors: an algae in the opening has scored. What stays on the reef or in a net is judged by the rules."""
    half, bottom = dim.PROCESSOR_OPENING_WIDTH / 2.0, dim.PROCESSOR_OPENING_BOTTOM
    low = (dim.PROCESSOR_X - half, -0.8, bottom)
    high = (dim.PROCESSOR_X + half, -0.05, bottom + dim.PROCESSOR_OPENING_HEIGHT)
    return tuple(
        ScoringZone(
            name=f"{alliance.capitalize()}Processor",
            alliance=alliance,
            zone=BoxZone(*flipped_box(low, high, alliance)),
            points=6,
            downward=False,
            kinds=("Algae",),
        )
        for alliance in ALLIANCES
    )
