"""Motion profiles as closed forms of time: how the reference of Motion Magic moves towards its goal."""

from __future__ import annotations

import math

__all__ = ["Trapezoid"]


class Trapezoid:
    """Reference that moves to a goal with limited velocity and acceleration, from any state.

    Source: the time-optimal motion with bounded acceleration: it speeds up, cruises and brakes; when it cannot stop
    before the goal it brakes first, passes it and comes back.
    """

    __slots__ = ("_a", "_area", "_goal", "_key", "_p0", "_t", "_t1", "_t2", "_t3", "_v0", "_vc", "p", "v", "acc")

    def __init__(self) -> None:
        self.p = self.v = self.acc = 0.0
        self._key: tuple[float, float, float] | None = None

    def start(self, position: float, velocity: float) -> None:
        """Begin anew from this state."""
        self.p, self.v, self.acc = position, velocity, 0.0
        self._key = None

    def advance(self, goal: float, cruise: float, acceleration: float, dt: float) -> None:
        """Move on by dt [s] towards the goal; a change of goal or limits plans anew from where it is."""
        key = (goal, cruise, acceleration)
        if key != self._key:
            self._plan(goal, cruise, acceleration)
            self._key = key
        t = self._t = self._t + dt
        a = self._a
        if t >= self._t3:
            self.p, self.v, self.acc = goal, 0.0, 0.0
        elif t > self._t2:
            left = self._t3 - t
            self.p, self.v, self.acc = goal - 0.5 * a * left * left, a * left, -a
        elif t > self._t1:
            self.p = self._area + self._vc * (t - self._t1)
            self.v, self.acc = self._vc, 0.0
        else:
            rate = a if self._vc >= self._v0 else -a
            if a < 0.0:
                rate = a if self._vc <= self._v0 else -a
            self.p = self._p0 + self._v0 * t + 0.5 * rate * t * t
            self.v, self.acc = self._v0 + rate * t, rate

    def _plan(self, goal: float, cruise: float, acceleration: float) -> None:
        p, v = self.p, self.v
        self._goal, self._p0, self._v0, self._t = goal, p, v, 0.0
        a = abs(acceleration)
        if a == 0.0:
            # Nothing is configured that could move it: the reference stays.
            self._t1 = self._t2 = math.inf
            self._t3, self._vc, self._a, self._area = math.inf, v, 0.0, p
            return
        stop = p + 0.5 * v * abs(v) / a
        way = 1.0 if goal >= stop else -1.0
        # In the direction of the goal: u is the velocity, d the distance.
        u, d = v * way, (goal - p) * way
        limit = abs(cruise) if cruise != 0.0 else math.inf
        top = math.sqrt(max(0.5 * u * u + a * d, 0.0))
        if u > limit:
            top = limit  # it starts too fast: down to the cruise velocity first
        top = min(top, limit)
        t1 = abs(top - u) / a
        d1 = 0.5 * (u + top) * t1
        d3 = 0.5 * top * top / a
        cruising = max(d - d1 - d3, 0.0) / top if top > 0.0 else 0.0
        self._t1, self._t2, self._t3 = t1, t1 + cruising, t1 + cruising + top / a
        self._vc, self._a, self._area = way * top, way * a, p + way * d1
