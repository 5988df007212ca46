"""Contacts of upright robots' bumpers with walls and with each other: spring, damper and Coulomb friction.

Two convex outlines touch along overlapping sides. The model has up to two contacts, one at each end of the overlap, and
therefore resists rotation as a distributed pressure does. In each contact a spring and a damper give the normal force

    N = k d - c v_n >= 0,   k = stiffness x half of the overlap's length,   c = 2 zeta sqrt(k m)

with zeta from the pair's restitution. A friction spring along the sides stretches during sliding up to the force mu N
(Cundall and Strack 1979, as for balls). Two bumpers in contact are springs in series: their depths add up.

Source of the contact detection: E. Catto, "Computing distance", GDC 2010: separating axes and clipping.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.loop.body import add_touch, apply_force, find_spring, unexplained, way_out
from simcore.loop.compiled import compiled, inner

__all__ = ["DAMPING_RATIOS", "place_parts", "touch_outlines", "touch_robots"]

_BESIDE = 0.003
"""Smallest length of the overlap of two sides that collide [m]; half of the shorter side, if that is smaller."""
_COMMON = 1e-3
"""Smallest vertical overlap at which parts of two robots collide [m]. Without this limit a frame, which begins at the
top of the bumpers, could collide with bumpers of the same height."""
_EQUAL = 1e-6
"""Difference of separation below which the first outline's side is the reference side [m]."""
_MOST_RESTITUTION = 0.25
"""Largest coefficient of restitution of a pair [-], above the restitution of bumpers. Within this limit no hit at any
angle gains energy in steps of 1 ms."""
_MOST_DAMPING = 0.5
"""Largest fraction of the speed that a damper removes in a step [-]; above 1 the speed would reverse."""
_LEAST_SIDE = 0.1
"""Smallest length of an overlap for the computation of contact stiffness [m]: the length over which a corner compresses
a bumper."""
_NONE = np.zeros(4, np.uint8)
"""Values of `is_hidden` for a rectangle without hidden sides."""


def _restitution(ratio: float) -> float:
    """Return the coefficient of restitution of a spring-damper contact with a given damping ratio [-].

    The contact ends when the force reaches zero, so the contact never pulls.

    Source: T. Schwager, T. Poeschel, "Coefficient of restitution and linear-dashpot model revisited", Granular Matter 9
    (2007), eq. 21 and 22.
    """
    if ratio < 1.0:
        s = math.sqrt(1.0 - ratio * ratio)
        return math.exp(-ratio / s * (math.pi - math.atan2(2.0 * ratio * s, 1.0 - 2.0 * ratio * ratio)))
    s = math.sqrt(max(ratio * ratio - 1.0, 1e-12))
    return math.exp(-ratio / s * math.log((ratio + s) / (ratio - s)))


_TRIED = np.linspace(3.0, 0.0, 3001)
DAMPING_RATIOS = np.interp(np.linspace(0.0, 1.0, 101), [_restitution(ratio) for ratio in _TRIED], _TRIED)
"""Damping ratio of a spring-damper contact that never pulls [-], indexed by 100 times the coefficient of restitution,
shape (101,)."""


@inner
def place_parts(fleet, r, body):
    """Update the plan-view outlines and heights of a robot's bumpers and frame for the robot's pose."""
    robot = fleet.robots[r]
    axes = body.axes
    ax = axes[0, 0]
    ay = axes[1, 0]
    bx = axes[0, 1]
    by = axes[1, 1]
    size_a = math.sqrt(ax * ax + ay * ay)
    size_b = math.sqrt(bx * bx + by * by)
    for p in range(robot.model.first_part, robot.model.last_part):
        part = fleet.parts[p]
        model = part.model
        high = 0.5 * (model.bottom + model.top)
        x = body.pos[0] + axes[0, 2] * high + ax * model.x + bx * model.y
        y = body.pos[1] + axes[1, 2] * high + ay * model.x + by * model.y
        part.low = body.pos[2] + axes[2, 2] * high - 0.5 * (model.top - model.bottom)
        part.high = part.low + model.top - model.bottom
        lx = model.half_length * ax
        ly = model.half_length * ay
        wx = model.half_width * bx
        wy = model.half_width * by
        part.corners[0, 0] = x + lx - wx
        part.corners[0, 1] = y + ly - wy
        part.corners[1, 0] = x + lx + wx
        part.corners[1, 1] = y + ly + wy
        part.corners[2, 0] = x - lx + wx
        part.corners[2, 1] = y - ly + wy
        part.corners[3, 0] = x - lx - wx
        part.corners[3, 1] = y - ly - wy
        # The sides after the four corners run along +y, -x, -y and +x.
        part.normals[0, 0] = by / size_b
        part.normals[0, 1] = -bx / size_b
        part.normals[1, 0] = -ay / size_a
        part.normals[1, 1] = ax / size_a
        part.normals[2, 0] = -by / size_b
        part.normals[2, 1] = bx / size_b
        part.normals[3, 0] = ay / size_a
        part.normals[3, 1] = -ax / size_a


@inner
def _widest(corners, normals, first, last, is_hidden, others, other_first, other_last):
    """Return the largest separation of a visible side from another outline [m], and the index of this side.

    A negative separation is the depth of an overlap.
    """
    best = -math.inf
    side = first
    for i in range(first, last):
        if is_hidden[i]:
            continue
        nx = normals[i, 0]
        ny = normals[i, 1]
        least = math.inf
        for j in range(other_first, other_last):
            least = min(least, nx * others[j, 0] + ny * others[j, 1])
        apart = least - nx * corners[i, 0] - ny * corners[i, 1]
        if apart > best:
            best = apart
            side = i
    return best, side


@inner
def _manifold(a, a_normals, a_first, a_last, a_hidden, b, b_normals, b_first, b_last, b_hidden, found):
    """Find up to two contacts of outlines a and b, with unit normals from a to b.

    Args:
        a: Array of corners that contains outline a [m].
        a_normals: Outward unit normal of the side after each corner in `a`.
        a_first: Index of the first corner of outline a.
        a_last: Index after the last corner of outline a.
        a_hidden: Whether another outline covers the side after each corner in `a`.
        b: Array of corners that contains outline b [m].
        b_normals: Outward unit normal of the side after each corner in `b`.
        b_first: Index of the first corner of outline b.
        b_last: Index after the last corner of outline b.
        b_hidden: Whether another outline covers the side after each corner in `b`.
        found: Filled with one row per contact, shape (2, 7): x, y, nx, ny, depth, length of the overlap, and index of
            the end of the overlap (0 or 1).

    Returns:
        Number of contacts.
    """
    apart_a, side_a = _widest(a, a_normals, a_first, a_last, a_hidden, b, b_first, b_last)
    if apart_a > 0.0:
        return 0
    apart_b, side_b = _widest(b, b_normals, b_first, b_last, b_hidden, a, a_first, a_last)
    if apart_b > 0.0:
        return 0
    if apart_b > apart_a + _EQUAL:
        return _clip(b, b_normals, b_first, b_last, side_b, a, a_normals, a_first, a_last, -1.0, found)
    return _clip(a, a_normals, a_first, a_last, side_a, b, b_normals, b_first, b_last, 1.0, found)


@inner
def _clip(a, a_normals, a_first, a_last, side, b, b_normals, b_first, b_last, sign, found):
    """Find the contacts of a side of a and the opposite side of b at both ends of the overlap.

    Returns:
        Number of contacts.
    """
    nx = a_normals[side, 0]
    ny = a_normals[side, 1]
    sx = a[side, 0]
    sy = a[side, 1]
    end = side + 1 if side + 1 < a_last else a_first
    tx = -ny
    ty = nx
    facing = b_first
    best = math.inf
    for j in range(b_first, b_last):
        along = nx * b_normals[j, 0] + ny * b_normals[j, 1]
        if along < best:
            best = along
            facing = j
    after = facing + 1 if facing + 1 < b_last else b_first
    # Positions along the side, and gaps, of both ends of the facing side, which runs in the opposite direction.
    p = tx * (b[facing, 0] - sx) + ty * (b[facing, 1] - sy)
    q = tx * (b[after, 0] - sx) + ty * (b[after, 1] - sy)
    gap_p = nx * (b[facing, 0] - sx) + ny * (b[facing, 1] - sy)
    gap_q = nx * (b[after, 0] - sx) + ny * (b[after, 1] - sy)
    length = tx * (a[end, 0] - sx) + ty * (a[end, 1] - sy)
    low = max(q, 0.0)
    high = min(p, length)
    if high - low < min(_BESIDE, min(0.5 * (p - q), 0.5 * length)):
        return 0
    slope = (gap_p - gap_q) / (p - q) if p > q else 0.0
    n = 0
    for k in range(2):
        place = low if k == 0 else high
        gap = gap_q + slope * (place - q)
        if gap < 0.0:
            found[n, 0] = sx + place * tx + 0.5 * gap * nx
            found[n, 1] = sy + place * ty + 0.5 * gap * ny
            found[n, 2] = sign * nx
            found[n, 3] = sign * ny
            found[n, 4] = -gap
            found[n, 5] = max(high - low, _LEAST_SIDE)
            found[n, 6] = k if sign > 0.0 else 1 - k  # the index of an end does not depend on the order
            n += 1
    return n


@inner
def _velocity(body, x, y, height):
    """Return the horizontal velocity of a body at a point (x, y, height) [m], field frame [m/s, m/s]."""
    ax = x - body.com[0]
    ay = y - body.com[1]
    az = height - body.com[2]
    return (
        body.vel[0] + body.rate[1] * az - body.rate[2] * ay,
        body.vel[1] + body.rate[2] * ax - body.rate[0] * az,
    )


@inner
def _mobility(body, x, y, nx, ny):
    """Return the inverse effective mass of a robot at a point along a horizontal unit vector [1/kg].

    The function ignores roll and pitch, because the wheels resist both rotations.
    """
    lever = (x - body.com[0]) * ny - (y - body.com[1]) * nx
    return 1.0 / body.model.mass + lever * lever / body.model.inertia[2]


@compiled
def _ratio(restitution):
    """Return the damping ratio for a pair's coefficient of restitution, limited to `_MOST_RESTITUTION` [-]."""
    return DAMPING_RATIOS[int(100.0 * min(restitution, _MOST_RESTITUTION) + 0.5)]


@inner
def _force(found, n, stiffness, ratio, mass, friction, v_n, v_t, springs, r, key, stamp, is_put, h):
    """Compute the force of a bumper contact, and update the record of the contact.

    v_n is the opening speed, and v_t is the sliding speed to the left of the unit normal [m/s].

    Returns:
        Normal force [N], tangential force [N], and the displacement that reduces the initial overlap [m].
    """
    k = 0.5 * stiffness * found[n, 5]
    c = min(2.0 * ratio * math.sqrt(k * mass), _MOST_DAMPING * mass / h)
    slot, is_new = find_spring(springs, r, key, stamp)
    spring = springs[r, slot]
    if is_new or is_put:
        spring.put_in = unexplained(found[n, 4], -v_n, h)
        spring.stretch[0] = 0.0
    spring.put_in = min(spring.put_in, found[n, 4])
    way = way_out(spring.put_in, h)
    normal = max(0.0, k * (found[n, 4] - spring.put_in) - c * v_n)
    stretch = spring.stretch[0] + v_t * h
    across = k * stretch + c * v_t
    most = friction * normal
    if across > most or across < -most:
        across = most if across > 0.0 else -most
        stretch = max(-most / k, min(most / k, stretch))
    spring.stretch[0] = stretch
    return normal, across, way


@inner
def touch_outlines(fleet, r, body, h, found):
    """Apply the contact forces of the field's outlines on the bumpers and frame of a robot.

    The function also adds the displacement out of initial overlaps to `robot.shift`, and updates the list of contacts.

    Args:
        fleet: All robots; call `place_parts` for robot r first.
        r: Index of the robot.
        body: Record of the robot's body.
        h: Time step [s].
        found: Buffer for two contacts, shape (2, 7).
    """
    robot = fleet.robots[r]
    for p in range(robot.model.first_part, robot.model.last_part):
        part = fleet.parts[p]
        low_x = math.inf
        low_y = math.inf
        high_x = -math.inf
        high_y = -math.inf
        for i in range(4):
            low_x = min(low_x, part.corners[i, 0])
            high_x = max(high_x, part.corners[i, 0])
            low_y = min(low_y, part.corners[i, 1])
            high_y = max(high_y, part.corners[i, 1])
        for o in range(part.first_outline, part.last_outline):
            one = fleet.outlines[o]
            if one.low_x > high_x or one.high_x < low_x or one.low_y > high_y or one.high_y < low_y:
                continue
            count = _manifold(
                part.corners, part.normals, 0, 4, _NONE, fleet.corners, fleet.normals, one.first, one.last,
                fleet.hidden, found,
            )  # fmt: skip
            for n in range(count):
                x = found[n, 0]
                y = found[n, 1]
                nx = found[n, 2]
                ny = found[n, 3]
                height = 0.5 * (max(part.low, one.bottom) + min(part.high, one.top))
                ux, uy = _velocity(body, x, y, height)
                mass = 1.0 / _mobility(body, x, y, nx, ny)
                normal, across, way = _force(
                    found, n, part.model.stiffness, _ratio(part.model.restitution * one.restitution), mass,
                    part.model.friction * one.friction, -(nx * ux + ny * uy), nx * uy - ny * ux,
                    fleet.springs, r, ((p + 1) * 100000 + o) * 2 + int(found[n, 6]), fleet.clock[0], robot.is_put, h,
                )  # fmt: skip
                robot.shift[0] -= way * nx
                robot.shift[1] -= way * ny
                if normal > 0.0:
                    apply_force(
                        robot, x - body.com[0], y - body.com[1], height - body.com[2],
                        -nx * normal + ny * across, -ny * normal - nx * across, 0.0,
                    )  # fmt: skip
                    add_touch(robot, one.row)


@inner
def touch_robots(fleet, a, b, bodies, h, found):
    """Apply the contact forces between the bumpers and frames of two robots.

    The function also adds the displacement out of initial overlaps to the robots' `shift`, and updates the robots'
    lists of contacts.

    Args:
        fleet: All robots; call `place_parts` for both robots first.
        a: Index of one robot.
        b: Index of the other robot.
        bodies: Records of all bodies.
        h: Time step [s].
        found: Buffer for two contacts, shape (2, 7).
    """
    one = fleet.robots[a]
    other = fleet.robots[b]
    body = bodies[one.model.body]
    met = bodies[other.model.body]
    for p in range(one.model.first_part, one.model.last_part):
        mine = fleet.parts[p]
        for q in range(other.model.first_part, other.model.last_part):
            theirs = fleet.parts[q]
            low = max(mine.low, theirs.low)
            high = min(mine.high, theirs.high)
            if high - low < _COMMON:
                continue
            count = _manifold(
                mine.corners, mine.normals, 0, 4, _NONE, theirs.corners, theirs.normals, 0, 4, _NONE, found
            )
            for n in range(count):
                x = found[n, 0]
                y = found[n, 1]
                nx = found[n, 2]
                ny = found[n, 3]
                height = 0.5 * (low + high)
                ux, uy = _velocity(met, x, y, height)
                vx, vy = _velocity(body, x, y, height)
                ux -= vx
                uy -= vy
                mass = 1.0 / (_mobility(body, x, y, nx, ny) + _mobility(met, x, y, nx, ny))
                k = mine.model.stiffness
                stiffness = k * theirs.model.stiffness / (k + theirs.model.stiffness)
                normal, across, way = _force(
                    found, n, stiffness, _ratio(mine.model.restitution * theirs.model.restitution), mass,
                    mine.model.friction * theirs.model.friction, nx * ux + ny * uy, nx * uy - ny * ux, fleet.springs, a,
                    -((p + 1) * 100000 + q) * 2 - int(found[n, 6]), fleet.clock[0], one.is_put or other.is_put, h,
                )  # fmt: skip
                share = met.model.mass / (body.model.mass + met.model.mass)
                one.shift[0] -= share * way * nx
                one.shift[1] -= share * way * ny
                other.shift[0] += (1.0 - share) * way * nx
                other.shift[1] += (1.0 - share) * way * ny
                if normal > 0.0:
                    fx = nx * normal + ny * across
                    fy = ny * normal - nx * across
                    apply_force(other, x - met.com[0], y - met.com[1], height - met.com[2], fx, fy, 0.0)
                    apply_force(one, x - body.com[0], y - body.com[1], height - body.com[2], -fx, -fy, 0.0)
                    add_touch(one, met.model.row)
                    add_touch(other, body.model.row)
