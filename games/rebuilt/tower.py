"""Tower levels of robots (game manual, TOWER scoring), determined from contacts and the height of the bumpers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fnmatch import fnmatchcase

from games.rebuilt.dimensions import TOWER_RUNG_HEIGHTS
from games.rebuilt.scoring import ASSESSMENT, MATCH
from simcore.match.foul_book import is_airborne, lowest_bumper
from simcore.match.game import PlayedMatch
from simcore.match.scoring import Alliance
from simcore.robot.robot import Robot

__all__ = ["TELEOP_POINTS", "TowerJudge", "tower_level"]

AUTO_POINTS, _MOST_IN_AUTO = 15, 2
TELEOP_POINTS = (0, 10, 20, 30)
"""Points for levels 0 to 3 at the end of the match."""

_HOLDS = ("tower_rung_*", "tower_upright_*")  # a robot on the tower touches at least one of these
_ALLOWED = (*_HOLDS, "tower_brace_*", "alliance_wall")
_EPS = 1e-9


def tower_level(alliance: Alliance, touched: Iterable[str], *, airborne: bool, lowest: float) -> int:
    """Return the tower level of a robot, or 0 if the robot is on no level.

    The robot must touch a rung or an upright of the alliance's tower. The robot may also touch the wall and supports of
    this tower, fuel and robots, but nothing else. For level 1, the robot must be off the carpet and the tower base. For
    level 2, the bumpers must be fully above the low rung. For level 3, the bumpers must be fully above the middle rung.

    Args:
        alliance: Alliance of the robot.
        touched: Names of the field elements that the robot touches, without fuel and robots.
        airborne: Whether no wheel touches the ground.
        lowest: Height of the bumpers' lowest point [m].

    Source: game manual, section 6.5.2.
    """
    names = list(touched)
    own = [name.removeprefix(f"{alliance}_") for name in names]
    holds = any(fnmatchcase(name, pattern) for name in own for pattern in _HOLDS)
    if not (airborne and holds and all(any(fnmatchcase(name, one) for one in _ALLOWED) for name in own)):
        return 0
    low, mid, _ = TOWER_RUNG_HEIGHTS
    return 3 if lowest > mid else 2 if lowest > low else 1


class TowerJudge:
    """Judge of the tower levels of all robots in one match.

    The auto level is the level when the timer of auto reaches 0:00. The final level is the level at the end of the
    assessment after the match, so a robot that falls during the assessment loses the level.

    Args:
        match: Match to judge.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        self._is_auto_judged = False
        self.auto: dict[int, int] = {}
        """Level in auto, 0 or 1, by robot number."""
        self.final: dict[int, int] = {}
        """Level at the end of the match, by robot number."""
        self.awarded: set[int] = set()
        """Numbers of the robots that get level 3 for an opponent's foul, at any final position."""
        self.carried: set[int] = set()
        """Numbers of the robots without tower points, because a partner has fully carried these robots."""

    def after_tick(self) -> None:
        """Record the tower levels once at the end of auto, and in each tick of the assessment after the match."""
        time = self._match.timer.time
        if not self._is_auto_judged and MATCH.start("pause") - _EPS <= time < MATCH.start("transition"):
            self._is_auto_judged = True
            self.auto = {robot.number: min(1, self.level(robot)) for robot in self._match.robots}
        elif MATCH.duration - _EPS <= time <= MATCH.duration + ASSESSMENT + _EPS:
            self.final = {robot.number: self.level(robot) for robot in self._match.robots}

    def level(self, robot: Robot) -> int:
        """Return the current tower level of a robot."""
        match, alliance = self._match, self._match.alliances[robot.number]
        lowest = lowest_bumper(robot)
        if lowest < robot.chassis.config.clearance:  # the robot stands on its wheels
            return 0
        touched = match.contacts.elements(robot.number)
        return tower_level(alliance, touched, airborne=is_airborne(robot), lowest=lowest)

    def points(self, alliance: Alliance) -> tuple[int, int]:
        """Return an alliance's tower points in auto and at the end of the match."""
        robots = [n for n, owner in enumerate(self._match.alliances) if owner == alliance]
        auto = [n for n in robots if self.auto_level(n)][:_MOST_IN_AUTO]
        return AUTO_POINTS * len(auto), int(math.fsum(TELEOP_POINTS[self.final_level(n)] for n in robots))

    def auto_level(self, robot: int) -> int:
        """Return the level that counts for a robot in auto; 0 for a robot that a partner has carried."""
        return 0 if robot in self.carried else self.auto.get(robot, 0)

    def final_level(self, robot: int) -> int:
        """Return the level that counts for a robot at the end of the match, with the effects of fouls."""
        return 3 if robot in self.awarded else 0 if robot in self.carried else self.final.get(robot, 0)
