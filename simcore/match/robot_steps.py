"""Steps of robots: each takes as many as it needs itself, whatever the pieces and other robots need.

An engine has one step for everybody. A robot on the flat carpet that no piece pushes moves by its own equations, in its
own steps of one or more of the engine's, so that another one at a wall changes no bit of its path. One that the engine
moves as well (on a ramp, among pieces, on a rung) is driven in each of the engine's steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import Protocol

from simcore.physics.substeps import Surroundings
from simcore.physics.world import PhysicsWorld
from simcore.robot.chassis import ChassisSimulation

__all__ = ["RobotSteps", "SteppedRobot"]

_BESIDE = 0.1  # [m]; robots that cannot come nearer to each other in a tick need not take the same steps


class SteppedRobot(Protocol):
    """What the plan of steps needs of a robot."""

    @property
    def chassis(self) -> ChassisSimulation:
        """Its body."""
        ...

    @property
    def is_at_rung(self) -> bool:
        """Whether it hangs, or could catch a rung within a tick."""
        ...


class RobotSteps:
    """The steps of all robots of a world.

    Args:
        world: Where they are.
        robots: All of them.
    """

    def __init__(self, world: PhysicsWorld, robots: Sequence[SteppedRobot]) -> None:
        self._world, self._robots = world, robots
        self._near = [Surroundings.OPEN] * len(robots)
        self._pairs: list[tuple[int, int]] = []

    def look_around(self, dt: float) -> None:
        """See what each robot could meet within dt [s], before `plan`."""
        self._near = [robot.chassis.surroundings(dt) for robot in self._robots]
        spots = [(robot.chassis.pos, robot.chassis.reach(dt) + 0.5 * _BESIDE) for robot in self._robots]
        self._pairs = [
            (a, b)
            for (a, (pos_a, reach_a)), (b, (pos_b, reach_b)) in combinations(enumerate(spots), 2)
            if math.dist(pos_a, pos_b) < reach_a + reach_b
        ]

    def plan(self, dt: float, fewest: int) -> tuple[int, list[int]]:
        """Share dt [s] between the robots' steps.

        Args:
            dt: Part of the tick.
            fewest: Steps of the engine that the pieces need.

        Returns:
            Steps of the engine: a multiple of each robot's number of steps, which is a power of two; and how many of
            them are one step of each robot.
        """
        count = self._world.substepping.robot_count
        wanted = [count(dt, robot.chassis.speed, near) for robot, near in zip(self._robots, self._near, strict=True)]
        for _ in self._pairs:  # those that may touch take the same steps, through others, too
            for a, b in self._pairs:
                wanted[a] = wanted[b] = max(wanted[a], wanted[b])
        steps = [1 << (number - 1).bit_length() for number in wanted]
        most = max(steps, default=1)
        total = most * math.ceil(fewest / most)
        alone = [robot.chassis.is_on_its_own and not robot.is_at_rung for robot in self._robots]
        for _ in self._pairs:
            for a, b in self._pairs:
                alone[a] = alone[b] = alone[a] and alone[b]
        return total, [total // number if own else 1 for number, own in zip(steps, alone, strict=True)]
