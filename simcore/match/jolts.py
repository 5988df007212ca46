"""What stands on the field, gives way a little when a robot hits it, and jolts the pieces that rest on it.

The engine takes such a structure as fixed. When a robot that touches it loses velocity faster than its tires could take
it, the structure gets that momentum, and what rests on it is moved by its recoil: momentum over mass, the velocity at
which it starts to sway. It sways by millimeters, so a piece gets this once; then the engine decides whether it stays.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fnmatch import fnmatchcase

import numpy as np

from simcore.geometry.rotation import IDENTITY
from simcore.physics.nearness import StaticBoxes
from simcore.physics.world import PhysicsWorld, StaticElement
from simcore.pieces.piece_manager import GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.robot.robot import Robot
from simcore.typing import FloatArray
from simcore.units import TICK

__all__ = ["Jolts"]

_HIT = 0.5  # [m/s] in a tick; tires change a robot's velocity by 0.25, so a robot that leans on something jolts nothing
_BESIDE = 0.02  # [m]; what is within this of a structure may rest on it
_AHEAD = 0.1  # [m]; robots that cannot come as near to a structure in a tick are not asked whether they touch it
_AT_REST = (int(PieceStatus.ASLEEP), int(PieceStatus.PLACED))


class Jolts:
    """The hits of a tick, and what they do.

    Args:
        world: With the field.
        elements: Of the field.
        masses: Of each structure, by name pattern of its elements [kg].
        pieces: That may rest on it.
        robots: That may hit it.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        elements: Iterable[StaticElement],
        masses: Mapping[str, float],
        pieces: GamePieceManager,
        robots: Sequence[Robot],
    ) -> None:
        self._world, self._pieces, self._robots = world, pieces, robots
        self._boxes: dict[str, StaticBoxes] = {}
        for element in elements:
            for pattern in masses:
                if fnmatchcase(element.name, pattern):
                    self._boxes.setdefault(pattern, StaticBoxes()).add(
                        element.shape, element.position.tolist(), IDENTITY
                    )
        self._masses = masses
        self._before: dict[int, FloatArray] = {}
        self._near: list[tuple[Robot, str]] = []
        self._hits: dict[tuple[int, str], None] = {}

    def begin_tick(self) -> None:
        """See who could hit what in this tick, and how fast."""
        self._hits.clear()
        self._near.clear()
        fast = [robot for robot in self._robots if robot.chassis.speed > 0.5 * _HIT] if self._boxes else []
        if not fast:
            return
        self._before = {robot.number: np.array(robot.chassis.vel) for robot in fast}
        for robot in fast:
            (x, y, _), reach = robot.chassis.pos, robot.chassis.reach(TICK) + _AHEAD
            self._near += [
                (robot, pattern) for pattern, boxes in self._boxes.items() if not boxes.is_clear(x, y, reach)
            ]

    def note(self) -> None:
        """Take in the contacts of the last sub-step."""
        for robot, pattern in self._near:
            if (robot.number, pattern) in self._hits:
                continue
            names = {self._world.body_name(row) for row in self._world.touching(robot.chassis.row)}
            if any(fnmatchcase(name, pattern) for name in names):
                self._hits[robot.number, pattern] = None

    def jolt(self) -> None:
        """Move what rests on the structures that were hit, at the end of the tick."""
        for number, pattern in self._hits:
            chassis = self._robots[number].chassis
            lost = self._before[number] - np.array(chassis.vel)
            lost[2] = 0.0
            if np.linalg.norm(lost) > _HIT:
                self._push(pattern, chassis.distribution.mass / self._masses[pattern] * lost)

    def _push(self, pattern: str, recoil: FloatArray) -> None:
        """Give the pieces that rest on a structure a velocity [m/s]; those on the floor beside it do not rest on it."""
        pieces = self._pieces
        slots = pieces.on_field()
        pos, reach = pieces.state.pos[slots], pieces.radius[slots] + _BESIDE
        is_on_it = self._boxes[pattern].are_near(pos, reach) & (pos[:, 2] > reach)
        slots = slots[is_on_it & np.isin(pieces.state.status[slots], _AT_REST)]
        if len(slots):
            pieces.push(slots, np.tile(recoil, (len(slots), 1)))
