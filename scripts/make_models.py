"""Writes models/advantagescope: a robot with its moving parts, the field and fuel, for AdvantageScope and the browser.

    python scripts/make_models.py [FOLDER]

The robot's parts come in the order of its components (games/rebuilt/robot.py), each drawn about its own origin; the
field comes from the collision mesh, so that what is seen is what is hit. Everything is small: a stand-in for those
without CAD.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterable
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from trimesh.transformations import rotation_matrix, translation_matrix
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from games.rebuilt import dimensions as dim
from games.rebuilt.fuel import FUEL
from games.rebuilt.game import REBUILT
from games.rebuilt.robot import rebuilt_robot
from simcore.physics.obj import ObjGroup, read_obj
from simcore.show.glb import linear_rgba
from simcore.show.scope_assets import IN_FLIGHT, field_config
from simcore.show.scope_assets import RED as RED_MODEL

OUTPUT = Path(__file__).resolve().parents[1] / "models" / "advantagescope"
ROBOTS = {"Robot_Rebuilt": "blue", "Robot_RebuiltRed": "red"}
"""Folders, and the alliance of their bumpers."""
FIELD = "Field3d_SimcoreRebuilt"
ROBOT_NAME, FIELD_NAME = "Simcore Rebuilt", "Simcore REBUILT"

BLUE, RED = (30, 84, 183), (196, 40, 40)
CARPET, WHITE, BLACK, STEEL, DARK = (92, 97, 104), (235, 236, 238), (28, 30, 34), (158, 165, 174), (58, 63, 71)
GREEN, ORANGE, YELLOW, PURPLE = (38, 160, 96), (232, 124, 30), (255, 206, 20), (120, 86, 190)
CLEAR = (205, 222, 238, 60)

Color = tuple[int, ...]
Point = tuple[float, float, float]


# --- shapes -----------------------------------------------------------------------------------------------------------


def painted(mesh: trimesh.Trimesh, color: Color) -> trimesh.Trimesh:
    """The mesh in one color (RGB or RGBA as on a screen, 0 to 255), edges over 35 degrees sharp."""
    mesh = trimesh.graph.smooth_shade(mesh, angle=math.radians(35.0))
    rgba = np.array(linear_rgba(color))
    material = PBRMaterial(
        baseColorFactor=rgba.tolist(),
        metallicFactor=0.0,
        roughnessFactor=0.75,
        alphaMode="BLEND" if rgba[3] < 1.0 else "OPAQUE",
        doubleSided=bool(rgba[3] < 1.0),
    )
    mesh.visual = TextureVisuals(material=material)
    return mesh


def box(low: Point, high: Point, color: Color) -> trimesh.Trimesh:
    """An axis-aligned box between two corners [m]."""
    size = np.subtract(high, low)
    return painted(trimesh.creation.box(size, translation_matrix(np.add(low, size / 2.0))), color)


def bar(center: Point, size: Point, color: Color) -> trimesh.Trimesh:
    """An axis-aligned box about a center [m]."""
    return painted(trimesh.creation.box(size, translation_matrix(center)), color)


def wheel(
    radius: float, width: float, color: Color, mark: Color, *, axis: str = "y", at: Point = (0.0, 0.0, 0.0)
) -> list[trimesh.Trimesh]:
    """A cylinder about an axis, with a stripe along it and across its ends, so that one sees it turn."""
    turn = rotation_matrix(math.pi / 2.0, (1.0, 0.0, 0.0)) if axis == "y" else np.eye(4)
    place = translation_matrix(at) @ turn
    body = trimesh.creation.cylinder(radius, width, sections=20, transform=place)
    stripe = trimesh.creation.box((2.06 * radius, 0.3 * radius, 1.02 * width), place)
    return [painted(body, color), painted(stripe, mark)]


def arc(radius: float, thickness: float, width: float, start: float, end: float) -> trimesh.Trimesh:
    """A curved plate about the y axis, between two angles from -x towards +z [rad]."""
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


def save(path: Path, meshes: Iterable[trimesh.Trimesh], names: Iterable[str] | None = None) -> None:
    """Write meshes as one GLB, meters, z up."""
    meshes = list(meshes)
    scene = trimesh.Scene()
    for mesh, name in zip(meshes, names or (f"part_{i}" for i in range(len(meshes))), strict=True):
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    path.write_bytes(scene.export(file_type="glb", include_normals=True))


# --- robot ------------------------------------------------------------------------------------------------------------


def chassis(bumpers: Color) -> dict[str, trimesh.Trimesh]:
    """What does not move, with bumpers in a color. They are named so: the browser view paints them itself."""
    c = rebuilt_robot().body
    length, width, thick = c.bumper_length / 2.0, c.bumper_width / 2.0, c.bumper_thickness
    low, high = c.clearance + 0.02, c.bumper_top
    frame_x, frame_y = length - thick, width - thick
    meshes = {
        "bumper_front": box((frame_x, -width, low), (length, width, high), bumpers),
        "bumper_back": box((-length, -width, low), (-frame_x, width, high), bumpers),
        "bumper_left": box((-frame_x, frame_y, low), (frame_x, width, high), bumpers),
        "bumper_right": box((-frame_x, -width, low), (frame_x, -frame_y, high), bumpers),
        "front_mark": box((length, -0.11, 0.12), (length + 0.004, 0.11, 0.20), WHITE),
        "front_arrow": painted(arrow(length - thick / 2.0, high), YELLOW),
        "belly_pan": box((-frame_x, -frame_y, c.clearance), (frame_x, frame_y, c.clearance + 0.02), DARK),
        "battery": box((-0.27, 0.13, 0.09), (-0.10, 0.21, 0.26), BLACK),
        "electronics": box((-0.27, -0.24, 0.09), (-0.10, -0.12, 0.13), GREEN),
        "plate_left": box((0.06, 0.17, 0.08), (0.32, 0.176, 0.50), STEEL),
        "plate_right": box((0.06, -0.176, 0.08), (0.32, -0.17, 0.50), STEEL),
        "back_sheet": box((0.02, -0.17, 0.20), (0.026, 0.17, 0.44), CLEAR),
        "rail_left": bar((-0.15, 0.29, 0.30), (0.34, 0.03, 0.03), STEEL),
        "rail_right": bar((-0.15, -0.29, 0.30), (0.34, 0.03, 0.03), STEEL),
    }
    for i, (x, y) in enumerate(c.wheel_positions):
        tire, stripe = wheel(c.wheel_radius, 0.038, BLACK, DARK, at=(x, y, c.wheel_radius))
        meshes |= {f"drive_wheel_{i}": tire, f"drive_wheel_mark_{i}": stripe}
        meshes[f"swerve_module_{i}"] = bar((x, y, 0.13), (0.08, 0.08, 0.05), STEEL)
    return meshes


def arrow(x: float, z: float) -> trimesh.Trimesh:
    """A flat arrow that points forward [m]."""
    points = [(x - 0.035, -0.06), (x + 0.035, 0.0), (x - 0.035, 0.06)]
    return trimesh.convex.convex_hull([(*xy, height) for xy in points for height in (z, z + 0.005)])


def _intake() -> list[trimesh.Trimesh]:
    arms = [bar((-0.02, side * 0.345, 0.0), (0.24, 0.012, 0.09), ORANGE) for side in (-1, 1)]
    return [*arms, bar((0.06, 0.0, 0.0), (0.02, 0.68, 0.03), ORANGE)]


def _hopper() -> list[trimesh.Trimesh]:
    x, y, low, high = 0.25, 0.285, -0.04, 0.20
    sheets = [box((-x, side * y - 0.003, low), (x - 0.14, side * y + 0.003, high), (*PURPLE, 90)) for side in (-1, 1)]
    return [*sheets, box((-x, -y, 0.08), (-x + 0.006, y, high), (*PURPLE, 90))]


def _plate() -> list[trimesh.Trimesh]:
    disc = trimesh.creation.cylinder(0.2, 0.012, sections=32)
    fins = [trimesh.creation.box((0.19, 0.014, 0.02), rotation_matrix(a, (0, 0, 1))) for a in (0.0, 2.094, 4.189)]
    for fin, angle in zip(fins, (0.0, 2.094, 4.189), strict=True):
        fin.apply_translation((0.1 * math.cos(angle), 0.1 * math.sin(angle), 0.012))
    return [painted(disc, DARK), *(painted(fin, GREEN) for fin in fins)]


def _cone() -> list[trimesh.Trimesh]:
    mark = trimesh.creation.box((0.02, 0.11, 0.02), translation_matrix((0.0, 0.0, 0.02)))
    return [painted(trimesh.creation.cone(0.07, 0.09, sections=20), GREEN), painted(mark, WHITE)]


def _kicker() -> list[trimesh.Trimesh]:
    arms = trimesh.creation.box((0.10, 0.02, 0.03))
    return [*wheel(0.028, 0.05, BLACK, WHITE, axis="z"), painted(arms, ORANGE)]


def _hood() -> list[trimesh.Trimesh]:
    """Ends 20 degrees before -x, so that the fuel leaves straight up when the hood stands at 20 degrees."""
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


PARTS: dict[str, Callable[[], list[trimesh.Trimesh]]] = {
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
"""By the names of the robot's components."""


def robot_config(alliance: str) -> dict[str, Any]:
    """For AdvantageScope; the cameras are views from the robot, not the simulated ones."""
    return {
        "name": ROBOT_NAME + RED_MODEL * (alliance == "red"),
        "isFTC": False,
        "disableSimplification": True,
        "rotations": [],
        "position": [0, 0, 0],
        "cameras": [
            {
                "name": "Shooter",
                "rotations": [{"axis": "y", "degrees": -10}],
                "position": [0.3, 0.0, 0.65],
                "resolution": [1280, 720],
                "fov": 80,
            }
        ],
        "components": [{"zeroedRotations": [], "zeroedPosition": [0, 0, 0]} for _ in rebuilt_robot().components],
    }


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
"""By name of the element; the first that fits."""


def field_meshes() -> dict[str, trimesh.Trimesh]:
    """Carpet, tape, walls and every element of the collision mesh, field frame."""
    length, width = dim.FIELD_LENGTH, dim.FIELD_WIDTH
    meshes = {"carpet": box((-0.9, -0.6, -0.03), (length + 0.9, width + 0.6, -0.002), CARPET)}
    for group in read_obj(REBUILT.field.mesh):
        if "guardrail" in group.name or "alliance_wall" in group.name:
            continue  # 0.3 m thick for the engine; drawn thin below
        color = next((color for pattern, color in FIELD_COLORS if fnmatchcase(group.name, pattern)), STEEL)
        meshes[group.name] = painted(_mesh(group), color)
    rail = dim.GUARDRAIL_HEIGHT
    for side, y in (("right", 0.0), ("left", width)):
        meshes[f"guardrail_{side}"] = box((0.0, y - 0.006, 0.0), (length, y + 0.006, rail), CLEAR)
        meshes[f"guardrail_top_{side}"] = box((0.0, y - 0.02, rail - 0.04), (length, y + 0.02, rail), STEEL)
        meshes[f"guardrail_foot_{side}"] = box((0.0, y - 0.02, 0.0), (length, y + 0.02, 0.04), STEEL)
    plate = 36.8 * 0.0254
    zone = dim.ALLIANCE_ZONE_DEPTH
    for name, x, line, color in (("blue", 0.0, zone, BLUE), ("red", length, length - zone, RED)):
        outside = -0.05 if name == "blue" else 0.05
        low, high = sorted((x, x + outside))
        meshes[f"{name}_wall"] = box((low, 0.0, 0.0), (high, width, plate), (*(int(0.55 * c + 80) for c in color),))
        meshes[f"{name}_wall_sheet"] = box((low, 0.0, plate), (high, width, dim.ALLIANCE_WALL_HEIGHT), CLEAR)
        meshes[f"{name}_wall_rail"] = box((low, 0.0, plate - 0.03), (high, width, plate + 0.03), color)
        meshes[f"{name}_zone_tape"] = box((line - 0.025, 0.0, -0.002), (line + 0.025, width, 0.002), color)
        for i, y in enumerate(dim.HUB_EXIT_YS):
            face = dim.HUB_EXIT_X if name == "blue" else length - dim.HUB_EXIT_X
            z = dim.HUB_EXIT_Z
            meshes[f"{name}_hub_exit_{i}"] = box(
                (face - 0.004, y - 0.11, z - 0.11), (face + 0.004, y + 0.11, z + 0.11), BLACK
            )
    meshes["center_tape"] = box((length / 2 - 0.025, 0.0, -0.002), (length / 2 + 0.025, width, 0.002), WHITE)
    return meshes


def _mesh(group: ObjGroup) -> trimesh.Trimesh:
    return trimesh.Trimesh(group.vertices, group.triangles(), process=False)


# --- output -----------------------------------------------------------------------------------------------------------


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write readable JSON with a newline at its end."""
    path.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8", newline="\n")


def write_all(output: Path) -> None:
    """Write all folders."""
    field = output / FIELD
    for folder in (field, *(output / name for name in ROBOTS)):
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.glob("*.glb"):
            old.unlink()
    for name, alliance in ROBOTS.items():
        base = chassis({"blue": BLUE, "red": RED}[alliance])
        save(output / name / "model.glb", base.values(), base)
        for i, part in enumerate(rebuilt_robot().components):
            save(output / name / f"model_{i}.glb", PARTS[part.name]())
        write_json(output / name / "config.json", robot_config(alliance))
    meshes = field_meshes()
    for mesh in meshes.values():
        mesh.apply_transform(translation_matrix((-dim.FIELD_LENGTH / 2, -dim.FIELD_WIDTH / 2, 0.0)))
        mesh.apply_transform(rotation_matrix(math.pi, (0.0, 0.0, 1.0)))
    save(field / "model.glb", meshes.values(), meshes)
    radius = FUEL.bounding_radius
    save(field / "model_0.glb", [painted(trimesh.creation.icosphere(1, radius), YELLOW)])
    # a little larger, for those in the air are drawn among all fuel, too
    save(field / "model_1.glb", [painted(trimesh.creation.icosphere(1, 1.15 * radius), ORANGE)])
    pieces = (FUEL.name, FUEL.name + IN_FLIGHT)
    write_json(field / "config.json", field_config(FIELD_NAME, REBUILT.field, pieces, dim.DRIVER_STATIONS))


def main() -> int:
    """Write the folders, by default into the source tree."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=OUTPUT, help="default: %(default)s")
    output: Path = parser.parse_args().folder
    write_all(output)
    files = [path for path in output.rglob("*") if path.is_file()]
    print(f"{output}: {len(files)} files, {sum(path.stat().st_size for path in files) / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
