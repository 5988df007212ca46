"""Contacts of upright bodies in the plane of the floor: where convex outlines meet, and the impulses there.

Two convex polygons touch along flat sides that overlap, so they have up to two contacts, one at each end of the
overlap: the pressure between them is spread and holds the heading. Contacts begin before the outlines touch (their
`gap` may be positive), and a body is stopped within the step in which it would close the gap.

Source: E. Catto, "Computing distance" and "Iterative dynamics with temporal coherence", GDC 2010 and 2005: separating
axes, clipping and sequential impulses, here to convergence, because there are few contacts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from simcore.geometry.rotation import Vector
from simcore.physics.contact_law import HIT_SPEED, PUSH_OUT
from simcore.units import plain_sum

__all__ = ["PlanarBody", "PlanarContact", "Polygon", "manifold", "solve_contacts"]

_BESIDE = (
    0.003  # [m]; outlines whose sides overlap by less pass each other: a seam between two flush walls stops nobody
)
_EQUAL = 1e-6  # [m]; of two sides that part the outlines by the same, the first one is taken
_MOST_ROUNDS = 300
_CONVERGED = 1e-9  # [m/s]


class Polygon:
    """A convex outline.

    Args:
        corners: Counter-clockwise [m], at least three.
    """

    __slots__ = ("corners", "normals", "radius", "x", "y")

    def __init__(self, corners: Sequence[tuple[float, float]]) -> None:
        self.corners = list(corners)
        """[m]"""
        self.normals: list[tuple[float, float]] = []
        """Unit vector outward from the side after each corner."""
        for (ax, ay), (bx, by) in zip(self.corners, [*self.corners[1:], self.corners[0]], strict=True):
            length = math.hypot(bx - ax, by - ay)
            self.normals.append(((by - ay) / length, (ax - bx) / length))
        self.x = plain_sum(x for x, _ in self.corners) / len(self.corners)
        """Mean of the corners [m]."""
        self.y = plain_sum(y for _, y in self.corners) / len(self.corners)
        self.radius = max([math.hypot(x - self.x, y - self.y) for x, y in self.corners])
        """Of the circle around `x`, `y` that holds it [m]."""

    @classmethod
    def rectangle(cls, x: float, y: float, along: tuple[float, float], across: tuple[float, float]) -> Polygon:
        """With its middle at a place [m], and from there to the middles of its front and left side [m]."""
        (ax, ay), (bx, by) = along, across
        return cls(
            [
                (x + ax - bx, y + ay - by),
                (x + ax + bx, y + ay + by),
                (x - ax + bx, y - ay + by),
                (x - ax - bx, y - ay - by),
            ]
        )


def manifold(a: Polygon, b: Polygon, reach: float) -> list[tuple[float, float, float, float, float]]:
    """Where two outlines touch, or could when they come nearer.

    Args:
        a: One outline.
        b: The other.
        reach: Largest gap that counts [m].

    Returns:
        Up to two of: place [m, m], unit normal from `a` to `b`, gap [m] (negative: they overlap).
    """
    far = a.radius + b.radius + reach
    if (a.x - b.x) ** 2 + (a.y - b.y) ** 2 > far * far:
        return []
    apart_a, side_a = _widest(a, b)
    if apart_a > reach:
        return []
    apart_b, side_b = _widest(b, a)
    if apart_b > reach:
        return []
    is_of_b = apart_b > apart_a + _EQUAL
    mine, other, side = (b, a, side_b) if is_of_b else (a, b, side_a)
    nx, ny = mine.normals[side]
    sx, sy = mine.corners[side]
    ex, ey = mine.corners[(side + 1) % len(mine.corners)]
    tx, ty = -ny, nx  # from the start of the side to its end
    facing = min(range(len(other.normals)), key=lambda i: nx * other.normals[i][0] + ny * other.normals[i][1])
    px, py = other.corners[facing]
    qx, qy = other.corners[(facing + 1) % len(other.corners)]
    # Places along the side, and gaps, of both ends of the facing side; it runs the other way round.
    p, q = tx * (px - sx) + ty * (py - sy), tx * (qx - sx) + ty * (qy - sy)
    gap_p, gap_q = nx * (px - sx) + ny * (py - sy), nx * (qx - sx) + ny * (qy - sy)
    length = tx * (ex - sx) + ty * (ey - sy)
    low, high = max(q, 0.0), min(p, length)
    if high - low < min(_BESIDE, 0.5 * (p - q), 0.5 * length):
        return []
    slope = (gap_p - gap_q) / (p - q)
    result = []
    for place in (low, high):
        gap = gap_q + slope * (place - q)
        if gap <= reach:
            x, y = sx + place * tx + 0.5 * gap * nx, sy + place * ty + 0.5 * gap * ny
            result.append((x, y, -nx, -ny, gap) if is_of_b else (x, y, nx, ny, gap))
    return result


def _widest(a: Polygon, b: Polygon) -> tuple[float, int]:
    """The side of `a` from which `b` is farthest, and by how much [m]."""
    best, side = -math.inf, 0
    for i, ((nx, ny), (sx, sy)) in enumerate(zip(a.normals, a.corners, strict=True)):
        apart = min([nx * x + ny * y for x, y in b.corners]) - nx * sx - ny * sy
        if apart > best:
            best, side = apart, i
    return best, side


@dataclass(slots=True, kw_only=True, eq=False)
class PlanarBody:
    """A body in the plane in a step; velocities are of its center of mass and about it, field axes [m/s, m/s, 1/s]."""

    center: Vector
    """Center of mass [m]."""
    mass: float
    """[kg]"""
    inertia: Vector
    """About the center of mass, roll, pitch and yaw [kg m^2]."""
    start: Vector
    """As the step begins."""
    mean: Vector
    """In the mean of the step, if it touched nothing."""
    end: Vector
    """At its end, likewise."""


@dataclass(slots=True)
class PlanarContact:
    """A contact of two bodies, or of a body with something fixed."""

    a: PlanarBody
    b: PlanarBody | None
    x: float
    """Where [m]."""
    y: float
    nx: float
    """Unit normal from `a` to `b`."""
    ny: float
    gap: float
    """[m], negative if they overlap."""
    friction: float
    """Coulomb's coefficient of the pair [-]."""
    restitution: float
    """Of the pair [-]."""
    normal: float = 0.0
    """Impulse along the normal in the step [N s], >= 0."""
    tangent: float = 0.0
    """Impulse across it, to the left of the normal [N s]."""
    is_hit: bool = False
    """Whether the bodies met fast enough to bounce."""


class _Row:
    """One direction at one contact: how velocities there follow from those of the bodies, and from impulses."""

    __slots__ = ("a", "b", "ja", "jb", "mobility", "nx", "ny")

    def __init__(self, contact: PlanarContact, nx: float, ny: float) -> None:
        self.nx, self.ny = nx, ny
        self.ja, *self.a = self._side(contact, contact.a)
        self.jb, *self.b = self._side(contact, contact.b) if contact.b is not None else (0.0, 0.0, 0.0)
        self.mobility = self.a[0] + self.a[1] * self.ja * self.ja
        if contact.b is not None:
            self.mobility += self.b[0] + self.b[1] * self.jb * self.jb

    def _side(self, contact: PlanarContact, body: PlanarBody) -> tuple[float, float, float]:
        """Lever of a body [m], and the inverses of its mass and inertia."""
        lever = (contact.x - body.center[0]) * self.ny - (contact.y - body.center[1]) * self.nx
        return lever, 1.0 / body.mass, 1.0 / body.inertia[2]

    def velocity(self, va: list[float], vb: list[float]) -> float:
        """Of b relative to a [m/s]."""
        nx, ny = self.nx, self.ny
        return nx * (vb[0] - va[0]) + ny * (vb[1] - va[1]) + self.jb * vb[2] - self.ja * va[2]

    def push(self, va: list[float], vb: list[float], impulse: float) -> None:
        """Add an impulse [N s] to b, and its opposite to a."""
        for v, (light, easy), lever, part in ((va, self.a, self.ja, -impulse), (vb, self.b, self.jb, impulse)):
            v[0] += part * light * self.nx
            v[1] += part * light * self.ny
            v[2] += part * easy * lever


def solve_contacts(
    bodies: Sequence[PlanarBody], contacts: Sequence[PlanarContact], h: float
) -> list[tuple[tuple[float, float, float], tuple[float, float, float]]]:
    """Impulses of all contacts in a step of h [s], into `contacts`, and what they change of each body's velocities.

    Coulomb's law and Newton's for velocities at the end of the step, for those contacts whose gap closes within it:
    P_n >= 0, v_n >= e |v_n before|, |P_t| <= mu P_n, against the sliding. A second condition holds for the mean
    velocity, with which bodies move: no gap becomes negative.

    Returns:
        For each body, change of its mean velocity and of that at the end [m/s, m/s, rad/s].
    """
    normals = [_Row(c, c.nx, c.ny) for c in contacts]
    tangents = [_Row(c, -c.ny, c.nx) for c in contacts]
    fixed = [0.0, 0.0, 0.0]
    number = {id(body): i for i, body in enumerate(bodies)}
    ends = [(number[id(c.a)], -1 if c.b is None else number[id(c.b)]) for c in contacts]

    def at(velocities: list[list[float]], i: int) -> tuple[list[float], list[float]]:
        a, b = ends[i]
        return velocities[a], fixed if b < 0 else velocities[b]

    least = [-c.gap / h if c.gap > 0.0 else min(-PUSH_OUT[0] * c.gap / h, PUSH_OUT[1]) for c in contacts]

    def stop(velocities: list[list[float]]) -> list[float]:
        """Let no gap become negative; returns the impulses."""
        impulses = [0.0] * len(contacts)
        for _ in range(_MOST_ROUNDS):
            most = 0.0
            for i, row in enumerate(normals):
                va, vb = at(velocities, i)
                change = max((least[i] - row.velocity(va, vb)) / row.mobility, -impulses[i])
                if change:
                    impulses[i] += change
                    row.push(va, vb, change)
                    most = max(most, abs(change) * row.mobility)
            if most < _CONVERGED:
                break
        return impulses

    def settle(velocities: list[list[float]], wanted: list[float]) -> None:
        """Coulomb's law, and at least the wanted velocities along the normals [m/s]."""
        for _ in range(_MOST_ROUNDS):
            most = 0.0
            for i, contact in enumerate(contacts):
                if not met[i]:
                    continue
                va, vb = at(velocities, i)
                row = tangents[i]
                limit = contact.friction * contact.normal
                tangent = contact.tangent - row.velocity(va, vb) / row.mobility
                change = max(-limit, min(limit, tangent)) - contact.tangent
                contact.tangent += change
                row.push(va, vb, change)
                most = max(most, abs(change) * row.mobility)
                row = normals[i]
                change = max((wanted[i] - row.velocity(va, vb)) / row.mobility, -contact.normal)
                contact.normal += change
                row.push(va, vb, change)
                most = max(most, abs(change) * row.mobility)
            if most < _CONVERGED:
                break

    # 1. Which contacts close within the step, with the mean velocity or with that which the step begins with.
    starts = [list(body.start) for body in bodies]
    free = [list(body.mean) for body in bodies]
    closing = [row.velocity(*at(starts, i)) for i, row in enumerate(normals)]
    met = [impulse > 0.0 for impulse in stop(free)]
    # 2. Velocities at the end.
    final = [list(body.end) for body in bodies]
    wanted = []
    for contact, speed in zip(contacts, closing, strict=True):
        contact.normal = contact.tangent = 0.0
        contact.is_hit = speed < -HIT_SPEED
        wanted.append(-contact.restitution * speed if contact.is_hit else 0.0)
    settle(final, wanted)
    if _energy(bodies, final) > _energy(bodies, [body.end for body in bodies]):
        # A bounce off center with friction can gain energy by Newton's law; then it does not bounce.
        final = [list(body.end) for body in bodies]
        for contact in contacts:
            contact.normal = contact.tangent = 0.0
        settle(final, [0.0] * len(contacts))
    # 3. Mean velocities: a push acts throughout the step, a hit from its instant on.
    mean = [list(body.mean) for body in bodies]
    for i, contact in enumerate(contacts):
        if met[i]:
            share = 0.5
            if contact.is_hit:
                share = 1.0 - min(1.0, max(0.0, contact.gap) / (-closing[i] * h))
            va, vb = at(mean, i)
            normals[i].push(va, vb, share * contact.normal)
            tangents[i].push(va, vb, share * contact.tangent)
    stop(mean)
    return [
        (
            (m[0] - body.mean[0], m[1] - body.mean[1], m[2] - body.mean[2]),
            (f[0] - body.end[0], f[1] - body.end[1], f[2] - body.end[2]),
        )
        for body, m, f in zip(bodies, mean, final, strict=True)
    ]


def _energy(bodies: Sequence[PlanarBody], velocities: Sequence[Sequence[float]]) -> float:
    """Of their motion [J]."""
    return plain_sum(
        0.5 * body.mass * (vx * vx + vy * vy) + 0.5 * body.inertia[2] * w * w
        for body, (vx, vy, w) in zip(bodies, velocities, strict=True)
    )
