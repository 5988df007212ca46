"""Write models/rebuilt/field_collision.obj from the dimensions in the game manual.

    python scripts/generate_rebuilt_field.py [FILE.obj]

Every group is a box or a convex prism, so an engine needs no triangle mesh for it. These simplifications are intended:

- The hub's exits are closed: a scored ball is removed in the funnel, and the game puts it back in front of an exit.
- The outpost's openings are closed; chute and corral are behind the alliance wall, outside the field.
- A trench arm is as tall as the whole trench (22.25 to 40.25 in); on the field only the tag panel is that tall.
- Round rungs are square bars of equal width.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

import numpy as np

from games.rebuilt import dimensions as dim
from simcore.world.obj import ObjGroup, box_group, flipped_group, format_obj, solid_group, write_obj
from simcore.world.symmetry import FieldSymmetry

OUTPUT = Path(__file__).resolve().parents[1] / "models" / "rebuilt" / "field_collision.obj"

FIELD_SYMMETRY = FieldSymmetry("rotate", (dim.FIELD_LENGTH, dim.FIELD_WIDTH))

QUADRANTS = ((1, 1), (-1, 1), (-1, -1), (1, -1))
"""Signs of x and y around a center, counter-clockwise."""

HEADER = """\
FRC 2026 REBUILT field, collision shapes. Meters, z up, origin at the blue alliance's right-hand corner.
Written by scripts/generate_rebuilt_field.py from games/rebuilt/dimensions.py; change those, not this file.
Red is blue rotated by 180 degrees about the field center."""


def ridge(
    name: str, low: tuple[float, float], high: tuple[float, float], height: float, bevel: tuple[float, float]
) -> ObjGroup:
    """Make a bar on the floor whose top is narrower on both sides by `bevel` along x and y [m]."""
    ring = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    bx, by = bevel
    top = [
        (low[0] + bx, low[1] + by),
        (high[0] - bx, low[1] + by),
        (high[0] - bx, high[1] - by),
        (low[0] + bx, high[1] - by),
    ]
    return solid_group(name, np.array([(*xy, 0.0) for xy in ring]), np.array([(*xy, height) for xy in top]))


def perimeter() -> list[ObjGroup]:
    """Make both guardrails; the alliance walls belong to the alliances and cover the corners."""
    t, length, width, height = dim.PERIMETER_THICKNESS, dim.FIELD_LENGTH, dim.FIELD_WIDTH, dim.GUARDRAIL_HEIGHT
    right = box_group("guardrail_right", (0.0, -t, 0.0), (length, 0.0, height))
    left = box_group("guardrail_left", (0.0, width, 0.0), (length, width + t, height))
    return [right, left]


def alliance_wall() -> ObjGroup:
    """Make the wall of driver stations, tower wall and outpost as one solid box."""
    t = dim.PERIMETER_THICKNESS
    return box_group("alliance_wall", (-t, -t, 0.0), (0.0, dim.FIELD_WIDTH + t, dim.ALLIANCE_WALL_HEIGHT))


def hub() -> list[ObjGroup]:
    """Make the solid base, six wedges (funnel, throat and outer skirt in one), four shoulders, and the backboard.

    Each wedge spans one edge of the hexagon. Its section, in distance from the axis and height: straight up the throat
    from the base, out along the funnel to the rim, over its slanting edge, and straight down on the outside. Solid
    wedges leave no thin wall to tunnel through and no way in from the side.
    """
    cx, cy = dim.HUB_CENTER
    half = dim.HUB_SIZE / 2.0
    groups = [box_group("hub_base", (cx - half, cy - half, 0.0), (cx + half, cy + half, dim.HUB_BOX_TOP))]
    outer = dim.HUB_OPENING_APOTHEM + dim.HUB_RIM_THICKNESS
    section = [
        (dim.HUB_THROAT_APOTHEM, dim.HUB_BOX_TOP),
        (outer, dim.HUB_BOX_TOP),
        (outer, dim.HUB_OPENING_HEIGHT - dim.HUB_RIM_THICKNESS),
        (dim.HUB_OPENING_APOTHEM, dim.HUB_OPENING_HEIGHT),
        (dim.HUB_THROAT_APOTHEM, dim.HUB_THROAT_HEIGHT),
    ]
    for i in range(6):
        ends = []
        for angle in (math.radians(60.0 * i + 30.0), math.radians(60.0 * i - 30.0)):
            corner = np.array([math.cos(angle), math.sin(angle)]) * 2.0 / math.sqrt(3.0)  # per meter of apothem
            ends.append(np.array([(cx + r * corner[0], cy + r * corner[1], z) for r, z in section]))
        groups.append(solid_group(f"hub_funnel_{i}", ends[0], ends[1]))
    groups += [hub_shoulder(f"hub_shoulder_{i}", sx, sy) for i, (sx, sy) in enumerate(QUADRANTS)]
    back = (cx + dim.HUB_OPENING_APOTHEM, cy - half, dim.HUB_BOX_TOP)
    groups.append(box_group("hub_backboard", back, (cx + half, cy + half, dim.HUB_BACKBOARD_TOP)))
    return groups


def hub_shoulder(name: str, sx: int, sy: int) -> ObjGroup:
    """Make a slope on one corner of the base, down from the skirt to the corner, so that balls roll off.

    Args:
        name: Name of the group.
        sx: Side of the hub along x, -1 or 1.
        sy: Side of the hub along y, -1 or 1.
    """
    (cx, cy), half = dim.HUB_CENTER, dim.HUB_SIZE / 2.0
    outer = dim.HUB_OPENING_APOTHEM + dim.HUB_RIM_THICKNESS
    # The skirt next to this corner is the line x cos 60 + y sin 60 = outer, in the first quadrant.
    on_side = ((outer - half * math.sin(math.radians(60.0))) / math.cos(math.radians(60.0)), half)
    on_front = (half, (outer - half * math.cos(math.radians(60.0))) / math.sin(math.radians(60.0)))
    low, high = dim.HUB_BOX_TOP, dim.HUB_BOX_TOP + dim.HUB_SHOULDER_RISE
    corners = [(*on_front, low), (half, half, low), (*on_side, low), (*on_front, high), (*on_side, high)]
    points = np.array([(cx + sx * x, cy + sy * y, z) for x, y, z in corners])
    faces = ((2, 1, 0), (0, 1, 3), (1, 2, 4), (1, 4, 3), (0, 3, 4, 2))
    # A mirrored copy has its corners in reverse order.
    return ObjGroup(name, points, faces if sx * sy > 0 else tuple(face[::-1] for face in faces))


def bumps() -> list[ObjGroup]:
    """Make two ridges next to the hub: triangular prisms along y."""
    half, groups = dim.BUMP_DEPTH / 2.0, []
    for side, y in (("left", dim.BUMP_LEFT_Y), ("right", dim.BUMP_RIGHT_Y)):
        profile = [(dim.BUMP_X - half, 0.0), (dim.BUMP_X + half, 0.0), (dim.BUMP_X, dim.BUMP_HEIGHT)]
        ends = [np.array([(x, y + dy, z) for x, z in profile]) for dy in (dim.BUMP_WIDTH / 2.0, -dim.BUMP_WIDTH / 2.0)]
        groups.append(solid_group(f"bump_{side}", ends[0], ends[1]))
    return groups


def trenches() -> list[ObjGroup]:
    """Make a leg between bump and opening on each side, and an arm from the leg to the guardrail."""
    x, leg, arm = dim.TRENCH_X, dim.TRENCH_DEPTH / 2.0, dim.TRENCH_ARM_DEPTH / 2.0
    clear, bump_edge, top = dim.TRENCH_CLEAR_WIDTH, dim.TRENCH_CLEAR_WIDTH + dim.TRENCH_LEG_WIDTH, dim.TRENCH_HEIGHT
    groups = []
    for side, mirrored in (("left", True), ("right", False)):

        def across(a: float, b: float, mirrored: bool = mirrored) -> tuple[float, float]:
            return (dim.FIELD_WIDTH - b, dim.FIELD_WIDTH - a) if mirrored else (a, b)

        y0, y1 = across(clear, bump_edge)
        groups.append(box_group(f"trench_{side}_leg", (x - leg, y0, 0.0), (x + leg, y1, top)))
        y0, y1 = across(0.0, clear)
        groups.append(box_group(f"trench_{side}_arm", (x - arm, y0, dim.TRENCH_CLEAR_HEIGHT), (x + arm, y1, top)))
    return groups


def tower() -> list[ObjGroup]:
    """Make the base plate, two uprights with a brace each to the wall, and three rungs."""
    x, y = dim.TOWER_UPRIGHT_X, dim.TOWER_Y
    dx, dy = dim.TOWER_UPRIGHT_DEPTH / 2.0, dim.TOWER_UPRIGHT_THICKNESS / 2.0
    half = dim.TOWER_BASE_WIDTH / 2.0
    groups = [box_group("tower_base", (0.0, y - half, 0.0), (dim.TOWER_BASE_DEPTH, y + half, dim.TOWER_BASE_HEIGHT))]
    for side, post in zip(("right", "left"), dim.TOWER_UPRIGHT_YS, strict=True):
        base = dim.TOWER_BASE_HEIGHT
        groups.append(
            box_group(f"tower_upright_{side}", (x - dx, post - dy, base), (x + dx, post + dy, dim.TOWER_UPRIGHT_HEIGHT))
        )
        # estimate: the manual prints their height, not their thickness; as thick as the upright
        brace = (0.0, post - dy, dim.TOWER_BRACE_BOTTOM)
        groups.append(box_group(f"tower_brace_{side}", brace, (x - dx, post + dy, dim.TOWER_BRACE_TOP)))
    r, reach = dim.TOWER_RUNG_DIAMETER / 2.0, dim.TOWER_RUNG_LENGTH / 2.0
    for level, z in zip(("low", "mid", "high"), dim.TOWER_RUNG_HEIGHTS, strict=True):
        groups.append(box_group(f"tower_rung_{level}", (x - r, y - reach, z - r), (x + r, y + reach, z + r)))
    return groups


def depot() -> list[ObjGroup]:
    """Make three low bevelled barriers against the alliance wall, which is the fourth side."""
    x, y, b, h, bevel = (
        dim.DEPOT_DEPTH,
        dim.DEPOT_Y,
        dim.DEPOT_BARRIER_WIDTH,
        dim.DEPOT_BARRIER_HEIGHT,
        dim.DEPOT_BARRIER_BEVEL,
    )
    half = dim.DEPOT_WIDTH / 2.0
    return [
        ridge("depot_barrier_front", (x - b, y - half), (x, y + half), h, (bevel, 0.0)),
        ridge("depot_barrier_left", (0.0, y + half - b), (x - b, y + half), h, (0.0, bevel)),
        ridge("depot_barrier_right", (0.0, y - half), (x - b, y - half + b), h, (0.0, bevel)),
    ]


def groups() -> list[ObjGroup]:
    """Return the whole field in the order of the file."""
    own = [alliance_wall(), *hub(), *bumps(), *trenches(), *tower(), *depot()]
    blue = [ObjGroup(f"blue_{group.name}", group.vertices, group.faces) for group in own]
    red = [flipped_group(group, f"red_{group.name}", FIELD_SYMMETRY) for group in own]
    return [*perimeter(), *blue, *red]


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
