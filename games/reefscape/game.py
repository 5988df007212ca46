"""Definition of REEFSCAPE, the 2025 game."""

from __future__ import annotations

import math

from games.reefscape.autos import AUTOS
from games.reefscape.driving import DRIVING
from games.reefscape.field import CAGE_OPTIONS, FIELD, arrange, scoring_zones
from games.reefscape.pieces import ALGAE, CORAL
from games.reefscape.places import PLACES
from games.reefscape.players import ROLES
from games.reefscape.robot import reefscape_robot
from games.reefscape.rules import ASSESSMENT, MATCH, ReefscapeRules
from games.reefscape.staging import ALGAE_COUNT, CORAL_COUNT, ROBOTS, stage
from games.shipped import shipped
from simcore.match.game import Game, PieceSupply

__all__ = ["REEFSCAPE"]

REEFSCAPE = Game(
    name="reefscape",
    year=2025,
    field=FIELD,
    pieces=(PieceSupply(CORAL, CORAL_COUNT), PieceSupply(ALGAE, ALGAE_COUNT)),
    clock=MATCH,
    assessment=ASSESSMENT,
    staging=stage,
    zones=scoring_zones(),
    places=PLACES,
    rules=ReefscapeRules,
    robot=reefscape_robot,
    starts=((7.2, 5.9, math.pi), (7.2, 2.15, math.pi), (7.2, 4.0259, math.pi)),
    preload=1,
    robots=ROBOTS,
    autos=AUTOS,
    driving=DRIVING,
    roles=ROLES,
    practice_matches={
        "practice-2v2": ("scorer", "scorer,defender"),
        "practice-3v3": ("scorer,algae", "scorer,climber,defender"),
    },
    models=shipped("reefscape", "advantagescope"),
    options=CAGE_OPTIONS,
    arrange=arrange,
)
"""Definition of the game: field, pieces, clock, staging, scoring, rules, robots and options."""
