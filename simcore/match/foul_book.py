"""Fouls of a match: what is broken for several ticks on end is broken once."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass

from simcore.match.game import PlayedMatch
from simcore.match.scoring import Alliance, FoulEvent

__all__ = ["FoulBook"]

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
