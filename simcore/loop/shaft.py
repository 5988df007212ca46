"""Shaft of a motor in one step: the request of its controller, and the shaft's motion."""

from __future__ import annotations

import math

from simcore.loop.compiled import compiled, inner
from simcore.loop.motor import end_weight, line_in_force, solve_limited, within
from simcore.loop.robot_state import CURRENT, DUTY, NEUTRAL, PISTON, SERVO, STEP, TARGET, Records

__all__ = ["accumulate", "begin_motor", "control", "open_circuit", "set_step", "turn", "turn_alone"]

_REST = 1e-9
"""A turn in 200 years [rad/s]: a shaft that nothing drives stands still from here on, and does not approach zero for
ever."""


@inner
def begin_motor(shafts, i):
    """Clear the means of the last call."""
    s = shafts[i]
    s.mean_current = 0.0
    s.mean_supply = 0.0


@inner
def open_circuit(shafts, i):
    """Take its power away: a motor coasts until the next request, a valve falls back, a servo is held."""
    s = shafts[i]
    model = s.model
    if model.kind == PISTON:
        if model.idle != 0.0:
            s.request.value = model.idle
    elif model.kind == SERVO:
        s.request.mode = NEUTRAL
        s.request.brakes = 0
        s.speed = 0.0
    else:
        s.request.mode = NEUTRAL
        s.request.value = 0.0
        s.request.brakes = 0


@inner
def control(shafts, i, bus, emf):
    """Work out what its controller applies in a step: volts or an open circuit, and the stator limit in force.

    Args:
        shafts: All.
        i: Number of the shaft.
        bus: Voltage of its supply [V].
        emf: Back-EMF now [V].
    """
    s = shafts[i]
    model = s.model
    s.limit = s.request.stator_limit
    s.is_open = 0
    if s.request.mode == NEUTRAL:
        s.wanted = 0.0
    elif s.request.mode == DUTY:
        s.wanted = s.request.value * bus
    elif s.request.mode == CURRENT:  # as much voltage as there is, with the wanted current as the limit
        s.wanted = math.copysign(math.inf, s.request.value)
        s.limit = min(abs(s.request.value), s.request.stator_limit)
        s.is_open = 1 if s.request.value == 0.0 else 0
    elif s.request.mode == TARGET:  # of a servo: an angle
        s.wanted = within(model.kp * (s.request.value - s.position), model.rail)
    else:
        s.wanted = s.request.value
    if s.wanted == 0.0 and s.request.brakes == 0:
        s.is_open = 1


@inner
def set_step(shafts, i, h):
    """Set the length of its step [s]; see `end_weight`."""
    s = shafts[i]
    model = s.model
    if s.weighted != h:
        s.weighted = h
        s.weight = end_weight(h, model.driven * model.emf / (model.resistance * model.inertia))


@inner
def turn(shafts, i, h, bus, friction, drag, torque):
    """Turn a shaft without wheels by a step; its request is known.

    The step is exact for a motor on constant volts, and the mean speed and current in it as well.

    Args:
        shafts: All.
        i: Number of the shaft.
        h: Step [s].
        bus: Voltage of the battery [V].
        friction: Further dry friction [N m].
        drag: Torque against its speed [N m s/rad].
        torque: Further torque [N m].
    """
    s = shafts[i]
    model = s.model
    w = s.speed
    supply = model.rail if model.rail > 0.0 else bus
    set_step(shafts, i, h)
    resistance = model.winding
    volts = 0.0
    emf_end = s.weight * model.emf
    offset = (model.emf - emf_end) * w
    i0 = 0.0
    i1 = 0.0
    if not s.is_open:
        volts, resistance = line_in_force(s.wanted, supply, model.emf * w, s.limit, model.resistance, model.winding)
        i0 = (volts - offset) / resistance
        i1 = emf_end / resistance
    else:
        offset = 0.0
        emf_end = 0.0
    holds = model.friction + friction
    torque += s.request.load - model.weight_torque * math.cos(s.position + 0.5 * h * w)
    k = model.inertia / h
    power = s.request.supply_limit * supply
    end, amps, at, _, _ = solve_limited(
        k + drag,
        k * w + torque,
        i0,
        i1,
        s.limit,
        emf_end,
        resistance,
        model.driving,
        model.driven,
        holds,
        offset,
        w,
        power,
    )
    if (s.position >= model.upper and end > 0.0) or (s.position <= model.lower and end < 0.0):  # a stop holds it
        w = 0.0
        end, amps, at, _, _ = solve_limited(
            k,
            0.0,
            i0 if s.is_open else volts / resistance,
            i1,
            s.limit,
            emf_end,
            resistance,
            model.driving,
            model.driven,
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
    if place > model.upper:
        place = model.upper
        end = min(end, 0.0)
    elif place < model.lower:
        place = model.lower
        end = max(end, 0.0)
    s.position = place
    s.speed = end
    s.volts = at
    s.current = amps
    accumulate(shafts, i, h, bus)


@inner
def accumulate(shafts, i, h, bus):
    """Add what the motors took in a step of h [s] to their sums."""
    s = shafts[i]
    model = s.model
    power = s.volts * s.current * model.count
    if model.kind == PISTON:
        power = 0.0
    s.supply = power / bus if bus > 0.0 else 0.0
    s.energy += power * h
    s.charge2 += s.current * s.current * h
    s.mean_current += s.current * model.count * h
    s.mean_supply += s.supply * h


@compiled
def turn_alone(shafts: Records, i: int, dt: float, bus: float) -> None:
    """Turn a mechanism for dt [s] on a battery of constant voltage [V]."""
    n = math.ceil(dt / STEP - 1e-9)
    h = dt / n
    s = shafts[i]
    model = s.model
    begin_motor(shafts, i)
    for _ in range(n):
        control(shafts, i, model.rail if model.rail > 0.0 else bus, model.emf * s.speed)
        turn(shafts, i, h, bus, 0.0, 0.0, 0.0)
    s.mean_current /= dt
    s.mean_supply /= dt
