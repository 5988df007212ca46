"""Field of REBUILT: mesh, materials and scoring zones."""

from __future__ import annotations

import math
from dataclasses import replace

from games.rebuilt import dimensions as dim
from games.shipped import shipped
from simcore.match.game import FieldDefinition
from simcore.match.scoring import Alliance, ScoringZone
from simcore.pieces.shot_opening import ShotOpening
from simcore.robot.climber import Rung
from simcore.world.contact_law import POLYCARBONATE, RUBBER, WALL
from simcore.world.symmetry import FieldSymmetry
from simcore.world.zones import CylinderZone

__all__ = ["FIELD", "FIELD_SIZE", "HUB_TARGET", "scoring_zones"]

FIELD_SIZE = (dim.FIELD_LENGTH, dim.FIELD_WIDTH)
"""Length and width of the field [m]."""

HUB_TARGET = (*dim.HUB_CENTER, dim.HUB_OPENING_HEIGHT)
"""Target point of shots: center of the blue hub's opening, field frame [m]."""

_NET = replace(WALL, name="NET", friction=0.6, restitution=0.2)  # estimate: a loose net absorbs most of a hit

_SURFACES = {
    "*": WALL,
    "*_hub_funnel_*": POLYCARBONATE,
    "*_hub_shoulder_*": POLYCARBONATE,
    "*_hub_backboard": _NET,
    "*_alliance_wall": POLYCARBONATE,  # balls mostly hit the sheet above the diamond plate
    "*_bump_*": POLYCARBONATE,  # HDPE plates, which are about as slippery
    "*_depot_barrier_*": RUBBER,
}


_SYMMETRY = FieldSymmetry("rotate", FIELD_SIZE)


def _rungs() -> tuple[Rung, ...]:
    """Return the three rungs of each alliance's tower, with the ends that extend beyond the uprights."""
    x, reach = dim.TOWER_UPRIGHT_X, 0.5 * dim.TOWER_RUNG_LENGTH
    rungs = []
    for level, z in zip(("low", "mid", "high"), dim.TOWER_RUNG_HEIGHTS, strict=True):
        ends = ((x, dim.TOWER_Y - reach, z), (x, dim.TOWER_Y + reach, z))
        for alliance in ("blue", "red"):
            start, end = _SYMMETRY.points_of(alliance, *ends)
            rungs.append(Rung(name=f"{alliance}_tower_rung_{level}", start=start, end=end, alliance=alliance))
    return tuple(rungs)


FIELD = FieldDefinition(
    size=FIELD_SIZE,
    symmetry=_SYMMETRY,
    mesh=shipped("rebuilt", "field_collision.obj"),
    materials=_SURFACES,
    drivable=("*_bump_*", "*_depot_barrier_*", "*_tower_base"),
    tags="2026-welded",
    rungs=_rungs(),
)
"""Definition of the field: size, symmetry, mesh, materials, drivable elements, tags and rungs."""


def scoring_zones() -> tuple[ScoringZone, ...]:
    """Return the scoring zone of each hub: the throat below the funnel."""
    zones = []
    alliances: tuple[Alliance, Alliance] = ("blue", "red")
    for alliance in alliances:
        center = dim.HUB_CENTER if alliance == "blue" else FIELD.symmetry.flip_point(*dim.HUB_CENTER)
        zone = CylinderZone(
            center=center,
            radius=dim.HUB_THROAT_CIRCUMRADIUS,
            bottom=dim.HUB_BOX_TOP,
            top=dim.HUB_THROAT_HEIGHT,
        )
        name = f"{alliance.capitalize()}Hub"
        zones.append(ScoringZone(name=name, alliance=alliance, zone=zone, opening=_hub_opening(alliance)))
    return tuple(zones)


def _hub_opening(alliance: Alliance) -> ShotOpening:
    """Return the hexagonal opening above the funnel of an alliance's hub."""
    (cx, cy), sixth = dim.HUB_CENTER, math.tau / 6
    reach, height = dim.HUB_OPENING_CIRCUMRADIUS, dim.HUB_OPENING_HEIGHT
    corners = [(math.cos((k + 0.5) * sixth), math.sin((k + 0.5) * sixth)) for k in range(6)]
    rim = _SYMMETRY.points_of(alliance, *((cx + reach * c, cy + reach * s, height) for c, s in corners))
    return ShotOpening(corners=rim, approach=0.0 if alliance == "blue" else math.pi)
