"""The rules of scoring: phases of the match, and which hub counts when (game manual, MATCH PERIODS and HUB status)."""

from __future__ import annotations

import numpy as np

from simcore.match.clock import MatchClock, Phase
from simcore.match.scoring import Alliance, ScoringZone

__all__ = ["MATCH", "RebuiltScoring"]

MATCH = MatchClock(
    [
        Phase("auto", 20.0),
        Phase("pause", 3.0),  # the scoring delay between auto and teleop
        Phase("transition", 10.0),
        Phase("shift 1", 25.0),
        Phase("shift 2", 25.0),
        Phase("shift 3", 25.0),
        Phase("shift 4", 25.0),
        Phase("end game", 30.0),
    ]
)
"""2:43 of match: 20 s auto, 3 s pause, 2:20 teleop."""

_GRACE = 3.0  # [s] fuel that was shot before a hub went inactive still counts


class RebuiltScoring:
    """Which hub is active.

    Both are in auto, transition and end game. The alliance with more auto fuel is inactive in shifts 1 and 3, the
    other in 2 and 4; with equal fuel, chance decides.
    """

    def __init__(self, rng: np.random.Generator, *, favorite: Alliance = "blue", always_active: bool = False) -> None:
        """Toss the coin for a tie.

        Args:
            rng: Decides.
            favorite: Who is inactive first if the coin shows heads; the first robot's alliance, so that a mirrored
                match has the mirrored coin.
            always_active: Whether both hubs count all the time, for practice.
        """
        other: Alliance = "red" if favorite == "blue" else "blue"
        self._coin: Alliance = favorite if rng.random() < 0.5 else other
        self._always_active = always_active
        self._auto_points: dict[Alliance, int] = {"blue": 0, "red": 0}

    @property
    def first_inactive(self) -> Alliance:
        """Whose hub is inactive first: the game data character, `B` or `R`."""
        blue, red = self._auto_points["blue"], self._auto_points["red"]
        if blue == red:
            return self._coin
        return "blue" if blue > red else "red"

    def message(self, time: float) -> str:
        """The field's game data at a time of the match [s]: empty before teleop, then whose hub is inactive first."""
        return self.first_inactive[0].upper() if time >= MATCH.start("transition") else ""

    def restart(self) -> None:
        """Forget the auto fuel, as a match begins."""
        self._auto_points = {"blue": 0, "red": 0}

    def is_active(self, alliance: Alliance, time: float) -> bool:
        """Whether a hub counts at a time [s], with the grace after it went inactive."""
        if self._always_active:
            return True
        if time >= MATCH.duration:
            return time < MATCH.duration + _GRACE
        return self._is_on(alliance, time) or self._is_on(alliance, max(0.0, time - _GRACE))

    def worth(self, zone: ScoringZone, time: float) -> int:
        """Points of a fuel in a zone at a time [s]; notes auto fuel, which decides who is inactive first."""
        points = zone.points if self.is_active(zone.alliance, time) else 0
        if time <= MATCH.start("transition"):
            self._auto_points[zone.alliance] += points
        return points

    def _is_on(self, alliance: Alliance, time: float) -> bool:
        name = MATCH.phase(time).name
        if name in ("shift 1", "shift 3"):
            return alliance != self.first_inactive
        if name in ("shift 2", "shift 4"):
            return alliance == self.first_inactive
        return True
