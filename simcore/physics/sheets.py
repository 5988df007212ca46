"""Open surfaces of a mesh, and which of their two sides is the free one.

A mesh without thickness becomes plates: the side that a face looks to (counter-clockwise corners) is free, and the
plate grows to the other. Files are often wound both ways, or one half of a field was made of the other with its faces
turned round. So the winding of neighbours is made to agree first; then a surface and its image on the other half of the
field have to. Where the winding does not say it, the free side is the one that looks up, from where pieces come.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from simcore.geometry.symmetry import FieldSymmetry
from simcore.physics.triangle_mesh import TriangleMesh
from simcore.typing import FloatArray, IntArray

__all__ = ["SAME_PLACE", "Sheet", "SideRemarks", "choose_sides", "components", "with_even_winding"]

SAME_PLACE = 0.02
"""Parts of the two halves of a field are each other's image if their bounds agree within this [m]. Fields are built to
less; a plate on the wrong side is off by its 0.05 m, of which at least 0.029 m are along one axis."""
_LEVEL = 0.05
"""A surface whose area seen from above is under this share of it is upright: neither side looks up [-]."""
_SLIVER = 1e-4
"""Faces under this share of a surface's area may be wound as they like [-]."""


@dataclass(slots=True, eq=False)
class Sheet:
    """A connected open surface as convex flat polygons, all wound to one side of it."""

    group: str
    """Name of its group in the file."""
    corners: tuple[FloatArray, ...]
    """Of each polygon [m], shape (m, 3)."""
    normals: FloatArray
    """Of each polygon, to the free side, shape (n, 3)."""
    areas: FloatArray
    """[m^2], shape (n,)."""
    is_mixed: bool
    """Whether its faces were wound both ways."""

    @property
    def centers(self) -> FloatArray:
        """Of the polygons [m], shape (n, 3)."""
        return np.array([corners.mean(axis=0) for corners in self.corners])

    @property
    def bounds(self) -> FloatArray:
        """Smallest and largest corner [m], shape (2, 3)."""
        points = np.vstack(self.corners)
        return np.array([points.min(axis=0), points.max(axis=0)])

    @property
    def rise(self) -> float:
        """Share of its area that looks up, less the share that looks down [-]."""
        return float(self.normals[:, 2] @ self.areas / self.areas.sum())

    def turn(self) -> None:
        """Let its other side be the free one."""
        self.normals = -self.normals


@dataclass(slots=True)
class SideRemarks:
    """Groups whose free side the file does not say; each with what was done."""

    upward: set[str] = field(default_factory=set)
    """They face up now."""
    by_most_faces: set[str] = field(default_factory=set)
    """They face where most of their area does."""
    as_other_half: set[str] = field(default_factory=set)
    """They are wound against their image on the other half, and face as that does now."""

    @property
    def sentences(self) -> list[str]:
        """For a warning; empty if the file says it all."""
        said = (
            ("now face up", self.upward),
            ("now face where most of their area does", self.by_most_faces),
            ("now face as their image on the other half of the field does", self.as_other_half),
        )
        return [f"{sorted(groups)} {what}" for what, groups in said if groups]


def components(pairs: IntArray, count: int) -> IntArray:
    """For each of `count` nodes, the number of its component in the graph that the pairs make."""
    graph = coo_matrix((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def with_even_winding(mesh: TriangleMesh) -> tuple[IntArray, bool]:
    """Faces of a connected mesh, wound so that neighbours agree and most of the area stays as it was.

    Each face is two nodes of a graph, as it is and turned round; an edge joins what agrees: two faces pass their common
    edge in opposite directions.

    Returns:
        Vertex rows, shape (m, 3), and whether any face was turned, or none can be right (a Moebius strip).
    """
    faces, count = mesh.faces, len(mesh.faces)
    pairs, edges = mesh.adjacent, mesh.shared_edges
    if not len(pairs):
        return faces, False
    agree = _passes(faces[pairs[:, 0]], edges) != _passes(faces[pairs[:, 1]], edges)
    a, b = pairs[:, 0], pairs[:, 1]
    other = np.where(agree, 0, count)
    joined = np.vstack([np.column_stack([a, b + other]), np.column_stack([a + count, b + count - other])])
    labels = components(joined, 2 * count)
    turned = np.zeros(count, dtype=np.bool_)
    areas, is_mixed = mesh.areas, False
    for label in np.unique(np.minimum(labels[:count], labels[count:])):
        as_it_is, turned_round = labels[:count] == label, labels[count:] == label
        if (as_it_is & turned_round).any():
            is_mixed = True
            continue
        fewer = as_it_is if areas[as_it_is].sum() < areas[turned_round].sum() else turned_round
        turned |= fewer
        is_mixed |= bool(areas[fewer].sum() > _SLIVER * areas.sum())
    return np.where(turned[:, None], faces[:, ::-1], faces), is_mixed


def _passes(faces: IntArray, edges: IntArray) -> Any:
    """Whether each face, (n, 3), passes its edge, (n, 2), from its first end to its second, shape (n,)."""
    ahead = np.roll(faces, -1, axis=1)
    return ((faces == edges[:, :1]) & (ahead == edges[:, 1:])).any(axis=1)


def choose_sides(sheets: Sequence[Sheet], symmetry: FieldSymmetry | None) -> SideRemarks:
    """Turn sheets to their free side, in place.

    Args:
        sheets: Of a whole field, in the order of the file.
        symmetry: Of the field, None if it has none.
    """
    remarks = SideRemarks()
    bounds = np.array([sheet.bounds for sheet in sheets]).reshape(-1, 2, 3)
    done: set[int] = set()
    for number, sheet in enumerate(sheets):
        if number in done:
            continue
        done.add(number)
        partner = None if symmetry is None else _partner(sheets, bounds, number, done, symmetry)
        if symmetry is None or partner is None:
            if sheet.is_mixed:
                _face_up((sheet,), remarks)
            continue
        done.add(partner)
        other = sheets[partner]
        if sheet.is_mixed and not other.is_mixed:
            _match(sheet, other, symmetry)
            continue
        differs = _match(other, sheet, symmetry)
        if sheet.is_mixed:
            _face_up((sheet, other), remarks)
        elif differs and not other.is_mixed:
            if abs(sheet.rise) > _LEVEL:
                _face_up((sheet, other), remarks)
            else:
                remarks.as_other_half.add(other.group)
    return remarks


def _face_up(alike: Sequence[Sheet], remarks: SideRemarks) -> None:
    """Turn a sheet, with its image if it has one, so that it looks up; an upright one stays."""
    groups = {sheet.group for sheet in alike}
    if abs(alike[0].rise) <= _LEVEL:
        remarks.by_most_faces |= groups
        return
    if alike[0].rise < 0.0:
        for sheet in alike:
            sheet.turn()
    remarks.upward |= groups


def _partner(
    sheets: Sequence[Sheet], bounds: FloatArray, number: int, done: set[int], symmetry: FieldSymmetry
) -> int | None:
    """Number of another sheet where the symmetry puts this one, best one that faces as its image; None: there is none.

    Args:
        sheets: All of them.
        bounds: Of each, shape (n, 2, 3) [m].
        number: Which one.
        done: Numbers of those that are no choice.
        symmetry: Of the field.
    """
    flipped = np.sort(symmetry.flip_points(bounds[number]), axis=0)
    near = np.nonzero(np.abs(bounds - flipped).max(axis=(1, 2)) < SAME_PLACE)[0].tolist()
    choice = [other for other in near if other not in done]
    alike = [other for other in choice if _agreement(sheets[other], sheets[number], symmetry) >= 0.0]
    return next(iter(alike or choice), None)


def _agreement(sheet: Sheet, other: Sheet, symmetry: FieldSymmetry) -> float:
    """Area of a sheet that faces as the image of another does, less the area that faces against it [m^2]."""
    centers, normals = symmetry.flip_points(other.centers), symmetry.flip_vectors(other.normals)
    away = np.linalg.norm(sheet.centers[:, None] - centers[None], axis=2)
    return float(np.einsum("ij,ij->i", sheet.normals, normals[away.argmin(axis=1)]) @ sheet.areas)


def _match(sheet: Sheet, like: Sheet, symmetry: FieldSymmetry) -> bool:
    """Turn a sheet so that it is the image of another; returns whether it had to be turned."""
    if _agreement(sheet, like, symmetry) >= 0.0:
        return False
    sheet.turn()
    return True
