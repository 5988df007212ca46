"""How many sub-steps a tick needs, so that nothing passes or lodges in a wall."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.errors import ConfigError, require_positive

__all__ = ["Substepping"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Substepping:
    """Limits on movement per sub-step, and on their number.

    A ball of radius r never passes a box or hull of thickness t while it moves at most r + t / 2 a step, nor a
    triangle mesh while it moves at most r (measured over 200 shots a cell). With r = 0.075 m, 0.07 m covers both.
    """

    max_move: float = 0.07
    """Farthest that a piece may move in one sub-step [m]."""
    robot_move: float = 0.016
    """Farthest that a robot may move in one sub-step [m]: more, and it rides up on the fuel that it pushes."""
    robot_near_move: float = 0.008
    """The same where something solid is within reach [m]: what a bumper can overlap a wall before it is stopped."""
    cap: int = 16
    """Most sub-steps a tick; a piece of r = 0.075 m is covered up to cap * max_move / dt = 56 m/s at 20 ms."""

    def __post_init__(self) -> None:
        for name in ("max_move", "robot_move", "robot_near_move"):
            require_positive("Substepping", name, getattr(self, name), "m")
        if self.cap < 1:
            raise ConfigError(f"Substepping: cap must be at least 1, got {self.cap}")

    def count(self, dt: float, piece_speed: float, robot_speed: float = 0.0, near: bool = False) -> int:
        """Sub-steps for a tick of dt [s] with the fastest piece and robot at these speeds [m/s]."""
        robot_limit = self.robot_near_move if near else self.robot_move
        wanted = max(piece_speed * dt / self.max_move, robot_speed * dt / robot_limit)
        return max(1, min(self.cap, math.ceil(wanted)))
