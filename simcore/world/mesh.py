"""Conversion of a mesh group into the simplest shapes that an engine can collide with.

Collisions with boxes are faster to compute than collisions with hulls, and fewer balls pass through boxes. Boxes and
hulls are both better than triangle meshes. Balls bump on the inner edges of a triangle mesh and pass through the
triangles at larger steps. A group therefore becomes, in this order of preference, a `Box`, a `Hull`, thin convex
plates, or, if nothing else fits, a `Mesh`.

A surface without thickness becomes plates. The side that a face points to (counter-clockwise corners) is the free side,
and the plate extends to the other side. Files often have mixed winding, or one half of the field is a copy of the other
half with reversed faces. `decompose` therefore makes the winding of neighboring faces consistent. `choose_sides` then
makes the winding of a surface and of the image on the other half consistent. If the winding is ambiguous, the side that
faces up is the free side, because pieces come from above.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from simcore.errors import FieldMeshError
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.world.obj import MOST_GROUPS, in_plane
from simcore.world.shapes import Box, Hull, Mesh
from simcore.world.symmetry import FieldSymmetry

__all__ = ["MAX_PLATES", "SAME_PLACE", "TOLERANCE", "MeshPart", "Sheet", "choose_sides", "decompose"]

TOLERANCE = 1e-4
"""Tolerance for dents and bends [m]: a tenth of a millimeter, far below the building tolerance of a field."""
MAX_PLATES = 32
"""Largest number of flat faces of an open surface; a surface with more faces counts as curved and stays a triangle
mesh."""
SAME_PLACE = 0.02
"""Largest difference between the bounds of a part and the bounds of the image on the other half of the field [m].

Building tolerances are smaller. The error of a plate on the wrong side is larger: the plate thickness of 0.05 m, with
at least 0.029 m along one axis.
"""
_LEVEL = 0.05
"""Absolute value of `Sheet.rise` below which a surface counts as upright [-]."""
_SLIVER = 1e-4
"""Fraction of a surface's area below which the winding of faces does not matter [-]."""
_THIN = 1e-5
"""Height below which a triangle has no usable normal [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class MeshPart:
    """Shape, and position of the shape in the mesh."""

    shape: Box | Hull | Mesh
    position: FloatArray
    """Origin of the shape in the frame of the mesh [m], shape (3,)."""


@dataclass(slots=True, eq=False)
class Sheet:
    """Connected open surface, divided into flat convex polygons with consistent winding."""

    group: str
    """Name of the surface's group in the file."""
    corners: list[FloatArray]
    """Corners of each polygon [m], shape (m, 3)."""
    normals: FloatArray
    """Unit normals of the polygons, toward the free side, shape (n, 3)."""
    areas: FloatArray
    """Areas of the polygons [m^2], shape (n,)."""
    is_mixed: bool
    """Whether the faces in the file had mixed winding."""
    bounds: FloatArray
    """Low and high corners of the bounding box [m], shape (2, 3)."""

    @property
    def rise(self) -> float:
        """Fraction of the area that faces up minus the fraction that faces down [-]."""
        return float(self.normals[:, 2] @ self.areas / self.areas.sum())

    def plates(self, thickness: float) -> list[MeshPart]:
        """Make one plate of the given thickness [m] per polygon, on the side opposite to the free side."""
        return [
            _convex_part(np.vstack([corners, corners - thickness * normal]))
            for corners, normal in zip(self.corners, self.normals, strict=True)
        ]


# --- conversion of a group ------------------------------------------------------------------------------------------


def decompose(vertices: FloatArray, triangles: IntArray, *, group: str = "") -> list[MeshPart | Sheet]:
    """Convert triangles into solids and open surfaces; the list is empty if all triangles are slivers.

    A closed axis-aligned box becomes a `Box`, and any other closed convex body becomes a `Hull`. The function splits
    all other meshes into connected pieces. An open piece of at most `MAX_PLATES` flat faces becomes a `Sheet`. The
    normals of a sheet (counter-clockwise corners) point to the free side, where the balls are. If the winding is mixed,
    the winding of the larger area determines the normals. All other pieces (closed bodies with dents, and curved open
    surfaces) become a `Mesh`.

    Args:
        vertices: Vertices [m], shape (n, 3).
        triangles: Rows of the vertices of each triangle, shape (m, 3).
        group: Name of the group of these triangles.

    Raises:
        FieldMeshError: If the group has more separate bodies than a field may have groups.
    """
    points, faces = _merged(vertices, triangles)
    if not _has_area(points[faces]).any():
        return []
    if (solid := _solid(points, faces)) is not None:
        return [solid]
    # Solids that touch stay separate if the file gives each solid its own vertices.
    pieces = _pieces(vertices, triangles, group)
    if len(pieces) == 1 or not all(_is_closed_body(*piece) for piece in pieces):
        pieces = _pieces(points, faces, group)
    return [_solid(*piece) or _sheet(*piece, group) or _triangle_mesh(*piece) for piece in pieces]


def _merged(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Merge vertices that agree to a micrometer, and drop unused vertices and faces with fewer than three corners."""
    _, first, inverse = np.unique(np.round(vertices, 6), axis=0, return_index=True, return_inverse=True)
    faces = inverse.reshape(-1)[faces]
    faces = faces[(np.diff(np.sort(faces, axis=1), axis=1) > 0).all(axis=1)]
    used, rows = np.unique(faces, return_inverse=True)
    return vertices[first][used], rows.reshape(-1, 3)


def _has_area(corners: FloatArray) -> BoolArray:
    """Return whether each triangle is more than a sliver, shape (m,); a sliver has no usable normal.

    Args:
        corners: Corners of the triangles [m], shape (m, 3, 3).
    """
    sides = np.roll(corners, -1, axis=1) - corners
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    return np.asarray(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) > _THIN * longest)


def _is_closed_body(points: FloatArray, faces: IntArray) -> bool:
    """Return whether every edge of a mesh joins exactly two faces, and the mesh is not flat."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    if not (np.unique(edges, axis=0, return_counts=True)[1] == 2).all():
        return False
    return bool(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[-1] > TOLERANCE)


def _solid(points: FloatArray, faces: IntArray) -> MeshPart | None:
    """Convert a closed convex mesh to a box or hull, regardless of winding; return None for any other mesh."""
    if not _is_closed_body(points, faces):
        return None
    corners = points[faces]
    corners = corners[_has_area(corners)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    offsets = np.einsum("ij,ij->i", normals, corners[:, 0])
    for start in range(0, len(normals), 256):  # in blocks, to reject a huge mesh early and with little memory
        rows = slice(start, start + 256)
        side = normals[rows] @ points.T - offsets[rows, None]
        if not ((side.max(axis=1) <= TOLERANCE) | (side.min(axis=1) >= -TOLERANCE)).all():
            return None
    return _convex_part(points)


def _convex_part(points: FloatArray) -> MeshPart:
    """Return the convex hull of points: a `Box` if the hull is an axis-aligned box, otherwise a `Hull`."""
    hull = ConvexHull(points)
    low, high = points.min(axis=0), points.max(axis=0)
    center, size = (low + high) / 2.0, high - low
    if hull.volume >= (1.0 - 1e-6) * float(np.prod(size)):
        return MeshPart(Box((float(size[0]), float(size[1]), float(size[2]))), center)
    return MeshPart(Hull(points[np.sort(hull.vertices)] - center), center)


def _triangle_mesh(points: FloatArray, faces: IntArray) -> MeshPart:
    center = (points.min(axis=0) + points.max(axis=0)) / 2.0
    return MeshPart(Mesh(points - center, faces), center)


def _trimesh(points: FloatArray, faces: IntArray) -> Any:
    import trimesh  # imported here because this takes half a second, and a field of solids does not need trimesh

    return trimesh.Trimesh(points, faces, process=False)


def _labels(pairs: IntArray, count: int) -> IntArray:
    """Return the number of the connected component of each node in a graph of `count` nodes with the edges `pairs`."""
    import trimesh.graph

    graph: Any = trimesh.graph  # typed Any because trimesh's annotations are incomplete
    return np.asarray(graph.connected_component_labels(pairs, node_count=count))


def _pieces(points: FloatArray, faces: IntArray, group: str) -> list[tuple[FloatArray, IntArray]]:
    """Split a mesh into components connected by shared edges, and return the vertices and faces of each component.

    The function drops components without area.

    Raises:
        FieldMeshError: If there are more than `MOST_GROUPS` components.
    """
    labels = _labels(_trimesh(points, faces).face_adjacency, len(faces))
    if labels.max() >= MOST_GROUPS:
        raise FieldMeshError(f"group {group!r} has {labels.max() + 1} separate bodies, over the limit of {MOST_GROUPS}")
    apart = [_merged(points, faces[labels == label]) for label in range(labels.max() + 1)]
    return [piece for piece in apart if _has_area(piece[0][piece[1]]).any()]


# --- open surfaces --------------------------------------------------------------------------------------------------


def _sheet(points: FloatArray, faces: IntArray, group: str) -> Sheet | None:
    """Convert an open connected mesh to a sheet; return None for a closed mesh or over `MAX_PLATES` polygons."""
    if _is_closed_body(points, faces):
        return None
    faces, is_mixed = _with_even_winding(_trimesh(points, faces))
    points, faces = _merged(points, faces[_has_area(points[faces])])
    mesh = _trimesh(points, faces)
    is_flat = np.abs(mesh.face_adjacency_projections) <= TOLERANCE
    pairs = mesh.face_adjacency[is_flat & (mesh.face_adjacency_angles < 0.5 * np.pi)]
    labels, regions = _labels(pairs, len(faces)), []
    for label in range(labels.max() + 1):
        regions += _convex_regions(mesh, np.flatnonzero(labels == label).tolist(), pairs)
        if len(regions) > MAX_PLATES:
            return None
    normals = mesh.face_normals[[region[0] for region in regions]]
    corners = [np.unique(mesh.triangles[region].reshape(-1, 3), axis=0) for region in regions]
    corners = [some[ConvexHull(in_plane(some, n)).vertices] for some, n in zip(corners, normals, strict=True)]
    areas = np.array([mesh.area_faces[region].sum() for region in regions])
    return Sheet(group, corners, normals, areas, is_mixed, np.array([points.min(axis=0), points.max(axis=0)]))


def _with_even_winding(mesh: Any) -> tuple[IntArray, bool]:
    """Make the winding of a connected mesh consistent by reversing the faces of at most half of the area.

    The function builds a graph with two nodes per face: the face unchanged and the face reversed. An edge of the graph
    joins two nodes with consistent winding: the two faces traverse the common edge in opposite directions.

    Returns:
        Vertex rows of the faces, shape (m, 3), and whether the winding was mixed. The winding was mixed if more than
            slivers had to be reversed, or if no consistent winding exists (Moebius strip).
    """
    faces, count, areas = np.asarray(mesh.faces), len(mesh.faces), mesh.area_faces
    a, b = mesh.face_adjacency.T
    edges = mesh.face_adjacency_edges

    def passes(some: IntArray) -> BoolArray:  # whether each face traverses its edge from the first end to the second
        ahead = np.roll(faces[some], -1, axis=1)
        return np.asarray(((faces[some] == edges[:, :1]) & (ahead == edges[:, 1:])).any(axis=1))

    other = np.where(passes(a) != passes(b), 0, count)
    joined = np.vstack([np.column_stack([a, b + other]), np.column_stack([a + count, b + count - other])])
    labels = _labels(joined, 2 * count)
    if labels[0] == labels[count]:
        return faces, True
    turned = labels[:count] != labels[0]
    if areas[turned].sum() > areas[~turned].sum():
        turned = ~turned
    return np.where(turned[:, None], faces[:, ::-1], faces), bool(areas[turned].sum() > _SLIVER * areas.sum())


def _convex_regions(mesh: Any, faces: list[int], pairs: IntArray) -> list[list[int]]:
    """Group coplanar connected triangles into few convex regions.

    The result is a single region if possible. Otherwise a greedy algorithm adds triangles to each region.
    """
    if _covers_its_hull(mesh, faces):
        return [faces]
    left = sorted(faces, key=lambda face: -float(mesh.area_faces[face]))
    regions: list[list[int]] = []
    while left:
        region: list[int] = []
        more: int | None = left[0]
        while more is not None:
            region.append(more)
            left.remove(more)
            near = pairs[np.isin(pairs, region).any(axis=1)]
            choice = np.intersect1d(near, left).tolist()
            more = next((face for face in choice if _covers_its_hull(mesh, [*region, face])), None)
        regions.append(region)
    return regions


def _covers_its_hull(mesh: Any, faces: list[int]) -> bool:
    """Return whether triangles are coplanar and fill a convex polygon."""
    points, normal = mesh.triangles[faces].reshape(-1, 3), mesh.face_normals[faces[0]]
    if np.abs((points - points[0]) @ normal).max() > TOLERANCE:  # a slight curve: each pair is flat, the region is not
        return False
    hull = ConvexHull(in_plane(points, normal))  # in 2-D, `volume` is the area
    return bool(hull.volume <= float(mesh.area_faces[faces].sum()) * (1.0 + 1e-4))


# --- the free side --------------------------------------------------------------------------------------------------


def choose_sides(sheets: Sequence[Sheet], symmetry: FieldSymmetry | None) -> list[str]:
    """Reverse the normals of sheets, in place, so that all normals point to the free side.

    Args:
        sheets: Sheets of the whole field, in the order of the file.
        symmetry: Symmetry of the field; None if the field has no symmetry.

    Returns:
        One sentence for each rule that decided the free side of groups that are ambiguous in the file.
    """
    upward: set[str] = set()
    by_most: set[str] = set()
    as_image: set[str] = set()
    left = list(sheets)
    while left:
        sheet, differs = left.pop(0), False
        image = None if symmetry is None else _image(sheet, left, symmetry)
        if symmetry is not None and image is not None:
            left.remove(image)
            if sheet.is_mixed and not image.is_mixed:
                sheet, image = image, sheet
            differs = _agreement(image, sheet, symmetry) < 0.0
            image.normals = -image.normals if differs else image.normals
        if not (sheet.is_mixed or (image is not None and differs and not image.is_mixed)):
            continue
        both = [one for one in (sheet, image) if one is not None]
        if abs(sheet.rise) > _LEVEL:
            for one in both if sheet.rise < 0.0 else ():
                one.normals = -one.normals
            upward |= {one.group for one in both}
        elif sheet.is_mixed:
            by_most |= {one.group for one in both}
        else:
            as_image.add(both[1].group)
    remarks = (
        ("now face up", upward),
        ("now face where most of their area does", by_most),
        ("now face as their image on the other half of the field does", as_image),
    )
    return [f"{sorted(groups)} {what}" for what, groups in remarks if groups]


def _image(sheet: Sheet, others: Sequence[Sheet], symmetry: FieldSymmetry) -> Sheet | None:
    """Return the image of a sheet under the symmetry, preferably with agreeing normals; None if no sheet matches."""
    flipped = np.sort(symmetry.flip_points(sheet.bounds), axis=0)
    near = [other for other in others if np.abs(other.bounds - flipped).max() < SAME_PLACE]
    alike = (other for other in near if _agreement(other, sheet, symmetry) >= 0.0)
    return next(alike, near[0] if near else None)


def _agreement(sheet: Sheet, other: Sheet, symmetry: FieldSymmetry) -> float:
    """Compute the agreement of a sheet's normals with the image of another sheet [m^2].

    The result is the sum over the polygons of area times the cosine of the angle between the two normals.
    """
    mine, its = (np.array([corners.mean(axis=0) for corners in one.corners]) for one in (sheet, other))
    nearest = np.linalg.norm(mine[:, None] - symmetry.flip_points(its)[None], axis=2).argmin(axis=1)
    normals = symmetry.flip_vectors(other.normals)[nearest]
    return float(np.einsum("ij,ij->i", sheet.normals, normals) @ sheet.areas)
