"""Reader for AdvantageScope's model folders, for the pages and for `scripts/check_models.py`.

A game or a team provides one folder with `Field3d_*` and `Robot_*` folders. AdvantageScope can use the same folder for
custom assets.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from simcore.errors import ModelError
from simcore.typing import FloatArray

__all__ = [
    "FieldModels",
    "Model",
    "RobotModels",
    "ViewModels",
    "load_models",
    "read_config",
    "read_field",
    "read_robot",
]


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """GLB file, with the transform that places the content of the file."""

    path: Path
    transform: FloatArray
    """Homogeneous transform from the frame of the file to the frame of the object (field, robot, part or piece) [m],
    shape (4, 4)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldModels:
    """Models of the field and the pieces in a `Field3d_*` folder."""

    name: str
    size: tuple[float, float]
    """Length and width of the field [m]."""
    body: Model
    """Model of the field, in the blue-origin field frame."""
    pieces: Mapping[str, Model]
    """Models of game pieces by name of the kind, as in `Sim/GamePieces/<name>`."""
    stations: tuple[tuple[float, float], ...] = ()
    """Positions of the driver stations, blue 1 to 3, then red 1 to 3, field frame [m]; empty if the config has none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotModels:
    """Models of the body and the moving parts in a `Robot_*` folder."""

    name: str
    body: Model
    parts: tuple[Model, ...]
    """Models of the moving parts, in the order of `ComponentPoses`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewModels:
    """Models in a folder; `field` is None without a field model, and `robots` is empty without robot models."""

    field: FieldModels | None = None
    robots: tuple[RobotModels, ...] = ()


def load_models(folder: str | Path) -> ViewModels:
    """Read the configs of all robot models and of the first field model in a folder.

    The function checks that the GLB files exist, but does not read the files.

    Raises:
        ModelError: If the folder is missing or contains neither `Field3d_*` nor `Robot_*`, or if a model is invalid.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise ModelError(f"no folder {str(folder)!r}; give the one that holds Field3d_... and Robot_... folders")
    fields = sorted(p for p in folder.glob("Field3d_*") if p.is_dir())
    robots = sorted(p for p in folder.glob("Robot_*") if p.is_dir())
    if not fields and not robots:
        raise ModelError(f"{str(folder)!r} holds neither a Field3d_... nor a Robot_... folder")
    return ViewModels(field=read_field(fields[0]) if fields else None, robots=tuple(map(read_robot, robots)))


def read_config(folder: Path) -> dict[str, Any]:
    """Read the `config.json` of one model folder.

    Raises:
        ModelError: If the file is missing, not JSON, or not an object.
    """
    path = folder / "config.json"
    try:
        config = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ModelError(f"{folder.name}: cannot read config.json: {error.strerror or error}") from error
    except (UnicodeDecodeError, json.JSONDecodeError) as error:
        raise ModelError(f"{folder.name}: config.json is not JSON: {error}") from error
    if not isinstance(config, dict):
        raise ModelError(f"{folder.name}: config.json must be an object {{...}}, got a {type(config).__name__}")
    return config


def _transform(folder: str, rotations: Any, position: Any) -> FloatArray:
    """Return the homogeneous transform of successive rotations followed by a translation, shape (4, 4).

    Raises:
        ModelError: If `rotations` is not a list of objects such as `{"axis": "x", "degrees": 90}`, or if `position` is
            not a list of three numbers.
    """
    matrix = np.eye(4)
    try:
        for turn in rotations:
            c, s = math.cos(math.radians(turn["degrees"])), math.sin(math.radians(turn["degrees"]))
            i = "xyz".index(turn["axis"])
            j, k = (i + 1) % 3, (i + 2) % 3
            step = np.eye(4)
            step[j, j] = step[k, k] = c
            step[k, j], step[j, k] = s, -s
            matrix = step @ matrix
        x, y, z = (float(value) for value in position)
        matrix[:3, 3] = x, y, z
    except (TypeError, KeyError, ValueError) as error:
        raise ModelError(
            f'{folder}: rotations must be a list of {{"axis": "x", "degrees": 90}} and position [x, y, z] in meters, '
            f"got {rotations!r} and {position!r}"
        ) from error
    if not np.isfinite(matrix).all():
        raise ModelError(f"{folder}: rotations and position must be finite, got {rotations!r} and {position!r}")
    return matrix


def _model(folder: Path, file: str, matrix: FloatArray) -> Model:
    path = folder / file
    if not path.is_file():
        near = [p.name for p in folder.iterdir() if p.name.lower() == file.lower()]
        hint = f"; there is {near[0]!r}, but names are case-sensitive" if near else ""
        raise ModelError(f"{folder.name}: {file} is missing{hint}")
    return Model(path, matrix)


def read_field(folder: Path) -> FieldModels:
    """Read the models of one `Field3d_*` folder.

    Raises:
        ModelError: If the folder is invalid; the message describes the first error.
    """
    config = read_config(folder)
    try:
        size = (float(config["widthInches"]) * 0.0254, float(config["heightInches"]) * 0.0254)
    except (KeyError, TypeError, ValueError) as error:
        raise ModelError(f"{folder.name}: widthInches and heightInches must be numbers") from error
    if not all(0.0 < s < 1e4 for s in size):
        raise ModelError(f"{folder.name}: widthInches and heightInches must be > 0, got {size} m")
    # the model's origin is the center of the field, with the red wall at -x
    to_field = np.diag((-1.0, -1.0, 1.0, 1.0))
    to_field[:2, 3] = size[0] / 2.0, size[1] / 2.0
    own = _transform(folder.name, config.get("rotations", []), config.get("position", [0, 0, 0]))
    pieces = {}
    for i, piece in enumerate(_list(folder, config, "gamePieces")):
        matrix = _transform(folder.name, piece.get("rotations", []), piece.get("position", [0, 0, 0]))
        pieces[str(piece.get("name", i))] = _model(folder, f"model_{i}.glb", matrix)
    name = str(config.get("name", folder.name))
    body = _model(folder, "model.glb", to_field @ own)
    return FieldModels(name=name, size=size, body=body, pieces=pieces, stations=_stations(folder, config, size))


def _stations(folder: Path, config: Mapping[str, Any], size: tuple[float, float]) -> tuple[tuple[float, float], ...]:
    """Return the positions of the driver stations in the field frame [m]; empty if the config has none.

    In the config, the origin is the center of the field, and the blue stations are at positive x.
    """
    listed = config.get("driverStations", [])
    try:
        places = tuple((0.5 * size[0] - float(x), 0.5 * size[1] - float(y)) for x, y in listed)
    except (TypeError, ValueError):
        places = ()
    if listed and (len(places) != 6 or not np.isfinite(places).all()):
        raise ModelError(f"{folder.name}: driverStations must be six pairs [x, y] in meters, got {listed!r}")
    return places


def read_robot(folder: Path) -> RobotModels:
    """Read the models of one `Robot_*` folder.

    Raises:
        ModelError: If the folder is invalid; the message describes the first error.
    """
    config = read_config(folder)
    own = _transform(folder.name, config.get("rotations", []), config.get("position", [0, 0, 0]))
    parts = []
    for i, part in enumerate(_list(folder, config, "components")):
        matrix = _transform(folder.name, part.get("zeroedRotations", []), part.get("zeroedPosition", [0, 0, 0]))
        parts.append(_model(folder, f"model_{i}.glb", matrix))
    name = str(config.get("name", folder.name))
    return RobotModels(name=name, body=_model(folder, "model.glb", own), parts=tuple(parts))


def _list(folder: Path, config: Mapping[str, Any], key: str) -> list[dict[str, Any]]:
    value = config.get(key, [])
    if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
        raise ModelError(f"{folder.name}: {key} must be a list of objects, got {value!r}")
    return value
