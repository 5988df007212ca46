"""Contact laws of foam balls: normal force with hysteresis, friction, rolling resistance; also drag and lift.

A ball is a soft sphere (P. A. Cundall, O. D. L. Strack, "A discrete numerical model for granular assemblies", 1979): at
an overlap d the foam gives the normal force F(d) (1 + c s). The memory s of a contact goes to 1 during loading, to -1
during unloading, and to 0 at rest. Foam loses energy by this hysteresis. The loss depends neither on speed, nor on
mass, nor on the time step, and at rest the force is F(d). Friction is a tangential spring from the first point of
contact, and the contact slips at the force mu N. The laws hold for forces from a light touch up to the push of a robot.
All functions take and return plain numbers. `simcore.loop.balls` finds the contacts.
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
"""Largest k h^2 / m of a contact in one step [-]; half a period, pi sqrt(m / k), then has at least 14 steps."""

_THINNEST = 0.003  # smallest band w of the memory [-]; restitution is then at least 0.04
_TURNING = 0.12
"""Square of the restitution e below which a contact needs shorter steps [-]: while the memory changes sign, the contact
is about 4 / e^2 times as stiff as the foam."""
_FORGETS = 0.15
"""Decay time of the memory of foam at rest [s]: at constant overlap the memory decays with the time constant
band * _FORGETS / 2, where `foam_loss` computes the band. The time is long compared with a bounce and short compared
with the time for which a robot pins a ball. The value is an estimate; no recovery times of balls are published."""
_TANGENTIAL = 0.8  # tangential over normal stiffness [-]: Mindlin's 2 (1 - nu) / (2 - nu), nu = 0.33
_TANGENTIAL_MASS = 2.0 / 7.0  # effective tangential mass at the surface of a solid ball over its mass [-]
_TANGENTIAL_STIFFEST = 0.5  # largest k h^2 / m of the friction spring in one step [-]


@compiled
def foam_force(depth, linear, cubic, hard_from, hard):
    """Return the normal force of foam without hysteresis [N]: k1 d + k3 d^3, plus k2 (d - d0)^2 for d > d0.

    Args:
        depth: Overlap d [m].
        linear: Coefficient k1 [N/m].
        cubic: Coefficient k3 [N/m^3].
        hard_from: Overlap d0 above which the foam becomes dense [m].
        hard: Coefficient k2 [N/m^2].
    """
    force = linear * depth + cubic * depth * depth * depth
    if depth > hard_from:
        over = depth - hard_from
        force += hard * over * over
    return force


@inner
def foam_slope(depth, linear, cubic, hard_from, hard):
    """Return the derivative of `foam_force` with respect to the overlap `depth` [N/m]."""
    slope = linear + 3.0 * cubic * depth * depth
    if depth > hard_from:
        slope += 2.0 * hard * (depth - hard_from)
    return slope


@inner
def foam_energy(depth, linear, cubic, hard_from, hard):
    """Return the work U of `foam_force` from zero overlap to the overlap `depth` [J]."""
    square = depth * depth
    energy = square * (0.5 * linear + 0.25 * cubic * square)
    if depth > hard_from:
        over = depth - hard_from
        energy += hard * over * over * over / 3.0
    return energy


@inner
def foam_loss(restitution):
    """Return the hysteresis factor c of the foam force [-] and the band w of the memory [-], at least `_THINNEST`.

    Loading takes the work (1 + c) U. Unloading returns (1 - c) U, plus 2 c j U while the memory changes sign over an
    interval w of ln U, with j = 1 - (1 - exp(-w)) / w for any F(d). So e^2 = (1 - c + 2 c j) / (1 + c), which
    c = 1 - e^2 and j = e^2 / 2 satisfy. With c = 1 and j = e^2 the foam would give no force during unloading.

    Args:
        restitution: Coefficient of restitution e of the pair, 0 to 1 [-].
    """
    e2 = min(1.0, restitution * restitution)
    band = e2 * (1.0 + e2 * (1.0 / 3.0 + e2 * 5.0 / 36.0))  # series of the inverse of j(w)
    return 1.0 - e2, max(_THINNEST, band)


@inner
def foam_memory(memory, energy, last, band, h):
    """Return the new memory of a contact, -1 to 1 [-].

    In a step the memory changes by 2 d(ln U) / w and decays towards 0.

    Args:
        memory: Memory after the last step, -1 to 1 [-].
        energy: Present energy U of the foam [J].
        last: Energy of the foam in the last step [J].
        band: Band w from `foam_loss` [-].
        h: Time step [s].
    """
    both, keeps = energy + last, band + (2.0 / _FORGETS) * h
    if both < 1e-30:
        return memory * band / keeps
    turned = 4.0 * (energy - last)
    return max(-1.0, min(1.0, (memory * both * band + turned) / (both * keeps)))


@inner
def hardened(slope, restitution):
    """Return the stiffness that limits the time step of a contact [N/m]: `slope`, increased for a low restitution."""
    returned = restitution * restitution + 1e-3
    return slope if returned >= _TURNING else slope * _TURNING / returned


@inner
def friction_stiffness(slope, mass, h):
    """Return the stiffness [N/m] and damping [N s/m] of a friction spring that is stable in steps of h [s].

    Args:
        slope: Normal stiffness [N/m].
        mass: Reduced mass of the pair [kg].
        h: Time step [s].
    """
    tangential = _TANGENTIAL_MASS * mass
    stiffness = min(_TANGENTIAL * slope, _TANGENTIAL_STIFFEST * tangential / (h * h))
    return stiffness, 0.6 * math.sqrt(stiffness * tangential)


@inner
def rolling_resistance(push, spin, depth, radius, restitution):
    """Return the torque of rolling resistance from foam hysteresis, divided by the relative spin [N m s].

    The torque is b N, with the lever b = 3/16 (1 - e^2) a and the radius a = sqrt(R d) of the contact patch.

    Source: K. L. Johnson, "Contact Mechanics", 1985, section 9.4.

    Args:
        push: Normal force N [N].
        spin: Square of the relative spin, > 0 [1/s^2].
        depth: Overlap d [m].
        radius: Effective radius of curvature R of the pair, R1 R2 / (R1 + R2) [m].
        restitution: Coefficient of restitution e of the pair, 0 to 1 [-].
    """
    return 0.1875 * (1.0 - min(1.0, restitution * restitution)) * push * math.sqrt(radius * depth / spin)


@inner
def steps_for(stiffness, mass, h):
    """Return the smallest number of equal parts of a step that keeps k h^2 / m of a contact at or below `STIFFEST`.

    Args:
        stiffness: Stiffness k of the contact, from `hardened` [N/m].
        mass: Effective mass m [kg].
        h: Whole time step [s].
    """
    stiff, most = stiffness * h * h, STIFFEST * mass
    return 1 if stiff <= most else math.ceil(math.sqrt(stiff / most))


@inner
def air_acceleration(vx, vy, vz, wx, wy, wz, drag, lift, saturation):
    """Return the acceleration of a ball from drag, -k |v| v, and from spin lift, along omega x v [m/s^2].

    Lift saturates with the spin ratio. `simcore.pieces.aerodynamics` gives the formula and the source.

    Args:
        vx: x component of the velocity [m/s].
        vy: y component of the velocity [m/s].
        vz: z component of the velocity [m/s].
        wx: x component of the angular velocity [rad/s].
        wy: y component of the angular velocity [rad/s].
        wz: z component of the angular velocity [rad/s].
        drag: Drag factor k [1/m].
        lift: Lift factor [-].
        saturation: Saturation of lift [m].
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
