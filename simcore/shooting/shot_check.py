"""Whether a shooter table is true: many scattered flights a row, and some of them as real shots of the engine."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.pieces.aerodynamics import fly_rows
from simcore.pieces.shot_flight import ShotRows
from simcore.shooting.practice_field import PracticeField, RealShot
from simcore.shooting.shot_table import ShotTable, ShotTableRow, scattered_hits
from simcore.shooting.shot_task import SPREADS, ShotDraws, ShotTask
from simcore.sweep.sweep_statistics import Share, wilson_share
from simcore.units import GRAVITY, TICK

__all__ = ["EngineCheck", "FlightCheck", "check_by_engine", "check_by_flights"]

_ALARM = 0.05
"""How often a true table fails a check: the intervals of its rows together hold at 95 %."""
_FLY_ERROR = 0.0005  # [m]; of the midpoint rule in 3 s at 15 m/s, against solve_ivp
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
    path_limit: float
    """What it may be, by the engine's order in drag [m]."""

    @property
    def holds(self) -> bool:
        """Whether paths agree within their limit, and what should go in scores, up to the chaos of bounces."""
        agrees = self.expected == 0 or wilson_share(self.lost, self.expected).lower <= _CHAOS
        return agrees and self.path_error <= self.path_limit

    def __str__(self) -> str:
        """One line."""
        return (
            f"{self.row.distance:g} m: {self.shots} real shots, {self.scored} scored, of {self.expected} that should "
            f"{self.lost} did not; paths within {1e3 * self.path_error:.1f} mm (limit {1e3 * self.path_limit:.1f}): "
            f"{'holds' if self.holds else 'does NOT hold'}"
        )


def check_by_flights(table: ShotTable, shots: int, *, seed: int) -> list[FlightCheck]:
    """Fly scattered shots of each row with a shot, drawn anew.

    Args:
        table: What is checked.
        shots: Of each row.
        seed: Of the draws; another one than the table's own are made with.
    """
    checks = []
    rows = table.feasible
    for number, row in enumerate(rows):
        shares = np.random.default_rng((seed, number)).uniform(1e-9, 1.0 - 1e-9, (shots, SPREADS))
        hits = scattered_hits(table.task, row.stand, row.best, ShotDraws.of(table.scatter, shares))
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
    task = table.task
    rows = [row for row in table.feasible if row.radial == row.tangential == 0.0]
    seen: list[list[tuple[RealShot, bool, float, float]]] = [[] for _ in rows]
    barrels = len(task.barrels)
    for barrel in range(barrels):
        with PracticeField(task, barrel=barrel, seed=seed, engine=engine) as field:
            for number, row in enumerate(rows):
                shares = np.random.default_rng((seed, number, barrel)).uniform(1e-9, 1.0 - 1e-9, (shots, SPREADS))
                draws = ShotDraws.of(table.scatter, shares)
                for one in range(len(range(barrel, shots, barrels))):
                    elevation = row.elevation + float(draws.elevation[one])
                    speed = row.speed * float(draws.exit_speed[one])
                    shot = field.shoot(row.stand, elevation, speed, turn=float(draws.azimuth[one]))
                    if shot is not None:
                        seen[number].append((shot, *_flown(task, row, shot)))
    checks = []
    for row, found in zip(rows, seen, strict=True):
        expected = [shot for shot, goes_in, _, _ in found if goes_in]
        worst = max(found, key=lambda one: one[2] / one[3], default=None)
        checks.append(
            EngineCheck(
                row,
                shots=len(found),
                scored=len([shot for shot, _, _, _ in found if shot.scored]),
                expected=len(expected),
                lost=len([shot for shot in expected if not shot.scored]),
                path_error=worst[2] if worst else 0.0,
                path_limit=worst[3] if worst else 0.0,
            )
        )
    return checks


def _flown(task: ShotTask, row: ShotTableRow, shot: RealShot) -> tuple[bool, float, float]:
    """Whether the same launch goes in by its flight, how far the engine's path is from it [m], and how far it may be.

    A sub-step h of the engine moves by leapfrog, whose kick wants the drag at its start; the engine takes it from a
    velocity that is gravity's half step later and lacks the drag's own. So the drag is that of a velocity that is off
    by up to (g + k v^2) h / 2, and off by 2 k v times that; the place is off by the integral of the integral of it.
    """
    one = np.ones(1)
    launched = task.rows(
        row.stand, row.elevation * one, row.speed * one, row.bearing * one, np.zeros(1, dtype=np.int64)
    )
    rows = ShotRows(
        pos=shot.points[:1].copy(), vel=shot.vel[None].copy(), spin=launched.spin, radius=launched.radius,
        air=launched.air,
    )  # fmt: skip
    goes_in = bool(task.fly(rows).goes_in[0])
    drag, h = task.kind.air.drag, TICK / shot.substeps
    pos, vel, spin = rows.pos, rows.vel, rows.spin
    error = limit = late = 0.0
    near = task.opening.reach + 2.0 * float(rows.radius[0])
    for point in shot.points[1:]:
        speed = float(np.linalg.norm(vel))
        late += drag * speed * (GRAVITY + drag * speed * speed) * h * TICK
        limit += late * TICK
        pos, vel = fly_rows(pos, vel, spin, TICK, gravity=GRAVITY, factors=rows.air)
        if math.dist(point, task.opening.middle) < near:
            break
        error = max(error, math.dist(point, pos[0]))
    return goes_in, error, limit + _FLY_ERROR
