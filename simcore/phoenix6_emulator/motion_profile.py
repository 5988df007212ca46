"""Motion profiles of a controller: the setpoint that moves from where it is to a goal, in closed form.

CTRE's simulation computes its loops when physics writes a sensor; so one call stands for all loops since the last
write, and a profile is advanced by all of them at once.
"""

from __future__ import annotations

import math

__all__ = ["Expo", "Profile", "SCurve", "VelocityRamp"]

_FULL_VOLTS = 12.0
"""What Motion Magic Expo takes for the voltage there is, whatever the battery has [V]."""
_Segment = tuple[float, float, float, float, float]
"""Start [s] and there position, velocity, acceleration; jerk after it."""


def _ramp(v0: float, a0: float, v1: float, limit: float, jerk: float) -> list[tuple[float, float, float]]:
    """From (v0, a0) to (v1, 0): pieces of (duration, acceleration at their start, jerk).

    Args:
        v0: Velocity at the start.
        a0: Acceleration at the start.
        v1: Velocity at the end.
        limit: Greatest acceleration, > 0.
        jerk: Greatest jerk; 0 for none, so that the acceleration jumps.
    """
    if jerk <= 0.0:
        return [(abs(v1 - v0) / limit, math.copysign(limit, v1 - v0), 0.0)] if v1 != v0 else []
    way = 1.0 if v1 >= v0 + 0.5 * a0 * abs(a0) / jerk else -1.0
    top = way * min(limit, math.sqrt(max(jerk * way * (v1 - v0) + 0.5 * a0 * a0, 0.0)))
    rise, fall = abs(top - a0) / jerk, abs(top) / jerk
    hold = (v1 - v0 - 0.5 * (a0 + top) * rise - 0.5 * top * fall) / top if top != 0.0 else 0.0
    return [(rise, a0, math.copysign(jerk, top - a0)), (max(hold, 0.0), top, 0.0), (fall, top, -way * jerk)]


def _distance(v0: float, pieces: list[tuple[float, float, float]]) -> tuple[float, float]:
    """How far and to which velocity the pieces lead."""
    p, v = 0.0, v0
    for t, a, j in pieces:
        p += t * (v + t * (0.5 * a + t * j / 6.0))
        v += t * (a + 0.5 * t * j)
    return p, v


class Profile:
    """What all profiles share: the state of the setpoint, and the plan as pieces of constant jerk."""

    __slots__ = ("_key", "_pieces", "_t", "acc", "done", "p", "v")

    def __init__(self) -> None:
        self.p = self.v = self.acc = 0.0
        self.done = True
        """Whether the setpoint has reached its goal."""
        self._key: tuple[float, ...] | None = None
        self._pieces: list[_Segment] = []
        self._t = 0.0

    def start(self, position: float, velocity: float) -> None:
        """Begin anew from this state."""
        self.p, self.v, self.acc = position, velocity, 0.0
        self._key = None

    def _lay(self, pieces: list[tuple[float, float, float]]) -> None:
        """Keep a plan that begins at the present state."""
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
        """Move along the plan."""
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
    """Reference that moves to a goal at rest with limited velocity, acceleration and jerk, from any state."""

    __slots__ = ()

    def advance(self, goal: float, cruise: float, acceleration: float, jerk: float, dt: float) -> None:
        """Move on by dt [s] towards the goal.

        Args:
            goal: Position to come to rest at.
            cruise: Greatest velocity; 0 for no limit.
            acceleration: Greatest acceleration; 0 lets the setpoint stand still.
            jerk: Greatest jerk; 0 for a trapezoid.
            dt: [s]
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
            self._lay([])
            return
        v0, a0 = self.v, self.acc if jerk else 0.0

        def through(peak: float) -> tuple[float, list[tuple[float, float, float]], list[tuple[float, float, float]]]:
            up, down = _ramp(v0, a0, peak, limit, jerk), _ramp(peak, 0.0, 0.0, limit, jerk)
            return _distance(v0, up)[0] + _distance(peak, down)[0], up, down

        way = goal - self.p
        sign = 1.0 if way >= through(0.0)[0] else -1.0
        # A velocity that is surely enough: all the way at full acceleration, from the present velocity.
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
        self._lay([*up, (cruising, 0.0, 0.0), *down])


class VelocityRamp(Profile):
    """Reference velocity that moves to a goal with limited acceleration and jerk; `p` has no meaning."""

    __slots__ = ()

    def advance(self, goal: float, acceleration: float, jerk: float, dt: float) -> None:
        """Move on by dt [s] towards the goal velocity; acceleration 0 lets it stay."""
        key = (goal, acceleration, jerk)
        if key != self._key:
            limit = abs(acceleration)
            a0 = self.acc if jerk else 0.0
            self._lay(_ramp(self.v, a0, goal, limit, abs(jerk)) if limit else [])
            self._key = key
        self._follow(dt)
        if self.done and acceleration:
            self.v, self.acc = goal, 0.0


class Expo(Profile):
    """Reference of a motor with 12 V: v' = (u - kV v) / kA with u = 12 V first and -12 V to brake."""

    __slots__ = ("_legs",)

    def __init__(self) -> None:
        super().__init__()
        self._legs: list[tuple[float, float, float, float, float]] = []

    def advance(self, goal: float, kv: float, ka: float, cruise: float, dt: float) -> None:
        """Move on by dt [s] towards the goal.

        Args:
            goal: Position to come to rest at.
            kv: Volts per velocity.
            ka: Volts per acceleration; with both 0 the setpoint stands still.
            cruise: Greatest velocity; 0 for no limit but the motor's.
            dt: [s]
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
        # Backwards from the end of the leg, where position and velocity are known exactly.
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
            """Time and way from v0 to v1 while the motor makes for the velocity `end`."""
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
