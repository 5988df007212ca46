"""The field of REBUILT: its mesh, its materials, and where fuel scores."""

from __future__ import annotations

import math
from dataclasses import replace
from fnmatch import fnmatchcase
from importlib import resources
from pathlib import Path

import numpy as np

from games.rebuilt import dimensions as dim
from simcore.geometry.symmetry import turn_half_point
from simcore.geometry.zones import CylinderZone
from simcore.match.scoring import Alliance, ScoringZone
from simcore.physics.field import FieldGeometry
from simcore.physics.obj import read_obj
from simcore.physics.surface import POLYCARBONATE, RUBBER, WALL
from simcore.typing import FloatArray

__all__ = [
    "DRIVABLE",
    "FIELD_SIZE",
    "HUB_TARGET",
    "default_mesh",
    "drivable",
    "hub_exit",
    "load_field",
    "scoring_zones",
]

FIELD_SIZE = (dim.FIELD_LENGTH, dim.FIELD_WIDTH)
"""Length and width [m]."""

DRIVABLE = ("*_bump_*", "*_depot_barrier_*", "*_tower_base")
"""What robots drive over: name patterns of elements."""

HUB_TARGET = (*dim.HUB_CENTER, dim.HUB_OPENING_HEIGHT)
"""Where to aim: the middle of the blue hub's opening [m]."""

_NET = replace(WALL, name="NET", friction=0.6, restitution=0.2)  # estimate: it hangs loose and takes most of a hit

_SURFACES = {
    "*": WALL,
    "*_hub_funnel_*": POLYCARBONATE,
    "*_hub_shoulder_*": POLYCARBONATE,
    "*_hub_backboard": _NET,
    "*_alliance_wall": POLYCARBONATE,  # the sheet above the diamond plate; a ball meets little else
    "*_bump_*": POLYCARBONATE,  # HDPE plates: as slippery
    "*_depot_barrier_*": RUBBER,
}


def default_mesh() -> Path:
    """The OBJ that comes with simcore: inside an installed package, or in the source tree."""
    packaged = Path(str(resources.files("games.rebuilt"))) / "models" / "field_collision.obj"
    if packaged.exists():
        return packaged
    return Path(__file__).resolve().parents[2] / "models" / "rebuilt" / "field_collision.obj"


def load_field(mesh: Path | None = None) -> FieldGeometry:
    """The field as shapes with surfaces.

    Args:
        mesh: An OBJ file; None: the one that comes with simcore. Groups that are named as in that one get the
            materials of the real field, others are walls.

    Raises:
        FieldMeshError: It is missing or broken.
    """
    if mesh is None:
        return FieldGeometry.load(default_mesh(), surfaces=_SURFACES)
    names = [group.name for group in read_obj(mesh)]
    return FieldGeometry.load(mesh, surfaces={p: s for p, s in _SURFACES.items() if _any_match(names, p)})


def drivable(field: FieldGeometry) -> list[str]:
    """Those of the `DRIVABLE` patterns that name something in this field."""
    names = [element.name for element in field.elements]
    return [pattern for pattern in DRIVABLE if _any_match(names, pattern)]


def _any_match(names: list[str], pattern: str) -> bool:
    return any(fnmatchcase(name, pattern) for name in names)


def scoring_zones() -> list[ScoringZone]:
    """One zone in each hub: the throat under its funnel. What falls through it has scored."""
    zones = []
    alliances: tuple[Alliance, Alliance] = ("blue", "red")
    for alliance in alliances:
        center = dim.HUB_CENTER if alliance == "blue" else turn_half_point(*dim.HUB_CENTER, FIELD_SIZE)
        zone = CylinderZone(
            center=center,
            radius=dim.HUB_THROAT_CIRCUMRADIUS,
            bottom=dim.HUB_BOX_TOP,
            top=dim.HUB_THROAT_HEIGHT,
        )
        zones.append(ScoringZone(name=f"{alliance.capitalize()}Hub", alliance=alliance, zone=zone))
    return zones


def hub_exit(alliance: Alliance, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Place [m] and velocity [m/s] of a fuel that leaves one of a hub's four exits into the neutral zone.

    2 m/s +-0.1, down by 15 +-2.5 degrees, fanned out by exit: MapleSim's figures, which are estimates.
    """
    exit_number = int(rng.integers(len(dim.HUB_EXIT_YS)))
    fan = math.radians((-33.75, -11.25, 11.25, 33.75)[exit_number] + rng.uniform(-7.5, 7.5))
    dip = math.radians(15.0 + rng.uniform(-2.5, 2.5))
    speed = 2.0 + rng.uniform(-0.1, 0.1)
    pos = np.array([dim.HUB_EXIT_X + 0.08, dim.HUB_EXIT_YS[exit_number] + rng.uniform(-0.01, 0.01), dim.HUB_EXIT_Z])
    level = speed * math.cos(dip)
    vel = np.array([level * math.cos(fan), level * math.sin(fan), -speed * math.sin(dip)])
    if alliance == "red":
        pos[:2] = FIELD_SIZE - pos[:2]
        vel[:2] = -vel[:2]
    return pos, vel
