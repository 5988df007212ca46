"""Which robots touch each other and what hangs from the field, as the physics engine finds it, sub-step by sub-step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

from simcore.physics.hanging import HangingBody
from simcore.physics.world import PhysicsWorld
from simcore.robot.robot import Robot
from simcore.units import TICK

__all__ = ["RobotContacts"]

_AHEAD = 0.2  # [m]; the engine is asked about what is so much farther apart than what touches, and nearer


class RobotContacts:
    """The contacts of a tick.

    Args:
        world: Where they are.
        robots: All of them.
        hanging: What hangs from the field.
    """

    def __init__(self, world: PhysicsWorld, robots: Sequence[Robot], hanging: Sequence[HangingBody]) -> None:
        self._world, self._engine = world, world.engine
        self._robots, self._hanging = robots, hanging
        self._number_of = {robot.chassis.row: robot.number for robot in robots}
        self._near_robots: list[tuple[Robot, Robot]] = []
        self.near_hanging: list[HangingBody] = []
        """Hanging bodies that a robot could touch in this tick."""
        self.robots: set[tuple[int, int]] = set()
        """Pairs of robots that touched in this tick, each in both orders."""
        self.hanging: set[tuple[int, str]] = set()
        """Robots, and the names of the hanging bodies that they touched in this tick."""

    def begin_tick(self) -> None:
        """Forget the last tick, and see who could touch in this one."""
        self.robots.clear()
        self.hanging.clear()
        spots = [(robot, robot.chassis.pos, robot.chassis.reach(TICK) + _AHEAD) for robot in self._robots]
        self._near_robots = [
            (a, b)
            for (a, pos_a, reach_a), (b, pos_b, reach_b) in combinations(spots, 2)
            if math.dist(pos_a, pos_b) < reach_a + reach_b
        ]
        self.near_hanging = [
            body
            for body in self._hanging
            if any(math.dist(pos[:2], body.pos[:2]) < reach + body.radius for _, pos, reach in spots)
        ]

    def note(self) -> None:
        """Take in the contacts of the last sub-step."""
        for a, b in self._near_robots:
            if b.chassis.row in self._world.touching(a.chassis.row):
                self.robots |= {(a.number, b.number), (b.number, a.number)}
        for body in self.near_hanging:
            self.hanging |= {(number, body.config.name) for number in self.touching(body.row)}

    def touching(self, row: int) -> list[int]:
        """Numbers of the robots that a body of the world touched in the last sub-step."""
        return [self._number_of[other] for other in self._engine.touching(row) if other in self._number_of]
