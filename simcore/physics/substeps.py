"""How many sub-steps a tick needs, so that nothing passes or lodges in a wall."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from simcore.quantities import DURATION, ROBOT_LENGTH, Quantity, require_fields

__all__ = ["Substepping", "Surroundings"]

_RADIUS = 0.075
"""Of the ball that the limits were measured with [m]."""


class Surroundings(IntEnum):
    """What a robot could meet within a tick."""

    OPEN = 0
    """Carpet, and pieces."""
    RAMP = 1
    """Something to drive over."""
    WALL = 2
    """A wall or another robot."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Substepping:
    """Limits on movement per sub-step, and on their number.

    A ball of radius r never passes a box or hull of thickness t while it moves at most r + t / 2 a step, nor a
    triangle mesh while it moves at most r (measured over 200 shots a cell). With r = 0.075 m, 0.07 m covers both.
    """

    max_move: float = 0.07
    """Farthest that a piece may move in one sub-step [m]."""
    robot_move: float = 0.06
    """Farthest that a robot may move in one sub-step on the open carpet [m]. Through single balls, loose and dense ones
    at 2.4 to 3 m/s, bumpers overlap balls by at most 50 mm with 0.06, 44 mm with 0.05 and 11 mm with 0.004, and balls
    come 0 to 3 % less far with 0.06 than with 0.05 (six fields of each).
    """
    robot_ramp_move: float = 0.016
    """The same with a ramp, a wall or another robot within reach [m]: at 0.06 m it jumps over a bump with twice the
    pitch."""
    robot_contact_step: float = 0.005
    """Longest step of a robot with a ramp, a wall or another robot within reach [s]. Coasting up a bump at 1.5 m/s it
    comes back with 1.37 m/s in steps of 5 ms, 1.13 m/s in those of 20 ms.
    """
    cap: int = 16
    """Most sub-steps a tick; a piece of r = 0.075 m is covered up to cap * max_move / dt = 56 m/s at 20 ms."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            max_move=ROBOT_LENGTH,
            robot_move=ROBOT_LENGTH,
            robot_ramp_move=ROBOT_LENGTH,
            robot_contact_step=DURATION,
            cap=Quantity("sub-steps", 1, 1000, is_whole=True),
        )

    @classmethod
    def for_balls(cls, radius: float) -> Substepping:
        """Limits for a game whose smallest ball has a radius [m]: those of `Substepping()`, or less if it is smaller.

        >>> Substepping.for_balls(0.2) == Substepping()
        True
        >>> round(Substepping.for_balls(0.05).robot_move, 4)
        0.04
        """
        limits, share = cls(), min(1.0, radius / _RADIUS)
        return cls(max_move=share * limits.max_move, robot_move=share * limits.robot_move)

    def count(
        self, dt: float, piece_speed: float, robot_speed: float = 0.0, near: Surroundings = Surroundings.OPEN
    ) -> int:
        """Sub-steps for a tick.

        Args:
            dt: Length of the tick [s].
            piece_speed: Of the fastest piece [m/s].
            robot_speed: Of the fastest robot [m/s].
            near: What that robot could meet within the tick.
        """
        pieces = min(self.cap, math.ceil(piece_speed * dt / self.max_move))
        return max(pieces, self.robot_count(dt, robot_speed, near))

    def robot_count(self, dt: float, speed: float, near: Surroundings = Surroundings.OPEN) -> int:
        """Steps that a robot takes in dt [s] at a speed [m/s], with something within reach."""
        limit = self.robot_move if near is Surroundings.OPEN else self.robot_ramp_move
        fewest = 1 if near is Surroundings.OPEN else math.ceil(dt / self.robot_contact_step - 1e-9)
        return max(fewest, min(self.cap, math.ceil(speed * dt / limit)), 1)
