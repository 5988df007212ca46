"""One time step of a motor shaft: output of the motor controller, and motion of the shaft."""

from __future__ import annotations

import math

from simcore.loop.compiled import compiled, inner
from simcore.loop.motor import end_weight, line_in_force, solve_limited, within
from simcore.loop.robot_state import CURRENT, DUTY, NEUTRAL, PISTON, SERVO, STEP, TARGET, Records

__all__ = ["accumulate", "begin_motor", "control", "open_circuit", "set_step", "turn", "turn_alone"]

_REST = 1e-9
"""Speed below which a shaft stops [rad/s], one turn in 200 years. Without this limit the speed of an undriven shaft
would never reach zero."""


@inner
def begin_motor(shafts, i):
    """Clear the sums for a shaft's mean stator and supply current before a call of the loop."""
    s = shafts[i]
    s.mean_current = 0.0
    s.mean_supply = 0.0


@inner
def open_circuit(shafts, i):
    """Switch off the power of a shaft's motors or valve.

    A motor coasts until the next request. The valve of a piston gets the voltage `idle`, or keeps the last voltage if
    `idle` is 0. A servo stops at once.
    """
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
    """Compute the output of a motor controller for a step: voltage or open circuit, and stator limit in force.

    Args:
        shafts: Records of all shafts.
        i: Index of the shaft.
        bus: Supply voltage of the controller [V].
        emf: Present back-EMF [V].
    """
    s = shafts[i]
    model = s.model
    s.limit = s.request.stator_limit
    s.is_open = 0
    if s.request.mode == NEUTRAL:
        s.wanted = 0.0
    elif s.request.mode == DUTY:
        s.wanted = s.request.value * bus
    elif s.request.mode == CURRENT:  # full voltage, with the requested current as the stator limit
        s.wanted = math.copysign(math.inf, s.request.value)
        s.limit = min(abs(s.request.value), s.request.stator_limit)
        s.is_open = 1 if s.request.value == 0.0 else 0
    elif s.request.mode == TARGET:  # angle of a servo
        s.wanted = within(model.kp * (s.request.value - s.position), model.rail)
    else:
        s.wanted = s.request.value
    if s.wanted == 0.0 and s.request.brakes == 0:
        s.is_open = 1


@inner
def set_step(shafts, i, h):
    """Set a shaft's time step [s] and the weight of the final speed in the mean speed; see `end_weight`."""
    s = shafts[i]
    model = s.model
    if s.weighted != h:
        s.weighted = h
        s.weight = end_weight(h, model.driven * model.emf / (model.resistance * model.inertia))


@inner
def turn(shafts, i, h, bus, friction, drag, torque):
    """Advance a shaft without wheels by one step with the controller output from `control`.

    Final speed, mean speed and mean current are exact for a motor at constant voltage. The shaft stops at the hard
    stops `lower` and `upper`.

    Args:
        shafts: Records of all shafts.
        i: Index of the shaft.
        h: Time step [s].
        bus: Battery voltage [V].
        friction: Additional dry friction torque [N m].
        drag: Viscous drag, torque per shaft speed [N m s/rad].
        torque: Additional torque [N m].
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
    if (s.position >= model.upper and end > 0.0) or (s.position <= model.lower and end < 0.0):  # at a hard stop
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
    """Compute the supply current of a step of h [s], and add the motors' currents and energy to the shaft's sums."""
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
    """Advance a mechanism without a robot by dt [s] under the present request, at a constant battery voltage [V]."""
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
