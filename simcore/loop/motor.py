"""A geared DC motor behind its controller: bus voltage, brake and coast, stator and supply limit, in four quadrants.

A controller keeps its voltage within the bus, the current within the stator limit, and the power, drawn or fed back,
within the supply limit times the bus voltage. With the shaft that the motor turns this is one scalar equation per shaft
and step. Backward Euler for the shaft speed w is

    k w = a + T(w)          k = J/h + (tire stiffness),   a = J/h w_old + (tire force)

and the torque T of motor, limits, gear loss and dry friction never rises with w. So there is exactly one solution for
any inertia and any step, it is found by a few comparisons, and it cannot diverge.
"""

from __future__ import annotations

import math

from simcore.loop.compiled import compiled, inner

__all__ = [
    "LOCKED",
    "end_weight",
    "line_in_force",
    "solve_limited",
    "solve_shaft",
    "supply_line",
    "torque_line",
    "within",
]

LOCKED = 1e12
"""Slope of a torque line that stands for a shaft held by friction [N m s]."""


@compiled
def within(value, limit):
    """Clamp `value` to -limit..limit: a voltage to the bus voltage, a current to the stator limit."""
    if value > limit:
        return limit
    if value < -limit:
        return -limit
    return value


@inner
def end_weight(h, rate):
    """Return the weight of a step's end in the mean that makes the step of w' = -rate w exact (exponential fitting).

    A slow shaft (rate h << 1) gets 1/2, the trapezoidal rule of second order; a fast one tends to 1, backward Euler,
    which does not ring.

    Args:
        h: Time step [s].
        rate: Rate at which back-EMF slows the free shaft down [1/s].
    """
    z = h * rate
    if z < 1e-3:
        return 0.5 + z / 12.0
    return -1.0 / math.expm1(-z) - 1.0 / z


@inner
def line_in_force(volts, bus, emf, limit, resistance, winding):
    """Return the current line of a motor whose controller compensates for the resistance in series with it.

    It compensates while its duty cycle is below 1: the current is the smallest of (V - e) / R_winding, (V_bus - e) / R
    and the stator limit.

    Args:
        volts: Wanted [V].
        bus: Battery voltage [V].
        emf: Back-EMF now [V].
        limit: Stator limit in force [A].
        resistance: Resistance at full duty [ohm].
        winding: Behind the controller [ohm].

    Returns:
        Voltage [V] and resistance [ohm] of the line I = (V - e) / R.
    """
    volts = within(volts, bus)
    if winding == resistance:
        return volts, resistance
    full = bus if volts > 0.0 else -bus
    at_full = abs(full - emf) / resistance
    if (volts - emf) * volts > 0.0 and at_full < limit and at_full * winding < abs(volts - emf):
        return full, resistance
    return volts, winding


@inner
def solve_shaft(k, a, i0, i1, limit, drive, driven, friction):
    """Solve `k w = a + T(w)` exactly for a limited motor behind lossy gears with dry friction.

    Args:
        k: Stiffness, > 0 [N m s].
        a: Torque that is there without the motor [N m].
        i0: Motor current at standstill, before the limit [A].
        i1: How much the current falls per shaft speed, >= 0 [A s/rad].
        limit: Limit of the current, in both directions [A].
        drive: Torque per current while the motor drives [N m/A].
        driven: Torque per current while it is driven, >= drive [N m/A].
        friction: Dry friction [N m].

    Returns:
        Shaft speed [rad/s], current [A], and the line T = t0 - t1 w that holds there: t0 [N m], t1 [N m s].
    """
    current = within(i0, limit)
    # Torque just above and just below standstill: between them gear loss and friction hold the shaft.
    if current > 0.0:
        up = a + drive * current - friction
        down = a + driven * current + friction
    else:
        up = a + driven * current - friction
        down = a + drive * current + friction
    if up > 0.0:
        a -= friction
        # The motor drives below its free speed i0 / i1; the torque balance at that speed tells on which side we are.
        f = drive if i0 > 0.0 and a * i1 < k * i0 else driven
        sign = -friction
    elif down < 0.0:
        a += friction
        f = drive if i0 < 0.0 and a * i1 > k * i0 else driven
        sign = friction
    else:
        return 0.0, current, 0.0, LOCKED
    w = (a + f * i0) / (k + f * i1)
    current = i0 - i1 * w
    if current > limit:
        return (a + f * limit) / k, limit, f * limit + sign, 0.0
    if current < -limit:
        return (a - f * limit) / k, -limit, sign - f * limit, 0.0
    return w, current, f * i0 + sign, f * i1


@inner
def supply_line(emf, slope, w, resistance, power, current, drawn):
    """Return the current line that keeps |V I| within `power` near a shaft speed.

    While drawing, the limit is the curve (e + I R) I = P, which is convex in e: its tangent at the present e stays
    below it, so the limit also holds at the end of the step. While regenerating, the controller reduces torque until
    the power fed back is within the limit; that current falls with e, so it is safe up to the e that is given.

    Args:
        emf: Back-EMF e [V].
        slope: Back-EMF per shaft speed [V s/rad].
        w: Shaft speed at which e was taken [rad/s].
        resistance: R [ohm].
        power: Limit P [W].
        current: The current that broke the limit; only its sign matters [A].
        drawn: The power that broke it; below zero it was fed back [W].

    Returns:
        `i0, i1` of the line I = i0 - i1 w, for `solve_shaft`.
    """
    if drawn < 0.0:
        e = abs(emf)
        return -math.copysign(0.5 * (e - math.sqrt(max(0.0, e * e - 4.0 * resistance * power))) / resistance, emf), 0.0
    sign = 1.0 if current > 0.0 else -1.0
    e = emf * sign
    size = 0.5 * (math.sqrt(e * e + 4.0 * resistance * power) - e) / resistance
    drop = size / (e + 2.0 * size * resistance) if size > 0.0 else 0.0
    return sign * size + drop * slope * w, drop * slope


@compiled
def solve_limited(k, a, i0, i1, limit, emf, resistance, driving, driven, friction, emf_offset, w, power):
    """Solve as `solve_shaft` within both limits, stator and supply.

    Args:
        k: See `solve_shaft`.
        a: See `solve_shaft`.
        i0: See `solve_shaft`.
        i1: See `solve_shaft`.
        limit: Stator limit in force now [A].
        emf: Back-EMF per shaft speed [V s/rad].
        resistance: [ohm]
        driving: See `solve_shaft`.
        driven: See `solve_shaft`.
        friction: See `solve_shaft`.
        emf_offset: Back-EMF at standstill [V].
        w: Shaft speed before the step [rad/s].
        power: Supply limit times bus voltage [W].

    Returns:
        Shaft speed [rad/s], current [A], volts at the motor [V], and the line of torque: t0 [N m], t1 [N m s].
    """
    end, i, t0, t1 = solve_shaft(k, a, i0, i1, limit, driving, driven, friction)
    drawn = (emf_offset + emf * end + i * resistance) * i
    if drawn > power or drawn < -power:
        is_done = False
        if drawn > 0.0:
            p0, p1 = supply_line(emf_offset + emf * w, emf, w, resistance, power, i, drawn)
            end, i, t0, t1 = solve_shaft(k, a, p0, p1, limit, driving, driven, friction)
            # A shaft that is thrown backwards within the step can turn the drawing motor into a generator.
            is_done = (emf_offset + emf * end + i * resistance) * i >= -power
        if not is_done:
            # Without current the shaft ends at the greatest |e| that it can have: limited there, limited always.
            w, _, _, _ = solve_shaft(k, a, 0.0, 0.0, limit, driving, driven, friction)
            p0, p1 = supply_line(emf_offset + emf * w, emf, w, resistance, power, i, -1.0)
            end, i, t0, t1 = solve_shaft(k, a, p0, p1, limit, driving, driven, friction)
    return end, i, emf_offset + emf * end + i * resistance, t0, t1


@inner
def torque_line(is_open, volts, bus, emf_offset, w, limit, power, emf, resistance, driving, driven, friction):
    """Return the lines of current and torque over shaft speed that hold near `w`.

    Args:
        is_open: Whether the circuit is open.
        volts: Wanted [V].
        bus: Battery voltage, which the motor cannot exceed [V].
        emf_offset: Back-EMF at standstill (azimuth coupling) [V].
        w: Shaft speed [rad/s].
        limit: Stator limit in force [A].
        power: Supply limit times bus voltage [W].
        emf: Back-EMF per shaft speed [V s/rad].
        resistance: [ohm]
        driving: See `solve_shaft`.
        driven: See `solve_shaft`.
        friction: See `solve_shaft`.

    Returns:
        `i0, i1` of the current I = i0 - i1 w without limits, and `t0, t1` of the torque T = t0 - t1 w within them.
    """
    i0 = 0.0
    i1 = 0.0
    t0 = 0.0
    t1 = 0.0
    if not is_open:
        volts = within(volts, bus)
        i0 = (volts - emf_offset) / resistance
        i1 = emf / resistance
        i = i0 - i1 * w
        f = driving if i * w >= 0.0 else driven
        p = volts * i
        if p > power or p < -power:
            t0, t1 = supply_line(emf_offset + emf * w, emf, w, resistance, power, i, p)
            i = t0 - t1 * w
            t0 *= f
            t1 *= f
        else:
            t0 = f * i0
            t1 = f * i1
        if i > limit:
            t0 = f * limit
            t1 = 0.0
        elif i < -limit:
            t0 = -f * limit
            t1 = 0.0
    if w > 0.0:
        return i0, i1, t0 - friction, t1
    if w < 0.0:
        return i0, i1, t0 + friction, t1
    if t0 > friction:
        return i0, i1, t0 - friction, t1
    if t0 < -friction:
        return i0, i1, t0 + friction, t1
    return i0, i1, 0.0, LOCKED
