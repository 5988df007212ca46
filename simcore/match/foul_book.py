"""Fouls of a match: what is broken for several ticks on end is broken once; and which pieces robots let go."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass

from simcore.match.game import PlayedMatch
from simcore.match.scoring import Alliance, FoulEvent
from simcore.pieces.pool import ON_FIELD

__all__ = ["FoulBook", "PieceRelease", "Releases"]

_APART = 1.0  # [s]; ours: what is so again after a shorter pause is the same foul


@dataclass(slots=True)
class _Stretch:
    """Of time in which a rule is broken."""

    start: float
    last: float = -math.inf
    fouls: int = 0


class FoulBook:
    """Calls fouls.

    Args:
        match: Its tracker gets the events.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        self._broken: dict[Hashable, _Stretch] = {}

    def call(
        self, rule: str, robot: int, points: int, text: str, *about: Hashable, every: float = math.inf, later: int = 0
    ) -> None:
        """A robot breaks a rule in this tick; say so in each tick in which it does.

        Args:
            rule: As the manual numbers it.
            robot: Who.
            points: For the other alliance.
            text: What it does, as people read it.
            about: What else makes it another foul than one that the robot commits at the same time, e.g. whom it
                touches.
            every: For how long it may go on before it is another foul, and so on [s].
            later: Points of each of those.
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
        """What an alliance has broken so far, foul by foul."""
        return [foul.rule for foul in self._match.tracker.fouls if foul.alliance == alliance]

    def count(self, alliance: Alliance, points: int) -> int:
        """How many fouls of so many points an alliance has committed."""
        return len([1 for f in self._match.tracker.fouls if f.alliance == alliance and f.points == points])

    def gained(self, alliance: Alliance) -> int:
        """Points that an alliance has got by the other's fouls."""
        total = 0
        for foul in self._match.tracker.fouls:
            if foul.gains == alliance:
                total += foul.points
        return total


@dataclass(frozen=True, slots=True)
class PieceRelease:
    """A piece that a robot has let go."""

    slot: int
    """The piece."""
    robot: int
    speed: float
    """Away from the robot along the carpet, in the tick in which it left [m/s]."""


class Releases:
    """Follows who holds what: seen from outside, whatever held a piece, shot it or put it down.

    Args:
        match: Of which.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        self._holders: dict[int, int] = {}

    def update(self) -> list[PieceRelease]:
        """Pieces that have come out of a robot and onto the field since the last call; call it once a tick."""
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
