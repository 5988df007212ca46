"""How much of the robot each wheel carries."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from operator import mul

from simcore.errors import NonFiniteError
from simcore.robot.wheel_config import RobotMass
from simcore.units import GRAVITY, plain_sum

__all__ = ["LoadTransfer", "normal_loads"]

_TIRE_LAG = 0.010  # [s]; treads and carpet give a little, so loads follow the chassis with a lag. Estimate, +-50 %


def normal_loads(
    config: RobotMass,
    touching: Sequence[bool],
    gravity_robot: Sequence[float],
    accel_robot: Sequence[float] = (0.0, 0.0, 0.0),
) -> list[float]:
    """Normal load of each wheel from gravity, acceleration and which wheels touch.

    The ground acts on the chassis with f = m (a - g). Its vertical part is shared so that the forces at the contact
    points make no moment about the center of mass (a rigid chassis that is not just tipping):

        sum N_i = f_z,   sum N_i x_i = -height f_x,   sum N_i y_i = -height f_y

    Speeding up puts load on the rear axle, a left turn on the right wheels, and a slope on the lower ones. With more
    than three wheels the load with the least squares is taken (equal springs under every wheel). A wheel that would
    have to pull on the floor lifts instead. Where the middle wheels are lowered, they carry all, together with the end
    toward which the load leans.

    Args:
        config: Positions of the wheels, mass, center of mass.
        touching: Per wheel, whether it is on the ground.
        gravity_robot: Acceleration of gravity, robot axes [m/s^2], shape (3,); level ground: (0, 0, -9.80665).
        accel_robot: Of the center of mass, robot axes, as seen from the field [m/s^2], shape (3,).

    Returns:
        Loads [N], each >= 0, 0 where nothing touches; they add up to f_z, or are all 0 in free fall.

    Raises:
        NonFiniteError: When an acceleration is NaN or infinite.
    """
    if not all(map(math.isfinite, (*gravity_robot, *accel_robot))):
        raise NonFiniteError(f"normal loads need finite numbers, got gravity={gravity_robot}, accel={accel_robot}")
    mass = config.mass
    positions = config.positions
    loads = [0.0] * len(positions)
    force_z = mass * (accel_robot[2] - gravity_robot[2])
    rows = tuple(i for i, down in enumerate(touching) if down)
    if force_z <= 0.0 or not rows:
        return loads
    height = config.center_of_mass[2] * mass
    want_x = height * (gravity_robot[0] - accel_robot[0])
    want_y = height * (gravity_robot[1] - accel_robot[1])
    if config.lowered:
        rows = _carrying(config, rows, want_x / force_z)
    while True:
        share = [p * force_z + q * want_x + r * want_y for p, q, r in _shares(positions, rows)]
        lowest = min(share)
        if lowest >= -1e-12 * force_z:
            break
        # It lifts; at least one wheel stays, as the shares add up to f_z > 0.
        out = share.index(lowest)
        rows = rows[:out] + rows[out + 1 :]
    for i, load in zip(rows, share, strict=True):
        loads[i] = load if load > 0.0 else 0.0
    return loads


class LoadTransfer:
    """Load of each wheel from inner step to inner step, following the acceleration of the chassis with a lag.

    Its owner says once a step how the robot stands; the drivetrain says in each inner step what its tires do.
    """

    def __init__(self, config: RobotMass) -> None:
        """At rest, all wheels on level ground."""
        self.set_robot(config)
        self._touching: Sequence[bool] = [True] * len(config.positions)
        self._gravity: Sequence[float] = (0.0, 0.0, -GRAVITY)
        self._world: Sequence[float] = (0.0, 0.0, 0.0)
        self._x = self._y = self._z = 0.0  # acceleration that the loads have followed, robot axes
        self._tires_x = self._tires_y = 0.0  # of the last inner step
        self._all_down = [True] * len(config.positions)
        self._followed = (0.0, 0.0, 0.0)  # step [s], and how much of the way the loads go in half of it and in all

    def set_robot(self, config: RobotMass) -> None:
        """Take in another mass or center of mass."""
        self._config, self._is_level = config, not config.lowered
        self._mass, self._lever = config.mass, config.mass * config.center_of_mass[2]
        self._all_shares = _shares(config.positions, tuple(range(len(config.positions))))

    def reset(self) -> None:
        """At rest again."""
        self._x = self._y = self._z = self._tires_x = self._tires_y = 0.0

    def stand(self, touching: Sequence[bool], gravity: Sequence[float], world: Sequence[float]) -> None:
        """How the robot stands in the steps to come.

        Args:
            touching: Which wheels are on the ground.
            gravity: In robot axes [m/s^2].
            world: What else than its tires accelerates the robot (walls, slopes, a landing), robot axes [m/s^2].
        """
        self._touching, self._gravity, self._world = touching, gravity, world

    def loads(self, h: float) -> list[float]:
        """In the middle of an inner step of h [s], if the tires do as in the last one [N]."""
        share = self._lag_shares(h)[1]
        ax, ay, az = self._world
        x = self._x + share * (ax + self._tires_x - self._x)
        y = self._y + share * (ay + self._tires_y - self._y)
        z = self._z + share * (az - self._z)
        gx, gy, gz = self._gravity
        if self._is_level and self._touching == self._all_down:  # `normal_loads` with all wheels down, 10.6 -> 3.4 us
            force_z, want_x, want_y = self._mass * (z - gz), self._lever * (gx - x), self._lever * (gy - y)
            loads = [p * force_z + q * want_x + r * want_y for p, q, r in self._all_shares]
            if min(loads) >= 0.0:
                return loads
        return normal_loads(self._config, self._touching, self._gravity, (x, y, z))

    def _lag_shares(self, h: float) -> tuple[float, float, float]:
        """A step of h [s], and the share of their way that loads go in half of it and in all of it [-]."""
        if self._followed[0] != h:
            self._followed = (h, -math.expm1(-0.5 * h / _TIRE_LAG), -math.expm1(-h / _TIRE_LAG))
        return self._followed

    def follow(self, h: float, ax: float, ay: float, turn: float) -> None:
        """Go on by an inner step of h [s].

        Args:
            h: Its length [s].
            ax: Acceleration by tires in it, forward [m/s^2].
            ay: The same, to the left [m/s^2].
            turn: By which the robot turned in it, and its axes with it [rad].
        """
        share = self._lag_shares(h)[2]
        wx, wy, wz = self._world
        x = self._x + share * (wx + ax - self._x)
        y = self._y + share * (wy + ay - self._y)
        self._z += share * (wz - self._z)
        c, s = math.cos(turn), math.sin(turn)
        self._x, self._y = c * x + s * y, c * y - s * x
        self._tires_x, self._tires_y = ax, ay


def _carrying(config: RobotMass, rows: tuple[int, ...], x: float) -> tuple[int, ...]:
    """Of touching wheels with lowered ones among them: which carry a load whose center is at x [m]."""
    lowered = [i for i in rows if i in config.lowered]
    if not lowered:
        return rows
    at = [place[0] for place in config.positions]
    rear, front = min(at[i] for i in lowered), max(at[i] for i in lowered)
    if x > front:
        return tuple(i for i in rows if at[i] >= front)
    return tuple(i for i in rows if at[i] <= rear) if x < rear else tuple(lowered)


@lru_cache(maxsize=256)  # a robot has few sets of touching wheels; 4.5 -> 2.9 us a call
def _shares(
    positions: tuple[tuple[float, float], ...], rows: tuple[int, ...]
) -> tuple[tuple[float, float, float], ...]:
    """What each wheel takes of the force and of both moments: N = p F + q want_x + r want_y; the p add up to 1."""
    n = len(rows)
    xs = [positions[i][0] for i in rows]
    ys = [positions[i][1] for i in rows]
    mean_x = plain_sum(xs) / n
    mean_y = plain_sum(ys) / n
    # About the mean of the contacts: there the sum decouples from the two moments.
    dx = [x - mean_x for x in xs]
    dy = [y - mean_y for y in ys]
    xx = plain_sum(map(mul, dx, dx))
    yy = plain_sum(map(mul, dy, dy))
    xy = plain_sum(map(mul, dx, dy))
    det = xx * yy - xy * xy
    spread = xx + yy
    a = b = c = 0.0  # the inverse of ((xx, xy), (xy, yy)), as far as it exists
    if spread < n * 1e-6:
        pass  # contacts within a millimeter are one point: it carries all, moments go unmet
    elif det > 1e-9 * spread * spread:
        a, b, c = yy / det, -xy / det, xx / det
    else:  # contacts on one line: only the moment along it can be met
        a, b, c = xx / spread**2, xy / spread**2, yy / spread**2
    result = []
    for x, y in zip(dx, dy, strict=True):
        q = a * x + b * y
        r = b * x + c * y
        result.append((1.0 / n - q * mean_x - r * mean_y, q, r))
    return tuple(result)
