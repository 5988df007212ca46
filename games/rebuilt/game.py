"""Definition of REBUILT, the 2026 game, and a match class with the defaults of this game."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from games.rebuilt.autos import AUTOS, DRIVING
from games.rebuilt.field import FIELD, scoring_zones
from games.rebuilt.fuel import FUEL
from games.rebuilt.fuel_ways import HUB_EXITS
from games.rebuilt.human_players import HUMAN_PLAYERS
from games.rebuilt.players import ROLES
from games.rebuilt.robot import rebuilt_robot
from games.rebuilt.rules import RebuiltRules
from games.rebuilt.scoring import ASSESSMENT, MATCH
from games.rebuilt.staging import Staging
from games.shipped import shipped
from simcore.match.game import Game, GameOption, PieceSupply, RobotEntry
from simcore.match.match import Match

__all__ = ["REBUILT", "RebuiltSim"]

_STAGING = Staging()

REBUILT = Game(
    name="rebuilt",
    year=2026,
    field=FIELD,
    pieces=(PieceSupply(FUEL, _STAGING.total),),
    clock=MATCH,
    assessment=ASSESSMENT,
    staging=_STAGING,
    zones=scoring_zones(),
    rules=RebuiltRules,
    robot=rebuilt_robot,
    starts=((2.5, 5.9, 0.0), (2.5, 2.2, 0.0), (2.5, 4.03, 0.0)),
    preload=_STAGING.preload_per_robot,
    robots=_STAGING.robots,
    autos=AUTOS,
    roles=ROLES,
    driving=DRIVING,
    practice_matches={
        "practice-2v2": ("collector", "collector,defender"),
        "practice-3v3": ("collector,shuttle", "collector,collector,defender"),
    },
    options=(
        GameOption(name=HUB_EXITS, help="scored fuel comes out of the hub's exit", in_matches=True),
        GameOption(name=HUMAN_PLAYERS, help="human players feed and throw the outposts' fuel", in_matches=True),
    ),
    models=shipped("rebuilt", "advantagescope"),
)
"""Definition of the game: field, pieces, clock, staging, scoring, rules, robots and options."""


class RebuiltSim(Match):
    """Match of REBUILT.

    Args:
        staging: Numbers of staged fuel; None for the manual's 504.
        robots: Robots of the match; by default one blue robot with the game's default config.
        settings: Further arguments of `Match`.
    """

    def __init__(self, *, staging: Staging | None = None, robots: Sequence[RobotEntry] = (), **settings: Any) -> None:
        game = REBUILT
        if staging is not None:
            game = replace(
                REBUILT,
                staging=staging,
                pieces=(PieceSupply(FUEL, staging.total),),
                preload=staging.preload_per_robot,
                robots=staging.robots,
            )
        super().__init__(game, robots=robots, **settings)
