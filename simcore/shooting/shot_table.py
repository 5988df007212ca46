"""A shooter table: for each distance and velocity of the robot a shot with a wide margin, and what it is worth."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from simcore.geometry.rotation import wrap_angle
from simcore.match.scatter import Scatter
from simcore.shooting.practice_field import PracticeField
from simcore.shooting.shot_band import ENOUGH, BestShot, ShotBand, smoothest
from simcore.shooting.shot_task import SPREADS, ShotDraws, ShotTask, Stand
from simcore.sweep.sweep_statistics import Share, wilson_share
from simcore.typing import FloatArray

__all__ = ["ShotTable", "ShotTableRow", "make_table"]

_CLAIM_SHOTS, _BETWEEN_SHOTS = 2048, 512
"""Of a row's shares: powers of 2, as Sobol's sequence wants."""
_CHOICE_SHOTS = 256  # of each elevation, among which a row's shot is chosen
_LEAST = 0.1  # standard deviations that count for a shot that goes in at all
_MOST_PLACES = 6  # that are tried before a row is given up


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
    share: Share | None = None
    """Of scattered shots that go in."""
    between: Share | None = None
    """The same half way to the next distance, with elevation and speed half way between; None: there is none."""

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
    aways = sorted(distances)
    rows: list[ShotTableRow] = []
    bands: list[ShotBand | None] = []
    with PracticeField(task, engine=engine) as field:
        for along, across in itertools.product(radial, tangential):
            found = [_Place(task, field, Stand(away, 0.0, along, across), spread) for away in aways]
            _choose(found)
            before: ShotTableRow | None = None
            for place in found:
                row = place.row(spread, seed)
                if before is not None and before.is_feasible and row.is_feasible:
                    rows[-1] = replace(before, between=_between(task, before, row, spread, seed))
                rows.append(row)
                bands.append(place.band)
                on_row(row)
                before = row
    order = sorted(range(len(rows)), key=lambda number: (rows[number].distance, number))
    return ShotTable(task, spread, tuple(rows[n] for n in order), tuple(bands[n] for n in order))


class _Place:
    """A place of the robot for a row, and the band of shots from there.

    Where the widest shot is in something's way, the next places to the side are tried, and the best of them is taken.
    """

    def __init__(self, task: ShotTask, field: PracticeField, wanted: Stand, scatter: Scatter) -> None:
        self.task, self.wanted = task, wanted
        self.band: ShotBand | None = None
        self.best: BestShot | None = None
        self.widths: FloatArray = np.zeros(0)
        """Of the widest shot of each elevation of the band whose way is free, in standard deviations, shape (n,)."""
        self._shots: dict[int, BestShot] = {}
        self.problem = "the robot has no place on the field there"
        widest = 0.0
        for stand in field.stands(wanted.distance, wanted.radial, wanted.tangential)[:_MOST_PLACES]:
            band = ShotBand.of(task, stand)
            if self.band is None:
                self.band, self.problem = band, "no elevation and speed of this shooter go in"
            shots, widths = band.widest(scatter), np.zeros(len(band.elevations))
            if not shots:
                continue
            aim = np.array([(shot.elevation, shot.speed) for shot in shots.values()])
            hits = task.scattered_hits(stand, aim[:, 0], aim[:, 1], _draws(scatter, 0, _CHOICE_SHOTS))
            # A wide shot that misses does so by its direction, spin or piece: it is no safer than its share says.
            safe = np.where(hits.all(axis=1), np.inf, ndtri((hits.sum(axis=1) + 0.5) / (_CHOICE_SHOTS + 1.0)))
            widths[list(shots)] = np.clip([shot.margin for shot in shots.values()], 0.0, np.maximum(safe, _LEAST))
            without_field = float(widths.max())
            for number, shot in shots.items():
                if not field.is_way_free(stand, shot.elevation, shot.speed, scatter):
                    widths[number] = 0.0
            free = min(float(widths.max()), ENOUGH)
            if free > widest:
                self.band, self._shots, self.widths, self.problem, widest = band, shots, widths, "", free
            elif not widest:
                self.band, self.problem = band, "something on the field is in the way of every shot"
            if free >= min(without_field, ENOUGH):
                return

    def choose(self, number: int) -> None:
        """Take the shot of a row of the grid."""
        self.best = self._shots[number]

    def row(self, scatter: Scatter, seed: int) -> ShotTableRow:
        """The row of the chosen shot, or of why there is none."""
        wanted, best, band, task = self.wanted, self.best, self.band, self.task
        if best is None or band is None:
            return ShotTableRow(
                distance=wanted.distance, radial=wanted.radial, tangential=wanted.tangential, problem=self.problem
            )
        stand = band.stand
        elevation, speed = np.array([best.elevation]), np.array([best.speed])
        yaw = task.lead(stand, elevation, speed)
        seen = task.fly(task.rows(stand, elevation, speed, yaw, np.zeros(1, dtype=np.int64)))
        vx, vy, vz = seen.vel[0].tolist()
        slowest, fastest = band.speed_limits(best)
        flattest, steepest = band.elevation_limits(best)
        return ShotTableRow(
            distance=wanted.distance,
            radial=wanted.radial,
            tangential=wanted.tangential,
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
            share=_share(task, stand, best, scatter, seed, _CLAIM_SHOTS),
        )


def _choose(places: list[_Place]) -> None:
    """The shots of one velocity, distance by distance; a row without any begins anew."""
    together: list[_Place] = []
    for place in [*places, None]:
        if place is not None and not place.problem:
            together.append(place)
        elif together:
            for one, number in zip(together, smoothest([one.widths for one in together]), strict=True):
                one.choose(number)
            together = []


def _between(task: ShotTask, row: ShotTableRow, after: ShotTableRow, scatter: Scatter, seed: int) -> Share:
    """Of the shots half way between two rows, from where the first was worked out."""
    shot = BestShot(0.5 * (row.elevation + after.elevation), 0.5 * (row.speed + after.speed), 0.0)
    stand = row.stand._replace(distance=0.5 * (row.distance + after.distance))
    return _share(task, stand, shot, scatter, seed, _BETWEEN_SHOTS)


def _share(task: ShotTask, stand: Stand, shot: BestShot, scatter: Scatter, seed: int, count: int) -> Share:
    draws = _draws(scatter, seed, count)
    hits = task.scattered_hits(stand, np.array([shot.elevation]), np.array([shot.speed]), draws)
    return wilson_share(int(hits.sum()), count)


def _draws(scatter: Scatter, seed: int, count: int) -> ShotDraws:
    return ShotDraws.of(scatter, np.clip(qmc.Sobol(SPREADS, seed=seed).random(count), 1e-9, 1.0 - 1e-9))
