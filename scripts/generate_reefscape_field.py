"""Write models/reefscape/field_collision.obj from the dimensions of the 2025 field.

    python scripts/generate_reefscape_field.py

Every group is convex, so an engine needs no triangle mesh for it. These simplifications are intended:

- Cages are not included: they swing (`games/reefscape/field.py`).
- The bends of the reef's pipes are corners, and the pipes are octagons of equal cross-section area.
- A net is a stiff tray between its rim and the lowest point of its sag.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

import numpy as np

from games.reefscape import dimensions as dim
from simcore.world.footprints import hexagon
from simcore.world.obj import (
    ObjGroup,
    box_group,
    flipped_group,
    format_obj,
    pipe_group,
    prism_group,
    solid_group,
    write_obj,
)
from simcore.world.symmetry import FieldSymmetry

OUTPUT = Path(__file__).resolve().parents[1] / "models" / "reefscape" / "field_collision.obj"
FIELD_SYMMETRY = FieldSymmetry("rotate", (dim.FIELD_LENGTH, dim.FIELD_WIDTH))

HEADER = """\
FRC 2025 REEFSCAPE field, collision shapes. Meters, z up, origin at the blue alliance's right-hand corner.
Written by scripts/generate_reefscape_field.py from games/reefscape/dimensions.py; change those, not this file.
Red is blue rotated by 180 degrees about the field center."""


def guardrail() -> list[ObjGroup]:
    """Make the wall y = 0 on both sides of blue's processor, and the processor's frame; red's is the wall y = width."""
    t, half = dim.PERIMETER_THICKNESS, dim.PROCESSOR_OPENING_WIDTH / 2.0
    x, jamb, back = dim.PROCESSOR_X, dim.PROCESSOR_FRAME_WIDTH, -dim.PROCESSOR_RECESS
    bottom, frame_top = dim.PROCESSOR_OPENING_BOTTOM, dim.PROCESSOR_FRAME_TOP
    lintel = bottom + dim.PROCESSOR_OPENING_HEIGHT
    low, high = x - half - jamb, x + half + jamb
    return [
        box_group("guardrail_near", (0.0, -t, 0.0), (low, 0.0, dim.GUARDRAIL_HEIGHT)),
        box_group("guardrail_far", (high, -t, 0.0), (dim.FIELD_LENGTH, 0.0, dim.GUARDRAIL_HEIGHT)),
        box_group("processor_sill", (low, -t, 0.0), (high, back, bottom)),
        box_group("processor_lintel", (low, -t, lintel), (high, back, frame_top)),
        box_group("processor_jamb_right", (low, -t, bottom), (x - half, back, lintel)),
        box_group("processor_jamb_left", (x + half, -t, bottom), (high, back, lintel)),
    ]


def alliance_wall() -> ObjGroup:
    """Make the wall of driver stations; coral stations cut its corners."""
    t = dim.PERIMETER_THICKNESS
    return box_group("alliance_wall", (-t, -t, 0.0), (0.0, dim.FIELD_WIDTH + t, dim.ALLIANCE_WALL_HEIGHT))


# --- reef -----------------------------------------------------------------------------------------------------------


def face_point(face: int, out: float, aside: float, z: float) -> tuple[float, float, float]:
    """Return a point of a reef face, from distances out from the reef's center and aside (left from the center) [m]."""
    yaw = math.radians(dim.REEF_FACE_YAWS_DEG[face])
    (cx, cy), c, s = dim.REEF_CENTER, math.cos(yaw), math.sin(yaw)
    return cx + out * c - aside * s, cy + out * s + aside * c, z


def reef() -> list[ObjGroup]:
    """Make a core up to the troughs' inner wall, a solid trough per face, and twelve pipes with three branches each."""
    inner = dim.REEF_APOTHEM - dim.TROUGH_DEPTH
    groups = [prism_group("reef_core", hexagon(dim.REEF_CENTER, inner), 0.0, dim.TROUGH_WALL_HEIGHT)]
    section = [
        (inner, 0.0),
        (dim.REEF_APOTHEM, 0.0),
        (dim.REEF_APOTHEM, dim.TROUGH_EDGE_HEIGHT),
        (inner, dim.TROUGH_EDGE_HEIGHT - dim.TROUGH_FLOOR_DROP),
    ]
    half = math.tan(math.radians(30.0))  # of a side, per meter of apothem
    for face in range(6):
        ends = [np.array([face_point(face, r, side * r * half, z) for r, z in section]) for side in (1.0, -1.0)]
        groups.append(solid_group(f"reef_trough_{face}", ends[0], ends[1]))
        for side, offset in (("left", -dim.BRANCH_OFFSET), ("right", dim.BRANCH_OFFSET)):
            groups += pipe_with_branches(face, f"{face}_{side}", offset)
    return groups


def pipe_with_branches(face: int, name: str, aside: float) -> list[ObjGroup]:
    """Make a riser, its branches of levels 2 and 3, and its end on level 4: out, and up."""
    riser, tip, slope = dim.RISER_RADIUS, dim.BRANCH_TIP_RADIUS, math.tan(dim.BRANCH_SLOPE)
    yaw = math.radians(dim.REEF_FACE_YAWS_DEG[face])
    across = (-math.sin(yaw), math.cos(yaw), 0.0)
    *sloping, top = dim.BRANCH_TIP_HEIGHTS
    bend = dim.L4_BEND_HEIGHT
    runs = [("riser", (riser, dim.TROUGH_WALL_HEIGHT), (riser, bend))]
    for level, z in zip((2, 3), sloping, strict=True):
        runs.append((f"branch_l{level}", (riser, z - (tip - riser) * slope), (tip, z)))
    runs += [("arm_l4", (riser, bend), (tip, bend)), ("branch_l4", (tip, bend), (tip, top))]
    return [
        pipe_group(
            f"reef_{kind}_{name}",
            face_point(face, start[0], aside, start[1]),
            face_point(face, end[0], aside, end[1]),
            dim.BRANCH_DIAMETER,
            aside=across,
        )
        for kind, start, end in runs
    ]


# --- stations -------------------------------------------------------------------------------------------------------


def station(side: str) -> list[ObjGroup]:
    """Make a cut corner: the chute's lip and slope under the opening, its roof, the space behind, and both ends."""
    opening, end = dim.STATION_OPENING_WIDTH / 2.0, 1.15  # the ends extend behind wall and guardrail
    lip, length, depth = dim.CHUTE_LIP_LENGTH, dim.CHUTE_LENGTH, dim.STATION_DEPTH
    bottom, mouth = dim.STATION_OPENING_BOTTOM, dim.STATION_OPENING_BOTTOM + dim.STATION_OPENING_HEIGHT
    lip_top = bottom + lip * math.tan(dim.CHUTE_LIP_SLOPE)
    steep = math.tan(dim.CHUTE_SLOPE)
    slope_top, roof_back = lip_top + (length - lip) * steep, mouth + length * steep
    front, back = dim.ALLIANCE_WALL_HEIGHT, dim.ALLIANCE_WALL_HEIGHT + 0.5 * depth  # too steep for pieces to stay on it
    at_length = front + (back - front) * length / depth
    parts = {  # corners of the section: behind the face, height
        "lip": ([(0.0, 0.0), (0.0, bottom), (lip, lip_top), (lip, 0.0)], -opening, opening),
        "chute": ([(lip, 0.0), (lip, lip_top), (length, slope_top), (length, 0.0)], -opening, opening),
        "roof": ([(0.0, mouth), (0.0, front), (length, at_length), (length, roof_back)], -opening, opening),
        "back": ([(length, 0.0), (length, at_length), (depth, back), (depth, 0.0)], -opening, opening),
        "end_near": ([(0.0, 0.0), (0.0, front), (depth, back), (depth, 0.0)], -end, -opening),
        "end_far": ([(0.0, 0.0), (0.0, front), (depth, back), (depth, 0.0)], opening, end),
    }
    yaw = math.radians(dim.STATION_YAW_DEG)
    n, along = np.array([math.cos(yaw), math.sin(yaw)]), np.array([-math.sin(yaw), math.cos(yaw)])
    groups = []
    for name, (section, low, high) in parts.items():
        ends = []
        for t in (high, low):
            rows = [(*(np.array(dim.STATION_FACE_CENTER) - d * n + t * along), z) for d, z in section]
            ends.append(np.array(rows))
        if side == "left":  # mirrored in y, so its corners are in reverse order
            ends = [rows * (1.0, -1.0, 1.0) + (0.0, dim.FIELD_WIDTH, 0.0) for rows in ends[::-1]]
        groups.append(solid_group(f"station_{side}_{name}", ends[0], ends[1]))
    return groups


# --- barge ----------------------------------------------------------------------------------------------------------


def barge() -> list[ObjGroup]:
    """Make one alliance's half: truss from the middle post to its leg outside the guardrail, and net above it."""
    x, middle = dim.FIELD_CENTER
    post, leg_end = dim.BARGE_POST_SIZE / 2.0, middle + dim.BARGE_LENGTH / 2.0
    rim, floor, t = dim.NET_RIM_HEIGHT, dim.NET_FLOOR_HEIGHT, dim.NET_FRAME_THICKNESS
    w, (y0, y1) = dim.NET_WIDTH / 2.0, (dim.NET_Y - dim.NET_LENGTH / 2.0, dim.NET_Y + dim.NET_LENGTH / 2.0)
    return [
        box_group("barge_post", (x - post, middle, 0.0), (x + post, middle + post, dim.TRUSS_BOTTOM)),
        box_group("barge_truss", (x - post, middle, dim.TRUSS_BOTTOM), (x + post, leg_end, dim.TRUSS_TOP)),
        box_group("barge_leg", (x - post, dim.FIELD_WIDTH, 0.0), (x + post, leg_end, dim.TRUSS_BOTTOM)),
        box_group("net_floor", (x - w, y0, floor - t), (x + w, y1, floor)),
        box_group("net_near", (x - w, y0, floor), (x - w + t, y1, rim)),
        box_group("net_far", (x + w - t, y0, floor), (x + w, y1, rim)),
        box_group("net_inner", (x - w + t, y0, floor), (x + w - t, y0 + t, rim)),
        box_group("net_outer", (x - w + t, y1 - t, floor), (x + w - t, y1, rim)),
    ]


def groups() -> list[ObjGroup]:
    """Return the whole field in the order of the file."""
    own = [alliance_wall(), *guardrail(), *station("right"), *station("left"), *reef(), *barge()]
    blue = [ObjGroup(f"blue_{group.name}", group.vertices, group.faces) for group in own]
    return blue + [flipped_group(group, f"red_{group.name}", FIELD_SYMMETRY) for group in own]


def generate() -> str:
    """Return the text of the OBJ file."""
    return format_obj(groups(), header=HEADER)


def main() -> int:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", nargs="?", type=Path, default=OUTPUT, help="default: %(default)s")
    print(write_obj(parser.parse_args().file, groups(), header=HEADER))
    return 0


if __name__ == "__main__":
    sys.exit(main())
