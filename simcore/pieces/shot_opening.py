"""The opening that shots fall through: its rim, the boards behind it that send them back in, and what is within it.

A shot goes in if it comes through the opening and does not bounce out again; where a zone counts falling pieces alone,
it comes down. Boards, walls and the rim's edges send it back by the law of all impacts here; the edge under a board
does not: what comes so far falls in along the board.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.errors import ConfigError
from simcore.geometry.rotation import Vector
from simcore.geometry.zones import Zone
from simcore.physics.contact_law import WALL, TerrainSurface, hit_surface, pair_friction, pair_restitution
from simcore.pieces.flight import FlightState, crossing
from simcore.quantities import ANGLE, FIELD_PLACE, require, require_fields
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import GRAVITY, TICK

__all__ = ["Panel", "ShotOpening", "ShotOutcomes", "fly_to_opening"]

_FLAT = 1e-3  # [m]; corners may be this far off their common plane
_LONGEST = 300  # ticks; 6 s, as long as a shot to a height of 40 m
_MOST_IMPACTS = 4  # in a tick
_SKIN = 0.01  # [m]; what is deeper behind a panel has come from its other side


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """A flat, convex part around an opening, that shots bounce off."""

    corners: tuple[Vector, ...]
    """In their order around it, field frame [m]."""
    surface: TerrainSurface

    def __post_init__(self) -> None:
        _require_outline(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotOpening:
    """A flat opening with a rim, convex, in any attitude."""

    corners: tuple[Vector, ...]
    """Of the rim, in their order around it, field frame [m]."""
    approach: float
    """Direction in which a shot comes that comes straight at it [rad]."""
    boards: tuple[Panel, ...] = ()
    """Each stands over the nearest edge of the rim: what hits it falls in along it, whatever it does to that edge."""
    walls: tuple[Panel, ...] = ()
    """What is within it, e.g. of a funnel."""

    def __post_init__(self) -> None:
        _require_outline(self)
        require("ShotOpening", "approach", self.approach, ANGLE)

    @property
    def middle(self) -> FloatArray:
        """Mean of its corners: where to aim, field frame [m], shape (3,)."""
        mean: FloatArray = np.array(self.corners).mean(axis=0)
        return mean

    @property
    def inward(self) -> FloatArray:
        """Unit normal toward the inside: down, or on where a shot comes straight from, shape (3,)."""
        normal = _normal(self.corners)
        ahead = np.array([math.cos(self.approach), math.sin(self.approach), -1.0])
        return normal if normal @ ahead > 0.0 else -normal

    @property
    def bare_rim(self) -> list[tuple[Vector, Vector]]:
        """Those of its edges over which no board stands, from corner to corner [m]."""
        edges = list(zip(self.corners, (*self.corners[1:], self.corners[0]), strict=True))
        middles = np.array([np.mean(edge, axis=0)[:2] for edge in edges])
        boarded = {
            int(np.argmin(np.linalg.norm(middles - np.mean(board.corners, axis=0)[:2], axis=1)))
            for board in self.boards
        }
        return [edge for number, edge in enumerate(edges) if number not in boarded]

    @property
    def rim_surface(self) -> TerrainSurface:
        """That of its first wall, whose upper edge the rim is; of a wall where it has none."""
        return self.walls[0].surface if self.walls else WALL

    @property
    def reach(self) -> float:
        """Radius of the ball around its middle that holds rim, boards and walls [m]."""
        corners = [self.corners, *(panel.corners for panel in (*self.boards, *self.walls))]
        return max(float(np.linalg.norm(np.array(some) - self.middle, axis=1).max()) for some in corners)

    def holds(self, points: FloatArray) -> BoolArray:
        """Which points of its plane (n, 3) [m] are within the rim, shape (n,)."""
        return _within(self.corners, points)


@dataclass(slots=True, kw_only=True)
class ShotOutcomes:
    """What became of n shots, one a row."""

    goes_in: BoolArray
    by_board: BoolArray
    """Which of them touched a board on their way."""
    by_rim: BoolArray
    """Which of them touched the rim."""
    time: FloatArray
    """From the muzzle to the opening [s], NaN for those that do not come through its plane."""
    place: FloatArray
    """Where they come through the plane of the opening [m], NaN for the others, shape (n, 3)."""
    vel: FloatArray
    """Velocity there [m/s], shape (n, 3)."""


class _Face:
    """A panel as balls of one surface meet it from the side of the opening's middle."""

    def __init__(self, panel: Panel, surface: TerrainSurface, middle: FloatArray) -> None:
        self.corners, normal = panel.corners, _normal(panel.corners)
        self.normal = normal if normal @ (middle - panel.corners[0]) > 0.0 else -normal
        self.restitution = pair_restitution(surface.restitution, panel.surface.restitution)
        self.friction = pair_friction(surface.friction, panel.surface.friction)

    def shares(self, start: FloatArray, end: FloatArray, radius: FloatArray) -> FloatArray:
        """Share of straight ways (n, 3) after which balls meet it, infinite for those that do not, shape (n,)."""
        gap = (start - self.corners[0]) @ self.normal - radius
        after = (end - self.corners[0]) @ self.normal - radius
        due = (after < 0.0) & (after < gap) & (gap > -_SKIN)
        share = np.where(due, np.maximum(gap, 0.0) / np.where(due, np.maximum(gap, 0.0) - after, 1.0), np.inf)
        rows = np.nonzero(due)[0]
        missed = rows[~_within(self.corners, start[rows] + share[rows, None] * (end - start)[rows])]
        share[missed] = np.inf
        return share

    def normal_at(self, pos: FloatArray) -> FloatArray:
        """Direction in which it pushes a ball at a place, shape (3,)."""
        return self.normal


class _Edge:
    """An edge of the rim, sharp, as balls of one surface meet it."""

    def __init__(self, edge: tuple[Vector, Vector], rim: TerrainSurface, surface: TerrainSurface) -> None:
        self.start = np.array(edge[0])
        line = np.array(edge[1]) - self.start
        self.length = float(np.linalg.norm(line))
        self.along = line / self.length
        self.restitution = pair_restitution(surface.restitution, rim.restitution)
        self.friction = pair_friction(surface.friction, rim.friction)

    def shares(self, start: FloatArray, end: FloatArray, radius: FloatArray) -> FloatArray:
        """As `_Face.shares`: where the way comes as near to the edge's line as the radius."""
        away, move = self._across(start - self.start), self._across(end - start)
        a, b = np.einsum("ij,ij->i", move, move), np.einsum("ij,ij->i", away, move)
        c = np.einsum("ij,ij->i", away, away) - np.square(radius)
        root = np.square(b) - a * c
        meets = (b < 0.0) & (root > 0.0)
        share = np.where(meets, np.maximum(-b - np.sqrt(np.maximum(root, 0.0)), 0.0) / np.where(meets, a, 1.0), np.inf)
        share[share >= 1.0] = np.inf
        rows = np.nonzero(np.isfinite(share))[0]
        there = (start[rows] + share[rows, None] * (end - start)[rows] - self.start) @ self.along
        share[rows[(there < 0.0) | (there > self.length)]] = np.inf
        return share

    def normal_at(self, pos: FloatArray) -> FloatArray:
        """Direction in which it pushes a ball at a place, shape (3,)."""
        away = self._across(pos - self.start)
        unit: FloatArray = away / np.linalg.norm(away)
        return unit

    def _across(self, ways: FloatArray) -> FloatArray:
        """What of ways (..., 3) is at right angles to the edge."""
        across: FloatArray = ways - (ways @ self.along)[..., None] * self.along
        return across


def fly_to_opening(
    shots: FlightState, opening: ShotOpening, zone: Zone, surface: TerrainSurface, *, downward: bool = True,
    gravity: float = GRAVITY,
) -> ShotOutcomes:  # fmt: skip
    """Fly shots until they are in, or past the opening.

    Args:
        shots: From their muzzles on.
        opening: What they are to fall through.
        zone: Where they score.
        surface: Of the pieces.
        downward: Whether only falling pieces score.
        gravity: Along -z [m/s^2].
    """
    n = len(shots)
    found = ShotOutcomes(
        goes_in=np.zeros(n, dtype=bool), by_board=np.zeros(n, dtype=bool), by_rim=np.zeros(n, dtype=bool),
        time=np.full(n, np.nan), place=np.full((n, 3), np.nan), vel=np.full((n, 3), np.nan),
    )  # fmt: skip
    middle, inward, reach = opening.middle, opening.inward, opening.reach
    lowest = min(z for _, _, z in opening.corners)
    parts: list[_Face | _Edge] = [_Face(panel, surface, middle) for panel in (*opening.boards, *opening.walls)]
    first_edge = len(parts)
    parts += [_Edge(edge, opening.rim_surface, surface) for edge in opening.bare_rim]
    row: IntArray = np.arange(n)
    flying, is_within = shots, np.zeros(n, dtype=bool)
    for tick in range(_LONGEST):
        if not len(row):
            break
        before, flying = flying, flying.advanced(TICK, gravity=gravity)
        start = before.pos
        touches: BoolArray = np.zeros(len(row), dtype=bool)
        way = np.linalg.norm(flying.pos - start, axis=1)
        near = np.nonzero(np.linalg.norm(flying.pos - middle, axis=1) < reach + flying.radius + way)[0]
        if len(near):
            hit, part = _bounce(flying, near, before, parts, gravity)
            found.by_board[row[hit[part < len(opening.boards)]]] = True
            found.by_rim[row[hit[part >= first_edge]]] = True
        pos, vel = flying.pos, flying.vel
        passed_at = crossing(start, pos, middle, inward)
        passes: BoolArray = np.isfinite(passed_at)
        if passes.any():
            share, there = passed_at[passes, None], row[passes]
            found.place[there] = start[passes] + share * (pos - start)[passes]
            found.vel[there] = before.vel[passes] + share * (vel - before.vel)[passes]
            found.time[there] = TICK * (tick + passed_at[passes])
            touches[passes] |= ~opening.holds(found.place[there]) | (downward & (vel[passes, 2] >= 0.0))
        comes_out = np.isfinite(crossing(start, pos, middle, -inward))
        if comes_out.any():  # what has never been in has come through a wall from below
            touches[comes_out] |= ~is_within[comes_out] & opening.holds(pos[comes_out])
        depth = (pos - middle) @ inward
        is_within = (is_within | passes) & (depth >= 0.0)
        scores = is_within & ((vel[:, 2] < 0.0) | (not downward)) & zone.crossed(start, pos)
        # What is deep enough to be clear of the rim, and has not the energy to rise to it any more, falls in.
        turning = 0.2 * np.square(flying.radius) * np.einsum("ij,ij->i", flying.spin, flying.spin)
        energy = 0.5 * np.einsum("ij,ij->i", vel, vel) + turning + gravity * (pos[:, 2] - lowest)
        is_in = (scores | (is_within & (depth >= flying.radius) & (energy < 0.0))) & ~touches
        found.goes_in[row[is_in]] = True
        is_past = (vel[:, 2] < 0.0) & (pos[:, 2] < lowest - flying.radius) & ~is_within
        left = ~(touches | is_in | is_past)
        if not left.all():
            flying, row, is_within = flying.only(left), row[left], is_within[left]
    return found


def _bounce(
    flying: FlightState, rows: IntArray, before: FlightState, parts: list[_Face | _Edge], gravity: float
) -> tuple[IntArray, IntArray]:
    """Play the impacts of a tick; gives the row and the number of the part of each.

    `flying` is what all are at the end of the tick if nothing is met, changed where something is of the rows that may;
    `before` is what they are as it begins.
    """
    flying.spin = flying.spin.copy()  # `before` keeps its own
    now, left = before.only(rows), np.full(len(rows), TICK)
    hit_rows, hit_parts = [rows[:0]], [rows[:0]]
    for _ in range(_MOST_IMPACTS):
        first, which = np.full(len(rows), np.inf), np.full(len(rows), -1)
        for number, part in enumerate(parts):
            share = part.shares(now.pos, flying.pos[rows], now.radius)
            earlier = share < first
            first[earlier], which[earlier] = share[earlier], number
        hit = np.nonzero(which >= 0)[0]
        if not len(hit):
            return np.concatenate(hit_rows), np.concatenate(hit_parts)
        rows, first, left, which = rows[hit], first[hit], left[hit], which[hit]
        now = now.only(hit).advanced((first * left)[:, None], gravity=gravity)
        for k, part in enumerate(parts[number] for number in which.tolist()):
            (vx, vy, vz), (wx, wy, wz) = now.vel[k].tolist(), now.spin[k].tolist()
            x, y, z = part.normal_at(now.pos[k]).tolist()
            now.vel[k], now.spin[k] = hit_surface(
                (vx, vy, vz), (wx, wy, wz), (x, y, z), radius=float(now.radius[k]),
                restitution=part.restitution, friction=part.friction,
            )  # fmt: skip
        hit_rows.append(rows)
        hit_parts.append(which)
        left = left * (1.0 - first)
        after_hit = now.advanced(left[:, None], gravity=gravity)
        flying.pos[rows], flying.vel[rows], flying.spin[rows] = after_hit.pos, after_hit.vel, now.spin
    flying.pos[rows], flying.vel[rows] = now.pos, now.vel  # it lies on a panel: what is left of the tick it stays there
    return np.concatenate(hit_rows), np.concatenate(hit_parts)


def _normal(corners: tuple[Vector, ...]) -> FloatArray:
    """Unit normal, on either side, shape (3,)."""
    first, second, third = np.array(corners[:3])
    normal: FloatArray = np.cross(second - first, third - second)
    unit: FloatArray = normal / np.linalg.norm(normal)
    return unit


def _within(corners: tuple[Vector, ...], points: FloatArray) -> BoolArray:
    """Which points (n, 3), looked at along the normal, are within a convex outline, shape (n,)."""
    rows = np.array(corners)
    inside: BoolArray = np.ones(len(points), dtype=bool)
    # from each edge toward the inside; np.cross of all of them takes 40 us, and of one as much
    for corner, toward in zip(rows, np.cross(_normal(corners), np.roll(rows, -1, axis=0) - rows), strict=True):
        inside &= (points - corner) @ toward >= 0.0
    return inside


def _require_outline(part: Panel | ShotOpening) -> None:
    """Refuse what is no flat, convex outline."""
    owner, corners = type(part).__name__, part.corners
    require_fields(part, corners=[(FIELD_PLACE,) * 3])
    if len(corners) < 3:
        raise ConfigError(f"{owner}: corners must be three or more, got {len(corners)}")
    rows = np.array(corners)
    sides = np.roll(rows, -1, axis=0) - rows
    turns = np.cross(sides, np.roll(sides, -1, axis=0))
    if not (turns @ turns[0] > 0.0).all() or float(np.abs((rows - rows[0]) @ _normal(corners)).max()) > _FLAT:
        raise ConfigError(f"{owner}: corners must go around a flat, convex outline, got {corners}")
