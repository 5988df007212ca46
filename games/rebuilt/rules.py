"""The rules of a match of REBUILT, hook by hook: hubs, tower, fouls, game data, and the final score sheet."""

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
    """Counts fuel as the hubs' sensors see it, judges towers and fouls, and lets human players act.

    Args:
        match: Which is played.
        event: Thresholds of ranking points, and what else differs from event to event.
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
                "the same at the end"),
    )  # fmt: skip

    def __init__(self, match: PlayedMatch, event: EventSettings | None = None) -> None:
        super().__init__(match)
        self.event = event or EventSettings()
        # whose hub is off first in a tie: counted from the first robot's alliance, so that red is blue flipped
        own: Alliance = match.entries[0].alliance
        self._coin: Alliance = own if match.rules_rng.random() < 0.5 else other_alliance(own)
        self.ways = FuelWays(match)
        """Fuel that is in a hub, or off the field."""
        self._forget()

    def _forget(self) -> None:
        self.hubs = HubCount(self._coin, practice=self.match.practice)
        self.towers = TowerJudge(self.match)
        self.fouls = Fouls(self.match, self.towers)
        self._tower_points: dict[Alliance, int] = dict.fromkeys(ALLIANCES, 0)

    def is_active(self, alliance: Alliance, time: float | None = None) -> bool:
        """Whether a fuel counts that the sensors see at a time of the match [s], now if none is given."""
        return self.hubs.period(alliance, self.match.timer.time if time is None else time) != UNCOUNTED

    def hub_light(self, alliance: Alliance) -> str:
        """Return what the light of an alliance's hub shows."""
        return self.hubs.light(alliance, self.match.timer.time)

    def levels(self, level: Callable[[int], int]) -> dict[str, str]:
        """Return the names of the robots' levels, by their places in the list."""
        return {str(robot.number + 1): _LEVELS[level(robot.number)] for robot in self.match.robots}

    # --- hooks ----------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """The human players take the fuel of their chutes."""
        self.match.pieces.out_of_field = self._left_field
        self.human_players = HumanPlayers(self.match) if HUMAN_PLAYERS in self.match.options else None

    def start_mode(self, mode: str) -> None:
        """An auto begins without points."""
        if mode == "auto":
            self._forget()

    def before_tick(self) -> None:
        """Hubs let fuel out, people bring back what left the field, human players feed and throw."""
        for slot in self.ways.act():
            self.fouls.emerged(slot)
        if self.human_players is not None:
            self.human_players.act()

    def worth(self, zone: ScoringZone) -> int:
        """One point, if the hub counts as its sensors see the fuel."""
        return zone.points if self.is_active(zone.alliance, self._sensed) else 0

    def scored(self, event: ScoreEvent) -> None:
        """Count the fuel in its period; the hub lets it out again."""
        self.hubs.count(event.alliance, self._sensed)
        self.fouls.scored(event)
        self.ways.enter_hub(event.alliance, event.slot)

    def after_tick(self) -> None:
        """Look for fouls and at the towers."""
        self.fouls.after_tick()
        self.towers.after_tick()
        for alliance in ALLIANCES:
            points = int(math.fsum(self.towers.points(alliance)))
            if points != self._tower_points[alliance]:
                self.match.tracker.add(alliance, points - self._tower_points[alliance])
                self._tower_points[alliance] = points

    def human_actions(self) -> Sequence[HumanAction]:
        """What may be done at an outpost, where somebody is there."""
        return () if self.human_players is None else self.human_players.actions

    def game_data(self) -> str:
        """Empty before teleop, then `B` or `R`: whose hub is inactive first."""
        return self.hubs.first_inactive[0].upper() if self.match.timer.time >= MATCH.start("transition") else ""

    def breakdown(self) -> Mapping[str, int]:
        """The score sheet by alliance, in the names of FIRST's score API."""
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

    # --- inside -----------------------------------------------------------------------------------------------------

    @property
    def _sensed(self) -> float:
        """When the sensors see a fuel that falls through a hub's throat now [s]."""
        return self.match.timer.time + self.event.sensor_delay

    def _left_field(self, slot: int) -> bool:
        """A fuel is outside of the field. In a match people bring it back later; otherwise it is back at once."""
        self.fouls.left_field(slot, untouched=bool(self.match.pieces.is_untouched[slot]))
        return self.human_players is not None and self.ways.leave_field(slot)

    def _bonuses(self, alliance: Alliance) -> dict[str, int]:
        """Ranking points beside those of the result."""
        fuel, event = self.hubs.counted(alliance), self.event
        tower = math.fsum(self.towers.points(alliance))
        return {
            "energizedAchieved": int(fuel >= event.energized),
            "superchargedAchieved": int(fuel >= event.supercharged),
            "traversalAchieved": int(tower >= event.traversal),
        }

    def _result(self, alliance: Alliance) -> int:
        """Ranking points of a match that has been assessed: 3 for a win, 1 for a tie."""
        totals, time = self.match.tracker.totals, self.match.timer.time
        if time < MATCH.duration + ASSESSMENT - 1e-9:
            return 0
        ahead = totals[alliance] - totals[other_alliance(alliance)]
        return _WIN if ahead > 0 else 0 if ahead < 0 else _TIE
