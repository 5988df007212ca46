"""Shapes for models, and the folders in which they are written: for AdvantageScope and the browser view.

Colors are screen colors, RGB or RGBA, 0 to 255. Lengths are in meters, z up.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
import trimesh.transformations
import trimesh.visual

from simcore.robot.chassis_config import ChassisConfig
from simcore.show.palette import rgb
from simcore.show.solids import chassis_boxes
from simcore.units import inches
from simcore.world.obj import read_obj
from simcore.world.shapes import Box, Compound, Cylinder, Hull, Mesh, Shape, Sphere

__all__ = [
    "BLACK", "BLUE", "CARPET", "CLEAR", "DARK", "GREEN", "ORANGE", "PURPLE", "RED", "STEEL", "WHITE", "YELLOW",
    "Color", "Point", "alliance_wall", "bar", "box", "carpet", "chassis", "emptied_folder", "field_parts", "guardrail",
    "painted", "rod", "shape_mesh", "tape", "wheel", "write_json", "write_model",
]  # fmt: skip

BLUE, RED = (30, 84, 183), (196, 40, 40)
CARPET, WHITE, BLACK, STEEL, DARK = (92, 97, 104), (235, 236, 238), (28, 30, 34), (158, 165, 174), (58, 63, 71)
GREEN, ORANGE, YELLOW, PURPLE = (38, 160, 96), (232, 124, 30), (255, 206, 20), (120, 86, 190)
CLEAR = (205, 222, 238, 60)

_turns: Any = trimesh.transformations  # without types, like the next
_visual: Any = trimesh.visual

Color = tuple[int, ...]
Point = tuple[float, float, float]


def linear_rgba(color: Color) -> list[float]:
    """Convert a screen color (RGB or RGBA, 0 to 255) to glTF's linear color, 0 to 1.

    Source: IEC 61966-2-1 (sRGB).

    >>> [round(c, 3) for c in linear_rgba((255, 128, 0))]
    [1.0, 0.216, 0.0, 1.0]
    """
    red, green, blue, alpha = (*(c / 255.0 for c in color), 1.0)[:4]
    return [*(c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (red, green, blue)), alpha]


def painted(mesh: Any, color: Color) -> Any:
    """Return the mesh as a `trimesh.Trimesh` in one color, with edges over 35 degrees sharp."""
    mesh = trimesh.graph.smooth_shade(mesh, angle=math.radians(35.0))
    rgba = np.array(linear_rgba(color))
    material = _visual.material.PBRMaterial(
        baseColorFactor=rgba.tolist(),
        metallicFactor=0.0,
        roughnessFactor=0.75,
        alphaMode="BLEND" if rgba[3] < 1.0 else "OPAQUE",
        doubleSided=bool(rgba[3] < 1.0),
    )
    mesh.visual = _visual.TextureVisuals(material=material)
    return mesh


def box(low: Point, high: Point, color: Color) -> Any:
    """Make an axis-aligned box between two corners."""
    size = np.subtract(high, low)
    return painted(trimesh.creation.box(size, _turns.translation_matrix(np.add(low, size / 2.0))), color)


def bar(center: Point, size: Point, color: Color) -> Any:
    """Make an axis-aligned box about a center."""
    return painted(trimesh.creation.box(size, _turns.translation_matrix(center)), color)


def rod(start: Point, end: Point, radius: float, color: Color) -> Any:
    """Make a cylinder between two points."""
    return painted(trimesh.creation.cylinder(radius, segment=(start, end), sections=12), color)


def wheel(
    radius: float, width: float, color: Color, mark: Color, *, axis: str = "y", at: Point = (0.0, 0.0, 0.0)
) -> list[Any]:
    """Make a cylinder about an axis, with a stripe along it and across its ends that shows its rotation."""
    turn = _turns.rotation_matrix(math.pi / 2.0, (1.0, 0.0, 0.0)) if axis == "y" else np.eye(4)
    place = _turns.translation_matrix(at) @ turn
    body = trimesh.creation.cylinder(radius, width, sections=20, transform=place)
    stripe = trimesh.creation.box((2.06 * radius, 0.3 * radius, 1.02 * width), place)
    return [painted(body, color), painted(stripe, mark)]


def shape_mesh(shape: Shape) -> Any:
    """Convert a collision shape to a `trimesh.Trimesh` about its origin."""
    if isinstance(shape, Compound):
        parts = []
        for part in shape.parts:
            parts.append(shape_mesh(part.shape))
            parts[-1].apply_translation(part.offset)
        return trimesh.util.concatenate(parts)
    if isinstance(shape, Sphere):
        return trimesh.creation.icosphere(subdivisions=1, radius=shape.radius)
    if isinstance(shape, Cylinder):
        return trimesh.creation.cylinder(shape.radius, shape.height, sections=20)
    if isinstance(shape, Box):
        return trimesh.creation.box(shape.size)
    if isinstance(shape, Hull):
        return trimesh.convex.convex_hull(shape.points)
    assert isinstance(shape, Mesh)
    return trimesh.Trimesh(shape.vertices, shape.faces, process=False)


def chassis(body: ChassisConfig, color: Color) -> dict[str, Any]:
    """Return frame, wheels, and bumpers in a color. The browser view recognizes and paints them by their names."""
    meshes = {
        name: box(low, high, rgb(paint) if paint else color) for name, (low, high, paint) in chassis_boxes(body).items()
    }
    meshes["front_arrow"] = painted(_arrow((body.bumper_length - body.bumper_thickness) / 2.0, body.bumper_top), YELLOW)
    for i, (x, y) in enumerate(body.wheel_positions):
        tire, stripe = wheel(body.wheel_radius, 0.038, BLACK, DARK, at=(x, y, body.wheel_radius))
        meshes |= {f"drive_wheel_{i}": tire, f"drive_wheel_mark_{i}": stripe}
    return meshes


def field_parts(mesh: Path, colors: Iterable[tuple[str, Color]], leave_out: Iterable[str] = ()) -> dict[str, Any]:
    """Return the elements of a field's collision mesh by name, so that the view shows what robots hit.

    Args:
        mesh: OBJ file.
        colors: Colors by name pattern (`*`, `?`); the first match wins.
        leave_out: Parts of names of elements that are thick for the engine, and drawn thin by `guardrail` and
            `alliance_wall`.
    """
    found, patterns = {}, [*colors, ("*", STEEL)]
    for group in read_obj(mesh):
        if not any(part in group.name for part in leave_out):
            color = next(color for pattern, color in patterns if fnmatchcase(group.name, pattern))
            found[group.name] = painted(trimesh.Trimesh(group.vertices, group.triangles(), process=False), color)
    return found


def carpet(size: tuple[float, float]) -> Any:
    """Make the carpet under a field of a length and width."""
    return box((-0.9, -0.6, -0.03), (size[0] + 0.9, size[1] + 0.6, -0.002), CARPET)


def guardrail(name: str, y: float, start: float, end: float, height: float) -> dict[str, Any]:
    """Make a guardrail along x from a start to an end: a clear sheet between two rails."""
    return {
        f"guardrail_{name}": box((start, y - 0.006, 0.0), (end, y + 0.006, height), CLEAR),
        f"guardrail_top_{name}": box((start, y - 0.02, height - 0.04), (end, y + 0.02, height), STEEL),
        f"guardrail_foot_{name}": box((start, y - 0.02, 0.0), (end, y + 0.02, 0.04), STEEL),
    }


def alliance_wall(alliance: str, x: float, start: float, end: float, height: float) -> dict[str, Any]:
    """Make an alliance wall at x, along y from a start to an end: diamond plate under a clear sheet."""
    plate, color = inches(36.8), BLUE if alliance == "blue" else RED
    low, high = sorted((x, x + (-0.05 if alliance == "blue" else 0.05)))
    metal = tuple(int(0.55 * c + 80) for c in color)
    return {
        f"{alliance}_wall": box((low, start, 0.0), (high, end, plate), metal),
        f"{alliance}_wall_sheet": box((low, start, plate), (high, end, height), CLEAR),
        f"{alliance}_wall_rail": box((low, start, plate - 0.03), (high, end, plate + 0.03), color),
    }


def tape(low: tuple[float, float], high: tuple[float, float], color: Color) -> Any:
    """Make a tape on the carpet, between two corners."""
    return box((*low, -0.002), (*high, 0.002), color)


def _arrow(x: float, z: float) -> Any:
    """Make a flat arrow that points forward."""
    points = [(x - 0.035, -0.06), (x + 0.035, 0.0), (x - 0.035, 0.06)]
    return trimesh.convex.convex_hull(np.array([(*xy, height) for xy in points for height in (z, z + 0.005)]))


# --- folders ----------------------------------------------------------------------------------------------------------


def write_model(path: Path, meshes: Mapping[str, Any] | Iterable[Any]) -> None:
    """Write meshes, by name or numbered, as one GLB file."""
    named = meshes if isinstance(meshes, Mapping) else {f"part_{i}": mesh for i, mesh in enumerate(meshes)}
    scene: Any = trimesh.Scene()
    for name, mesh in named.items():
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    path.write_bytes(scene.export(file_type="glb", include_normals=True))


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write readable JSON with a newline at its end."""
    path.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8", newline="\n")


def emptied_folder(folder: Path) -> None:
    """Make a folder for a model, and delete the GLB files of an old one."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.glb"):
        old.unlink()
