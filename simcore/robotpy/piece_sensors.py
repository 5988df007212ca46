"""Sensors that see pieces in the robot: beam breaks and CANranges.

Pieces in a robot are not simulated one by one: a robot's storage knows which it holds and in which order they came. A
sensor asks it how many there are, or whether one has just come or gone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from simcore.robot.robot import Robot
from simcore.robot_file.device_settings import PieceView
from simcore.robotpy.port_devices import Switch
from simcore.units import TICK

__all__ = ["BeamBreak", "DistanceSensor", "PieceEye", "PieceRange"]


class DistanceSensor(Protocol):
    """A sensor of distance: `CANrangeSim`."""

    def write(self, distance: float) -> None:
        """Set the distance to what is in front of it [m]."""
        ...


class PieceEye:
    """Whether a sensor sees a piece now.

    Args:
        view: Which pieces it sees, and where.
        robot: In the match.
        kind_of: Name of the kind of a piece, by its slot.
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
        """Look, once a tick."""
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
        """Slots of all pieces in the robot but those in claws."""
        in_claws = {placer.piece for placer in self._robot.placers}
        return [slot for slot in self._robot.held if slot not in in_claws]

    def _sees(self, slot: int) -> bool:
        return not self._view.kinds or self._kind_of(slot) in self._view.kinds


class BeamBreak:
    """A light barrier.

    Args:
        eye: What breaks its beam.
        switch: Where it is wired to.
    """

    def __init__(self, eye: PieceEye, switch: Switch) -> None:
        self._eye = eye
        self._switch = switch
        self.is_active = False
        """Whether the beam is broken."""

    def update(self) -> None:
        """After a tick."""
        self.is_active = self._eye.look()
        self._switch.set_active(self.is_active)


class PieceRange:
    """A CANrange that looks where pieces come by.

    Args:
        eye: What it sees.
        sensor: The device.
        distance: To a piece [m].
        empty: To what is behind [m].
    """

    def __init__(self, eye: PieceEye, sensor: DistanceSensor, *, distance: float, empty: float) -> None:
        self._eye = eye
        self._sensor = sensor
        self._distances = (empty, distance)
        self.is_active = False
        """Whether a piece is in front of it."""

    def update(self) -> None:
        """After a tick."""
        self.is_active = self._eye.look()
        self._sensor.write(self._distances[self.is_active])
