"""The impacts of one part of a tick, each at its instant and in their order, whoever meets whom.

Between impacts a flying ball moves on a parabola (gravity and the air at the start of each arc); balls that lie move on
straight lines, because something carries them. What meets what first is found along the chords of the arcs, and its
instant on the arc itself. Robots move as they do at the start of the part.
"""

from __future__ import annotations

import math
from heapq import heapify, heappop, heappush
from typing import NamedTuple

import numpy as np

from simcore.geometry.rotation import Vector, apply, apply_back, as_rows, cross, matrix, minus
from simcore.physics.contact_law import (
    ENGINE_SPEED,
    LANDING_SPEED,
    REST_SPEED,
    TerrainSurface,
    hit_ball,
    hit_surface,
    pair_friction,
    pair_restitution,
)
from simcore.physics.swept_balls import FirstTouch
from simcore.physics.world import PhysicsWorld
from simcore.pieces.aerodynamics import ball_acceleration
from simcore.pieces.ball_rows import Arc, BallRows
from simcore.pieces.pool import PiecePool
from simcore.pieces.reach import lengths
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["ImpactEvents", "is_caught"]

_MOST_OF_ONE = 4  # impacts of one ball on surfaces in a part: then it is caught between them, and squeezed
_SKIN = 0.002  # [m]
_MOST_OF_ALL = 16  # impacts of one ball in a part: what is pushed from all sides is the engine's
_STANDS = 1e-9  # [m/s]; slower is rounding
_STILL = (0.0, 0.0, 0.0)
_LEVEL = 0.003  # [m]; balls that lie on one surface, a little pressed into it, push each other along it


class _Body:
    """A robot, or what hangs, in this part of the tick."""

    def __init__(self, world: PhysicsWorld, row: int, h: float) -> None:
        self.row, self.body, self.is_hit = row, world.hit_bodies[row], False
        self.origin, quat = world.engine.pose(row)
        self.vel, self.rate = world.engine.velocity(row)
        self.axes = as_rows(matrix(quat))
        speed = self.body.reach * math.hypot(*self.rate)
        self.turns, self.slack = h * speed, 2.0 * speed + _STANDS  # how far, and twice how fast, it turns
        low, high = self.body.surfaces.bounds
        self.low: Vector = (float(low[0]), float(low[1]), float(low[2]))
        self.high: Vector = (float(high[0]), float(high[1]), float(high[2]))
        x, y, z = apply(self.axes, self.body.center_of_mass)
        self.center = self.origin[0] + x, self.origin[1] + y, self.origin[2] + z
        """Center of mass [m]."""

    def is_near(self, arc: Arc, left: float) -> bool:
        """Whether a ball may meet its bounding box in the time left of the part [s]."""
        (ox, oy, oz), (u, v, w), now = self.origin, self.vel, arc.time
        (x, y, z), (cu, cv, cw) = arc.pos, arc.chord
        x, y, z = x - ox - now * u, y - oy - now * v, z - oz - now * w
        cu, cv, cw = cu - u, cv - v, cw - w
        reach = arc.radius + left * math.sqrt(cu * cu + cv * cv + cw * cw) + _SKIN + self.turns
        if x * x + y * y + z * z > (reach + self.body.reach) ** 2:
            return False
        if not arc.is_free and math.sqrt(cu * cu + cv * cv + cw * cw) + self.slack <= ENGINE_SPEED:
            return False
        p, q, r = apply_back(self.axes, (x, y, z))
        (lx, ly, lz), (hx, hy, hz) = self.low, self.high
        if not (lx - reach < p < hx + reach and ly - reach < q < hy + reach and lz - reach < r < hz + reach):
            return False
        a, b, c = apply_back(self.axes, (cu, cv, cw))
        outside, last = 0, 0.0
        for place, speed, low, high in ((p, a, lx, hx), (q, b, ly, hy), (r, c, lz, hz)):
            if low <= place <= high:
                continue
            last = speed if place > high else -speed
            if last > self.slack:
                return False
            outside += 1
        return outside != 1 or last < self.slack - (0.0 if arc.is_free else ENGINE_SPEED)

    def first_touch(self, arc: Arc, left: float, least: float) -> FirstTouch | None:
        """What a ball touches first of it in the time left of the part [s]; see `TriangleSet.first_touch`."""
        (px, py, pz), (u, v, w), (cx, cy, cz), now = arc.pos, self.vel, self.center, arc.time
        x, y, z = px - now * u - cx, py - now * v - cy, pz - now * w - cz
        a, b, c = cross(self.rate, (x, y, z))
        x, y, z = x - now * a, y - now * b, z - now * c  # as the robot sees it at the start of the part
        a, b, c = cross(self.rate, (x, y, z))
        way = left * (arc.chord[0] - u - a), left * (arc.chord[1] - v - b), left * (arc.chord[2] - w - c)
        ox, oy, oz = self.origin
        place = apply_back(self.axes, (x + cx - ox, y + cy - oy, z + cz - oz))
        touch = self.body.surfaces.first_touch(place, apply_back(self.axes, way), arc.radius, least)
        return None if touch is None else touch._replace(normal=apply(self.axes, touch.normal))

    def velocity_at(self, place: Vector) -> Vector:
        """Of a place of it [m/s]."""
        a, b, c = cross(self.rate, minus(place, self.center))
        return self.vel[0] + a, self.vel[1] + b, self.vel[2] + c

    def _turn(self, place: Vector, impulse: Vector) -> Vector:
        """What an impulse [N s] at a place [m] changes of its rate, in its own axes [rad/s]."""
        a, b, c = apply_back(self.axes, cross(minus(place, self.body.pivot or self.center), impulse))
        ia, ib, ic = self.body.inertia
        return a / ia, b / ib, c / ic

    def inverse_mass(self, place: Vector, normal: Vector) -> float:
        """Of the body, where and along which it is hit [1/kg]."""
        a, b, c = self._turn(place, normal)
        ia, ib, ic = self.body.inertia
        return (0.0 if self.body.pivot else 1.0 / self.body.mass) + a * a * ia + b * b * ib + c * c * ic

    def push(self, place: Vector, impulse: Vector) -> None:
        """Take an impulse [N s] at a place [m]."""
        (a, b, c), (x, y, z), mass = apply(self.axes, self._turn(place, impulse)), impulse, self.body.mass
        self.rate = self.rate[0] + a, self.rate[1] + b, self.rate[2] + c
        if self.body.pivot is None:
            self.vel = self.vel[0] + x / mass, self.vel[1] + y / mass, self.vel[2] + z / mass
        else:
            self.vel = cross(self.rate, minus(self.center, self.body.pivot))
        self.is_hit = True


class _Meeting(NamedTuple):
    """What a ball meets next."""

    time: float
    normal: Vector
    surface: TerrainSurface
    robot: _Body | None


class ImpactEvents:
    """Plays the impacts of some balls on surfaces, on robots and on each other.

    Args:
        world: Where the bodies live.
        pool: The pieces.
    """

    def __init__(self, world: PhysicsWorld, pool: PiecePool) -> None:
        self._world = world
        self._pool = pool
        self.pressed: list[int] = []
        """Slots of sleepers that balls come to touch in the part, too gently for an impact."""

    def play(self, h: float, balls: BallRows, flying: IntArray) -> list[Arc]:
        """Play a part of a tick; returns how those that had an impact go on from the last one.

        Args:
            h: Length of the part [s].
            balls: At the start of the part.
            flying: Numbers of those that fly, shape (n,).
        """
        self.pressed.clear()
        self._h, self._balls, self._events = h, balls, _first_meetings(balls, h)
        self._robots = [_Body(self._world, row, h) for row in self._world.hit_bodies]
        lying = balls.is_beside.copy()
        lying[flying] = False
        meets = np.concatenate((flying, self._fast(lying.nonzero()[0])))
        self._arcs: dict[int, Arc] = {}
        self._surface: dict[int, _Meeting] = {}
        heapify(self._events)
        self._look_first(meets)
        while self._events:
            now, n, m, changes = heappop(self._events)
            a = self._arc(n)
            if m < 0:
                if a.changes != changes:
                    continue
                self._hit_surface(a, self._surface[n], now)
                hit = [a]
            else:
                b = self._arc(m)
                if a.changes + b.changes != changes:
                    continue
                self._hit_balls(a, b, now)
                hit = [a, b]
            for arc in hit:
                arc.changes += 1
                arc.aim(h)
            for arc in hit:
                self._look_for_balls(arc)
                self._look_for_surface(arc, self._robots)
        for robot in self._robots:
            if robot.is_hit:
                self._world.set_velocity(robot.row, robot.vel, robot.rate)
        order = {number: place for place, number in enumerate(meets.tolist())}  # of the engine's later calls
        touched = [arc for arc in self._arcs.values() if arc.is_touched]
        touched.sort(key=lambda arc: order.get(arc.number, len(order)))
        for arc in touched:
            balls.strike(arc)
        return touched

    def _fast(self, numbers: IntArray) -> IntArray:
        """Which of some balls move fast enough, to what stands or to a robot, for an impact."""
        vel = self._balls.vel[numbers]
        fast: BoolArray = np.einsum("ij,ij->i", vel, vel) > ENGINE_SPEED * ENGINE_SPEED
        for robot in self._robots:
            relative, least = vel - robot.vel, max(ENGINE_SPEED - robot.slack, 0.0)
            fast |= np.einsum("ij,ij->i", relative, relative) > least * least
        return numbers[fast]

    def _arc(self, number: int) -> Arc:
        arc = self._arcs.get(number)
        if arc is None:
            arc = self._arcs[number] = self._balls.arc(number)
        return arc

    # --- what is met --------------------------------------------------------------------------------------------

    def _look_for_balls(self, arc: Arc) -> None:
        """Note when a ball meets others, from its last change on."""
        if is_caught(arc):
            return
        now, n, h = arc.time, arc.number, self._h
        for m in self._balls.around(arc, h):
            other = self._arc(m)
            if is_caught(other):
                continue
            time = _meeting_time(arc, other, ENGINE_SPEED, now)
            if time <= h:
                heappush(self._events, (time, n, m, arc.changes + other.changes))
            elif arc.is_touched and self._balls.is_frozen(m) and _meeting_time(arc, other, _STANDS, now) <= h:
                self.pressed.append(other.slot)

    def _look_first(self, numbers: IntArray) -> None:
        """Note what balls meet first of floor, field and robots, looking only at those that have one of them near."""
        if not len(numbers):
            return
        pos, chord, radius = self._balls.at_start(numbers)
        reach = radius + self._h * lengths(chord) + _SKIN
        rest: BoolArray = self._world.near_field(pos, reach)
        if self._world.floor is not None:
            rest |= (pos[:, 2] < reach) & (self._balls.flies(numbers) | (chord[:, 2] <= -ENGINE_SPEED))
        near: dict[int, list[_Body]] = {k: [] for k in rest.nonzero()[0].tolist()}
        for k, n in _near_boxes(self._robots, pos, chord, radius, self._h):
            near.setdefault(k, []).append(self._robots[n])
        for k in sorted(near):
            self._look_for_surface(self._arc(int(numbers[k])), near[k], is_beside=bool(rest[k]))

    def _look_for_surface(self, arc: Arc, robots: list[_Body], *, is_beside: bool = True) -> None:
        """Note what a ball meets next of some robots and, where these are beside it, of the floor and the field."""
        if arc.surfaces >= _MOST_OF_ONE:
            return
        world, left, is_free = self._world, self._h - arc.time, arc.is_free
        least, meeting = 0.0 if is_free else ENGINE_SPEED * left, None
        if is_beside:
            gap, rise = arc.pos[2] - arc.radius, arc.vel[2]
            if world.floor is not None and gap >= -arc.radius and (is_free or rise <= -ENGINE_SPEED):
                time = arc.time + _fall_time(max(0.0, gap), rise, arc.acc[2])
                if time <= self._h:
                    meeting = _Meeting(time, (0.0, 0.0, 1.0), world.floor, None)
            u, v, w = arc.chord
            touch = world.first_touch(arc.pos, (left * u, left * v, left * w), arc.radius, least)
            if touch is not None:
                meeting = self._earlier(arc, meeting, touch, None)
        for robot in robots:
            if robot.is_near(arc, left):
                touch = robot.first_touch(arc, left, least)
                if touch is not None:
                    meeting = self._earlier(arc, meeting, touch, robot)
        if meeting is not None:
            self._surface[arc.number] = meeting
            heappush(self._events, (meeting.time, arc.number, -1, arc.changes))

    def _earlier(self, arc: Arc, known: _Meeting | None, touch: FirstTouch, robot: _Body | None) -> _Meeting | None:
        """What a ball meets first: what is known, or what it touches, at its instant on the arc."""
        left, normal = self._h - arc.time, touch.normal
        moving = _STILL
        if robot is not None:
            (x, y, z), (u, v, w), now = arc.pos, robot.vel, arc.time
            moving = robot.velocity_at((x - now * u, y - now * v, z - now * w))
        away, pull = _along(arc.vel, moving, normal), _along(arc.acc, _STILL, normal)
        if not arc.is_free and away > -ENGINE_SPEED:
            return known
        gap = max(0.0, -(away + 0.5 * pull * left) * touch.fraction * left)
        time = arc.time + _fall_time(gap, away, pull)
        if time > self._h or (known is not None and time >= known.time):
            return known
        return _Meeting(time, normal, self._world.surface(touch.tag if robot is None else robot.row), robot)

    # --- what comes of it ---------------------------------------------------------------------------------------

    def _hit_surface(self, arc: Arc, meeting: _Meeting, now: float) -> None:
        pool, (_, normal, other, robot) = self._pool, meeting
        own, pos, vel, radius = pool.surfaces[arc.slot], arc.at(now), arc.velocity(now), arc.radius
        moving, ratio, mass = _STILL, 0.0, float(pool.mass[arc.slot])
        (x, y, z), (nx, ny, nz) = pos, normal
        place = x - radius * nx, y - radius * ny, z - radius * nz
        if robot is not None:
            u, v, w = robot.vel
            place = place[0] - now * u, place[1] - now * v, place[2] - now * w  # as it is at the start of the part
            moving, ratio = robot.velocity_at(place), mass * robot.inverse_mass(place, normal)
        approach = -_along(vel, moving, normal)
        after, spin = hit_surface(
            vel,
            arc.spin,
            normal,
            radius=radius,
            restitution=pair_restitution(own.restitution, other.restitution) if approach > REST_SPEED else 0.0,
            friction=pair_friction(own.friction, other.friction),
            surface_velocity=moving,
            mass_ratio=ratio,
        )
        if robot is not None:
            u, v, w = minus(vel, after)
            robot.push(place, (mass * u, mass * v, mass * w))
        if not arc.is_flying and after[2] < 0.0:  # something carries it
            after = (after[0], after[1], 0.0)
        leaves = _along(after, moving, normal)
        arc.surfaces += 1
        self._turn(arc, now, pos, after, spin)
        arc.is_landing = (
            leaves < (LANDING_SPEED * normal[2] if robot is None else ENGINE_SPEED) or arc.surfaces >= _MOST_OF_ONE
        )
        if arc.is_landing:
            pull = min(0.0, _along(arc.acc, _STILL, normal))
            x, y, z = (v - leaves * c for v, c in zip(after, normal, strict=True))
            ax, ay, az = (a - pull * c for a, c in zip(arc.acc, normal, strict=True))
            arc.vel, arc.acc = (x, y, z), (ax, ay, az)

    def _turn(self, arc: Arc, now: float, pos: Vector, vel: Vector, spin: Vector) -> None:
        """Go on from an impact."""
        arc.time, arc.pos, arc.vel, arc.spin, arc.is_touched = now, pos, vel, spin, True
        if arc.is_flying:
            x, y, z = ball_acceleration(vel, spin, self._pool.air_of(arc.slot))
            arc.acc = x, y, z - self._world.gravity

    def _hit_balls(self, a: Arc, b: Arc, now: float) -> None:
        pool = self._pool
        pos_a, pos_b = a.at(now), b.at(now)
        away = [p - q for p, q in zip(pos_a, pos_b, strict=True)]
        if not (a.is_flying or b.is_flying) and abs(away[2]) < _LEVEL:
            away[2] = 0.0
        distance = math.hypot(*away)
        normal = (away[0] / distance, away[1] / distance, away[2] / distance)
        sa, sb = pool.surfaces[a.slot], pool.surfaces[b.slot]
        approach = -_along(a.velocity(now), b.velocity(now), normal)
        (va, vb), (wa, wb) = hit_ball(
            (a.velocity(now), b.velocity(now)),
            (a.spin, b.spin),
            normal,
            radii=(a.radius, b.radius),
            masses=(float(pool.mass[a.slot]), float(pool.mass[b.slot])),
            restitution=pair_restitution(sa.restitution, sb.restitution) if approach > REST_SPEED else 0.0,
            friction=pair_friction(sa.friction, sb.friction),
        )
        for arc, pos, vel, spin, other in ((a, pos_a, va, wa, b), (b, pos_b, vb, wb, a)):
            if not arc.is_flying and vel[2] < 0.0:  # something carries it
                vel = (vel[0], vel[1], 0.0)
            self._turn(arc, now, pos, vel, spin)
            if arc.is_flying and not other.is_flying:
                leaves = _along(va, vb, normal)
                arc.is_landing = leaves < ENGINE_SPEED


def _near_boxes(
    robots: list[_Body], pos: FloatArray, chord: FloatArray, radius: FloatArray, h: float
) -> list[tuple[int, int]]:
    """Which balls may be in the bounding box of which robots in a part of the tick: numbers of both.

    Args:
        robots: As they begin it.
        pos: Of the balls as they begin it [m], shape (n, 3).
        chord: [m/s], shape (n, 3).
        radius: [m], shape (n,).
        h: Length of the part [s].
    """
    if not robots:
        return []
    away = pos[:, None] - np.array([robot.origin for robot in robots])
    closing = chord[:, None] - np.array([robot.vel for robot in robots])
    reach = radius[:, None] + np.array([robot.turns + 2.0 * _SKIN for robot in robots])
    reach += h * np.sqrt(np.einsum("ijk,ijk->ij", closing, closing))
    room = reach + np.array([robot.body.reach for robot in robots])
    i, j = (np.einsum("ijk,ijk->ij", away, away) < room * room).nonzero()
    local = np.einsum("ij,ijk->ik", away[i, j], np.array([robot.axes for robot in robots])[j])
    room = reach[i, j, None]
    inside = np.array([robot.low for robot in robots])[j] - room < local
    inside &= np.array([robot.high for robot in robots])[j] + room > local
    near = inside.all(axis=1)
    return list(zip(i[near].tolist(), j[near].tolist(), strict=True))


def _along(a: Vector, b: Vector, normal: Vector) -> float:
    """Of a difference, along a unit vector."""
    return (a[0] - b[0]) * normal[0] + (a[1] - b[1]) * normal[1] + (a[2] - b[2]) * normal[2]


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


def is_caught(arc: Arc) -> bool:
    """Whether a ball has had so many impacts in the part that something holds it: the engine goes on."""
    return arc.surfaces >= _MOST_OF_ONE or arc.changes >= _MOST_OF_ALL


def _first_meetings(balls: BallRows, h: float) -> list[tuple[float, int, int, int]]:
    """When the pairs of balls first meet within h [s]: time, both numbers, and how often these have changed."""
    i, j = balls.pairs
    if not len(i):
        return []
    chord = balls.vel + (0.5 * h) * balls.acc
    away, closing, contact = balls.pos[j] - balls.pos[i], chord[j] - chord[i], balls.radius[i] + balls.radius[j]
    along = np.einsum("ij,ij->i", away, closing)
    gap = np.einsum("ij,ij->i", away, away) - contact * contact
    speed2 = np.einsum("ij,ij->i", closing, closing)
    root = along * along - speed2 * gap
    least = ENGINE_SPEED * contact
    meet = (along < -least) & (root > least * least)
    i, j, along = i[meet], j[meet], along[meet]
    times = np.maximum(gap[meet], 0.0) / (np.sqrt(root[meet]) - along)
    return [(time, n, m, 0) for time, n, m in zip(times.tolist(), i.tolist(), j.tolist(), strict=True) if time <= h]


def _meeting_time(a: Arc, b: Arc, least: float, now: float) -> float:
    """When two balls touch from now on [s], inf for never or more gently than `least` [m/s]."""
    (ax, ay, az), (bx, by, bz), (au, av, aw), (bu, bv, bw) = a.base, b.base, a.chord, b.chord
    u, v, w = bu - au, bv - av, bw - aw
    x, y, z = bx - ax + now * u, by - ay + now * v, bz - az + now * w
    contact = a.radius + b.radius
    least *= contact
    along = x * u + y * v + z * w
    if along > -least:
        return math.inf
    gap = x * x + y * y + z * z - contact * contact
    root = along * along - (u * u + v * v + w * w) * gap
    if root < least * least:
        return math.inf
    return now + max(gap, 0.0) / (math.sqrt(root) - along)
