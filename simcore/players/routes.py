"""Routes on the carpet: the cheapest way around what stands on the field and around other robots.

The field is a grid of cells of about 0.2 m, each with a cost of a meter through it. All of it is in the blue frame of
whoever plans: for a red robot the field is flipped, so that red is blue under the field's symmetry.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from simcore.match.game import FieldDefinition
from simcore.physics.field import FieldElement
from simcore.physics.shapes import outline_points
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["RouteMap"]

Place = tuple[float, float]
"""On the carpet, blue field frame [m]."""

_CELL = 0.2  # [m]
_FINE = 4  # points a cell and axis, at which elements are looked for
_FLAT = 0.05  # [m]; what is no higher does not slow a robot down
_HALF = 0.42  # [m]; half of a robot, and a little: its center comes no nearer to a wall
_CORNER = 0.6  # [m]; a robot that turns this near to a wall touches it
_BLOCKED, _TIGHT = 60.0, 1.5  # cost of a meter; high and not infinite, so that who is inside gets out
_RAMP = 8.0  # the same; a robot is slow there, and may land on a piece that lifts its wheels off the carpet
_ROBOT, _NEAR_ROBOT = (0.85, 12.0), (1.3, 2.0)  # [m] from another robot's center, and the cost added there
_DETOUR = 1.03  # a straight line may cost this much more than the cells of a route, which go in steps of 45 degrees


class RouteMap:
    """Costs of a field, and routes over it.

    Args:
        field: Which; its symmetry and what robots drive over.
        elements: What stands on it, as loaded.
        height: Of a robot [m]; what is higher up does not stop it.
        flipped: Whether red plans.
    """

    def __init__(
        self, field: FieldDefinition, elements: Iterable[FieldElement], *, height: float, flipped: bool
    ) -> None:
        from scipy.ndimage import distance_transform_edt

        self._size = np.array(field.size)
        self.shape = (round(field.size[0] / _CELL), round(field.size[1] / _CELL))
        self._step = self._size / self.shape
        solid, ramp = self._rasters(elements, field.drivable, height)
        fine = self._step / _FINE
        away = distance_transform_edt(np.pad(~solid, 1), sampling=fine)[1:-1, 1:-1]
        cost = np.where(away < _HALF, _BLOCKED, np.where(away < _CORNER, _TIGHT, 1.0)) + (_RAMP - 1.0) * ramp
        cells = cost.reshape(self.shape[0], _FINE, self.shape[1], _FINE)
        ramps = np.any(ramp.reshape(cells.shape), axis=(1, 3))
        self._to_ramp: FloatArray = (
            distance_transform_edt(~ramps, sampling=self._step) if ramps.any() else np.full(self.shape, np.inf)
        )
        # the middle of a cell stands for it: a passage that is narrower than two cells would close otherwise
        self._cost = cells[:, _FINE // 2 - 1 : _FINE // 2 + 1, :, _FINE // 2 - 1 : _FINE // 2 + 1].mean(axis=(1, 3))
        if flipped:
            turn = (slice(None, None, -1), slice(None, None, -1 if field.symmetry.keeps_hands else None))
            self._cost, self._to_ramp = self._cost[turn].copy(), self._to_ramp[turn].copy()
        x, y = ((np.arange(n) + 0.5) * s for n, s in zip(self.shape, self._step, strict=True))
        self._centers = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        self._edges = _neighbors(self.shape)
        self._lengths = np.linalg.norm(
            self._centers.reshape(-1, 2)[self._edges[0]] - self._centers.reshape(-1, 2)[self._edges[1]], axis=1
        )

    def _rasters(
        self, elements: Iterable[FieldElement], drivable: Sequence[str], height: float
    ) -> tuple[BoolArray, BoolArray]:
        """What stops a robot and what it climbs over, at the fine points."""
        fine = (self.shape[0] * _FINE, self.shape[1] * _FINE)
        solid, ramp = np.zeros(fine, dtype=bool), np.zeros(fine, dtype=bool)
        step = self._step / _FINE
        for element in elements:
            z = outline_points(element.shape)[:, 2] + element.position[2]
            is_ramp = any(fnmatchcase(element.name, pattern) for pattern in drivable)
            if z.max() < _FLAT or z.min() > height:
                continue
            outline = element.outline()
            first = np.maximum(0, np.ceil(outline.min(axis=0) / step - 0.5)).astype(int)
            last = np.minimum(fine, np.floor(outline.max(axis=0) / step + 0.5)).astype(int)
            if (last <= first).any():
                continue
            x, y = ((np.arange(a, b) + 0.5) * s for a, b, s in zip(first, last, step, strict=True))
            edges = np.roll(outline, -1, axis=0) - outline
            inside = np.ones((len(x), len(y)), dtype=bool)
            for (ex, ey), (cx, cy) in zip(edges.tolist(), outline.tolist(), strict=True):
                inside &= ex * (y[None, :] - cy) - ey * (x[:, None] - cx) >= 0.0
            (ramp if is_ramp else solid)[first[0] : last[0], first[1] : last[1]] |= inside
        return solid, ramp

    # --- questions ------------------------------------------------------------------------------------------------

    def is_ramp(self, place: Place, within: float = 0.0) -> bool:
        """Whether a place is on something that robots climb over, or that near to it [m]."""
        return bool(self._to_ramp[self._cell(place)] <= within)

    def is_free(self, place: Place) -> bool:
        """Whether a robot's center can be there."""
        inside = 0.0 < place[0] < self._size[0] and 0.0 < place[1] < self._size[1]
        return inside and bool(self._cost[self._cell(place)] < _BLOCKED)

    def route(self, start: Place, goal: Place, others: Sequence[Place] = ()) -> list[Place]:
        """Corners of the cheapest way from a place to another, without the first.

        Args:
            start: Where the robot is [m].
            goal: Where it wants to be [m].
            others: Centers of other robots [m]; one that stands on the goal is no obstacle.
        """
        cost = self._cost
        for x, y in others:
            if math.dist((x, y), goal) < _ROBOT[0]:
                continue
            if cost is self._cost:
                cost = cost.copy()
            away = np.hypot(self._centers[..., 0] - x, self._centers[..., 1] - y)
            for reach, more in (_ROBOT, _NEAR_ROBOT):
                cost[away < reach] += more
        length = math.dist(start, goal)
        if self._line_cost(cost, start, goal) <= _DETOUR * length:
            return [goal]
        flat = cost.ravel()
        a, b = self._edges
        weights = self._lengths * 0.5 * (flat[a] + flat[b])
        graph: Any = csr_array((weights, (a, b)), shape=(flat.size, flat.size))
        width = self.shape[1]
        first, last = (i * width + j for i, j in (self._cell(start), self._cell(goal)))
        costs, before = (row[0] for row in dijkstra(graph, indices=[last], return_predecessors=True))
        way, node = [], int(before[first])
        while node >= 0 and node != last:
            way.append(node)
            node = int(before[node])
        middles = [(float(x), float(y)) for x, y in self._centers.reshape(-1, 2)[way]] + [goal]
        left = [*costs[way].tolist(), 0.0]
        total = float(costs[first])
        # go straight to the farthest cell that costs no more so than cell by cell
        for n in range(len(middles) - 1, 0, -1):
            if self._line_cost(cost, start, middles[n]) <= _DETOUR * (total - left[n]):
                return middles[n:]
        return middles

    def _cell(self, place: Place) -> tuple[int, int]:
        i, j = (int(p / s) for p, s in zip(place, self._step, strict=True))
        return min(max(i, 0), self.shape[0] - 1), min(max(j, 0), self.shape[1] - 1)

    def _line_cost(self, cost: FloatArray, a: Place, b: Place) -> float:
        """Cost of the straight way between two places."""
        length = math.dist(a, b)
        points = max(2, math.ceil(length / (0.5 * _CELL)) + 1)
        places = np.linspace(a, b, points) / self._step
        cells = np.clip(places.astype(int), 0, np.array(self.shape) - 1)
        return length * float(cost[cells[:, 0], cells[:, 1]].mean())


def _neighbors(shape: tuple[int, int]) -> tuple[IntArray, IntArray]:
    """Pairs of cells that lie beside each other, straight or across a corner, each in both orders."""
    number = np.arange(shape[0] * shape[1]).reshape(shape)
    pairs = [
        (number[:-1, :], number[1:, :]),
        (number[:, :-1], number[:, 1:]),
        (number[:-1, :-1], number[1:, 1:]),
        (number[:-1, 1:], number[1:, :-1]),
    ]
    a = np.concatenate([one.ravel() for one, _ in pairs])
    b = np.concatenate([other.ravel() for _, other in pairs])
    return np.concatenate((a, b)), np.concatenate((b, a))
