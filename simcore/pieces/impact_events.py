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
from simcore.typing import FloatArray, IntArray

__all__ = ["LEAST_BOUNCE", "Arc", "ImpactEvents"]

_LEAST_APPROACH = 0.1  # [m/s]; slower impacts have no restitution: a bounce of 0.5 mm
LEAST_BOUNCE = 0.15
"""A ball that leaves a level surface more slowly has come to lie on it [m/s]: it would rise by 1 mm."""
_GENTLE = 0.03  # share of the fastest speed; a row of inelastic balls has no end of gentler impacts on each other
_MOST_EVENTS = 2000
_MOST_OF_ONE = 30  # impacts of one ball on surfaces; then it is caught between them
_STANDS = 1e-9  # [m/s]; slower is rounding
_LEVEL = 0.003  # [m]; balls that lie on one surface, a little pressed into it, push each other along it


class Arc:
    """One ball in a part of a tick, from its last impact on."""

    __slots__ = ("acc", "is_flying", "is_landing", "is_touched", "pos", "slot", "spin", "surfaces", "time", "vel")

    def __init__(
        self, slot: int, pos: Sequence[float], vel: Sequence[float], spin: Sequence[float], acc: Sequence[float] | None
    ) -> None:
        self.slot = slot
        self.pos: Vector = (pos[0], pos[1], pos[2])
        self.vel: Vector = (vel[0], vel[1], vel[2])
        self.spin: Vector = (spin[0], spin[1], spin[2])
        self.is_flying = acc is not None
        self.acc: Vector = (0.0, 0.0, 0.0) if acc is None else (acc[0], acc[1], acc[2])
        self.time = 0.0
        self.is_touched = False
        self.is_landing = False
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

    def play(self, h: float, arcs: list[Arc], near_field: Sequence[bool], robots: Sequence[int]) -> None:
        """Play a part of a tick.

        Args:
            h: Length of the part [s].
            arcs: Of the balls that may meet something or each other; they go on from their last impact.
            near_field: Which of them may meet elements of the field, before any impact.
            robots: Rows of the robots that they may meet.
        """
        self._robots = [self._robot(row) for row in robots]
        pool = self._pool
        radius = pool.radius[[arc.slot for arc in arcs]]
        base, chord = np.zeros((len(arcs), 3)), np.zeros((len(arcs), 3))  # where the chord was at time 0
        for number, arc in enumerate(arcs):
            base[number], chord[number] = _chord(arc, h)
        active = np.array([n for n, arc in enumerate(arcs) if arc.is_flying or arc.vel != (0.0, 0.0, 0.0)], dtype=int)
        least = max(_LEAST_APPROACH, _GENTLE * math.sqrt(float(np.einsum("ij,ij->i", chord, chord).max())))
        times = _meeting_times(base, chord, radius, active, least)
        next_surface = self._surfaces(h, arcs, near_field)
        surface_times = np.array([meeting.time for meeting in next_surface])
        for _ in range(_MOST_EVENTS):
            pair = int(times.argmin()) if times.size else -1
            pair_time = float(times.flat[pair]) if pair >= 0 else math.inf
            i = int(surface_times.argmin())
            now = min(pair_time, float(surface_times[i]))
            if not now <= h:
                break
            if pair_time < surface_times[i]:
                k, j = divmod(pair, len(arcs))
                i = int(active[k])
                self._hit_balls(arcs[i], arcs[j], now)
                changed = [i, j]
            else:
                self._hit_surface(arcs[i], next_surface[i], now)
                changed = [i]
            for n in changed:
                base[n], chord[n] = _chord(arcs[n], h)
            if changed[-1] not in active:  # from now on it moves
                active = np.append(active, changed[-1])
                times = np.vstack((times, np.full(len(arcs), np.inf)))
            found = _meeting_times(base + now * chord, chord, radius, np.array(changed), least) + now
            for n, one in zip(changed, found, strict=True):
                times[:, n] = one[active]
                times[active == n] = one
            some = [n for n in changed if arcs[n].is_flying]
            for n, meeting in zip(some, self._surfaces(h, [arcs[n] for n in some], [True] * len(some)), strict=True):
                next_surface[n] = meeting
                surface_times[n] = meeting.time
        for robot in self._robots:
            if robot.is_hit:
                self._world.engine.set_velocity(robot.row, robot.vel.tolist(), robot.rate.tolist())

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
        time = arc.time + _fall_time(gap, away, pull)
        if time < found[n].time:
            x, y, z = normal.tolist()
            found[n] = _Meeting(time, (x, y, z), surface, robot)

    def _floor(self, h: float, arc: Arc) -> _Meeting:
        """When a ball meets the floor at z = 0."""
        if self._world.floor is None or not arc.is_flying or arc.surfaces >= _MOST_OF_ONE:
            return _NEVER
        gap = arc.pos[2] - float(self._pool.radius[arc.slot])
        if gap < -float(self._pool.radius[arc.slot]):
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
        approach = -sum((v - u) * c for v, u, c in zip(vel, moving, normal, strict=True))
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
        leaves = sum((v - u) * c for v, u, c in zip(after, moving, normal, strict=True))
        arc.surfaces += 1
        self._turn(arc, now, pos, after, spin)
        if leaves < LEAST_BOUNCE * normal[2] or arc.surfaces >= _MOST_OF_ONE:
            arc.is_landing = True
            pull = min(0.0, sum(a * c for a, c in zip(arc.acc, normal, strict=True)))
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
        for arc, pos, vel, spin, other, up in ((a, pos_a, va, wa, b, normal[2]), (b, pos_b, vb, wb, a, -normal[2])):
            if not arc.is_flying and vel[2] < 0.0:  # something carries it
                vel = (vel[0], vel[1], 0.0)
            self._turn(arc, now, pos, vel, spin)
            if arc.is_flying and not other.is_flying:
                leaves = sum((v - w) * n for v, w, n in zip(va, vb, normal, strict=True))
                arc.is_landing = leaves < LEAST_BOUNCE * up


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
