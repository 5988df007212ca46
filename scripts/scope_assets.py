"""Write plain models of any game for AdvantageScope: field, pieces, a robot in blue and in red.

    python scripts/scope_assets.py FOLDER [GAME]

They are for a game without its own models: the view shows the collision shapes. FOLDER is AdvantageScope's custom
assets folder; `simcore layout GAME --models FOLDER` makes a layout that shows them.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import model_parts
import numpy as np

from simcore.errors import OutputError, SimcoreError
from simcore.match.camera_rig import tag_layout
from simcore.match.game import FieldDefinition, Game
from simcore.match.registry import find_game
from simcore.show.palette import COLORS, rgb
from simcore.show.scope_layout import RED
from simcore.typing import FloatArray, alliance_in
from simcore.units import inches

__all__ = ["IN_FLIGHT", "april_tags", "field_config", "write_assets", "write_field", "write_robots"]

IN_FLIGHT = " in flight"
"""Suffix of the name of a piece for its model in the air, if the field has one."""

_STATION_SPACING = inches(69.0)  # AdvantageScope's spacing, for a field without given stations
_PART = {"rotations": [], "position": [0, 0, 0]}


def write_assets(game: Game, folder: Path) -> list[Path]:
    """Write `Field3d_...` and two `Robot_...` folders, for AdvantageScope's custom assets folder.

    Returns:
        Paths of the three folders.

    Raises:
        OutputError: If they cannot be written.
    """
    word = re.sub(r"\W", "", game.name.title())
    field, name = folder / f"Field3d_{word}", f"Simcore {game.heading}"
    meshes = {"carpet": model_parts.carpet(game.field.size)}
    for element in game.field.load().elements:
        mesh = model_parts.shape_mesh(element.shape)
        mesh.apply_translation(element.position)
        meshes[element.name] = model_parts.painted(
            mesh, rgb(COLORS[f"{alliance_in(element.name) or 'neutral'}-fill"][0])
        )
    pieces = {}
    for kind in (supply.kind for supply in game.pieces):
        for what, color, scale in ((kind.name, rgb(kind.color), 1.0), (kind.name + IN_FLIGHT, model_parts.ORANGE, 1.1)):
            mesh = model_parts.painted(model_parts.shape_mesh(kind.shape), color)
            mesh.apply_scale(scale)  # pieces in the air are also drawn among all pieces, under this
            pieces[what] = mesh
    body = game.robot().body
    try:
        write_field(field, meshes, list(pieces.values()), field_config(name, game.field, list(pieces)))
        robots = write_robots(folder / f"Robot_{word}", name, lambda color: model_parts.chassis(body, color))
    except OSError as error:
        raise OutputError(f"cannot write models to {str(folder)!r}: {error.strerror or error}") from error
    return [field, *robots]


def write_field(folder: Path, meshes: Mapping[str, Any], pieces: Sequence[Any], config: Mapping[str, Any]) -> None:
    """Write a `Field3d_...` folder, in place of an old one.

    Args:
        folder: Folder to write; made if missing.
        meshes: Meshes by name, in the field frame: blue origin.
        pieces: Mesh of each of the config's `gamePieces`.
        config: Config; see `field_config`.
    """
    model_parts.emptied_folder(folder)
    size = (inches(config["widthInches"]), inches(config["heightInches"]))
    for mesh in meshes.values():
        mesh.vertices = to_model(mesh.vertices, size)  # a half turn keeps the winding
    model_parts.write_model(folder / "model.glb", meshes)
    for number, piece in enumerate(pieces):
        model_parts.write_model(folder / f"model_{number}.glb", [piece])
    model_parts.write_json(folder / "config.json", config)


def write_robots(
    folder: Path,
    name: str,
    body: Callable[[tuple[int, ...]], Mapping[str, Any]],
    parts: Sequence[Iterable[Any]] = (),
    cameras: Sequence[Mapping[str, Any]] = (),
) -> list[Path]:
    """Write a `Robot_...` folder with blue bumpers, and one with red ones next to it, in place of old ones.

    Args:
        folder: Folder of the blue robot; both are made if missing.
        name: Name in AdvantageScope's list.
        body: Function that makes the fixed parts, with bumpers in a color.
        parts: Meshes of each of the robot's components, about its origin.
        cameras: Views from the robot.

    Returns:
        Paths of both folders.
    """
    components = [{"zeroedRotations": [], "zeroedPosition": [0, 0, 0]} for _ in parts]
    blue, red = folder, folder.with_name(f"{folder.name}Red")
    for path, suffix, color in ((blue, "", model_parts.BLUE), (red, RED, model_parts.RED)):
        model_parts.emptied_folder(path)
        model_parts.write_model(path / "model.glb", body(color))
        for number, part in enumerate(parts):
            model_parts.write_model(path / f"model_{number}.glb", part)
        config = {"name": name + suffix, "isFTC": False, "disableSimplification": True, **_PART}
        model_parts.write_json(path / "config.json", {**config, "cameras": list(cameras), "components": components})
    return [blue, red]


def field_config(
    name: str,
    field: FieldDefinition,
    pieces: Sequence[str],
    stations: Sequence[tuple[float, float]] = (),
) -> dict[str, Any]:
    """Return the `config.json` of a field; without `isFTC` AdvantageScope silently skips the folder.

    Args:
        name: Name in the list of the 3D tab.
        field: Definition with size, symmetry and tags.
        pieces: Names of the piece models, in their order.
        stations: Centers of blue's driver stations 1 to 3, field frame [m]; none: evenly spaced behind the wall.
    """
    length, width = field.size
    blue = stations or [(0.0, width / 2.0 + offset * _STATION_SPACING) for offset in (1.0, 0.0, -1.0)]
    red = sorted((field.symmetry.flip_point(*station) for station in blue), key=lambda station: station[1])
    both = [*blue, *red]  # each from the drivers' left to their right
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
    """Return all tags of a field, in the model frame, which AdvantageScope uses for them in any coordinate system."""
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
    """Convert field frame (blue corner) to AdvantageScope's model frame: origin in the middle, red wall at -x [m]."""
    middle = np.array((size[0] / 2.0, size[1] / 2.0, 0.0))
    moved: FloatArray = (points - middle) * (-1.0, -1.0, 1.0)
    return moved


def main(argv: list[str] | None = None) -> int:
    """Write the models and print their folders; return 0 if written, 1 if refused."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("game", nargs="?", help="default: the newest that is installed")
    options = parser.parse_args(argv)
    try:
        for path in write_assets(find_game(options.game), options.folder):
            print(path)
    except SimcoreError as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
