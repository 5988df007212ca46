"""Who has climbed the tower, and how high (game manual, TOWER scoring): judged by contacts and the bumpers' height."""

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
"""Of levels 0 to 3."""

_HOLDS = ("tower_rung_*", "tower_upright_*")  # one of these has to be touched
_ALLOWED = (*_HOLDS, "tower_brace_*", "alliance_wall")
_EPS = 1e-9


def tower_level(alliance: Alliance, touched: Iterable[str], *, airborne: bool, lowest: float) -> int:
    """Level of the tower on which a robot is, 0 for none.

    It touches a rung or an upright of its tower, and beside these nothing but the tower's wall and supports, fuel and
    robots. On level 1 it is off carpet and tower base; its bumpers are wholly above the low rung on level 2, and above
    the middle one on level 3.

    Args:
        alliance: Whose robot it is.
        touched: Names of the field elements that it touches; fuel and robots are left out.
        airborne: Whether no wheel stands on anything.
        lowest: Height of its bumpers' lowest point [m].

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
    """Levels of all robots in one match.

    In auto they are judged as the timer has come to 0:00. After the match they are judged until the assessment is over;
    what is so then, counts: who falls before has no level.

    Args:
        match: Which is judged.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        self._is_auto_judged = False
        self.auto: dict[int, int] = {}
        """Level in auto, 0 or 1, by robot."""
        self.final: dict[int, int] = {}
        """Level at the end, by robot."""
        self.awarded: set[int] = set()
        """Robots that have level 3 by a foul of the other alliance, wherever they end."""
        self.carried: set[int] = set()
        """Robots that lose their tower points, because a partner has fully carried them."""

    def after_tick(self) -> None:
        """Once a tick, after everything has moved."""
        time = self._match.timer.time
        if not self._is_auto_judged and MATCH.start("pause") - _EPS <= time < MATCH.start("transition"):
            self._is_auto_judged = True
            self.auto = {robot.number: min(1, self.level(robot)) for robot in self._match.robots}
        elif MATCH.duration - _EPS <= time <= MATCH.duration + ASSESSMENT + _EPS:
            self.final = {robot.number: self.level(robot) for robot in self._match.robots}

    def level(self, robot: Robot) -> int:
        """On which level a robot is now."""
        match, alliance = self._match, self._match.alliances[robot.number]
        lowest = lowest_bumper(robot)
        if lowest < robot.chassis.config.clearance:  # it stands, and need not be asked more
            return 0
        touched = match.contacts.elements(robot.number)
        return tower_level(alliance, touched, airborne=is_airborne(robot), lowest=lowest)

    def points(self, alliance: Alliance) -> tuple[int, int]:
        """Tower points of an alliance in auto and at the end."""
        robots = [n for n, owner in enumerate(self._match.alliances) if owner == alliance]
        auto = [n for n in robots if self.auto_level(n)][:_MOST_IN_AUTO]
        return AUTO_POINTS * len(auto), int(math.fsum(TELEOP_POINTS[self.final_level(n)] for n in robots))

    def auto_level(self, robot: int) -> int:
        """Level of a robot that counts in auto."""
        return 0 if robot in self.carried else self.auto.get(robot, 0)

    def final_level(self, robot: int) -> int:
        """Level of a robot that counts at the end."""
        return 3 if robot in self.awarded else 0 if robot in self.carried else self.final.get(robot, 0)
