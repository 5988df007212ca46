"""Variation of one robot program run: the seed, the scatter and the factors of a sweep.

The options `--sim-seed` and `--sim-scatter` set the seed and scatter. A robot program builds the match in a separate
process. The code that starts the process sets the variation before the program starts, and the code that builds the
match reads the variation:

    variation = run_variation()
    entry = RobotEntry(config=variation.robot(config))
    match = Match(variation.game(game), robots=[entry], seed=variation.seed, scatter=variation.scatter)

Projects with a `simcore.toml` apply the variation automatically.
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
    """Seed, scatter and factors of one run of a robot program."""

    seed: int = 0
    """Seed of the match."""
    scatter: Scatter | None = None
    """Standard deviations of the scatter; None for the values in `simcore.toml`, or no scatter without a file."""
    factors: Mapping[str, FactorValue] = field(default_factory=dict)
    """Values of the robot and piece parameters that a sweep varies, by factor name."""

    def robot(self, config: RobotConfig) -> RobotConfig:
        """Return the robot configuration after applying the factors of this run.

        Raises:
            ConfigError: A factor is unknown or has an invalid value.
        """
        return vary_robot(config, self.factors)

    def game(self, game: Game) -> Game:
        """Return the game after applying the factors of this run to the game pieces.

        Raises:
            ConfigError: A factor is unknown or has an invalid value.
        """
        return vary_pieces(game, self.factors)


_variation = RunVariation()


def run_variation() -> RunVariation:
    """Return the variation for the matches of robot programs in this process."""
    return _variation


def set_run_variation(variation: RunVariation) -> None:
    """Set the variation for all later matches of robot programs in this process."""
    global _variation
    _variation = variation


def set_factors(factors: Mapping[str, FactorValue]) -> None:
    """Set the factors of a sweep for all later matches, and keep the seed and scatter."""
    set_run_variation(replace(_variation, factors=factors))


def require_varied(match: Match) -> None:
    """Check that a match uses the variation of this run, because a project's own physics.py may ignore the variation.

    Raises:
        SimcoreError: The match has a different seed, scatter, robot or game.
    """
    wanted = _variation
    if match.seed != wanted.seed or (wanted.scatter is not None and match.scatter != wanted.scatter):
        raise SimcoreError(
            f"this run has seed {wanted.seed} and its own scatter, but physics.py builds its match with seed "
            f"{match.seed} and scatter {match.scatter.text!r}; give it Match(..., seed=run_variation().seed, "
            "scatter=run_variation().scatter), from simcore"
        )
    config = match.robots[0].config
    # the factors change nothing in a robot and game to which they have been applied
    if wanted.robot(config) != config or wanted.game(match.game).pieces != match.game.pieces:
        raise SimcoreError(
            f"this run varies {', '.join(wanted.factors)}, but physics.py builds its match without; give it "
            "Match(run_variation().game(game), robots=[RobotEntry(config=run_variation().robot(config))], ...), "
            "from simcore"
        )
