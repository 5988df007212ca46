"""Rolling resistance of balls and tubes.

Bullet resists rolling about two fixed axes, each with the full torque: a ball that rolls at 45 degrees to the field's
axes slows 1.41 times too fast, and one at 30 degrees curves to 18. It also keeps the resistance of contact points
behind the ball that carry nothing any more: 5 to 11 % more below 1 m/s. So balls and the floor under them have no
rolling resistance in the engine, and balls that roll on it lose speed here: c g t / (1.4 r), against their motion. On
anything else the engine has the part of what they roll on, and here they lose by their own.

It also keeps places of contact up to 3 mm behind a ball that rolls on a box or a hull, and the ball falls forward from
them: at one sub-step it would roll for ever, at 0.2 m/s. So these contacts are found anew in each sub-step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from simcore.geometry.rotation import rotate
from simcore.physics.contact_law import TerrainSurface, pair_rolling
from simcore.physics.engine import Engine
from simcore.physics.mass_properties import mass_properties
from simcore.physics.shapes import Shape, Sphere, round_radius
from simcore.typing import BoolArray, FloatArray

__all__ = ["RollingResistance"]

_PERIOD = 0.02
"""Least time between two losses of speed [s], of 0.01 m/s on carpet."""
_BALLS, _LONGEST = 8, 8
"""Balls for which losses are taken that often; of twice as many half as often, down to an eighth."""
_LIFTED = 0.001
"""Balls that are higher over the floor do not touch it [m]."""
_RISING = 0.2
"""Balls that rise or fall faster bounce [m/s]."""
_SLIP = 0.05
"""A ball slides if its lowest point moves faster than this share of its speed, and 1 cm/s [-]."""
_LEVEL = 0.05
"""Largest slope of the axis of a tube that rolls [-]."""
_HOPS = 0.004
"""Tubes that are higher over the floor do not roll on it [m]."""
_EDGES = 10.0
"""Most that edges take of a tube's speed, in parts of what its resistance takes; a hit takes more [-]."""
_STANDS, _CREEPS = 1e-9, 0.001
"""Balls that stand, and those that stop by themselves, are slower [m/s]."""


class RollingResistance:
    """Balls on the floor z = 0 or on other things, and what slows them.

    Args:
        engine: Where they live.
        floor: Its material; None: there is no floor.
        surface: Material of each row.
        is_static: Whether a row never moves.
    """

    def __init__(
        self,
        engine: Engine,
        floor: TerrainSurface | None,
        surface: Callable[[int], TerrainSurface],
        is_static: Callable[[int], bool],
    ) -> None:
        self._engine = engine
        self._is_static = is_static
        self._elsewhere: list[int] = []  # rows of balls that roll on statics
        self._floor = floor
        self._surface = surface
        self._balls: dict[int, tuple[float, float, float]] = {}  # radius, deceleration on the floor, and elsewhere for
        # each unit of friction there, by row
        self._shown: dict[int, None] = {}  # rows in the order in which they were shown
        self._tubes: dict[int, tuple[float, float]] = {}  # radius and deceleration on the floor, by row
        self._rolled: dict[int, float] = {}  # speeds of the tubes that rolled at the last loss
        self._due = 0.0

    def add(self, row: int, shape: Shape, surface: TerrainSurface) -> None:
        """Slow a body of a shape and a material from now on, if it can roll."""
        floor, radius = self._floor, round_radius(shape)
        lever = (
            pair_rolling(floor.rolling, floor.friction, surface.rolling, surface.friction) if floor is not None else 0.0
        )
        if radius is None or not (lever > 0.0 or surface.rolling > 0.0):
            return
        each = self._engine.gravity / (radius + float(mass_properties(shape).inertia[2, 2]) / radius)
        if isinstance(shape, Sphere):
            self._balls[row] = radius, lever * each, surface.rolling * each
            self.show(row, True)
        else:
            self._tubes[row] = radius, lever * each

    def show(self, row: int, is_shown: bool) -> None:
        """Say whether anything touches a body; one that is no ball is left alone."""
        if row in self._balls and is_shown != (row in self._shown):
            if is_shown:
                self._shown[row] = None
            else:
                del self._shown[row]

    def resist(self, dt: float, awake: Sequence[int] | None = None) -> None:
        """Take from each ball that rolls on the floor what it loses within dt [s].

        Args:
            dt: Time to come [s]; losses are taken once in a while.
            awake: Rows that can move; None: all.
        """
        self._due += dt
        count = len(self._shown if awake is None else awake)
        if self._due < _PERIOD * min(_LONGEST, math.ceil(max(count, 1) / _BALLS)) - 1e-9:
            return
        due, self._due = self._due, 0.0
        self._hold_tubes(due, self._tubes if awake is None else [row for row in awake if row in self._tubes])
        self._elsewhere.clear()
        balls = self._balls
        rows = [row for row in (self._shown if awake is None else awake) if row in balls]
        if not rows:
            return
        radius, slowing, elsewhere = np.array([balls[row] for row in rows]).T
        twists = self._engine.velocities(rows)
        speed = np.hypot(twists[:, 0], twists[:, 1])
        moving = np.nonzero((speed > _STANDS) & (np.abs(twists[:, 2]) < _RISING) & _rolls(twists, speed, radius))[0]
        if not len(moving):
            return
        over_floor = self._engine.centers([rows[i] for i in moving.tolist()])[:, 2] - radius[moving]
        rolling = moving[(over_floor >= _LIFTED) & (speed[moving] > _CREEPS)].tolist()
        self._elsewhere = [rows[i] for i in rolling if self._rolls_on_statics(rows[i])]
        for i in moving[(over_floor >= _LIFTED) & (elsewhere[moving] > 0.0)].tolist():
            slowing[i] = elsewhere[i] * self._friction_under(rows[i])
        is_slowed = np.where(over_floor < _LIFTED, over_floor > -0.5 * radius[moving], elsewhere[moving] > 0.0)
        moving = moving[is_slowed]
        left = np.maximum(0.0, 1.0 - slowing[moving] * due / speed[moving])
        slowed = twists[moving]
        slowed[:, [0, 1, 3, 4]] *= left[:, None]  # neither what it rises nor what it spins on the spot
        self._engine.set_velocities([rows[i] for i in moving.tolist()], slowed)

    def _hold_tubes(self, due: float, rows: Iterable[int]) -> None:
        """Give each tube that rolls on the floor the speed that resistance leaves it [s]."""
        before, self._rolled = self._rolled, {}
        for row in rows:
            radius, slowing = self._tubes[row]
            (vx, vy, vz), (wx, wy, wz) = self._engine.velocity(row)
            speed, (pos, quat) = math.hypot(vx, vy), self._engine.pose(row)
            slip = math.hypot(vx - radius * wy, vy + radius * wx)
            is_low = speed > _CREEPS and pos[2] - radius < _HOPS and slip < _SLIP * speed + 0.01
            if not (is_low and abs(rotate(quat, (0.0, 0.0, 1.0))[2]) < _LEVEL):
                continue
            was = before.get(row, 0.0)
            left = max(was - slowing * due, 0.0)
            if left - _EDGES * slowing * due < speed <= was:
                share, speed = left / speed, left
                self._engine.set_velocity(row, (share * vx, share * vy, vz), (share * wx, share * wy, wz))
            self._rolled[row] = speed

    def renew(self) -> None:
        """Let the engine find anew where balls roll on statics, before a sub-step."""
        for row in self._elsewhere:
            self._engine.renew_contacts(row)

    def _rolls_on_statics(self, row: int) -> bool:
        """Whether a ball touches what never moves, and nothing else."""
        touching = self._engine.touching(row)
        return bool(touching) and all(map(self._is_static, touching))

    def _friction_under(self, row: int) -> float:
        """Friction factor of the roughest thing that a ball touches, 0 in the air."""
        return max([self._surface(other).friction for other in self._engine.touching(row)], default=0.0)


def _rolls(twists: FloatArray, speed: FloatArray, radius: FloatArray) -> BoolArray:
    slip_x = twists[:, 0] - radius * twists[:, 4]
    slip_y = twists[:, 1] + radius * twists[:, 3]
    rolls: BoolArray = np.hypot(slip_x, slip_y) < _SLIP * speed + 0.01
    return rolls
