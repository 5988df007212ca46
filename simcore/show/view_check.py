"""What is wrong with a folder of models, before AdvantageScope skips it in silence or draws it in the wrong place."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from simcore.errors import ModelError
from simcore.show.view_models import read_config, transform

__all__ = ["ModelFinding", "check_folder"]

KINDS = ("Robot_", "Field3d_", "Field2d_", "Joystick_")
SYSTEMS = ("wall-alliance", "wall-blue", "center-rotated", "center-red")
_POINTER = b"version https://git-lfs"
_LARGE = 50e6  # [bytes]; one file; above, AdvantageScope takes long to load
_TALL, _SMALL = 3.0, 0.02  # [m]; sizes that no robot has: units are wrong


@dataclass(frozen=True, slots=True)
class ModelFinding:
    """One thing that is wrong."""

    place: str
    """Folder and file."""
    text: str
    """What, and what would work."""
    is_error: bool = True
    """False: it works, but should be looked at."""

    def __str__(self) -> str:
        return f"{'ERROR' if self.is_error else 'warning'}: {self.place}: {self.text}"


def check_folder(folder: Path, *, parts: int | None = None) -> list[ModelFinding]:
    """Check a model folder, or a folder of such folders.

    Args:
        folder: `Robot_NAME`, `Field3d_NAME`, or what AdvantageScope has as custom assets folder.
        parts: How many moving parts the robot code publishes in `ComponentPoses`; None does not compare.

    Raises:
        ModelError: There is no such folder, or nothing in it that AdvantageScope would look at.
    """
    if not folder.is_dir():
        raise ModelError(f"no folder {str(folder)!r}")
    own = folder.resolve()
    if own.name.startswith(KINDS):
        folders = [own]
    else:
        folders = sorted(p for p in own.iterdir() if p.is_dir() and p.name.startswith(KINDS))
    if not folders:
        raise ModelError(
            f"{str(folder)!r} holds no folder named Robot_..., Field3d_..., Field2d_... or Joystick_...; "
            "AdvantageScope looks at no other"
        )
    findings: list[ModelFinding] = []
    names: dict[tuple[str, str], str] = {}
    for path in folders:
        kind = next(k for k in KINDS if path.name.startswith(k))
        try:
            config = read_config(path)
        except ModelError as error:
            findings.append(ModelFinding(path.name, str(error).removeprefix(f"{path.name}: ")))
            continue
        name = config.get("name")
        if not isinstance(name, str) or not name:
            findings.append(ModelFinding(path.name, f'config.json needs a "name", got {name!r}'))
        elif (kind, name) in names:
            other = names[kind, name]
            findings.append(ModelFinding(path.name, f"the name {name!r} is taken by {other}; each needs its own"))
        else:
            names[kind, name] = path.name
        if kind == "Robot_":
            findings += _robot(path, config, parts)
        elif kind == "Field3d_":
            findings += _field(path, config)
    return findings


def _robot(folder: Path, config: Mapping[str, Any], parts: int | None) -> Iterator[ModelFinding]:
    yield from _transform(folder, config, "rotations", "position")
    components = config.get("components", [])
    if not _is_list(components):
        yield ModelFinding(folder.name, "components must be a list of objects, one for each moving part")
        components = []
    for component in components:
        yield from _transform(folder, component, "zeroedRotations", "zeroedPosition")
    cameras = config.get("cameras", [])
    if not _is_list(cameras):
        yield ModelFinding(folder.name, "cameras must be a list of objects")
        cameras = []
    for i, camera in enumerate(cameras):
        if not camera.get("name"):
            yield ModelFinding(folder.name, f'camera {i} needs a "name", or the robot is not loaded')
    if parts is not None and parts != len(components):
        yield ModelFinding(
            folder.name,
            f"components lists {len(components)} parts, but {parts} poses are published in Sim/Robot/ComponentPoses; "
            "they go together one by one, in order",
        )
    yield from _files(folder, len(components), "components")
    body = folder / "model.glb"
    extent = _extent(body)
    if extent is not None and (max(extent) > _TALL or max(extent) < _SMALL):
        yield ModelFinding(
            f"{folder.name}/model.glb",
            f"is {max(extent):.3g} long; glTF is in meters. Was it exported in millimeters or inches?",
            is_error=False,
        )


def _field(folder: Path, config: Mapping[str, Any]) -> Iterator[ModelFinding]:
    if "isFTC" not in config:
        yield ModelFinding(folder.name, '"isFTC": false is missing; AdvantageScope skips the field without a word')
    system = config.get("coordinateSystem")
    if system not in SYSTEMS:
        yield ModelFinding(
            folder.name,
            f'"coordinateSystem" should be "wall-blue" (blue origin), got {system!r}; everything would be turned',
        )
    for key in ("widthInches", "heightInches"):
        value = config.get(key)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value < 1e4:
            yield ModelFinding(folder.name, f'"{key}" must be a length in inches, got {value!r}')
    yield from _transform(folder, config, "rotations", "position")
    pieces = config.get("gamePieces", [])
    if not _is_list(pieces):
        yield ModelFinding(folder.name, "gamePieces must be a list of objects")
        pieces = []
    for i, piece in enumerate(pieces):
        if not piece.get("name"):
            yield ModelFinding(folder.name, f'game piece {i} needs a "name", as in Sim/GamePieces/<name>')
        yield from _transform(folder, piece, "rotations", "position")
    yield from _files(folder, len(pieces), "gamePieces")


def _transform(folder: Path, config: Mapping[str, Any], rotations: str, position: str) -> Iterator[ModelFinding]:
    try:
        transform(folder.name, config.get(rotations, []), config.get(position, [0, 0, 0]))
    except ModelError as error:
        yield ModelFinding(folder.name, str(error).removeprefix(f"{folder.name}: "))


def _files(folder: Path, count: int, listed: str) -> Iterator[ModelFinding]:
    wanted = ["model.glb", *(f"model_{i}.glb" for i in range(count))]
    for name in wanted:
        path = folder / name
        if not path.is_file():
            near = [p.name for p in folder.iterdir() if p.name.lower() == name.lower()]
            hint = f"; there is {near[0]!r}, but names are case-sensitive" if near else ""
            yield ModelFinding(f"{folder.name}/{name}", f"is missing{hint}")
            continue
        trouble = _glb_trouble(path)
        if trouble:
            yield ModelFinding(f"{folder.name}/{name}", trouble)
        elif path.stat().st_size > _LARGE:
            size = path.stat().st_size / 1e6
            yield ModelFinding(
                f"{folder.name}/{name}",
                f"is {size:.0f} MB; leave out screws and the inside, or it takes long to load",
                is_error=False,
            )
    for path in sorted(folder.glob("model_*.glb")):
        if path.name not in wanted:
            text = f"is not used: {listed} in config.json has {count} entries"
            yield ModelFinding(f"{folder.name}/{path.name}", text, is_error=False)


def _glb_trouble(path: Path) -> str:
    """Why a file is no GLB; empty if it is one."""
    try:
        with path.open("rb") as file:
            head = file.read(200)
    except OSError as error:
        return f"cannot be read: {error.strerror or error}"
    size = path.stat().st_size
    if head.startswith(_POINTER):
        return "is a Git LFS pointer, not the model: run `git lfs install` and `git lfs pull` in the project"
    if head[:4] != b"glTF" or len(head) < 20:
        kind = "empty" if not head else "no GLB file"
        return f"is {kind}; export binary glTF 2.0 (.glb)"
    _, version, length = struct.unpack_from("<4sII", head)
    if version != 2:
        return f"is glTF {version}; export glTF 2.0"
    if length != size:
        return f"is cut off: {size} of {length} bytes; copy or export it again"
    return ""


def _extent(path: Path) -> tuple[float, float, float] | None:
    """Size of everything in a GLB by its own account, node transforms left out [as exported]."""
    if not path.is_file() or _glb_trouble(path):
        return None
    with path.open("rb") as file:
        file.seek(12)
        length, _ = struct.unpack("<II", file.read(8))
        try:
            document = json.loads(file.read(length))
            places = [
                document["accessors"][p["attributes"]["POSITION"]]
                for mesh in document["meshes"]
                for p in mesh["primitives"]
            ]
            lows, highs = [a["min"] for a in places], [a["max"] for a in places]
        except (ValueError, KeyError, IndexError, TypeError):
            return None
    x, y, z = (max(h[i] for h in highs) - min(low[i] for low in lows) for i in range(3))
    return x, y, z


def _is_list(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(item, dict) for item in value)
