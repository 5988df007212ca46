"""Games and autos for tests of laws that hold in every game."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from crates import CRATES

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore.match.game import Auto, Game
from simcore.match.match import Match
from simcore.match.runner import AutoRun, play_auto
from simcore.pieces.pool import PieceStatus

GAMES: dict[str, Game] = {"rebuilt": REBUILT, "reefscape": REEFSCAPE, "crates": CRATES}
AUTOS = [(name, auto) for name, game in GAMES.items() for auto in game.autos]
LONG = {("reefscape", "station_cycle"), ("reefscape", "algae"), ("reefscape", "climb")}
"""Autos that only `--whole` plays; another auto of the same game stands for them otherwise."""


@dataclass
class Played:
    """Run of an auto with observations at each tick."""

    run: AutoRun
    auto: Auto
    lost: list[int] = field(default_factory=list)
    """Ticks at which the count of pieces was wrong."""
    sunk: float = 1.0
    """Smallest height of a piece's center above the height at which it lies flat [m]."""
    poses: list[tuple[float, ...]] = field(default_factory=list)
    """Position and quaternion of the robot at each tick."""
    roll_pitch: list[tuple[float, float]] = field(default_factory=list)
    held: list[int] = field(default_factory=list)
    touched: int = 0
    """Tick at which a piece first woke or was taken."""
    ghosts: float = 0.0
    """Largest distance of a sleeping body from its reported position, at the end [m]."""


def play(game: str, auto: str, alliance: str = "blue", seed: int = 0, **settings) -> Played:
    """Play an auto, observe it at every tick and close its match."""
    seen = Played(run=None, auto=GAMES[game].auto(auto))  # type: ignore[arg-type]

    def look(match: Match) -> None:
        if not match.count.is_conserved:
            seen.lost.append(match.ticks)
        slots = match.pieces.on_field()
        rest = np.array([kind.rest_height for kind in match.pieces.types])[match.pieces.state.kind[slots]]
        seen.sunk = min(seen.sunk, float((match.pieces.state.pos[slots, 2] - rest).min()))
        chassis = match.robots[0].chassis
        seen.poses.append((*chassis.pos, *chassis.quat))
        seen.roll_pitch.append(chassis.roll_pitch_yaw[:2])
        seen.held.append(match.count.held)
        if not seen.touched and (len(match.pieces.awake) > len(match.record.flying) or match.record.taken_in):
            seen.touched = match.ticks

    seen.run = play_auto(GAMES[game], auto, alliance=alliance, seed=seed, on_tick=look, **settings)
    match = seen.run.match
    rows = np.array(match.pieces._pool.rows)  # engine rows; balls have none
    asleep = np.nonzero((match.pieces.state.status == PieceStatus.ASLEEP) & (rows >= 0))[0]
    bodies = match.world.engine.centers(match.pieces._pool.rows_of(asleep))
    seen.ghosts = float(np.abs(bodies - match.pieces.state.pos[asleep]).max(initial=0.0))
    match.close()  # later queries must not need the engine
    return seen
