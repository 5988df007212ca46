"""Sensors for game pieces in the robot: beam breaks and CANranges.

Simcore does not simulate the motion of pieces inside a robot. The storage contains only the pieces and the order of the
pieces. A sensor therefore detects the number of stored pieces, a piece in a claw, or a piece that has just entered or
left the robot.
"""

from __future__ import annotations

from collections.abc import Callable

from simcore.robot.robot import Robot
from simcore.robot_file.sensor_tables import PieceView
from simcore.units import TICK

__all__ = ["PieceSensor"]


class PieceSensor:
    """Beam break or CANrange that detects game pieces in the storage, in a claw, at an intake or at a shooter.

    Args:
        view: Location of the sensor, kinds of pieces that the sensor detects, and delays.
        robot: Robot in the match.
        kind_of: Function that returns the kind name of the piece in a slot.
    """

    def __init__(self, view: PieceView, robot: Robot, kind_of: Callable[[int], str]) -> None:
        self._view = view
        self._robot = robot
        self._kind_of = kind_of
        self._time = 0.0
        self._came: dict[int, float] = {slot: -view.delay for slot in self._stored()}
        self._held = set(robot.held)
        self._seen_until = 0.0

    def look(self) -> bool:
        """Advance the sensor by one tick; return whether the sensor detects a piece, or enough pieces in the storage.

        Call this method once per tick.
        """
        self._time += TICK
        view = self._view
        if view.place == "storage":
            return self._count_in_storage() >= view.at_least
        if view.place == "claw":
            held = (placer.piece for placer in self._robot.placers)
            return any(piece is not None and self._sees(piece) for piece in held)
        now = set(self._robot.held)
        passed = now - self._held if view.place == "intake" else self._held - now
        self._held = now
        if any(self._sees(slot) for slot in passed):
            self._seen_until = self._time + view.passing_time
        return self._time < self._seen_until - 1e-9

    def _count_in_storage(self) -> int:
        here = [slot for slot in self._stored() if self._sees(slot)]
        self._came = {slot: self._came.get(slot, self._time) for slot in here}
        latest = self._time - self._view.delay + 1e-9
        return len([slot for slot in here if self._came[slot] <= latest])

    def _stored(self) -> list[int]:
        """Return the slots of all pieces in the robot, except pieces in claws."""
        in_claws = {placer.piece for placer in self._robot.placers}
        return [slot for slot in self._robot.held if slot not in in_claws]

    def _sees(self, slot: int) -> bool:
        return not self._view.kinds or self._kind_of(slot) in self._view.kinds
