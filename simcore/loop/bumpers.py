"""Bumpers against walls and robots, in the plane of the floor: spring, damper and Coulomb friction at flat sides.

Two convex outlines touch along sides that overlap, so they have up to two contacts, one at each end of the overlap: the
pressure between them is spread and holds the heading. At each a spring and a damper push,

    N = k d - c v_n >= 0,   k = stiffness x half of the length that overlaps,   c = 2 zeta sqrt(k m)

with zeta from the pair's restitution, and a spring of friction along the sides, which stretches with the sliding until
it has mu N (Cundall and Strack 1979, as balls have it). Two bumpers in a row give way by the sum of both depths.

Source of the sides that touch: E. Catto, "Computing distance", GDC 2010: separating axes and clipping.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.loop.compiled import compiled
from simcore.loop.robot_state import TOUCHES

__all__ = ["place_parts", "touch_outlines", "touch_robots"]

_BESIDE = 0.003
"""Outlines whose sides overlap by less pass each other [m]."""
_EQUAL = 1e-6
"""Of two sides that part the outlines by the same, the first one is taken [m]."""
_MOST_RESTITUTION = 0.25
"""More than bumpers give back [-]; up to here no hit, however oblique, gains energy in steps of 1 ms."""
_MOST_DAMPING = 0.5
"""Share of the speed that a damper takes in a step, at most: beyond 1 it would turn it round."""
_RISES = 0.05
"""Bumpers that were put into something come out with no more than this [m/s]: nobody has squeezed them."""
_LEAST_SIDE = 0.1
"""Length over which a corner presses a bumper in [m]."""
_NONE = np.zeros(4, np.uint8)
"""No side of a rectangle is hidden."""


def _restitution(ratio: float) -> float:
    """Of a spring and a damper that never pull, at a damping ratio: until the force of both is gone.

    Source: T. Schwager, T. Poeschel, "Coefficient of restitution and linear-dashpot model revisited", Granular Matter 9
    (2007), eq. 21 and 22.
    """
    if ratio < 1.0:
        s = math.sqrt(1.0 - ratio * ratio)
        return math.exp(-ratio / s * (math.pi - math.atan2(2.0 * ratio * s, 1.0 - 2.0 * ratio * ratio)))
    s = math.sqrt(max(ratio * ratio - 1.0, 1e-12))
    return math.exp(-ratio / s * math.log((ratio + s) / (ratio - s)))


_TRIED = np.linspace(3.0, 0.0, 3001)
_RATIOS = np.interp(np.linspace(0.0, 1.0, 101), [_restitution(ratio) for ratio in _TRIED], _TRIED)
"""Damping ratio by restitution, in hundredths."""


@compiled
def place_parts(robots, r, parts):
    """Put the outlines of a robot's bumpers where it is."""
    robot = robots[r]
    c = math.cos(robot.yaw)
    s = math.sin(robot.yaw)
    ax = c * robot.along[0] - s * robot.along[1]
    ay = s * robot.along[0] + c * robot.along[1]
    bx = c * robot.aside[0] - s * robot.aside[1]
    by = s * robot.aside[0] + c * robot.aside[1]
    for p in range(robot.first_part, robot.last_part):
        part = parts[p]
        # Of the middle of its height from the center of mass, in a robot that leans.
        high = 0.5 * (part.bottom + part.top)
        lean_x = robot.upward[0] * high - robot.center_ahead[0]
        lean_y = robot.upward[1] * high - robot.center_ahead[1]
        x = robot.x + c * lean_x - s * lean_y + ax * part.x + bx * part.y
        y = robot.y + s * lean_x + c * lean_y + ay * part.x + by * part.y
        lx = part.half_length * ax
        ly = part.half_length * ay
        wx = part.half_width * bx
        wy = part.half_width * by
        part.corners[0, 0] = x + lx - wx
        part.corners[0, 1] = y + ly - wy
        part.corners[1, 0] = x + lx + wx
        part.corners[1, 1] = y + ly + wy
        part.corners[2, 0] = x - lx + wx
        part.corners[2, 1] = y - ly + wy
        part.corners[3, 0] = x - lx - wx
        part.corners[3, 1] = y - ly - wy
        size_a = math.sqrt(ax * ax + ay * ay)
        size_b = math.sqrt(bx * bx + by * by)
        # The side after each corner runs along y, back along x, back along y and along x.
        part.normals[0, 0] = by / size_b
        part.normals[0, 1] = -bx / size_b
        part.normals[1, 0] = -ay / size_a
        part.normals[1, 1] = ax / size_a
        part.normals[2, 0] = -by / size_b
        part.normals[2, 1] = bx / size_b
        part.normals[3, 0] = ay / size_a
        part.normals[3, 1] = -ax / size_a


@compiled
def _widest(corners, normals, first, last, is_hidden, others, other_first, other_last):
    """The side of an outline from which another one is farthest, and by how much [m]; hidden sides part nothing."""
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


@compiled
def _manifold(a, a_normals, a_first, a_last, a_hidden, b, b_normals, b_first, b_last, b_hidden, found):
    """Where two outlines overlap: up to two of place, unit normal from a to b, depth and length, into `found`.

    Args:
        a: Corners of one outline among others [m].
        a_normals: Outward from the side after each corner.
        a_first: Its first corner.
        a_last: The one behind its last.
        a_hidden: Whether each side is covered by another outline.
        b: Of the other.
        b_normals: Of the other.
        b_first: Of the other.
        b_last: Of the other.
        b_hidden: Of the other.
        found: Rows of x, y, nx, ny, depth, length, shape (2, 6).

    Returns:
        How many.
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


@compiled
def _clip(a, a_normals, a_first, a_last, side, b, b_normals, b_first, b_last, sign, found):
    """Of a side of a, and the side of b that faces it: both ends of their overlap."""
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
    # Places along the side, and gaps, of both ends of the facing side; it runs the other way round.
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
            n += 1
    return n


@compiled
def _note_touch(robot, row):
    """Note the engine row of what a robot touches."""
    for k in range(robot.touched):
        if robot.touches[k] == row:
            return
    if robot.touched < TOUCHES:
        robot.touches[robot.touched] = row
        robot.touched += 1


@compiled
def _velocity(robot, x, y, height):
    """Of a robot at a place [m] and a height of the field [m], in plan [m/s, m/s]."""
    above = height - robot.pos[2]
    return (
        robot.vx - robot.omega * (y - robot.y) + robot.leaning[0] * above,
        robot.vy + robot.omega * (x - robot.x) + robot.leaning[1] * above,
    )


@compiled
def _mobility(robot, x, y, nx, ny):
    """Inverse of the mass that a robot shows at a place along a direction [1/kg]."""
    lever = (x - robot.x) * ny - (y - robot.y) * nx
    return 1.0 / robot.mass + lever * lever / robot.inertia[2]


@compiled
def _push(robot, x, y, fx, fy):
    """Let a force [N] act on a robot at a place [m]."""
    robot.contact[0] += fx
    robot.contact[1] += fy
    robot.contact[2] += (x - robot.x) * fy - (y - robot.y) * fx


@compiled
def _spring(springs, r, key, stamp, depth, is_put, h):
    """The spring of a contact of robot r: the one it has, or a free or old one, relaxed."""
    oldest = 0
    for k in range(springs.shape[1]):
        one = springs[r, k]
        if one.key == key and one.stamp >= stamp - 1 and not is_put:
            one.stamp = stamp
            one.put_in = max(0.0, min(one.put_in, depth) - _RISES * h)
            return k
        if one.stamp < springs[r, oldest].stamp:
            oldest = k
    one = springs[r, oldest]
    one.key = key
    one.stamp = stamp
    one.stretch = 0.0
    one.put_in = depth if is_put else 0.0
    return oldest


@compiled
def _ratio(restitution):
    """Damping ratio of a pair."""
    return _RATIOS[int(100.0 * min(restitution, _MOST_RESTITUTION) + 0.5)]


@compiled
def _force(found, n, stiffness, ratio, mass, friction, v_n, v_t, springs, r, key, stamp, is_put, h):
    """Force along the normal and across it at a contact [N, N]; v_n is that of the gap, v_t to the left of n [m/s]."""
    k = 0.5 * stiffness * found[n, 5]
    c = min(2.0 * ratio * math.sqrt(k * mass), _MOST_DAMPING * mass / h)
    spring = springs[r, _spring(springs, r, key, stamp, found[n, 4], is_put, h)]
    normal = max(0.0, k * (found[n, 4] - spring.put_in) - c * v_n)
    spring.stretch += v_t * h
    across = k * spring.stretch + c * v_t
    most = friction * normal
    if across > most or across < -most:
        across = most if across > 0.0 else -most
        spring.stretch = max(-most / k, min(most / k, spring.stretch))
    return normal, across


@compiled
def touch_outlines(robots, r, parts, outlines, corners, normals, hidden, springs, stamp, h, found):
    """Let a robot touch what stands on the field.

    Args:
        robots: All.
        r: Which.
        parts: Of all robots; its own are in place.
        outlines: Of the field.
        corners: Of all outlines [m], shape (n, 2).
        normals: Of the sides after them, shape (n, 2).
        hidden: Whether each side is covered by another outline, shape (n,).
        springs: Of friction, shape (robots, m).
        stamp: Number of the step.
        h: Step [s].
        found: Room for two contacts, shape (2, 6).
    """
    robot = robots[r]
    for p in range(robot.first_part, robot.last_part):
        part = parts[p]
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
            one = outlines[o]
            if one.low_x > high_x or one.high_x < low_x or one.low_y > high_y or one.high_y < low_y:
                continue
            count = _manifold(
                part.corners, part.normals, 0, 4, _NONE, corners, normals, one.first, one.last, hidden, found
            )
            for n in range(count):
                x = found[n, 0]
                y = found[n, 1]
                nx = found[n, 2]
                ny = found[n, 3]
                height = 0.5 * (max(part.low, one.bottom) + min(part.high, one.top))
                ux, uy = _velocity(robot, x, y, height)
                mass = 1.0 / _mobility(robot, x, y, nx, ny)
                normal, across = _force(
                    found, n, part.stiffness, _ratio(part.restitution * one.restitution), mass,
                    part.friction * one.friction, -(nx * ux + ny * uy), nx * uy - ny * ux,
                    springs, r, ((p + 1) * 100000 + o) * 2 + n, stamp, robot.is_put, h,
                )  # fmt: skip
                if normal > 0.0:
                    fx = -nx * normal + ny * across
                    fy = -ny * normal - nx * across
                    _push(robot, x, y, fx, fy)
                    _lean(robot, fx, fy, height, h)
                    _note_touch(robot, one.row)


@compiled
def _lean(robot, fx, fy, height, h):
    """Note that a force acts at a height [m] of the field: above the center of mass it tips, below it loads."""
    lever = height - robot.pos[2] - robot.center[2]
    robot.hit_moment[0] -= h * lever * fy
    robot.hit_moment[1] += h * lever * fx
    share = (height - robot.pos[2]) / robot.center[2] if robot.center[2] > 1e-6 else 0.0
    robot.contact_load[0] += (1.0 - share) * fx / robot.mass
    robot.contact_load[1] += (1.0 - share) * fy / robot.mass


@compiled
def touch_robots(robots, a, b, parts, springs, stamp, h, found):
    """Let two robots touch; their parts are in place. For the arguments see `touch_outlines`."""
    one = robots[a]
    other = robots[b]
    for p in range(one.first_part, one.last_part):
        mine = parts[p]
        for q in range(other.first_part, other.last_part):
            theirs = parts[q]
            low = max(mine.low, theirs.low)
            high = min(mine.high, theirs.high)
            if low >= high:
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
                ux, uy = _velocity(other, x, y, height)
                vx, vy = _velocity(one, x, y, height)
                ux -= vx
                uy -= vy
                mass = 1.0 / (_mobility(one, x, y, nx, ny) + _mobility(other, x, y, nx, ny))
                stiffness = mine.stiffness * theirs.stiffness / (mine.stiffness + theirs.stiffness)
                normal, across = _force(
                    found, n, stiffness, _ratio(mine.restitution * theirs.restitution), mass,
                    mine.friction * theirs.friction, nx * ux + ny * uy, nx * uy - ny * ux,
                    springs, a, -((p + 1) * 100000 + q) * 2 - n, stamp, one.is_put or other.is_put, h,
                )  # fmt: skip
                if normal > 0.0:
                    fx = nx * normal + ny * across
                    fy = ny * normal - nx * across
                    _push(other, x, y, fx, fy)
                    _push(one, x, y, -fx, -fy)
                    _lean(other, fx, fy, height, h)
                    _lean(one, -fx, -fy, height, h)
                    _note_touch(one, other.row)
                    _note_touch(other, one.row)
