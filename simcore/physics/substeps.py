"""How many sub-steps a tick needs, so that nothing passes or lodges in a wall."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from simcore.quantities import ROBOT_LENGTH, Quantity, require_fields

__all__ = ["Substepping", "Surroundings", "TickPlan"]

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
    """The same where there is something to drive over [m]: at 0.06 m it jumps over a bump with twice the pitch."""
    robot_wall_move: float = 0.008
    """The same where something solid is within reach [m]: what a bumper can overlap a wall before it is stopped."""
    cap: int = 16
    """Most sub-steps a tick; a piece of r = 0.075 m is covered up to cap * max_move / dt = 56 m/s at 20 ms."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            max_move=ROBOT_LENGTH,
            robot_move=ROBOT_LENGTH,
            robot_ramp_move=ROBOT_LENGTH,
            robot_wall_move=ROBOT_LENGTH,
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
        limit = (self.robot_move, self.robot_ramp_move, self.robot_wall_move)[near]
        wanted = max(piece_speed * dt / self.max_move, robot_speed * dt / limit)
        fewest = 2 if near is Surroundings.WALL else 1  # with one, a robot that pushes a wall with all its grip rocks
        return max(fewest, min(self.cap, math.ceil(wanted)))


@dataclass(frozen=True, slots=True, kw_only=True)
class TickPlan:
    """What is known of a tick before it: how finely it must be stepped."""

    piece_speed: float = 0.0
    """Of the fastest piece, with what gravity can add [m/s]."""
    longest_step: float = math.inf
    """Longest step of the engine that the pieces allow [s]."""
    is_pressed: bool = False
    """Whether a robot presses pieces against something: each of its steps is then one of the engine's."""
    near: Surroundings = Surroundings.OPEN
    """What a robot could meet."""
