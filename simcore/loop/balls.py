"""Motion of balls in steps of at most 1 ms: flight, rolling, bounces, piles, and balls pinned by robots.

`list_contacts` lists the ball-ball pairs and the ball-solid pairs that may touch within a few milliseconds.
`advance_balls` advances the balls by one step: the contact forces in the middle of the step change the velocities, and
the positions drift to the middle of the next step (leapfrog).

Most balls advance by whole steps. The loop divides the step into parts (substeps) for a fast ball, and for a ball whose
contact with a solid is too stiff for the whole step. Balls whose contacts with each other are too stiff advance
together in equal parts. The forces of all other pairs of balls are constant during the step.

A contact with a ball changes the velocity of a robot or swinging body in the same step. Other bodies move at constant
velocity during the call, and the engine applies the balls' impulses to these bodies after the call.

A sleeping ball does not move and needs almost no computing time. The ball wakes when a nearby ball moves, or when the
force of a ball or body differs from the force at which the ball fell asleep. The force that wakes a ball also
accelerates the ball.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from simcore.loop.body import apply_impulse
from simcore.loop.compiled import compiled, inlined, inner
from simcore.loop.contact import (
    air_acceleration,
    foam_energy,
    foam_force,
    foam_loss,
    foam_memory,
    foam_slope,
    friction_stiffness,
    hardened,
    rolling_resistance,
    steps_for,
)
from simcore.loop.neighbours import cell_range, grid_of, is_outside, listed_balls, near_pairs, near_solids
from simcore.loop.solids import Solids, nearest_point
from simcore.loop.state import (
    AWAKE,
    IN_FLIGHT,
    JUST_PUT,
    NOBODY,
    REMEMBERED,
    sleeps,
    speed,
    to_body,
    to_field,
)
from simcore.typing import FloatArray, IntArray

__all__ = ["advance_balls", "any_moves", "depth_at", "drift_balls", "end_balls", "list_contacts"]

_STANDING = 1e-3  # speed below which a body is at rest [m/s, rad/s]
_MOST_SURFACES = 12  # largest number of contacts of a ball with solids and floor at one time
_FLOOR, _PAIR = -2, -3  # contact key of the floor; contact key of the other ball is `_PAIR` minus that ball's row
_COPLANAR = 5e-4  # distance of an edge from the plane of a touched face within which the edge is ignored [m]
_QUIET_SPEED = 0.03  # speed below which a ball is still [m/s]
_GAINS = 0.004  # increase of a still ball's speed that restarts the time `still` [m/s]
_WAKING_SPEED = 0.05  # speed above which a ball wakes a sleeping ball that it touches or almost touches [m/s]
_BESIDE = 0.003  # gap up to which a moving ball wakes a sleeping ball that may lean on the moving ball [m]
_LIFTED = 2.5  # increase of another ball's force that wakes a sleeping ball, over the sleeping ball's weight [-]
_TOUCH_FORCE, _TOUCH_SHARE = 0.2, 0.05  # change of the bodies' force that wakes a ball: [N] plus a fraction [-]
_RISES = 0.5  # speed at which an initial overlap decays [m/s]
_STOPPING = 0.1  # largest fraction of a pair's relative spin that rolling resistance removes in a step [-]
_FARTHEST = 0.25  # largest displacement of a ball near solids in one part of a step, over the ball's radius [-]


class Listed(NamedTuple):
    """Balls that may move or wake within a few milliseconds, and the contacts of these balls with floor and solids."""

    queue: IntArray
    """Rows of the listed balls; only the first `size` entries are valid."""
    size: int
    """Number of listed balls."""
    start: IntArray
    """Index of each ball's first entry in `near`; the last element is the number of entries, shape (size + 1,)."""
    near: IntArray
    """Rows of the solids that the balls may touch while the list is valid, ball by ball."""
    has_bodies: npt.NDArray[np.uint8]
    """1 for balls that may touch a solid of a body, else 0, shape (size,)."""
    number: IntArray
    """Number of present contacts of each ball with floor and solids, shape (size,)."""
    found: FloatArray
    """Unit normal towards the ball [-], depth [m], and contact point relative to the ball's center [m] of each contact,
    deepest contact first, field axes, shape (12, size, 7)."""
    which: IntArray
    """Row of the touched solid (-2 for the floor) and 1 for a contact with a face (0 for an edge or corner) of each
    contact, shape (12, size, 2)."""
    is_leaving: npt.NDArray[np.uint8]
    """1 for balls that still overlap the body that launched the ball, else 0, shape (size,)."""
    reach: FloatArray
    """Distance from each ball's center within which `gap` is exact [m], shape (size,)."""
    gap: FloatArray
    """Smallest gap between each ball and the floor or a solid, negative for an overlap [m], shape (size,)."""
    nearest: IntArray
    """Row of the solid with the smallest gap, -2 for the floor and for balls without a near solid, shape (size,)."""
    parts: IntArray
    """Number of parts of the step for each ball, shape (size,)."""
    joint: IntArray
    """Number of parts that the stiff pairs of each ball need, 1 without stiff pairs, indexed by row, shape (n,)."""
    order: IntArray
    """Indices into `queue`: first balls that take a whole step, then balls that take parts of the step, then balls with
    stiff pairs, shape (size,)."""


class Pairs(NamedTuple):
    """Pairs of balls that may touch within a few milliseconds."""

    first: IntArray
    """Row of one ball of each pair; only the first `size` entries are valid."""
    second: IntArray
    """Row of the other ball of each pair; only the first `size` entries are valid."""
    size: int
    """Number of pairs."""
    stiffness: npt.NDArray[np.uint8]
    """0 for pairs that can take whole steps, 1 for pairs that are too stiff for a whole step at a large depth or
    closing speed, 2 for pairs that are too stiff at any depth, shape (size,)."""
    stiff: IntArray
    """Indices of the pairs that are too stiff for the present step; `collide` returns the number of valid entries,
    shape (size,)."""


@inner
def _slot(key, stamp, i, touched):
    """Return the index of the contact with the key `touched` in the memory of ball i.

    A contact that is not in the memory replaces the contact with the oldest stamp.
    """
    oldest = 0
    for s in range(REMEMBERED):
        if key[i, s] == touched:
            return s
        if stamp[i, s] < stamp[i, oldest]:
            oldest = s
    key[i, oldest] = touched
    stamp[i, oldest] = -2
    return oldest


@inlined
def _squeeze(spring, i, s, is_new, is_put, depth, closing, h):
    """Update the initial overlap of a contact, and return the compression: `depth` minus the initial overlap [m].

    Only a new contact of a ball that a user has just placed has an initial overlap: the part of the depth [m] that the
    closing speed [m/s] does not explain within a step of h [s]. The initial overlap decays with time.
    """
    if is_new:
        spring[i, s, 3] = max(0.0, depth - max(0.0, closing) * h) if is_put else 0.0
    else:
        spring[i, s, 3] = max(0.0, min(spring[i, s, 3], depth) - _RISES * h)
    return depth - spring[i, s, 3]


@inlined
def _push(spring, i, s, is_new, depth, closing, k1, k3, hard_from, hard, restitution, h):
    """Return the normal force of a contact with hysteresis [N], and update the memory and energy of the foam.

    The memory of a new contact begins at 2 v h / d, at most 1, for a closing speed v and an overlap d; a contact
    without overlap begins at 1.
    """
    loss, band = foam_loss(restitution)
    energy = foam_energy(depth, k1, k3, hard_from, hard)
    if is_new:
        spring[i, s, 4] = min(1.0, 2.0 * max(0.0, closing) * h / depth) if depth > 0.0 else 1.0
    else:
        spring[i, s, 4] = foam_memory(spring[i, s, 4], energy, spring[i, s, 5], band, h)
    spring[i, s, 5] = energy
    return foam_force(depth, k1, k3, hard_from, hard) * (1.0 + loss * spring[i, s, 4])


@inlined
def _friction(spring, i, s, is_new, nx, ny, nz, ux, uy, uz, push, slope, friction, mass, h):
    """Return the friction force on a ball, field axes [N], and update the friction spring of the contact.

    Args:
        spring: State of the contacts of all balls, `Memory.spring`.
        i: Row of the ball whose memory contains the contact.
        s: Index of the contact in the ball's memory.
        is_new: Whether the contact is new in this step.
        nx: x component of the unit normal towards the ball.
        ny: y component of the unit normal.
        nz: z component of the unit normal.
        ux: x component of the velocity of the ball's surface at the contact, relative to the other surface [m/s].
        uy: y component of the relative velocity [m/s].
        uz: z component of the relative velocity [m/s].
        push: Normal force [N].
        slope: Normal stiffness [N/m].
        friction: Coefficient of friction of the pair [-].
        mass: Reduced mass of the pair [kg].
        h: Time step [s].
    """
    x, y, z = spring[i, s, 0], spring[i, s, 1], spring[i, s, 2]
    if is_new:
        x = y = z = 0.0
    away = ux * nx + uy * ny + uz * nz
    tx, ty, tz = ux - away * nx, uy - away * ny, uz - away * nz
    x, y, z = x + tx * h, y + ty * h, z + tz * h
    out = x * nx + y * ny + z * nz  # the normal may have turned since the last step
    x, y, z = x - out * nx, y - out * ny, z - out * nz
    stiffness, damping = friction_stiffness(slope, mass, h)
    fx, fy, fz = -stiffness * x - damping * tx, -stiffness * y - damping * ty, -stiffness * z - damping * tz
    size, most = math.sqrt(fx * fx + fy * fy + fz * fz), friction * push
    if size > most:  # the contact slips
        share = most / size
        fx, fy, fz = share * fx, share * fy, share * fz
        give = -1.0 / stiffness
        x, y, z = give * (fx + damping * tx), give * (fy + damping * ty), give * (fz + damping * tz)
    spring[i, s, 0], spring[i, s, 1], spring[i, s, 2] = x, y, z
    return fx, fy, fz


# --- contacts of one ball with solids -------------------------------------------------------------------------------


@inner
def _add_contact(found, which, q, count, solid, distance, radius, nx, ny, nz, is_face):
    """Insert a contact into the contact list of a ball, sorted by decreasing depth.

    If the list already has 12 contacts, the function drops the shallowest contact.

    Args:
        found: Array `Listed.found`.
        which: Array `Listed.which`.
        q: Index of the ball in `Listed.queue`.
        count: Number of contacts in the list.
        solid: Row of the solid, or -2 for the floor.
        distance: Distance of the ball's center from the solid, negative inside [m].
        radius: Radius of the ball [m].
        nx: x component of the unit normal towards the ball.
        ny: y component of the unit normal.
        nz: z component of the unit normal.
        is_face: Whether the ball touches a face, and not an edge or corner.

    Returns:
        New number of contacts.
    """
    if count == _MOST_SURFACES and found[count - 1, q, 3] >= radius - distance:
        return count
    k = min(count, _MOST_SURFACES - 1)
    while k > 0 and found[k - 1, q, 3] < radius - distance:
        for c in range(7):
            found[k, q, c] = found[k - 1, q, c]
        which[k, q, 0], which[k, q, 1] = which[k - 1, q, 0], which[k - 1, q, 1]
        k -= 1
    found[k, q, 0], found[k, q, 1], found[k, q, 2], found[k, q, 3] = nx, ny, nz, radius - distance
    found[k, q, 4], found[k, q, 5], found[k, q, 6] = -distance * nx, -distance * ny, -distance * nz
    which[k, q, 0], which[k, q, 1] = solid, 1 if is_face else 0
    return min(count + 1, _MOST_SURFACES)


@inner
def _without_edges(found, which, q, count):
    """Remove the contacts in or behind the face plane of a deeper contact, and return the number of remaining contacts.

    A ball that rolls across the seam between two coplanar plates therefore does not hit the edges at the seam.
    """
    kept = 0
    for k in range(count):
        is_hidden = False
        for m in range(kept):
            if which[m, q, 1] == 1:
                over = (
                    (found[k, q, 4] - found[m, q, 4]) * found[m, q, 0]
                    + (found[k, q, 5] - found[m, q, 5]) * found[m, q, 1]
                    + (found[k, q, 6] - found[m, q, 6]) * found[m, q, 2]
                )
                is_hidden = is_hidden or over < _COPLANAR
        if not is_hidden:
            if kept < k:
                for c in range(7):
                    found[kept, q, c] = found[k, q, c]
                which[kept, q, 0], which[kept, q, 1] = which[k, q, 0], which[k, q, 1]
            kept += 1
    return kept


# --- contacts of balls with each other ------------------------------------------------------------------------------


@inlined
def _wake(status, still, hold, i):
    """Wake a sleeping ball, and set the ball's time at rest and the force that frees a lodged ball to 0."""
    status[i] = AWAKE
    still[i] = 0.0
    hold[i] = 0.0


@inlined
def _pair_foam(foam, a, b):
    """Return the parameters k1, k3, d0 and k2 of `foam_force` for a pair of balls, modeled as two springs in series.

    The linear term is exact. The other terms assume that the overlap compresses both balls equally.
    """
    linear, cubic = foam[a, 0] * foam[b, 0] / (foam[a, 0] + foam[b, 0]), 0.0625 * (foam[a, 1] + foam[b, 1])
    return linear, cubic, foam[a, 2] + foam[b, 2], 0.125 * (foam[a, 3] + foam[b, 3])


@inlined
def _parts_of_pair(foam, surface, masses, a, b, depth, way, h):
    """Return the number of parts of a step of h [s] that a pair needs at an overlap of `depth` plus `way` [m]."""
    linear, cubic, hard_from, hard = _pair_foam(foam, a, b)
    slope = foam_slope(max(0.0, depth) + max(0.0, way), linear, cubic, hard_from, hard)
    mass = masses[a] * masses[b] / (masses[a] + masses[b])
    return steps_for(hardened(slope, surface[a, 1] * surface[b, 1]), mass, h)


@inner
def mark_stiff_pairs(balls, pairs, within, h):
    """Set `Pairs.stiffness`: mark the pairs that may become too stiff for a step of h [s] in the next `within` [s]."""
    pos, vel, radii, foam, surface, masses = balls.pos, balls.vel, balls.radius, balls.foam, balls.surface, balls.mass
    for p in range(pairs.size):
        a, b = pairs.first[p], pairs.second[p]
        nx, ny, nz = pos[a, 0] - pos[b, 0], pos[a, 1] - pos[b, 1], pos[a, 2] - pos[b, 2]
        depth = radii[a] + radii[b] - math.sqrt(nx * nx + ny * ny + nz * nz)
        way = (speed(vel, a) + speed(vel, b)) * within
        pairs.stiffness[p] = 0
        if _parts_of_pair(foam, surface, masses, a, b, depth, way, h) > 1:
            pairs.stiffness[p] = 2 if _parts_of_pair(foam, surface, masses, a, b, 0.0, 0.0, h) > 1 else 1


@inner
def collide(balls, memory, gravity, listed, pairs, count, force, h, is_whole):
    """Add the contact forces between balls to `force`, and wake sleeping balls that are pushed or lose support.

    Args:
        balls: All balls.
        memory: Contact memory of the balls.
        gravity: Gravitational acceleration [m/s^2].
        listed: Balls from `list_contacts`; the function updates `listed.joint` for stiff pairs.
        pairs: Pairs from `list_contacts`.
        count: Number of pairs to compute: all pairs in a whole step, else the first entries of `pairs.stiff`.
        force: Force [N] and torque [N m] on each ball, number of contacts, and largest normal force [N], shape (n, 8).
        h: Time step, or part of a step [s].
        is_whole: Whether `h` is a whole step. If so, pairs that are too stiff for a whole step give no force, and the
            function adds these pairs to `pairs.stiff`.

    Returns:
        Number of entries in `pairs.stiff`; 0 unless `is_whole`.
    """
    status, pos, vel, spin, radii, masses = balls.status, balls.pos, balls.vel, balls.spin, balls.radius, balls.mass
    foam, surface, still, hold, press = balls.foam, balls.surface, balls.still, balls.hold, balls.press
    key, stamp, spring, now, is_put = memory.key, memory.stamp, memory.spring, memory.clock[0], balls.is_put
    first, second, stiffness, joint = pairs.first, pairs.second, pairs.stiffness, listed.joint
    stiff, slowing = 0, 0.4 * _STOPPING / h
    for entry in range(count):
        p = entry if is_whole else pairs.stiff[entry]
        a, b = first[p], second[p]
        sleeper = a if sleeps(status, a) else b if sleeps(status, b) else NOBODY
        if sleeper == a and sleeps(status, b):
            continue
        nx, ny, nz = pos[a, 0] - pos[b, 0], pos[a, 1] - pos[b, 1], pos[a, 2] - pos[b, 2]
        reach, square = radii[a] + radii[b], nx * nx + ny * ny + nz * nz
        if sleeper >= 0 and hold[sleeper] == 0.0 and square < (reach + _BESIDE) * (reach + _BESIDE):
            if speed(vel, b if sleeper == a else a) > _WAKING_SPEED:  # the sleeper may lean on the moving ball
                _wake(status, still, hold, sleeper)
                sleeper = NOBODY
        fastest = 0.0
        if is_whole and stiffness[p] == 2:  # this pair must not come into contact within a whole step
            fastest = (speed(vel, a) + speed(vel, b)) * h  # by the sum of speeds, as another contact may reverse a ball
        if square >= (reach + fastest) * (reach + fastest):
            continue
        distance = math.sqrt(square)
        if distance > 1e-9:
            nx, ny, nz = nx / distance, ny / distance, nz / distance
        else:
            nx, ny, nz = 0.0, 0.0, 1.0
        depth = reach - distance
        ra, rb = radii[a] * distance / reach, radii[b] * distance / reach
        wx, wy, wz = (
            ra * spin[a, 0] + rb * spin[b, 0], ra * spin[a, 1] + rb * spin[b, 1], ra * spin[a, 2] + rb * spin[b, 2],
        )  # fmt: skip
        ux = vel[a, 0] - vel[b, 0] - (wy * nz - wz * ny)
        uy = vel[a, 1] - vel[b, 1] - (wz * nx - wx * nz)
        uz = vel[a, 2] - vel[b, 2] - (wx * ny - wy * nx)
        closing = -(ux * nx + uy * ny + uz * nz)
        if is_whole and stiffness[p] > 0:
            needed = _parts_of_pair(foam, surface, masses, a, b, depth, closing * h, h)
            if needed > 1:
                pairs.stiff[stiff] = p
                stiff += 1
                joint[a], joint[b] = max(joint[a], needed), max(joint[b], needed)
                continue
        if depth <= 0.0:
            continue
        linear, cubic, hard_from, hard = _pair_foam(foam, a, b)
        mass = masses[a] * masses[b] / (masses[a] + masses[b])
        i, j = (a, b) if a < b else (b, a)  # the memory of the ball with the lower row has the contact
        s = _slot(key, stamp, i, _PAIR - j)
        is_new = stamp[i, s] < now - 1 or is_put[a] == JUST_PUT or is_put[b] == JUST_PUT
        stamp[i, s] = now
        depth = _squeeze(spring, i, s, is_new, is_put[a] or is_put[b], depth, closing, h)
        slope = foam_slope(depth, linear, cubic, hard_from, hard)
        bounce = surface[a, 1] * surface[b, 1]
        push = _push(spring, i, s, is_new, depth, closing, linear, cubic, hard_from, hard, bounce, h)
        if sleeper >= 0:
            if is_put[sleeper] == JUST_PUT:  # the contact is old from the next step on
                is_put[sleeper] = 1
            most = hold[sleeper] if hold[sleeper] > 0.0 else press[sleeper] + _LIFTED * masses[sleeper] * gravity
            if push > most or (closing > _QUIET_SPEED and hold[sleeper] == 0.0):
                _wake(status, still, hold, sleeper)
        sign = 1.0 if i == a else -1.0
        fx, fy, fz = _friction(
            spring, i, s, is_new, sign * nx, sign * ny, sign * nz, sign * ux, sign * uy, sign * uz, push, slope,
            surface[a, 0] * surface[b, 0], mass, h,
        )  # fmt: skip
        fx, fy, fz = push * nx + sign * fx, push * ny + sign * fy, push * nz + sign * fz
        tx, ty, tz = ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx
        wx, wy, wz = spin[a, 0] - spin[b, 0], spin[a, 1] - spin[b, 1], spin[a, 2] - spin[b, 2]
        smaller, turning = min(radii[a], radii[b]), wx * wx + wy * wy + wz * wz
        brake = slowing * mass * smaller * smaller  # largest torque over the relative spin
        if turning > 1e-12:
            brake = min(brake, rolling_resistance(push, turning, depth, radii[a] * radii[b] / reach, bounce))
        force[a, 0] += fx
        force[a, 1] += fy
        force[a, 2] += fz
        force[a, 3] -= ra * tx + brake * wx
        force[a, 4] -= ra * ty + brake * wy
        force[a, 5] -= ra * tz + brake * wz
        force[b, 0] -= fx
        force[b, 1] -= fy
        force[b, 2] -= fz
        force[b, 3] -= rb * tx - brake * wx
        force[b, 4] -= rb * ty - brake * wy
        force[b, 5] -= rb * tz - brake * wz
        force[a, 6] += 1.0
        force[b, 6] += 1.0
        force[a, 7] = max(force[a, 7], push)
        force[b, 7] = max(force[b, 7], push)
    return stiff


# --- one step -------------------------------------------------------------------------------------------------------


@inner
def find_contacts(balls, solids, bodies, floor, listed, first, last, late, h):
    """Find the contacts and smallest gaps of listed balls with floor, field and bodies, and update `listed`.

    For sleeping balls the function finds only contacts with bodies.

    Args:
        balls: All balls.
        solids: Solids of the field and of bodies.
        bodies: Records of all bodies, with poses in the middle of the step.
        floor: Properties of the floor.
        listed: Balls from `list_contacts`.
        first: Index of the first ball in `listed.order`.
        last: Index after the last ball in `listed.order`.
        late: Time since the middle of the step, for which bodies are extrapolated at constant velocity [s].
        h: Time step [s]; gaps are exact up to the displacement of the ball in half a step.
    """
    queue, start, near, found, which = listed.queue, listed.start, listed.near, listed.found, listed.which
    number, is_leaving, reaches, gaps, nearest = (
        listed.number, listed.is_leaving, listed.reach, listed.gap, listed.nearest,
    )  # fmt: skip
    status, pos, vel, radii, leaves = balls.status, balls.pos, balls.vel, balls.radius, balls.leaves
    owner, box, begin, plane, corner = solids.body, solids.box, solids.first, solids.plane, solids.corner
    origin, axes, center, moving, turning = bodies.pos, bodies.axes, bodies.com, bodies.vel, bodies.rate
    is_floor, has_bodies = floor.is_there, listed.has_bodies
    for entry in range(first, last):
        q = listed.order[entry]
        i = queue[q]
        is_asleep = sleeps(status, i)
        n = 0
        number[q], is_leaving[q], nearest[q] = 0, 0, _FLOOR
        if is_asleep and not has_bodies[q]:
            continue
        x, y, z, radius = pos[i, 0], pos[i, 1], pos[i, 2], radii[i]
        reach = radius if is_asleep else radius + 0.5 * h * speed(vel, i)
        gap = z - radius if is_floor else 1e30
        if is_floor and z < radius and not is_asleep:
            n = _add_contact(found, which, q, n, _FLOOR, z, radius, 0.0, 0.0, 1.0, True)
        for candidate in range(start[q], start[q + 1]):
            s = near[candidate]
            b = owner[s]
            lx, ly, lz = x, y, z
            if b >= 0:
                ox, oy, oz = x - center[b, 0], y - center[b, 1], z - center[b, 2]
                wx, wy, wz = turning[b, 0], turning[b, 1], turning[b, 2]
                lx, ly, lz = to_body(
                    axes, b,
                    x - origin[b, 0] - late * (moving[b, 0] + wy * oz - wz * oy),
                    y - origin[b, 1] - late * (moving[b, 1] + wz * ox - wx * oz),
                    z - origin[b, 2] - late * (moving[b, 2] + wx * oy - wy * ox),
                )  # fmt: skip
            elif is_asleep:
                continue
            if is_outside(box, s, lx, ly, lz, reach):
                continue
            distance, nx, ny, nz, is_face = nearest_point(s, lx, ly, lz, reach, begin, plane, corner)
            if b >= 0:
                nx, ny, nz = to_field(axes, b, nx, ny, nz)
            if distance < radius and b >= 0 and b == leaves[i]:
                is_leaving[q] = 1
                continue
            if distance - radius < gap:
                gap = distance - radius
                nearest[q] = s
            if distance < radius:
                n = _add_contact(found, which, q, n, s, distance, radius, nx, ny, nz, is_face)
        if n > 1:
            n = _without_edges(found, which, q, n)
        number[q], reaches[q], gaps[q] = n, reach, gap


@inner
def choose_parts(balls, solids, floor, listed, h):
    """Choose the number of parts of a step for each listed ball, and sort `listed.order`.

    The number follows from the ball's speed, the stiffest contact and the ball's stiff pairs. The order is: balls that
    take a whole step, balls that take parts of the step (by increasing number of parts), and balls with stiff pairs.
    The function resets `listed.joint` to 1 for all listed balls.

    Args:
        balls: All balls.
        solids: Solids of the field and of bodies.
        floor: Properties of the floor.
        listed: Balls from `list_contacts`, with contacts from `find_contacts`.
        h: Time step [s].

    Returns:
        Number of balls that take a whole step, and number of balls without stiff pairs.
    """
    queue, start, number, found, parts = listed.queue, listed.start, listed.number, listed.found, listed.parts
    reach, gap, status, vel, radii, foam = listed.reach, listed.gap, balls.status, balls.vel, balls.radius, balls.foam
    nearest, which, surface, material = listed.nearest, listed.which, balls.surface, solids.surface
    masses, on_floor, joint, order = balls.mass, floor.restitution, listed.joint, listed.order
    whole, behind = 0, listed.size
    for q in range(listed.size):
        i = queue[q]
        parts[q] = joint[i]
        if not sleeps(status, i):
            k1, k3, hard_from, hard = foam[i, 0], foam[i, 1], foam[i, 2], foam[i, 3]
            vx, vy, vz, most = vel[i, 0], vel[i, 1], vel[i, 2], joint[i]
            if start[q + 1] > start[q]:
                most = max(most, math.ceil(speed(vel, i) * h / (_FARTHEST * radii[i])))
            comes, stiffness, own = reach[q] - radii[i], 0.0, surface[i, 1]
            if 0.0 <= gap[q] < comes:  # the ball will touch within this step
                restitution = own * (material[nearest[q], 1] if nearest[q] >= 0 else on_floor)
                stiffness = hardened(foam_slope(comes - gap[q], k1, k3, hard_from, hard), restitution)
            for k in range(number[q]):
                closing = -(vx * found[k, q, 0] + vy * found[k, q, 1] + vz * found[k, q, 2])
                depth = found[k, q, 3] + max(0.0, closing) * h
                restitution = own * (material[which[k, q, 0], 1] if which[k, q, 0] >= 0 else on_floor)
                stiffness = max(stiffness, hardened(foam_slope(depth, k1, k3, hard_from, hard), restitution))
            parts[q] = max(most, steps_for(stiffness, masses[i], h))
        if joint[i] > 1:
            behind -= 1
            order[behind] = q
        elif parts[q] == 1:
            order[whole] = q
            whole += 1
    alone = whole
    for q in range(listed.size):
        if joint[queue[q]] > 1:
            joint[queue[q]] = 1
        elif parts[q] > 1:  # sorted by parts
            k = alone
            while k > whole and parts[order[k - 1]] > parts[q]:
                order[k] = order[k - 1]
                k -= 1
            order[k] = q
            alone += 1
    return whole, alone


@inlined
def _kick(vx, vy, vz, sx, sy, sz, ax, ay, az, tx, ty, tz, rolling, fading, mass, radius, h):
    """Return the velocity and spin of a ball after an acceleration [m/s^2] and a torque [N m] over h [s].

    The torque of rolling resistance `rolling` [N m] and the decay of spin in air `fading` [-] reduce the spin, at most
    to zero.
    """
    turnability = 2.5 / (mass * radius * radius)
    vx, vy, vz = vx + h * ax, vy + h * ay, vz + h * az
    sx, sy, sz = sx + h * turnability * tx, sy + h * turnability * ty, sz + h * turnability * tz
    size = math.sqrt(sx * sx + sy * sy + sz * sz)
    if size > 0.0:
        keep = max(0.0, 1.0 - h * (rolling * turnability / size + fading * size))
        sx, sy, sz = keep * sx, keep * sy, keep * sz
    return vx, vy, vz, sx, sy, sz


@inner
def integrate(balls, memory, solids, bodies, floor, listed, force, first, last, late, h, on):
    """Advance the velocities and positions of balls under contact forces, gravity and air forces.

    The function also applies the reaction forces to bodies. A sleeping ball does not move, but pushes on bodies. The
    ball wakes if the normal force from bodies differs by more than a threshold from the force at which the ball fell
    asleep.

    Args:
        balls: All balls; the positions of awake balls are in the middle of the step or part.
        memory: Contact memory of the balls.
        solids: Solids of the field and of bodies.
        bodies: Records of all bodies, with poses in the middle of the step.
        floor: Properties of the floor, and gravity.
        listed: Balls from `list_contacts`, with contacts from `find_contacts`.
        force: Forces of the balls on each other, as in `collide`, shape (n, 8); the function sets the used rows to 0.
        first: Index of the first ball in `listed.order`.
        last: Index after the last ball in `listed.order`.
        late: Time from the middle of the step to the time of the ball positions [s].
        h: Time step, or part of a step [s].
        on: Time by which the positions advance, usually to the middle of the next step or part [s].
    """
    queue, number, found, which, order = listed.queue, listed.number, listed.found, listed.which, listed.order
    has_bodies, is_leaving = listed.has_bodies, listed.is_leaving
    status, pos, vel, spin, radii, masses = balls.status, balls.pos, balls.vel, balls.spin, balls.radius, balls.mass
    foam, surface, air, still, load = balls.foam, balls.surface, balls.air, balls.still, balls.load
    hold, contacts, seen, leaves = balls.hold, balls.contacts, balls.bodies, balls.leaves
    is_touched, press, is_put = balls.is_touched, balls.press, balls.is_put
    key, stamp, spring, now = memory.key, memory.stamp, memory.spring, memory.clock[0]
    owner, material = solids.body, solids.surface
    center, moving, turning = bodies.com, bodies.vel, bodies.rate
    for entry in range(first, last):
        q = order[entry]
        i = queue[q]
        px, py, pz, qx, qy, qz = force[i, 0], force[i, 1], force[i, 2], force[i, 3], force[i, 4], force[i, 5]
        touched, pressed = int(force[i, 6]) + number[q], force[i, 7]
        for k in range(8):
            force[i, k] = 0.0
        is_asleep = sleeps(status, i)
        if is_asleep and not has_bodies[q]:
            continue
        if not is_leaving[q] and len(bodies) > 0:
            leaves[i] = NOBODY
        radius, mass = radii[i], masses[i]
        k1, k3, hard_from, hard = foam[i, 0], foam[i, 1], foam[i, 2], foam[i, 3]
        own_friction, own_restitution, own_rolling = surface[i, 0], surface[i, 1], surface[i, 2]
        x, y, z, vx, vy, vz = pos[i, 0], pos[i, 1], pos[i, 2], vel[i, 0], vel[i, 1], vel[i, 2]
        sx, sy, sz = spin[i, 0], spin[i, 1], spin[i, 2]
        fx, fy, fz, tx, ty, tz, rolling, by_bodies, is_in = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, False
        for k in range(number[q]):
            s, depth = which[k, q, 0], found[k, q, 3]
            nx, ny, nz = found[k, q, 0], found[k, q, 1], found[k, q, 2]
            lever = radius - depth
            ux = vx - lever * (sy * nz - sz * ny)
            uy = vy - lever * (sz * nx - sx * nz)
            uz = vz - lever * (sx * ny - sy * nx)
            b, ax, ay, az = NOBODY, 0.0, 0.0, 0.0
            if s == _FLOOR:
                friction, restitution = own_friction * floor.friction, own_restitution * floor.restitution
                resistance = own_rolling * floor.friction + floor.rolling * own_friction
            else:
                friction, restitution = own_friction * material[s, 0], own_restitution * material[s, 1]
                resistance = own_rolling * material[s, 0] + material[s, 2] * own_friction
                b = owner[s]
                if b >= 0:
                    ax = x + found[k, q, 4] - center[b, 0] - late * moving[b, 0]
                    ay = y + found[k, q, 5] - center[b, 1] - late * moving[b, 1]
                    az = z + found[k, q, 6] - center[b, 2] - late * moving[b, 2]
                    ux -= moving[b, 0] + turning[b, 1] * az - turning[b, 2] * ay
                    uy -= moving[b, 1] + turning[b, 2] * ax - turning[b, 0] * az
                    uz -= moving[b, 2] + turning[b, 0] * ay - turning[b, 1] * ax
            m = _slot(key, stamp, i, s)
            is_new = stamp[i, m] < now - 1 or is_put[i] == JUST_PUT
            stamp[i, m] = now
            closing = -(ux * nx + uy * ny + uz * nz)
            depth = _squeeze(spring, i, m, is_new, is_put[i], depth, closing, h)
            is_in = is_in or spring[i, m, 3] > 0.0
            slope = foam_slope(depth, k1, k3, hard_from, hard)
            push = _push(spring, i, m, is_new, depth, closing, k1, k3, hard_from, hard, restitution, h)
            gx, gy, gz = _friction(spring, i, m, is_new, nx, ny, nz, ux, uy, uz, push, slope, friction, mass, h)
            gx, gy, gz = gx + push * nx, gy + push * ny, gz + push * nz
            fx, fy, fz = fx + gx, fy + gy, fz + gz
            tx -= lever * (ny * gz - nz * gy)
            ty -= lever * (nz * gx - nx * gz)
            tz -= lever * (nx * gy - ny * gx)
            rolling += resistance * push
            if b >= 0:
                by_bodies += push
                seen[i] |= bodies[b].model.mark
                if bodies[b].is_awake or not (is_asleep and bodies[b].model.swings):
                    apply_impulse(bodies[b], -h * gx, -h * gy, -h * gz, ax, ay, az)
        contacts[i] = touched
        if touched > 0:
            is_touched[i] = 1
        is_put[i] = 1 if is_put[i] and (is_in or is_asleep) else 0
        if is_asleep:
            most = hold[i] if hold[i] > 0.0 else _TOUCH_FORCE + _TOUCH_SHARE * load[i]
            if abs(by_bodies - load[i]) <= most:
                continue
            _wake(status, still, hold, i)
        load[i] = by_bodies
        press[i] = pressed
        gx, gy, gz = air_acceleration(vx, vy, vz, sx, sy, sz, air[i, 0], air[i, 1], air[i, 2])
        lightness = 1.0 / mass
        vx, vy, vz, sx, sy, sz = _kick(
            vx, vy, vz, sx, sy, sz, gx + (px + fx) * lightness, gy + (py + fy) * lightness,
            gz + (pz + fz) * lightness - floor.gravity, qx + tx, qy + ty, qz + tz, rolling, air[i, 3], mass, radius, h,
        )  # fmt: skip
        pos[i, 0], pos[i, 1], pos[i, 2] = x + on * vx, y + on * vy, z + on * vz
        vel[i, 0], vel[i, 1], vel[i, 2] = vx, vy, vz
        spin[i, 0], spin[i, 1], spin[i, 2] = sx, sy, sz


@compiled
def _advance_in_parts(balls, memory, solids, bodies, floor, listed, pairs, stiff, force, first, last, h, ahead):
    """Advance some balls by one step in equal parts.

    The number of parts is the largest number in `listed.parts` of these balls.

    Args:
        balls: All balls, with positions in the middle of the step.
        memory: Contact memory of the balls.
        solids: Solids of the field and of bodies.
        bodies: Records of all bodies, with poses in the middle of the step.
        floor: Properties of the floor, and gravity.
        listed: Balls from `list_contacts`.
        pairs: Pairs from `list_contacts`.
        stiff: Number of stiff pairs among the balls to advance.
        force: Forces of the other pairs, as in `collide`, constant during the step, shape (n, 8); the function sets the
            used rows to 0.
        first: Index of the first ball in `listed.order`.
        last: Index after the last ball in `listed.order`.
        h: Time step [s].
        ahead: Time from the middle of the step to the middle of the next step, or to the end of the last step [s].
    """
    queue, order, status, pos, vel = listed.queue, listed.order, balls.status, balls.pos, balls.vel
    count = 1
    for entry in range(first, last):
        count = max(count, listed.parts[order[entry]])
    part = h / count
    constant = np.empty((last - first, 8))
    for entry in range(first, last):
        i = queue[order[entry]]
        for k in range(8):
            constant[entry - first, k] = force[i, k]
        if not sleeps(status, i):  # back to the middle of the first part
            for c in range(3):
                pos[i, c] -= 0.5 * (h - part) * vel[i, c]
    for number in range(count):
        if number > 0:
            for entry in range(first, last):
                for k in range(8):
                    force[queue[order[entry]], k] = constant[entry - first, k]
        late = (number + 0.5) * part - 0.5 * h
        on = part if number < count - 1 else ahead - late
        if stiff > 0:
            collide(balls, memory, floor.gravity, listed, pairs, stiff, force, part, False)
        find_contacts(balls, solids, bodies, floor, listed, first, last, late, 0.0)
        integrate(balls, memory, solids, bodies, floor, listed, force, first, last, late, part, on)


@compiled
def list_contacts(balls, bodies, solids, with_pairs, h, step):
    """List the balls that may move or wake within h [s], and the possible contacts of these balls.

    Args:
        balls: All balls.
        bodies: Records of all bodies.
        solids: Solids of the field and of bodies.
        with_pairs: Whether balls collide with each other.
        h: Time for which the lists are valid [s].
        step: Time step, for the stiffness marks of the pairs [s].

    Returns:
        Listed balls and the solids near these balls, as `Listed`, and pairs of balls, as `Pairs`.
    """
    grid = grid_of(balls)
    way = np.empty(balls.pos.shape[0])  # displacement of each ball within h [m]
    for i in range(len(way)):
        way[i] = speed(balls.vel, i) * h
    queue, depth, count = listed_balls(balls, bodies, grid, way, h)
    room, pairs = 64 + 8 * count if with_pairs else 0, -1 if with_pairs else 0
    if count == 0:
        room, pairs = 0, 0
    first, second = np.empty(room, np.int64), np.empty(room, np.int64)
    while pairs < 0:
        pairs, count = near_pairs(balls, grid, way, queue, depth, count, first, second)
        if pairs < 0:
            room *= 2
            first, second = np.empty(room, np.int64), np.empty(room, np.int64)
    start, near = near_solids(balls, bodies, solids, way, queue, count, h)
    has_bodies, owner = np.zeros(count, np.uint8), solids.body
    for k in range(count):
        for entry in range(start[k], start[k + 1]):
            if owner[near[entry]] >= 0:
                has_bodies[k] = 1
    listed = Listed(
        queue, count, start, near, has_bodies, np.zeros(count, np.int64), np.empty((_MOST_SURFACES, count, 7)),
        np.empty((_MOST_SURFACES, count, 2), np.int64), np.zeros(count, np.uint8), np.zeros(count), np.zeros(count),
        np.zeros(count, np.int64), np.ones(count, np.int64), np.ones(len(way), np.int64), np.arange(count),
    )  # fmt: skip
    found = Pairs(first, second, pairs, np.zeros(pairs, np.uint8), np.empty(pairs, np.int64))
    mark_stiff_pairs(balls, found, h, step)
    return listed, found


@inner
def drift_balls(balls, listed, h):
    """Advance the positions over h [s] at constant velocity for all listed balls that do not sleep."""
    for q in range(listed.size):
        i = listed.queue[q]
        if not sleeps(balls.status, i):
            for c in range(3):
                balls.pos[i, c] += h * balls.vel[i, c]


@compiled
def advance_balls(balls, memory, solids, bodies, floor, listed, pairs, force, h, ahead):
    """Advance all listed balls by one step, from the middle of the step to the middle of the next step.

    Args:
        balls: All balls, with positions in the middle of the step.
        memory: Contact memory of the balls.
        solids: Solids of the field and of bodies.
        bodies: Records of all bodies, with poses in the middle of the step.
        floor: Properties of the floor, and gravity.
        listed: Balls from `list_contacts`.
        pairs: Pairs from `list_contacts`.
        force: Buffer for the forces of the balls on each other, all 0 before and after, shape (n, 8).
        h: Time step [s].
        ahead: Time from the middle of the step to the middle of the next step, or to the end of the last step [s].
    """
    memory.clock[0] += 1
    stiff = collide(balls, memory, floor.gravity, listed, pairs, pairs.size, force, h, True)
    find_contacts(balls, solids, bodies, floor, listed, 0, listed.size, 0.0, h)
    whole, alone = choose_parts(balls, solids, floor, listed, h)
    integrate(balls, memory, solids, bodies, floor, listed, force, 0, whole, 0.0, h, ahead)
    last = whole
    while last < alone:  # balls with the same number of parts advance together
        first, count = last, listed.parts[listed.order[last]]
        while last < alone and listed.parts[listed.order[last]] == count:
            last += 1
        _advance_in_parts(balls, memory, solids, bodies, floor, listed, pairs, 0, force, first, last, h, ahead)
    if stiff > 0:
        _advance_in_parts(
            balls, memory, solids, bodies, floor, listed, pairs, stiff, force, alone, listed.size, h, ahead
        )


@inner
def end_balls(balls, listed, h):
    """Update the attitude and the time at rest (`Balls.still`) over h [s] for all listed balls that do not sleep.

    A ball is still while the ball is slow and has a contact. The time restarts when the ball gains speed.
    """
    queue, spin, radius, still, vel = listed.queue, balls.spin, balls.radius, balls.still, balls.vel
    for q in range(listed.size):
        i = queue[q]
        if not sleeps(balls.status, i):
            _turn(balls.quat, spin, i, h)
            fast = max(speed(vel, i), speed(spin, i) * radius[i])
            if still[i] == 0.0 or fast > balls.calm[i] + _GAINS:  # a ball that gains speed is not in equilibrium
                balls.calm[i] = fast
                still[i] = 0.0
            still[i] = still[i] + h if balls.contacts[i] > 0 and fast < _QUIET_SPEED else 0.0


@inner
def _turn(quat, spin, i, h):
    """Integrate the attitude of ball i over h [s] at the present spin."""
    x, y, z, s = quat[i, 0], quat[i, 1], quat[i, 2], quat[i, 3]
    a, b, c = 0.5 * h * spin[i, 0], 0.5 * h * spin[i, 1], 0.5 * h * spin[i, 2]
    nx, ny, nz = x + a * s + b * z - c * y, y + b * s + c * x - a * z, z + c * s + a * y - b * x
    ns = s - a * x - b * y - c * z
    scale = 1.0 / math.sqrt(nx * nx + ny * ny + nz * nz + ns * ns)
    quat[i, 0], quat[i, 1], quat[i, 2], quat[i, 3] = nx * scale, ny * scale, nz * scale, ns * scale


@inner
def any_moves(balls, bodies):
    """Return whether any ball is awake or in flight, or whether any body that balls can touch is moving."""
    for i in range(len(balls.status)):
        if balls.is_ball[i] and (balls.status[i] == AWAKE or balls.status[i] == IN_FLIGHT):
            return True
    vel, rate = bodies.vel, bodies.rate
    for b in range(len(bodies)):
        if bodies[b].is_active:
            if bodies[b].model.swings and bodies[b].is_awake:
                return True
            for k in range(3):
                if abs(vel[b, k]) > _STANDING or abs(rate[b, k]) > _STANDING:
                    return True
    return False


@compiled
def depth_at(solids: Solids, x: float, y: float, z: float, radius: float) -> float:
    """Return the largest overlap of a ball at a given position with a solid of the field [m], 0 without overlap."""
    nx, ny = solids.cell_count[0], solids.cell_count[1]
    x0, x1 = cell_range(x - radius, x + radius, solids.cell_low[0], solids.cell_low[2], nx)
    y0, y1 = cell_range(y - radius, y + radius, solids.cell_low[1], solids.cell_low[2], ny)
    least = radius
    for cx in range(x0, x1 + 1):
        for cy in range(y0, y1 + 1):
            for entry in range(solids.cell_first[cx * ny + cy], solids.cell_first[cx * ny + cy + 1]):
                s = solids.cell_solid[entry]
                if not is_outside(solids.box, s, x, y, z, radius):
                    distance, _, _, _, _ = nearest_point(s, x, y, z, radius, solids.first, solids.plane, solids.corner)
                    least = min(least, distance)
    return radius - least
