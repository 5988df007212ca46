"""Control laws and motion profiles of a motor controller.

A law is a closure over the gains of one slot. `build_plan` creates a law when the request kind, slot or configuration
changes, and the controller calls the law each step. Setpoints are attributes of `LoopState`, so changing a setpoint
does not rebuild the law. CTRE's simulation computes its loops when physics writes a sensor, and holds the output
until the next write. One call of a law therefore covers all loops since the last write: a profile advances in closed
form, and an integral applies the present error to all of those loops.

Measurements of CTRE's simulation show that a profile's setpoint moves every 10 ms and is constant between two moves.
The laws in this module move the setpoint 5, 15, 25 ms after a request, the mean of the possible phases of CTRE's ticks.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from phoenix6.signals import BridgeOutputValue, ControlModeValue
from phoenix6.spns.spn_value import SpnValue

from simcore.robotcode.emulator.emulated_device import LOOP, REQUESTS, Axis, RequestKind, Setting, Unit
from simcore.robotcode.emulator.output_stage import Bridge, Stage

__all__ = [
    "PROFILE_LOOPS",
    "REQ_BRAKE",
    "REQ_COAST",
    "ControlPlan",
    "Expo",
    "Gains",
    "Law",
    "LoopState",
    "Profile",
    "SCurve",
    "VelocityRamp",
    "build_plan",
    "limits_of",
]

_FULL_VOLTS = 12.0
"""Supply voltage of the ideal motor in Motion Magic Expo, independent of the battery voltage [V]."""
_Segment = tuple[float, float, float, float, float]
"""Profile segment: start time [s]; position, velocity and acceleration at the start; constant jerk."""


def _ramp(v0: float, a0: float, v1: float, limit: float, jerk: float) -> list[tuple[float, float, float]]:
    """Return the constant-jerk segments of a velocity change, as tuples (duration, initial acceleration, jerk).

    Args:
        v0: Velocity at the start.
        a0: Acceleration at the start.
        v1: Velocity at the end, where the acceleration is zero.
        limit: Largest acceleration, > 0.
        jerk: Largest jerk; 0 for no limit, with steps in the acceleration.
    """
    if jerk <= 0.0:
        return [(abs(v1 - v0) / limit, math.copysign(limit, v1 - v0), 0.0)] if v1 != v0 else []
    way = 1.0 if v1 >= v0 + 0.5 * a0 * abs(a0) / jerk else -1.0
    top = way * min(limit, math.sqrt(max(jerk * way * (v1 - v0) + 0.5 * a0 * a0, 0.0)))
    rise, fall = abs(top - a0) / jerk, abs(top) / jerk
    hold = (v1 - v0 - 0.5 * (a0 + top) * rise - 0.5 * top * fall) / top if top != 0.0 else 0.0
    return [(rise, a0, math.copysign(jerk, top - a0)), (max(hold, 0.0), top, 0.0), (fall, top, -way * jerk)]


def _distance(v0: float, pieces: list[tuple[float, float, float]]) -> tuple[float, float]:
    """Return the distance and the final velocity of constant-jerk segments that start at velocity `v0`."""
    p, v = 0.0, v0
    for t, a, j in pieces:
        p += t * (v + t * (0.5 * a + t * j / 6.0))
        v += t * (a + 0.5 * t * j)
    return p, v


class Profile:
    """Base class of all profiles, with the present setpoint and a plan of constant-jerk segments."""

    __slots__ = ("_key", "_pieces", "_t", "acc", "done", "p", "v")

    def __init__(self) -> None:
        self.p = self.v = self.acc = 0.0
        self.done = True
        """Whether the setpoint has reached the goal."""
        self._key: tuple[float, ...] | None = None
        self._pieces: list[_Segment] = []
        self._t = 0.0

    def start(self, position: float, velocity: float) -> None:
        """Move the setpoint to a position and velocity with zero acceleration, and discard the plan."""
        self.p, self.v, self.acc = position, velocity, 0.0
        self._key = None

    def _set_plan(self, pieces: list[tuple[float, float, float]]) -> None:
        """Replace the plan with segments (duration, initial acceleration, jerk) that start at the present setpoint."""
        t, p, v = 0.0, self.p, self.v
        self._pieces = []
        for duration, a, j in pieces:
            if duration > 0.0:
                self._pieces.append((t, p, v, a, j))
                p += duration * (v + duration * (0.5 * a + duration * j / 6.0))
                v += duration * (a + 0.5 * duration * j)
                t += duration
        self._pieces.append((t, p, v, 0.0, 0.0))
        self._t = 0.0

    def _follow(self, dt: float) -> None:
        """Advance the setpoint along the plan by dt [s], and update `done`."""
        pieces = self._pieces
        t = self._t = self._t + dt
        while len(pieces) > 1 and pieces[1][0] <= t:
            del pieces[0]
        start, p, v, a, j = pieces[0]
        s = t - start
        self.p = p + s * (v + s * (0.5 * a + s * j / 6.0))
        self.v = v + s * (a + 0.5 * s * j)
        self.acc = a + j * s
        self.done = len(pieces) == 1


class SCurve(Profile):
    """Position profile from any state to rest at a goal, with limited velocity, acceleration and jerk."""

    __slots__ = ()

    def advance(self, goal: float, cruise: float, acceleration: float, jerk: float, dt: float) -> None:
        """Advance the setpoint by dt [s] towards the goal.

        Args:
            goal: Final position, at rest.
            cruise: Largest velocity; 0 for no limit.
            acceleration: Largest acceleration; 0 to hold the present position.
            jerk: Largest jerk; 0 for a trapezoidal velocity profile.
            dt: Step [s].
        """
        key = (goal, cruise, acceleration, jerk)
        if key != self._key:
            self._plan(goal, abs(cruise) or math.inf, abs(acceleration), abs(jerk))
            self._key = key
        self._follow(dt)
        if self.done:
            self.p, self.v, self.acc = (goal, 0.0, 0.0) if acceleration else (self.p, 0.0, 0.0)

    def _plan(self, goal: float, cruise: float, limit: float, jerk: float) -> None:
        if limit == 0.0:
            self.v = 0.0
            self._set_plan([])
            return
        v0, a0 = self.v, self.acc if jerk else 0.0

        def through(peak: float) -> tuple[float, list[tuple[float, float, float]], list[tuple[float, float, float]]]:
            up, down = _ramp(v0, a0, peak, limit, jerk), _ramp(peak, 0.0, 0.0, limit, jerk)
            return _distance(v0, up)[0] + _distance(peak, down)[0], up, down

        way = goal - self.p
        sign = 1.0 if way >= through(0.0)[0] else -1.0
        # Upper bound of the peak velocity: full acceleration over the whole distance, from the present velocity.
        reach = abs(v0) + abs(a0) * limit / jerk if jerk else abs(v0)
        high = sign * min(cruise, reach + math.sqrt(4.0 * limit * abs(way) + 4.0 * reach * reach) + 1e-9)
        far, up, down = through(high)
        cruising = 0.0
        if (way - far) * sign >= 0.0:
            cruising = (way - far) / high if high else 0.0
            peak = high
        else:
            low = 0.0
            for _ in range(60):
                peak = 0.5 * (low + high)
                far, up, down = through(peak)
                if (way - far) * sign >= 0.0:
                    low = peak
                else:
                    high = peak
        self._set_plan([*up, (cruising, 0.0, 0.0), *down])


class VelocityRamp(Profile):
    """Profile of the velocity setpoint with limited acceleration and jerk. `p` is unused."""

    __slots__ = ()

    def advance(self, goal: float, acceleration: float, jerk: float, dt: float) -> None:
        """Advance the setpoint by dt [s] towards the goal velocity. An `acceleration` of 0 holds the setpoint."""
        key = (goal, acceleration, jerk)
        if key != self._key:
            limit = abs(acceleration)
            a0 = self.acc if jerk else 0.0
            self._set_plan(_ramp(self.v, a0, goal, limit, abs(jerk)) if limit else [])
            self._key = key
        self._follow(dt)
        if self.done and acceleration:
            self.v, self.acc = goal, 0.0


class Expo(Profile):
    """Position profile of an ideal motor: v' = (u - kV v) / kA, with u = 12 V to accelerate and -12 V to brake."""

    __slots__ = ("_legs",)

    def __init__(self) -> None:
        super().__init__()
        self._legs: list[tuple[float, float, float, float, float]] = []

    def advance(self, goal: float, kv: float, ka: float, cruise: float, dt: float) -> None:
        """Advance the setpoint by dt [s] towards the goal.

        Args:
            goal: Final position, at rest.
            kv: Voltage per unit of velocity.
            ka: Voltage per unit of acceleration.
            cruise: Largest velocity; 0 for the ideal motor's free speed.
            dt: Step [s].
        """
        key = (goal, kv, ka, cruise)
        if key != self._key:
            self._shape(goal, abs(kv), abs(ka), abs(cruise) or math.inf)
            self._key = key
        t = self._t = self._t + dt
        legs = self._legs
        while legs and legs[0][0] <= t:
            del legs[0]
        self.done = not legs
        if self.done:
            self.p, self.v, self.acc = goal, 0.0, 0.0
            return
        end, p1, v1, final, tau = legs[0]
        # Integrate backwards from the end of the leg, where position and velocity are known exactly.
        s = t - end
        if math.isinf(tau):
            self.acc = final
            self.v = v1 + final * s
            self.p = p1 + s * (v1 + 0.5 * final * s)
            return
        grown = math.expm1(-s / tau)
        self.v = v1 + (v1 - final) * grown
        self.p = p1 + final * s - (v1 - final) * tau * grown
        self.acc = (final - self.v) / tau

    def _shape(self, goal: float, kv: float, ka: float, cruise: float) -> None:
        kv, ka = max(kv, 1e-6), max(ka, 1e-6)
        tau, final = ka / kv, _FULL_VOLTS / kv
        cruise = min(cruise, final * (1.0 - 1e-9))

        def leg(v0: float, v1: float, end: float) -> tuple[float, float]:
            """Return the time and distance from v0 to v1 for a motor with the free speed `end`."""
            t = tau * math.log((v0 - end) / (v1 - end))
            return t, end * t + tau * (v0 - v1)

        v = max(min(self.v, 0.999999 * final), -0.999999 * final)
        rest = leg(v, 0.0, -math.copysign(final, v))[1] if v else 0.0
        way = 1.0 if goal - self.p >= rest else -1.0
        u, d = v * way, (goal - self.p) * way
        if u > cruise:
            peak, first = cruise, leg(u, cruise, -final)
            first_end = -final
        else:
            first_end = final
            low, high = max(u, 0.0), cruise
            peak = high
            if leg(u, peak, final)[1] + leg(peak, 0.0, -final)[1] > d:
                for _ in range(60):
                    peak = 0.5 * (low + high)
                    if leg(u, peak, final)[1] + leg(peak, 0.0, -final)[1] > d:
                        high = peak
                    else:
                        low = peak
            first = leg(u, peak, final)
        last = leg(peak, 0.0, -final)
        hold = max(d - first[1] - last[1], 0.0) / peak if peak > 1e-12 else 0.0
        t1 = first[0]
        t2 = t1 + hold
        t3 = t2 + last[0]
        braking = goal - way * last[1]
        self._legs = [
            (t1, braking - way * peak * hold, way * peak, way * first_end, tau),
            (t2, braking, way * peak, 0.0, math.inf),
            (t3, goal, 0.0, -way * final, tau),
        ]
        self._t = 0.0


_FIRST = (SpnValue.SLOT0_K_P.value, SpnValue.SLOT1_K_P.value, SpnValue.SLOT2_K_P.value)
_SIGN = (SpnValue.SLOT0_K_S_SIGN.value, SpnValue.SLOT1_K_S_SIGN.value, SpnValue.SLOT2_K_S_SIGN.value)
_OFFSET = (
    SpnValue.SLOT0_K_G_POS_OFFSET.value,
    SpnValue.SLOT1_K_G_POS_OFFSET.value,
    SpnValue.SLOT2_K_G_POS_OFFSET.value,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Gains:
    """Gains of one slot.

    The output unit is volts, duty cycle or amperes. The input unit is rotations, rotations/s or rotations/s^2.
    """

    kp: float = 0.0
    ki: float = 0.0
    kd: float = 0.0
    ks: float = 0.0
    kv: float = 0.0
    ka: float = 0.0
    kg: float = 0.0
    arm: bool = False
    """Whether kG is multiplied by the cosine of the position (arm) instead of being constant (elevator)."""
    sign_of_error: bool = False
    """Whether kS has the sign of the closed-loop error instead of the sign of the setpoint velocity."""
    kg_offset: float = 0.0
    """Offset added to the position before the cosine [rotations]."""


def gains_of(config: Mapping[int, Setting], slot: int) -> Gains:
    """Return the gains of slot 0, 1 or 2 in a controller's configuration."""
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
"""Number of control loops between two moves of a profile's setpoint."""
Law = Callable[[int], float]
"""Control law: a function that returns the output [V, duty cycle or A] for the control loops since the last call."""


@dataclass(slots=True)
class LoopState:
    """State of a motor controller's control loop, with robot code's sign of position, velocity and output."""

    pos: float = 0.0
    """Position of the configured sensor [mechanism rotations]."""
    vel: float = 0.0
    """Velocity of the configured sensor [mechanism rotations/s]."""
    acc: float = 0.0
    """Acceleration of the configured sensor [mechanism rotations/s^2]."""
    output: float = 0.0
    """Output of an open-loop request [V, duty cycle or A]."""
    goal_p: float = 0.0
    """Position setpoint [mechanism rotations]."""
    goal_v: float = 0.0
    """Velocity setpoint [mechanism rotations/s]."""
    goal_a: float = 0.0
    """Acceleration setpoint [mechanism rotations/s^2]."""
    feed_forward: float = 0.0
    """Feed-forward of the request [V, duty cycle or A]."""
    limits: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Limits of the profile: cruise velocity, acceleration and jerk; for Expo, cruise velocity, kV and kA."""
    integral: float = 0.0
    """Integral term of the output [V, duty cycle or A]."""
    pid_out: float = 0.0
    """Output of the control law [V, duty cycle or A]."""
    err: float = 0.0
    """Closed-loop error [mechanism rotations or rotations/s]."""
    derr: float = 0.0
    """Rate of change of the closed-loop error [mechanism rotations/s or rotations/s^2]."""
    ref: float = 0.0
    """Closed-loop reference: the present setpoint [mechanism rotations or rotations/s]."""
    slope: float = 0.0
    """Rate of change of the closed-loop reference [mechanism rotations/s or rotations/s^2]."""
    scurve: SCurve = field(default_factory=SCurve)
    expo: Expo = field(default_factory=Expo)
    velocity_ramp: VelocityRamp = field(default_factory=VelocityRamp)
    profile_loops: int = 0
    """Number of control loops since the profile's setpoint last moved."""

    def start(self) -> None:
        """Reset the integral and output, and restart all profiles at the present state, for a new request."""
        self.integral = self.pid_out = 0.0
        self.profile_loops = PROFILE_LOOPS // 2
        self.scurve.start(self.pos, self.vel)
        self.expo.start(self.pos, self.vel)
        self.velocity_ramp.start(0.0, self.vel)
        self.velocity_ramp.v = self.vel


def _sign(value: float) -> float:
    return 1.0 if value > 0.0 else (-1.0 if value < 0.0 else 0.0)


def _pid(m: LoopState, g: Gains, peaks: tuple[float, float], on_position: bool) -> Callable[..., float]:
    """Return a function that computes the sum of PID feedback and feed-forward.

    With `on_position` (position control), kS has the sign of the error if the gains select this sign.
    """
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
            # Anti-windup: outside the output range, the integral may only shrink.
            if low < out + m.integral < high or step * m.integral < 0.0:
                m.integral = min(max(m.integral + step, low), high)
            out += m.integral
        if ks:
            out += ks * _sign(error if on_error else v_ref)
        if kg:
            out += kg * math.cos(math.tau * (m.pos + offset)) if arm else kg
        return out

    return pid


def position_law(m: LoopState, gains: Gains, peaks: tuple[float, float], wrap: bool) -> Law:
    """Return the law of position control. `wrap` limits the error to half a rotation in either direction."""
    pid = _pid(m, gains, peaks, True)

    def law(loops: int) -> float:
        m.ref = m.goal_p
        error = m.goal_p - m.pos
        if wrap:
            error -= math.floor(error + 0.5)
        m.slope = v = m.goal_v
        return pid(error, v - m.vel, v, 0.0, loops)

    return law


def velocity_law(m: LoopState, gains: Gains, peaks: tuple[float, float]) -> Law:
    """Return the law of velocity control, with the acceleration setpoint as feed-forward."""
    pid = _pid(m, gains, peaks, False)

    def law(loops: int) -> float:
        m.ref = v = m.goal_v
        m.slope = a = m.goal_a
        return pid(v - m.vel, a - m.acc, v, a, loops)

    return law


def _follow_profile(m: LoopState, pid: Callable[..., float], profile: SCurve | Expo, wrap: bool, loops: int) -> float:
    """Return the output that tracks the setpoint of a position profile."""
    m.ref = profile.p
    m.slope = v = profile.v
    error = profile.p - m.pos
    if wrap:
        error -= math.floor(error + 0.5)
    return pid(error, v - m.vel, v, profile.acc, loops)


def _elapsed(m: LoopState, loops: int) -> float:
    """Count control loops, and return the time by which the profile's setpoint advances now [s]; 0 for no move."""
    elapsed = m.profile_loops + loops
    moves, m.profile_loops = divmod(elapsed, PROFILE_LOOPS)
    return moves * (PROFILE_LOOPS * LOOP)


def _shift_to_nearest(profile: SCurve | Expo, goal: float) -> None:
    """Restart the profile with the setpoint shifted by whole turns if the goal is more than half a turn away."""
    turns = math.floor(goal - profile.p + 0.5)
    if turns:
        profile.start(profile.p + turns, profile.v)


def _profiled(
    m: LoopState,
    gains: Gains,
    peaks: tuple[float, float],
    wrap: bool,
    profile: SCurve | Expo,
    advance: Callable[[float], None],
) -> Law:
    """Return the law of position control along a profile. `advance` advances the profile by a time [s]."""
    pid = _pid(m, gains, peaks, True)

    def law(loops: int) -> float:
        dt = _elapsed(m, loops)
        if dt:
            if wrap:
                _shift_to_nearest(profile, m.goal_p)
            advance(dt)
        return _follow_profile(m, pid, profile, wrap, loops)

    return law


def motion_magic_law(m: LoopState, gains: Gains, peaks: tuple[float, float], wrap: bool, profile: SCurve) -> Law:
    """Return the law of Motion Magic: position control along a profile with limited velocity, acceleration and jerk."""

    def advance(dt: float) -> None:
        cruise, acceleration, jerk = m.limits
        profile.advance(m.goal_p, cruise, acceleration, jerk, dt)

    return _profiled(m, gains, peaks, wrap, profile, advance)


def motion_magic_expo_law(m: LoopState, gains: Gains, peaks: tuple[float, float], wrap: bool, profile: Expo) -> Law:
    """Return the law of Motion Magic Expo: position control along the profile of an ideal motor at 12 V."""

    def advance(dt: float) -> None:
        cruise, kv, ka = m.limits
        profile.advance(m.goal_p, kv, ka, cruise, dt)

    return _profiled(m, gains, peaks, wrap, profile, advance)


def motion_magic_velocity_law(m: LoopState, gains: Gains, peaks: tuple[float, float], profile: VelocityRamp) -> Law:
    """Return the law of Motion Magic Velocity: velocity control along a ramp with limited acceleration and jerk."""
    pid = _pid(m, gains, peaks, False)

    def law(loops: int) -> float:
        dt = _elapsed(m, loops)
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
"""Bridge states (`BridgeOutputValue`) that `get_bridge_output` reports."""


@dataclass(frozen=True, slots=True)
class ControlPlan:
    """Control law and output stage of a request, and the values that status frames report for the request."""

    law: Law | None
    """Control law; None if the bridge coasts, brakes or follows."""
    stage: Stage | None
    """Output stage for the control law; None without a law."""
    gains: Gains
    profile: Profile | None
    """Motion Magic profile; None for other requests."""
    mode: int
    """Reported control mode (`ControlModeValue`)."""
    drives: int
    """Reported bridge state (`BridgeOutputValue`) while the bridge is not neutral."""
    unit_number: int
    """Unit of the closed-loop output: 0 duty cycle, 1 volts, 2 amperes."""
    on_velocity: bool
    """Whether the loop controls velocity."""


_OUTPUTLESS = frozenset((Axis.NEUTRAL, Axis.BRAKE, Axis.COAST, Axis.MUSIC, Axis.FOLLOW))


def build_plan(
    loop: LoopState, bridge: Bridge, config: Mapping[int, Setting], kind: RequestKind, slot: int, foc: bool
) -> ControlPlan:
    """Build the control law, output stage and status values of a request.

    Raises:
        NotImplementedError: The slot uses gain scheduling.
    """
    law, stage, gains = _law_and_stage(loop, bridge, config, kind, slot, foc)
    torque = kind.unit is Unit.AMPERES
    profiles: dict[Axis, Profile] = {
        Axis.MOTION_MAGIC: loop.scurve,
        Axis.MOTION_MAGIC_EXPO: loop.expo,
        Axis.MOTION_MAGIC_VELOCITY: loop.velocity_ramp,
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
    )


def _law_and_stage(
    loop: LoopState, bridge: Bridge, c: Mapping[int, Setting], kind: RequestKind, slot: int, foc: bool
) -> tuple[Law | None, Stage | None, Gains]:
    axis = kind.axis
    if axis in _OUTPUTLESS:
        return None, None, Gains()
    stage = bridge.stage(kind.unit, closed=axis is not Axis.OPEN, foc=foc)
    if axis is Axis.OPEN:
        return (lambda loops: loop.output), stage, Gains()
    if c[SpnValue.SLOT0_GAIN_SCHED_BEHAVIOR.value + slot]:
        raise NotImplementedError(f"gain scheduling (slot{slot}) is not modelled in simulated time")
    gains = gains_of(c, slot)
    peaks = bridge.peaks[kind.unit]
    wrap = bool(c[SpnValue.CONFIG_CONTINUOUS_WRAP.value])
    if axis is Axis.POSITION:
        return position_law(loop, gains, peaks, wrap), stage, gains
    if axis is Axis.VELOCITY:
        return velocity_law(loop, gains, peaks), stage, gains
    if axis is Axis.MOTION_MAGIC:
        return motion_magic_law(loop, gains, peaks, wrap, loop.scurve), stage, gains
    if axis is Axis.MOTION_MAGIC_EXPO:
        return motion_magic_expo_law(loop, gains, peaks, wrap, loop.expo), stage, gains
    return motion_magic_velocity_law(loop, gains, peaks, loop.velocity_ramp), stage, gains


def limits_of(config: Mapping[int, Setting], kind: RequestKind, args: tuple[float, ...]) -> tuple[float, float, float]:
    """Return the `LoopState.limits` of a profile request.

    A value in the request takes precedence over the value in the configuration.
    """
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
