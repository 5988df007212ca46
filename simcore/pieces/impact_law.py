"""Impacts of solid balls: what velocities and spins become, by Newton's restitution and Coulomb's friction.

With the normal impulse `J = (1 + e) m |v_n|` the friction impulse is the smaller of `mu J` and the one that ends the
slip of the touching points; that one sees the mass `2/7 m`, because a solid ball (inertia `2/5 m r^2`) also turns.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.rotation import Vector
from simcore.typing import FloatArray

__all__ = ["hit_ball", "hit_surface", "touch_normal"]


def hit_surface(
    velocity: Vector,
    spin: Vector,
    normal: Vector,
    *,
    radius: float,
    restitution: float,
    friction: float,
    surface_velocity: Vector = (0.0, 0.0, 0.0),
    mass_ratio: float = 0.0,
) -> tuple[Vector, Vector]:
    """Velocity and spin of a ball after it hit something that is fixed, or moves and gives way.

    Args:
        velocity: Of its center before [m/s].
        spin: Angular velocity before [rad/s].
        normal: Unit normal of the surface, toward the ball.
        radius: Of the ball [m].
        restitution: Of the pair [-].
        friction: Of the pair [-].
        surface_velocity: Of the other body where it is touched, before [m/s].
        mass_ratio: Mass of the ball over the effective mass of the other body there; 0: it is fixed [-].

    Example:
        >>> hit_surface((0.0, 0.0, -2.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), radius=0.1, restitution=0.5, friction=1.0)
        ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    """
    nx, ny, nz = normal
    vx, vy, vz = velocity
    relative = (vx - surface_velocity[0], vy - surface_velocity[1], vz - surface_velocity[2])
    approach = -_dot(relative, normal)
    slip = _slip(relative, spin, normal, radius, approach)
    size = math.sqrt(_dot(slip, slip))
    out = (1.0 + restitution) * approach / (1.0 + mass_ratio)
    share = min(friction * out / size, 1.0 / (3.5 + mass_ratio)) if size > 0.0 else 0.0
    jx, jy, jz = -share * slip[0], -share * slip[1], -share * slip[2]  # friction impulse over the mass
    turn = -2.5 / radius  # 1 / (2/5 r), and the lever is -normal r
    sx, sy, sz = spin
    return (
        (vx + out * nx + jx, vy + out * ny + jy, vz + out * nz + jz),
        (sx + turn * (ny * jz - nz * jy), sy + turn * (nz * jx - nx * jz), sz + turn * (nx * jy - ny * jx)),
    )


def hit_ball(
    velocities: tuple[Vector, Vector],
    spins: tuple[Vector, Vector],
    normal: Vector,
    *,
    radii: tuple[float, float],
    masses: tuple[float, float],
    restitution: float,
    friction: float,
) -> tuple[tuple[Vector, Vector], tuple[Vector, Vector]]:
    """Velocities and spins of two balls after they hit each other.

    Args:
        velocities: Of the centers before [m/s].
        spins: Angular velocities before [rad/s].
        normal: Unit vector from the second center to the first.
        radii: [m]
        masses: [kg]
        restitution: Of the pair [-].
        friction: Of the pair [-].
    """
    (va, vb), (wa, wb) = velocities, spins
    relative = (va[0] - vb[0], va[1] - vb[1], va[2] - vb[2])
    turning = tuple(radii[0] * a + radii[1] * b for a, b in zip(wa, wb, strict=True))
    approach = -_dot(relative, normal)
    slip = _slip(relative, (turning[0], turning[1], turning[2]), normal, 1.0, approach)
    size = math.sqrt(_dot(slip, slip))
    share = min(friction * (1.0 + restitution) * approach / size, 2.0 / 7.0) if size > 0.0 else 0.0
    reduced = masses[0] * masses[1] / (masses[0] + masses[1])
    out = (1.0 + restitution) * approach
    push = [reduced * (out * n - share * s) for n, s in zip(normal, slip, strict=True)]
    rub = [-reduced * share * s for s in slip]
    new_v, new_w = [], []
    for sign, mass, radius, v, w in zip((1.0, -1.0), masses, radii, velocities, spins, strict=True):
        new_v.append((v[0] + sign * push[0] / mass, v[1] + sign * push[1] / mass, v[2] + sign * push[2] / mass))
        turn = -2.5 / (mass * radius)  # both touch with -normal r for the first, +normal r for the second
        new_w.append(
            (
                w[0] + turn * (normal[1] * rub[2] - normal[2] * rub[1]),
                w[1] + turn * (normal[2] * rub[0] - normal[0] * rub[2]),
                w[2] + turn * (normal[0] * rub[1] - normal[1] * rub[0]),
            )
        )
    return (new_v[0], new_v[1]), (new_w[0], new_w[1])


def touch_normal(ahead: Vector, away: FloatArray, reach: float) -> Vector:
    """Unit normal from a ball toward another that comes along a line, where they first touch.

    Args:
        ahead: Unit vector of the line, the way that the other one comes.
        away: From a point of the line to the ball [m], shape (3,); the ball is within `reach` of the line.
        reach: Distance of the centers as they touch [m].

    Example:
        >>> touch_normal((1.0, 0.0, 0.0), np.array([0.2, 0.6, 0.0]), 1.0)
        (-0.8, -0.6, -0.0)
    """
    beside = away - np.dot(away, ahead) * np.array(ahead)
    along = math.sqrt(max(0.0, reach * reach - float(beside @ beside)))
    x, y, z = (-(beside + along * np.array(ahead)) / reach).tolist()
    return x, y, z


def _slip(velocity: Vector, spin: Vector, normal: Vector, radius: float, approach: float) -> Vector:
    """Velocity of the touching point along the surface."""
    (vx, vy, vz), (wx, wy, wz), (nx, ny, nz) = velocity, spin, normal
    return (
        vx + approach * nx - radius * (wy * nz - wz * ny),
        vy + approach * ny - radius * (wz * nx - wx * nz),
        vz + approach * nz - radius * (wx * ny - wy * nx),
    )


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
