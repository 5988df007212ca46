"""The rules of scoring: phases of the match, and which hub counts when (game manual, MATCH PERIODS and HUB status)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from games.rebuilt.field import hub_exit
from simcore.match.clock import MatchClock, Phase
from simcore.match.game import Rules
from simcore.match.match_state import MatchState
from simcore.match.scoring import Alliance, ScoreEvent, ScoringZone, other_alliance

__all__ = ["HUB_EXITS", "MATCH", "RebuiltRules"]

MATCH = MatchClock(
    [
        Phase("auto", 20.0, "auto"),
        Phase("pause", 3.0, "disabled"),  # the scoring delay between auto and teleop
        Phase("transition", 10.0),
        Phase("shift 1", 25.0),
        Phase("shift 2", 25.0),
        Phase("shift 3", 25.0),
        Phase("shift 4", 25.0),
        Phase("end game", 30.0),
    ]
)
"""2:43 of match: 20 s auto, 3 s pause, 2:20 teleop."""

HUB_EXITS = "hub_exits"
"""Option: scored fuel comes out of the hub's exits into the neutral zone, as on the real field."""

_GRACE = 3.0  # [s] fuel that was shot before a hub went inactive still counts


class RebuiltRules(Rules):
    """Which hub is active, and what a fuel is worth in it.

    Both are in auto, transition and end game. The alliance with more auto fuel is inactive in shifts 1 and 3, the
    other in 2 and 4; with equal fuel, chance decides. In practice both count all the time.
    """

    def __init__(self, match: MatchState) -> None:
        super().__init__(match)
        self._auto_points: dict[Alliance, int] = {"blue": 0, "red": 0}
        # who is inactive first in a tie: counted from the first robot's alliance, so that red is blue flipped
        own: Alliance = match.entries[0].alliance
        self._coin: Alliance = own if match.rules_rng.random() < 0.5 else other_alliance(own)

    @property
    def first_inactive(self) -> Alliance:
        """Whose hub is inactive first."""
        blue, red = self._auto_points["blue"], self._auto_points["red"]
        if blue == red:
            return self._coin
        return "blue" if blue > red else "red"

    def is_active(self, alliance: Alliance, time: float | None = None) -> bool:
        """Whether a hub counts at a time of the match [s], now if none is given, with the grace after it goes off."""
        now = self.match.timer.time if time is None else time
        if self.match.practice:
            return True
        if now >= MATCH.duration:
            return now < MATCH.duration + _GRACE
        return self._is_on(alliance, now) or self._is_on(alliance, max(0.0, now - _GRACE))

    # --- hooks ----------------------------------------------------------------------------------------------------

    def start_mode(self, mode: str) -> None:
        """An auto begins without auto fuel."""
        if mode == "auto":
            self._auto_points = {"blue": 0, "red": 0}

    def worth(self, zone: ScoringZone) -> int:
        """One point in an active hub."""
        return zone.points if self.is_active(zone.alliance) else 0

    def scored(self, event: ScoreEvent) -> None:
        """Auto fuel decides who is inactive first; it counts until teleop starts. The hub lets the fuel out again."""
        if self.match.timer.time <= MATCH.start("transition"):
            self._auto_points[event.alliance] += event.points
        if HUB_EXITS in self.match.options:
            slot = np.array([event.slot])
            pos, vel = hub_exit(event.alliance, self.match.rules_rng)
            self.match.pieces.release(slot, pos[None, :])
            self.match.pieces.push(slot, vel[None, :], flying=True)

    def game_data(self) -> str:
        """Empty before teleop, then `B` or `R`: whose hub is inactive first."""
        return self.first_inactive[0].upper() if self.match.timer.time >= MATCH.start("transition") else ""

    def breakdown(self) -> Mapping[str, int]:
        """Auto fuel by alliance."""
        return {"BlueAutoFuel": self._auto_points["blue"], "RedAutoFuel": self._auto_points["red"]}

    def telemetry(self) -> Mapping[str, float | int | bool | str]:
        """The hubs' states."""
        return {
            "Sim/Match/BlueHubActive": self.is_active("blue"),
            "Sim/Match/RedHubActive": self.is_active("red"),
        }

    def _is_on(self, alliance: Alliance, time: float) -> bool:
        name = MATCH.phase(time).name
        if name in ("shift 1", "shift 3"):
            return alliance != self.first_inactive
        if name in ("shift 2", "shift 4"):
            return alliance == self.first_inactive
        return True
