"""How many steps of the engine robots need in a tick: balls need none, they have their own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from simcore.quantities import DURATION, ROBOT_LENGTH, Quantity, require_fields

__all__ = ["Substepping", "Surroundings"]


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
    """Limits on the movement of robots per step of the engine, and on the number of steps."""

    robot_move: float = 0.06
    """Farthest that a robot may move in one step on the open carpet [m]."""
    robot_ramp_move: float = 0.016
    """The same with a ramp, a wall or another robot within reach [m]: at 0.06 m it jumps over a bump with twice the
    pitch."""
    robot_contact_step: float = 0.005
    """Longest step of a robot with a ramp, a wall or another robot within reach [s]. Coasting up a bump at 1.5 m/s it
    comes back with 1.37 m/s in steps of 5 ms, 1.13 m/s in those of 20 ms.
    """
    cap: int = 16
    """Most steps a tick."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            robot_move=ROBOT_LENGTH,
            robot_ramp_move=ROBOT_LENGTH,
            robot_contact_step=DURATION,
            cap=Quantity("steps", 1, 1000, is_whole=True),
        )

    def robot_count(self, dt: float, speed: float, near: Surroundings = Surroundings.OPEN) -> int:
        """Steps that a robot takes in dt [s] at a speed [m/s], with something within reach."""
        limit = self.robot_move if near is Surroundings.OPEN else self.robot_ramp_move
        fewest = 1 if near is Surroundings.OPEN else math.ceil(dt / self.robot_contact_step - 1e-9)
        return max(fewest, min(self.cap, math.ceil(speed * dt / limit)), 1)
