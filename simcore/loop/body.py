"""Rigid bodies: rotation, motion, applied forces, and contacts of robots with field, swinging bodies and robots.

A robot is one rigid body. Each wheel is a soft ball around the axle, and the compression of the ball gives the wheel
load. Small soft balls also represent the corners and sides of bumpers and frame. An edge of a field element inside the
box of bumpers or frame pushes the box away along the normal of the nearest face. These contact forces produce load
transfer, tipping, driving on ramps, falls, a robot on its back, and a robot on top of another robot.

A new contact can be deeper than the closing speed explains, for example when a user places a robot inside another
robot, or when a robot tips beyond the angle at which bumpers collide in plan view. The excess depth (`put_in`, the
initial overlap) gives no force. The loop shifts the robots apart without a change of velocity.

A contact of a robot with a swinging body is as soft as the lighter of the two requires, because a cage has a fraction
of the mass for which the stiffness of wheels and bumpers is chosen; see `limited_stiffness`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from simcore.loop.compiled import compiled, inner
from simcore.loop.neighbours import cell_range, is_outside
from simcore.loop.robot_state import SPRINGS, TOUCHES
from simcore.loop.solids import nearest_point

__all__ = [
    "add_touch",
    "apply_force",
    "apply_impulse",
    "change_velocity",
    "drift",
    "find_spring",
    "kick_and_drift",
    "limited_damping",
    "limited_stiffness",
    "list_near",
    "mobility_at",
    "place_in_body",
    "place_in_field",
    "rotate",
    "rotate_back",
    "touch_each_other",
    "touch_field",
    "touch_swinging",
    "turned",
    "turned_rate",
    "unexplained",
    "update_axes",
    "velocity_at",
    "way_off",
    "way_out",
]

UPRIGHT = math.cos(math.radians(25.0))
"""Cosine of the largest tilt at which bumpers collide in plan view [-]: 16 degrees on a bump, plus a margin."""
_NEAR = 0.005  # largest gap that contact detection computes [m]
_MOST_NEAR = 64  # largest number of solids near a robot
_MOST_ENDS = 24  # largest number of ends of edges in the box of a robot's bumpers or frame
_SLIDES = 0.1  # coefficient of friction of skids and plates under a frame on the field [-]; estimate
_RUBS = 0.4  # coefficient of friction of other parts of a robot on the field and on robots [-]; estimate
_SLACK = 2e-4  # tolerance of the depth that the closing speed explains [m]
_MOST_DAMPING = 0.8  # largest fraction of the speed that dampers remove in a step [-]; above 1 the speed would reverse
_MOST_STIFFNESS = 1.2  # largest stiffness of all contacts with a swinging body, over effective mass and step^2 [-]
_SHARING = 12  # number of contacts with a swinging body among which this stiffness is divided at least
_MOST_HITS = 64  # largest number of contacts of a robot with a swinging body
_OUT_TIME = 0.03  # time constant with which an initial overlap decays [s]
_OUT_SPEED = 0.05  # further speed at which an initial overlap decays [m/s]
_ALONG = 0.5  # stiffness of a robot's contact along the surface, over that along the normal [-]; estimate
_FLOOR = -1
_EDGES, _POINTS = 10**10, 10**12  # first contact key of edges, first contact key of points


@compiled
def rotate(quat: Sequence[float], x: float, y: float, z: float) -> tuple[float, float, float]:
    """Transform a vector from body axes to field axes with an attitude quaternion (x, y, z, w)."""
    a, b, c, w = quat[0], quat[1], quat[2], quat[3]
    tx = 2.0 * (b * z - c * y)
    ty = 2.0 * (c * x - a * z)
    tz = 2.0 * (a * y - b * x)
    return x + w * tx + b * tz - c * ty, y + w * ty + c * tx - a * tz, z + w * tz + a * ty - b * tx


@compiled
def rotate_back(quat, x, y, z):
    """Transform a vector from field axes to body axes with an attitude quaternion (x, y, z, w)."""
    return rotate((-quat[0], -quat[1], -quat[2], quat[3]), x, y, z)


@inner
def place_in_field(body, x, y, z):
    """Transform a position from the body frame to the field frame [m]."""
    x, y, z = rotate(body.quat, x, y, z)
    return x + body.pos[0], y + body.pos[1], z + body.pos[2]


@inner
def place_in_body(body, x, y, z):
    """Transform a position from the field frame to the body frame [m]."""
    return rotate_back(body.quat, x - body.pos[0], y - body.pos[1], z - body.pos[2])


@inner
def update_axes(body):
    """Update the axes and the center of mass (or pivot) of a body from the body's pose."""
    x = body.quat[0]
    y = body.quat[1]
    z = body.quat[2]
    w = body.quat[3]
    axes = body.axes
    axes[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    axes[0, 1] = 2.0 * (x * y - z * w)
    axes[0, 2] = 2.0 * (x * z + y * w)
    axes[1, 0] = 2.0 * (x * y + z * w)
    axes[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    axes[1, 2] = 2.0 * (y * z - x * w)
    axes[2, 0] = 2.0 * (x * z - y * w)
    axes[2, 1] = 2.0 * (y * z + x * w)
    axes[2, 2] = 1.0 - 2.0 * (x * x + y * y)
    center = body.model.center
    for k in range(3):
        if body.model.swings:
            body.com[k] = center[k]
        else:
            body.com[k] = body.pos[k] + axes[k, 0] * center[0] + axes[k, 1] * center[1] + axes[k, 2] * center[2]


@inner
def drift(body, h):
    """Advance the pose of a body by h [s] at constant velocity."""
    ox = body.pos[0] - body.com[0]
    oy = body.pos[1] - body.com[1]
    oz = body.pos[2] - body.com[2]
    ox, oy, oz = rotate_back(body.quat, ox, oy, oz)
    q = body.quat
    a = 0.5 * h * body.rate[0]
    b = 0.5 * h * body.rate[1]
    c = 0.5 * h * body.rate[2]
    x = q[0] + a * q[3] + b * q[2] - c * q[1]
    y = q[1] + b * q[3] + c * q[0] - a * q[2]
    z = q[2] + c * q[3] + a * q[1] - b * q[0]
    w = q[3] - a * q[0] - b * q[1] - c * q[2]
    scale = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    q[0] = x * scale
    q[1] = y * scale
    q[2] = z * scale
    q[3] = w * scale
    for k in range(3):
        body.com[k] += h * body.vel[k]
    ox, oy, oz = rotate(q, ox, oy, oz)
    body.pos[0] = body.com[0] + ox
    body.pos[1] = body.com[1] + oy
    body.pos[2] = body.com[2] + oz
    update_axes(body)


@compiled
def kick_and_drift(bodies, b, vx, vy, vz, wx, wy, wz, h):
    """Add a velocity [m/s, rad/s] to a body, and advance the body's pose over h [s] at the added velocity alone."""
    body = bodies[b]
    kept = (body.vel[0], body.vel[1], body.vel[2], body.rate[0], body.rate[1], body.rate[2])
    update_axes(body)
    for k in range(3):
        body.vel[k] = (vx, vy, vz)[k]
        body.rate[k] = (wx, wy, wz)[k]
    drift(body, h)
    for k in range(3):
        body.vel[k] += kept[k]
        body.rate[k] += kept[3 + k]


@inner
def turned(inertia, rate, during, torque, h):
    """Return an angular velocity after a torque [N m] has acted for h [s] at an angular velocity `during` [rad/s].

    All vectors are in the principal axes with moments `inertia` [kg m^2].
    """
    ix, iy, iz = inertia[0], inertia[1], inertia[2]
    wx, wy, wz = during
    return (
        rate[0] + h * (torque[0] - (iz - iy) * wy * wz) / ix,
        rate[1] + h * (torque[1] - (ix - iz) * wz * wx) / iy,
        rate[2] + h * (torque[2] - (iy - ix) * wx * wy) / iz,
    )


@inner
def turned_rate(body, tx, ty, tz, h):
    """Return a body's angular velocity [rad/s] after a torque [N m] has acted for h [s], both in body axes."""
    rate = rotate_back(body.quat, body.rate[0], body.rate[1], body.rate[2])
    return turned(body.model.inertia, rate, rate, (tx, ty, tz), h)


@inner
def change_velocity(body, jx, jy, jz, ax, ay, az):
    """Change a body's velocity by an impulse [N s] and an angular impulse about the center of mass or pivot [N m s].

    Impulse and angular impulse are in field axes. The impulse does not change the velocity of a body on a pivot.
    """
    model = body.model
    if not model.swings:
        body.vel[0] += jx / model.mass
        body.vel[1] += jy / model.mass
        body.vel[2] += jz / model.mass
    for axis in range(3):
        u, v, w = model.principal[0, axis], model.principal[1, axis], model.principal[2, axis]
        px = body.axes[0, 0] * u + body.axes[0, 1] * v + body.axes[0, 2] * w
        py = body.axes[1, 0] * u + body.axes[1, 1] * v + body.axes[1, 2] * w
        pz = body.axes[2, 0] * u + body.axes[2, 1] * v + body.axes[2, 2] * w
        spin = (px * ax + py * ay + pz * az) / model.inertia[axis]
        body.rate[0] += spin * px
        body.rate[1] += spin * py
        body.rate[2] += spin * pz


@inner
def apply_impulse(body, jx, jy, jz, ax, ay, az):
    """Apply an impulse [N s] to a body at an offset from the center of mass or pivot [m].

    The function adds the impulse and angular impulse to `body.impulse`. The velocity of a robot or swinging body
    changes at once, and a swinging body wakes. The engine changes the velocity of other bodies after the call.
    """
    mx = ay * jz - az * jy
    my = az * jx - ax * jz
    mz = ax * jy - ay * jx
    if body.model.swings:
        body.is_awake = 1
    if body.model.is_robot or body.model.swings:
        change_velocity(body, jx, jy, jz, mx, my, mz)
    body.impulse[0] += jx
    body.impulse[1] += jy
    body.impulse[2] += jz
    body.impulse[3] += mx
    body.impulse[4] += my
    body.impulse[5] += mz


@inner
def apply_force(robot, ax, ay, az, fx, fy, fz):
    """Add a contact force [N], at an offset from the center of mass [m], to a robot's force and torque in this step."""
    robot.press[0] += fx
    robot.press[1] += fy
    robot.press[2] += fz
    robot.twist[0] += ay * fz - az * fy
    robot.twist[1] += az * fx - ax * fz
    robot.twist[2] += ax * fy - ay * fx


@inner
def add_touch(robot, row):
    """Add the row of a body or field element to a robot's list of contacts, if the row is new and the list not full."""
    for k in range(robot.touched):
        if robot.touches[k] == row:
            return
    if robot.touched < TOUCHES:
        robot.touches[robot.touched] = row
        robot.touched += 1


@inner
def find_spring(springs, r, key, stamp):
    """Return the index of a contact in the records of robot r, and whether the contact is new; update the stamp.

    A new contact replaces the record with the oldest stamp, and starts with zero stretch and zero initial overlap.
    """
    oldest = 0
    for k in range(SPRINGS):
        one = springs[r, k]
        if one.key == key and one.stamp >= stamp - 1:
            one.stamp = stamp
            return k, False
        if one.stamp < springs[r, oldest].stamp:
            oldest = k
    one = springs[r, oldest]
    one.key = key
    one.stamp = stamp
    one.stretch[0] = 0.0
    one.stretch[1] = 0.0
    one.stretch[2] = 0.0
    one.put_in = 0.0
    return oldest, True


@inner
def unexplained(depth, closing, h):
    """Return the initial overlap of a new contact: the depth minus `closing` times h and minus a tolerance [m]."""
    return max(0.0, depth - max(0.0, closing) * h - _SLACK)


@inner
def way_out(put_in, h):
    """Return the displacement that reduces an initial overlap in a step of h [s], at most the whole overlap [m]."""
    return min(put_in, (put_in / _OUT_TIME + _OUT_SPEED) * h) if put_in > 0.0 else 0.0


@inner
def _press(robot, r, springs, key, stamp, depth, nx, ny, nz, ax, ay, az, ux, uy, uz, k, c, along, friction, h):
    """Compute the force of a soft contact with a friction spring, and update the record of the contact.

    For walls and other steep surfaces, the function also adds the displacement out of an initial overlap to
    `robot.shift`.

    Args:
        robot: Record of the robot.
        r: Index of the robot.
        springs: Records of all contacts.
        key: Key of the contact.
        stamp: Number of the step.
        depth: Depth of the contact [m].
        nx: x component of the unit normal towards the robot.
        ny: y component of the unit normal.
        nz: z component of the unit normal.
        ax: x offset of the contact from the robot's center of mass [m].
        ay: y offset of the contact [m].
        az: z offset of the contact [m].
        ux: x component of the robot's velocity at the contact, relative to the other body [m/s].
        uy: y component of the relative velocity [m/s].
        uz: z component of the relative velocity [m/s].
        k: Normal stiffness [N/m].
        c: Normal damping [N s/m].
        along: Stiffness and damping along the surface, over those along the normal [-].
        friction: Coefficient of friction [-].
        h: Time step [s].

    Returns:
        Normal force [N], and total force in field axes [N]; all 0 for a contact that would pull.
    """
    out = ux * nx + uy * ny + uz * nz
    slot, is_new = find_spring(springs, r, key, stamp)
    spring = springs[r, slot]
    if is_new or robot.is_put:
        spring.put_in = unexplained(depth, -out, h)
    spring.put_in = min(spring.put_in, depth)
    if spring.put_in > 0.0 and abs(nz) < 0.7:  # no vertical shift: the robot's weight acts there
        way = way_out(spring.put_in, h)
        robot.shift[0] += way * nx
        robot.shift[1] += way * ny
    load = k * (depth - spring.put_in) - c * out
    if load <= 0.0:
        spring.stretch[0] = 0.0
        spring.stretch[1] = 0.0
        spring.stretch[2] = 0.0
        return 0.0, 0.0, 0.0, 0.0
    ux -= out * nx
    uy -= out * ny
    uz -= out * nz
    x = spring.stretch[0] + ux * h
    y = spring.stretch[1] + uy * h
    z = spring.stretch[2] + uz * h
    out = x * nx + y * ny + z * nz  # the normal may have turned since the last step
    x -= out * nx
    y -= out * ny
    z -= out * nz
    stiffness = along * k
    damping = along * c
    fx = -stiffness * x - damping * ux
    fy = -stiffness * y - damping * uy
    fz = -stiffness * z - damping * uz
    size = math.sqrt(fx * fx + fy * fy + fz * fz)
    if size > friction * load:  # the contact slips
        share = friction * load / size
        fx *= share
        fy *= share
        fz *= share
        x = -(fx + damping * ux) / stiffness
        y = -(fy + damping * uy) / stiffness
        z = -(fz + damping * uz) / stiffness
        longest = friction * load / stiffness
        size = math.sqrt(x * x + y * y + z * z)
        if size > longest:
            x *= longest / size
            y *= longest / size
            z *= longest / size
    spring.stretch[0] = x
    spring.stretch[1] = y
    spring.stretch[2] = z
    return load, fx + load * nx, fy + load * ny, fz + load * nz


@compiled
def velocity_at(body, ax, ay, az):
    """Return the velocity of a body at an offset from the center of mass or pivot, field axes [m/s]."""
    vel = body.vel
    rate = body.rate
    return (
        vel[0] + rate[1] * az - rate[2] * ay,
        vel[1] + rate[2] * ax - rate[0] * az,
        vel[2] + rate[0] * ay - rate[1] * ax,
    )


@compiled
def mobility_at(body, ax, ay, az, nx, ny, nz):
    """Return the inverse effective mass of a body along a unit vector [1/kg], at an offset [m].

    The offset is that from the center of mass or pivot.
    """
    x, y, z = rotate_back(body.quat, ay * nz - az * ny, az * nx - ax * nz, ax * ny - ay * nx)
    inertia = body.model.inertia
    turning = x * x / inertia[0] + y * y / inertia[1] + z * z / inertia[2]
    return turning if body.model.swings else 1.0 / body.model.mass + turning


@inner
def _largest_mobility(body, ax, ay, az):
    """Return an upper bound of the inverse effective mass at an offset from the center of mass or pivot [1/kg].

    The bound holds for all directions: it is the trace of the rotational part, plus the inverse mass if there is no
    pivot.
    """
    x, y, z = rotate_back(body.quat, ax, ay, az)
    inertia = body.model.inertia
    turning = (y * y + z * z) / inertia[0] + (z * z + x * x) / inertia[1] + (x * x + y * y) / inertia[2]
    return turning if body.model.swings else turning + 1.0 / body.model.mass


@inner
def _approach(body, other, ax, ay, az):
    """Return the offset of a point from another body's center of mass or pivot [m], and the relative velocity [m/s].

    The point is at an offset [m] from the first body's center of mass, and the velocity is that of the first body.
    """
    cx = ax + body.com[0] - other.com[0]
    cy = ay + body.com[1] - other.com[1]
    cz = az + body.com[2] - other.com[2]
    ux, uy, uz = velocity_at(body, ax, ay, az)
    vx, vy, vz = velocity_at(other, cx, cy, cz)
    return cx, cy, cz, ux - vx, uy - vy, uz - vz


@inner
def limited_stiffness(stiffness, mobility, count, h):
    """Return the stiffness of one of `count` simultaneous contacts with a swinging body, limited for stability [N/m].

    Contacts with stiffness k and damping c are stable in steps of h [s] if the sum of k h^2 / m + 2 c h / m, with the
    effective mass m of each contact, is below 4. The second terms add up to 2 `_MOST_DAMPING` at most.
    """
    return min(stiffness, _MOST_STIFFNESS / (mobility * count * h * h))


@inner
def limited_damping(damping, mobility, count, h):
    """Return the damping of one of `count` simultaneous contacts, limited for stability [N s/m].

    In a step of h [s] each damper removes at most the fraction `_MOST_DAMPING / count` of the speed at the contact. All
    dampers together therefore never reverse the velocity, at any position of the contacts.
    """
    return min(damping, _MOST_DAMPING / (mobility * count * h))


@inner
def _add_load(point, load, nx, ny, nz, ax, ay, az):
    """Add the load [N] of a contact to a point, and update the load-weighted means of normal and arm."""
    share = load / (point.load + load)
    point.normal[0] += share * (nx - point.normal[0])
    point.normal[1] += share * (ny - point.normal[1])
    point.normal[2] += share * (nz - point.normal[2])
    point.arm[0] += share * (ax - point.arm[0])
    point.arm[1] += share * (ay - point.arm[1])
    point.arm[2] += share * (az - point.arm[2])
    point.load += load


@inner
def _note_hit(hits, n, i, what, depth, nx, ny, nz, ax, ay, az):
    """Store a contact in row n of `hits`.

    The row contains the index of the point, the index of the touched object, the depth [m], the unit normal, and the
    offset of the point from the center of mass [m]. For edges, the first two are the index of the part and the contact
    key, the offset is that of the contact, and a tenth entry is the coefficient of friction.
    """
    hit = hits[n]
    hit[0] = i
    hit[1] = what
    hit[2] = depth
    hit[3] = nx
    hit[4] = ny
    hit[5] = nz
    hit[6] = ax
    hit[7] = ay
    hit[8] = az


@inner
def _press_point(fleet, r, body, i, what, depth, nx, ny, nz, ax, ay, az, count, h):
    """Apply the contact force of the field on one wheel or other contact point of a robot.

    `count` is the number of simultaneous contacts of points other than wheels.
    """
    robot = fleet.robots[r]
    point = fleet.points[i]
    model = point.model
    ax -= (model.radius - depth) * nx
    ay -= (model.radius - depth) * ny
    az -= (model.radius - depth) * nz
    ux, uy, uz = velocity_at(body, ax, ay, az)
    if model.is_wheel:  # the tire model computes the friction of wheels
        load = model.stiffness * depth - model.damping * (ux * nx + uy * ny + uz * nz)
        if load > 0.0:
            apply_force(robot, ax, ay, az, load * nx, load * ny, load * nz)
            _add_load(point, load, nx, ny, nz, ax, ay, az)
        return
    damping = limited_damping(model.damping, mobility_at(body, ax, ay, az, nx, ny, nz), count, h)
    _, fx, fy, fz = _press(
        robot, r, fleet.springs, _POINTS + (i - robot.model.first_point) * 100000 + what, fleet.clock[0], depth,
        nx, ny, nz, ax, ay, az, ux, uy, uz, model.stiffness, damping, _ALONG, _RUBS, h,
    )  # fmt: skip
    apply_force(robot, ax, ay, az, fx, fy, fz)


# --- edges of the field in the box of a robot's bumpers or frame ------------------------------------------------------


@compiled
def _clip(ax, ay, az, bx, by, bz, half, ends, n):
    """Clip an edge to a box around the origin, append the two ends to `ends`, and return the new number of ends.

    The row of an end contains the position [m], the axis of the face of the box that clips the edge (-1 for none), and
    the vector along the whole edge [m]. An edge outside the box adds no ends.
    """
    t0 = 0.0
    t1 = 1.0
    enters = -1
    leaves = -1
    for axis in range(3):
        a = ax if axis == 0 else ay if axis == 1 else az
        d = (bx if axis == 0 else by if axis == 1 else bz) - a
        for sign in (-1.0, 1.0):
            over = sign * a - half[axis]
            rise = sign * d
            if rise == 0.0:
                if over >= 0.0:
                    return n
            elif rise > 0.0:
                if -over / rise < t1:
                    t1 = -over / rise
                    leaves = axis
            elif -over / rise > t0:
                t0 = -over / rise
                enters = axis
    if t0 >= t1 or n + 2 > _MOST_ENDS:
        return n
    for k in range(2):
        t = t0 if k == 0 else t1
        ends[n, 0] = ax + t * (bx - ax)
        ends[n, 1] = ay + t * (by - ay)
        ends[n, 2] = az + t * (bz - az)
        ends[n, 3] = enters if k == 0 else leaves
        ends[n, 4] = bx - ax
        ends[n, 5] = by - ay
        ends[n, 6] = bz - az
        n += 1
    return n


@inner
def way_off(fx, fy, fz, gx, gy, gz, ex, ey, ez):
    """Return the unit normal of a solid's contact with an end of a clipped edge, and the cosine to the face normal.

    At an end of the edge itself, the normal is that of the face, f. Where another face with the normal g clips the
    edge, an edge of the solid along f x g touches the edge, and the normal e x (f x g) is perpendicular to both. With
    the normal of the face, an inclined edge that slides along the solid would gain energy.

    Args:
        fx: x component of the unit normal of the face.
        fy: y component.
        fz: z component.
        gx: x component of the unit normal of the face that clips the edge, 0 at an end of the edge itself.
        gy: y component.
        gz: z component.
        ex: x component of a vector along the edge.
        ey: y component.
        ez: z component.
    """
    f = ex * fx + ey * fy + ez * fz
    g = ex * gx + ey * gy + ez * gz
    x = g * fx - f * gx
    y = g * fy - f * gy
    z = g * fz - f * gz
    size = math.sqrt(x * x + y * y + z * z)
    cosine = x * fx + y * fy + z * fz
    if size < 1e-9 * (abs(f) + abs(g)) or size == 0.0:
        return fx, fy, fz, 1.0
    if cosine < 0.0:
        size = -size
    return x / size, y / size, z / size, cosine / size


@inner
def _find_edges(fleet, r, bodies, p, solids, s, ends, keys, hits, first):
    """Find the contacts of the edges of a solid of the field, or of a swinging body, with the box of bumpers or frame.

    The contacts have the normal of the face with the smallest displacement that moves the box off all edges; those with
    a swinging body have the normal of `way_off`. The function stores the contacts in `hits`, see `_note_hit`, from row
    `first` on, and returns the index after the last one.
    """
    robot = fleet.robots[r]
    body = bodies[robot.model.body]
    owner = solids.body[s]
    other = bodies[owner]  # if any
    part = fleet.parts[p].model
    middle = 0.5 * (part.bottom + part.top)
    half = (part.half_length, part.half_width, 0.5 * (part.top - part.bottom))
    quat = body.quat
    far = half[0] + half[1] + half[2]
    n = 0
    corner = solids.corner
    for t in range(solids.first[s], solids.first[s + 1]):
        for e in range(3):
            i = 3 * e
            j = 3 * ((e + 1) % 3)
            ax = corner[t, i]
            ay = corner[t, i + 1]
            az = corner[t, i + 2]
            bx = corner[t, j]
            by = corner[t, j + 1]
            bz = corner[t, j + 2]
            if ax > bx or (ax == bx and (ay > by or (ay == by and az > bz))):
                continue  # the adjacent triangle has this edge in the opposite direction
            if owner >= 0:
                ax, ay, az = place_in_field(other, ax, ay, az)
                bx, by, bz = place_in_field(other, bx, by, bz)
            cx = body.com[0]
            cy = body.com[1]
            cz = body.com[2]
            if (
                min(ax, bx) > cx + far or max(ax, bx) < cx - far or min(ay, by) > cy + far or max(ay, by) < cy - far
                or min(az, bz) > cz + far or max(az, bz) < cz - far
            ):  # fmt: skip
                continue
            ax, ay, az = place_in_body(body, ax, ay, az)
            bx, by, bz = place_in_body(body, bx, by, bz)
            before = n
            n = _clip(ax - part.x, ay - part.y, az - middle, bx - part.x, by - part.y, bz - middle, half, ends, n)
            for k in range(before, n):
                keys[k] = _EDGES + ((p - robot.model.first_part) * 1000000 + 3 * t + e) * 2 + k - before
    if n == 0 or first + n > len(hits):
        return first
    best = math.inf
    face = 0
    for axis in range(3):
        for sign in (-1.0, 1.0):
            most = 0.0
            for k in range(n):
                most = max(most, half[axis] - sign * ends[k, axis])
            if most < best:
                best = most
                face = 2 * axis + (1 if sign > 0.0 else 0)
    axis = face // 2
    sign = 1.0 if face % 2 else -1.0
    center = body.model.center
    for k in range(n):
        ax, ay, az = rotate(
            quat, ends[k, 0] + part.x - center[0], ends[k, 1] + part.y - center[1], ends[k, 2] + middle - center[2]
        )  # fmt: skip
        fx, fy, fz = (sign if axis == 0 else 0.0, sign if axis == 1 else 0.0, sign if axis == 2 else 0.0)
        nx, ny, nz, cosine = fx, fy, fz, 1.0
        if owner >= 0:  # in a solid of the field, this normal would hold a robot at the foot of a bump
            clips = int(ends[k, 3])
            gx, gy, gz = (1.0 if clips == 0 else 0.0, 1.0 if clips == 1 else 0.0, 1.0 if clips == 2 else 0.0)
            nx, ny, nz, cosine = way_off(fx, fy, fz, gx, gy, gz, ends[k, 4], ends[k, 5], ends[k, 6])
        nx, ny, nz = rotate(quat, -nx, -ny, -nz)  # the robot moves away from the edge
        depth = cosine * (half[axis] - sign * ends[k, axis])
        _note_hit(hits, first + k, p, keys[k], depth, nx, ny, nz, ax, ay, az)
        hits[first + k, 9] = _SLIDES if face == 4 else _RUBS
    return first + n


@inner
def _press_edges(fleet, r, body, hits, n, row, h):
    """Apply the forces of the first n contacts of field edges in `hits` on a robot; `row` is that of the element."""
    robot = fleet.robots[r]
    for k in range(n):
        nx, ny, nz = hits[k, 3], hits[k, 4], hits[k, 5]
        ax, ay, az = hits[k, 6], hits[k, 7], hits[k, 8]
        part = fleet.parts[int(hits[k, 0])].model
        ux, uy, uz = velocity_at(body, ax, ay, az)
        damping = limited_damping(part.edge_damping, mobility_at(body, ax, ay, az, nx, ny, nz), n, h)
        load, fx, fy, fz = _press(
            robot, r, fleet.springs, int(hits[k, 1]), fleet.clock[0], hits[k, 2], nx, ny, nz, ax, ay, az, ux, uy, uz,
            part.edge_stiffness, damping, _ALONG, hits[k, 9], h,
        )  # fmt: skip
        if load > 0.0:
            apply_force(robot, ax, ay, az, fx, fy, fz)
            add_touch(robot, row)


@inner
def list_near(solids, place, wide, far, lowest, without_plan, near):
    """List the solids of the field near a point, and return their number.

    Args:
        solids: Solids of the field and of bodies.
        place: Point, field frame [m].
        wide: Horizontal distance of the grid cells to search [m].
        far: Distance between the point and the bounding box of a near solid [m].
        lowest: Height that a near solid reaches [m].
        without_plan: Whether to omit solids with which bumpers collide in plan view.
        near: Filled with the rows of the solids, shape (64,).
    """
    low = solids.cell_low
    nx_cells = solids.cell_count[0]
    ny_cells = solids.cell_count[1]
    count = 0
    x0, x1 = cell_range(place[0] - wide, place[0] + wide, low[0], low[2], nx_cells)
    y0, y1 = cell_range(place[1] - wide, place[1] + wide, low[1], low[2], ny_cells)
    for cx in range(x0, x1 + 1):
        for cy in range(y0, y1 + 1):
            cell = cx * ny_cells + cy
            for e in range(solids.cell_first[cell], solids.cell_first[cell + 1]):
                s = solids.cell_solid[e]
                if solids.is_in_plan[s] and without_plan:
                    continue
                if solids.box[s, 5] < lowest:
                    continue
                if is_outside(solids.box, s, place[0], place[1], place[2], far):
                    continue
                known = False
                for k in range(count):
                    known = known or near[k] == s
                if not known and count < _MOST_NEAR:
                    near[count] = s
                    count += 1
    return count


@compiled
def touch_field(fleet, r, bodies, solids, has_floor, h):
    """Apply the contact forces of floor and field on the wheels, bumpers and frame of a robot.

    The function also updates the robot's contact points and adds touched field elements to the robot's list of
    contacts.

    Args:
        fleet: All robots.
        r: Index of the robot.
        bodies: Records of all bodies.
        solids: Solids of the field and of bodies.
        has_floor: Whether there is a floor at z = 0.
        h: Time step [s].
    """
    robot = fleet.robots[r]
    model = robot.model
    body = bodies[model.body]
    up = body.axes[2, 2]
    sine = math.sqrt(max(0.0, 1.0 - up * up))
    # lower bounds of the height of bumpers and frame, and of the whole robot
    lowest = body.pos[2] + min(model.low * up, model.high * up) - model.reach * sine
    soles = min(lowest, body.pos[2] - model.reach * sine) - 2.0 * _NEAR
    near = np.empty(_MOST_NEAR, np.int64)
    count = list_near(solids, body.com, model.reach, body.model.reach, soles, robot.is_upright, near)
    if count > 0:
        ends = np.empty((_MOST_ENDS, 7))
        keys = np.empty(_MOST_ENDS, np.int64)
        found = np.empty((_MOST_ENDS, 10))
        for k in range(count):
            if solids.box[near[k], 5] > lowest:
                for p in range(model.first_part, model.last_part):
                    n = _find_edges(fleet, r, bodies, p, solids, near[k], ends, keys, found, 0)
                    _press_edges(fleet, r, body, found, n, solids.row[near[k]], h)
    is_low = count > 0 or (has_floor and lowest < 0.0)
    hits = np.empty((2 * (model.last_point - model.first_point), 9))
    center = body.model.center
    n = 0
    points = 0  # number of contacts of points other than wheels
    for i in range(model.first_point, model.last_point):
        point = fleet.points[i]
        sphere = point.model
        point.load = 0.0
        point.on = -1
        for k in range(3):
            point.normal[k] = 0.0
            point.arm[k] = 0.0
        if not (sphere.is_wheel or is_low):
            continue
        radius = sphere.radius
        ax, ay, az = rotate(body.quat, sphere.x - center[0], sphere.y - center[1], sphere.z - center[2])
        x = body.com[0] + ax
        y = body.com[1] + ay
        z = body.com[2] + az
        point.gap = z - radius if has_floor else _NEAR
        before = n
        if has_floor and z < radius:
            _note_hit(hits, n, i, _FLOOR, radius - z, 0.0, 0.0, 1.0, ax, ay, az)
            n += 1
        best = 0.0
        solid = 0
        bx = 0.0
        by = 0.0
        bz = 1.0
        for k in range(count):
            s = near[k]
            if is_outside(solids.box, s, x, y, z, radius + _NEAR):
                continue
            d, nx, ny, nz, _ = nearest_point(s, x, y, z, radius + _NEAR, solids.first, solids.plane, solids.corner)
            point.gap = min(point.gap, d - radius)
            if radius - d > best:
                best = radius - d
                solid = s
                bx = nx
                by = ny
                bz = nz
        if best > 0.0:
            _note_hit(hits, n, i, solid, best, bx, by, bz, ax, ay, az)
            n += 1
            add_touch(robot, solids.row[solid])
        if not sphere.is_wheel:
            points += n - before
    for k in range(n):
        i = int(hits[k, 0])
        what = int(hits[k, 1])
        _press_point(
            fleet, r, body, i, what, hits[k, 2], hits[k, 3], hits[k, 4], hits[k, 5], hits[k, 6], hits[k, 7], hits[k, 8],
            points, h,
        )  # fmt: skip


@compiled
def touch_swinging(fleet, r, bodies, solids, h):
    """Apply the contact forces between a robot and swinging bodies, for example cages, and seesaws with robots on them.

    Wheels and points of the robot touch the solids of the bodies, and edges of these solids touch bumpers and frame.
    The function also updates the robot's contact points and list of contacts. `touch_field` must run first.
    """
    model = fleet.robots[r].model
    body = bodies[model.body]
    for b in range(len(bodies)):
        other = bodies[b]
        if not other.model.swings:
            continue
        dx = body.com[0] - other.pos[0]
        dy = body.com[1] - other.pos[1]
        dz = body.com[2] - other.pos[2]
        far = body.model.reach + other.model.reach
        if dx * dx + dy * dy + dz * dz > far * far:
            continue
        ends = np.empty((_MOST_ENDS, 7))
        keys = np.empty(_MOST_ENDS, np.int64)
        hits = np.empty((_MOST_HITS, 10))
        edges = 0
        for s in range(other.model.first_solid, other.model.last_solid):
            for p in range(model.first_part, model.last_part):
                edges = _find_edges(fleet, r, bodies, p, solids, s, ends, keys, hits, edges)
        n = edges
        for s in range(other.model.first_solid, other.model.last_solid):
            for i in range(model.first_point, model.last_point):
                n = _find_point(fleet.points[i], body, other, solids, s, i, hits, n)
        for k in range(n):
            _press_swinging(fleet, r, body, other, b, hits, k, k < edges, n, h)


@inner
def _find_point(point, body, other, solids, s, i, hits, n):
    """Find the contact of a robot's wheel or other contact point with a solid of a swinging body.

    The function stores the contact in row n of `hits`, see `_note_hit`, and returns the index after the last contact.
    """
    sphere = point.model
    radius = sphere.radius
    center = body.model.center
    ax, ay, az = rotate(body.quat, sphere.x - center[0], sphere.y - center[1], sphere.z - center[2])
    x, y, z = place_in_body(other, body.com[0] + ax, body.com[1] + ay, body.com[2] + az)
    if is_outside(solids.box, s, x, y, z, radius + _NEAR):
        return n
    d, nx, ny, nz, _ = nearest_point(s, x, y, z, radius + _NEAR, solids.first, solids.plane, solids.corner)
    if other.model.carries:
        point.gap = min(point.gap, d - radius)
    if d >= radius or n == len(hits):
        return n
    nx, ny, nz = rotate(other.quat, nx, ny, nz)
    _note_hit(hits, n, i, s, radius - d, nx, ny, nz, ax - d * nx, ay - d * ny, az - d * nz)
    return n + 1


@inner
def _press_swinging(fleet, r, body, other, b, hits, k, is_edge, count, h):
    """Apply the force of contact k in `hits`, one of `count` contacts, between a robot and a swinging body."""
    robot = fleet.robots[r]
    nx, ny, nz = hits[k, 3], hits[k, 4], hits[k, 5]
    ax, ay, az = hits[k, 6], hits[k, 7], hits[k, 8]
    cx, cy, cz, ux, uy, uz = _approach(body, other, ax, ay, az)
    mobility = mobility_at(body, ax, ay, az, nx, ny, nz) + mobility_at(other, cx, cy, cz, nx, ny, nz)
    along = _ALONG * mobility / (_largest_mobility(body, ax, ay, az) + _largest_mobility(other, cx, cy, cz))
    if is_edge:
        part = fleet.parts[int(hits[k, 0])].model
        key = int(hits[k, 1])
        stiffness = part.edge_stiffness
        damping = part.edge_damping
        friction = hits[k, 9]
    else:
        point = fleet.points[int(hits[k, 0])]
        key = _POINTS + (int(hits[k, 0]) - robot.model.first_point) * 100000 + int(hits[k, 1])
        stiffness = point.model.stiffness
        damping = point.model.damping
        friction = 0.0 if point.model.is_wheel and other.model.carries else _RUBS
    stiffness = limited_stiffness(stiffness, mobility, max(count, _SHARING), h)
    damping = limited_damping(damping, mobility, count, h)
    if not is_edge and friction == 0.0:  # the tire model computes the friction of wheels
        load = stiffness * hits[k, 2] - damping * (ux * nx + uy * ny + uz * nz)
        fx, fy, fz = load * nx, load * ny, load * nz
        if load > 0.0:
            point = fleet.points[int(hits[k, 0])]
            point.on = b
            _add_load(point, load, nx, ny, nz, ax, ay, az)
    else:
        load, fx, fy, fz = _press(
            robot, r, fleet.springs, key, fleet.clock[0], hits[k, 2], nx, ny, nz, ax, ay, az, ux, uy, uz, stiffness,
            damping, along, friction, h,
        )  # fmt: skip
    if load > 0.0:
        apply_force(robot, ax, ay, az, fx, fy, fz)
        apply_impulse(other, -h * fx, -h * fy, -h * fz, cx, cy, cz)
        add_touch(robot, other.model.row)


# --- robots that lie on the floor or on another robot -----------------------------------------------------------------


@inner
def _box_gap(part, x, y, z):
    """Return the distance of a point from a box of bumpers or frame [m], and the outward unit normal.

    The distance is negative inside the box. Point and normal are in the frame of the robot with this box.
    """
    model = part.model
    middle = 0.5 * (model.bottom + model.top)
    half = (model.half_length, model.half_width, 0.5 * (model.top - model.bottom))
    at = (x - model.x, y - model.y, z - middle)
    dx = at[0] - max(-half[0], min(half[0], at[0]))
    dy = at[1] - max(-half[1], min(half[1], at[1]))
    dz = at[2] - max(-half[2], min(half[2], at[2]))
    size = math.sqrt(dx * dx + dy * dy + dz * dz)
    if size > 0.0:
        return size, dx / size, dy / size, dz / size
    best = -math.inf
    axis = 0
    for k in range(3):
        over = abs(at[k]) - half[k]
        if over > best:
            best = over
            axis = k
    sign = 1.0 if at[axis] >= 0.0 else -1.0
    return best, sign if axis == 0 else 0.0, sign if axis == 1 else 0.0, sign if axis == 2 else 0.0


@compiled
def _press_into(fleet, r, q, body, other, h):
    """Apply the contact forces between the contact points of robot r and the bumpers and frame of robot q."""
    robot = fleet.robots[r]
    beneath = fleet.robots[q]
    center = body.model.center
    quat = other.quat
    hits = np.empty((robot.model.last_point - robot.model.first_point, 9))
    n = 0
    for i in range(robot.model.first_point, robot.model.last_point):
        point = fleet.points[i].model
        ax, ay, az = rotate(body.quat, point.x - center[0], point.y - center[1], point.z - center[2])
        x, y, z = place_in_body(other, body.com[0] + ax, body.com[1] + ay, body.com[2] + az)
        best = 0.0
        bx = 0.0
        by = 0.0
        bz = 1.0
        for p in range(beneath.model.first_part, beneath.model.last_part):
            d, nx, ny, nz = _box_gap(fleet.parts[p], x, y, z)
            if point.radius - d > best:
                best = point.radius - d
                bx = nx
                by = ny
                bz = nz
        if best > 0.0:
            nx, ny, nz = rotate(quat, bx, by, bz)
            _note_hit(hits, n, i, q, best, nx, ny, nz, ax, ay, az)
            n += 1
    for k in range(n):
        i = int(hits[k, 0])
        depth = hits[k, 2]
        nx, ny, nz = hits[k, 3], hits[k, 4], hits[k, 5]
        point = fleet.points[i].model
        ax = hits[k, 6] - (point.radius - depth) * nx
        ay = hits[k, 7] - (point.radius - depth) * ny
        az = hits[k, 8] - (point.radius - depth) * nz
        cx, cy, cz, ux, uy, uz = _approach(body, other, ax, ay, az)
        mobility = mobility_at(body, ax, ay, az, nx, ny, nz) + mobility_at(other, cx, cy, cz, nx, ny, nz)
        load, fx, fy, fz = _press(
            robot, r, fleet.springs, -_POINTS - (i - robot.model.first_point) * 1000 - q, fleet.clock[0], depth,
            nx, ny, nz, ax, ay, az, ux, uy, uz, point.stiffness,
            limited_damping(point.damping, mobility, n, h), _ALONG, _RUBS, h,
        )  # fmt: skip
        if load > 0.0:
            apply_force(robot, ax, ay, az, fx, fy, fz)
            apply_force(beneath, cx, cy, cz, -fx, -fy, -fz)
            add_touch(robot, other.model.row)
            add_touch(beneath, body.model.row)


@compiled
def touch_each_other(fleet, r, q, bodies, h):
    """Apply the contact forces between two robots that do not collide in plan view: tipped, or one above the other."""
    body = bodies[fleet.robots[r].model.body]
    other = bodies[fleet.robots[q].model.body]
    _press_into(fleet, r, q, body, other, h)
    _press_into(fleet, q, r, other, body, h)
