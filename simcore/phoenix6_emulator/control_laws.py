"""Control laws: the output that a controller passes to its bridge, as closures over the gains of one slot.

A closure is built when request kind, slot or configuration change, and called each step; set points are attributes of
the controller, so a new number costs nothing. CTRE's simulation computes its loops when physics writes a sensor, and
holds their output between two writes; so here one call stands for all loops since the last write: a profile is advanced
by its closed form, an integral takes the present error for all of them.

The setpoint of a profile moves every 10 ms and holds in between, as measured; here 5, 15, 25 ms after a request, the
mean of wherever CTRE's ticks may fall.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.config_text import Setting
from simcore.phoenix6_emulator.device_clock import LOOP
from simcore.phoenix6_emulator.motion_profile import Expo, SCurve, VelocityRamp

__all__ = [
    "PROFILE_LOOPS",
    "ControlState",
    "Gains",
    "Law",
    "gains_of",
    "motion_magic",
    "motion_magic_expo",
    "motion_magic_velocity",
    "position",
    "velocity",
]

_FIRST = (SpnValue.SLOT0_K_P.value, SpnValue.SLOT1_K_P.value, SpnValue.SLOT2_K_P.value)
_SIGN = (SpnValue.SLOT0_K_S_SIGN.value, SpnValue.SLOT1_K_S_SIGN.value, SpnValue.SLOT2_K_S_SIGN.value)
_OFFSET = (
    SpnValue.SLOT0_K_G_POS_OFFSET.value,
    SpnValue.SLOT1_K_G_POS_OFFSET.value,
    SpnValue.SLOT2_K_G_POS_OFFSET.value,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Gains:
    """Gains of one slot, in the unit of the request (volts, duty cycle or amperes) per rotation and its rates."""

    kp: float = 0.0
    ki: float = 0.0
    kd: float = 0.0
    ks: float = 0.0
    kv: float = 0.0
    ka: float = 0.0
    kg: float = 0.0
    arm: bool = False
    """Whether kG is multiplied by the cosine of the position (an arm) and is not constant (an elevator)."""
    sign_of_error: bool = False
    """Whether kS has the sign of the closed-loop error and not that of the setpoint velocity."""
    kg_offset: float = 0.0
    """Added to the position before its cosine is taken [rotations]."""


def gains_of(config: Mapping[int, Setting], slot: int) -> Gains:
    """Gains of slot 0, 1 or 2."""
    first = _FIRST[slot]
    p, i, d, s, v, a, g, kind = (config[first + k] for k in range(8))
    return Gains(
        kp=p,
        ki=i,
        kd=d,
        ks=s,
        kv=v,
        ka=a,
        kg=g,
        arm=kind == 1,
        sign_of_error=config[_SIGN[slot]] == 1,
        kg_offset=config[_OFFSET[slot]],
    )


PROFILE_LOOPS = 10
"""Control loops from one move of a profile's reference to the next."""
Law = Callable[[int], float]
"""Output of the law after this many control loops [V, duty cycle or A]."""


class ControlState(Protocol):
    """What a law reads and writes of a controller; positions in mechanism rotations, robot code's signs."""

    pos: float
    """Measured."""
    vel: float
    acc: float
    goal_p: float
    """Set point of the request."""
    goal_v: float
    goal_a: float
    feed_forward: float
    profile_loops: int
    """Control loops since the profile's reference last moved."""
    limits: tuple[float, float, float]
    """Limits of the profile: cruise velocity, acceleration and jerk, or cruise velocity, kV and kA."""
    integral: float
    """Integral part of the output."""
    err: float
    """Error of the loop, and its rate."""
    derr: float
    ref: float
    """What the loop follows, and its rate."""
    slope: float


def _sign(value: float) -> float:
    return 1.0 if value > 0.0 else (-1.0 if value < 0.0 else 0.0)


def _pid(m: ControlState, g: Gains, peaks: tuple[float, float], on_position: bool) -> Callable[..., float]:
    """The sum of feedback and feed-forward; kS can follow the error only where a position is controlled."""
    kp, ki, kd, ks, kv, ka, kg = g.kp, g.ki, g.kd, g.ks, g.kv, g.ka, g.kg
    arm, offset = g.arm, g.kg_offset
    on_error = g.sign_of_error and on_position
    plain = ki == 0.0 and ks == 0.0 and kg == 0.0
    high, low = peaks

    def pid(error: float, slope: float, v_ref: float, a_ref: float, loops: int) -> float:
        m.err = error
        m.derr = slope
        out = kp * error + kd * slope + kv * v_ref + ka * a_ref + m.feed_forward
        if plain:
            return out
        if ki:
            step = ki * error * loops * LOOP
            # No winding up: past the greatest output the integral only comes back.
            if low < out + m.integral < high or step * m.integral < 0.0:
                m.integral = min(max(m.integral + step, low), high)
            out += m.integral
        if ks:
            out += ks * _sign(error if on_error else v_ref)
        if kg:
            out += kg * math.cos(math.tau * (m.pos + offset)) if arm else kg
        return out

    return pid


def position(m: ControlState, gains: Gains, peaks: tuple[float, float], wrap: bool) -> Law:
    """Position control; with `wrap` the short way round."""
    pid = _pid(m, gains, peaks, True)

    def law(loops: int) -> float:
        m.ref = m.goal_p
        error = m.goal_p - m.pos
        if wrap:
            error -= math.floor(error + 0.5)
        m.slope = v = m.goal_v
        return pid(error, v - m.vel, v, 0.0, loops)

    return law


def velocity(m: ControlState, gains: Gains, peaks: tuple[float, float]) -> Law:
    """Velocity control."""
    pid = _pid(m, gains, peaks, False)

    def law(loops: int) -> float:
        m.ref = v = m.goal_v
        m.slope = a = m.goal_a
        return pid(v - m.vel, a - m.acc, v, a, loops)

    return law


def _along(m: ControlState, pid: Callable[..., float], profile: SCurve | Expo, wrap: bool, loops: int) -> float:
    """Feedback towards the setpoint of a position profile."""
    m.ref = profile.p
    m.slope = v = profile.v
    error = profile.p - m.pos
    if wrap:
        error -= math.floor(error + 0.5)
    return pid(error, v - m.vel, v, profile.acc, loops)


def _moves(m: ControlState, loops: int) -> float:
    """Time by which the setpoint of a profile moves on now; 0 where it holds [s]."""
    elapsed = m.profile_loops + loops
    moves, m.profile_loops = divmod(elapsed, PROFILE_LOOPS)
    return moves * (PROFILE_LOOPS * LOOP)


def _near(profile: SCurve | Expo, goal: float) -> None:
    """Move the setpoint by whole turns to the one nearest to the goal."""
    turns = math.floor(goal - profile.p + 0.5)
    if turns:
        profile.start(profile.p + turns, profile.v)


def _profiled(
    m: ControlState,
    gains: Gains,
    peaks: tuple[float, float],
    wrap: bool,
    profile: SCurve | Expo,
    advance: Callable[[float], None],
) -> Law:
    """Position control along a profile, which `advance` moves on by a time [s]."""
    pid = _pid(m, gains, peaks, True)

    def law(loops: int) -> float:
        dt = _moves(m, loops)
        if dt:
            if wrap:
                _near(profile, m.goal_p)
            advance(dt)
        return _along(m, pid, profile, wrap, loops)

    return law


def motion_magic(m: ControlState, gains: Gains, peaks: tuple[float, float], wrap: bool, profile: SCurve) -> Law:
    """Position control along a profile with limited velocity, acceleration and jerk."""

    def advance(dt: float) -> None:
        cruise, acceleration, jerk = m.limits
        profile.advance(m.goal_p, cruise, acceleration, jerk, dt)

    return _profiled(m, gains, peaks, wrap, profile, advance)


def motion_magic_expo(m: ControlState, gains: Gains, peaks: tuple[float, float], wrap: bool, profile: Expo) -> Law:
    """Position control along the profile of a motor with 12 V."""

    def advance(dt: float) -> None:
        cruise, kv, ka = m.limits
        profile.advance(m.goal_p, kv, ka, cruise, dt)

    return _profiled(m, gains, peaks, wrap, profile, advance)


def motion_magic_velocity(m: ControlState, gains: Gains, peaks: tuple[float, float], profile: VelocityRamp) -> Law:
    """Velocity control along a ramp with limited acceleration and jerk."""
    pid = _pid(m, gains, peaks, False)

    def law(loops: int) -> float:
        dt = _moves(m, loops)
        if dt:
            _, acceleration, jerk = m.limits
            profile.advance(m.goal_v, acceleration, jerk, dt)
        m.ref = v = profile.v
        m.slope = a = profile.acc
        return pid(v - m.vel, a - m.acc, v, a, loops)

    return law
