"""Who pins whom, and for how long: the counts that referees keep, as FIRST's manuals have worded them for years.

A robot pins an opponent while it prevents, by contact, the movement of one that tries to move. A count goes on until
the two have been apart, or one of them has been away from where it began, by six feet for three seconds, or until the
pinned robot pins the other one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, TypeAlias

from simcore.units import inches

if TYPE_CHECKING:
    from simcore.match.game import PlayedMatch
    from simcore.robot.robot import Robot

__all__ = ["PinCounts", "pins_of"]

_APART = inches(72.0)
_AWAY = 3.0  # [s] for which they have to be that far apart
_HELD_SPEED = 0.25  # [m/s]; ours: a robot that is faster is not prevented from moving
_BESIDE = 0.1  # [m]; ours: a robot this near to what stands is held between that and its opponent
_TRYING = 15.0  # [A] of a drive motor; ours: one that holds its heading takes less

Pin: TypeAlias = tuple[int, int]
"""Number of the robot that pins, and of the one that is pinned."""


@dataclass(slots=True)
class _Count:
    where: Mapping[int, tuple[float, float]]
    """Of both robots as it began [m]."""
    seconds: float = 0.0
    ended: float = 0.0
    """For how long they have been apart or away [s]."""
    fouls: int = 0


class PinCounts:
    """Counts of one match; pure rules, which are told who pins whom.

    Args:
        limit: For how long a pin may last, and how long each further one is [s].
    """

    def __init__(self, limit: float = 3.0) -> None:
        self._limit = limit
        self._counts: dict[Pin, _Count] = {}

    def seconds(self, pin: Pin) -> float:
        """How long a pin lasts [s], 0 if there is none."""
        return self._counts[pin].seconds if pin in self._counts else 0.0

    def update(self, dt: float, pins: set[Pin], places: Mapping[int, tuple[float, float]]) -> list[tuple[Pin, int]]:
        """Let a time pass.

        Args:
            dt: [s]
            pins: Who pins whom now.
            places: Of all robots, by number [m].

        Returns:
            Each pin that has just become a foul, and how many times it was one before.
        """
        found = []
        for pin in sorted(pins):
            self._counts.pop(pin[::-1], None)
            self._counts.setdefault(pin, _Count({number: places[number] for number in pin}))
        for pin, count in list(self._counts.items()):
            apart = math.dist(places[pin[0]], places[pin[1]])
            moved = max(math.dist(places[number], count.where[number]) for number in pin)
            count.ended = count.ended + dt if max(apart, moved) >= _APART else 0.0
            if count.ended >= _AWAY:
                del self._counts[pin]
                continue
            if pin in pins:
                count.seconds += dt
            if count.seconds > self._limit * (count.fouls + 1) + 1e-9:
                found.append((pin, count.fouls))
                count.fouls += 1
        return found


def pins_of(match: PlayedMatch) -> set[Pin]:
    """Who pins whom in this tick: the one that pins touches an opponent that tries to move and hardly does.

    The pinned one is held between the other and something that stands, or between two opponents; of two that push each
    other in the open field nobody is pinned.
    """
    sides = match.alliances
    touches = [(a, b) for a, b in sorted(match.contacts.robots) if sides[a] != sides[b]]
    pins: set[Pin] = set()
    for number, other in touches:
        held = match.robots[other]
        currents = chain(*(amps for group, amps in held.drive.motor_currents().items() if group != "steer"))
        if held.chassis.speed > _HELD_SPEED or max(map(abs, currents)) < _TRYING:
            continue
        if len([1 for a, b in touches if b == other]) > 1 or _is_at_something(match, held):
            pins.add((number, other))
    return pins


def _is_at_something(match: PlayedMatch, robot: Robot) -> bool:
    """Whether what stands on the field leaves a robot no room on one side."""
    body, chassis = robot.chassis.config, robot.chassis
    half = 0.5 * body.bumper_length + _BESIDE, 0.5 * body.bumper_width + _BESIDE
    height = chassis.pos[2]
    return match.world.is_in_solid(*chassis.pose, *half, height + body.clearance, height + body.bumper_top)
