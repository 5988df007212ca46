"""Triangles of one mesh group sorted into the simplest shapes that an engine can collide with.

A box collides faster and leaks less than a hull, and both beat a triangle mesh: balls bump over the inner edges of
triangles and pass them at higher steps. So each group becomes, in this order of preference: a `Box`, a `Hull`, thin
convex plates, and a `Mesh` only where nothing else fits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from simcore.errors import FieldMeshError
from simcore.physics.obj import MOST_GROUPS
from simcore.physics.shapes import Box, Hull, Mesh
from simcore.physics.sheets import Sheet, components, with_even_winding
from simcore.physics.triangle_mesh import TriangleMesh
from simcore.typing import FloatArray, IntArray

__all__ = ["MAX_PLATES", "TOLERANCE", "MeshPart", "decompose", "plates"]

TOLERANCE = 1e-4
"""Dents and bends below this do not count [m]: a tenth of a millimeter, far under what a field is built to."""
MAX_PLATES = 32
"""An open surface of more flat faces than this is taken for curved and stays one triangle mesh."""


@dataclass(frozen=True, slots=True, eq=False)
class MeshPart:
    """One shape and where its origin stands."""

    shape: Box | Hull | Mesh
    position: FloatArray
    """Origin of the shape in the frame of the mesh [m], shape (3,)."""


def decompose(vertices: FloatArray, triangles: IntArray, *, group: str = "") -> tuple[MeshPart | Sheet, ...]:
    """The solids and open surfaces that stand for some triangles; empty if all of them are slivers without area.

    Rules: a closed axis-aligned box is a `Box`, another closed convex body a `Hull`. Everything else is first taken
    apart into connected pieces. An open piece of at most `MAX_PLATES` flat faces is a `Sheet`: the normal of a face
    (counter-clockwise corners) points to the free side where balls are. Where the faces of a piece are wound both ways,
    the larger part says it. What is left, closed bodies with dents and curved open surfaces, is a `Mesh`.

    Args:
        vertices: Shape (n, 3) [m].
        triangles: Vertex rows, shape (m, 3).
        group: Name of the group that they come from.
    """
    mesh = TriangleMesh.cleaned(vertices, triangles)
    if not mesh.has_area.any():
        return ()
    solid = _solid(mesh)
    if solid is not None:
        return (solid,)
    parts: list[MeshPart | Sheet] = []
    for piece in _pieces(vertices, triangles, mesh, group):
        solid = _solid(piece)
        if solid is not None:
            parts.append(solid)
            continue
        sheet = None if _is_closed_body(piece) else _sheet(piece, group)
        parts.append(_triangle_mesh(piece) if sheet is None else sheet)
    return tuple(parts)


def plates(sheet: Sheet, thickness: float) -> list[MeshPart]:
    """A plate for each polygon of a sheet, behind its free side, so thick [m]."""
    return [_plate(corners, normal, thickness) for corners, normal in zip(sheet.corners, sheet.normals, strict=True)]


def _sheet(mesh: TriangleMesh, group: str) -> Sheet | None:
    """An open connected mesh as flat polygons; None if it takes more than `MAX_PLATES`."""
    faces, is_mixed = with_even_winding(mesh)
    polygons = _flat_polygons(TriangleMesh(mesh.vertices, faces))
    if not polygons:
        return None
    corners, normals = zip(*polygons, strict=True)
    areas = [ConvexHull(_in_plane(points, normal)).volume for points, normal in polygons]  # in 2-D, the area
    return Sheet(group, corners, np.array(normals), np.array(areas), is_mixed)


def _pieces(vertices: FloatArray, triangles: IntArray, mesh: TriangleMesh, group: str) -> list[TriangleMesh]:
    """Connected pieces; solids that merely touch are kept apart if the file gave them vertices of their own."""
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]]])
    labels = components(edges, len(vertices))[triangles[:, 0]]
    if (count := len(np.unique(labels))) > MOST_GROUPS:
        raise FieldMeshError(f"group {group!r} has {count} separate bodies, over the limit of {MOST_GROUPS}")
    if labels.max() > labels.min():
        apart = [TriangleMesh.cleaned(vertices, triangles[labels == label]) for label in np.unique(labels)]
        apart = [piece for piece in apart if piece.has_area.any()]
        if all(_is_closed_body(piece) for piece in apart):
            return apart
    labels = components(mesh.adjacent, len(mesh.faces))
    pieces = [TriangleMesh.cleaned(mesh.vertices, mesh.faces[labels == label]) for label in np.unique(labels)]
    return [piece for piece in pieces if piece.has_area.any()]


def _is_closed_body(mesh: TriangleMesh) -> bool:
    """Whether every edge joins two faces and the whole is not just a flat sheet with two sides."""
    if not mesh.is_watertight:
        return False
    depth = np.linalg.svd(mesh.vertices - mesh.vertices.mean(axis=0), compute_uv=False)[-1]
    return bool(depth > TOLERANCE)


def _solid(mesh: TriangleMesh) -> MeshPart | None:
    """The mesh as a box or a hull, None if it is neither."""
    if not (_is_closed_body(mesh) and _is_convex(mesh)):
        return None
    try:
        hull = ConvexHull(mesh.vertices)
    except QhullError:
        return None
    points = mesh.vertices
    low, high = points.min(axis=0), points.max(axis=0)
    center, size = (low + high) / 2.0, high - low
    if hull.volume >= (1.0 - 1e-6) * float(np.prod(size)):
        return MeshPart(Box((float(size[0]), float(size[1]), float(size[2]))), center)
    return MeshPart(Hull(points[np.sort(hull.vertices)] - center), center)


def _is_convex(mesh: TriangleMesh) -> bool:
    """Whether each face has all vertices on one side; independent of the winding, which is often wrong in files."""
    is_face = mesh.has_area
    normals = mesh.normals[is_face]
    offsets = np.einsum("ij,ij->i", normals, mesh.triangles[is_face, 0])
    for start in range(0, len(normals), 256):  # in blocks, so that a huge mesh is rejected early and in little memory
        rows = slice(start, start + 256)
        side = normals[rows] @ mesh.vertices.T - offsets[rows, None]
        if not ((side.max(axis=1) <= TOLERANCE) | (side.min(axis=1) >= -TOLERANCE)).all():
            return False
    return True


def _flat_polygons(mesh: TriangleMesh) -> list[tuple[FloatArray, FloatArray]]:
    """Convex flat polygons that cover the mesh, as (corners, normal); empty if it takes more than `MAX_PLATES`."""
    mesh = TriangleMesh.cleaned(mesh.vertices, mesh.faces[mesh.has_area])
    pairs = mesh.adjacent
    a, b = pairs[:, 0], pairs[:, 1]
    normals, corners = mesh.normals, mesh.triangles
    # Both faces lie within the tolerance of each other's plane and look to the same side.
    gap_b = np.abs(np.einsum("ijk,ik->ij", corners[b] - corners[a][:, :1], normals[a])).max(axis=1, initial=0.0)
    gap_a = np.abs(np.einsum("ijk,ik->ij", corners[a] - corners[b][:, :1], normals[b])).max(axis=1, initial=0.0)
    is_flat = (np.maximum(gap_a, gap_b) <= TOLERANCE) & (np.einsum("ij,ij->i", normals[a], normals[b]) > 0.0)
    pairs = pairs[is_flat]
    labels = components(pairs, len(mesh.faces))
    regions: list[list[int]] = []
    for label in np.unique(labels):
        regions += _convex_regions(mesh, np.flatnonzero(labels == label).tolist(), pairs)
        if len(regions) > MAX_PLATES:
            return []
    return [(_corners(mesh, region), mesh.normals[region[0]]) for region in regions]


def _convex_regions(mesh: TriangleMesh, faces: list[int], pairs: IntArray) -> list[list[int]]:
    """Coplanar connected triangles gathered into few convex regions: the whole if it is one, else grown greedily."""
    if _covers_its_hull(mesh, faces):
        return [faces]
    left = set(faces)
    regions: list[list[int]] = []
    neighbours: dict[int, set[int]] = {face: set() for face in faces}
    for i, j in pairs.tolist():
        if i in neighbours and j in neighbours:
            neighbours[i].add(j)
            neighbours[j].add(i)
    while left:
        seed = max(sorted(left), key=lambda face: float(mesh.areas[face]))
        region = [seed]
        left.discard(seed)
        grew = True
        while grew:
            grew = False
            for face in sorted({n for member in region for n in neighbours[member]} & left):
                if _covers_its_hull(mesh, [*region, face]):
                    region.append(face)
                    left.discard(face)
                    grew = True
        regions.append(region)
    return regions


def _covers_its_hull(mesh: TriangleMesh, faces: list[int]) -> bool:
    """Whether triangles lie in one plane and fill a convex polygon of it."""
    points, normal = mesh.triangles[faces].reshape(-1, 3), mesh.normals[faces[0]]
    if np.abs((points - points[0]) @ normal).max() > TOLERANCE:  # a fine curve: each pair is flat, the whole is not
        return False
    area = float(mesh.areas[faces].sum())
    flat = _in_plane(points, normal)
    return bool(ConvexHull(flat).volume <= area * (1.0 + 1e-4))  # in 2-D, `volume` is the area


def _corners(mesh: TriangleMesh, faces: list[int]) -> FloatArray:
    points = np.unique(mesh.triangles[faces].reshape(-1, 3), axis=0)
    return np.asarray(points[ConvexHull(_in_plane(points, mesh.normals[faces[0]])).vertices])


def _in_plane(points: FloatArray, normal: FloatArray) -> FloatArray:
    u = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    u = u / np.linalg.norm(u)
    return np.column_stack([points @ u, points @ np.cross(normal, u)])


def _plate(corners: FloatArray, normal: FloatArray, thickness: float) -> MeshPart:
    points = np.asarray(np.vstack([corners, corners - thickness * normal]))
    low, high = points.min(axis=0), points.max(axis=0)
    center, size = (low + high) / 2.0, high - low
    is_box = len(corners) == 4 and bool(np.isclose(np.prod(size), ConvexHull(points).volume, rtol=1e-6))
    if is_box:
        return MeshPart(Box((float(size[0]), float(size[1]), float(size[2]))), center)
    return MeshPart(Hull(points - center), center)


def _triangle_mesh(mesh: TriangleMesh) -> MeshPart:
    points = mesh.vertices
    center = (points.min(axis=0) + points.max(axis=0)) / 2.0
    return MeshPart(Mesh(points - center, mesh.faces), center)
