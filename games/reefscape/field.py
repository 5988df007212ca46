"""Field of REEFSCAPE: mesh, materials, cages and processor zones."""

from __future__ import annotations

from dataclasses import replace

from games.reefscape import dimensions as dim
from games.shipped import shipped
from simcore.match.game import FieldDefinition, GameOption
from simcore.match.scoring import Alliance, ScoringZone
from simcore.robot.climber import Rung
from simcore.world.contact_law import POLYCARBONATE, WALL
from simcore.world.hanging import HangingConfig
from simcore.world.shapes import Box
from simcore.world.symmetry import FieldSymmetry
from simcore.world.zones import BoxZone

__all__ = [
    "ALLIANCES", "CAGE_OPTIONS", "FIELD", "FIELD_SIZE", "arrange", "scoring_zones"
]  # fmt: skip

ALLIANCES: tuple[Alliance, Alliance] = ("blue", "red")
FIELD_SIZE = (dim.FIELD_LENGTH, dim.FIELD_WIDTH)
"""Length and width of the field [m]."""

# Estimates: the coefficient of friction of PVC is 0.2 to 0.3 on steel pipe and on the HDPE of troughs and chutes.
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


def _cage_name(alliance: Alliance, number: int) -> str:
    """Return the name of the cage with a given number, counted from 1 at the guardrail."""
    return f"{alliance}_cage_{number}"


def arrange(field: FieldDefinition, options: frozenset[str]) -> FieldDefinition:
    """Return a copy of the field with six cages, deep, or shallow if the option `<cage name>_shallow` is on."""
    cages, rungs, half = [], [], dim.CAGE_SIZE / 2.0
    for alliance in ALLIANCES:
        for number, y in enumerate(dim.CAGE_YS, start=1):
            name = _cage_name(alliance, number)
            bottom = dim.CAGE_SHALLOW_BOTTOM if f"{name}_shallow" in options else dim.CAGE_DEEP_BOTTOM
            ends = [(dim.CAGE_X, y + aside, dim.TRUSS_BOTTOM) for aside in (-half, 0.0, half)]
            (x0, y0, _), pivot, (x1, y1, _) = _SYMMETRY.points_of(alliance, *ends)
            cages.append(
                HangingConfig(
                    name=name,
                    alliance=alliance,
                    shape=Box((dim.CAGE_SIZE, dim.CAGE_SIZE, dim.CAGE_HEIGHT)),
                    mass=7.0,  # estimate: four 1 in Sch 40 pipes and two plates, 6 to 8 kg
                    pivot=pivot,
                    drop=dim.TRUSS_BOTTOM - bottom - dim.CAGE_HEIGHT / 2.0,
                    surface=_PIPE,
                )
            )
            for end, z in (("top", bottom + dim.CAGE_HEIGHT), ("bottom", bottom)):
                start, stop = (x0, y0, z), (x1, y1, z)
                rungs.append(Rung(name=f"{name} {end}", start=start, end=stop, mount=name, alliance=alliance))
    return replace(field, hanging=tuple(cages), rungs=tuple(rungs))


CAGE_OPTIONS = tuple(
    GameOption(
        name=f"{_cage_name(alliance, number)}_shallow",
        help=f"{alliance}'s cage {number}, counted from the guardrail, hangs shallow; otherwise deep",
    )
    for alliance in ALLIANCES
    for number in range(1, len(dim.CAGE_YS) + 1)
)

FIELD = arrange(
    FieldDefinition(
        size=FIELD_SIZE,
        symmetry=_SYMMETRY,
        mesh=shipped("reefscape", "field_collision.obj"),
        materials=_SURFACES,
        tags="2025-welded",
    ),
    frozenset(),
)
"""Definition of the field: size, symmetry, mesh, materials, tags, and six deep cages."""


def scoring_zones() -> tuple[ScoringZone, ...]:
    """Return the scoring zones of the processors; `ReefscapeRules` counts pieces on the reef and in the nets."""
    half, bottom = dim.PROCESSOR_OPENING_WIDTH / 2.0, dim.PROCESSOR_OPENING_BOTTOM
    low = (dim.PROCESSOR_X - half, -0.8, bottom)
    high = (dim.PROCESSOR_X + half, -0.05, bottom + dim.PROCESSOR_OPENING_HEIGHT)
    return tuple(
        ScoringZone(
            name=f"{alliance.capitalize()}Processor",
            alliance=alliance,
            zone=BoxZone(*_SYMMETRY.box_of(alliance, low, high)),
            points=6,
            downward=False,
            kinds=("Algae",),
        )
        for alliance in ALLIANCES
    )
