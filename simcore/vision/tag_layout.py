"""AprilTag layouts of a field, from WPILib's official layouts or from files in WPILib's JSON format."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.quantities import FIELD_LENGTH, FIELD_PLACE, Quantity, require, require_row, shown
from simcore.typing import FloatArray, IntArray
from simcore.units import inches, plain_sum
from simcore.world.rotation import Quaternion, Vector, matrix

__all__ = [
    "OFFICIAL_LAYOUTS",
    "TAG_SIZE",
    "TagLayout",
    "cross_matrices",
    "load_layout",
    "official_layout",
    "rotation_matrices",
]

TAG_SIZE = inches(6.5)
"""Edge length of the black square of an FRC AprilTag, family 36h11 [m]. Source: 2026 manual, section 5."""

_TAG_ID = Quantity("", 0, 586, is_whole=True)  # ids of family 36h11
_TAG_SIZE = Quantity("m", 0.0, 1.0, is_open=True)
_QUATERNION = Quantity("", -1.0 - 1e-3, 1.0 + 1e-3)
_ROUNDING = 1e-3  # [-]; numbers in files have three digits or more

_IDENTITY: FloatArray = np.eye(3)
_CROSS: FloatArray = np.array(
    [(0, 0, 0, 0, 0, -1, 0, 1, 0), (0, 0, 1, 0, 0, 0, -1, 0, 0), (0, -1, 0, 1, 0, 0, 0, 0, 0)], dtype=float
)
"""Cross product matrix of each unit vector, flattened by rows, shape (3, 9)."""

OFFICIAL_LAYOUTS = {
    "2026-welded": "k2026RebuiltWelded",
    "2026-andymark": "k2026RebuiltAndyMark",
    "2025-welded": "k2025ReefscapeWelded",
    "2025-andymark": "k2025ReefscapeAndyMark",
}
"""WPILib names of the official layouts, by short name."""


@dataclass(frozen=True, eq=False)
class TagLayout:
    """AprilTags of a field, one row per tag.

    The x axis of a tag points out of the tag's face, and the z axis points up. The method `of` creates a layout.
    """

    ids: IntArray
    """Tag ids in ascending order, shape (n,)."""
    centers: FloatArray
    """Centers of the tags, field frame [m], shape (n, 3)."""
    rotations: FloatArray
    """Rotations from tag axes to field axes, shape (n, 3, 3)."""
    corners: FloatArray
    """Corners of the tags, field frame [m], shape (n, 4, 3), in the order lower left, lower right, upper right, upper
    left, as seen facing the tag."""
    field_size: tuple[float, float]
    """Length and width of the field [m]."""
    size: float
    """Edge length of the black square [m]."""
    normals: FloatArray
    """Unit normals out of the faces, field frame, shape (n, 3)."""
    square_axes: FloatArray
    """Rotations from field axes to face axes (right as seen facing the tag, up, out of the face), shape (n, 3, 3)."""

    @classmethod
    def of(
        cls, tags: Iterable[tuple[int, Vector, Quaternion]], *, field_size: tuple[float, float], size: float = TAG_SIZE
    ) -> TagLayout:
        """Create a layout with the tags sorted by id.

        Args:
            tags: Id, center in the field frame [m], and attitude (unit quaternion from tag to field axes) of each tag.
            field_size: Length and width of the field [m].
            size: Edge length of the black square [m].

        Raises:
            ConfigError: If an id occurs twice or a number is out of range.
        """
        owner = "tag layout"
        require(owner, "size", size, _TAG_SIZE)
        require_row(owner, "field_size", field_size, (FIELD_LENGTH, FIELD_LENGTH))
        rows = list(tags)
        for number, pos, quat in rows:
            _require_tag(number, pos, quat)
        rows.sort()
        ids = [number for number, _, _ in rows]
        if len(set(ids)) != len(ids):
            twice = sorted({number for number in ids if ids.count(number) > 1})
            raise ConfigError(f"{owner}: ids must differ, got {twice} more than once")
        centers = np.array([tuple(map(float, pos)) for _, pos, _ in rows]).reshape(-1, 3)
        rotations = np.array([matrix(quat) for _, _, quat in rows]).reshape(-1, 3, 3)
        return cls._placed(np.array(ids, dtype=np.int64), centers, rotations, field_size, size)

    @classmethod
    def _placed(
        cls, ids: IntArray, centers: FloatArray, rotations: FloatArray, field_size: tuple[float, float], size: float
    ) -> TagLayout:
        h = size / 2.0
        square = np.array([(0.0, -h, -h), (0.0, h, -h), (0.0, h, h), (0.0, -h, h)])
        corners = centers[:, None, :] + square @ rotations.swapaxes(1, 2)
        normals = np.ascontiguousarray(rotations[:, :, 0])
        square_axes = np.ascontiguousarray(rotations[:, :, (1, 2, 0)].transpose(0, 2, 1))
        arrays = (ids, centers, rotations, corners, normals, square_axes)
        for array in arrays:
            array.setflags(write=False)
        return cls(*arrays[:4], field_size, size, *arrays[4:])

    def displaced(self, offsets: FloatArray) -> TagLayout:
        """Return a copy of the layout with rotated and translated tags.

        Args:
            offsets: Rotation vector about the tag's center [rad] and translation [m], field axes, shape (n, 6).
        """
        rotations = rotation_matrices(offsets[:, :3]) @ self.rotations
        return self._placed(self.ids, self.centers + offsets[:, 3:], rotations, self.field_size, self.size)

    @property
    def id_list(self) -> list[int]:
        """Tag ids as a list of integers, in row order."""
        numbers: list[int] = self.ids.tolist()
        return numbers


def cross_matrices(vectors: FloatArray) -> FloatArray:
    """Compute the matrices C with C w = v x w for vectors v (..., 3), shape (..., 3, 3)."""
    matrices: FloatArray = (vectors @ _CROSS).reshape(*vectors.shape, 3)
    return matrices


def rotation_matrices(vectors: FloatArray) -> FloatArray:
    """Compute the matrices of rotation vectors (..., 3) [rad] by Rodrigues' formula, shape (..., 3, 3)."""
    across = cross_matrices(vectors)
    angle2 = np.maximum((vectors * vectors).sum(axis=-1), 1e-18)[..., None, None]
    angle = np.sqrt(angle2)
    turns: FloatArray = _IDENTITY + np.sin(angle) / angle * across + (1.0 - np.cos(angle)) / angle2 * (across @ across)
    return turns


def _require_tag(number: int, pos: Vector, quat: Quaternion) -> None:
    require("tag layout", "id", number, _TAG_ID)
    require_row("tag layout", f"place of tag {number}", pos, (FIELD_PLACE,) * 3)
    require_row("tag layout", f"attitude of tag {number}", quat, (_QUATERNION,) * 4)
    if abs(math.hypot(*quat) - 1.0) > _ROUNDING:
        raise ConfigError(f"tag layout: attitude of tag {number} must be a unit quaternion, got {shown(quat)}")


def _unit(quat: Quaternion) -> Quaternion:
    x, y, z, w = quat
    norm = math.sqrt(plain_sum([float(c) ** 2 for c in quat]))
    return x / norm, y / norm, z / norm, w / norm


def official_layout(name: str) -> TagLayout:
    """Load an official layout by short name or by WPILib's name (`k2026RebuiltWelded`).

    Raises:
        UnknownNameError: If no layout has this name; the message lists similar names and all known names.
    """
    known = _official_rows()
    layout = known.get(OFFICIAL_LAYOUTS.get(name, name))
    if layout is None:
        raise UnknownNameError("tag layout", name, [*OFFICIAL_LAYOUTS, *known])
    length, width = layout["field"]
    tags = [(int(number), (x, y, z), (qx, qy, qz, qw)) for number, x, y, z, qw, qx, qy, qz in layout["tags"]]
    return TagLayout.of(tags, field_size=(length, width))


@cache
def _official_rows() -> dict[str, Any]:
    """Read all official layouts, by WPILib name, from the file that `scripts/make_tag_layouts.py` writes."""
    data: dict[str, Any] = json.loads(Path(__file__).with_name("tag_layouts.json").read_text(encoding="utf-8"))
    return data


def load_layout(path: Path, *, size: float = TAG_SIZE) -> TagLayout:
    """Load a layout from a file in WPILib's JSON format, and normalize the quaternions.

    Args:
        path: Path of the file.
        size: Edge length of the black square of each tag [m].

    Raises:
        ConfigError: If the file is missing or malformed; the message names the file.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        tags = []
        for tag in data["tags"]:
            p, q = tag["pose"]["translation"], tag["pose"]["rotation"]["quaternion"]
            tags.append((tag["ID"], (p["x"], p["y"], p["z"]), (q["X"], q["Y"], q["Z"], q["W"])))
        field_size = (data["field"]["length"], data["field"]["width"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise ConfigError(
            f"{path}: not a tag layout in WPILib's JSON ('tags' with ID and pose, 'field' with length and width): "
            f"{type(error).__name__}: {error}"
        ) from error
    try:
        for tag in tags:
            _require_tag(*tag)
        tags = [(number, pos, _unit(quat)) for number, pos, quat in tags]
        return TagLayout.of(tags, field_size=field_size, size=size)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error
