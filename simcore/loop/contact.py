"""Laws of contact of foam balls, one function each: normal force, its memory, friction with memory, what air does.

A ball is a soft sphere (P. A. Cundall, O. D. L. Strack, "A discrete numerical model for granular assemblies", 1979):
where it overlaps something by a depth d, foam pushes back with F(d) (1 + c s). The memory s of a contact is 1 while it
is squeezed, turns to -1 while it is let go, and forgets. So foam loses energy by hysteresis: how much depends neither
on the speed, nor on the mass behind the ball, nor on the step, and at rest the force is F(d). Friction is a spring
along the surface that remembers where it was touched, and slips at mu N. The same laws hold from a touch to the force
of a robot. Functions take and return plain numbers; `simcore.loop.balls` knows who touches whom.
"""

from __future__ import annotations

import math

from simcore.loop.compiled import compiled, inner

__all__ = [
    "STIFFEST",
    "air_acceleration",
    "foam_energy",
    "foam_force",
    "foam_loss",
    "foam_memory",
    "foam_slope",
    "friction_stiffness",
    "hardened",
    "rolling_resistance",
    "steps_for",
]

STIFFEST = 0.05
"""Most of k h^2 / m of a contact in its step [-]: half a period then has ten steps."""

_THINNEST = 0.003  # band of foam that gives nothing back: it gives back 0.04 of the speed
_TURNING = 0.12
"""Square of the restitution below which a contact needs shorter steps [-]: its stiffness is 4 / e^2 times that of the
foam as its memory turns."""
_FORGETS = 0.15
"""Time constant with which foam at rest comes to F(d) [s]: long beside the bounce of a ball, short beside a pin.
Estimate; nobody has published how fast balls recover."""
_TANGENTIAL = 0.8  # stiffness of the friction spring over the normal one: Mindlin's 2 (1 - nu) / (2 - nu), nu = 0.33
_TANGENTIAL_MASS = 2.0 / 7.0  # of a solid ball, seen at its surface
_TANGENTIAL_STIFFEST = 0.5  # most of k h^2 / m of the friction spring


@compiled
def foam_force(depth, linear, cubic, hard_from, hard):
    """Return foam's force at a depth [m]: F = k1 d + k3 d^3, and k2 (d - d0)^2 beyond d0, where it is dense [N]."""
    force = linear * depth + cubic * depth * depth * depth
    if depth > hard_from:
        over = depth - hard_from
        force += hard * over * over
    return force


@inner
def foam_slope(depth, linear, cubic, hard_from, hard):
    """Return the stiffness dF/dd of `foam_force` at a depth [N/m]."""
    slope = linear + 3.0 * cubic * depth * depth
    if depth > hard_from:
        slope += 2.0 * hard * (depth - hard_from)
    return slope


@inner
def foam_energy(depth, linear, cubic, hard_from, hard):
    """Return the work U of `foam_force` up to a depth [J]."""
    square = depth * depth
    energy = square * (0.5 * linear + 0.25 * cubic * square)
    if depth > hard_from:
        over = depth - hard_from
        energy += hard * over * over * over / 3.0
    return energy


@inner
def foam_loss(restitution):
    """Return share c of the force that foam adds while squeezed and lacks while let go [-], and its band w [-].

    Squeezed it takes (1 + c) U; let go it returns (1 - c) U and, while its memory turns within ln U = w, 2 c j U more,
    with j = 1 - (1 - exp(-w)) / w, whatever F(d) is. So e^2 = (1 - c + 2 c j) / (1 + c), which c = 1 - e^2 and
    j = e^2 / 2 fulfil. All of it in the band (c = 1, j = e^2) would leave foam that is let go no force to part with.

    Args:
        restitution: Restitution of the pair, 0 to 1 [-].
    """
    e2 = min(1.0, restitution * restitution)
    band = e2 * (1.0 + e2 * (1.0 / 3.0 + e2 * 5.0 / 36.0))  # the inverse of j(w) by its series
    return 1.0 - e2, max(_THINNEST, band)


@inner
def foam_memory(memory, energy, last, band, h):
    """Return the memory of a contact, -1 to 1 [-]: it turns by 2 d(ln U) / w, and forgets while nothing moves.

    Args:
        memory: Before.
        energy: Energy of the foam now [J].
        last: Likewise, in the step before.
        band: Band of `foam_loss`.
        h: Step [s].
    """
    both, keeps = energy + last, band + (2.0 / _FORGETS) * h
    if both < 1e-30:
        return memory * band / keeps
    turned = 4.0 * (energy - last)
    return max(-1.0, min(1.0, (memory * both * band + turned) / (both * keeps)))


@inner
def hardened(slope, restitution):
    """Return the stiffness [N/m] that a contact needs its step for: more than that of foam which gives little back."""
    returned = restitution * restitution + 1e-3
    return slope if returned >= _TURNING else slope * _TURNING / returned


@inner
def friction_stiffness(slope, mass, h):
    """Return stiffness [N/m] and damping [N s/m] of a contact's friction spring, limited for a step h [s]."""
    tangential = _TANGENTIAL_MASS * mass
    stiffness = min(_TANGENTIAL * slope, _TANGENTIAL_STIFFEST * tangential / (h * h))
    return stiffness, 0.6 * math.sqrt(stiffness * tangential)


@inner
def rolling_resistance(push, spin, depth, radius, restitution):
    """Return the torque with which foam resists rolling, over the spin [N m s]: what it loses ahead, it lacks behind.

    The torque is c N, c = 3/16 (1 - e^2) a, with the radius a = sqrt(R d) of the patch that touches.
    Source: K. L. Johnson, "Contact Mechanics", 1985, section 9.4.

    Args:
        push: Normal force N [N].
        spin: Square of the relative spin, more than 0 [1/s^2].
        depth: Depth of the squeeze [m].
        radius: Radius of curvature of the pair, R1 R2 / (R1 + R2) [m].
        restitution: Restitution of the pair, 0 to 1 [-].
    """
    return 0.1875 * (1.0 - min(1.0, restitution * restitution)) * push * math.sqrt(radius * depth / spin)


@inner
def steps_for(stiffness, mass, h):
    """Return into how many steps a contact of a stiffness [N/m] and a mass [kg] cuts h [s]."""
    stiff, most = stiffness * h * h, STIFFEST * mass
    return 1 if stiff <= most else math.ceil(math.sqrt(stiff / most))


@inner
def air_acceleration(vx, vy, vz, wx, wy, wz, drag, lift, saturation):
    """Return drag -k |v| v, and the lift of spin along omega x v, which levels off with the spin ratio [m/s^2].

    Source and meaning of the three factors: `simcore.pieces.aerodynamics`.
    """
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    pull = -drag * speed
    ax, ay, az = pull * vx, pull * vy, pull * vz
    if lift != 0.0 and speed > 0.0:
        cx, cy, cz = wy * vz - wz * vy, wz * vx - wx * vz, wx * vy - wy * vx
        across = math.sqrt(cx * cx + cy * cy + cz * cz)
        share = lift * speed * speed / (speed * speed + saturation * across)
        ax += share * cx
        ay += share * cy
        az += share * cz
    return ax, ay, az
