"""Fouls that follow from the geometry of a match (game manual, section 7.4, as of team update 22)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

import numpy as np

from games.rebuilt import dimensions as dim
from games.rebuilt.scoring import ALLIANCES
from games.rebuilt.tower import TowerJudge
from simcore.match.foul_book import (
    FoulBook,
    PinCounts,
    Releases,
    is_airborne,
    is_carried,
    pins_of,
    reaches_into,
    robot_near,
)
from simcore.match.game import PlayedMatch
from simcore.match.scoring import Alliance, ScoreEvent
from simcore.pieces.pool import PieceStatus
from simcore.typing import FloatArray
from simcore.units import TICK

__all__ = ["MAJOR", "MINOR", "Fouls", "crosses_center", "is_closed", "is_outside_zone"]

MINOR, MAJOR = 5, 15
_ASLEEP, _HELD = int(PieceStatus.ASLEEP), int(PieceStatus.HELD)
_FEW_SECONDS = 3.0  # [s]; a violation that lasts this long is a further foul
_MOMENT = 0.5  # [s]; our choice: holding a piece for a shorter time is only momentary
_NEAR = 0.05  # [m]; our choice: a fuel this close to a robot's bumpers counts as touching
_PASSES = 0.7  # [m]; our choice: a robot does not fit through a narrower gap
_STANDS = 0.5  # [m/s]; our choice: a faster robot passes through and does not close off a passage


def is_outside_zone(outline: FloatArray) -> bool:
    """Return whether a robot is fully outside the robot's alliance zone; the line is part of the zone.

    Args:
        outline: Corners of the bumpers, flipped to the blue side [m], shape (4, 2).
    """
    return bool(outline[:, 0].min() > dim.ALLIANCE_ZONE_DEPTH)


def crosses_center(outline: FloatArray) -> bool:
    """Return whether a robot is completely across the center line.

    Args:
        outline: Corners of the bumpers, flipped to the blue side [m], shape (4, 2).
    """
    return bool(outline[:, 0].min() > dim.FIELD_CENTER[0])


def is_closed(passage: tuple[float, float], robots: Iterable[tuple[float, float]]) -> bool:
    """Return whether robots block a passage: no remaining gap is wide enough for another robot.

    Args:
        passage: Lower and upper y of the passage [m].
        robots: Lowest and highest y of each robot in the passage [m].
    """
    edge, widest = passage[0], 0.0
    for low, high in sorted(robots):
        widest, edge = max(widest, low - edge), max(edge, high)
    return max(widest, passage[1] - edge) < _PASSES


class Fouls:
    """Judge of fouls in auto and teleop of one match.

    Args:
        match: Match to judge.
        towers: Judge of the tower levels; some fouls change the levels that count.
    """

    def __init__(self, match: PlayedMatch, towers: TowerJudge) -> None:
        self._match, self._towers = match, towers
        self.book = FoulBook(match)
        """Record of the fouls called so far."""
        self._releases = Releases(match)
        self._pins = PinCounts(_FEW_SECONDS)
        self._shots: dict[int, tuple[int, bool]] = {}  # by slot: robot that shot the fuel; if outside the zone
        self._emerged: dict[int, int] = {}  # by slot of fuel out of a hub: first robot in contact, or -1
        self._kept: dict[int, float] = {}  # by slot of such fuel: time at which a robot took the fuel [s]
        self._thrown: dict[int, int] = {}  # number of fuel that each robot has thrown off the field
        self._closed: dict[tuple[Alliance, str], float] = {}  # time for which passages have been closed [s]

    # --- events from the rules --------------------------------------------------------------------------------------

    def emerged(self, slot: int) -> None:
        """Record a fuel that has come out of a hub."""
        self._emerged[slot] = -1

    def scored(self, event: ScoreEvent) -> None:
        """Judge G407: a robot fully outside the alliance zone has shot a fuel that scores in the robot's own hub.

        Several fuel of one volley give one foul.
        """
        robot, outside = self._shots.pop(event.slot, (-1, False))
        if outside and event.alliance == self._match.alliances[robot]:
            self.book.call("G407", robot, MAJOR, "shoots into its hub from outside of its alliance zone")

    def left_field(self, slot: int, *, untouched: bool) -> None:
        """Judge G405: a robot throws fuel off the field; a fuel that had a contact after the shot is no foul.

        The first fuel of each robot is a minor foul, and each further fuel is a major foul.
        """
        robot, _ = self._shots.pop(slot, (-1, False))
        if robot >= 0 and untouched:
            before = self._thrown.get(robot, 0)
            self._thrown[robot] = before + 1
            self.book.call("G405", robot, MAJOR if before else MINOR, "throws fuel off the field", slot)

    # --- once a tick ------------------------------------------------------------------------------------------------

    def after_tick(self) -> None:
        """Judge the fouls of a tick, after motion and scoring; judge nothing while robots are disabled."""
        match = self._match
        for piece in self._releases.update():
            self._shots[piece.slot] = piece.robot, is_outside_zone(match.outline(piece.robot))
        if not match.timer.is_enabled or match.timer.is_over:
            return
        shots = np.array(list(self._shots), dtype=np.int64)
        for slot in shots[match.pieces.state.status[shots] == _ASLEEP].tolist():
            del self._shots[slot]
        self._judge_emerged()
        if len(match.robots) > 1:
            self._judge_contacts()
            self._judge_pins()
            self._judge_passages()

    def _judge_emerged(self) -> None:
        """Judge G408: a robot keeps a fuel that came out of a hub and touched this robot before any other object."""
        match, pieces, slots = self._match, self._match.pieces, list(self._emerged)
        if not slots:
            return
        state, reach = pieces.state, pieces.types[0].bounding_radius + _NEAR
        holders = np.where(state.status[slots] == _HELD, state.holder[slots], -1).tolist()
        places, untouched = state.pos[slots], pieces.is_untouched[slots].tolist()
        for slot, holder, place, is_untouched in zip(slots, holders, places, untouched, strict=True):
            met = self._emerged[slot]
            if holder >= 0:
                since = self._kept.setdefault(slot, match.time)
                if met != holder or match.time - since > _MOMENT:
                    if met == holder:
                        self.book.call("G408", holder, MINOR, "keeps fuel as it comes out of a hub")
                    del self._emerged[slot], self._kept[slot]
            elif slot in self._kept:
                del self._emerged[slot], self._kept[slot]
            elif met < 0 and not is_untouched:
                self._emerged[slot] = robot_near(match.robots, place[:2], reach)
                if self._emerged[slot] < 0:
                    del self._emerged[slot]
            elif met >= 0 and place[2] < pieces.types[0].rest_height + _NEAR:
                del self._emerged[slot]  # the fuel has touched the carpet

    def _judge_contacts(self) -> None:
        match, phase = self._match, self._match.timer.phase
        touches = sorted(match.contacts.robots)
        for number, other in touches:
            if match.alliances[number] == match.alliances[other]:
                if is_carried(match, other, number):
                    self._towers.carried.add(other)  # G414
                continue
            if phase.mode == "auto" and crosses_center(match.outline(number)):
                self.book.call("G403", number, MAJOR, f"touches robot {other} across the center line", other)
            if reaches_into(match.robots[number], match.robots[other]):
                self.book.call("G415", number, MINOR, f"reaches into robot {other}", other)
        if phase.name == "end game":
            for number, other in sorted({*touches, *self._by_fuel()}):
                if match.alliances[number] != match.alliances[other] and self._is_at_tower(other):
                    self.book.call("G420", number, MAJOR, f"touches robot {other} at its tower", other)
                    if is_airborne(match.robots[other]):
                        self._towers.awarded.add(other)

    def _is_at_tower(self, number: int) -> bool:
        """Return whether a robot touches its own alliance's tower."""
        own = f"{self._match.alliances[number]}_tower_*"
        return any(fnmatchcase(name, own) for name in self._match.contacts.elements(number))

    def _by_fuel(self) -> set[tuple[int, int]]:
        """Return pairs of robots that touch the same fuel, in both orders.

        The set is empty if no robot touches its own alliance's tower.
        """
        match = self._match
        climbing = [robot.number for robot in match.robots if self._is_at_tower(robot.number)]
        if not climbing:
            return set()
        pairs = set()
        for slot in match.pieces.in_contact.tolist():
            touching = match.contacts.touching_piece(slot)
            pairs |= {(a, b) for a in touching for b in touching if a != b}
        return pairs

    def _judge_pins(self) -> None:
        """Judge G418: a robot pins an opponent for too long."""
        match = self._match
        places = {robot.number: robot.chassis.pose[:2] for robot in match.robots}
        for (number, other), before in self._pins.update(TICK, pins_of(match), places):
            self.book.call("G418", number, MAJOR if before else MINOR, f"pins robot {other}", other, before)

    def _judge_passages(self) -> None:
        """Judge G419: robots of an alliance close off both trenches or both bumps of one side for over 3 s."""
        match = self._match
        for alliance in ALLIANCES:
            slow = [
                robot.number
                for robot in match.robots
                if match.alliances[robot.number] == alliance and robot.chassis.speed < _STANDS
            ]
            stand = [_extent(match.outline(number)) for number in slow] if len(slow) > 1 else []
            for name, passages in _PASSAGES.items():
                for side, middle in (("own", dim.HUB_CENTER[0]), ("other", dim.FIELD_LENGTH - dim.HUB_CENTER[0])):
                    key = (alliance, f"both {name} of the {side} side")
                    closed = bool(stand) and _are_closed(passages, stand, middle)
                    self._closed[key] = self._closed.get(key, 0.0) + TICK if closed else 0.0
                    if self._closed[key] > _FEW_SECONDS:
                        robot = match.alliances.index(alliance)
                        text = f"and partners close off {key[1]}"
                        self.book.call("G419", robot, MAJOR, text, *key, every=_FEW_SECONDS, later=MAJOR)


_PASSAGES = {
    "trenches": tuple(
        (y - 0.5 * dim.TRENCH_CLEAR_WIDTH, y + 0.5 * dim.TRENCH_CLEAR_WIDTH)
        for y in (dim.TRENCH_LEFT_Y, dim.TRENCH_RIGHT_Y)
    ),
    "bumps": tuple((y - 0.5 * dim.BUMP_WIDTH, y + 0.5 * dim.BUMP_WIDTH) for y in (dim.BUMP_LEFT_Y, dim.BUMP_RIGHT_Y)),
}


def _extent(outline: FloatArray) -> tuple[float, float, float, float]:
    """Return the lowest x, lowest y, highest x and highest y of an outline [m]."""
    (x, y), (far_x, far_y) = outline.min(axis=0).tolist(), outline.max(axis=0).tolist()
    return x, y, far_x, far_y


def _are_closed(
    passages: Sequence[tuple[float, float]], robots: Sequence[tuple[float, float, float, float]], middle: float
) -> bool:
    """Return whether robots close off all passages of a side.

    Args:
        passages: Lower and upper y of each passage [m].
        robots: Lowest x, lowest y, highest x and highest y of each robot [m].
        middle: x of the passages' center [m].
    """
    reach = 0.5 * dim.HUB_SIZE
    spans = [(low, high) for x, low, far_x, high in robots if x < middle + reach and far_x > middle - reach]
    return all(
        is_closed(passage, [s for s in spans if s[1] > passage[0] and s[0] < passage[1]]) for passage in passages
    )
