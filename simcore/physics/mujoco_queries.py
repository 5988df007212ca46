"""Rays and bounding boxes in a MuJoCo model whose kinematics are up to date."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from simcore.geometry.rotation import Vector
from simcore.physics.mujoco_model import CompiledModel
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["ModelQueries"]

_MOST_PASSED = 16  # surfaces that a ray leaves from the inside before it is given up


class ModelQueries:
    """Questions to one model; the poses of statics in it are right already."""

    def __init__(self, model: CompiledModel) -> None:
        self._model, self._mj, self._m, self._d = model, model.mj, model.m, model.d
        statics = np.nonzero(model.body_of_geom < 0)[0]
        self._first = len(statics)
        low, high = self.boxes(statics)
        self._static_low, self._static_high = low.T.copy(), high.T.copy()
        box = self._m.geom_aabb[self._first :]
        center = np.sqrt(np.einsum("ij,ij->i", box[:, :3], box[:, :3]))
        self._radius = center + np.sqrt(np.einsum("ij,ij->i", box[:, 3:], box[:, 3:]))

    def cast(self, start: FloatArray, end: FloatArray, groups: Any) -> tuple[float, int, Sequence[float]]:
        """Fraction, row and normal of the first surface that a segment enters."""
        way, passed = end - start, 0.0
        geom, normal = np.zeros(1, dtype=np.int32), np.zeros((3, 1))
        for _ in range(_MOST_PASSED):
            there = self._mj.mj_ray(
                self._m, self._d, (start + passed * way)[:, None], way[:, None], groups, True, -1, geom, normal
            )
            passed += there
            if there < 0.0 or passed > 1.0:
                break
            if float(normal[:, 0] @ way) < 0.0:
                return passed, int(self._model.row_of_geom[geom[0]]), normal[:, 0].tolist()
            passed += 1e-9  # it left a body from the inside
        return 1.0, -1, (0.0, 0.0, 0.0)

    def overlapping(self, low: Sequence[float], high: Sequence[float]) -> list[int]:
        """Rows of the bodies in the world whose bounding boxes overlap a box [m]."""
        first = self._first
        here = np.nonzero(_overlap(self._static_low, self._static_high, low, high))[0]
        pos = self._d.geom_xpos[first:].T
        near = np.nonzero(_overlap(pos - self._radius, pos + self._radius, low, high))[0] + first
        if len(near):
            lows, highs = self.boxes(near)
            near = near[_overlap(lows.T, highs.T, low, high)]
        geoms = np.concatenate((here, near))
        geoms = geoms[self._m.geom_contype[geoms] != 0]
        rows: list[int] = np.unique(self._model.row_of_geom[geoms]).tolist()
        return rows

    def near_statics(self, row: int, reach: float) -> list[tuple[float, Vector, Vector]]:
        """As `Engine.near_statics`, of the shapes of a body in turn."""
        m, mine = self._m, self._model.geoms_of_row[row]
        low, high = (corner.T[:, :, None] for corner in self.boxes(mine))
        near = _overlap(self._static_low[:, None, :], self._static_high[:, None, :], low - reach, high + reach)
        ways = m.geom_contype[mine, None] & m.geom_conaffinity[: self._first]
        back = m.geom_conaffinity[mine, None] & m.geom_contype[: self._first]
        x, y, z = self._model.qpos[self._model.body_of_row[row], :3].tolist()
        found: list[tuple[float, Vector, Vector]] = []
        ends = np.zeros(6)
        for one, other in np.argwhere(near & ((ways | back) != 0)).tolist():
            gap = self._mj.mj_geomDistance(m, self._d, int(mine[one]), other, reach, ends)
            ax, ay, az, bx, by, bz = ends.tolist()
            if gap < reach and gap != 0.0:
                found.append((gap, ((ax - bx) / gap, (ay - by) / gap, (az - bz) / gap), (ax - x, ay - y, az - z)))
        return found

    def boxes(self, geoms: IntArray) -> tuple[FloatArray, FloatArray]:
        """Corners of the bounding boxes of some shapes, field frame [m], shape (n, 3) each."""
        m, d = self._m, self._d
        axes, box = d.geom_xmat[geoms].reshape(-1, 3, 3), m.geom_aabb[geoms]
        center = d.geom_xpos[geoms] + (axes @ box[:, :3, None])[:, :, 0]
        half = (np.abs(axes) @ box[:, 3:, None])[:, :, 0]
        half[m.geom_type[geoms] == self._mj.mjtGeom.mjGEOM_PLANE] = np.inf
        return center - half, center + half


def _overlap(
    lows: FloatArray, highs: FloatArray, low: Sequence[float] | FloatArray, high: Sequence[float] | FloatArray
) -> BoolArray:
    """Whether boxes overlap another, corners of shape (3, n), shape (n,)."""
    found: BoolArray = (lows[0] <= high[0]) & (highs[0] >= low[0])
    for axis in (1, 2):
        found &= (lows[axis] <= high[axis]) & (highs[axis] >= low[axis])
    return found
