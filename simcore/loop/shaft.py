"""What a motor turns, in one step: what its controller is asked for, and how the shaft moves."""

from __future__ import annotations

import math

from simcore.loop.compiled import compiled
from simcore.loop.motor import end_weight, line_in_force, solve_limited, within
from simcore.loop.robot_state import CURRENT, DUTY, NEUTRAL, PISTON, SERVO, STEP, TARGET, Records

__all__ = ["begin_motor", "book", "open_circuit", "request", "turn", "turn_alone"]

_REST = 1e-9
"""A turn in 200 years [rad/s]: a shaft that nothing drives stands still from here on, and does not approach zero for
ever."""


@compiled
def begin_motor(shafts, i):
    """Forget the means of the last call."""
    s = shafts[i]
    s.mean_current = 0.0
    s.mean_supply = 0.0


@compiled
def open_circuit(shafts, i):
    """Nothing powers it: a motor coasts until it is asked for something, a valve falls back, a servo is held."""
    s = shafts[i]
    if s.kind == PISTON:
        if s.idle != 0.0:
            s.request = s.idle
    elif s.kind == SERVO:
        s.mode = NEUTRAL
        s.brakes = 0
        s.speed = 0.0
    else:
        s.mode = NEUTRAL
        s.request = 0.0
        s.brakes = 0


@compiled
def request(shafts, i, bus, emf):
    """What its controller wants of the motor in a step: volts or an open circuit, and the stator limit in force.

    Args:
        shafts: All.
        i: Which.
        bus: Voltage of its supply [V].
        emf: Back-EMF now [V].
    """
    s = shafts[i]
    s.limit = s.stator_limit
    s.is_open = 0
    if s.mode == NEUTRAL:
        s.wanted = 0.0
    elif s.mode == DUTY:
        s.wanted = s.request * bus
    elif s.mode == CURRENT:  # as much voltage as there is, with the wanted current as the limit
        s.wanted = math.copysign(math.inf, s.request)
        s.limit = min(abs(s.request), s.stator_limit)
        s.is_open = 1 if s.request == 0.0 else 0
    elif s.mode == TARGET:  # of a servo: an angle
        s.wanted = within(s.kp * (s.request - s.position), s.rail)
    else:
        s.wanted = s.request
    if s.wanted == 0.0 and s.brakes == 0:
        s.is_open = 1


@compiled
def fit(shafts, i, h):
    """Fit its step to a length [s]; see `end_weight`."""
    s = shafts[i]
    if s.weighted != h:
        s.weighted = h
        s.weight = end_weight(h, s.driven * s.emf / (s.resistance * s.inertia))


@compiled
def turn(shafts, i, h, bus, friction, drag, torque):
    """Turn a shaft without wheels by a step; its request is known.

    The step is exact for a motor on constant volts, and the mean speed and current in it as well.

    Args:
        shafts: All.
        i: Which.
        h: Step [s].
        bus: Voltage of the battery [V].
        friction: Dry friction beside its own [N m].
        drag: Torque against its speed [N m s/rad].
        torque: From elsewhere [N m].
    """
    s = shafts[i]
    w = s.speed
    supply = s.rail if s.rail > 0.0 else bus
    fit(shafts, i, h)
    resistance = s.winding
    volts = 0.0
    emf_end = s.weight * s.emf
    offset = (s.emf - emf_end) * w
    i0 = 0.0
    i1 = 0.0
    if not s.is_open:
        volts, resistance = line_in_force(s.wanted, supply, s.emf * w, s.limit, s.resistance, s.winding)
        i0 = (volts - offset) / resistance
        i1 = emf_end / resistance
    else:
        offset = 0.0
        emf_end = 0.0
    holds = s.friction + friction
    torque += s.load - s.weight_torque * math.cos(s.position + 0.5 * h * w)
    k = s.inertia / h
    power = s.supply_limit * supply
    end, amps, at, _, _ = solve_limited(
        k + drag, k * w + torque, i0, i1, s.limit, emf_end, resistance, s.driving, s.driven, holds, offset, w, power
    )
    if (s.position >= s.upper and end > 0.0) or (s.position <= s.lower and end < 0.0):  # a stop holds it
        w = 0.0
        end, amps, at, _, _ = solve_limited(
            k,
            0.0,
            i0 if s.is_open else volts / resistance,
            i1,
            s.limit,
            emf_end,
            resistance,
            s.driving,
            s.driven,
            math.inf,
            0.0,
            0.0,
            power,
        )
    if s.is_open:
        at = 0.0
        mean = 0.5 * (w + end)
    else:
        mean = w + s.weight * (end - w)
        if w * end <= 0.0 and holds > 0.0:
            mean = 0.5 * (w + end)
    if -_REST < end < _REST:
        end = 0.0
    place = s.position + mean * h
    if place > s.upper:
        place = s.upper
        end = min(end, 0.0)
    elif place < s.lower:
        place = s.lower
        end = max(end, 0.0)
    s.position = place
    s.speed = end
    s.volts = at
    s.current = amps
    book(shafts, i, h, bus)


@compiled
def book(shafts, i, h, bus):
    """Note what the motors took in a step of h [s]."""
    s = shafts[i]
    power = s.volts * s.current * s.count
    if s.kind == PISTON:
        power = 0.0
    s.supply = power / bus if bus > 0.0 else 0.0
    s.energy += power * h
    s.charge2 += s.current * s.current * h
    s.mean_current += s.current * s.count * h
    s.mean_supply += s.supply * h


@compiled
def turn_alone(shafts: Records, i: int, dt: float, bus: float) -> None:
    """Turn a mechanism for dt [s] on a battery of constant voltage [V]."""
    n = math.ceil(dt / STEP - 1e-9)
    h = dt / n
    s = shafts[i]
    begin_motor(shafts, i)
    for _ in range(n):
        request(shafts, i, s.rail if s.rail > 0.0 else bus, s.emf * s.speed)
        turn(shafts, i, h, bus, 0.0, 0.0, 0.0)
    s.mean_current /= dt
    s.mean_supply /= dt
