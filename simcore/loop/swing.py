"""Bodies that swing on a chain or turn about a hinge: gravity, spring, friction, and contacts with floor and field.

A swinging body is rigid and turns about a fixed pivot. A chain has no stiffness against swings, and a torque returns
the body to zero yaw. A hinge leaves one angle free: the moments of inertia about the other axes are infinite.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.loop.body import (
    change_velocity,
    limited_damping,
    limited_stiffness,
    list_near,
    mobility_at,
    place_in_body,
    place_in_field,
    rotate,
    rotate_back,
    turned,
    velocity_at,
    way_off,
)
from simcore.loop.compiled import compiled, inner

__all__ = ["swing", "touch_stops"]

_TWIST_RATE = 3.0  # [rad/s]; estimate: two chain links turn a body back within a second, without overshoot
_MOST_NEAR = 64  # largest number of solids near a body
_MOST_ENDS = 48  # largest number of ends of edges of one solid in another
_SOFTER = 12  # factor on the number of contacts with stops, so that the dampers suppress a bounce
_SLIGHT = 1e-9  # depth at which a clipped edge begins in the surface of a solid [m]
_RIGID = 1e12  # stiffness and damping of stops before the limits for stability [N/m], [N s/m]
_GROUND = np.array([[0.0, 0.0, 1.0, 0.0]])  # plane of the floor


@compiled
def swing(body, gravity, h):
    """Change the angular velocity of a swinging body by all torques but those of contacts, over h [s].

    The torques are gravity, `body.torque`, the spring of a hinge or the yaw torque of a chain, and friction. Spring and
    yaw torque act by implicit Euler steps, which are stable for every stiffness.
    """
    model = body.model
    ax = body.pos[0] - body.com[0]
    ay = body.pos[1] - body.com[1]
    az = body.pos[2] - body.com[2]
    weight = model.mass * gravity
    torque = (body.torque[0] - ay * weight, body.torque[1] + ax * weight, body.torque[2])
    keep = math.exp(-model.drag * h)
    rate = body.rate
    if model.hinge >= 0:
        k = model.hinge
        inertia = model.inertia[k]
        spring = model.spring / inertia
        angle = 2.0 * math.atan2(body.quat[k], body.quat[3])
        about = torque[0] if k == 0 else torque[1]
        rate[k] = keep * (rate[k] + h * (about / inertia - spring * angle)) / (1.0 + spring * h * h)
        return
    quat = body.quat
    push = rotate_back(quat, torque[0], torque[1], torque[2])
    start = rotate_back(quat, rate[0], rate[1], rate[2])
    middle = turned(model.inertia, start, start, push, 0.5 * h)
    ex, ey, ez = turned(model.inertia, start, middle, push, h)
    ex, ey, ez = rotate(quat, ex, ey, ez)
    size = math.sqrt(ax * ax + ay * ay + az * az)
    ax /= -size
    ay /= -size
    az /= -size
    twist = ex * ax + ey * ay + ez * az  # about the line up to the pivot
    yaw = math.atan2(2.0 * (quat[3] * quat[2] + quat[0] * quat[1]), 1.0 - 2.0 * (quat[1] * quat[1] + quat[2] * quat[2]))
    wanted = (twist - _TWIST_RATE * _TWIST_RATE * yaw * h) / ((1.0 + _TWIST_RATE * h) * (1.0 + _TWIST_RATE * h))
    rate[0] = keep * (ex - twist * ax) + wanted * ax
    rate[1] = keep * (ey - twist * ay) + wanted * ay
    rate[2] = keep * (ez - twist * az) + wanted * az


@compiled
def touch_stops(body, solids, has_floor, h):
    """Apply the contact forces of floor and field on a swinging body, without friction.

    The contacts are as stiff as the step allows, and stop the body without a bounce.
    """
    ends = np.empty((_MOST_ENDS, 7))
    near = np.empty(_MOST_NEAR, np.int64)
    far = body.model.reach
    lowest = body.pos[2] - far
    count = list_near(solids, body.pos, far, far, lowest, False, near)
    if count == 0 and not (has_floor and lowest < 0.0):
        return
    for own in range(body.model.first_solid, body.model.last_solid):
        if has_floor and lowest < 0.0:
            n = _clip_edges(body, True, solids, own, _GROUND, 0, 1, ends)
            _press_ends(body, True, _GROUND, 0, 1, ends, n, h)
        for k in range(count):
            s = near[k]
            n = _clip_edges(body, True, solids, own, solids.plane, solids.first[s], solids.first[s + 1], ends)
            _press_ends(body, True, solids.plane, solids.first[s], solids.first[s + 1], ends, n, h)
            n = _clip_edges(body, False, solids, s, solids.plane, solids.first[own], solids.first[own + 1], ends)
            _press_ends(body, False, solids.plane, solids.first[own], solids.first[own + 1], ends, n, h)


@inner
def _clip_edges(body, outward, solids, s, plane, first, last, ends):
    """Clip the edges of a solid to the inside of some planes, and return the number of ends.

    Args:
        body: Record of a swinging body.
        outward: Whether solid and planes are in the body frame and in the field frame, or the other way around.
        solids: Solids of the field and of bodies.
        s: Row of the solid.
        plane: Outward unit normals and distances of planes, shape (t, 4).
        first: Index of the first plane.
        last: Index after the last plane.
        ends: Filled with both ends of each clipped edge, shape (48, 7): position [m], index of the plane that clips the
            edge (-1 for none), and vector along the edge [m], all in the frame of the planes.
    """
    n = 0
    for t in range(solids.first[s], solids.first[s + 1]):
        for e in range(3):
            i = 3 * e
            j = 3 * ((e + 1) % 3)
            ax, ay, az = solids.corner[t, i], solids.corner[t, i + 1], solids.corner[t, i + 2]
            bx, by, bz = solids.corner[t, j], solids.corner[t, j + 1], solids.corner[t, j + 2]
            if ax > bx or (ax == bx and (ay > by or (ay == by and az > bz))):
                continue  # the adjacent triangle has this edge in the opposite direction
            if outward:
                ax, ay, az = place_in_field(body, ax, ay, az)
                bx, by, bz = place_in_field(body, bx, by, bz)
            else:
                ax, ay, az = place_in_body(body, ax, ay, az)
                bx, by, bz = place_in_body(body, bx, by, bz)
            t0, t1, enters, leaves = 0.0, 1.0, -1, -1
            for p in range(first, last):
                over = plane[p, 0] * ax + plane[p, 1] * ay + plane[p, 2] * az - plane[p, 3]
                rise = plane[p, 0] * (bx - ax) + plane[p, 1] * (by - ay) + plane[p, 2] * (bz - az)
                if rise > 0.0 and -over / rise < t1:
                    t1, leaves = -over / rise, p
                elif rise < 0.0 and -over / rise > t0:
                    t0, enters = -over / rise, p
                elif rise == 0.0 and over >= 0.0:
                    t1 = 0.0
                if t0 >= t1:
                    break
            if t0 >= t1 or n + 2 > _MOST_ENDS:
                continue
            for k in range(2):
                part = t0 if k == 0 else t1
                ends[n, 0] = ax + part * (bx - ax)
                ends[n, 1] = ay + part * (by - ay)
                ends[n, 2] = az + part * (bz - az)
                ends[n, 3] = enters if k == 0 else leaves
                ends[n, 4], ends[n, 5], ends[n, 6] = bx - ax, by - ay, bz - az
                n += 1
    return n


@inner
def _press_ends(body, outward, plane, first, last, ends, n, h):
    """Apply the contact forces on a swinging body at the ends of clipped edges.

    The forces act along the normal of the plane with the smallest displacement that moves all ends outside. The
    arguments are those of `_clip_edges`, with the number n of ends.
    """
    if n == 0:
        return
    best = math.inf
    face = first
    for p in range(first, last):
        most = 0.0
        for k in range(n):
            inside = plane[p, 3] - plane[p, 0] * ends[k, 0] - plane[p, 1] * ends[k, 1] - plane[p, 2] * ends[k, 2]
            most = max(most, inside)
        if most < best:
            best = most
            face = p
    ox, oy, oz = plane[face, 0], plane[face, 1], plane[face, 2]
    count = 0
    for k in range(n):
        if plane[face, 3] - ox * ends[k, 0] - oy * ends[k, 1] - oz * ends[k, 2] > _SLIGHT:
            count += 1
    for k in range(n):
        x, y, z = ends[k, 0], ends[k, 1], ends[k, 2]
        depth = plane[face, 3] - ox * x - oy * y - oz * z
        if depth <= _SLIGHT:
            continue
        g = int(ends[k, 3])
        gx, gy, gz = (plane[g, 0], plane[g, 1], plane[g, 2]) if g >= 0 else (0.0, 0.0, 0.0)
        nx, ny, nz, cosine = way_off(ox, oy, oz, gx, gy, gz, ends[k, 4], ends[k, 5], ends[k, 6])
        if not outward:
            nx, ny, nz = rotate(body.quat, -nx, -ny, -nz)
            x, y, z = place_in_field(body, x, y, z)
        ax, ay, az = x - body.com[0], y - body.com[1], z - body.com[2]
        mobility = mobility_at(body, ax, ay, az, nx, ny, nz)
        ux, uy, uz = velocity_at(body, ax, ay, az)
        load = limited_stiffness(_RIGID, mobility, _SOFTER * count, h) * cosine * depth
        load -= limited_damping(_RIGID, mobility, count, h) * (ux * nx + uy * ny + uz * nz)
        if load > 0.0:
            jx, jy, jz = h * load * nx, h * load * ny, h * load * nz  # not in `body.impulse`: a body on stops may sleep
            change_velocity(body, jx, jy, jz, ay * jz - az * jy, az * jx - ax * jz, ax * jy - ay * jx)
