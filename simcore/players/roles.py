"""What roles of every game have in common: how a role is made, standing still, and defense within the pinning rule."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass

from simcore.geometry.symmetry import Pose
from simcore.match.foul_book import pins_of
from simcore.match.game import Role
from simcore.match.match import Match
from simcore.match.scoring import Alliance
from simcore.match.scripted import ScriptSettings, Steps
from simcore.players.player import SKILLS, Player, PlayScript
from simcore.players.routes import Place
from simcore.robot.robot_config import RobotConfig

__all__ = ["Defense", "idle", "make_role"]

_INTO = 0.3  # [m]; a robot that wants to be this far before another one's middle pushes it
_LONGEST_PIN, _LET_GO, _SIX_FEET = 1.6, 3.1, 1.95  # [s], [s], [m]; a pin ends when both were so far apart for 3 s


def make_role(
    script: PlayScript, summary: str, settings: ScriptSettings, config: Callable[[], RobotConfig] | None = None
) -> Role:
    """A role that is named as its script.

    Args:
        script: What it does.
        summary: The same in a few words, for people.
        settings: How it handles the robot.
        config: Its robot; None: the game's own.
    """

    def controller(match: Match, alliance: Alliance, level: int) -> Player:
        return Player(script, match, alliance, SKILLS[level - 1], settings)

    return Role(name=script.__name__, summary=summary, controller=controller, config=config)


def idle(player: Player) -> Steps:
    """Stand still."""
    while True:
        player.stop()
        yield


@dataclass(frozen=True, slots=True, kw_only=True)
class Defense:
    """How a game is defended: robots push opponents away from a place that these want to reach."""

    goal: Place
    """Where opponents bring pieces, seen from the defender's alliance as blue [m]."""
    retreat: Place
    """Where a defender goes that leaves an opponent alone, or has none [m]."""
    is_left_alone: Callable[[Player, Place], bool]
    """Whether an opponent at a place must not be touched."""

    def play(self, player: Player) -> Steps:
        """Defend until the match ends, and let an opponent go before a pin of it is a foul."""
        pinned: dict[int, float] = defaultdict(float)  # since an opponent was left alone [s], by its number
        while True:
            wanted = [other for other in player.opponents if not self.is_left_alone(player, other.place)]
            nearest = min(wanted, key=lambda other: player.away(other.place), default=None)
            yield from self._block(player, None if nearest is None else nearest.number, pinned)
            yield

    def _block(self, player: Player, number: int | None, pinned: dict[int, float]) -> Steps:
        """Push an opponent away from its goal for some seconds; leave it alone before that is a foul."""
        since = 0.0

        def place() -> Place | None:
            other = next((one.place for one in player.opponents if one.number == number), None)
            return None if other is None or self.is_left_alone(player, other) else other

        def between() -> Pose | None:
            other = place()
            if number is None or other is None or pinned[number] > _LONGEST_PIN:
                return None
            if (player.robot.number, number) in pins_of(player.match):
                pinned[number] += player.skill.reaction
            toward = math.atan2(self.goal[1] - other[1], self.goal[0] - other[0])
            return other[0] + _INTO * math.cos(toward), other[1] + _INTO * math.sin(toward), toward + math.pi

        def away() -> Pose | None:
            nonlocal since
            other = place()
            if other is None or player.away(other) < _SIX_FEET:
                since = player.match.time
            return None if player.match.time > since + _LET_GO else (*self.retreat, player.pose[2])

        yield from player.pursue(between, near=0.0, timeout=4.0, ignored=() if number is None else (number,))
        since = player.match.time
        if number is None:
            yield from player.pursue(away, timeout=_LET_GO)
        elif pinned[number] > _LONGEST_PIN:
            yield from player.pursue(away, near=0.0, timeout=8.0)
            pinned[number] = 0.0
        player.stop()
