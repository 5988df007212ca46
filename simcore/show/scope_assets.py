"""Plain models of any game for AdvantageScope: its field as the engine has it, its pieces, a robot in blue and in red.

For a game that has no models of its own yet: what is seen is what is hit.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import OutputError
from simcore.match.camera_rig import tag_layout
from simcore.physics.shapes import Box, Compound, Cylinder, HalfSpace, Hull, Mesh, Shape, Sphere
from simcore.robot.chassis_config import ChassisConfig
from simcore.show.glb import linear_rgba
from simcore.show.palette import flat, rgb, tint
from simcore.typing import FloatArray
from simcore.units import inches

if TYPE_CHECKING:
    from simcore.match.game import FieldDefinition, Game

__all__ = ["IN_FLIGHT", "RED", "april_tags", "field_config", "to_model", "write_assets"]

IN_FLIGHT = " in flight"
"""What follows the name of a piece in that of its model in the air, if the field has one."""
RED = " (red)"
"""What follows the name of a robot in that of its model with red bumpers, if there is one."""

_BLUE, _RED, _CARPET, _FRAME = "#1e54b7", "#c42828", "#5c6168", "#3a3f47"
_AIR = "#e87c1e"
_STATION_SPACING = inches(69.0)  # AdvantageScope's own, for a field whose stations are not given
_PART = {"rotations": [], "position": [0, 0, 0]}


def write_assets(game: Game, folder: Path) -> list[Path]:
    """Write `Field3d_...` and two `Robot_...` folders, for AdvantageScope's custom assets folder.

    Returns:
        The three folders.

    Raises:
        OutputError: They cannot be written.
    """
    word = re.sub(r"\W", "", game.name.title())
    field, robot, red = folder / f"Field3d_{word}", folder / f"Robot_{word}", folder / f"Robot_{word}Red"
    name = f"Simcore {game.heading}"
    size = game.field.size
    body = game.robot().body
    try:
        for path in (field, robot, red):
            path.mkdir(parents=True, exist_ok=True)
        length, width = size
        carpet = Box(size=(length + 1.8, width + 1.2, 0.03))
        meshes = {"carpet": _painted(carpet, _CARPET, (length / 2.0, width / 2.0, -0.017))}
        for element in game.field.load().elements:
            if not isinstance(element.shape, HalfSpace):
                meshes[element.name] = _painted(element.shape, flat(tint(element.name)[0]), element.position)
        for mesh in meshes.values():
            mesh.vertices = to_model(mesh.vertices, size)  # a half turn: windings stay
        _save(field / "model.glb", meshes)
        pieces: list[str] = []
        for supply in game.pieces:
            kind = supply.kind
            for what, color, scale in ((kind.name, kind.color, 1.0), (kind.name + IN_FLIGHT, _AIR, 1.1)):
                mesh = _painted(kind.shape, color)
                mesh.apply_scale(scale)  # drawn over what is drawn among all pieces, too
                _save(field / f"model_{len(pieces)}.glb", {"piece": mesh})
                pieces.append(what)
        _write_json(field / "config.json", field_config(name, game.field, pieces))
        for path, color, suffix in ((robot, _BLUE, ""), (red, _RED, RED)):
            _save(path / "model.glb", _robot_meshes(body, color))
            config = {"name": name + suffix, "isFTC": False, "disableSimplification": True, **_PART}
            _write_json(path / "config.json", {**config, "cameras": [], "components": []})
    except OSError as error:
        raise OutputError(f"cannot write models to {str(folder)!r}: {error.strerror or error}") from error
    return [field, robot, red]


def field_config(
    name: str,
    field: FieldDefinition,
    pieces: Sequence[str],
    stations: Sequence[tuple[float, float]] = (),
) -> dict[str, Any]:
    """The `config.json` of a field; without `isFTC` AdvantageScope skips the folder in silence.

    Args:
        name: As the 3D tab lists it.
        field: Its size, symmetry and tags.
        pieces: Names of the models of pieces, in their order.
        stations: Middles of blue's driver stations 1 to 3, field frame [m]; none: evenly behind the wall.
    """
    length, width = field.size
    blue = stations or [(0.0, width / 2.0 + offset * _STATION_SPACING) for offset in (1.0, 0.0, -1.0)]
    red = sorted((field.symmetry.flip_point(*station) for station in blue), key=lambda station: station[1])
    both = [*blue, *red]  # either from the drivers' left to their right
    places = to_model(np.array([(x, y, 0.0) for x, y in both]), field.size)[:, :2]
    return {
        "name": name,
        "isFTC": False,
        "coordinateSystem": "wall-blue",
        **_PART,
        "widthInches": round(length / inches(1.0), 3),
        "heightInches": round(width / inches(1.0), 3),
        "defaultOrigin": "blue",
        "driverStations": (np.round(places, 3) + 0.0).tolist(),
        "gamePieces": [{"name": piece, **_PART, "stagedObjects": []} for piece in pieces],
        "aprilTags": april_tags(field),
    }


def april_tags(field: FieldDefinition) -> list[dict[str, Any]]:
    """All tags of a field; AdvantageScope has them in the frame of the model, whatever the coordinate system is."""
    tags = tag_layout(field.tags, field.size)
    turned = np.diag((-1.0, -1.0, 1.0))
    found = []
    for number, center, rotation in zip(tags.id_list, to_model(tags.centers, field.size), tags.rotations, strict=True):
        rows = turned @ rotation
        pitch = math.asin(max(-1.0, min(1.0, -float(rows[2, 0]))))
        roll, yaw = math.atan2(rows[2, 1], rows[2, 2]), math.atan2(rows[1, 0], rows[0, 0])
        angles = zip("xyz", (round(math.degrees(angle), 3) for angle in (roll, pitch, yaw)), strict=True)
        found.append(
            {
                "variant": f"36h11-{tags.size / inches(1.0):g}in",
                "id": number,
                "rotations": [{"axis": axis, "degrees": degrees} for axis, degrees in angles if degrees],
                "position": np.round(center, 4).tolist(),
            }
        )
    return found


def to_model(points: FloatArray, size: tuple[float, float]) -> FloatArray:
    """Field frame (blue corner) to AdvantageScope's model frame: origin in the middle, the red wall at -x [m]."""
    middle = np.array((size[0] / 2.0, size[1] / 2.0, 0.0))
    moved: FloatArray = (points - middle) * (-1.0, -1.0, 1.0)
    return moved


# --- meshes -----------------------------------------------------------------------------------------------------------


def _robot_meshes(body: ChassisConfig, color: str) -> dict[str, Any]:
    """Bumpers with a white mark in front, and a plate between them."""
    length, width, thick, top = body.bumper_length, body.bumper_width, body.bumper_thickness, body.bumper_top
    low = body.clearance + 0.02
    middle, high = 0.5 * (low + top), top - low
    x, y = 0.5 * (length - thick), 0.5 * (width - thick)
    meshes = {
        "bumper_front": _painted(Box(size=(thick, width, high)), color, (x, 0.0, middle)),
        "bumper_back": _painted(Box(size=(thick, width, high)), color, (-x, 0.0, middle)),
        "bumper_left": _painted(Box(size=(length, thick, high)), color, (0.0, y, middle)),
        "bumper_right": _painted(Box(size=(length, thick, high)), color, (0.0, -y, middle)),
        "front_mark": _painted(Box(size=(0.01, 0.22, 0.08)), "#ffffff", (0.5 * length, 0.0, middle)),
        "frame": _painted(Box(size=(length - thick, width - thick, 0.02)), _FRAME, (0.0, 0.0, low)),
    }
    for number, (px, py) in enumerate(body.wheel_positions):
        size = (2.0 * body.wheel_radius, 0.04, 2.0 * body.wheel_radius)
        meshes[f"wheel_{number}"] = _painted(Box(size=size), _FRAME, (px, py, body.wheel_radius))
    return meshes


def _painted(shape: Shape, color: str, at: Sequence[float] | FloatArray = (0.0, 0.0, 0.0)) -> Any:
    import trimesh

    mesh = _mesh(shape)
    mesh.apply_translation(np.asarray(at, dtype=np.float64))
    visual: Any = trimesh.visual
    material = visual.material.PBRMaterial(
        baseColorFactor=linear_rgba(rgb(color)), metallicFactor=0.0, roughnessFactor=0.8
    )
    mesh.visual = visual.TextureVisuals(material=material)
    return mesh


def _mesh(shape: Shape) -> Any:
    """A shape as a `trimesh.Trimesh` about its origin."""
    import trimesh

    if isinstance(shape, Compound):
        parts = []
        for part in shape.parts:
            parts.append(_mesh(part.shape))
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


def _save(path: Path, meshes: Mapping[str, Any]) -> None:
    import trimesh

    scene: Any = trimesh.Scene()
    for name, mesh in meshes.items():
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    path.write_bytes(scene.export(file_type="glb", include_normals=True))


def _write_json(path: Path, content: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8", newline="\n")
