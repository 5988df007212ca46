"""Laws of contact of foam balls, one function each: normal force, damping, friction with memory, and what air does.

A ball is a soft sphere (P. A. Cundall, O. D. L. Strack, "A discrete numerical model for granular assemblies", 1979):
where it overlaps something by a depth d, foam pushes back with F(d), and a damper takes what the pair's restitution
says. Friction is a spring along the surface that remembers where it was touched, and slips at mu N. The same laws hold
from a touch to the force of a robot. Functions take and return plain numbers; `simcore.loop.balls` knows who touches
whom.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.loop.compiled import compiled
from simcore.typing import FloatArray

__all__ = [
    "DAMPING_RATIOS",
    "STIFFEST",
    "air_acceleration",
    "damping_ratio",
    "foam_force",
    "foam_slope",
    "friction_stiffness",
    "normal_force",
    "steps_for",
]

STIFFEST = 0.05
"""Most of k h^2 / m of a contact in its step [-]: half a period then has ten steps."""

_MOST_DAMPING = 0.5  # of c h / m: more would turn a ball with many contacts back
_TANGENTIAL = 0.8  # stiffness of the friction spring over the normal one: Mindlin's 2 (1 - nu) / (2 - nu), nu = 0.33
_TANGENTIAL_MASS = 2.0 / 7.0  # of a solid ball, seen at its surface
_TANGENTIAL_STIFFEST = 0.5  # most of k h^2 / m of the friction spring

_E_STEPS = 20  # intervals of the table below
# fmt: off
DAMPING_RATIOS: FloatArray = np.array([
    [3.0, 1.9469, 1.2453, 0.9246, 0.7314, 0.5974, 0.4973, 0.4187, 0.3546, 0.3010, 0.2555,
     0.2159, 0.1811, 0.1499, 0.1223, 0.0973, 0.0744, 0.0536, 0.0346, 0.0168, 0.0],
    [3.0, 1.5891, 1.0164, 0.7551, 0.5972, 0.4880, 0.4062, 0.3420, 0.2897, 0.2459, 0.2087,
     0.1761, 0.1478, 0.1226, 0.0998, 0.0795, 0.0611, 0.0440, 0.0281, 0.0139, 0.0],
])
# fmt: on
"""Ratio zeta of the damper c = 2 zeta sqrt(m F'(d)) that leaves a restitution of 0, 0.05 ... 1, shape (2, 21).

Of springs F ~ d and F ~ d^3 that never pull; found by integrating one contact. With this damper the restitution does
not depend on the speed (Y. Tsuji, T. Tanaka, T. Ishida, Powder Technology 71, 239, 1992). That of 0 is 0.02.
"""


@compiled
def foam_force(depth, linear, cubic, hard_from, hard):
    """Force of foam squeezed by depth [m]: F = k1 d + k3 d^3, and k2 (d - d0)^2 beyond d0, where it is dense [N]."""
    force = linear * depth + cubic * depth * depth * depth
    if depth > hard_from:
        over = depth - hard_from
        force += hard * over * over
    return force


@compiled
def foam_slope(depth, linear, cubic, hard_from, hard):
    """Stiffness dF/dd of `foam_force` at a depth [N/m]."""
    slope = linear + 3.0 * cubic * depth * depth
    if depth > hard_from:
        slope += 2.0 * hard * (depth - hard_from)
    return slope


@compiled
def damping_ratio(restitution, share, table):
    """Damping ratio of a contact [-].

    Args:
        restitution: Of the pair, 0 to 1.
        share: Part of the present stiffness that is not linear in the depth, 0 to 1.
        table: `DAMPING_RATIOS`.
    """
    place = min(max(restitution, 0.0), 1.0) * _E_STEPS
    share = share * (2.0 - share)
    low = min(int(place), _E_STEPS - 1)
    part = place - low
    soft = table[0, low] + part * (table[0, low + 1] - table[0, low])
    stiffening = table[1, low] + part * (table[1, low + 1] - table[1, low])
    return soft + share * (stiffening - soft)


@compiled
def normal_force(depth, force, slope, linear, approach, is_new, restitution, mass, h, table):
    """Force of spring and damper [N], never tension: F + 2 zeta sqrt(m k) v.

    Args:
        depth: [m]
        force: Of the foam [N].
        slope: Its stiffness [N/m].
        linear: That of a light touch [N/m].
        approach: Speed with which the two close [m/s].
        is_new: Whether they did not touch at the middle of the step before.
        restitution: Of the pair [-].
        mass: Reduced mass of both [kg].
        h: Step [s].
        table: `DAMPING_RATIOS`.
    """
    if is_new and approach > 0.0:  # they have touched for half a step, and as long as it took to get so deep
        approach *= min(1.5, 0.5 + depth / (approach * h))
    damping = 2.0 * damping_ratio(restitution, 1.0 - linear / slope, table) * math.sqrt(mass * slope)
    return max(0.0, force + min(damping, _MOST_DAMPING * mass / h) * approach)


@compiled
def friction_stiffness(slope, mass, h):
    """Stiffness [N/m] and damping [N s/m] of the friction spring of a contact, no stiffer than a step h [s] allows."""
    tangential = _TANGENTIAL_MASS * mass
    stiffness = min(_TANGENTIAL * slope, _TANGENTIAL_STIFFEST * tangential / (h * h))
    return stiffness, 0.6 * math.sqrt(stiffness * tangential)


@compiled
def steps_for(slope, mass, h):
    """Into how many steps a contact of a stiffness [N/m] and a mass [kg] cuts h [s]."""
    stiffness, most = slope * h * h, STIFFEST * mass
    return 1 if stiffness <= most else math.ceil(math.sqrt(stiffness / most))


@compiled
def air_acceleration(vx, vy, vz, wx, wy, wz, drag, lift, saturation):
    """Drag -k |v| v, and the lift of spin along omega x v, which levels off with the spin ratio [m/s^2].

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
