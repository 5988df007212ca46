"""Impacts of fast balls at their own instant, whatever the length of a sub-step.

The engine finds a contact at the start of the sub-step after it, when a fast ball is already deep in a wall or in
another ball: speeds come out right, but the ball starts again from there, so that the height of a bounce depends on
the phase of the hit (-37 to -2 % from 2 m). So the paths of fast balls are followed ahead of each sub-step, with the
time of each impact and the velocities after it (`impact_law`). Such a ball moves through the sub-step by the straight
line to where it is at its end, and then gets the velocity that it has there; pushes from elsewhere add to it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from simcore.geometry.rotation import Vector
from simcore.physics.surface import TerrainSurface
from simcore.physics.world import PhysicsWorld
from simcore.pieces.impact_law import hit_ball, hit_surface
from simcore.pieces.pool import PiecePool
from simcore.pieces.touching import TOUCH, lengths, touching_chain
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["Impacts"]

_LEAST_APPROACH = 0.1  # [m/s]; slower ones are left to the engine: a bounce of 0.5 mm
_LEAST_BOUNCE = 0.3  # [m/s]; slower ones rise by less than 5 mm, and the engine goes on with them
_FAST = 6.0  # [m/s]; balls that are all slower are left to the engine: they overlap by at most 70 mm in a sub-step
_STEEPEST = 3.0  # distance along the path over distance to the surface: 71 degrees from the normal, and the engine's
_SKIN = 0.003  # [m]; the surface under the touching point may be this far off the one that the center would meet
_MOST_SURFACES = 4  # impacts of one ball on surfaces in a sub-step
_GENTLE = 0.03  # share of the fastest speed; a row of inelastic balls has no end of gentler impacts on each other
_MOST_EVENTS = 2000  # impacts of balls on each other in a sub-step
_KNOCK_REACH, _KNOCK_WAYS = 0.3, 4.0  # [m] and ways of a tick, as far as a knock may get from a fast ball in a tick
_KNOCK_LENGTH = 20  # balls of a row, each of which takes a third of the knock
_STANDS = 0.05  # [m/s]; slower balls are where they were at the start of the tick, until they are hit
_SLOW = 3.0  # [m/s]; balls that were hit by a fast one count as fast down to this


class _Path:
    """One ball in a sub-step: straight lines between impacts."""

    __slots__ = ("bounced", "is_falling", "is_near", "pos", "rests", "slot", "spin", "start", "time", "touched", "vel")

    def __init__(self, slot: int, pos: list[float], vel: list[float], spin: list[float], is_falling: bool) -> None:
        self.slot = slot
        self.start = (pos[0], pos[1], pos[2])
        self.pos: Vector = self.start
        self.vel: Vector = (vel[0], vel[1], vel[2])
        self.spin: Vector = (spin[0], spin[1], spin[2])
        self.time = 0.0
        self.is_falling = is_falling
        self.is_near = True  # an element of the field may be in reach
        self.touched = False
        self.rests = False
        self.bounced = True

    def at(self, time: float) -> Vector:
        """Where it is at a time of the sub-step."""
        t, (x, y, z), (vx, vy, vz) = time - self.time, self.pos, self.vel
        return x + vx * t, y + vy * t, z + vz * t

    def turn(self, time: float, pos: Vector, vel: Vector, spin: Vector) -> None:
        """Go on from an impact."""
        self.time, self.pos, self.vel, self.spin, self.touched = time, pos, vel, spin, True
        self.is_near = True


class Impacts:
    """Finds and plays the impacts of fast balls on surfaces and on each other.

    Args:
        world: Where the bodies live.
        pool: The pieces.
        wake: Lets a sleeping piece move: called with its slot.
    """

    def __init__(self, world: PhysicsWorld, pool: PiecePool, wake: Callable[[int], None]) -> None:
        self._world = world
        self._pool = pool
        self._wake = wake
        self._is_needed = not world.engine.is_exact
        self._near: IntArray = np.zeros(0, dtype=np.int64)
        self._moves: BoolArray = np.zeros(0, dtype=bool)  # of those near
        self._was_hit = np.zeros(len(pool.rows), dtype=bool)
        self._pending: dict[int, tuple[Vector, Vector]] = {}
        self.bounced = np.zeros(len(pool.rows), dtype=bool)
        """Which slots have had an impact since this was last cleared, shape (slots,)."""

    # --- once a tick ------------------------------------------------------------------------------------------------

    def begin_tick(self, awake: IntArray, speed: FloatArray, busy: BoolArray, dt: float) -> None:
        """Find the balls that may hit each other fast within a tick, and wake them.

        Args:
            awake: Slots that the engine moves, shape (n,).
            speed: Of each [m/s], shape (n,).
            busy: Which slots are within reach of a robot: those the engine plays with it, shape (slots,).
            dt: Length of the tick [s].
        """
        state, radius = self._pool.state, self._pool.radius
        is_fast = speed > _FAST
        is_fast |= (speed > _SLOW) & self._was_hit[awake]
        fast = awake[is_fast & self._pool.is_ball[awake] & ~busy[awake]]
        self._was_hit[:] = False
        self._near = self._near[:0]
        if not len(fast):
            return
        pos, way = state.pos[fast], state.vel[fast] * dt
        length = lengths(way)
        reach = (_KNOCK_REACH + _KNOCK_WAYS * length)[:, None]
        others = np.nonzero(self._pool.is_on_field & self._pool.is_ball & ~busy)[0]
        there = state.pos[others]
        others = others[((there > (pos - reach).min(axis=0)) & (there < (pos + reach).max(axis=0))).all(axis=1)]
        away = state.pos[others][None, :, :] - pos[:, None, :]
        along = np.clip(np.einsum("ijk,ik->ij", away, way) / np.square(length)[:, None], 0.0, 1.0)
        aside = away - along[:, :, None] * way[:, None, :]
        moves = lengths(state.vel[others]) * dt
        touch = radius[fast][:, None] + (radius[others] + moves)[None, :] + TOUCH + self._world.gravity * dt * dt
        meets = (np.einsum("ijk,ijk->ij", aside, aside) < touch * touch) & (fast[:, None] != others[None, :])
        if meets.any():
            reached = touching_chain(state.pos[others], radius[others], meets.any(axis=0), _KNOCK_LENGTH)
            for slot in others[reached & self._pool.is_frozen[others]].tolist():
                self._wake(slot)
            if self._is_needed:
                self._near, self._moves = others, moves > _STANDS * dt

    @property
    def is_due(self) -> bool:
        """Whether balls may hit each other in this tick."""
        return len(self._near) > 0

    # --- once a sub-step --------------------------------------------------------------------------------------------

    def finish(self) -> None:
        """Give the balls of the last sub-step the velocities that they have after their impacts."""
        if not self._pending:
            return
        engine, rows = self._world.engine, self._pool.rows
        for slot, (change, spin) in self._pending.items():
            row = rows[slot]
            vel, _ = engine.velocity(row)
            engine.set_velocity(row, (vel[0] + change[0], vel[1] + change[1], vel[2] + change[2]), spin)
        self._pending.clear()

    def forget(self, slot: int) -> None:
        """A ball was put elsewhere or given a velocity: what it was about to have is of no use."""
        self._pending.pop(slot, None)

    def play(self, h: float, slots: IntArray, centers: FloatArray, middle: FloatArray, spin: FloatArray) -> BoolArray:
        """Play the impacts of the sub-step to come; those who have one are on their way already.

        Args:
            h: Length of the sub-step [s].
            slots: Balls in free flight.
            centers: Where each is [m], shape (n, 3).
            middle: Velocity of each in the middle of the sub-step, if nothing is met [m/s], shape (n, 3).
            spin: Angular velocity of each [rad/s], shape (n, 3).

        Returns:
            Which of `slots` are on their way: nothing else may push them in this sub-step, shape (n,).
        """
        taken = np.zeros(len(slots), dtype=bool)
        is_ball = self._pool.is_ball[slots]
        others_near = len(self._near) > 0
        if not (self._is_needed and (others_near or np.count_nonzero(is_ball))):
            return taken
        near_field, falls = self._may_meet(h, centers, middle, self._pool.radius[slots])
        played = is_ball if others_near else is_ball & (near_field | falls)
        flying: dict[int, _Path] = {}
        for number in played.nonzero()[0].tolist():
            slot = int(slots[number])
            path = _Path(slot, centers[number].tolist(), middle[number].tolist(), spin[number].tolist(), True)
            path.is_near = bool(near_field[number])
            flying[slot] = path
        if others_near:
            self._play_balls(h, flying)
        if flying:
            self._play_surfaces(h, [path for path in flying.values() if path.is_falling])
        for path in flying.values():
            if path.touched:
                self._send(path, h)
                taken[slots == path.slot] = True
        return taken

    def _may_meet(
        self, h: float, center: FloatArray, vel: FloatArray, radius: FloatArray
    ) -> tuple[BoolArray, BoolArray]:
        """Which balls can meet an element of the field in a sub-step, and which the floor, shape (n,) each."""
        fall = vel[:, 2]
        falls: BoolArray = (fall <= -_LEAST_APPROACH) & (center[:, 2] + fall * h < radius + _SKIN)
        return self._world.near_field(center, radius + lengths(vel) * h + _SKIN), falls

    def _send(self, path: _Path, h: float) -> None:
        """Let a ball reach the end of its path within the sub-step, and remember how it goes on."""
        engine, row = self._world.engine, self._pool.rows[path.slot]
        gravity = self._world.gravity if path.is_falling else 0.0
        self._wake(path.slot)
        self.bounced[path.slot] = path.bounced
        end = path.at(h)
        line = [(b - a) / h for a, b in zip(path.start, end, strict=True)]
        engine.set_velocity(row, (line[0], line[1], line[2] + gravity * h), path.spin)
        vx, vy, vz = path.vel
        after = vz if path.rests else vz - 0.5 * gravity * (h - path.time)
        self._pending[path.slot] = (vx - line[0], vy - line[1], after - line[2]), path.spin

    # --- balls on balls ---------------------------------------------------------------------------------------------

    def _play_balls(self, h: float, flying: dict[int, _Path]) -> None:
        """Impacts of balls on each other, in the order of their instants."""
        engine, pool, near = self._world.engine, self._pool, self._near
        active = np.nonzero(self._moves)[0]
        rows = pool.rows_of(near[active])
        pos, vel, spin = pool.state.pos[near], np.zeros((len(near), 3)), np.zeros((len(near), 3))
        pos[active], twists = engine.centers(rows), engine.velocities(rows)
        vel[active], spin[active] = twists[:, :3], twists[:, 3:]
        for number in active.tolist():
            path = flying.get(int(near[number]))
            if path is not None:
                vel[number] = path.vel
        least = max(_LEAST_APPROACH, _GENTLE * math.sqrt(float(np.einsum("ij,ij->i", vel, vel).max())))
        contact = pool.radius[near]
        now, times = 0.0, _meeting_times(pos, vel, contact, active, least)
        for _ in range(_MOST_EVENTS):
            k, j = divmod(int(np.argmin(times)), len(near))
            wait = float(times[k, j])
            if now + wait > h:
                return
            now += wait
            pos += vel * wait
            times -= wait
            i = int(active[k])
            if not self._moves[j]:  # from now on it moves
                self._moves[j] = True
                active = np.append(active, j)
                times = np.vstack((times, np.full(len(near), np.inf)))
            paths = []
            for number in (i, j):
                slot = int(near[number])
                path = flying.get(slot)
                if path is None:
                    start = pos[number] - vel[number] * now
                    path = _Path(slot, start.tolist(), vel[number].tolist(), spin[number].tolist(), False)
                    flying[slot] = path
                paths.append(path)
            self._hit(paths[0], paths[1], now, pos[i].tolist(), pos[j].tolist())
            vel[i], vel[j] = paths[0].vel, paths[1].vel
            changed = np.array([i, j])
            found = _meeting_times(pos, vel, contact, changed, least)
            for number, one in zip((i, j), found, strict=True):
                times[:, number] = one[active]
                times[active == number] = one

    def _hit(self, a: _Path, b: _Path, time: float, pos_a: list[float], pos_b: list[float]) -> None:
        pool = self._pool
        away = [p - q for p, q in zip(pos_a, pos_b, strict=True)]
        if not (a.is_falling or b.is_falling) and abs(away[2]) < _SKIN:
            away[2] = 0.0  # both roll on one surface, a little pressed into it
        distance = math.hypot(*away)
        sa, sb = pool.surfaces[a.slot], pool.surfaces[b.slot]
        (va, vb), (wa, wb) = hit_ball(
            (a.vel, b.vel),
            (a.spin, b.spin),
            (away[0] / distance, away[1] / distance, away[2] / distance),
            radii=(float(pool.radius[a.slot]), float(pool.radius[b.slot])),
            masses=(float(pool.mass[a.slot]), float(pool.mass[b.slot])),
            restitution=sa.restitution * sb.restitution,
            friction=sa.friction * sb.friction,
        )
        for path, pos, vel, spin in ((a, pos_a, va, wa), (b, pos_b, vb, wb)):
            if not path.is_falling and vel[2] < 0.0:  # something carries it
                vel = (vel[0], vel[1], 0.0)
            path.turn(time, (pos[0], pos[1], pos[2]), vel, spin)
            self._was_hit[path.slot] = True

    # --- balls on surfaces ------------------------------------------------------------------------------------------

    def _play_surfaces(self, h: float, paths: list[_Path]) -> None:
        """Impacts on the floor and on statics, each ball for itself."""
        for _ in range(_MOST_SURFACES):
            if not paths:
                return
            found = self._first_surfaces(h, paths)
            again = []
            for path, hit in zip(paths, found, strict=True):
                if hit is None:
                    continue
                time, normal, surface = hit
                own = self._pool.surfaces[path.slot]
                late = 0.5 * self._world.gravity * (path.time + h - 2.0 * time)  # from the mean of the rest to now
                vx, vy, vz = path.vel
                vel, spin = hit_surface(
                    (vx, vy, vz + late),
                    path.spin,
                    normal,
                    radius=float(self._pool.radius[path.slot]),
                    restitution=own.restitution * surface.restitution,
                    friction=own.friction * surface.friction,
                )
                away = vel[0] * normal[0] + vel[1] * normal[1] + vel[2] * normal[2]
                path.rests = away < _LEAST_APPROACH
                path.bounced = away > _LEAST_BOUNCE
                rest = 0.0 if path.rests else 0.5 * self._world.gravity * (h - time)
                path.turn(time, path.at(time), (vel[0], vel[1], vel[2] - rest), spin)
                if not path.rests:
                    again.append(path)
            paths = again

    def _first_surfaces(self, h: float, paths: list[_Path]) -> list[tuple[float, Vector, TerrainSurface] | None]:
        """When each path meets the first surface, with its normal and material; None where it meets none in time."""
        radius = self._pool.radius
        found: list[tuple[float, Vector, TerrainSurface] | None] = [self._floor(path, h) for path in paths]
        if not any(path.is_near for path in paths):
            return found
        pos = np.array([path.pos for path in paths])
        vel = np.array([path.vel for path in paths])
        speed = np.maximum(lengths(vel), 1e-9)
        ahead = vel / speed[:, None]
        left = speed * (h - np.array([path.time for path in paths]))
        size = radius[[path.slot for path in paths]]
        hits = self._world.solid_rays(pos, pos + ahead * (left + _STEEPEST * size)[:, None])
        if not (hits.row >= 0).any():
            return found
        incidence = -np.einsum("ij,ij->i", ahead, hits.normal)
        steep = (hits.row >= 0) & (incidence > 1.0 / _STEEPEST)
        distance = hits.fraction * (left + _STEEPEST * size) - size / np.maximum(incidence, 1.0 / _STEEPEST)
        due = steep & (distance < left) & (distance > -_SKIN) & (incidence * speed > _LEAST_APPROACH)
        for number in np.nonzero(due)[0].tolist():
            path = paths[number]
            time = path.time + max(0.0, float(distance[number])) / float(speed[number])
            earlier = found[number]
            if earlier is not None and earlier[0] <= time:
                continue
            normal = hits.normal[number]
            if self._is_touching(np.array(path.at(time)), normal, float(size[number])):
                nx, ny, nz = normal.tolist()
                found[number] = time, (nx, ny, nz), self._world.surface(int(hits.row[number]))
        return found

    def _is_touching(self, center: FloatArray, normal: FloatArray, radius: float) -> bool:
        """Whether the surface that the center would have met is also under the touching point."""
        hit = self._world.solid_rays(center[None], (center - normal * (radius + _SKIN))[None])
        if hit.row[0] < 0:
            return False
        depth = float(hit.fraction[0]) * (radius + _SKIN)
        return depth > radius - _SKIN and float(hit.normal[0] @ normal) > 0.99

    def _floor(self, path: _Path, h: float) -> tuple[float, Vector, TerrainSurface] | None:
        """When a path meets the floor at z = 0."""
        surface = self._world.floor
        fall = -path.vel[2]
        if surface is None or fall < _LEAST_APPROACH:
            return None
        height = path.pos[2] - float(self._pool.radius[path.slot])
        time = path.time + max(0.0, height) / fall
        if height < -_SKIN or time > h:
            return None
        return time, (0.0, 0.0, 1.0), surface


def _meeting_times(pos: FloatArray, vel: FloatArray, radius: FloatArray, some: IntArray, least: float) -> FloatArray:
    """When some balls touch each of all [s], inf for never or too gently, shape (some, n).

    Args:
        pos: Centers, shape (n, 3).
        vel: Velocities, shape (n, 3).
        radius: Shape (n,).
        some: Rows.
        least: Approach that counts as an impact [m/s].
    """
    away = pos[None, :, :] - pos[some][:, None, :]
    closing = vel[None, :, :] - vel[some][:, None, :]
    contact = np.square(radius[some][:, None] + radius[None, :])
    along = np.einsum("ijk,ijk->ij", away, closing)
    speed2 = np.einsum("ijk,ijk->ij", closing, closing)
    gap = np.einsum("ijk,ijk->ij", away, away) - contact
    root = along * along - speed2 * gap
    meet = (along < 0.0) & (root > 0.0) & (along * along > least * least * contact)
    times: FloatArray = np.full(meet.shape, np.inf)
    times[meet] = np.maximum(gap[meet], 0.0) / (np.sqrt(root[meet]) - along[meet])
    return times
