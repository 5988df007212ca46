"""The impacts of one part of a tick, each at its instant and in their order, whoever meets whom.

Between impacts a flying ball moves on a parabola (gravity and the air at the start of each arc); balls that lie move on
straight lines, because something carries them. What meets what first is found along the chords of the arcs, and its
instant on the arc itself. Robots move as they do at the start of the part.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simcore.geometry.rotation import Vector, matrix
from simcore.physics.surface import TerrainSurface
from simcore.physics.world import PhysicsWorld, RobotBody
from simcore.pieces.aerodynamics import air_acceleration
from simcore.pieces.impact_law import hit_ball, hit_surface
from simcore.pieces.pool import PiecePool
from simcore.pieces.touching import close_pairs, lengths
from simcore.typing import FloatArray, IntArray

__all__ = ["LEAST_BOUNCE", "Arc", "BallRows", "ImpactEvents"]

_LEAST_APPROACH = 0.1  # [m/s]; slower impacts have no restitution: a bounce of 0.5 mm
LEAST_BOUNCE = 0.15
"""A ball that leaves a level surface more slowly has come to lie on it [m/s]: it would rise by 1 mm."""
_GENTLE = 0.3  # [m/s]; slower impacts of balls on each other are the engine's, and all of what has come to lie
_SHARE = 0.01  # of the fastest: a row of inelastic balls has no end of gentler impacts
_MOST_OF_ONE = 10  # impacts of one ball on surfaces in a part: then it is caught between them, and squeezed
_STANDS = 1e-9  # [m/s]; slower is rounding
_LEVEL = 0.003  # [m]; balls that lie on one surface, a little pressed into it, push each other along it


class Arc:
    """One ball in a part of a tick, from its last impact on."""

    __slots__ = ("acc", "is_flying", "is_landing", "is_touched", "pos", "slot", "spin", "surfaces", "time", "vel")

    def __init__(self, slot: int, pos: Vector, vel: Vector, spin: Vector, acc: Vector | None, is_landing: bool) -> None:
        self.slot, self.pos, self.vel, self.spin = slot, pos, vel, spin
        self.is_flying = acc is not None
        self.acc = acc or (0.0, 0.0, 0.0)
        self.time = 0.0
        self.is_touched = False
        self.is_landing = is_landing
        self.surfaces = 0

    def at(self, time: float) -> Vector:
        """Where it is at a time of the part [m]."""
        t, (x, y, z), (vx, vy, vz), (ax, ay, az) = time - self.time, self.pos, self.vel, self.acc
        s = 0.5 * t * t
        return x + vx * t + ax * s, y + vy * t + ay * s, z + vz * t + az * s

    def velocity(self, time: float) -> Vector:
        """Its velocity at a time of the part [m/s]."""
        t, (vx, vy, vz), (ax, ay, az) = time - self.time, self.vel, self.acc
        return vx + ax * t, vy + ay * t, vz + az * t


@dataclass(slots=True, kw_only=True)
class BallRows:
    """Balls at the start of a part of a tick: k that fly, and then those that lie, n together."""

    slots: IntArray
    """Shape (n,)."""
    pos: FloatArray
    """[m], shape (n, 3)."""
    vel: FloatArray
    """[m/s], shape (n, 3)."""
    spin: FloatArray
    """[rad/s], shape (n, 3)."""
    acc: FloatArray
    """Of those that fly [m/s^2], shape (k, 3)."""
    is_landing: list[bool]
    """Which of those that fly have come to lie in an earlier part of the tick."""
    near_field: list[bool]
    """Which of those that fly may meet elements of the field, before any impact."""

    def arc(self, n: int) -> Arc:
        """How one begins the part."""
        is_flying = n < len(self.acc)
        acc = tuple(self.acc[n].tolist()) if is_flying else None
        pos, vel, spin = (tuple(rows[n].tolist()) for rows in (self.pos, self.vel, self.spin))
        return Arc(int(self.slots[n]), pos, vel, spin, acc, is_flying and self.is_landing[n])


@dataclass(slots=True)
class _Robot:
    """A robot in this part of the tick."""

    row: int
    body: RobotBody
    origin: FloatArray
    axes: FloatArray
    vel: FloatArray
    rate: FloatArray
    is_hit: bool = False

    @property
    def center(self) -> FloatArray:
        """Center of mass [m]."""
        center: FloatArray = self.origin + self.axes @ self.body.center_of_mass
        return center

    def velocity_at(self, place: FloatArray) -> FloatArray:
        velocity: FloatArray = self.vel + np.cross(self.rate, place - self.center)
        return velocity

    def inverse_mass(self, place: FloatArray, normal: FloatArray) -> float:
        """Of the body, where and along which it is hit [1/kg]."""
        turn = self.axes.T @ np.cross(place - self.center, normal)
        return 1.0 / self.body.mass + float((turn * turn / self.body.inertia).sum())

    def push(self, place: FloatArray, impulse: FloatArray) -> None:
        self.vel = self.vel + impulse / self.body.mass
        turn = self.axes.T @ np.cross(place - self.center, impulse) / self.body.inertia
        self.rate = self.rate + self.axes @ turn
        self.is_hit = True


@dataclass(slots=True)
class _Meeting:
    """What a ball meets next."""

    time: float
    normal: Vector
    surface: TerrainSurface | None = None
    robot: _Robot | None = None


_NEVER = _Meeting(math.inf, (0.0, 0.0, 1.0))


class ImpactEvents:
    """Plays the impacts of some balls on surfaces, on robots and on each other.

    Args:
        world: Where the bodies live.
        pool: The pieces.
    """

    def __init__(self, world: PhysicsWorld, pool: PiecePool) -> None:
        self._world = world
        self._pool = pool
        self._robots: list[_Robot] = []

    def play(self, h: float, balls: BallRows, robots: Sequence[int]) -> list[Arc]:
        """Play a part of a tick; returns how those that had an impact go on from the last one.

        Args:
            h: Length of the part [s].
            balls: Those that may meet something or each other, at the start of the part.
            robots: Rows of the robots that they may meet.
        """
        self._robots = [self._robot(row) for row in robots]
        slots, n = balls.slots, len(balls.near_field)
        radius = self._pool.radius[slots]
        chord = balls.vel.copy()
        chord[:n] += 0.5 * h * balls.acc
        base = balls.pos.copy()  # where the chord was at time 0
        knock = max(_GENTLE, _SHARE * float(lengths(chord).max(initial=0.0)))
        least = np.where(np.arange(len(slots)) < n, _GENTLE, knock)  # [m/s]
        times = _first_meetings(base, chord, radius, least, h)
        arcs = {k: balls.arc(k) for k in range(n)}
        next_surface = self._surfaces(h, list(arcs.values()), balls.near_field)
        surface_times = np.array([meeting.time for meeting in next_surface] + [math.inf])
        while True:
            pair, i = int(times.argmin()), int(surface_times.argmin())
            pair_time, surface_time = float(times.flat[pair]), float(surface_times[i])
            now = min(pair_time, surface_time)
            if not now <= h:
                break
            if pair_time < surface_time:
                changed = list(divmod(pair, len(slots)))
                for k in changed:
                    arcs[k] = arcs.get(k) or balls.arc(k)
                self._hit_balls(arcs[changed[0]], arcs[changed[1]], now)
            else:
                changed = [i]
                self._hit_surface(arcs[i], next_surface[i], now)
            for k in changed:
                base[k], chord[k] = _chord(arcs[k], h)
            away = (base + now * chord) - (base[changed] + now * chord[changed])[:, None]
            contact, gentle = radius + radius[changed][:, None], np.minimum(least, least[changed][:, None])
            found = now + _meeting_times(away, chord - chord[changed][:, None], contact, gentle)
            times[changed], times[:, changed] = found, found.T
            if some := [k for k in changed if k < n]:
                for k, meeting in zip(
                    some, self._surfaces(h, [arcs[k] for k in some], [True] * len(some)), strict=True
                ):
                    next_surface[k], surface_times[k] = meeting, meeting.time
        for robot in self._robots:
            if robot.is_hit:
                self._world.engine.set_velocity(robot.row, robot.vel.tolist(), robot.rate.tolist())
        return [arc for arc in arcs.values() if arc.is_touched]

    def _robot(self, row: int) -> _Robot:
        engine = self._world.engine
        pos, quat = engine.pose(row)
        vel, rate = engine.velocity(row)
        return _Robot(row, self._world.robot_bodies[row], np.array(pos), matrix(quat), np.array(vel), np.array(rate))

    # --- what is met --------------------------------------------------------------------------------------------

    def _surfaces(self, h: float, arcs: Sequence[Arc], near_field: Sequence[bool]) -> list[_Meeting]:
        """What each ball meets next of the floor, the field and robots."""
        found = [self._floor(h, arc) for arc in arcs]
        numbers = [n for n, arc in enumerate(arcs) if arc.is_flying and (near_field[n] or self._robots)]
        numbers = [n for n in numbers if arcs[n].surfaces < _MOST_OF_ONE]
        if not numbers:
            return found
        some = [arcs[n] for n in numbers]
        pos, radius = np.array([arc.pos for arc in some]), self._pool.radius[[arc.slot for arc in some]]
        start = np.array([arc.time for arc in some])
        left = h - start[:, None]
        chord = np.array([arc.vel for arc in some]) + 0.5 * left * np.array([arc.acc for arc in some])
        touch = self._world.first_touch(pos, left * chord, radius)
        for n, share, normal, row in zip(
            numbers, touch.fraction.tolist(), touch.normal, touch.tag.tolist(), strict=True
        ):
            if row >= 0:
                self._note(found, n, h, arcs[n], share, normal, self._world.surface(row))
        for robot in self._robots:
            away = pos - start[:, None] * robot.vel - robot.center
            away -= start[:, None] * np.cross(robot.rate, away)  # as the robot sees it at the start of the part
            relative = chord - robot.vel - np.cross(robot.rate, away)
            local = (away + robot.center - robot.origin) @ robot.axes
            touch = robot.body.surfaces.first_touch(local, left * relative @ robot.axes, radius)
            surface = self._world.surface(robot.row)
            for n, share, normal, row in zip(
                numbers, touch.fraction.tolist(), touch.normal, touch.tag.tolist(), strict=True
            ):
                if row >= 0:
                    self._note(found, n, h, arcs[n], share, robot.axes @ normal, surface, robot)
        return found

    def _note(
        self,
        found: list[_Meeting],
        n: int,
        h: float,
        arc: Arc,
        share: float,
        normal: FloatArray,
        surface: TerrainSurface,
        robot: _Robot | None = None,
    ) -> None:
        """Keep what a ball meets if it is the first: its instant is that on the arc, at the plane it meets."""
        left = h - arc.time
        relative = np.array(arc.vel)
        if robot is not None:
            relative = relative - robot.velocity_at(np.array(arc.pos) - arc.time * robot.vel)
        away = float(normal @ relative)
        pull = float(normal @ arc.acc)
        gap = max(0.0, -(away + 0.5 * pull * left) * share * left)
        if arc.is_landing and away > -_GENTLE:
            return
        time = arc.time + _fall_time(gap, away, pull)
        if time < found[n].time:
            x, y, z = normal.tolist()
            found[n] = _Meeting(time, (x, y, z), surface, robot)

    def _floor(self, h: float, arc: Arc) -> _Meeting:
        """When a ball meets the floor at z = 0."""
        if self._world.floor is None or not arc.is_flying or arc.surfaces >= _MOST_OF_ONE:
            return _NEVER
        gap = arc.pos[2] - float(self._pool.radius[arc.slot])
        if gap < -float(self._pool.radius[arc.slot]) or (arc.is_landing and arc.vel[2] > -_GENTLE):
            return _NEVER
        time = arc.time + _fall_time(max(0.0, gap), arc.vel[2], arc.acc[2])
        return _Meeting(time, (0.0, 0.0, 1.0), self._world.floor) if time <= h else _NEVER

    # --- what comes of it ---------------------------------------------------------------------------------------

    def _hit_surface(self, arc: Arc, meeting: _Meeting, now: float) -> None:
        pool, normal, robot = self._pool, meeting.normal, meeting.robot
        own, other = pool.surfaces[arc.slot], meeting.surface
        assert other is not None
        pos, vel, radius = arc.at(now), arc.velocity(now), float(pool.radius[arc.slot])
        moving, ratio = (0.0, 0.0, 0.0), 0.0
        n, mass = np.array(normal), float(pool.mass[arc.slot])
        place = np.array(pos) - radius * n
        if robot is not None:
            place = place - now * robot.vel  # on the robot as it is at the start of the part
            vx, vy, vz = robot.velocity_at(place).tolist()
            moving, ratio = (vx, vy, vz), mass * robot.inverse_mass(place, n)
        approach = -_along(vel, moving, normal)
        after, spin = hit_surface(
            vel,
            arc.spin,
            normal,
            radius=radius,
            restitution=own.restitution * other.restitution if approach > _LEAST_APPROACH else 0.0,
            friction=own.friction * other.friction,
            surface_velocity=moving,
            mass_ratio=ratio,
        )
        if robot is not None:
            robot.push(place, -mass * (np.array(after) - np.array(vel)))
        leaves = _along(after, moving, normal)
        arc.surfaces += 1
        self._turn(arc, now, pos, after, spin)
        arc.is_landing = (
            leaves < (LEAST_BOUNCE * normal[2] if robot is None else _GENTLE) or arc.surfaces >= _MOST_OF_ONE
        )
        if arc.is_landing:
            pull = min(0.0, _along(arc.acc, (0.0, 0.0, 0.0), normal))
            x, y, z = (v - leaves * c for v, c in zip(after, normal, strict=True))
            ax, ay, az = (a - pull * c for a, c in zip(arc.acc, normal, strict=True))
            arc.vel, arc.acc = (x, y, z), (ax, ay, az)

    def _turn(self, arc: Arc, now: float, pos: Vector, vel: Vector, spin: Vector) -> None:
        """Go on from an impact."""
        arc.time, arc.pos, arc.vel, arc.spin, arc.is_touched = now, pos, vel, spin, True
        if arc.is_flying:
            air = air_acceleration(np.array([vel]), np.array([spin]), self._pool.air_of(arc.slot))[0].tolist()
            arc.acc = air[0], air[1], air[2] - self._world.gravity

    def _hit_balls(self, a: Arc, b: Arc, now: float) -> None:
        pool = self._pool
        pos_a, pos_b = a.at(now), b.at(now)
        away = [p - q for p, q in zip(pos_a, pos_b, strict=True)]
        if not (a.is_flying or b.is_flying) and abs(away[2]) < _LEVEL:
            away[2] = 0.0
        distance = math.hypot(*away)
        normal = (away[0] / distance, away[1] / distance, away[2] / distance)
        sa, sb = pool.surfaces[a.slot], pool.surfaces[b.slot]
        (va, vb), (wa, wb) = hit_ball(
            (a.velocity(now), b.velocity(now)),
            (a.spin, b.spin),
            normal,
            radii=(float(pool.radius[a.slot]), float(pool.radius[b.slot])),
            masses=(float(pool.mass[a.slot]), float(pool.mass[b.slot])),
            restitution=sa.restitution * sb.restitution,
            friction=sa.friction * sb.friction,
        )
        for arc, pos, vel, spin, other in ((a, pos_a, va, wa, b), (b, pos_b, vb, wb, a)):
            if not arc.is_flying and vel[2] < 0.0:  # something carries it
                vel = (vel[0], vel[1], 0.0)
            self._turn(arc, now, pos, vel, spin)
            if arc.is_flying and not other.is_flying:
                leaves = _along(va, vb, normal)
                arc.is_landing = leaves < _GENTLE


def _along(a: Vector, b: Vector, normal: Vector) -> float:
    """Of a difference, along a unit vector."""
    return (a[0] - b[0]) * normal[0] + (a[1] - b[1]) * normal[1] + (a[2] - b[2]) * normal[2]


def _chord(arc: Arc, h: float) -> tuple[FloatArray, FloatArray]:
    """Where the chord of the rest of an arc was at time 0 [m], and the velocity along it [m/s]."""
    chord = np.array(arc.vel) + 0.5 * (h - arc.time) * np.array(arc.acc)
    return np.array(arc.pos) - arc.time * chord, chord


def _fall_time(gap: float, away: float, pull: float) -> float:
    """When a gap closes [s]; inf: never.

    Args:
        gap: [m], at least 0.
        away: Speed at which it grows [m/s].
        pull: Acceleration of that [m/s^2].
    """
    if gap <= 0.0:
        return 0.0 if away < -_STANDS else (2.0 * max(away, 0.0) / -pull if pull < 0.0 else math.inf)
    root = away * away - 2.0 * pull * gap
    if root < 0.0:
        return math.inf
    faster = math.sqrt(root) - away
    return 2.0 * gap / faster if faster > 1e-12 else math.inf


def _first_meetings(pos: FloatArray, vel: FloatArray, radius: FloatArray, least: FloatArray, h: float) -> FloatArray:
    """When balls first meet each other within h [s], inf for never or too gently, shape (n, n)."""
    times: FloatArray = np.full((len(pos), len(pos)), np.inf)
    way = lengths(vel) * h
    i, j, away2 = close_pairs(pos, pos, radius + way + (radius + way).max(initial=0.0))
    room = radius[i] + radius[j] + way[i] + way[j]
    close = (away2 < room * room) & (way[i] + way[j] > _GENTLE * h)
    i, j = i[close], j[close]
    times[i, j] = _meeting_times(
        pos[j] - pos[i], vel[j] - vel[i], radius[i] + radius[j], np.minimum(least[i], least[j])
    )
    return times


def _meeting_times(away: FloatArray, closing: FloatArray, contact: FloatArray, least: FloatArray) -> FloatArray:
    """When pairs of balls touch [s], inf for never or too gently, shape (...).

    Args:
        away: Of one center from the other, shape (..., 3).
        closing: Its velocity, shape (..., 3).
        contact: Distance at which they touch, shape (...).
        least: Approach that counts as an impact [m/s], shape (...).
    """
    along = np.einsum("...j,...j->...", away, closing)
    speed2 = np.einsum("...j,...j->...", closing, closing)
    gap = np.einsum("...j,...j->...", away, away) - contact * contact
    root = along * along - speed2 * gap
    meet = (along < -least * contact) & (root > 0.0)
    times: FloatArray = np.full(meet.shape, np.inf)
    times[meet] = np.maximum(gap[meet], 0.0) / (np.sqrt(root[meet]) - along[meet])
    return times
