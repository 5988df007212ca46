"""Check a folder of AdvantageScope models: your own CAD, or ours.

    python scripts/check_models.py FOLDER [--parts 16]

FOLDER is a Robot_NAME or Field3d_NAME folder, or the one that contains them (AdvantageScope's custom assets folder).
The script reports mistakes for which AdvantageScope would silently skip a model or draw it in the wrong place. Exit
status: 0 no mistakes, 1 errors, 2 no such folder.
"""

from __future__ import annotations

import argparse
import struct
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from simcore.errors import ModelError
from simcore.show.solids import extents
from simcore.show.view_models import read_config, read_field, read_robot

KINDS = ("Robot_", "Field3d_", "Field2d_", "Joystick_")
SYSTEMS = ("wall-alliance", "wall-blue", "center-rotated", "center-red")
_POINTER = b"version https://git-lfs"
_LARGE = 50e6  # [bytes]; one file; above, AdvantageScope takes long to load
_TALL, _SMALL = 3.0, 0.02  # [m]; sizes of no robot: the units are wrong


@dataclass(frozen=True, slots=True)
class ModelFinding:
    """One mistake."""

    place: str
    """Folder and file."""
    text: str
    """Description of the mistake, and of what would work."""
    is_error: bool = True
    """Whether it is an error; otherwise it works, but needs a look."""

    def __str__(self) -> str:
        return f"{'ERROR' if self.is_error else 'warning'}: {self.place}: {self.text}"


def check_folder(folder: Path, *, parts: int | None = None) -> list[ModelFinding]:
    """Check a model folder, or a folder of such folders.

    Args:
        folder: `Robot_NAME`, `Field3d_NAME`, or AdvantageScope's custom assets folder.
        parts: Number of moving parts that robot code publishes in `ComponentPoses`; None: not compared.

    Raises:
        ModelError: If there is no such folder, or nothing in it that AdvantageScope reads.
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
        try:
            if kind == "Robot_":
                findings += _robot(path, config, parts)
                read_robot(path)
            elif kind == "Field3d_":
                findings += _field(path, config)
                read_field(path)
        except ModelError as error:  # the player's first error
            findings.append(ModelFinding(path.name, str(error).removeprefix(f"{path.name}: ")))
    return findings


def _robot(folder: Path, config: Mapping[str, Any], parts: int | None) -> Iterator[ModelFinding]:
    components = config.get("components", [])
    if parts is not None and isinstance(components, list) and parts != len(components):
        yield ModelFinding(
            folder.name,
            f"components lists {len(components)} parts, but {parts} poses are published in Sim/Robot/ComponentPoses; "
            "they go together one by one, in order",
        )
    cameras = config.get("cameras", [])
    for i, camera in enumerate(cameras if isinstance(cameras, list) else [None]):
        if not (isinstance(camera, dict) and camera.get("name")):
            yield ModelFinding(folder.name, f'camera {i} needs a "name", or the robot is not loaded')
    yield from _files(folder, components)
    body = folder / "model.glb"
    longest = 0.0 if not body.is_file() or _glb_trouble(body) else max(extents(body))
    if longest and not _SMALL < longest < _TALL:
        yield ModelFinding(
            f"{folder.name}/model.glb",
            f"is {longest:.3g} long; glTF is in meters. Was it exported in millimeters or inches?",
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
    pieces = config.get("gamePieces", [])
    for i, piece in enumerate(pieces if isinstance(pieces, list) else []):
        if not (isinstance(piece, dict) and piece.get("name")):
            yield ModelFinding(folder.name, f'game piece {i} needs a "name", as in Sim/GamePieces/<name>')
    yield from _files(folder, pieces)


def _files(folder: Path, listed: object) -> Iterator[ModelFinding]:
    """Check the GLB files of a folder whose `config.json` lists parts or pieces."""
    count = len(listed) if isinstance(listed, list) else 0
    wanted = ["model.glb", *(f"model_{i}.glb" for i in range(count))]
    for path in sorted(folder.glob("*.glb")):
        place = f"{folder.name}/{path.name}"
        if trouble := _glb_trouble(path):
            yield ModelFinding(place, trouble)
        elif path.name not in wanted:
            yield ModelFinding(place, f"is not used: config.json lists {count}", is_error=False)
        elif (size := path.stat().st_size) > _LARGE:
            text = f"is {size / 1e6:.0f} MB; leave out screws and the inside, or it takes long to load"
            yield ModelFinding(place, text, is_error=False)


def _glb_trouble(path: Path) -> str:
    """Return why a file is not a GLB; empty if it is one."""
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


def main(argv: list[str] | None = None) -> int:
    """Print one line for each mistake."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--parts", type=int, help="how many moving parts are published (the REBUILT robot: 16)")
    options = parser.parse_args(argv)
    try:
        findings = check_folder(options.folder, parts=options.parts)
    except ModelError as error:
        print(f"ModelError: {error}", file=sys.stderr)
        return 2
    for finding in findings:
        print(finding)
    errors = sum(finding.is_error for finding in findings)
    if not findings:
        print(f"{options.folder}: nothing wrong")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
