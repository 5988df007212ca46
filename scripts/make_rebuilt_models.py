"""Write models/rebuilt/advantagescope: a robot with its moving parts, the field and fuel.

    python scripts/make_rebuilt_models.py [FOLDER]

They are for AdvantageScope and the browser view. The robot's parts are in the order of its components
(games/rebuilt/robot.py), each drawn about its origin; the field is the collision mesh, so that the view shows what
robots hit. All models are small: a substitute for teams without CAD.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from model_parts import (
    BLACK,
    BLUE,
    CLEAR,
    DARK,
    GREEN,
    ORANGE,
    PURPLE,
    RED,
    STEEL,
    WHITE,
    YELLOW,
    Color,
    alliance_wall,
    bar,
    box,
    carpet,
    chassis,
    field_parts,
    guardrail,
    painted,
    tape,
    wheel,
)  # fmt: skip
from scope_assets import IN_FLIGHT, field_config, write_field, write_robots
from trimesh.transformations import rotation_matrix, translation_matrix

from games.rebuilt import REBUILT
from games.rebuilt import dimensions as dim
from games.rebuilt.field import FIELD_SIZE
from games.rebuilt.fuel import FUEL
from games.rebuilt.robot import rebuilt_robot

ROBOT_NAME, FIELD_NAME = "Simcore Rebuilt", "Simcore REBUILT"


def arc(radius: float, thickness: float, width: float, start: float, end: float) -> Any:
    """Make a curved plate about the y axis, between two angles from -x towards +z [rad]."""
    angles = np.linspace(start, end, 9)
    rings = [
        [(-r * math.cos(a), y, r * math.sin(a)) for r, y in _corners(radius, thickness, width / 2.0)] for a in angles
    ]
    faces = [(0, 1, 2), (0, 2, 3)]
    last = 4 * (len(rings) - 1)
    faces += [(last + c, last + b, last + a) for a, b, c in faces[:2]]
    for i in range(0, last, 4):
        for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)):
            faces += [(i + a, i + 4 + b, i + b), (i + a, i + 4 + a, i + 4 + b)]
    mesh = trimesh.Trimesh(np.array(rings).reshape(-1, 3), faces)
    mesh.fix_normals()
    return mesh


def _corners(radius: float, thickness: float, half: float) -> list[tuple[float, float]]:
    return [(radius, -half), (radius, half), (radius + thickness, half), (radius + thickness, -half)]


# --- robot ------------------------------------------------------------------------------------------------------------


def body(bumpers: Color) -> dict[str, Any]:
    """Return the fixed parts."""
    return {
        **chassis(rebuilt_robot().body, bumpers),
        "battery": box((-0.27, 0.13, 0.09), (-0.10, 0.21, 0.26), BLACK),
        "electronics": box((-0.27, -0.24, 0.09), (-0.10, -0.12, 0.13), GREEN),
        "plate_left": box((0.06, 0.17, 0.08), (0.32, 0.176, 0.50), STEEL),
        "plate_right": box((0.06, -0.176, 0.08), (0.32, -0.17, 0.50), STEEL),
        "back_sheet": box((0.02, -0.17, 0.20), (0.026, 0.17, 0.44), CLEAR),
        "rail_left": bar((-0.15, 0.29, 0.30), (0.34, 0.03, 0.03), STEEL),
        "rail_right": bar((-0.15, -0.29, 0.30), (0.34, 0.03, 0.03), STEEL),
    }


def _intake() -> list[Any]:
    arms = [bar((-0.02, side * 0.345, 0.0), (0.24, 0.012, 0.09), ORANGE) for side in (-1, 1)]
    return [*arms, bar((0.06, 0.0, 0.0), (0.02, 0.68, 0.03), ORANGE)]


def _hopper() -> list[Any]:
    x, y, low, high = 0.25, 0.285, -0.04, 0.44  # the room of 50 fuel ends at 0.46
    sheets = [box((-x, side * y - 0.003, low), (x - 0.14, side * y + 0.003, high), (*PURPLE, 90)) for side in (-1, 1)]
    return [*sheets, box((-x, -y, 0.08), (-x + 0.006, y, high), (*PURPLE, 90))]


def _plate() -> list[Any]:
    disc = trimesh.creation.cylinder(0.2, 0.012, sections=32)
    fins = [trimesh.creation.box((0.19, 0.014, 0.02), rotation_matrix(a, (0, 0, 1))) for a in (0.0, 2.094, 4.189)]
    for fin, angle in zip(fins, (0.0, 2.094, 4.189), strict=True):
        fin.apply_translation((0.1 * math.cos(angle), 0.1 * math.sin(angle), 0.012))
    return [painted(disc, DARK), *(painted(fin, GREEN) for fin in fins)]


def _cone() -> list[Any]:
    mark = trimesh.creation.box((0.02, 0.11, 0.02), translation_matrix((0.0, 0.0, 0.02)))
    return [painted(trimesh.creation.cone(0.07, 0.09, sections=20), GREEN), painted(mark, WHITE)]


def _kicker() -> list[Any]:
    arms = trimesh.creation.box((0.10, 0.02, 0.03))
    return [*wheel(0.028, 0.05, BLACK, WHITE, axis="z"), painted(arms, ORANGE)]


def _hood() -> list[Any]:
    """Make the hood; it ends 20 degrees before -x, so that fuel leaves straight up at a hood angle of 20 degrees."""
    shell = painted(arc(0.195, 0.008, 0.32, math.radians(-52.0), math.radians(-20.0)), ORANGE)
    sides = []
    for y in (-0.155, 0.155):
        plate = trimesh.convex.convex_hull(
            [
                (x, y + side * 0.003, z)
                for side in (-1, 1)
                for x, z in [(0.02, 0.02), (0.02, -0.02)]
                + [(-0.195 * math.cos(a), 0.195 * math.sin(a)) for a in np.radians((-52.0, -36.0, -20.0))]
            ]
        )
        sides.append(painted(plate, (*ORANGE, 130)))
    return [shell, *sides]


PARTS: dict[str, Callable[[], list[Any]]] = {
    "intake": _intake,
    "hopper": _hopper,
    "intake roller, lower": lambda: wheel(0.027, 0.66, BLACK, GREEN),
    "intake roller, upper": lambda: wheel(0.027, 0.66, BLACK, GREEN),
    "hopper roller": lambda: wheel(0.02, 0.5, BLACK, GREEN),
    "spindexer plate": _plate,
    "spindexer cone": _cone,
    "spindexer kicker": _kicker,
    "feeder wheel, lower left": lambda: wheel(0.03, 0.04, DARK, YELLOW),
    "feeder wheel, lower right": lambda: wheel(0.03, 0.04, DARK, YELLOW),
    "feeder wheel, upper left": lambda: wheel(0.03, 0.04, DARK, YELLOW),
    "feeder wheel, upper right": lambda: wheel(0.03, 0.04, DARK, YELLOW),
    "hood": _hood,
    "shooter wheel, left": lambda: wheel(0.05, 0.06, BLACK, YELLOW),
    "shooter wheel, right": lambda: wheel(0.05, 0.06, BLACK, YELLOW),
    "shooter backspin roller": lambda: wheel(0.02, 0.3, BLACK, GREEN),
}
"""Functions that make the parts, by the names of the robot's components."""


CAMERA = {
    "name": "Shooter",
    "rotations": [{"axis": "y", "degrees": -10}],
    "position": [0.3, 0.0, 0.65],
    "resolution": [1280, 720],
    "fov": 80,
}
"""View from the robot, not a simulated camera."""


# --- field ------------------------------------------------------------------------------------------------------------

FIELD_COLORS: tuple[tuple[str, Color], ...] = (
    ("*_hub_base", (82, 88, 98)),
    ("*_hub_backboard", (225, 228, 232, 90)),
    ("blue_hub_*", BLUE),
    ("red_hub_*", RED),
    ("blue_bump_*", (52, 74, 118)),
    ("red_bump_*", (118, 56, 58)),
    ("*_trench_*_arm", STEEL),
    ("*_trench_*_leg", (112, 118, 127)),
    ("*_tower_base", DARK),
    ("*_tower_*", STEEL),
    ("blue_depot_*", BLUE),
    ("red_depot_*", RED),
)
"""Colors by name pattern of the element; the first match wins."""


def field_meshes() -> dict[str, Any]:
    """Return carpet, tape, walls and every element of the collision mesh, field frame."""
    length, width = FIELD_SIZE
    meshes = {"carpet": carpet(FIELD_SIZE)}
    meshes |= field_parts(REBUILT.field.mesh, FIELD_COLORS, ("guardrail", "alliance_wall"))
    for side, y in (("right", 0.0), ("left", width)):
        meshes |= guardrail(side, y, 0.0, length, dim.GUARDRAIL_HEIGHT)
    zone = dim.ALLIANCE_ZONE_DEPTH
    for name, x, line, color in (("blue", 0.0, zone, BLUE), ("red", length, length - zone, RED)):
        meshes |= alliance_wall(name, x, 0.0, width, dim.ALLIANCE_WALL_HEIGHT)
        meshes[f"{name}_zone_tape"] = tape((line - 0.025, 0.0), (line + 0.025, width), color)
        face = dim.HUB_EXIT_X if name == "blue" else length - dim.HUB_EXIT_X
        half = 0.5 * dim.HUB_EXIT_WIDTH
        low = (face - 0.004, dim.HUB_CENTER[1] - half, dim.HUB_EXIT_BOTTOM)
        high = (face + 0.004, dim.HUB_CENTER[1] + half, dim.HUB_EXIT_TOP)
        meshes[f"{name}_hub_exit"] = box(low, high, BLACK)
    meshes["center_tape"] = tape((length / 2 - 0.025, 0.0), (length / 2 + 0.025, width), WHITE)
    return meshes


# --- output -----------------------------------------------------------------------------------------------------------


def write_all(output: Path) -> None:
    """Write all folders."""
    parts = [PARTS[part.name]() for part in rebuilt_robot().components]
    write_robots(output / "Robot_Rebuilt", ROBOT_NAME, body, parts, [CAMERA])
    radius = FUEL.bounding_radius
    pieces = {
        FUEL.name: painted(trimesh.creation.icosphere(1, radius), YELLOW),
        # slightly larger, because fuel in the air is also drawn among all fuel
        FUEL.name + IN_FLIGHT: painted(trimesh.creation.icosphere(1, 1.15 * radius), ORANGE),
    }
    config = field_config(FIELD_NAME, REBUILT.field, list(pieces), dim.DRIVER_STATIONS)
    write_field(output / "Field3d_SimcoreRebuilt", field_meshes(), list(pieces.values()), config)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=REBUILT.models, help="default: %(default)s")
    write_all(parser.parse_args().folder)
