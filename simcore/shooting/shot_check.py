"""Whether a shooter table is true: many scattered flights a row, and some of them as real shots of the engine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simcore.pieces.flight import path
from simcore.shooting.practice_field import PracticeField, RealShot
from simcore.shooting.shot_table import ShotTable, ShotTableRow
from simcore.shooting.shot_task import SPREADS, ShotDraws, ShotTask
from simcore.sweep.sweep_statistics import Share, wilson_share

__all__ = ["EngineCheck", "FlightCheck", "check_by_engine", "check_by_flights"]

_ALARM = 0.05
"""How often a true table fails a check: the intervals of its rows together hold at 95 %."""
_PATH_LIMIT = 0.02
"""How far the engine may be from the flight before the opening [m]; measured 0.1 to 7 mm, by the engine's steps."""
_CHAOS = 0.02
"""Share of shots that may bounce out of a funnel in the engine and not here, or the other way: after several bounces,
differences of a millimeter decide. Measured: 4 of 700 random shots over the whole band."""


@dataclass(frozen=True, slots=True)
class FlightCheck:
    """Many scattered flights of one row."""

    row: ShotTableRow
    found: Share

    @property
    def holds(self) -> bool:
        """Whether the row's share is within the interval of these flights."""
        assert self.row.share is not None
        return self.found.lower <= self.row.share.value <= self.found.upper

    def __str__(self) -> str:
        """One line."""
        assert self.row.share is not None
        found = self.found
        return (
            f"{self.row.distance:g} m: claimed {self.row.share.value:.1%}, found {found.k} of {found.n}"
            f" ({found.lower:.1%} to {found.upper:.1%}): {'holds' if self.holds else 'does NOT hold'}"
        )


@dataclass(frozen=True, slots=True)
class EngineCheck:
    """Real shots of one row in a match, beside flights from the same launches."""

    row: ShotTableRow
    shots: int
    scored: int
    expected: int
    """Of which the flight says that they go in."""
    lost: int
    """Of those, how many did not score."""
    path_error: float
    """Largest distance between flight and engine before the opening [m]."""

    @property
    def holds(self) -> bool:
        """Whether paths agree within their limit, and what should go in scores, up to the chaos of bounces."""
        agrees = self.expected == 0 or wilson_share(self.lost, self.expected).lower <= _CHAOS
        return agrees and self.path_error <= _PATH_LIMIT

    def __str__(self) -> str:
        """One line."""
        return (
            f"{self.row.distance:g} m: {self.shots} real shots, {self.scored} scored, of {self.expected} that should "
            f"{self.lost} did not; paths within {1e3 * self.path_error:.1f} mm (limit {1e3 * _PATH_LIMIT:.0f}): "
            f"{'holds' if self.holds else 'does NOT hold'}"
        )


def check_by_flights(table: ShotTable, shots: int, *, seed: int) -> list[FlightCheck]:
    """Fly scattered shots of each row with a shot, drawn anew.

    Args:
        table: What is checked.
        shots: Of each row.
        seed: Of the draws; another one than the table's own are made with.
    """
    checks, rows = [], table.feasible
    for number, row in enumerate(rows):
        aim = np.array([row.elevation]), np.array([row.speed])
        hits = table.task.scattered_hits(row.stand, *aim, _draws(table, (seed, number), shots))
        checks.append(FlightCheck(row, wilson_share(int(hits.sum()), shots, 1.0 - _ALARM / len(rows))))
    return checks


def check_by_engine(table: ShotTable, shots: int, *, seed: int, engine: str | None = None) -> list[EngineCheck]:
    """Shoot scattered shots of each row of a robot at rest in a match, and fly the same launches.

    Speed, elevation and direction are scattered; pieces are as the game has them.

    Args:
        table: What is checked.
        shots: Of each row, from the barrels in turn.
        seed: Of the draws.
        engine: Name of the physics engine; None: see `engine_choice`.
    """
    rows = [row for row in table.feasible if row.radial == row.tangential == 0.0]
    seen: list[list[tuple[bool, bool, float]]] = [[] for _ in rows]
    barrels = len(table.task.barrels)
    for barrel in range(barrels):
        with PracticeField(table.task, barrel=barrel, seed=seed, engine=engine) as field:
            for number, row in enumerate(rows):
                draws = _draws(table, (seed, number, barrel), shots)
                for one in range(len(range(barrel, shots, barrels))):
                    elevation = row.elevation + float(draws.elevation[one])
                    speed = row.speed * float(draws.exit_speed[one])
                    shot = field.shoot(row.stand, elevation, speed, turn=float(draws.azimuth[one]))
                    if shot is not None:
                        seen[number].append((shot.scored, *_flown(table.task, row, shot)))
    checks = []
    for row, found in zip(rows, seen, strict=True):
        scored, expected = [one for one in found if one[0]], [one for one in found if one[1]]
        lost, worst = [one for one in expected if not one[0]], max((one[2] for one in found), default=0.0)
        checks.append(EngineCheck(row, len(found), len(scored), len(expected), len(lost), worst))
    return checks


def _draws(table: ShotTable, seed: tuple[int, ...], shots: int) -> ShotDraws:
    return ShotDraws.of(table.scatter, np.random.default_rng(seed).uniform(1e-9, 1.0 - 1e-9, (shots, SPREADS)))


def _flown(task: ShotTask, row: ShotTableRow, shot: RealShot) -> tuple[bool, float]:
    """Whether the same launch goes in by its flight, and how far the engine's path is from it [m]."""
    one = np.ones(1)
    rows = task.rows(row.stand, row.elevation * one, row.speed * one, row.bearing * one, np.zeros(1, dtype=np.int64))
    rows.pos, rows.vel = shot.points[:1], shot.vel[None]
    whole = task.zone.opening or task.opening  # with its boards, which the engine has in any case
    near = whole.reach + 2.0 * float(rows.radius[0])
    away = np.linalg.norm(shot.points - task.opening.middle, axis=1) >= near
    error = np.linalg.norm(shot.points - path(rows, len(shot.points) - 1)[:, 0], axis=1)
    return bool(task.fly(rows).goes_in[0]), float(error[np.logical_and.accumulate(away)].max(initial=0.0))
