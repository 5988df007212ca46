"""Triangles that share vertices: areas, normals, and which of them meet at an edge."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["TriangleMesh"]


class TriangleMesh:
    """A mesh of triangles.

    Args:
        vertices: Shape (n, 3) [m].
        faces: Rows of the vertices, counter-clockwise seen from outside, shape (m, 3).
    """

    def __init__(self, vertices: FloatArray, faces: IntArray) -> None:
        self.vertices = vertices
        self.faces = faces
        self.triangles: FloatArray = vertices[faces]
        """Corners of each face [m], shape (m, 3, 3)."""
        cross = np.cross(self.triangles[:, 1] - self.triangles[:, 0], self.triangles[:, 2] - self.triangles[:, 1])
        length = np.linalg.norm(cross, axis=1)
        self.areas: FloatArray = 0.5 * length
        """Of each face [m^2], shape (m,)."""
        self.normals: FloatArray = cross / np.maximum(length, np.finfo(float).tiny)[:, None]
        """Of each face, of length 1, shape (m, 3); zero where a face has no area."""

    @classmethod
    def cleaned(cls, vertices: FloatArray, faces: IntArray) -> TriangleMesh:
        """With equal vertices (to a micrometer) merged, unused ones dropped, and no face of two points."""
        _, first, inverse = np.unique(np.round(vertices, 6), axis=0, return_index=True, return_inverse=True)
        faces = inverse.reshape(-1)[faces]
        faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
        used, rows = np.unique(faces, return_inverse=True)
        return cls(vertices[first][used], rows.reshape(-1, 3))

    @property
    def has_area(self) -> BoolArray:
        """Per face, whether it is more than a sliver: slivers close a body but have no direction of their own."""
        longest = np.linalg.norm(self.triangles - np.roll(self.triangles, 1, axis=1), axis=2).max(axis=1)
        return np.asarray(2.0 * self.areas > 1e-5 * longest)  # its height is over 10 micrometers

    @property
    def is_watertight(self) -> bool:
        """Whether every edge joins two faces."""
        return 2 * len(self._joints[0]) == 3 * len(self.faces) > 0

    @property
    def adjacent(self) -> IntArray:
        """Pairs of faces that meet at an edge which no third one has, shape (k, 2)."""
        return self._joints[0]

    @property
    def shared_edges(self) -> IntArray:
        """The edge of each of these pairs, by rows of the vertices, the lower one first, shape (k, 2)."""
        return self._joints[1]

    @cached_property
    def _joints(self) -> tuple[IntArray, IntArray]:
        ends = np.sort(self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        edges, which, counts = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
        order = np.argsort(which.reshape(-1), kind="stable")
        starts = (np.cumsum(counts) - counts)[counts == 2]
        return np.column_stack([order[starts], order[starts + 1]]) // 3, edges[counts == 2]
