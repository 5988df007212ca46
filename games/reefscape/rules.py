"""Scoring rules of REEFSCAPE: phases of the match, points by level, assessment and ranking points."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence

from games.reefscape import dimensions as dim
from games.reefscape.field import ALLIANCES
from games.reefscape.fouls import BARGE_ZONE, Fouls
from games.reefscape.human_players import HumanPlayers
from games.reefscape.places import BRANCH_ROWS, level_of
from simcore.channel import Channel
from simcore.match.clock import MatchClock, Phase
from simcore.match.game import PlayedMatch, Rules
from simcore.match.human_actions import HumanAction
from simcore.match.scoring import Alliance, ScoreEvent, ScoringZone, other_alliance
from simcore.pieces.resting_places import PlaceEvent, RestingPlace
from simcore.robot.chassis import ground_clearance
from simcore.robot.robot import Robot
from simcore.world.footprints import overlaps

__all__ = ["ASSESSMENT", "COOP_ALGAE", "CORAL_A_LEVEL", "MATCH", "ReefscapeRules"]

MATCH = MatchClock(
    [
        Phase("auto", 15.0, "auto"),
        Phase("pause", 3.0, "disabled"),
        Phase("teleop", 115.0),
        Phase("end game", 20.0),
    ]
)
"""Match clock of 2:33: 15 s auto, 3 s pause, 2:15 teleop."""

_CORAL_ROWS = (*BRANCH_ROWS.values(), "trough")
_AUTO_CORAL = {1: 3, 2: 4, 3: 6, 4: 7}
_TELEOP_CORAL = {1: 2, 2: 3, 3: 4, 4: 5}
_NET_POINTS, _LEAVE_POINTS = 4, 3
_END_POINTS = {"None": 0, "Parked": 2, "ShallowCage": 6, "DeepCage": 12}
CORAL_A_LEVEL, _BARGE_BONUS = 5, 14  # for ranking points at events before the championships
COOP_ALGAE = 2
"""Number of algae that each alliance must score in a processor for the coopertition criterion."""
ASSESSMENT = 3.0  # [s]; time after auto and after the match for pieces to come to rest


class ReefscapeRules(Rules):
    """Rules of one match.

    The rules count the pieces that are in place now, so the points of a coral that falls off are lost. Auto points stay
    with the branches that held a coral at the end of auto, and with as many coral in the trough as at the end of auto.
    """

    channels = (
        Channel("Sim/Match/<Alliance>StationCoral", "int",
                lambda r: {a.capitalize(): r.human_players.stock[a] for a in ALLIANCES},
                "coral that an alliance's human players have"),
        Channel("Sim/Match/<Alliance>HumanPlayerAlgae", "int",
                lambda r: {a.capitalize(): r.human_players.waiting_algae[a] for a in ALLIANCES},
                "algae behind the processor, waiting for the human player"),
        Channel("Sim/Match/EndGameRobot<n>", "string", lambda r: r.ends,
                "how each robot ended: `None`, `Parked`, `ShallowCage` or `DeepCage`"),
    )  # fmt: skip

    def __init__(self, match: PlayedMatch) -> None:
        super().__init__(match)
        self._clear_points()

    def _clear_points(self) -> None:
        self._where: dict[int, RestingPlace] = {}  # place of each placed piece, by slot
        self._count: Counter[str] = Counter()  # number of placed pieces, by level
        self._auto_branches: frozenset[str] = frozenset()  # names of places with a piece at the end of auto
        self._auto_count: Counter[str] = Counter()  # number of placed pieces at the end of auto, by level
        self._left: dict[int, bool] = {}
        self._ends: dict[int, str] = {}
        self._points: dict[Alliance, int] = dict.fromkeys(ALLIANCES, 0)
        self._processed: Counter[Alliance] = Counter()
        self.fouls = Fouls(self.match)
        """Judge of the fouls since the last reset of points."""

    # --- hooks ----------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Create the human players, with coral at the stations."""
        self.human_players = HumanPlayers(self.match)

    def start_mode(self, mode: str) -> None:
        """Clear all points when the autonomous period starts."""
        if mode == "auto":
            self._clear_points()

    def before_tick(self) -> None:
        """Perform the human players' actions when due."""
        self.human_players.act()

    def human_actions(self) -> Sequence[HumanAction]:
        """Return the actions of human players at the stations and the processor."""
        return self.human_players.actions

    def worth(self, zone: ScoringZone) -> int:
        """Return the points for an algae in a processor, or 0 after the assessment of the match."""
        return 0 if self._is_assessed else zone.points

    def scored(self, event: ScoreEvent) -> None:
        """Count an algae scored in a processor, and give the algae to the other alliance's human player."""
        self.human_players.take_algae(event.alliance, event.slot)
        self._processed[event.alliance] += bool(event.points)

    def placed(self, event: PlaceEvent) -> None:
        """Count a coral on a branch or in the trough, or an algae in a net."""
        self._where[event.slot] = event.place
        self._count = Counter(place.level for place in self._where.values())
        self._judge()

    def removed(self, event: PlaceEvent) -> None:
        """Stop counting a piece that has fallen off or that a robot has taken, and judge the foul G410."""
        self._where.pop(event.slot, None)
        self._count = Counter(place.level for place in self._where.values())
        self.fouls.removed(event)
        self._judge()

    def after_tick(self) -> None:
        """Judge fouls, robots that have left the starting line at the end of auto, and robots that park or hang.

        The method judges parked and hanging robots during the assessment after the match.
        """
        self.fouls.after_tick()
        time = self.match.timer.time
        if MATCH.start("pause") - 1e-9 <= time < MATCH.start("teleop") and not self._left:
            self._left = {robot.number: self._has_left(robot) for robot in self.match.robots}
            self._judge()
        elif MATCH.duration < time <= MATCH.duration + ASSESSMENT:
            self._judge()

    def end(self) -> None:
        """Judge robots that park or hang at the end of the match; `after_tick` repeats the test during assessment."""
        self._judge()

    def processed(self, alliance: Alliance) -> int:
        """Return the number of algae that an alliance has scored in the processor."""
        return self._processed[alliance]

    def breakdown(self) -> Mapping[str, int]:
        """Return the score breakdown of both alliances, with the names in the API of The Blue Alliance."""
        rows: dict[str, int] = {}
        now, auto = self._count, self._auto_count
        for alliance in ALLIANCES:
            book, (early, late), net = self.fouls.book, self._coral(alliance), now[level_of(alliance, "net")]
            mobility, barge, processed = self._mobility(alliance), self._barge(alliance), self._processed[alliance]
            algae, broken = 6 * processed + _NET_POINTS * net, book.rules(alliance)
            bonuses = self._bonuses(alliance)
            own = {
                "netAlgaeCount": net,
                "wallAlgaeCount": processed,
                "algaePoints": algae,
                "autoMobilityPoints": mobility,
                "autoCoralCount": self._auto_coral(alliance),
                "autoCoralPoints": early,
                "autoPoints": mobility + early,
                "teleopCoralPoints": late,
                "teleopPoints": late + algae + barge,
                "endGameBargePoints": barge,
                "coopertitionCriteriaMet": int(processed >= COOP_ALGAE),
                "foulCount": book.count(alliance, 2),
                "techFoulCount": book.count(alliance, 6),
                "foulPoints": book.gained(alliance),
                "totalPoints": self.match.tracker.totals[alliance],
                **{f"{rule.lower()}Penalty": int(rule in broken) for rule in ("G410", "G418", "G428")},
                **bonuses,
                "rp": int(math.fsum((*bonuses.values(), self._result(alliance)))),
            }
            for period, counts in (("autoReef", auto), ("teleopReef", now)):
                own |= {f"{period}/{row}": counts[level_of(alliance, row)] for row in _CORAL_ROWS}
            rows |= {f"{alliance.capitalize()}/{name}": count for name, count in own.items()}
        return rows

    @property
    def ends(self) -> dict[str, str]:
        """End-game result of each robot, `None`, `Parked`, `ShallowCage` or `DeepCage`, by robot number from 1."""
        return {str(robot.number + 1): self._ends.get(robot.number, "None") for robot in self.match.robots}

    # --- scoring ------------------------------------------------------------------------------------------------------

    def _judge(self) -> None:
        """Update the auto and end-game results until the assessment ends, and add the change of points to the score."""
        time = self.match.timer.time
        if self._is_assessed:
            return
        if time >= MATCH.duration - 1e-9:
            self._ends = {robot.number: self._end_of(robot) for robot in self.match.robots}
        if time < MATCH.start("teleop"):
            self._auto_branches = frozenset(place.name for place in self._where.values())
            self._auto_count = self._count
        for alliance in ALLIANCES:
            points = self._worth_of(alliance)
            if points != self._points[alliance]:
                self.match.tracker.add(alliance, points - self._points[alliance])
                self._points[alliance] = points

    @property
    def _is_assessed(self) -> bool:
        """Whether the assessment after the match is over, so that nothing counts any more; always False in practice."""
        return self.match.timer.time > MATCH.duration + ASSESSMENT + 1e-9 and not self.match.practice

    def _coral(self, alliance: Alliance) -> tuple[int, int]:
        """Return the points of an alliance's coral with auto value, and the points of coral with teleop value."""
        now, trough = self._count, level_of(alliance, "trough")
        first = min(now[trough], self._auto_count[trough])
        early, late = first * _AUTO_CORAL[1], (now[trough] - first) * _TELEOP_CORAL[1]
        for level, row in BRANCH_ROWS.items():
            if count := now[level_of(alliance, row)]:
                names = [place.name for place in self._where.values() if place.level == level_of(alliance, row)]
                kept = len(self._auto_branches.intersection(names))
                early, late = early + kept * _AUTO_CORAL[level], late + (count - kept) * _TELEOP_CORAL[level]
        return early, late

    def _worth_of(self, alliance: Alliance) -> int:
        """Return an alliance's points, except the points for algae in the processor and for fouls."""
        early, late = self._coral(alliance)
        net = _NET_POINTS * self._count[level_of(alliance, "net")]
        return early + late + net + self._mobility(alliance) + self._barge(alliance)

    def _auto_coral(self, alliance: Alliance) -> int:
        return int(math.fsum(self._auto_count[level_of(alliance, row)] for row in _CORAL_ROWS))

    def _robots_of(self, alliance: Alliance) -> list[Robot]:
        return [robot for robot in self.match.robots if self.match.alliances[robot.number] == alliance]

    def _mobility(self, alliance: Alliance) -> int:
        return _LEAVE_POINTS * len([1 for robot in self._robots_of(alliance) if self._left.get(robot.number)])

    def _barge(self, alliance: Alliance) -> int:
        """Return an alliance's points for parked and hanging robots."""
        ends = [self._ends.get(robot.number, "None") for robot in self._robots_of(alliance)]
        return int(math.fsum(_END_POINTS[end] for end in ends))

    @property
    def _is_coop(self) -> bool:
        return all(self._processed[alliance] >= COOP_ALGAE for alliance in ALLIANCES)

    def _full_levels(self, alliance: Alliance) -> int:
        return len([1 for row in _CORAL_ROWS if self._count[level_of(alliance, row)] >= CORAL_A_LEVEL])

    def _bonuses(self, alliance: Alliance) -> dict[str, int]:
        """Return an alliance's bonus ranking points by name, each 0 or 1.

        Some fouls of the other alliance also give a bonus ranking point.
        """
        robots, given = self._robots_of(alliance), self.fouls.book.rules(other_alliance(alliance))
        have_left = bool(robots) and all(self._left.get(robot.number) for robot in robots)
        is_full = self._full_levels(alliance) >= (3 if self._is_coop else 4)
        hangs = self._barge(alliance) >= _BARGE_BONUS
        return {
            "autoBonusAchieved": int(have_left and self._auto_coral(alliance) > 0),
            "coralBonusAchieved": int(is_full or "G410" in given),
            "bargeBonusAchieved": int(hangs or "G418" in given or "G428" in given),
        }

    def _result(self, alliance: Alliance) -> int:
        """Return the ranking points for the result: 3 for a win, 1 for a tie, 0 for a loss or before the assessment."""
        totals = self.match.tracker.totals
        ahead = totals[alliance] - totals[other_alliance(alliance)]
        is_early = self.match.timer.time < MATCH.duration + ASSESSMENT - 1e-9
        return 0 if is_early or ahead < 0 else 3 if ahead else 1

    def _has_left(self, robot: Robot) -> bool:
        """Return whether no part of a robot's bumpers is above the starting line of the robot's alliance."""
        x = self.match.outline(robot.number)[:, 0]
        return bool(x.max() < dim.STARTING_LINE_X - dim.STARTING_LINE_WIDTH or x.min() > dim.STARTING_LINE_X)

    def _end_of(self, robot: Robot) -> str:
        """Return the end-game result that a robot would get now: `ShallowCage`, `DeepCage`, `Parked` or `None`."""
        alliance = self.match.alliances[robot.number]
        for climber in robot.climbers:
            rung = climber.rung
            if rung is not None and rung.alliance == alliance:
                if ground_clearance(*robot.chassis.wheel_ground()).is_airborne:
                    return "ShallowCage" if f"{rung.mount}_shallow" in self.match.options else "DeepCage"
        return "Parked" if overlaps(self.match.outline(robot.number), BARGE_ZONE) else "None"
