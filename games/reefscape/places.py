"""Resting places of coral and algae: branches and troughs of the reefs, and nets."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from games.reefscape import dimensions as dim
from games.reefscape.field import ALLIANCES, FIELD
from simcore.match.scoring import Alliance
from simcore.pieces.resting_places import RestingPlace
from simcore.world.zones import BoxZone, CapsuleZone

__all__ = ["BRANCH_ROWS", "PLACES", "branch_ends", "level_of"]

BRANCH_ROWS = {4: "topRow", 3: "midRow", 2: "botRow"}
"""Name of the row of branches on each level, by level, as in the API of The Blue Alliance."""
_LABELS = {row: f"L{level}" for level, row in BRANCH_ROWS.items()} | {"trough": "L1", "net": "Net"}
_BORE_SPARE = 0.04
"""Largest distance from a branch's axis to the center of a coral on the branch [m]. The bore of a coral has a clearance
of 30 mm. The center of a coral next to the branch has a distance of 78 mm."""
_TROUGH_SPARE = 0.15  # [m] around the line along a trough's floor, enough for a coral that stands upright


@cache
def level_of(alliance: Alliance, row: str) -> str:
    """Return the name of the level of an alliance's row of places, for example `BlueL4`."""
    return f"{alliance.capitalize()}{_LABELS[row]}"


def branch_ends(number: int, level: int) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return both ends of the last straight part of a blue branch, first the inner end, then the tip [m].

    Args:
        number: Number of the branch, 0 to 11 for A to L of the manual, counter-clockwise from the face toward the
            alliance wall.
        level: Level, 2 to 4.
    """
    yaw = math.radians(dim.REEF_FACE_YAWS_DEG[-(number // 2) % 6])  # faces are numbered clockwise
    aside = dim.BRANCH_OFFSET if number % 2 else -dim.BRANCH_OFFSET
    run = dim.BRANCH_TIP_RADIUS - dim.RISER_RADIUS
    tip_z = dim.BRANCH_TIP_HEIGHTS[level - 2]
    start = (dim.RISER_RADIUS, tip_z - run * math.tan(dim.BRANCH_SLOPE))
    if level == 4:
        start = (dim.BRANCH_TIP_RADIUS, dim.L4_BEND_HEIGHT)
    (cx, cy), c, s = dim.REEF_CENTER, math.cos(yaw), math.sin(yaw)

    def at(out: float, z: float) -> tuple[float, float, float]:
        return cx + out * c - aside * s, cy + out * s + aside * c, z

    return at(*start), at(dim.BRANCH_TIP_RADIUS, tip_z)


def _places(alliance: Alliance) -> list[RestingPlace]:
    name, coral, places = alliance.capitalize(), ("Coral",), []
    for level, row in BRANCH_ROWS.items():
        for number in range(12):
            start, tip = FIELD.symmetry.points_of(alliance, *branch_ends(number, level))
            way = np.subtract(tip, start)
            x, y, z = (way / np.linalg.norm(way)).tolist()
            places.append(
                RestingPlace(
                    name=f"{name} {'ABCDEFGHIJKL'[number]} L{level}",
                    level=level_of(alliance, row),
                    alliance=alliance,
                    zone=CapsuleZone(start, tip, _BORE_SPARE),
                    capacity=1,
                    kinds=coral,
                    axis=(x, y, z),
                )
            )
    out = dim.REEF_APOTHEM - 0.5 * dim.TROUGH_DEPTH
    half, z = out * math.tan(math.radians(30.0)), dim.TROUGH_EDGE_HEIGHT
    for face in range(6):  # counter-clockwise, like the branches above
        yaw_deg = dim.REEF_FACE_YAWS_DEG[-face % 6]
        (cx, cy), c, s = dim.REEF_CENTER, math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
        ends = [(cx + out * c - t * s, cy + out * s + t * c, z) for t in (-half, half)]
        start, end = FIELD.symmetry.points_of(alliance, *ends)
        zone = CapsuleZone(start, end, _TROUGH_SPARE)
        level_name = level_of(alliance, "trough")
        over = "ABCDEFGHIJKL"[2 * face : 2 * face + 2]
        places.append(
            RestingPlace(name=f"{name} {over} L1", level=level_name, alliance=alliance, zone=zone, kinds=coral)
        )
    w, length, t = dim.NET_WIDTH / 2.0, dim.NET_LENGTH / 2.0, dim.NET_FRAME_THICKNESS
    low = (dim.FIELD_CENTER[0] - w + t, dim.NET_Y - length + t, dim.NET_FLOOR_HEIGHT)
    high = (dim.FIELD_CENTER[0] + w - t, dim.NET_Y + length - t, dim.NET_RIM_HEIGHT + 0.5 * dim.ALGAE_DIAMETER)
    zone_of_net = BoxZone(*FIELD.symmetry.box_of(alliance, low, high))
    net_level = level_of(alliance, "net")
    net = RestingPlace(name=f"{name} net", level=net_level, alliance=alliance, zone=zone_of_net, kinds=("Algae",))
    return [*places, net]


PLACES = tuple(place for alliance in ALLIANCES for place in _places(alliance))
"""Resting places of both alliances."""
