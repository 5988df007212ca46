"""Geared DC motor and motor controller: bus voltage, brake and coast, stator and supply limits, in four quadrants.

The controller limits the voltage to the bus voltage, the current to the stator limit, and the power, drawn or
regenerated, to the supply limit times the bus voltage. Motor, controller and shaft give one scalar equation per shaft
and step. Backward Euler for the shaft speed w is

    k w = a + T(w)          k = J/h + (tire stiffness),   a = J/h w_old + (tire force)

The torque T from motor, limits, gear loss and dry friction never increases with w. The equation therefore has exactly
one solution for any inertia and any step. `solve_shaft` finds the solution with a few comparisons and no iteration.
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
"""Slope of the torque line of a shaft that friction holds [N m s]."""


@compiled
def within(value, limit):
    """Return `value` clamped to the range from -limit to limit."""
    if value > limit:
        return limit
    if value < -limit:
        return -limit
    return value


@inner
def end_weight(h, rate):
    """Return the weight of the final speed in the mean speed [-] that makes a step of w' = -rate w exact.

    The method is exponential fitting. The weight is 1/2 (trapezoidal rule, second order) for a slow shaft, rate h << 1,
    and tends to 1 (backward Euler, which does not ring) for a fast shaft.

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
    """Return the line I = (V - e) / R of a motor at the present back-EMF.

    The controller compensates for the resistance in series with the winding while the duty cycle is below 1. The
    current is therefore the smallest of (V - e) / R_winding, (V_bus - e) / R and the stator limit.

    Args:
        volts: Requested voltage V [V].
        bus: Battery voltage [V].
        emf: Present back-EMF e [V].
        limit: Stator current limit in force [A].
        resistance: Resistance R of the motor at full duty cycle [ohm].
        winding: Resistance of the winding [ohm].

    Returns:
        Voltage V [V] and resistance R [ohm] of the line; the caller applies the stator limit.
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
    """Solve `k w = a + T(w)` exactly for a current-limited motor and lossy gears with dry friction.

    Args:
        k: Coefficient k of the shaft speed, > 0 [N m s].
        a: Torque a without the motor [N m].
        i0: Motor current at standstill without the limit [A].
        i1: Decrease of the current per shaft speed, >= 0 [A s/rad].
        limit: Current limit in both directions [A].
        drive: Torque per current while the motor drives the gears [N m/A].
        driven: Torque per current while the gears drive the motor, >= drive [N m/A].
        friction: Dry friction torque [N m].

    Returns:
        Shaft speed [rad/s], current [A], and the torque line T = t0 - t1 w at this speed: t0 [N m], t1 [N m s].
    """
    current = within(i0, limit)
    # Net torque just above and just below standstill. If neither moves the shaft, gear loss and friction hold it.
    if current > 0.0:
        up = a + drive * current - friction
        down = a + driven * current + friction
    else:
        up = a + driven * current - friction
        down = a + drive * current + friction
    if up > 0.0:
        a -= friction
        # The motor drives the gears below the free speed i0 / i1; the sign of the torque balance there decides.
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

    While the motor draws power, the limit is the curve (e + I R) I = P. This curve is convex in e: the tangent at the
    present e stays below the curve, so the limit also holds at the end of the step. While the motor regenerates, the
    controller reduces the torque until the regenerated power is within the limit. The current decreases as |e|
    increases, so the limit also holds for any smaller |e|.

    Args:
        emf: Back-EMF e at shaft speed `w` [V].
        slope: Back-EMF per shaft speed [V s/rad].
        w: Shaft speed [rad/s].
        resistance: Resistance R of the motor [ohm].
        power: Limit P of the power [W].
        current: Current that exceeded the limit, of which only the sign matters [A].
        drawn: Power that exceeded the limit, negative if regenerated [W].

    Returns:
        Coefficients `i0` [A] and `i1` [A s/rad] of the line I = i0 - i1 w, for `solve_shaft`.
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
    """Solve `k w = a + T(w)` as in `solve_shaft`, within the stator limit and the supply limit.

    Args:
        k: Coefficient k of the shaft speed, > 0 [N m s].
        a: Torque a without the motor [N m].
        i0: Motor current at standstill without limits [A].
        i1: Decrease of the current per shaft speed, >= 0 [A s/rad].
        limit: Stator current limit in force [A].
        emf: Back-EMF per shaft speed [V s/rad].
        resistance: Resistance of the motor [ohm].
        driving: Torque per current while the motor drives the gears [N m/A].
        driven: Torque per current while the gears drive the motor, >= driving [N m/A].
        friction: Dry friction torque [N m].
        emf_offset: Back-EMF at standstill [V].
        w: Shaft speed before the step [rad/s].
        power: Supply limit times bus voltage [W].

    Returns:
        Shaft speed [rad/s], current [A], voltage at the motor [V], and the torque line T = t0 - t1 w at this speed:
            t0 [N m], t1 [N m s].
    """
    end, i, t0, t1 = solve_shaft(k, a, i0, i1, limit, driving, driven, friction)
    drawn = (emf_offset + emf * end + i * resistance) * i
    if drawn > power or drawn < -power:
        is_done = False
        if drawn > 0.0:
            p0, p1 = supply_line(emf_offset + emf * w, emf, w, resistance, power, i, drawn)
            end, i, t0, t1 = solve_shaft(k, a, p0, p1, limit, driving, driven, friction)
            # If an external torque reverses the shaft within the step, the motor can regenerate instead.
            is_done = (emf_offset + emf * end + i * resistance) * i >= -power
        if not is_done:
            # Without current the shaft reaches the largest possible |e|; a current that is safe there is always safe.
            w, _, _, _ = solve_shaft(k, a, 0.0, 0.0, limit, driving, driven, friction)
            p0, p1 = supply_line(emf_offset + emf * w, emf, w, resistance, power, i, -1.0)
            end, i, t0, t1 = solve_shaft(k, a, p0, p1, limit, driving, driven, friction)
    return end, i, emf_offset + emf * end + i * resistance, t0, t1


@inner
def torque_line(is_open, volts, bus, emf_offset, w, limit, power, emf, resistance, driving, driven, friction):
    """Return the current and torque of a motor as linear functions of the shaft speed near `w`.

    Args:
        is_open: Whether the circuit is open.
        volts: Requested voltage [V].
        bus: Battery voltage, the limit of the motor voltage [V].
        emf_offset: Back-EMF at standstill, from the coupling of the steer shaft [V].
        w: Shaft speed [rad/s].
        limit: Stator current limit in force [A].
        power: Supply limit times bus voltage [W].
        emf: Back-EMF per shaft speed [V s/rad].
        resistance: Resistance of the motor [ohm].
        driving: Torque per current while the motor drives the gears [N m/A].
        driven: Torque per current while the gears drive the motor, >= driving [N m/A].
        friction: Dry friction torque [N m].

    Returns:
        `i0` [A] and `i1` [A s/rad] of the current I = i0 - i1 w without limits, and `t0` [N m] and `t1` [N m s] of the
            torque T = t0 - t1 w with limits and friction.
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
