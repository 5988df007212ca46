"""Shot solver: yaw, elevation and speed at which a ball with drag falls through a target, also from a moving robot.

Without lift, a flight stays in the vertical plane that contains muzzle and target in the field frame. The unknowns are
slope and speed in this plane. Each slope has exactly one speed that hits. The remaining equation for the slope is that
the launch *relative to the moving muzzle* has the requested elevation or speed.

The solver integrates over the horizontal distance x, and therefore needs no search for the time of the hit. With the
slope p = dz/dx and q = 1 / vx^2:
    dp/dx = -g q,   dq/dx = 2 k q sqrt(1 + p^2),   dz/dx = p,   dt/dx = sqrt(q).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import SupportsFloat, TypeAlias

from simcore.errors import ConfigError, NonFiniteError, SimcoreError
from simcore.loop.compiled import compiled
from simcore.typing import FloatArray
from simcore.units import GRAVITY
from simcore.world.rotation import wrap_angle

__all__ = ["NoShotError", "Shot", "solve_shot"]

_Vector: TypeAlias = Sequence[float] | FloatArray
_STEPS = 16  # number of RK4 steps to the target: within 0.1 mm of solve_ivp over half a field
_STEEPEST = math.radians(88.0)
_MIN_DISTANCE = 0.05  # [m]; at a shorter distance the direction to the target is undefined


class NoShotError(SimcoreError, ValueError):
    """Error if no launch within the limits hits the target."""

    def __init__(self, reason: str, *, distance: float, height: float) -> None:
        self.reason = reason
        self.distance = distance
        """Horizontal distance from muzzle to target [m]."""
        self.height = height
        """Height of the target above the muzzle [m]."""
        super().__init__(f"no shot at {distance:.2f} m away and {height:+.2f} m up: {reason}")


@dataclass(frozen=True, slots=True)
class Shot:
    """Launch that hits the target: setpoints for hood, wheels and turret, relative to the moving muzzle."""

    yaw: float
    """Yaw of the launch relative to the muzzle, field frame [rad]."""
    elevation: float
    """Elevation of the launch above the horizontal, relative to the muzzle [rad]."""
    speed: float
    """Speed relative to the muzzle [m/s]."""
    time_of_flight: float
    """Time from muzzle to target [s]."""
    entry_angle: float
    """Angle below the horizontal at the target, positive on the way down [rad]."""


def solve_shot(
    muzzle: _Vector, target: _Vector, *, elevation: float | None = None, speed: float | None = None,
    drag: SupportsFloat = 0.0, robot_velocity: _Vector = (0.0, 0.0, 0.0), yaw_rate: float = 0.0,
    muzzle_offset: _Vector = (0.0, 0.0, 0.0), high_arc: bool = True, rising: bool = False, max_speed: float = math.inf,
    gravity: float = GRAVITY,
) -> Shot:  # fmt: skip
    """Solve for the speed at a given elevation, or for the elevation at a given speed, in about 1 ms.

    Args:
        muzzle: Center of the ball at launch, field frame [m], shape (3,).
        target: Point through which the ball falls, field frame [m], shape (3,).
        elevation: Elevation of the launch relative to the robot [rad]; None if `speed` is given.
        speed: Speed of the launch relative to the muzzle [m/s]; None if `elevation` is given.
        drag: Drag factor k = rho Cd A / (2 m), `GamePieceConfig.air.drag` [1/m]; the solver does not model lift.
        robot_velocity: Velocity of the robot center, field frame [m/s], shape (3,).
        yaw_rate: Yaw rate of the robot, counter-clockwise positive [rad/s].
        muzzle_offset: Vector from robot center to muzzle, field axes [m], shape (3,); needed only with a yaw rate.
        high_arc: Whether to choose the higher of the two elevations at a given speed.
        rising: Whether the ball may also reach the target on the way up, for goals with an opening at the front.
        max_speed: Maximum speed of the launcher [m/s].
        gravity: Gravitational acceleration, downward [m/s^2].

    Returns:
        Launch that hits the target, relative to the moving muzzle.

    Raises:
        NoShotError: If no launch hits; the message states the reason.
        ConfigError: If not exactly one of elevation and speed is given, or a value is out of range.
        NonFiniteError: If a position or velocity is not finite.

    >>> shot = solve_shot((0, 0, 0.5), (4.18, 0, 1.8288), elevation=math.radians(60), drag=0.0232)
    >>> round(shot.speed, 2), round(shot.time_of_flight, 2)
    (8.0, 1.12)
    """
    if (elevation is None) == (speed is None):
        raise ConfigError(f"solve_shot: give either elevation or speed, got {elevation} and {speed}")
    if elevation is not None and not -math.pi / 2 < elevation < math.pi / 2:
        raise ConfigError(f"solve_shot: elevation must be within +-pi/2 rad, got {elevation}")
    if speed is not None and not 0.0 < speed < math.inf:
        raise ConfigError(f"solve_shot: speed must be finite and > 0 m/s, got {speed}")
    k = float(drag)
    if not (0.0 <= k < math.inf and 0.0 < gravity < math.inf and max_speed > 0.0):
        raise ConfigError(f"solve_shot: need drag >= 0, gravity > 0, max_speed > 0, got {drag}, {gravity}, {max_speed}")
    problem = _Problem(muzzle, target, robot_velocity, yaw_rate, muzzle_offset, k, gravity)
    if elevation is not None:
        shot = problem.shot(problem.angle_for_elevation(elevation))
    else:
        assert speed is not None
        shot = problem.shot(problem.angle_for_speed(speed, high_arc))
    if shot.entry_angle <= 0.0 and not rising:
        raise problem.no_shot("the ball would pass it on the way up; aim steeper, or allow `rising`")
    if shot.speed > max_speed * (1.0 + 1e-9):
        raise problem.no_shot(f"it needs {shot.speed:.2f} m/s and the launcher gives {max_speed:.2f}")
    return shot


class _Problem:
    """Shot problem in the vertical plane through muzzle and target.

    Angles of methods are elevations of the ball's velocity in the field frame.
    """

    def __init__(
        self, muzzle: _Vector, target: _Vector, velocity: _Vector, yaw_rate: float, offset: _Vector, drag: float,
        gravity: float,
    ) -> None:  # fmt: skip
        east, north, self.height = (float(end) - float(start) for start, end in zip(muzzle, target, strict=True))
        vx, vy, self.up = (float(c) for c in velocity)
        vx, vy = vx - yaw_rate * float(offset[1]), vy + yaw_rate * float(offset[0])
        self.distance = math.hypot(east, north)
        if not math.isfinite(self.distance + self.height + vx + vy + self.up):
            raise NonFiniteError(
                f"solve_shot: need finite numbers, got muzzle {muzzle}, target {target},"
                f" robot {velocity} m/s, {yaw_rate} rad/s"
            )
        if self.distance < _MIN_DISTANCE:
            raise self.no_shot(f"the target is right over or under the muzzle (need {_MIN_DISTANCE} m or more)")
        self.bearing = math.atan2(north, east)
        c, s = east / self.distance, north / self.distance
        self.along = c * vx + s * vy  # muzzle velocity toward the target [m/s]
        self.across = c * vy - s * vx  # muzzle velocity across this direction, positive to the left [m/s]
        self.drag = drag
        self.gravity = gravity
        self.flattest = math.atan2(self.height, self.distance) + 1e-3  # line of sight
        if self.flattest >= _STEEPEST:
            raise self.no_shot("the line of sight is too steep")

    def no_shot(self, reason: str) -> NoShotError:
        return NoShotError(reason, distance=self.distance, height=self.height)

    def angle_for_elevation(self, elevation: float) -> float:
        """Return the field-frame angle at which a hit has a given elevation relative to the muzzle [rad]."""
        if self.along == self.across == self.up == 0.0:
            if elevation < self.flattest:
                raise self.no_shot(f"{math.degrees(elevation):.1f} degrees is below the line of sight")
            if elevation > _STEEPEST:
                raise self.no_shot(f"{math.degrees(elevation):.1f} degrees is too steep")
            return elevation
        from scipy.optimize import brentq

        def excess(angle: float) -> float:
            return self.shot(angle).elevation - elevation

        # Search outward from the solution for a robot at rest; the first change of sign is the nearest solution.
        middle = min(max(elevation, self.flattest), _STEEPEST)
        ends, values, limits = [middle] * 2, [excess(middle)] * 2, [self.flattest, _STEEPEST]
        reach = math.radians(3.0)
        while ends != limits:
            # The excess grows with the angle, so first try the direction in which the sign should change.
            for side in (0, 1) if values[1] > 0.0 else (1, 0):
                if ends[side] != limits[side]:
                    end = min(max(ends[side] + (reach if side else -reach), self.flattest), _STEEPEST)
                    value = excess(end)
                    if value * values[side] <= 0.0:
                        low, high = sorted((end, ends[side]))
                        return float(brentq(excess, low, high, xtol=1e-10))
                    ends[side], values[side] = end, value
            reach *= 1.5
        raise self.no_shot(f"no speed hits at {math.degrees(elevation):.1f} degrees from a robot that moves like this")

    def angle_for_speed(self, speed: float, high_arc: bool) -> float:
        """Return the field-frame angle [rad] at which a hit has a given speed relative to the muzzle [m/s]."""
        from scipy.optimize import brentq, minimize_scalar

        def excess(angle: float) -> float:
            return self.shot(angle).speed - speed

        cheapest = 0.5 * (0.5 * math.pi + self.flattest)  # optimum in a vacuum at rest, as a start value
        if excess(cheapest) > 0.0:
            found = minimize_scalar(
                excess, bounds=(self.flattest, _STEEPEST), method="bounded", options={"xatol": 1e-4}
            )
            cheapest = float(found.x)
            if found.fun > 0.0:
                raise self.no_shot(f"out of range: it needs {speed + found.fun:.2f} m/s and {speed:.2f} were given")
        end = _STEEPEST if high_arc else self.flattest
        if excess(end) < 0.0:
            raise self.no_shot(f"at {speed:.2f} m/s the arc would be steeper or flatter than a launcher can shoot")
        return float(brentq(excess, cheapest, end, xtol=1e-10))

    def shot(self, angle: float) -> Shot:
        """Return the launch that hits the target at a given field-frame angle [rad]."""
        slope = math.tan(angle)
        q, end_slope, time = self._hit(slope)
        forward = 1.0 / math.sqrt(q)
        along, across, up = forward - self.along, -self.across, forward * slope - self.up
        level = math.hypot(along, across)
        return Shot(
            yaw=wrap_angle(self.bearing + math.atan2(across, along)),
            elevation=math.atan2(up, level),
            speed=math.hypot(level, up),
            time_of_flight=time,
            entry_angle=-math.atan(end_slope),
        )

    def _hit(self, slope: float) -> tuple[float, float, float]:
        """Return q = 1 / vx^2 at the muzzle for a hit with a given initial slope, and slope and time [s] at the hit.

        Raises:
            NoShotError: If drag stops the ball before the target at any speed.
        """
        distance, k = self.distance, self.drag
        drop = slope * distance - self.height  # [m], > 0; required drop below the straight line
        mean = self.height / distance  # mean slope; without drag the slopes are `slope`, `mean`, 2 `mean` - `slope`
        stretch = (_length(slope) + 4.0 * _length(mean) + _length(2.0 * mean - slope)) / 6.0
        y = 2.0 * k * stretch * distance
        growth = 2.0 * (math.expm1(y) - y) / (y * y) if 1e-4 < y < 500.0 else 1.0  # for a constant path length factor
        q = 2.0 * drop / (self.gravity * distance * distance * growth)
        low, high, last_q, last_fall = 0.0, math.inf, 0.0, 0.0
        for _ in range(80):
            fall, end_slope, time = _arrive(slope, q, distance, k, self.gravity)
            low, high = (low, q) if fall > drop else (q, high)
            if abs(fall - drop) < 1e-8 or high - low < 1e-15 * q:
                return q, end_slope, time
            # The fall is nearly linear in q: use the secant method (first through zero) within the known bracket.
            guess = 0.0
            if math.isfinite(fall):
                if fall != last_fall:
                    guess = q + (drop - fall) * (q - last_q) / (fall - last_fall)
                last_q, last_fall = q, fall
            q = guess if low < guess < high else (0.5 * (low + high) if high < math.inf else 2.0 * q)
        raise self.no_shot("air drag stops the ball before it gets there")


@compiled
def _arrive(p: float, q: float, distance: float, k: float, g: float) -> tuple[float, float, float]:
    """Integrate a flight over a horizontal distance [m] by RK4.

    Returns:
        Drop below the straight line with the initial slope [m], slope [-] and time [s] at this distance. The drop is
            infinite if the ball falls short.
    """
    h = distance / _STEPS
    half, sixth, k2 = 0.5 * h, h / 6.0, 2.0 * k
    slope, rise, time = p, 0.0, 0.0
    for _ in range(_STEPS):
        dp1, dq1 = -g * q, k2 * q * math.sqrt(1.0 + p * p)
        p2, q2 = p + half * dp1, q + half * dq1
        dp2, dq2 = -g * q2, k2 * q2 * math.sqrt(1.0 + p2 * p2)
        p3, q3 = p + half * dp2, q + half * dq2
        dp3, dq3 = -g * q3, k2 * q3 * math.sqrt(1.0 + p3 * p3)
        p4, q4 = p + h * dp3, q + h * dq3
        dp4, dq4 = -g * q4, k2 * q4 * math.sqrt(1.0 + p4 * p4)
        rise += sixth * (p + 2.0 * (p2 + p3) + p4)
        before = math.sqrt(q)
        p += sixth * (dp1 + 2.0 * (dp2 + dp3) + dp4)
        q += sixth * (dq1 + 2.0 * (dq2 + dq3) + dq4)
        if p < -200.0:  # the ball falls straight down and never reaches the distance
            return math.inf, p, math.inf
        time += sixth * (before + 4.0 * math.sqrt(0.5 * (q2 + q3)) + math.sqrt(q))
    return slope * distance - rise, p, time


def _length(slope: float) -> float:
    return math.sqrt(1.0 + slope * slope)
