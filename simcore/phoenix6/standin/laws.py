"""Control laws: what a controller asks of its bridge, as closures over the gains of one slot.

A closure is built when request kind, slot or configuration change, and called each step; set points live in the
`Setpoint` of the controller, so a new number costs nothing. Between two writes of physics a device measures the same,
so one call stands for several loops: integrals and profiles are advanced by their closed forms.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from simcore.phoenix6.standin.clock import LOOP
from simcore.phoenix6.standin.gains import Gains
from simcore.phoenix6.standin.profile import Trapezoid

__all__ = ["Controller", "Law", "motion_magic", "open_loop", "position", "velocity"]

Law = Callable[[int], float]
"""Output of the law after this many control loops [V, duty cycle or A]."""


class Controller(Protocol):
    """What a law reads of a controller and writes to it; positions in mechanism rotations, robot code's signs."""

    pos: float
    vel: float
    acc: float
    output: float
    goal_p: float
    goal_v: float
    goal_a: float
    feed_forward: float
    integral: float
    err: float
    derr: float
    ref_p: float
    ref_v: float
    ref_a: float


def _sign(value: float) -> float:
    return 1.0 if value > 0.0 else (-1.0 if value < 0.0 else 0.0)


def _pid(m: Controller, g: Gains) -> Callable[[float, float, float, float, int], float]:
    """The sum of feedback and feed-forward, for any axis."""
    kp, ki, kd, ks, kv, ka, kg = g.kp, g.ki, g.kd, g.ks, g.kv, g.ka, g.kg
    arm, on_error, offset = g.arm, g.sign_of_error, g.kg_offset
    plain = ki == 0.0 and ks == 0.0 and kg == 0.0

    def pid(error: float, slope: float, v_ref: float, a_ref: float, loops: int) -> float:
        m.err = error
        m.derr = slope
        out = kp * error + kd * slope + kv * v_ref + ka * a_ref + m.feed_forward
        if plain:
            return out
        if ki:
            m.integral += ki * error * loops * LOOP
            out += m.integral
        if ks:
            out += ks * _sign(error if on_error else v_ref)
        if kg:
            out += kg * math.cos(math.tau * (m.pos + offset)) if arm else kg
        return out

    return pid


def open_loop(m: Controller) -> Law:
    """The output of the request itself."""

    def law(loops: int) -> float:
        return m.output

    return law


def position(m: Controller, gains: Gains, wrap: bool) -> Law:
    """Position control; with `wrap` the short way round."""
    pid = _pid(m, gains)

    def law(loops: int) -> float:
        error = m.goal_p - m.pos
        if wrap:
            error -= math.floor(error + 0.5)
        m.ref_p = m.goal_p
        m.ref_v = v = m.goal_v
        return pid(error, v - m.vel, v, 0.0, loops)

    return law


def velocity(m: Controller, gains: Gains) -> Law:
    """Velocity control."""
    pid = _pid(m, gains)

    def law(loops: int) -> float:
        m.ref_v = v = m.goal_v
        m.ref_a = a = m.goal_a
        return pid(v - m.vel, a - m.acc, v, a, loops)

    return law


def motion_magic(
    m: Controller, gains: Gains, wrap: bool, profile: Trapezoid, cruise: float, acceleration: float
) -> Law:
    """Position control along a trapezoidal profile."""
    pid = _pid(m, gains)

    def law(loops: int) -> float:
        profile.advance(m.goal_p, cruise, acceleration, loops * LOOP)
        m.ref_p = p = profile.p
        m.ref_v = v = profile.v
        m.ref_a = profile.acc
        error = p - m.pos
        if wrap:
            error -= math.floor(error + 0.5)
        return pid(error, v - m.vel, v, profile.acc, loops)

    return law
