"""Identity of one of many runs of a robot program: seed, scatter (`--sim-seed`, `--sim-scatter`), factors of a sweep.

A robot program builds its match in its own process. The starter of that process sets the variation here before the
program starts; the code that builds the match reads it:

    variation = run_variation()
    entry = RobotEntry(config=variation.robot(config))
    match = Match(variation.game(game), robots=[entry], seed=variation.seed, scatter=variation.scatter)

A project with a `simcore.toml` does so by itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from simcore.errors import SimcoreError
from simcore.match.game import Game
from simcore.match.match import Match
from simcore.match.scatter import Scatter
from simcore.robot.robot_config import RobotConfig
from simcore.sweep.factors import FactorValue, vary_pieces, vary_robot

__all__ = ["RunVariation", "require_varied", "run_variation", "set_factors", "set_run_variation"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RunVariation:
    """One of many runs of a robot program."""

    seed: int = 0
    """Seed of the match."""
    scatter: Scatter | None = None
    """Standard deviations of the scatter; None: that of `simcore.toml`, else none."""
    factors: Mapping[str, FactorValue] = field(default_factory=dict)
    """Values by factor that a sweep varies in robot and pieces."""

    def robot(self, config: RobotConfig) -> RobotConfig:
        """Return the robot of this run.

        Raises:
            ConfigError: There is no such factor, or it cannot have this value.
        """
        return vary_robot(config, self.factors)

    def game(self, game: Game) -> Game:
        """Return the game of this run; errors as in `robot`."""
        return vary_pieces(game, self.factors)


_variation = RunVariation()


def run_variation() -> RunVariation:
    """Return the variation of this process."""
    return _variation


def set_run_variation(variation: RunVariation) -> None:
    """Set the variation for all matches of robot programs built from now on in this process."""
    global _variation
    _variation = variation


def set_factors(factors: Mapping[str, FactorValue]) -> None:
    """Set the factors of a sweep; keep seed and scatter."""
    set_run_variation(replace(_variation, factors=factors))


def require_varied(match: Match) -> None:
    """Refuse a match that a project's own physics.py has built without this run's variation.

    Raises:
        SimcoreError: It has another seed, scatter, robot or game.
    """
    wanted = _variation
    if match.seed != wanted.seed or (wanted.scatter is not None and match.scatter != wanted.scatter):
        raise SimcoreError(
            f"this run has seed {wanted.seed} and a scatter of its own, but physics.py builds its match with seed "
            f"{match.seed} and scatter {match.scatter.text!r}; give it Match(..., seed=run_variation().seed, "
            "scatter=run_variation().scatter), from simcore"
        )
    config = match.robots[0].config
    # factors already at their values do not change them
    if wanted.robot(config) != config or wanted.game(match.game).pieces != match.game.pieces:
        raise SimcoreError(
            f"this run varies {', '.join(wanted.factors)}, but physics.py builds its match without; give it "
            "Match(run_variation().game(game), robots=[RobotEntry(config=run_variation().robot(config))], ...), "
            "from simcore"
        )
