"""Functions for rules about fouls: foul record, pin counts, released pieces, and tests of robot contact and reach."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import TypeAlias

import numpy as np

from simcore.match.game import PlayedMatch
from simcore.match.scoring import Alliance, FoulEvent
from simcore.pieces.pool import ON_FIELD
from simcore.robot.chassis import ground_clearance
from simcore.robot.robot import Robot
from simcore.typing import FloatArray
from simcore.units import inches
from simcore.world.footprints import corners, overlaps
from simcore.world.rotation import rotate

__all__ = [
    "FoulBook",
    "PieceRelease",
    "PinCounts",
    "Releases",
    "is_airborne",
    "is_carried",
    "lowest_bumper",
    "pins_of",
    "reaches_into",
    "robot_near",
]

_APART = 1.0  # [s]; our choice: a repeat after a shorter pause is the same violation


@dataclass(slots=True)
class _Stretch:
    """Violation of a rule, with interruptions of at most 1 s."""

    start: float
    last: float = -math.inf
    fouls: int = 0


class FoulBook:
    """Record of rule violations that calls one foul for a violation that lasts several ticks.

    Args:
        match: Match in whose `tracker` the fouls are recorded.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        self._broken: dict[Hashable, _Stretch] = {}

    def call(
        self, rule: str, robot: int, points: int, text: str, *about: Hashable, every: float = math.inf, later: int = 0
    ) -> None:
        """Record that a robot violates a rule in this tick; call a foul at the start of the violation.

        Call the method in each tick of the violation. A violation that resumes within 1 s is the same violation.

        Args:
            rule: Number of the rule in the manual.
            robot: Number of the robot.
            points: Points for the other alliance.
            text: Description of the violation, worded to follow "robot 0" in a message.
            about: Further keys that distinguish this violation from simultaneous violations of the same rule by the
                same robot, e.g. the number of the opponent.
            every: Duration after which a continued violation is a further foul [s].
            later: Points for each further foul of a continued violation.
        """
        match, key = self._match, (rule, robot, *about)
        now = self._broken.get(key)
        if now is None or match.time - now.last > _APART:
            now = self._broken[key] = _Stretch(match.time)
        now.last = match.time
        if now.fouls == 0 or now.last - now.start > now.fouls * every - 1e-9:
            worth = later if now.fouls else points
            match.tracker.foul(FoulEvent(match.time, rule, robot, match.alliances[robot], worth, text))
            now.fouls += 1

    def rules(self, alliance: Alliance) -> list[str]:
        """Return the rule number of each foul that an alliance has committed so far, oldest first."""
        return [foul.rule for foul in self._match.tracker.fouls if foul.alliance == alliance]

    def count(self, alliance: Alliance, points: int) -> int:
        """Return the number of an alliance's fouls that give a certain number of points to the opponents."""
        return len([1 for f in self._match.tracker.fouls if f.alliance == alliance and f.points == points])

    def gained(self, alliance: Alliance) -> int:
        """Return the points that an alliance has received for fouls of the opposing alliance."""
        total = 0
        for foul in self._match.tracker.fouls:
            if foul.gains == alliance:
                total += foul.points
        return total


@dataclass(frozen=True, slots=True)
class PieceRelease:
    """Release of a piece by a robot: piece, robot and speed."""

    slot: int
    """Slot of the piece."""
    robot: int
    speed: float
    """Horizontal speed of the piece relative to the robot, at the end of the tick of the release [m/s]."""


class Releases:
    """Detector of pieces that robots release from hoppers, shooters and placers.

    Args:
        match: Match whose robots and pieces are tracked.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        self._holders: dict[int, int] = {}

    def update(self) -> list[PieceRelease]:
        """Return the releases of pieces onto the field or into the air since the last call.

        Call the method once per tick.
        """
        match, state = self._match, self._match.pieces.state
        now = {slot: robot.number for robot in match.robots for slot in robot.held}
        found = []
        for slot, number in self._holders.items():
            if slot not in now and state.status[slot] in ON_FIELD:
                vx, vy, _ = match.robots[number].chassis.origin_velocity
                speed = math.hypot(state.vel[slot, 0] - vx, state.vel[slot, 1] - vy)
                found.append(PieceRelease(slot, number, speed))
        self._holders = now
        return found


_PIN_APART = inches(72.0)
_PIN_AWAY = 3.0  # [s]; a pin ends when the robots have been `_PIN_APART` apart for this time
_HELD_SPEED = 0.25  # [m/s]; our choice: a faster robot is not pinned
_BESIDE = 0.1  # [m]; our choice: a robot this close to a static element can be pinned against the element
_TRYING = 15.0  # [A] of a drive motor; our choice: a robot that only holds the heading draws less

Pin: TypeAlias = tuple[int, int]
"""Numbers of the pinning robot and the pinned robot."""


@dataclass(slots=True)
class _PinCount:
    where: Mapping[int, tuple[float, float]]
    """Position of each of the two robots at the start of the count, field frame [m], by robot number."""
    seconds: float = 0.0
    ended: float = 0.0
    """Time for which the robots, or a robot and the position in `where`, have been six feet apart [s]."""
    fouls: int = 0


class PinCounts:
    """Pin counts of one match under the PIN rule of FIRST's game manuals.

    A robot pins an opponent if the contact keeps the opponent from moving although the opponent tries to move. A count
    pauses while the robot does not pin the opponent. A count ends after three seconds with the robots six feet apart or
    with one of the robots six feet away from the position at the start of the count. A count also ends when the pinned
    robot pins the other robot.

    Args:
        limit: Longest allowed pin, and additional time of a pin until each further foul [s].
    """

    def __init__(self, limit: float = 3.0) -> None:
        self._limit = limit
        self._counts: dict[Pin, _PinCount] = {}

    def seconds(self, pin: Pin) -> float:
        """Return the duration of a pin so far [s]; 0 if there is no count for the pin."""
        return self._counts[pin].seconds if pin in self._counts else 0.0

    def update(self, dt: float, pins: set[Pin], places: Mapping[int, tuple[float, float]]) -> list[tuple[Pin, int]]:
        """Advance all pin counts by one time step.

        Args:
            dt: Time step [s].
            pins: Pins in this tick.
            places: Positions of all robots, field frame [m], by robot number.

        Returns:
            Each pin that has just become a foul, with the number of earlier fouls for the same pin.
        """
        found = []
        for pin in sorted(pins):
            self._counts.pop(pin[::-1], None)
            self._counts.setdefault(pin, _PinCount({number: places[number] for number in pin}))
        for pin, count in list(self._counts.items()):
            apart = math.dist(places[pin[0]], places[pin[1]])
            moved = max(math.dist(places[number], count.where[number]) for number in pin)
            count.ended = count.ended + dt if max(apart, moved) >= _PIN_APART else 0.0
            if count.ended >= _PIN_AWAY:
                del self._counts[pin]
                continue
            if pin in pins:
                count.seconds += dt
            if count.seconds > self._limit * (count.fouls + 1) + 1e-9:
                found.append((pin, count.fouls))
                count.fouls += 1
        return found


def pins_of(match: PlayedMatch) -> set[Pin]:
    """Return the pins of this tick: each pair of a robot and an opponent that the robot holds in place.

    The robots of a pair touch. A drive motor of the pinned robot draws at least 15 A, but the pinned robot moves at
    0.25 m/s or less. The pinned robot is also close to a static element, or touches a second opponent. Robots that push
    each other in the open field do not pin.
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
    """Return whether a robot's bumpers are within 0.1 m of a static element of the field."""
    body, chassis = robot.chassis.config, robot.chassis
    half = 0.5 * body.bumper_length + _BESIDE, 0.5 * body.bumper_width + _BESIDE
    height = chassis.pos[2]
    return match.world.is_in_solid(*chassis.pose, *half, height + body.clearance, height + body.bumper_top)


def is_airborne(robot: Robot) -> bool:
    """Return whether no wheel of a robot touches the ground."""
    return ground_clearance(*robot.chassis.wheel_ground()).is_airborne


def lowest_bumper(robot: Robot) -> float:
    """Return the height of the lowest point of a robot's bumpers above the carpet [m]."""
    body, chassis = robot.chassis.config, robot.chassis
    x, y = 0.5 * body.bumper_length, 0.5 * body.bumper_width
    return chassis.pos[2] + min(rotate(chassis.quat, (a, b, body.clearance))[2] for a in (-x, x) for b in (-y, y))


def robot_near(robots: Sequence[Robot], place: FloatArray, reach: float) -> int:
    """Return the number of the first robot with bumpers within reach of a point, seen from above; -1 for no robot.

    Args:
        robots: Robots to test, in order.
        place: Point, field frame [m], shape (2,).
        reach: Largest distance of the point from the bumpers, along the x or y axis of the robot [m].
    """
    for robot in robots:
        body = robot.chassis.config
        size = body.bumper_length + 2.0 * reach, body.bumper_width + 2.0 * reach
        if overlaps(corners(*robot.chassis.pose, *size), place[None]):
            return robot.number
    return -1


def is_carried(match: PlayedMatch, number: int, by: int) -> bool:
    """Return whether a robot is above another robot, and touches neither the ground nor a field element.

    Args:
        match: Match of the robots.
        number: Number of the upper robot.
        by: Number of the lower robot.
    """
    above, below = match.robots[number], match.robots[by]
    is_higher = above.chassis.pos[2] > below.chassis.pos[2] + above.chassis.config.clearance
    return is_higher and is_airborne(above) and not match.contacts.elements(number)


def reaches_into(robot: Robot, other: Robot) -> bool:
    """Return whether an active intake extends past a robot's bumpers and into the frame perimeter of another robot."""
    body, frame = other.chassis.config, 2.0 * other.chassis.config.bumper_thickness
    perimeter = corners(*other.chassis.pose, body.bumper_length - frame, body.bumper_width - frame)
    return any(overlaps(perimeter, outline) for outline in _reaching_out(robot))


def _reaching_out(robot: Robot) -> list[FloatArray]:
    """Return the outline of each active intake that extends past the front or rear bumper, field frame [m].

    An outline contains only the part of the zone outside of the bumpers, shape (4, 2). For an intake on a moving part,
    the outline is the center of the zone, shape (1, 2).
    """
    (px, py, yaw), outlines = robot.chassis.pose, []
    c, s, half = math.cos(yaw), math.sin(yaw), 0.5 * robot.chassis.config.bumper_length
    for intake in robot.intakes:
        if not intake.is_active:
            continue
        ends = np.array([intake.around[1][:2]])
        if not intake.config.joints:
            zone = intake.zone
            ends = np.array([(x, y) for x in (zone.x_min, zone.x_max) for y in (zone.y_min, zone.y_max)])[[0, 1, 3, 2]]
        if np.abs(ends[:, 0]).max() > half:
            ends[:, 0] = np.where(np.abs(ends[:, 0]) < half, np.copysign(half, ends[:, 0]), ends[:, 0])
            x, y = ends.T
            outlines.append(np.column_stack((px + c * x - s * y, py + s * x + c * y)))
    return outlines
