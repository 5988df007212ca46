"""Fouls that follow from contacts, positions, and the pieces that robots hold, take, launch or place."""

from __future__ import annotations

import math

from games.reefscape import dimensions as dim
from games.reefscape.field import ALLIANCES, FIELD
from simcore.match.foul_book import FoulBook, PinCounts, Releases, pins_of
from simcore.match.game import PlayedMatch
from simcore.pieces.pool import PieceStatus
from simcore.pieces.resting_places import PlaceEvent
from simcore.units import TICK
from simcore.world.footprints import corners, hexagon, overlaps

__all__ = ["BARGE_ZONE", "REEF_ZONE", "Fouls"]

_MINOR, _MAJOR = 2, 6
_FEW_SECONDS = 3.0  # [s]; time limit for a pin, and for a second robot beyond the barge
_LAUNCHED = 1.5  # [m/s], horizontal, relative to the robot; our choice: a coral that is only released is slower
_KNOCKED = 1.0  # [s]; our choice: longest time between a robot's contact with a coral and the fall of the coral

REEF_ZONE = hexagon(dim.REEF_CENTER, dim.REEF_ZONE_APOTHEM)
"""Corners of blue's reef zone, in order around the zone [m], shape (6, 2)."""
_FAR_EDGE = dim.FIELD_CENTER[0] + 0.5 * dim.BARGE_ZONE_DEPTH
_BARGE_Y = dim.FIELD_WIDTH - 0.5 * dim.BARGE_ZONE_WIDTH
BARGE_ZONE = corners(dim.FIELD_CENTER[0], _BARGE_Y, 0.0, dim.BARGE_ZONE_DEPTH, dim.BARGE_ZONE_WIDTH)
"""Corners of blue's barge zone, in order around the zone [m], shape (4, 2)."""


class Fouls:
    """Judge of fouls in auto and teleop of one match.

    Args:
        match: Match to judge.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        self.book = FoulBook(match)
        """Record of the fouls called so far."""
        self._releases = Releases(match)
        self._pins = PinCounts(_FEW_SECONDS)
        self._owners = {body.config.name: body.config.alliance for body in match.hanging}
        self._released: dict[int, int] = {}  # by slot of algae not yet at rest: robot that released the algae
        self._touched: dict[int, tuple[int, float]] = {}  # by slot of coral: last robot in contact, and time

    def after_tick(self) -> None:
        """Judge the fouls of a tick, after motion and scoring; judge nothing while robots are disabled."""
        match, released = self._match, self._releases.update()
        if not match.timer.is_enabled or match.timer.is_over:
            return
        self._judge_contacts()
        for robot in match.robots:
            kinds = [match.pieces.kind_name(slot) for slot in robot.held]
            for kind in sorted({kind for kind in kinds if kinds.count(kind) > 1}):
                self.book.call("G409", robot.number, _MINOR, f"holds more than one {kind.lower()}", kind)
        for piece in released:
            if match.pieces.kind_name(piece.slot) == "Algae":
                self._released[piece.slot] = piece.robot
            elif piece.speed > _LAUNCHED and not overlaps(match.outline(piece.robot), REEF_ZONE):
                self.book.call("G412", piece.robot, _MAJOR, "launches a coral outside of its reef zone", piece.slot)
        self._judge_released()
        places = {robot.number: robot.chassis.pose[:2] for robot in match.robots}
        for (number, other), before in self._pins.update(TICK, pins_of(match), places):
            self.book.call("G425", number, _MAJOR if before else _MINOR, f"pins robot {other}", other, before)
        for alliance in ALLIANCES:
            own = [robot.number for robot in match.robots if match.alliances[robot.number] == alliance]
            beyond = [number for number in own if self._is_beyond(number)]
            for number in beyond[1:]:
                text = "is a second robot beyond the barge"
                self.book.call("G421", number, _MINOR, text, every=_FEW_SECONDS, later=_MAJOR)

    def removed(self, event: PlaceEvent) -> None:
        """Judge G410: a robot takes or knocks a coral off the opponents' reef.

        A robot has knocked the coral off if the robot touched the coral less than 1 s before the fall.
        """
        touched, time = self._touched.get(event.slot, (-1, -math.inf))
        robot = event.holder if event.holder >= 0 else touched if self._match.time - time < _KNOCKED else -1
        if robot >= 0 and "Coral" in event.place.kinds:
            if event.place.alliance != self._match.alliances[robot]:
                self.book.call("G410", robot, _MAJOR, f"takes a coral off {event.place.name}", event.slot)

    # --- internals ------------------------------------------------------------------------------------------------

    def _is_beyond(self, number: int) -> bool:
        """Return whether a robot is completely beyond the barge, on the opponents' side."""
        return bool(self._match.outline(number)[:, 0].min() > _FAR_EDGE)

    def _judge_contacts(self) -> None:
        match, contacts = self._match, self._match.contacts
        mode, is_late = match.timer.phase.mode, match.timer.phase.name == "end game"
        for number, cage in sorted(contacts.hanging):
            if self._owners[cage] != match.alliances[number]:
                self.book.call("G405" if mode == "auto" else "G418", number, _MAJOR, f"touches {cage}", cage)
        for number, other in sorted(contacts.robots):
            if match.alliances[number] == match.alliances[other]:
                continue
            outline = match.outline(other)
            if mode == "auto":
                if self._is_beyond(number):
                    self.book.call("G403", number, _MAJOR, f"touches robot {other} beyond the barge", other)
            elif is_late and self._climbs(other):
                self.book.call("G428", number, _MAJOR, f"touches robot {other} at its cage", other)
            elif overlaps(outline, REEF_ZONE) or overlaps(outline, BARGE_ZONE):
                self.book.call("G427", number, _MAJOR, f"touches robot {other} in its zone", other)
        for slot in match.pieces.places.woken.tolist():
            for number in contacts.touching_piece(slot):
                self._touched[slot] = number, match.time

    def _climbs(self, number: int) -> bool:
        """Return whether a robot hangs on or touches a cage of the robot's alliance."""
        rungs = [climber.rung for climber in self._match.robots[number].climbers]
        owners = [rung.alliance for rung in rungs if rung]
        owners += [self._owners[cage] for robot, cage in self._match.contacts.hanging if robot == number]
        return self._match.alliances[number] in owners

    def _judge_released(self) -> None:
        """Judge G411: an algae released by a robot has come to rest on the opponents' reef."""
        match, state = self._match, self._match.pieces.state
        for slot, number in list(self._released.items()):
            if state.status[slot] in (PieceStatus.AWAKE, PieceStatus.IN_FLIGHT):
                continue
            del self._released[slot]
            x, y, z = state.pos[slot].tolist()
            if match.alliances[number] == "blue":
                x, y = FIELD.symmetry.flip_point(x, y)
            is_there = z > dim.TROUGH_EDGE_HEIGHT and math.dist((x, y), dim.REEF_CENTER) < dim.REEF_ZONE_APOTHEM
            if is_there and state.status[slot] == PieceStatus.ASLEEP:
                self.book.call("G411", number, _MAJOR, "lays an algae on the other reef", slot)
