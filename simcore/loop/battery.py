"""Battery, roboRIO brownouts, and the bus voltage at which battery and motor currents balance."""

from __future__ import annotations

import math

from simcore.loop.compiled import compiled, inner
from simcore.loop.motor import line_in_force, within
from simcore.loop.robot_state import Records

__all__ = ["begin_battery", "bus_voltage", "draw", "open_voltage", "watch_brownout"]


@compiled
def open_voltage(batteries: Records, i: int) -> float:
    """Return the open-circuit voltage at the present charge, minus the slow voltage drop, at least 0 [V]."""
    b = batteries[i]
    voltage: float = b.model.empty + (b.model.full - b.model.empty) * b.charge - b.slow_drop
    return max(0.0, voltage)


@compiled
def begin_battery(batteries: Records, i: int) -> None:
    """Swap in a rested battery with the present `charge`, and start the roboRIO and the motor controllers.

    The function does not reset `off_time`, `min_voltage`, and the numbers of brownouts and resets.
    """
    b = batteries[i]
    b.slow_drop = 0.0
    b.drawn = 0.0
    b.energy = 0.0
    b.current = 0.0
    b.voltage = open_voltage(batteries, i)
    b.min_voltage = min(b.min_voltage, b.voltage)
    b.is_off = 0
    b.is_low = 0
    b.heard = b.model.heartbeat
    b.starved = 0.0
    b.boots = 0.0
    if b.model.browns_out:
        watch_brownout(batteries, i, 0.0)


@inner
def draw(batteries: Records, i: int, h: float, current: float, at_voltage: float) -> bool:
    """Draw a current from a battery for one step, and update voltage, charge, energy and brownout state.

    Args:
        batteries: Records of all batteries.
        i: Index of the battery.
        h: Time step [s].
        current: Net current, constant over the step [A]; negative while charging.
        at_voltage: Bus voltage at which the motors draw this current [V]; NaN for a current that does not depend on the
            voltage. A load that would pull the terminals below `at_voltage` draws in proportion to the voltage.

    Returns:
        Whether a brownout or a reset began in this step; always False if the model has no brownouts.
    """
    b = batteries[i]
    if current > 0.0 and at_voltage > 0.0:
        share = open_voltage(batteries, i) / (at_voltage + b.model.resistance * current)
        if share < 1.0:
            current *= share
    b.current = current
    b.drawn += current * h
    b.charge = min(1.0, max(0.0, b.charge - current * h / b.model.capacity))
    # Exact for a constant current: the slow voltage drop relaxes towards I * R_slow.
    b.slow_drop += (b.slow_drop - current * b.model.recovery_resistance) * math.expm1(-h / b.model.recovery_time)
    voltage = max(0.0, open_voltage(batteries, i) - b.model.resistance * current)
    b.voltage = voltage
    b.energy += (at_voltage if at_voltage > 0.0 else voltage) * current * h
    b.tick_min_voltage = min(b.tick_min_voltage, voltage)
    b.min_voltage = min(b.min_voltage, voltage)
    return watch_brownout(batteries, i, h) if b.model.browns_out else False


@inner
def watch_brownout(batteries: Records, i: int, h: float) -> bool:
    """Update the power states of the roboRIO and of the motor controllers after a step of h [s].

    The motor controllers change state only at heartbeats: off during a brownout or a reboot, otherwise on.

    Returns:
        Whether a brownout or a reset began in this step.
    """
    b = batteries[i]
    v = b.voltage
    has_begun = False
    level = b.model.recovered_voltage if b.is_low else b.model.brownout_voltage
    b.is_low = 1 if v < level or (b.is_low and v == level) else 0
    if v < b.model.reset_voltage:
        b.starved += h
        if b.starved > b.model.reset_hold - 1e-9:  # rounding errors of the sum must not delay the reset by a step
            if b.boots == 0.0:
                b.resets += 1
                has_begun = True
            b.boots = b.model.reboot_time
    else:
        b.starved = 0.0
        b.boots = max(0.0, b.boots - h)
    if b.is_off:
        b.off_time += h
    b.heard += h
    if b.heard > b.model.heartbeat - 1e-9:
        b.heard = 0.0
        was_off = b.is_off
        b.is_off = 1 if b.is_low or b.boots > 0.0 else 0
        if b.is_off:
            b.tick_was_off = 1
            if not was_off:
                b.brownouts += 1
                has_begun = True
    if has_begun:
        b.noted_voltage = v
        b.noted_current = b.current
    return has_begun


@inner
def bus_voltage(batteries, i, guess, other_current, shafts, first, last):
    """Return the bus voltage at which battery and motor currents balance: V = V_open - R (I_other + I_motors(V)) [V].

    Four stalled motors in parallel have less resistance than the battery. An explicit solution, with the current of the
    last step, would therefore ring between 0 and 13 V. Newton's method starts from the last bus voltage and needs one
    iteration in steady state.

    Args:
        batteries: Records of all batteries.
        i: Index of the battery.
        guess: Bus voltage in the last step [V].
        other_current: Current of all loads other than motors [A].
        shafts: Records of all shafts.
        first: Index of the robot's first shaft.
        last: Index after the robot's last shaft.
    """
    b = batteries[i]
    source = open_voltage(batteries, i)
    if b.model.resistance == 0.0:
        return source
    bus = guess if guess > 1e-3 else source
    if bus < 1e-3:
        return 0.0
    for _ in range(8):
        total = other_current
        rise = 0.0  # d total / d bus
        for k in range(first, last):
            s = shafts[k]
            model = s.model
            if s.is_open or model.rail > 0.0:
                continue
            emf = model.emf * s.speed + s.emf_offset
            v, resistance = line_in_force(s.wanted, bus, emf, s.limit, model.resistance, model.winding)
            if v >= bus:
                amps = (bus - emf) / resistance
                drawn = amps
                slope = 1.0 / resistance
            elif v <= -bus:
                amps = (-bus - emf) / resistance
                drawn = -amps
                slope = 1.0 / resistance
            else:
                amps = (v - emf) / resistance
                drawn = v * amps / bus
                slope = -drawn / bus
            if amps > s.limit or amps < -s.limit:
                amps = within(amps, s.limit)
                drawn = (emf + amps * model.winding) * amps / bus
                slope = -drawn / bus
            if drawn > s.request.supply_limit or drawn < -s.request.supply_limit:
                drawn = within(drawn, s.request.supply_limit)
                slope = 0.0
            total += drawn * model.count
            rise += slope * model.count
        miss = source - b.model.resistance * total - bus
        if -1e-4 < miss < 1e-4:
            break
        steep = 1.0 + b.model.resistance * rise
        # Beyond the point of maximum power Newton's method diverges: halve the voltage until the requests saturate.
        if steep > 0.2:
            new = bus + miss / steep
        else:
            new = 0.5 * bus if miss < 0.0 else source
        bus = new if new > 0.0 else 0.5 * bus
        if bus < 1e-3:
            return 0.0
    return bus
