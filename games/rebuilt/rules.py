"""Rules of a match of REBUILT: hubs, towers, fouls, game data and score breakdown."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from games.rebuilt.fouls import MAJOR, MINOR, Fouls
from games.rebuilt.fuel_ways import FuelWays
from games.rebuilt.human_players import HUMAN_PLAYERS, HumanPlayers
from games.rebuilt.scoring import ALLIANCES, ASSESSMENT, MATCH, UNCOUNTED, EventSettings, HubCount
from games.rebuilt.tower import TowerJudge
from simcore.channel import Channel
from simcore.match.game import PlayedMatch, Rules
from simcore.match.human_actions import HumanAction
from simcore.match.scoring import Alliance, ScoreEvent, ScoringZone, other_alliance

__all__ = ["RebuiltRules"]

_LEVELS = ("None", "Level1", "Level2", "Level3")
_WIN, _TIE = 3, 1


def _each(of: Callable[[Alliance], Any]) -> dict[str, Any]:
    return {alliance.capitalize(): of(alliance) for alliance in ALLIANCES}


class RebuiltRules(Rules):
    """Rules of one match: count of fuel in the hubs, tower levels, fouls and human players.

    Args:
        match: Match to judge.
        event: Settings of the event, such as thresholds for ranking points; None for the defaults.
    """

    channels = (
        Channel("Sim/Match/<Alliance>HubActive", "boolean", lambda r: _each(r.is_active),
                "fuel that the hub's sensors see now counts"),
        Channel("Sim/Match/<Alliance>HubLight", "string", lambda r: _each(r.hub_light),
                "`on`, `pulsing` (3 s before it goes inactive), `off`, `purple` after the match"),
        Channel("Sim/Match/<Alliance>OutpostFuel", "int",
                lambda r: _each(r.human_players.stock.__getitem__) if r.human_players else {},
                "fuel in chute and corral, in matches with human players"),
        Channel("Sim/Match/AutoTowerRobot<n>", "string", lambda r: r.levels(r.towers.auto_level),
                "level of each robot: `None`, `Level1` to `Level3`"),
        Channel("Sim/Match/EndGameTowerRobot<n>", "string", lambda r: r.levels(r.towers.final_level),
                "the same at the end of the match"),
    )  # fmt: skip

    def __init__(self, match: PlayedMatch, event: EventSettings | None = None) -> None:
        super().__init__(match)
        self.event = event or EventSettings()
        # alliance whose hub is inactive first in a tie, drawn relative to the first robot's alliance for symmetry
        own: Alliance = match.entries[0].alliance
        self._coin: Alliance = own if match.rules_rng.random() < 0.5 else other_alliance(own)
        self.ways = FuelWays(match)
        """Fuel inside the hubs and outside the field."""
        self._clear_points()

    def _clear_points(self) -> None:
        self.hubs = HubCount(self._coin, practice=self.match.practice)
        self.towers = TowerJudge(self.match)
        self.fouls = Fouls(self.match, self.towers)
        self._tower_points: dict[Alliance, int] = dict.fromkeys(ALLIANCES, 0)

    def is_active(self, alliance: Alliance, time: float | None = None) -> bool:
        """Return whether fuel that reaches the sensors at a match time [s] counts; None for the present time."""
        return self.hubs.period(alliance, self.match.timer.time if time is None else time) != UNCOUNTED

    def hub_light(self, alliance: Alliance) -> str:
        """Return the current state of the lights on an alliance's hub."""
        return self.hubs.light(alliance, self.match.timer.time)

    def levels(self, level: Callable[[int], int]) -> dict[str, str]:
        """Return the name of each robot's tower level, by robot number from 1.

        Args:
            level: Function that returns the level of a robot with a given number, from 0.
        """
        return {str(robot.number + 1): _LEVELS[level(robot.number)] for robot in self.match.robots}

    # --- hooks ----------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Create the human players if the option is on, and set the callback for fuel that leaves the field."""
        self.match.pieces.out_of_field = self._left_field
        self.human_players = HumanPlayers(self.match) if HUMAN_PLAYERS in self.match.options else None

    def start_mode(self, mode: str) -> None:
        """Clear all points when the autonomous period starts."""
        if mode == "auto":
            self._clear_points()

    def before_tick(self) -> None:
        """Release fuel from hubs, return fuel that left the field, and perform the human players' actions."""
        for slot in self.ways.act():
            self.fouls.emerged(slot)
        if self.human_players is not None:
            self.human_players.act()

    def worth(self, zone: ScoringZone) -> int:
        """Return the points for a fuel that enters a hub now: 0 if the fuel will not count at the hub's sensors."""
        return zone.points if self.is_active(zone.alliance, self._sensed) else 0

    def scored(self, event: ScoreEvent) -> None:
        """Count a scored fuel in the period of detection, judge G407, and put the fuel into the hub."""
        self.hubs.count(event.alliance, self._sensed)
        self.fouls.scored(event)
        self.ways.enter_hub(event.alliance, event.slot)

    def after_tick(self) -> None:
        """Judge fouls and towers, and add the change of tower points to the score."""
        self.fouls.after_tick()
        self.towers.after_tick()
        for alliance in ALLIANCES:
            points = int(math.fsum(self.towers.points(alliance)))
            if points != self._tower_points[alliance]:
                self.match.tracker.add(alliance, points - self._tower_points[alliance])
                self._tower_points[alliance] = points

    def human_actions(self) -> Sequence[HumanAction]:
        """Return the actions of human players at the outposts; empty without human players."""
        return () if self.human_players is None else self.human_players.actions

    def game_data(self) -> str:
        """Return `B` or `R` for the alliance whose hub is inactive first; empty before teleop."""
        return self.hubs.first_inactive[0].upper() if self.match.timer.time >= MATCH.start("transition") else ""

    def breakdown(self) -> Mapping[str, int]:
        """Return the score breakdown of both alliances, with the names in FIRST's score API."""
        rows: dict[str, int] = {}
        for alliance in ALLIANCES:
            (auto, final), book = self.towers.points(alliance), self.fouls.book
            hub, bonuses = self.hubs.hub_score(alliance), self._bonuses(alliance)
            own = {
                **{f"hubScore/{name}": count for name, count in hub.items()},
                "autoTowerPoints": auto,
                "endGameTowerPoints": final,
                "totalTowerPoints": auto + final,
                "totalAutoPoints": hub["autoPoints"] + auto,
                "totalTeleopPoints": hub["teleopPoints"] + final,
                "foulPoints": book.gained(alliance),
                "minorFoulCount": book.count(alliance, MINOR),
                "majorFoulCount": book.count(alliance, MAJOR),
                "totalPoints": hub["totalPoints"] + auto + final + book.gained(alliance),
                **bonuses,
                "rp": int(math.fsum((*bonuses.values(), self._result(alliance)))),
            }
            rows |= {f"{alliance.capitalize()}/{name}": count for name, count in own.items()}
        return rows

    # --- internals --------------------------------------------------------------------------------------------------

    @property
    def _sensed(self) -> float:
        """Match time at which the sensors detect a fuel that falls through a hub's throat now [s]."""
        return self.match.timer.time + self.event.sensor_delay

    def _left_field(self, slot: int) -> bool:
        """Judge a fuel that has left the field, and return whether field staff will return the fuel later."""
        self.fouls.left_field(slot, untouched=bool(self.match.pieces.is_untouched[slot]))
        return self.human_players is not None and self.ways.leave_field(slot)

    def _bonuses(self, alliance: Alliance) -> dict[str, int]:
        """Return an alliance's bonus ranking points by name, each 0 or 1."""
        fuel, event = self.hubs.counted(alliance), self.event
        tower = math.fsum(self.towers.points(alliance))
        return {
            "energizedAchieved": int(fuel >= event.energized),
            "superchargedAchieved": int(fuel >= event.supercharged),
            "traversalAchieved": int(tower >= event.traversal),
        }

    def _result(self, alliance: Alliance) -> int:
        """Return the ranking points for the result: 3 for a win, 1 for a tie, 0 for a loss or before the assessment."""
        totals, time = self.match.tracker.totals, self.match.timer.time
        if time < MATCH.duration + ASSESSMENT - 1e-9:
            return 0
        ahead = totals[alliance] - totals[other_alliance(alliance)]
        return _WIN if ahead > 0 else 0 if ahead < 0 else _TIE
