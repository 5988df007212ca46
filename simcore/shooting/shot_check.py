"""Whether a shooter table is true: many scattered flights a row, and some of them as real shots of the engine."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import binom

from simcore.pieces.flight import path
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.shooting.practice_field import PracticeField, RealShot
from simcore.shooting.shot_table import ShotTable, ShotTableRow
from simcore.shooting.shot_task import SPREADS, ShotDraws, ShotTask, Stand
from simcore.sweep.sweep_statistics import Share, wilson_share

__all__ = ["Check", "check_by_engine", "check_by_flights", "stated_interval"]

_ALARM = 0.05
"""How often a true table fails a check: the intervals of its rows together hold at 95 %."""
_PATH_LIMIT = 0.02
"""How far the engine may be from the flight before the opening [m]; measured 0.1 to 7 mm, by the engine's steps."""
_CHAOS = 0.02
"""Share of shots that may bounce out of a funnel in the engine and not here, or the other way: after several bounces,
differences of a millimeter decide. Measured: 4 of 700 random shots over the whole band."""


def stated_interval(share: Share, shots: int) -> tuple[int, int]:
    """Least and most of so many real shots that go in, in 95 % of tries, of a share of flights.

    The binomial quantiles at the ends of the share's own interval, moved outward by the chaos of bounces.
    """
    ends = max(0.0, share.lower - _CHAOS), min(1.0, share.upper + _CHAOS)
    low, high = (int(binom.ppf(level, shots, p)) for level, p in zip((0.025, 0.975), ends, strict=True))
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
            draws, claimed = _draws(table, (seed, len(checks)), shots), row.share.value
            found = table.task.share(
                row.worst_stand, row.elevation, row.speed, draws, 1.0 - _ALARM / len(table.feasible)
            )
            claim = f"claimed {claimed:.1%}, found {found.k} of {found.n} ({found.lower:.1%} to {found.upper:.1%})"
            checks[number] = _check(row, found, found.lower <= claimed <= found.upper, claim)
    return checks


def check_by_engine(table: ShotTable, shots: int, *, seed: int, engine: str | None = None) -> list[Check]:
    """Shoot scattered shots of each row in a match, from its bearings in turn, and fly the same launches.

    Paths must agree within their limit; what should go in must score and what should not must not, up to the chaos of
    bounces. Speed, elevation and direction are scattered; pieces are as the game has them. A tank shoots at rest only.

    Args:
        table: What is checked.
        shots: Of each row, from the barrels in turn.
        seed: Of the draws.
        engine: Name of the physics engine; None: see `engine_choice`.
    """
    is_tank = isinstance(table.task.robot.drivetrain, TankConfig)
    rows = [row for row in table.feasible if not (is_tank and any(row.stand.velocity))]
    seen: list[list[tuple[bool, bool, float]]] = [[] for _ in rows]
    barrels = len(table.task.barrels)
    for barrel in range(barrels):
        with PracticeField(table.task, barrel=barrel, seed=seed, engine=engine) as field:
            for number, row in enumerate(rows):
                draws = _draws(table, (seed, number, barrel), shots)
                for one in range(len(range(barrel, shots, barrels))):
                    elevation = row.elevation + float(draws.elevation[one])
                    speed = row.speed * float(draws.exit_speed[one])
                    stand = row.stand._replace(bearing=row.bearings[one % len(row.bearings)][0])
                    shot = field.shoot(stand, elevation, speed, turn=float(draws.azimuth[one]))
                    if shot is not None:
                        seen[number].append((shot.scored, *_flown(table.task, row, stand, shot)))
    checks = []
    for row, found in zip(rows, seen, strict=True):
        scored = [did for did, _, _ in found].count(True)
        lost, gained = (
            [did for did, should, _ in found if should is which].count(not which) for which in (True, False)
        )
        error = max((error for *_, error in found), default=0.0)
        holds = error <= _PATH_LIMIT and wilson_share(max(lost, gained), max(1, len(found))).lower <= _CHAOS
        text = (
            f"{len(found)} real shots, {scored} scored, {lost} that should did not, {gained} that should not did; "
            f"paths within {1e3 * error:.1f} mm (limit {1e3 * _PATH_LIMIT:.0f})"
        )
        checks.append(_check(row, wilson_share(scored, max(1, len(found))), holds, text))
    return checks


def _check(row: ShotTableRow, found: Share, holds: bool, text: str) -> Check:
    return Check(found, holds, f"{row.stand.distance:g} m: {text}: {'holds' if holds else 'does NOT hold'}")


def _draws(table: ShotTable, seed: tuple[int, ...], shots: int) -> ShotDraws:
    return ShotDraws.of(table.scatter, np.random.default_rng(seed).uniform(1e-9, 1.0 - 1e-9, (shots, SPREADS)))


def _flown(task: ShotTask, row: ShotTableRow, stand: Stand, shot: RealShot) -> tuple[bool, float]:
    """Whether the same launch goes in by its flight, and how far the engine's path is from it [m]."""
    aim = np.array([row.elevation]), np.array([row.speed])
    rows = task.rows(stand, *aim, task.lead(stand, *aim))
    rows.pos, rows.vel = shot.points[:1], shot.vel[None]
    opening = task.opening
    away = np.linalg.norm(shot.points - opening.middle, axis=1) >= opening.reach + 2.0 * float(rows.radius[0])
    error = np.linalg.norm(shot.points - path(rows, len(shot.points) - 1)[:, 0], axis=1)
    return bool(task.fly(rows).goes_in[0]), float(error[np.logical_and.accumulate(away)].max(initial=0.0))
