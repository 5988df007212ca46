"""Seed and scatter of the run of a robot program: what `--sim-seed` and `--sim-scatter` of robot tests say.

A robot program builds its match in the process in which it runs. Who starts that process says here, before the program
starts, which of many runs it shall be; whoever builds the match asks:

    variation = run_variation()
    match = Match(game, robots=[entry], seed=variation.seed, scatter=variation.scatter)

A project that is described by `simcore.toml` does so by itself.
"""

from __future__ import annotations

from dataclasses import dataclass

from simcore.errors import SimcoreError
from simcore.match.match import Match
from simcore.match.scatter import Scatter

__all__ = ["RunVariation", "require_varied", "run_variation", "set_run_variation"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RunVariation:
    """Which of many runs of a robot program this is."""

    seed: int = 0
    """Of the match."""
    scatter: Scatter | None = None
    """By how much things differ; None: as `simcore.toml` says, else not at all."""


_variation = RunVariation()


def run_variation() -> RunVariation:
    """That of this process."""
    return _variation


def set_run_variation(variation: RunVariation) -> None:
    """Set it for all matches of robot programs that are built from now on in this process."""
    global _variation
    _variation = variation


def require_varied(match: Match) -> None:
    """Refuse a match that a project's own physics.py has built without asking for seed and scatter.

    Raises:
        SimcoreError: It has others than this run should have.
    """
    wanted = _variation
    if match.seed == wanted.seed and (wanted.scatter is None or match.scatter == wanted.scatter):
        return
    raise SimcoreError(
        f"this run has seed {wanted.seed} and a scatter of its own, but physics.py builds its match with seed "
        f"{match.seed} and scatter {match.scatter.text!r}; give it Match(..., seed=run_variation().seed, "
        "scatter=run_variation().scatter), from simcore"
    )
