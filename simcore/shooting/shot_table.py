"""A shooter table: for each distance and velocity of the robot the shot with the widest margin, and what it is worth."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from scipy.stats import binomtest, qmc

from simcore.geometry.rotation import wrap_angle
from simcore.match.scatter import Scatter
from simcore.shooting.practice_field import PracticeField
from simcore.shooting.shot_band import BestShot, ShotBand
from simcore.shooting.shot_task import ShotDraws, ShotTask, Stand
from simcore.typing import FloatArray

__all__ = ["ShotShare", "ShotTable", "ShotTableRow", "make_table", "scattered_hits"]

_CLAIM_SHOTS = 2048
"""Of a row's share: a power of 2, as Sobol's sequence wants."""
_LEVEL = 0.95
_MOST_PLACES = 6  # that are tried before a row is given up


@dataclass(frozen=True, slots=True)
class ShotShare:
    """A share of shots with its interval by Wilson (scipy.stats.binomtest)."""

    hits: int
    shots: int
    lower: float
    upper: float

    @classmethod
    def of(cls, hits: int, shots: int, level: float = _LEVEL) -> ShotShare:
        """At a level of confidence [-]."""
        interval = binomtest(hits, shots).proportion_ci(level, method="wilson")
        return cls(hits, shots, float(interval.low), float(interval.high))

    @property
    def share(self) -> float:
        """[-]"""
        return self.hits / self.shots


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotTableRow:
    """One place and velocity of the robot."""

    distance: float
    """From the robot's origin to the middle of the target, along the floor [m]."""
    radial: float
    """Speed of the robot toward the target [m/s]."""
    tangential: float
    """Speed of the robot to the left, looking at the target [m/s]."""
    problem: str = ""
    """Why there is no shot; empty: there is one."""
    bearing: float = math.nan
    """From the robot to the target, where it was worked out, field frame [rad]."""
    elevation: float = math.nan
    """[rad]"""
    hood: float | None = None
    """Angle of the hood's mechanism [rad]; None: the shooter has none."""
    speed: float = math.nan
    """Relative to the muzzle [m/s]."""
    wheel_speed: float = math.nan
    """Of all wheels [rad/s]."""
    lead: float = math.nan
    """Direction of the shot from that to the target, counter-clockwise [rad]."""
    time_of_flight: float = math.nan
    """From the muzzle to the opening [s]."""
    entry_angle: float = math.nan
    """Under the horizontal, at the opening [rad]."""
    by_board: bool = False
    """Whether it touches a board on its way in."""
    slowest: float = math.nan
    """At this elevation [m/s]."""
    fastest: float = math.nan
    """At this elevation [m/s]."""
    flattest: float = math.nan
    """At this speed [rad]."""
    steepest: float = math.nan
    """At this speed [rad]."""
    margin: float = math.nan
    """To the nearest shot that does not go in, in standard deviations of the scatter [-]."""
    share: ShotShare | None = None
    """Of scattered shots that go in."""

    @property
    def is_feasible(self) -> bool:
        """Whether there is a shot."""
        return not self.problem

    @property
    def best(self) -> BestShot:
        """The shot."""
        return BestShot(self.elevation, self.speed, self.margin)

    @property
    def stand(self) -> Stand:
        """Where it was worked out."""
        return Stand(self.distance, self.bearing, self.radial, self.tangential)


@dataclass(frozen=True, slots=True)
class ShotTable:
    """All rows, and what they are of."""

    task: ShotTask
    scatter: Scatter
    rows: tuple[ShotTableRow, ...]
    bands: tuple[ShotBand | None, ...]
    """Of each row; None where the robot has no place."""

    @property
    def feasible(self) -> list[ShotTableRow]:
        """Rows with a shot."""
        return [row for row in self.rows if row.is_feasible]


def make_table(
    task: ShotTask,
    distances: Iterable[float],
    *,
    radial: Iterable[float] = (0.0,),
    tangential: Iterable[float] = (0.0,),
    scatter: Scatter | None = None,
    seed: int = 0,
    engine: str | None = None,
    on_row: Callable[[ShotTableRow], object] = lambda row: None,
) -> ShotTable:
    """Work a table out.

    Args:
        task: Which shooter, at what.
        distances: From the robot's origin to the target [m].
        radial: Speeds of the robot toward the target [m/s].
        tangential: Speeds of the robot to the left of it [m/s].
        scatter: Of the shots; None: the default one.
        seed: Of the scattered shots.
        engine: Name of the physics engine, which says where the robot can stand.
        on_row: Called with each row as it is done.
    """
    spread = Scatter() if scatter is None else scatter
    radials, tangentials = list(radial), list(tangential)
    rows, bands = [], []
    with PracticeField(task, engine=engine) as field:
        for distance in distances:
            for along in radials:
                for across in tangentials:
                    row, band = _row(task, field, distance, along, across, spread, seed + len(rows))
                    rows.append(row)
                    bands.append(band)
                    on_row(row)
    return ShotTable(task, spread, tuple(rows), tuple(bands))


def _row(
    task: ShotTask, field: PracticeField, distance: float, radial: float, tangential: float, scatter: Scatter, seed: int
) -> tuple[ShotTableRow, ShotBand | None]:
    here = {"distance": distance, "radial": radial, "tangential": tangential}
    stands = field.stands(distance, radial, tangential)
    if not stands:
        return ShotTableRow(**here, problem="the robot has no place on the field there"), None
    band = None
    problem = ""
    for stand in stands[:_MOST_PLACES]:
        band = ShotBand.of(task, stand)
        best = band.best(scatter)
        if best is None:
            problem = "no elevation and speed of this shooter go in"
            continue
        if not field.obstacle_free(stand, best.elevation, best.speed):
            problem = "something on the field is in the way"
            continue
        return _worked_out(task, band, best, scatter, seed, here), band
    return ShotTableRow(**here, problem=problem), band


def _worked_out(
    task: ShotTask, band: ShotBand, best: BestShot, scatter: Scatter, seed: int, here: dict[str, float]
) -> ShotTableRow:
    stand = band.stand
    elevation, speed = np.array([best.elevation]), np.array([best.speed])
    yaw = task.lead(stand, elevation, speed)
    seen = task.fly(task.rows(stand, elevation, speed, yaw, np.zeros(1, dtype=np.int64)))
    vx, vy, vz = seen.vel[0].tolist()
    slowest, fastest = band.speed_limits(best)
    flattest, steepest = band.elevation_limits(best)
    shares = np.clip(qmc.Sobol(7, seed=seed).random(_CLAIM_SHOTS), 1e-9, 1.0 - 1e-9)
    hits = int(scattered_hits(task, stand, best, ShotDraws.of(scatter, shares)).sum())
    return ShotTableRow(
        **here,
        bearing=stand.bearing,
        elevation=best.elevation,
        hood=task.hood_for(best.elevation),
        speed=best.speed,
        wheel_speed=task.shooter.wheel_speed_for(best.speed),
        lead=wrap_angle(float(yaw[0]) - stand.bearing),
        time_of_flight=float(seen.time[0]),
        entry_angle=math.atan2(-vz, math.hypot(vx, vy)),
        by_board=bool(seen.by_board[0]),
        slowest=slowest,
        fastest=fastest,
        flattest=flattest,
        steepest=steepest,
        margin=best.margin,
        share=ShotShare.of(hits, _CLAIM_SHOTS),
    )


def scattered_hits(task: ShotTask, stand: Stand, shot: BestShot, draws: ShotDraws) -> FloatArray:
    """Which of many scattered shots go in, from all barrels in turn, as 0 or 1, shape (n,)."""
    n = len(draws.elevation)
    elevation, speed = np.full(n, shot.elevation), np.full(n, shot.speed)
    yaw = np.repeat(task.lead(stand, elevation[:1], speed[:1]), n)
    found = task.fly(task.rows(stand, elevation, speed, yaw, task.barrel_numbers(n), draws))
    return found.goes_in.astype(float)
