"""Motion of all bodies during one tick, and contacts of the robots, for matches and for worlds without a match.

`Motion.advance` is the loop. Each 5 ms step updates the devices, then moves robots, swinging bodies and balls. The
engine moves all other bodies, in one step or in several if the pieces require shorter steps. Sensors are read last.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import combinations

from simcore.pieces.piece_manager import Footprint, GamePieceManager
from simcore.robot.robot import Robot
from simcore.units import TICK
from simcore.world.field import FieldElement
from simcore.world.hanging import HangingBody
from simcore.world.world import PhysicsWorld

__all__ = ["STEP", "Motion", "RobotContacts"]

_AHEAD = 0.2  # [m]; margin within which contacts are read from the engine


class RobotContacts:
    """Contacts of robots with robots, hanging bodies, pieces and field elements during one tick.

    Args:
        world: Physics world of the robots and pieces.
        robots: All robots.
        pieces: All pieces.
        hanging: Hanging bodies of the field.
        elements: Elements of the field.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        robots: Sequence[Robot],
        pieces: GamePieceManager,
        hanging: Sequence[HangingBody],
        elements: Iterable[FieldElement] = (),
    ) -> None:
        self._world = world
        self._robots, self._pieces, self._hanging = robots, pieces, hanging
        self._elements = frozenset(element.name for element in elements)
        self._number_of = {robot.chassis.row: robot.number for robot in robots}
        self._near_robots: list[tuple[Robot, Robot]] = []
        self.near_hanging: list[HangingBody] = []
        """Hanging bodies that are close enough to a robot for contact in this tick."""
        self.robots: set[tuple[int, int]] = set()
        """Pairs of numbers of robots that have touched in this tick, each pair in both orders."""
        self.hanging: set[tuple[int, str]] = set()
        """Robot number and name of the hanging body for each contact with a hanging body in this tick."""

    def begin_tick(self) -> None:
        """Clear the contacts of the last tick, and list the robots and hanging bodies that could touch in this tick."""
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
        """Add the contacts of robots with robots and hanging bodies in the last substep to the contacts of the tick."""
        touched = {robot: self._world.touching(robot.chassis.row) for robot, _ in self._near_robots}
        for a, b in self._near_robots:
            if b.chassis.row in touched[a]:
                self.robots |= {(a.number, b.number), (b.number, a.number)}
        for body in self.near_hanging:
            self.hanging |= {(number, body.config.name) for number in self.touching(body.row)}

    def touching_piece(self, slot: int) -> list[int]:
        """Return the numbers of the robots that a piece has touched.

        The result covers the whole tick for a ball, and only the last engine step for any other piece.
        """
        return [self._number_of[row] for row in self._pieces.robots_touching(slot)]

    def touching(self, row: int) -> list[int]:
        """Return the numbers of the robots that a body has touched in the last substep.

        Args:
            row: Row of the body in the physics world.
        """
        return [robot.number for robot in self._robots if row in self._world.touching(robot.chassis.row)]

    def elements(self, number: int) -> set[str]:
        """Return the names of the field elements that a robot touched in the last substep.

        The result includes the rungs on which the robot's climbers hang.
        """
        robot = self._robots[number]
        touched = {self._world.body_name(row) for row in self._world.touching(robot.chassis.row)} & self._elements
        return touched | {climber.rung.name for climber in robot.climbers if climber.rung is not None}


STEP = 0.005
"""Time step of devices and robot bodies [s].

A robot that coasts up a bump at 1.5 m/s rolls back at 1.37 m/s with this step, but at only 1.13 m/s with 20 ms steps.
"""


class Motion:
    """Time stepping of the robots, pieces and hanging bodies in a physics world.

    Args:
        world: Physics world of the bodies.
        robots: All robots.
        pieces: All pieces; None for a world without pieces.
        hanging: Hanging bodies of the field.
        watchers: Contact records, cleared at the start of each tick and updated after each substep.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        *,
        robots: Sequence[Robot] = (),
        pieces: GamePieceManager | None = None,
        hanging: Sequence[HangingBody] = (),
        watchers: Sequence[RobotContacts] = (),
    ) -> None:
        self._world, self._robots, self._pieces = world, robots, pieces
        self._hanging, self._watchers = hanging, watchers
        self._longest = math.inf  # longest step that the pieces allow in this tick [s]
        self.substeps = 0
        """Number of substeps in this tick so far."""

    def begin_tick(self, dt: float = TICK, *, others: Sequence[Footprint] = ()) -> None:
        """Begin a tick: clear contacts, wake pieces that a moving body can reach, and find the longest allowed substep.

        Args:
            dt: Length of the tick [s].
            others: Footprints of moving bodies other than robots, pieces and hanging bodies.
        """
        movers = [*others, *(Footprint(*robot.chassis.footprint) for robot in self._robots)]
        movers += [Footprint(*body.footprint) for body in self._hanging if body.is_awake]
        self._longest = math.inf if self._pieces is None else self._pieces.begin_tick(movers, dt)
        self.substeps = 0
        for watcher in self._watchers:
            watcher.begin_tick()

    def advance(self, dt: float = TICK) -> None:
        """Advance devices and bodies by dt [s], a whole tick or part of a tick, and then read the sensors."""
        world, robots = self._world, self._robots
        count = math.ceil(dt / STEP - 1e-9)
        h = dt / count
        parts = max(1, math.ceil(h / self._longest - 1e-9))
        for _ in range(count):
            for robot in robots:
                robot.step_devices(h)
            world.advance(h)
            if world.has_engine:
                self._step_engine(h, parts)
            else:
                for watcher in self._watchers:
                    watcher.note()
        for robot in robots:
            robot.sense(dt)
        self.substeps += count * parts

    def _step_engine(self, h: float, parts: int) -> None:
        """Advance the engine's bodies by h [s] in `parts` equal substeps, with drag on pieces, and record contacts."""
        for number in range(parts):
            if number == 0:
                self._world.begin_engine(h)
            if self._pieces is not None:
                self._pieces.apply_drag(h / parts)
            self._world.step_engine(h / parts)
            for watcher in self._watchers:
                watcher.note()
        self._world.end_engine(h)

    def tick(self, dt: float = TICK, *, others: Sequence[Footprint] = ()) -> None:
        """Advance a world without a match by one whole tick.

        Args:
            dt: Length of the tick [s].
            others: Footprints of moving bodies other than robots, pieces and hanging bodies.
        """
        self.begin_tick(dt, others=others)
        self.advance(dt)
        self.end_tick(dt)

    def end_tick(self, dt: float = TICK) -> None:
        """End a tick of dt [s]: read the state of the pieces, and put slow pieces to sleep."""
        if self._pieces is not None:
            self._pieces.gather(dt)
            self._pieces.settle(dt)
