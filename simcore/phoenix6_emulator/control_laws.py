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
from typing import TYPE_CHECKING

from phoenix6.signals import BridgeOutputValue, ControlModeValue
from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.control_requests import REQUESTS, Axis, RequestKind, Unit
from simcore.phoenix6_emulator.emulated_device import LOOP, Setting
from simcore.phoenix6_emulator.motion_profile import Expo, Profile, SCurve, VelocityRamp
from simcore.phoenix6_emulator.output_stage import Stage

if TYPE_CHECKING:
    from simcore.phoenix6_emulator.emulated_talon import EmulatedTalon

__all__ = [
    "PROFILE_LOOPS",
    "REQ_BRAKE",
    "REQ_COAST",
    "REQ_FOC",
    "REQ_TORQUE",
    "REQ_TRAPEZOIDAL",
    "ControlPlan",
    "Gains",
    "Law",
    "build_plan",
    "gains_of",
    "limits_of",
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


def _sign(value: float) -> float:
    return 1.0 if value > 0.0 else (-1.0 if value < 0.0 else 0.0)


def _pid(m: EmulatedTalon, g: Gains, peaks: tuple[float, float], on_position: bool) -> Callable[..., float]:
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


def position_law(m: EmulatedTalon, gains: Gains, peaks: tuple[float, float], wrap: bool) -> Law:
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


def velocity_law(m: EmulatedTalon, gains: Gains, peaks: tuple[float, float]) -> Law:
    """Velocity control."""
    pid = _pid(m, gains, peaks, False)

    def law(loops: int) -> float:
        m.ref = v = m.goal_v
        m.slope = a = m.goal_a
        return pid(v - m.vel, a - m.acc, v, a, loops)

    return law


def _along(m: EmulatedTalon, pid: Callable[..., float], profile: SCurve | Expo, wrap: bool, loops: int) -> float:
    """Feedback towards the setpoint of a position profile."""
    m.ref = profile.p
    m.slope = v = profile.v
    error = profile.p - m.pos
    if wrap:
        error -= math.floor(error + 0.5)
    return pid(error, v - m.vel, v, profile.acc, loops)


def _moves(m: EmulatedTalon, loops: int) -> float:
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
    m: EmulatedTalon,
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


def motion_magic_law(m: EmulatedTalon, gains: Gains, peaks: tuple[float, float], wrap: bool, profile: SCurve) -> Law:
    """Position control along a profile with limited velocity, acceleration and jerk."""

    def advance(dt: float) -> None:
        cruise, acceleration, jerk = m.limits
        profile.advance(m.goal_p, cruise, acceleration, jerk, dt)

    return _profiled(m, gains, peaks, wrap, profile, advance)


def motion_magic_expo_law(m: EmulatedTalon, gains: Gains, peaks: tuple[float, float], wrap: bool, profile: Expo) -> Law:
    """Position control along the profile of a motor with 12 V."""

    def advance(dt: float) -> None:
        cruise, kv, ka = m.limits
        profile.advance(m.goal_p, kv, ka, cruise, dt)

    return _profiled(m, gains, peaks, wrap, profile, advance)


def motion_magic_velocity_law(m: EmulatedTalon, gains: Gains, peaks: tuple[float, float], profile: VelocityRamp) -> Law:
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


REQ_COAST, REQ_BRAKE, REQ_TRAPEZOIDAL, REQ_TORQUE, REQ_FOC = (
    int(BridgeOutputValue[f"BRIDGE_REQ_{name}"].value)
    for name in ("COAST", "BRAKE", "TRAPEZ", "FOC_TORQUE", "FOC_EASY")
)
"""What a bridge does, as `get_bridge_output` reads."""


@dataclass(frozen=True, slots=True)
class ControlPlan:
    """Law and output stage, and what status frames say of them."""

    law: Law | None
    """None: the bridge coasts, brakes or follows."""
    stage: Stage | None
    """Output stage of the law."""
    gains: Gains
    profile: Profile | None
    """What Motion Magic moves along."""
    mode: int
    """`ControlModeValue`."""
    drives: int
    """`BridgeOutputValue` of a bridge that is not neutral."""
    unit_number: int
    """0 to 2: number of the unit of the loop's output, after that of the duty cycle."""
    on_velocity: bool
    """Whether a velocity is controlled."""
    reads_sensor: bool
    """Whether the law reads a sensor."""
    has_memory: bool
    """Whether the output depends on what was before: an integral, a ramp."""


_OUTPUTLESS = frozenset((Axis.NEUTRAL, Axis.BRAKE, Axis.COAST, Axis.MUSIC, Axis.FOLLOW))


def build_plan(talon: EmulatedTalon, kind: RequestKind, slot: int, foc: bool) -> ControlPlan:
    """Law, output stage and status of a request.

    Raises:
        NotImplementedError: The slot schedules its gains.
    """
    law, stage, gains = _law_and_stage(talon, kind, slot, foc)
    torque = kind.unit is Unit.AMPERES
    profiles: dict[Axis, Profile] = {
        Axis.MOTION_MAGIC: talon.scurve,
        Axis.MOTION_MAGIC_EXPO: talon.expo,
        Axis.MOTION_MAGIC_VELOCITY: talon.velocity_ramp,
    }
    return ControlPlan(
        law,
        stage,
        gains,
        profile=profiles.get(kind.axis),
        mode=0 if kind is REQUESTS["Empty"] else int(ControlModeValue[kind.mode(foc)].value),
        drives=REQ_TORQUE if torque else (REQ_FOC if foc else REQ_TRAPEZOIDAL),
        unit_number=(Unit.DUTY, Unit.VOLTS, Unit.AMPERES).index(kind.unit),
        on_velocity=kind.axis in (Axis.VELOCITY, Axis.MOTION_MAGIC_VELOCITY),
        reads_sensor=law is not None and kind.axis is not Axis.OPEN,
        has_memory=gains.ki != 0.0 or talon.bridge.has_ramp,
    )


def _law_and_stage(
    talon: EmulatedTalon, kind: RequestKind, slot: int, foc: bool
) -> tuple[Law | None, Stage | None, Gains]:
    axis = kind.axis
    if axis in _OUTPUTLESS:
        return None, None, Gains()
    c = talon.config
    stage = talon.bridge.stage(kind.unit, closed=axis is not Axis.OPEN, foc=foc)
    if axis is Axis.OPEN:
        return (lambda loops: talon.output), stage, Gains()
    if c[SpnValue.SLOT0_GAIN_SCHED_BEHAVIOR.value + slot]:
        raise NotImplementedError(f"{talon!r}: gain scheduling (slot{slot}) is not modelled in simulated time")
    gains = gains_of(c, slot)
    peaks = talon.bridge.peaks[kind.unit]
    wrap = bool(c[SpnValue.CONFIG_CONTINUOUS_WRAP.value])
    if axis is Axis.POSITION:
        return position_law(talon, gains, peaks, wrap), stage, gains
    if axis is Axis.VELOCITY:
        return velocity_law(talon, gains, peaks), stage, gains
    if axis is Axis.MOTION_MAGIC:
        return motion_magic_law(talon, gains, peaks, wrap, talon.scurve), stage, gains
    if axis is Axis.MOTION_MAGIC_EXPO:
        return motion_magic_expo_law(talon, gains, peaks, wrap, talon.expo), stage, gains
    return motion_magic_velocity_law(talon, gains, peaks, talon.velocity_ramp), stage, gains


def limits_of(config: Mapping[int, Setting], kind: RequestKind, args: tuple[float, ...]) -> tuple[float, float, float]:
    """Limits of the profile of a request, from the request itself (Dynamic) or from the configuration."""
    c = config
    field = kind.slots
    dynamic = kind.name.startswith("Dynamic")
    cruise = c[SpnValue.CONFIG_MOTION_MAGIC_CRUISE_VELOCITY.value]
    if kind.axis is Axis.MOTION_MAGIC_EXPO:
        if dynamic:
            return args[field["velocity"]], args[field["k_v"]], args[field["k_a"]]
        kv = c[SpnValue.CONFIG_MOTION_MAGIC_EXPO_K_V.value]
        return cruise, kv, c[SpnValue.CONFIG_MOTION_MAGIC_EXPO_K_A.value]
    acceleration = c[SpnValue.CONFIG_MOTION_MAGIC_ACCELERATION.value]
    jerk = c[SpnValue.CONFIG_MOTION_MAGIC_JERK.value]
    if dynamic:
        return args[field["velocity"]], args[field["acceleration"]], args[field["jerk"]]
    if kind.axis is Axis.MOTION_MAGIC_VELOCITY:
        return cruise, args[field["acceleration"]] or acceleration, jerk
    return cruise, acceleration, jerk
