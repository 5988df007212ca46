"""The loop of a tick, written once: for a match, for tests, and for whoever has a world without a match.

`Motion.advance` is the loop. Robots take steps of their own, so that what pieces need changes nothing for them. In
each, devices, mechanisms and drivetrain move in parts of 5 ms or less. Then follow, in each step of the engine,
contacts of robots with walls and one another, what hangs, the balls, the engine itself, and who looks at contacts.
Sensors come last.

>>> from simcore.physics.world import PhysicsWorld
>>> from simcore.robot.chassis import ChassisSimulation
>>> from simcore.robot.chassis_config import ChassisConfig
>>> with PhysicsWorld() as world:
...     robot = ChassisSimulation(world, ChassisConfig())
...     motion = Motion(world, robots=[BareRobot(robot)])
...     robot.follow_velocity(1.0, 0.0, 0.0)
...     for _ in range(50):
...         motion.tick()
...     0.9 < robot.pos[0] < 1.0
True
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import Protocol

from simcore.physics.hanging import HangingBody
from simcore.physics.substeps import Surroundings
from simcore.physics.world import PhysicsWorld
from simcore.pieces.footprint import Footprint
from simcore.pieces.piece_manager import GamePieceManager
from simcore.robot.chassis import ChassisSimulation
from simcore.units import TICK

__all__ = ["BareRobot", "ContactWatcher", "Motion", "MovingRobot"]

_BESIDE = 0.1  # [m]; robots that cannot come nearer to each other in a tick need not take the same steps


class MovingRobot(Protocol):
    """What the loop needs of a robot."""

    @property
    def chassis(self) -> ChassisSimulation:
        """Its body."""
        ...

    @property
    def is_at_rung(self) -> bool:
        """Whether it hangs, or could catch a rung within a tick."""
        ...

    def begin_step(self, h: float) -> list[float]:
        """Begin a step of h [s]; returns the lengths of the parts in which what it has inside moves [s]."""
        ...

    def step_devices(self, h: float) -> None:
        """Let the controllers of robot code look and answer for the next h [s]."""
        ...

    def step_mechanisms(self, dt: float) -> None:
        """Advance its mechanisms by dt [s]."""
        ...

    def sense(self, dt: float) -> None:
        """Let its sensors follow what happened in the last dt [s]."""
        ...


class ContactWatcher(Protocol):
    """Who looks at contacts after each step of the engine."""

    def begin_tick(self) -> None:
        """Forget the last tick."""
        ...

    def note(self) -> None:
        """Take in the contacts of the last step."""
        ...


class BareRobot:
    """A chassis alone, as a robot of the loop: without devices, mechanisms and sensors."""

    is_at_rung = False

    def __init__(self, chassis: ChassisSimulation) -> None:
        self.chassis = chassis

    def begin_step(self, h: float) -> list[float]:
        """See `MovingRobot`."""
        return self.chassis.begin_step(h)

    def step_devices(self, h: float) -> None:
        """There are none."""

    def step_mechanisms(self, dt: float) -> None:
        """There are none."""

    def sense(self, dt: float) -> None:
        """Read the body's pose and velocity."""
        self.chassis.read()


class Motion:
    """Everything that moves in a world.

    Args:
        world: Where it moves.
        robots: They take their own steps: what pieces need changes nothing for them.
        pieces: None: there are none.
        hanging: What hangs from the field.
        watchers: Who looks at contacts.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        *,
        robots: Sequence[MovingRobot] = (),
        pieces: GamePieceManager | None = None,
        hanging: Sequence[HangingBody] = (),
        watchers: Sequence[ContactWatcher] = (),
    ) -> None:
        self._world, self._robots, self._pieces = world, robots, pieces
        self._hanging, self._watchers = hanging, watchers
        self._steps = RobotSteps(world, robots)
        self._longest = math.inf  # step that the pieces allow in this tick [s]
        self.substeps = 0
        """Steps of the engine in this tick so far."""

    def begin_tick(self, dt: float = TICK, *, others: Sequence[Footprint] = ()) -> None:
        """Before a tick of dt [s]: sleepers that can be reached wake, and its steps are planned.

        Args:
            dt: Length of the tick [s].
            others: What else moves, beside robots, pieces and what hangs.
        """
        movers = [*others, *(Footprint(*robot.chassis.footprint) for robot in self._robots)]
        movers += [Footprint(*body.footprint) for body in self._hanging if body.is_awake]
        self._longest = math.inf if self._pieces is None else self._pieces.begin_tick(movers, dt)
        self._steps.look_around(dt)
        self.substeps = 0
        for watcher in self._watchers:
            watcher.begin_tick()

    def advance(self, dt: float = TICK, *, steps: tuple[int, int] | None = None) -> None:
        """The loop: everything moves for dt [s], a tick or a part of one.

        Args:
            dt: Time to come [s].
            steps: Of the robots, and of the engine in each of them; None: as planned.
        """
        world, pieces, robots, hanging = self._world, self._pieces, self._robots, self._hanging
        total, parts = self.count_steps(dt) if steps is None else (math.prod(steps), [steps[1]] * len(robots))
        h = dt / total
        for number in range(total):
            for body in hanging:
                body.read()
            for robot, own in zip(robots, parts, strict=True):
                if number % own:
                    robot.chassis.go_on()
                    continue
                for part in robot.begin_step(h * own):
                    robot.step_devices(part)
                    robot.step_mechanisms(part)
                    robot.chassis.drive(part)
                robot.chassis.push(own)
            world.bumpers.resolve()
            for body in hanging:
                body.before_substep(h)
            if pieces is not None:
                pieces.before_step(h)
            world.engine.step(h)
            for watcher in self._watchers:
                watcher.note()
        for robot in robots:
            robot.sense(dt)
        self.substeps += total

    def count_steps(self, dt: float) -> tuple[int, list[int]]:
        """Steps of the engine within the next dt [s], and how many of them are one step of each robot."""
        return self._steps.plan(dt, max(1, math.ceil(dt / self._longest - 1e-9)))

    def tick(self, dt: float = TICK, *, steps: tuple[int, int] | None = None, others: Sequence[Footprint] = ()) -> None:
        """A whole tick of a world without a match; for `steps` see `advance`, for `others` see `begin_tick`."""
        self.begin_tick(dt, others=others)
        self.advance(dt, steps=steps)
        self.end_tick(dt)

    def end_tick(self, dt: float = TICK) -> None:
        """After a tick of dt [s]: pieces are read, and those that have been slow for a while sleep."""
        if self._pieces is not None:
            self._pieces.gather(dt)
            self._pieces.settle(dt)


class RobotSteps:
    """The steps of all robots of a world: each takes as many as it needs itself, whatever pieces and others need.

    An engine has one step for everybody. A robot on the flat carpet that no piece pushes moves by its own equations, in
    its own steps of one or more of the engine's, so that another one at a wall changes no bit of its path. One that the
    engine moves as well (on a ramp, among pieces, on a rung) is driven in each of the engine's steps.

    Args:
        world: Where they are.
        robots: All of them.
    """

    def __init__(self, world: PhysicsWorld, robots: Sequence[MovingRobot]) -> None:
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
