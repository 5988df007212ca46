"""Wavefront OBJ files: functions that read and write files, and that make named groups of polygons.

Group names select the surface of each part of a field. Error messages contain the line number. trimesh 5.2 also keeps
group names (`split_objects`, `split_groups`), but counts negative indices from the end of the file instead of the
latest vertex. trimesh also splits concave polygons into triangles outside the polygon, and silently accepts a vertex
with two numbers, NaN, or a face with vertex 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from simcore.errors import ConfigError, FieldMeshError
from simcore.typing import FloatArray, IntArray
from simcore.world.symmetry import FieldSymmetry

__all__ = [
    "MOST_GROUPS",
    "ObjGroup",
    "box_group",
    "flipped_group",
    "format_obj",
    "in_plane",
    "pipe_group",
    "prism_group",
    "read_obj",
    "solid_group",
    "triangulate",
    "write_obj",
]

UNNAMED = "default"
"""Group name of faces before the first `o` or `g` statement, as in the OBJ specification."""

MOST_FACES, MOST_GROUPS = 100_000, 1000
"""Largest numbers of faces and groups in a field; larger fields would take minutes to load."""
_MOST_CORNERS = 256

_IGNORED = frozenset(
    "vt vn vp s usemtl mtllib usemap maplib l p mg cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con "
    "bevel c_interp d_interp lod shadow_obj trace_obj ctech stech call csh".split()
)


@dataclass(frozen=True, slots=True, eq=False)
class ObjGroup:
    """Named group of polygons with their vertices."""

    name: str
    vertices: FloatArray
    """Vertices of the polygons, in the units of the file, shape (n, 3)."""
    faces: tuple[tuple[int, ...], ...]
    """Rows of the vertices of each polygon, counter-clockwise seen from the tip of the normal."""

    def triangles(self) -> IntArray:
        """Split the polygons into triangles, and return the rows of the vertices of each triangle, shape (m, 3)."""
        rows = [tri for face in self.faces for tri in triangulate(self.vertices, face)]
        return np.array(rows, dtype=np.int64).reshape(-1, 3)


def read_obj(
    path: str | PathLike[str], *, most_faces: int = MOST_FACES, most_groups: int = MOST_GROUPS
) -> tuple[ObjGroup, ...]:
    """Read the groups of an OBJ file in the order in which they first appear.

    The latest `o` or `g` statement gives the group of a face. Statements with equal names give one group.

    Args:
        path: Path of the file.
        most_faces: Largest number of faces; the function rejects files with more faces before parsing.
        most_groups: Largest number of `o` and `g` statements; the function rejects files with more statements before
            parsing.

    Raises:
        FieldMeshError: If the file is missing, unreadable, not an OBJ file, too large, without faces, or has a
            malformed line.
    """
    path = Path(path)
    try:
        raw = path.read_bytes()
    except (OSError, ValueError) as error:  # a path with a NUL raises ValueError
        reason = getattr(error, "strerror", None) or error
        raise FieldMeshError(f"cannot read the field mesh {path}: {reason}. Give the path of an OBJ file") from error
    count, names = raw.count(b"\nf "), raw.count(b"\ng ") + raw.count(b"\no ")
    if count > most_faces:
        raise FieldMeshError(
            f"{path} has {count} faces, over the limit of {most_faces}. Reduce it with "
            f"`python scripts/simplify_field.py {path} OUT.obj`, or raise max_triangles"
        )
    if names > most_groups:
        raise FieldMeshError(
            f"{path} has {names} groups ('o' and 'g'), over the limit of {most_groups}. Join those of one material"
        )
    if b"\0" in raw:
        raise FieldMeshError(f"{path} is a binary file, not a text OBJ. Export the mesh as Wavefront OBJ")
    text = raw.decode("utf-8", errors="replace").lstrip("\ufeff").replace("\\\r\n", " ").replace("\\\n", " ")

    vertices: list[list[float]] = []
    faces: dict[str, list[tuple[int, ...]]] = {}
    name = UNNAMED
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        keyword, values = words[0], words[1:]
        try:
            if keyword == "v":
                vertices.append(_vertex(values))
            elif keyword == "f":
                faces.setdefault(name, []).append(_face(values, len(vertices)))
            elif keyword in ("o", "g"):
                name = "_".join(values) or UNNAMED
            elif keyword not in _IGNORED:
                raise ValueError(f"unknown statement {keyword!r}")
        except ValueError as error:
            raise FieldMeshError(f"{path}, line {number}: {error} in {line.strip()[:80]!r}") from error
    if not faces:
        raise FieldMeshError(
            f"{path} is empty: {len(vertices)} vertices and no faces. Export the mesh with its faces ('f' lines)"
        )
    points, groups = np.array(vertices, dtype=np.float64), []
    for name, polygons in faces.items():
        used = sorted({row for face in polygons for row in face})
        new = {row: i for i, row in enumerate(used)}
        groups.append(ObjGroup(name, points[used], tuple(tuple(new[row] for row in face) for face in polygons)))
    return tuple(groups)


def format_obj(groups: Iterable[ObjGroup], *, header: str = "", decimals: int = 6) -> str:
    """Return the text of an OBJ file with the given groups; equal groups give equal text on every machine.

    Args:
        groups: Groups in the order of the file, each under its own `o` statement.
        header: Comment lines for the top of the file.
        decimals: Number of decimals of each coordinate; 6 decimals of a meter are a micrometer.
    """
    lines = [f"# {line}".rstrip() for line in header.splitlines()]
    offset = 1
    for group in groups:
        lines.append(f"o {group.name}")
        # Adding zero turns -0.0 into 0.0, so that a mirrored copy has the same digits.
        lines += ["v " + " ".join(f"{c:.{decimals}f}" for c in v) for v in np.round(group.vertices, decimals) + 0.0]
        lines += ["f " + " ".join(str(i + offset) for i in face) for face in group.faces]
        offset += len(group.vertices)
    return "\n".join(lines) + "\n"


def write_obj(path: Path, groups: Sequence[ObjGroup], *, header: str = "") -> str:
    """Write an OBJ file, create missing folders, and return a line with the path and the group and triangle counts.

    Args:
        path: Path of the file.
        groups: Groups in the order of the file.
        header: Comment lines for the top of the file.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(format_obj(groups, header=header), encoding="utf-8", newline="\n")
    triangles = sum([len(group.triangles()) for group in groups])
    return f"{path}: {len(groups)} groups, {triangles} triangles"


def triangulate(vertices: FloatArray, face: tuple[int, ...]) -> list[tuple[int, int, int]]:
    """Split a flat polygon, convex or concave, into triangles by ear clipping.

    Args:
        vertices: Vertices of the mesh, shape (n, 3).
        face: Rows of the polygon's vertices, in order.

    Returns:
        Rows of the three vertices of each triangle.
    """
    corners = vertices[list(face)]
    flat = in_plane(corners, np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0))  # Newell's normal
    place = (flat[:, 0] + 1j * flat[:, 1]).tolist()
    left, out = list(range(len(face))), []

    def turn(a: int, b: int, c: int) -> float:  # twice the signed area; positive for a left turn at b
        return float(((place[b] - place[a]).conjugate() * (place[c] - place[a])).imag)

    def is_ear(i: int) -> bool:
        a, b, c = left[i - 1], left[i], left[(i + 1) % len(left)]
        return turn(a, b, c) > 0.0 and not any(
            turn(a, b, p) >= 0.0 and turn(b, c, p) >= 0.0 and turn(c, a, p) >= 0.0 for p in left if p not in (a, b, c)
        )

    while len(left) > 3:
        ear = next(filter(is_ear, range(len(left))), 0)  # 0 for a self-intersecting polygon, which has no ears
        out.append((face[left[ear - 1]], face[left[ear]], face[left[(ear + 1) % len(left)]]))
        del left[ear]
    return [*out, (face[left[0]], face[left[1]], face[left[2]])]


def in_plane(points: FloatArray, normal: FloatArray) -> FloatArray:
    """Project points onto the plane with a given normal.

    The projection preserves counter-clockwise order, seen from the tip of the normal.

    Args:
        points: Points, shape (n, 3).
        normal: Normal of the plane, of any length, shape (3,).

    Returns:
        Coordinates in the plane, shape (n, 2).
    """
    u = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    u = u / max(float(np.linalg.norm(u)), np.finfo(float).tiny)
    return np.column_stack([points @ u, points @ np.cross(normal, u)])


def _vertex(values: list[str]) -> list[float]:
    if len(values) < 3:
        raise ValueError(f"a vertex needs 3 numbers, got {len(values)}")
    point = [float(v) for v in values[:3]]
    if not all(math.isfinite(c) for c in point):
        raise ValueError("a vertex must have finite coordinates")
    return point


def _face(values: list[str], count: int) -> tuple[int, ...]:
    if len(values) > _MOST_CORNERS:
        raise ValueError(f"a face has at most {_MOST_CORNERS} corners, got {len(values)}; export it as triangles")
    rows: list[int] = []
    for value in values:
        index = int(value.partition("/")[0])
        row = index - 1 if index > 0 else count + index  # negative indices count back from the latest vertex
        if index == 0 or not 0 <= row < count:
            raise ValueError(f"vertex {index} does not exist, {count} vertices so far")
        if row not in rows:
            rows.append(row)
    if len(rows) < 3:
        raise ValueError(f"a face needs 3 different vertices, got {len(rows)}")
    return tuple(rows)


# --- convex bodies ---------------------------------------------------------------------------------------------------


def box_group(name: str, low: tuple[float, float, float], high: tuple[float, float, float]) -> ObjGroup:
    """Make a group with an axis-aligned box from the low and high corners of the box [m]."""
    ring = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    return solid_group(name, np.array([(*xy, low[2]) for xy in ring]), np.array([(*xy, high[2]) for xy in ring]))


def solid_group(name: str, bottom: FloatArray, top: FloatArray) -> ObjGroup:
    """Make a group with a prism or frustum from two flat polygons with equal numbers of corners.

    Args:
        name: Name of the group.
        bottom: Corners of the lower polygon, counter-clockwise seen from the top [m], shape (n, 3).
        top: Corners of the upper polygon, each above the lower corner of the same row [m], shape (n, 3).
    """
    n = len(bottom)
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return ObjGroup(name, np.vstack([bottom, top]), (tuple(reversed(range(n))), tuple(range(n, 2 * n)), *sides))


def prism_group(name: str, outline: FloatArray, bottom: float, top: float) -> ObjGroup:
    """Make a group with an upright prism.

    Args:
        name: Name of the group.
        outline: Convex outline, counter-clockwise seen from above [m], shape (n, 2).
        bottom: Height of the lower face [m].
        top: Height of the upper face [m].
    """
    ends = [np.column_stack([outline, np.full(len(outline), z)]) for z in (bottom, top)]
    return solid_group(name, ends[0], ends[1])


def pipe_group(
    name: str,
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    diameter: float,
    *,
    aside: tuple[float, float, float],
    sides: int = 8,
) -> ObjGroup:
    """Make a group with a straight pipe: a prism with the cross-sectional area of the round pipe.

    Args:
        name: Name of the group.
        start: Center of the first end [m].
        end: Center of the second end [m].
        diameter: Diameter of the round pipe [m].
        aside: Direction across the pipe; the component perpendicular to the pipe is normal to a pair of faces.
        sides: Number of side faces.

    Raises:
        ConfigError: If the pipe has no length or diameter, or `aside` is along the pipe.
    """
    ends = np.array([start, end])
    way = ends[1] - ends[0]
    u = np.array(aside) - way * (way @ np.array(aside)) / max(float(way @ way), 1e-12)
    if not (diameter > 0.0 and float(way @ way) > 0.0 and float(u @ u) > 1e-12):
        raise ConfigError(
            f"{name}: diameter must be > 0 m, start and end differ and aside be across, got {diameter}, {start}, "
            f"{end}, {aside}"
        )
    u /= np.linalg.norm(u)
    v = np.cross(way / np.linalg.norm(way), u)
    # the regular polygon of the same area
    radius = 0.5 * diameter * math.sqrt(math.tau / (sides * math.sin(math.tau / sides)))
    turn = (np.arange(sides) + 0.5) * math.tau / sides
    ring = radius * (np.outer(np.cos(turn), u) + np.outer(np.sin(turn), v))
    return solid_group(name, ends[0] + ring, ends[1] + ring)


def flipped_group(group: ObjGroup, name: str, symmetry: FieldSymmetry) -> ObjGroup:
    """Return the image of a group under the symmetry of a field; the normals of the image also point outward."""
    faces = group.faces if symmetry.keeps_hands else tuple(face[::-1] for face in group.faces)
    return ObjGroup(name, symmetry.flip_points(group.vertices), faces)
