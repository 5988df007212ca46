"""Whether a shooter table is true: many scattered flights a row, and some shots of the robot in a match."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.stats import binom

from simcore.match.scatter import Scatter
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.shooting.practice_field import PracticeField
from simcore.shooting.shot_table import ShotTable, ShotTableRow
from simcore.shooting.shot_task import SPREADS, ShotDraws
from simcore.sweep.sweep_statistics import Share, wilson_share

__all__ = ["Check", "check_by_flights", "check_in_match", "stated_interval"]

_ALARM = 0.05
"""How often a true table fails a check: the intervals of its rows together hold at 95 %."""
_STATED_SHOTS = 512  # flights from each bearing


def stated_interval(share: Share, shots: int) -> tuple[int, int]:
    """Least and most of so many real shots that go in, in 95 % of tries, of a share of flights.

    The binomial quantiles at the ends of the share's own interval.
    """
    low, high = (int(binom.ppf(level, shots, p)) for level, p in ((0.025, share.lower), (0.975, share.upper)))
    return low, high


class Check(NamedTuple):
    """What came of checking one row."""

    found: Share
    """Of the flights or shots that scored."""
    holds: bool
    text: str
    """One line."""


def check_by_flights(table: ShotTable, shots: int, *, seed: int) -> dict[int, Check]:
    """Fly scattered shots of each row with a shot, drawn anew: the row's share must be within their interval.

    Args:
        table: What is checked.
        shots: Of each row.
        seed: Of the draws; another one than the table's own are made with.

    Returns:
        The checks by the number of their row.
    """
    checks: dict[int, Check] = {}
    for number, row in enumerate(table.rows):
        if row.share is not None:
            draws, claimed = _draws(table.scatter, (seed, len(checks)), shots), row.share.value
            found = table.task.share(
                row.worst_stand, row.elevation, row.speed, draws, 1.0 - _ALARM / len(table.feasible)
            )
            claim = f"claimed {claimed:.1%}, found {found.k} of {found.n} ({found.lower:.1%} to {found.upper:.1%})"
            checks[number] = _check(row, found, found.lower <= claimed <= found.upper, claim)
    return checks


def check_in_match(table: ShotTable, shots: int, *, seed: int, engine: str | None = None) -> list[Check]:
    """Shoot scattered shots of each row in a match, from its bearings in turn: as many must score as flights say.

    Speed, elevation and direction are scattered; pieces are as the game has them. A tank shoots at rest only.

    Args:
        table: What is checked.
        shots: Of each row, from the barrels in turn.
        seed: Of the draws.
        engine: Name of the physics engine; None: see `engine_choice`.
    """
    is_tank = isinstance(table.task.robot.drivetrain, TankConfig)
    rows = [row for row in table.feasible if not (is_tank and any(row.stand.velocity))]
    scatter = replace(table.scatter, spin=0.0, piece_mass=0.0, piece_diameter=0.0, drag=0.0)
    scored: list[list[bool]] = [[] for _ in rows]
    barrels = len(table.task.barrels)
    for barrel in range(barrels):
        with PracticeField(table.task, barrel=barrel, seed=seed, engine=engine) as field:
            for number, row in enumerate(rows):
                draws = _draws(scatter, (seed, number, barrel), shots)
                for one in range(len(range(barrel, shots, barrels))):
                    elevation = row.elevation + float(draws.elevation[one])
                    speed = row.speed * float(draws.exit_speed[one])
                    stand = row.stand._replace(bearing=row.bearings[one % len(row.bearings)][0])
                    shot = field.shoot(stand, elevation, speed, turn=float(draws.azimuth[one]))
                    scored[number] += [] if shot is None else [shot]
    checks = []
    for number, (row, found) in enumerate(zip(rows, scored, strict=True)):
        draws = _draws(scatter, (seed, number), _STATED_SHOTS)
        stands = [row.stand._replace(bearing=bearing) for bearing, _ in row.bearings]
        hits = np.array([table.task.hits(one, *row.aim, draws) for one in stands])
        stated = wilson_share(int(hits.sum()), hits.size)
        (low, high), count = stated_interval(stated, len(found)), found.count(True)
        text = f"{len(found)} shots in a match, {count} scored, {low} to {high} should ({stated.value:.1%} of flights)"
        checks.append(_check(row, wilson_share(count, max(1, len(found))), low <= count <= high, text))
    return checks


def _check(row: ShotTableRow, found: Share, holds: bool, text: str) -> Check:
    return Check(found, holds, f"{row.stand.distance:g} m: {text}: {'holds' if holds else 'does NOT hold'}")


def _draws(scatter: Scatter, seed: tuple[int, ...], shots: int) -> ShotDraws:
    return ShotDraws.of(scatter, np.random.default_rng(seed).uniform(1e-9, 1.0 - 1e-9, (shots, SPREADS)))
