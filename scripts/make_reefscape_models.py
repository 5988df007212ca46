"""Write models/reefscape/advantagescope: a robot with its moving parts, the field, its cages, coral and algae.

    python scripts/make_reefscape_models.py [FOLDER]

They are for AdvantageScope and the browser view. The robot's parts are in the order of its components
(games/reefscape/robot.py), each drawn about its origin; the field is the collision mesh, so that the view shows what
robots hit. All models are small: a substitute for teams without CAD.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import trimesh
from model_parts import (
    BLACK,
    BLUE,
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
    rod,
    tape,
    wheel,
)  # fmt: skip
from scope_assets import IN_FLIGHT, field_config, write_field, write_robots
from trimesh.transformations import rotation_matrix

from games.reefscape import REEFSCAPE
from games.reefscape import dimensions as dim
from games.reefscape.field import FIELD_SIZE
from games.reefscape.pieces import ALGAE, CORAL
from games.reefscape.robot import CORAL_REACH, CORAL_TILT, PIVOT, reefscape_robot
from simcore.show.palette import rgb
from simcore.show.scope_layout import HANGING

ROBOT_NAME, FIELD_NAME = "Simcore Reefscape", "Simcore REEFSCAPE"

# --- robot ------------------------------------------------------------------------------------------------------------

_LOW, _TALL = 0.12, 0.92  # of the elevator's rails [m]: 1.04 m high at the bottom stop, 42 in are allowed


def body(bumpers: Color) -> dict[str, Any]:
    """Return the fixed parts: bumpers, drivetrain, the elevator's outer rails, and the funnel at the back."""
    x, z = PIVOT[0] - 0.06, _LOW + 0.5 * _TALL
    meshes = {
        **chassis(reefscape_robot().body, bumpers),
        "battery": box((-0.30, 0.16, 0.09), (-0.13, 0.24, 0.26), BLACK),
        "electronics": box((-0.30, -0.28, 0.09), (-0.13, -0.16, 0.13), GREEN),
        "elevator_top": bar((x - 0.035, 0.0, _LOW + _TALL - 0.02), (0.02, 0.50, 0.03), STEEL),
        "elevator_foot": bar((0.11, 0.0, _LOW), (0.02, 0.50, 0.03), STEEL),
    }
    for side, y in (("left", 0.235), ("right", -0.235)):
        meshes[f"rail_{side}"] = bar((x, y, z), (0.05, 0.025, _TALL), STEEL)
        corners = [(-0.46, 1.00), (-0.46, 0.94), (-0.16, 0.60), (-0.13, 0.60), (-0.13, 0.68)]
        points = [(px, math.copysign(0.32, y) + dy, pz) for px, pz in corners for dy in (-0.004, 0.004)]
        meshes[f"funnel_{side}"] = painted(trimesh.convex.convex_hull(points), (*ORANGE, 130))
    floor = [
        (px, py, pz + dz) for px, pz in ((-0.46, 0.94), (-0.16, 0.60)) for py in (-0.32, 0.32) for dz in (0, 0.006)
    ]
    meshes["funnel_floor"] = painted(trimesh.convex.convex_hull(floor), (*ORANGE, 130))
    return meshes


def _stage(y: float) -> list[Any]:
    """Make a frame of the elevator, relative to the arm's pivot at the bottom stop."""
    x, low = -0.06, _LOW - PIVOT[2] + 0.02
    rails = [bar((x, side * y, low + 0.5 * _TALL - 0.02), (0.04, 0.02, _TALL - 0.04), STEEL) for side in (-1, 1)]
    return [*rails, bar((x - 0.03, 0.0, low + _TALL - 0.06), (0.02, 2 * y, 0.03), DARK)]


def _carriage() -> list[Any]:
    plates = [box((-0.09, side * 0.135 - 0.006, -0.16), (0.03, side * 0.135 + 0.006, 0.05), ORANGE) for side in (-1, 1)]
    return [*plates, bar((-0.075, 0.0, -0.13), (0.02, 0.26, 0.05), ORANGE), _axle(0.012, 0.28, DARK)]


def _arm() -> list[Any]:
    """Make two plates with a channel for the coral, and a fork for the algae at their end."""
    parts = []
    for y in (-0.075, 0.075):
        parts.append(bar((0.5 * CORAL_REACH, y, 0.0), (CORAL_REACH, 0.008, 0.045), PURPLE))
        guide = trimesh.creation.box((0.10, 0.008, 0.20), rotation_matrix(-CORAL_TILT, (0.0, 1.0, 0.0)))
        guide.apply_translation((CORAL_REACH, y, 0.0))
        parts.append(painted(guide, PURPLE))
        parts.append(rod((0.36, 1.3 * y, -0.03), (WHEEL[0], 1.3 * y, WHEEL[2]), 0.009, STEEL))
    return [*parts, _axle(0.02, 0.15, DARK), bar((0.15, 0.0, 0.0), (0.03, 0.15, 0.03), PURPLE)]


def _axle(radius: float, width: float, color: Color) -> Any:
    return rod((0.0, -0.5 * width, 0.0), (0.0, 0.5 * width, 0.0), radius, color)


def _hook() -> list[Any]:
    """Make a hook about its bend, where it hangs."""
    mast = bar((-0.045, 0.0, -0.12), (0.025, 0.04, 0.36), STEEL)
    return [
        mast,
        bar((-0.01, 0.0, 0.045), (0.09, 0.04, 0.02), YELLOW),
        bar((0.03, 0.0, 0.02), (0.02, 0.04, 0.06), YELLOW),
    ]


COMPONENTS = reefscape_robot().components
WHEEL = next(part.joints[-1].origin for part in COMPONENTS if part.name == "algae wheel")
"""Axle of the algae wheel in the frame of the arm [m]."""
PARTS: dict[str, Callable[[], list[Any]]] = {
    "elevator stage 1": lambda: _stage(0.205),
    "elevator stage 2": lambda: _stage(0.172),
    "carriage": _carriage,
    "arm": _arm,
    "coral roller": lambda: wheel(0.025, 0.13, BLACK, GREEN),
    "algae wheel": lambda: wheel(0.05, 0.19, BLACK, GREEN),
    "funnel roller": lambda: wheel(0.025, 0.60, BLACK, GREEN),
    "hook": _hook,
}
"""Functions that make the parts, by the names of the robot's components."""
CAMERA = {
    "name": "Arm",
    "rotations": [{"axis": "y", "degrees": 10}],
    "position": [-0.25, 0.0, 1.1],
    "resolution": [1280, 720],
    "fov": 80,
}
"""View from the robot, not a simulated camera."""

# --- field ------------------------------------------------------------------------------------------------------------

PIPE = (206, 198, 224)
FIELD_COLORS: tuple[tuple[str, Color], ...] = (
    ("*_reef_core", DARK),
    ("blue_reef_trough_*", BLUE),
    ("red_reef_trough_*", RED),
    ("*_reef_*", PIPE),
    ("blue_net_floor", (*BLUE, 110)),
    ("red_net_floor", (*RED, 110)),
    ("blue_net_*", BLUE),
    ("red_net_*", RED),
    ("*_barge_*", DARK),
    ("*_station_*_lip", STEEL),
    ("*_station_*_chute", STEEL),
    ("blue_station_*", (96, 124, 178)),
    ("red_station_*", (178, 108, 106)),
    ("blue_processor_*", BLUE),
    ("red_processor_*", RED),
)
"""Colors by name pattern of the element; the first match wins."""


def field_meshes() -> dict[str, Any]:
    """Return carpet, tape, walls and every element of the collision mesh, field frame."""
    length, width = FIELD_SIZE
    meshes = {"carpet": carpet(FIELD_SIZE)}
    meshes |= field_parts(REEFSCAPE.field.mesh, FIELD_COLORS, ("guardrail", "alliance_wall"))
    (corner_x, corner_y), yaw = dim.STATION_FACE_CENTER, math.radians(dim.STATION_YAW_DEG)
    near = corner_x + corner_y * math.tan(yaw)  # where a station's face meets the guardrail, and
    up = corner_y + corner_x / math.tan(yaw)  # the alliance wall
    half = 0.5 * dim.PROCESSOR_OPENING_WIDTH + dim.PROCESSOR_FRAME_WIDTH
    for side, y, middle in (("right", 0.0, dim.PROCESSOR_X), ("left", width, length - dim.PROCESSOR_X)):
        meshes |= guardrail(f"{side}_blue", y, near, middle - half, dim.GUARDRAIL_HEIGHT)
        meshes |= guardrail(f"{side}_red", y, middle + half, length - near, dim.GUARDRAIL_HEIGHT)
    zone, barge = 0.5 * dim.BARGE_ZONE_DEPTH, dim.FIELD_CENTER[0]
    for name, x, color in (("blue", 0.0, BLUE), ("red", length, RED)):
        meshes |= alliance_wall(name, x, up, width - up, dim.ALLIANCE_WALL_HEIGHT)
        for what, mesh in _tapes(color, zone, barge, width).items():
            if name == "red":
                mesh.vertices = (length, width, 0.0) - mesh.vertices * (1.0, 1.0, -1.0)  # a half turn
            meshes[f"{name}_{what}"] = mesh
    return meshes


def _tapes(color: Color, zone: float, barge: float, width: float) -> dict[str, Any]:
    """Return the blue half's starting line, barge zone, reef zone and marks of staged pieces."""
    line, half = dim.STARTING_LINE_X, 0.025
    found = {
        "starting_line": tape((line - dim.STARTING_LINE_WIDTH, 0.0), (line, width), BLACK),
        "barge_zone": tape(
            (barge - zone, width - dim.BARGE_ZONE_WIDTH), (barge + zone, width - dim.BARGE_ZONE_WIDTH + 2 * half), color
        ),
    }
    side = dim.REEF_ZONE_APOTHEM * math.tan(math.radians(30.0))
    for face, yaw_deg in enumerate(dim.REEF_FACE_YAWS_DEG):
        strip = tape((dim.REEF_ZONE_APOTHEM - 2 * half, -side), (dim.REEF_ZONE_APOTHEM, side), color)
        strip.apply_transform(rotation_matrix(math.radians(yaw_deg), (0.0, 0.0, 1.0)))
        strip.apply_translation((*dim.REEF_CENTER, 0.0))
        found[f"reef_zone_{face}"] = strip
    for number, y in enumerate(dim.MARK_YS):
        found[f"mark_{number}"] = tape((dim.MARK_X - half, y - half), (dim.MARK_X + half, y + half), WHITE)
    return found


# --- pieces and cages -------------------------------------------------------------------------------------------------


def coral(color: Color) -> Any:
    """Make a tube along z."""
    tube = trimesh.creation.annulus(
        0.5 * dim.CORAL_INNER_DIAMETER, 0.5 * dim.CORAL_OUTER_DIAMETER, dim.CORAL_LENGTH, sections=20
    )
    return painted(tube, color)


def cage() -> Any:
    """Make four pipes between two plates, and the chain of a deep cage, about the center of the pipes."""
    half, tall, r = 0.5 * dim.CAGE_SIZE, 0.5 * dim.CAGE_HEIGHT, 0.5 * 1.315 * 0.0254  # 1 in Sch 40 pipe
    pipes = [(x, y) for x in (-half + r, half - r) for y in (-half + r, half - r)]
    meshes = [trimesh.creation.cylinder(r, segment=((x, y, -tall), (x, y, tall)), sections=10) for x, y in pipes]
    for z in (-tall, tall):
        plate = trimesh.creation.box((dim.CAGE_SIZE, dim.CAGE_SIZE, 0.012))
        plate.apply_translation((0.0, 0.0, z - math.copysign(0.006, z)))
        meshes.append(plate)
    chain = dim.TRUSS_BOTTOM - dim.CAGE_DEEP_BOTTOM - dim.CAGE_HEIGHT
    meshes.append(trimesh.creation.cylinder(0.008, segment=((0, 0, tall), (0, 0, tall + chain)), sections=6))
    return painted(trimesh.util.concatenate(meshes), YELLOW)


def write_all(output: Path) -> None:
    """Write all folders."""
    parts = [PARTS[part.name]() for part in COMPONENTS]
    write_robots(output / "Robot_Reefscape", ROBOT_NAME, body, parts, [CAMERA])
    radius = ALGAE.bounding_radius
    pieces = {
        CORAL.name: coral(rgb(CORAL.color)),
        CORAL.name + IN_FLIGHT: coral(ORANGE),
        ALGAE.name: painted(trimesh.creation.icosphere(2, radius), rgb(ALGAE.color)),
        ALGAE.name + IN_FLIGHT: painted(trimesh.creation.icosphere(2, radius), ORANGE),
        HANGING: cage(),
    }
    for name in (CORAL.name, ALGAE.name):
        pieces[name + IN_FLIGHT].apply_scale(1.05)  # those in the air are also drawn among all of their kind
    config = field_config(FIELD_NAME, REEFSCAPE.field, list(pieces))
    write_field(output / "Field3d_SimcoreReefscape", field_meshes(), list(pieces.values()), config)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=REEFSCAPE.models, help="default: %(default)s")
    write_all(parser.parse_args().folder)
