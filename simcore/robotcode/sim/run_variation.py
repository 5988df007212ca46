"""Which of many runs of a robot program this is: seed and scatter (`--sim-seed`, `--sim-scatter`), factors of a sweep.

A robot program builds its match in the process in which it runs. Who starts that process says here, before the program
starts, which of many runs it shall be; whoever builds the match asks:

    variation = run_variation()
    entry = RobotEntry(config=variation.robot(config))
    match = Match(variation.game(game), robots=[entry], seed=variation.seed, scatter=variation.scatter)

A project that is described by `simcore.toml` does so by itself.
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
    """Which of many runs of a robot program this is."""

    seed: int = 0
    """Of the match."""
    scatter: Scatter | None = None
    """By how much things differ; None: as `simcore.toml` says, else not at all."""
    factors: Mapping[str, FactorValue] = field(default_factory=dict)
    """What a sweep varies of robot and pieces, by name."""

    def robot(self, config: RobotConfig) -> RobotConfig:
        """The robot of this run.

        Raises:
            ConfigError: There is no such factor, or it cannot have this value.
        """
        return vary_robot(config, self.factors)

    def game(self, game: Game) -> Game:
        """The game of this run; errors as `robot`."""
        return vary_pieces(game, self.factors)


_variation = RunVariation()


def run_variation() -> RunVariation:
    """That of this process."""
    return _variation


def set_run_variation(variation: RunVariation) -> None:
    """Set it for all matches of robot programs that are built from now on in this process."""
    global _variation
    _variation = variation


def set_factors(factors: Mapping[str, FactorValue]) -> None:
    """Set what a sweep varies, whatever seed and scatter are."""
    set_run_variation(replace(_variation, factors=factors))


def require_varied(match: Match) -> None:
    """Refuse a match that a project's own physics.py has built without asking for what this run should have.

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
    # what has its values already is not changed by them
    if wanted.robot(config) != config or wanted.game(match.game).pieces != match.game.pieces:
        raise SimcoreError(
            f"this run varies {', '.join(wanted.factors)}, but physics.py builds its match without; give it "
            "Match(run_variation().game(game), robots=[RobotEntry(config=run_variation().robot(config))], ...), "
            "from simcore"
        )
