"""Flights of many shots at an opening at once, by the equations that the engine's flights follow.

A shot goes in if it comes down through the opening, stays clear of the rim all along, and does not bounce out again.
Boards and walls send it back by the law of all impacts here. Only the edge under a board may be touched: what comes
so far falls in along the board. A shot that touches the rim elsewhere may still drop in, and does not count.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simcore.geometry.zones import Zone, line_distance
from simcore.physics.surface import TerrainSurface
from simcore.pieces.aerodynamics import AirRows, fly_rows
from simcore.pieces.impact_law import hit_surface
from simcore.pieces.shot_opening import Panel, ShotOpening
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import TICK

__all__ = ["ShotOutcomes", "ShotRows", "fly_to_opening"]

_LONGEST = 300  # ticks; 6 s, as long as a shot to a height of 40 m
_MOST_IMPACTS = 4  # in a tick
_SKIN = 0.01  # [m]; what is deeper behind a panel has come from its other side


@dataclass(slots=True, kw_only=True)
class ShotRows:
    """Shots at the instant at which they leave their muzzles, one a row, field frame."""

    pos: FloatArray
    """Centers [m], shape (n, 3)."""
    vel: FloatArray
    """[m/s], shape (n, 3)."""
    spin: FloatArray
    """Angular velocity [rad/s], shape (n, 3)."""
    radius: FloatArray
    """Of the balls [m], shape (n,)."""
    air: AirRows

    def __len__(self) -> int:
        return len(self.pos)

    def only(self, rows: IntArray | BoolArray) -> ShotRows:
        """Some of them."""
        air = AirRows(
            drag=self.air.drag[rows], lift=self.air.lift[rows], lift_saturation=self.air.lift_saturation[rows]
        )
        return ShotRows(pos=self.pos[rows], vel=self.vel[rows], spin=self.spin[rows], radius=self.radius[rows], air=air)


@dataclass(slots=True, kw_only=True)
class ShotOutcomes:
    """What became of shots, one a row."""

    goes_in: BoolArray
    """Shape (n,)."""
    by_board: BoolArray
    """Which of them touched a board on their way, shape (n,)."""
    time: FloatArray
    """From the muzzle to the opening [s], NaN for those that do not come down through its plane, shape (n,)."""
    place: FloatArray
    """Where they come down through the plane of the opening [m], NaN for the others, shape (n, 3)."""
    vel: FloatArray
    """Velocity there [m/s], shape (n, 3)."""


def fly_to_opening(
    shots: ShotRows, opening: ShotOpening, zone: Zone, surface: TerrainSurface, *, gravity: float
) -> ShotOutcomes:
    """Fly shots until they are in, past the opening, or on its rim.

    Args:
        shots: From their muzzles on.
        opening: What they are to fall through.
        zone: Where they score.
        surface: Of the pieces.
        gravity: Along -z [m/s^2].
    """
    n = len(shots)
    found = ShotOutcomes(
        goes_in=np.zeros(n, dtype=bool), by_board=np.zeros(n, dtype=bool), time=np.full(n, np.nan),
        place=np.full((n, 3), np.nan), vel=np.full((n, 3), np.nan),
    )  # fmt: skip
    middle, inward, rim, reach = opening.middle, opening.inward, opening.bare_rim, opening.reach
    lowest = min(z for _, _, z in opening.corners)
    panels = [_Face(panel, surface, middle) for panel in (*opening.boards, *opening.walls)]
    row: IntArray = np.arange(n)
    flying = shots.only(row)  # own arrays, which shrink
    is_within: BoolArray = np.zeros(n, dtype=bool)
    for tick in range(_LONGEST):
        if not len(row):
            break
        start, start_vel = flying.pos.copy(), flying.vel.copy()
        flying.pos, flying.vel = fly_rows(start, start_vel, flying.spin, TICK, gravity=gravity, factors=flying.air)
        touches: BoolArray = np.zeros(len(row), dtype=bool)
        way = np.linalg.norm(flying.pos - start, axis=1)
        near = np.nonzero(np.linalg.norm(flying.pos - middle, axis=1) < reach + flying.radius + way)[0]
        if len(near):
            by_board = _bounce(flying, near, start, start_vel, panels, len(opening.boards), gravity)
            found.by_board[row[by_board]] = True
            for a, b in rim:
                touches[near] |= line_distance(start[near], flying.pos[near], a, b) < flying.radius[near]
        pos, vel = flying.pos, flying.vel
        depth_before, depth = (start - middle) @ inward, (pos - middle) @ inward
        passes = (depth_before < 0.0) & (depth >= 0.0)
        if passes.any():
            share = (depth_before[passes] / (depth_before - depth)[passes])[:, None]
            found.place[row[passes]] = start[passes] + share * (pos - start)[passes]
            found.vel[row[passes]] = start_vel[passes] + share * (vel - start_vel)[passes]
            found.time[row[passes]] = TICK * (tick + share[:, 0])
            touches[passes] |= ~opening.holds(found.place[row[passes]]) | (vel[passes, 2] >= 0.0)
        comes_out = (depth_before >= 0.0) & (depth < 0.0)
        if comes_out.any():  # what has never been in has come through a wall from below
            touches[comes_out] |= ~is_within[comes_out] & opening.holds(pos[comes_out])
        is_within = (is_within | passes) & (depth >= 0.0)
        scores = is_within & (vel[:, 2] < 0.0) & zone.crossed(start, pos)
        # What is deep enough to be clear of the rim, and has not the energy to rise to it any more, falls in.
        turning = 0.2 * np.square(flying.radius) * np.einsum("ij,ij->i", flying.spin, flying.spin)
        energy = 0.5 * np.einsum("ij,ij->i", vel, vel) + turning + gravity * (pos[:, 2] - lowest)
        is_caught = is_within & (depth >= flying.radius) & (energy < 0.0)
        is_in = (scores | is_caught) & ~touches
        found.goes_in[row[is_in]] = True
        is_past = (vel[:, 2] < 0.0) & (pos[:, 2] < lowest - flying.radius) & ~is_within
        left = ~(touches | is_in | is_past)
        if not left.all():
            flying, row, is_within = flying.only(left), row[left], is_within[left]
    return found


class _Face:
    """A panel as balls of one surface meet it from the side of the opening's middle."""

    def __init__(self, panel: Panel, surface: TerrainSurface, middle: FloatArray) -> None:
        self.holds = panel.holds
        self.origin = np.array(panel.corners[0])
        side = panel.normal @ (middle - self.origin)
        self.normal = panel.normal if side > 0.0 else -panel.normal
        x, y, z = self.normal.tolist()
        self.toward = (x, y, z)
        self.restitution = surface.restitution * panel.surface.restitution
        self.friction = surface.friction * panel.surface.friction


def _bounce(
    flying: ShotRows,
    rows: IntArray,
    start: FloatArray,
    start_vel: FloatArray,
    faces: Sequence[_Face],
    boards: int,
    gravity: float,
) -> IntArray:
    """Play the impacts of a tick on panels, in place.

    Args:
        flying: At the end of the tick if nothing is met; changed where something is.
        rows: Which may meet something.
        start: Where all were as the tick began [m], shape (n, 3).
        start_vel: Their velocities then [m/s], shape (n, 3).
        faces: All panels.
        boards: How many of them, from the first on, are boards.
        gravity: Along -z [m/s^2].

    Returns:
        Which rows met a board.
    """
    pos, vel = start[rows], start_vel[rows]
    left = np.full(len(rows), TICK)
    on_board = []
    for _ in range(_MOST_IMPACTS):
        first, which = np.full(len(rows), np.inf), np.full(len(rows), -1)
        for number, face in enumerate(faces):
            before = (pos - face.origin) @ face.normal - flying.radius[rows]
            after = (flying.pos[rows] - face.origin) @ face.normal - flying.radius[rows]
            due = (after < 0.0) & (after < before) & (before > -_SKIN)
            share = np.where(due, np.maximum(before, 0.0) / np.where(due, np.maximum(before, 0.0) - after, 1.0), np.inf)
            earlier = np.nonzero(share < first)[0]
            if len(earlier):
                at = pos[earlier] + share[earlier, None] * (flying.pos[rows[earlier]] - pos[earlier])
                earlier = earlier[face.holds(at)]
                first[earlier], which[earlier] = share[earlier], number
        hit = np.nonzero(which >= 0)[0]
        if not len(hit):
            break
        rows, pos, vel, left, first, which = rows[hit], pos[hit], vel[hit], left[hit], first[hit], which[hit]
        on_board.append(rows[which < boards])
        some = flying.only(rows)
        pos, vel = fly_rows(pos, vel, some.spin, (first * left)[:, None], gravity=gravity, factors=some.air)
        for number, (slot, face_number) in enumerate(zip(rows.tolist(), which.tolist(), strict=True)):
            face = faces[face_number]
            (vx, vy, vz), (wx, wy, wz) = vel[number].tolist(), some.spin[number].tolist()
            vel[number], flying.spin[slot] = hit_surface(
                (vx, vy, vz), (wx, wy, wz), face.toward, radius=float(some.radius[number]),
                restitution=face.restitution, friction=face.friction,
            )  # fmt: skip
        left = left * (1.0 - first)
        flying.pos[rows], flying.vel[rows] = fly_rows(
            pos, vel, flying.spin[rows], left[:, None], gravity=gravity, factors=some.air
        )
    else:  # it lies on a panel: what is left of the tick it stays there
        flying.pos[rows], flying.vel[rows] = pos, vel
    return np.concatenate(on_board) if on_board else rows[:0]
