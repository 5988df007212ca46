"""A shooter table: for each distance and velocity of the robot a shot with a wide margin, and what it is worth."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.special import ndtri
from scipy.stats import qmc

from simcore.geometry.rotation import wrap_angle
from simcore.match.scatter import Scatter
from simcore.pieces.shot_solver import NoShotError, solve_shot
from simcore.shooting.practice_field import PracticeField
from simcore.shooting.shot_task import SPREADS, ShotDraws, ShotTask, Stand
from simcore.sweep.sweep_statistics import Share
from simcore.typing import BoolArray, FloatArray
from simcore.units import degrees

__all__ = ["ShotBand", "ShotTable", "ShotTableRow", "make_table"]

_ELEVATION_STEP = degrees(0.5)
_SPEED_STEP = 0.0075  # of the speed
_SPARE_ELEVATION, _SPARE_SPEED = degrees(3.0), 0.05  # beyond the shooter's limits: scatter does not stop there
_SLOWER, _FASTER, _TO_BOARD = 0.8, 1.3, 1.5  # times the speed that meets the middle: rim, rim behind, top of a board
_ENOUGH = 6.0  # standard deviations; more is worth nothing: one shot in 10^9 is farther off
_LITTLE = 0.01  # what more than enough is worth
_DEAR = degrees(20.0)
_FINE_SPEED, _FINE_ELEVATION, _FINE_REACH = 0.0025, degrees(0.1), degrees(25.0)
_CLAIM_SHOTS, _BETWEEN_SHOTS = 1024, 512
"""Of a row's shares, from each bearing: powers of 2, as Sobol's sequence wants."""
_APART = degrees(14.9)  # at least, bearings for which a row's share is worked out
_CHOICE_SHOTS = 128  # of each elevation, among which a row's shot is chosen
_KEPT = 0.9  # half way between two rows at least this part of the worse of their shares goes in; else there is a gap
_LEAST = 0.1  # standard deviations that count for a shot that goes in at all
_MOST_PLACES = 6  # that are tried for a row
_PLACE_SHOTS, _PLACE_EVERY = 8, 4  # shots from each, of every fourth elevation
_AS_GOOD = 0.95  # of what goes in from the best place, that takes the one that is most straight on
_NONE: FloatArray = np.zeros(0)


@dataclass(frozen=True, slots=True)
class ShotBand:
    """What goes in, from every barrel, of a grid of elevations and speeds."""

    task: ShotTask
    stand: Stand
    elevations: FloatArray
    """Of the grid [rad], shape (n,)."""
    speeds: FloatArray
    """Of the grid, relative to the muzzle, each a fixed share above the one before [m/s], shape (m,)."""
    inside: BoolArray
    """Shape (n, m)."""

    @classmethod
    def of(cls, task: ShotTask, stand: Stand) -> ShotBand:
        """Fly the shots of a grid around those that meet the target's middle."""
        elevations, middles = _to_middle(task, stand)
        most, fastest = task.max_speed * (1.0 + _SPARE_SPEED), _TO_BOARD if task.boards else _FASTER
        reachable = middles[middles < most]
        speeds: FloatArray = np.zeros(0)
        if len(reachable):
            least = max(_SLOWER * float(reachable.min()), task.min_speed)
            most = min(fastest * float(reachable.max()), most)
            speeds = least * np.exp(_SPEED_STEP * np.arange(max(1, math.ceil(math.log(most / least) / _SPEED_STEP))))
        ratio = speeds[None, :] / middles[:, None]
        row, column = np.nonzero((ratio > _SLOWER) & (ratio < fastest))
        inside: BoolArray = np.zeros(ratio.shape, dtype=bool)
        inside[row, column] = task.hits(stand, elevations[row], speeds[column]).all(axis=1)
        return cls(task, stand, elevations, speeds, inside)

    def widest(self, scatter: Scatter) -> tuple[FloatArray, FloatArray]:
        """Speed [m/s] of each elevation's shot with the widest margin, and that margin, shape (n,) each.

        A margin is the way to the nearest elevation and speed that do not go in, in standard deviations; zero where
        nothing within the shooter's limits goes in.

        Args:
            scatter: Measures the margins; where it has no exit speed or elevation, the default ones do.
        """
        if not self.inside.any():
            return np.zeros(len(self.elevations)), np.zeros(len(self.elevations))
        usual = Scatter()
        sizes = (
            _ELEVATION_STEP / (scatter.elevation or usual.elevation),
            _SPEED_STEP / (scatter.exit_speed or usual.exit_speed),
        )
        margins: FloatArray = distance_transform_edt(np.pad(self.inside, 1), sampling=sizes)[1:-1, 1:-1]
        low, high = self.task.elevations
        margins[(self.elevations < low - 1e-9) | (self.elevations > high + 1e-9)] = 0.0
        margins[:, self.speeds > self.task.max_speed] = 0.0
        column = np.argmax(margins, axis=1)
        return self.speeds[column], margins.max(axis=1)

    def limits(self, elevation: float, speed: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Slowest and fastest shot at an elevation [m/s], flattest and steepest at a speed [rad], that still go in."""
        speeds = speed * np.exp(np.arange(math.log(_SLOWER), math.log(_TO_BOARD), _FINE_SPEED))
        elevations: FloatArray = np.arange(_FINE_ELEVATION, 0.5 * math.pi, _FINE_ELEVATION)
        elevations = elevations[np.abs(elevations - elevation) < _FINE_REACH]
        fast: BoolArray = np.asarray(self.task.hits(self.stand, np.full(len(speeds), elevation), speeds).all(axis=1))
        steep: BoolArray = np.asarray(
            self.task.hits(self.stand, elevations, np.full(len(elevations), speed)).all(axis=1)
        )
        return _around(speeds, fast, speed), _around(elevations, steep, elevation)


def _around(values: FloatArray, inside: BoolArray, middle: float) -> tuple[float, float]:
    """Ends of the unbroken stretch around a value."""
    here = int(np.argmin(np.abs(values - middle)))
    if not inside[here]:
        return middle, middle
    out = np.nonzero(~inside)[0]
    first = int(out[out < here].max(initial=-1)) + 1
    last = int(out[out > here].min(initial=len(values))) - 1
    return float(values[first]), float(values[last])


def _to_middle(task: ShotTask, stand: Stand) -> tuple[FloatArray, FloatArray]:
    """Elevations of the grid [rad], and the speed that meets the middle of the opening [m/s], infinite for none."""
    low, high = task.elevations
    spare = math.ceil(_SPARE_ELEVATION / _ELEVATION_STEP)
    count = math.floor((high - low) / _ELEVATION_STEP + 1e-9)
    grid = low + _ELEVATION_STEP * np.arange(-spare, count + spare + 1)
    elevations: FloatArray = np.array(grid[(grid > 0.0) & (grid < 0.5 * math.pi)], dtype=np.float64)
    speeds, muzzle = np.full(len(elevations), np.inf), task.muzzle(stand, np.array([stand.bearing]))[0]
    for number, elevation in enumerate(elevations.tolist()):
        with contextlib.suppress(NoShotError):
            speeds[number] = solve_shot(
                muzzle, task.opening.middle, elevation=elevation, drag=task.kind.air.drag,
                robot_velocity=stand.velocity, rising=not task.zone.downward,
            ).speed  # fmt: skip
    return elevations, speeds


def _hits_by_place(task: ShotTask, stand: Stand, scatter: Scatter) -> int:
    """How many of some shots of all elevations at the middle go in: fewer where something is in the way."""
    elevations, speeds = _to_middle(task, stand)
    usable = np.nonzero(speeds < task.max_speed)[0][::_PLACE_EVERY]
    hits = task.hits(stand, elevations[usable], speeds[usable], _draws(scatter, 0, _PLACE_SHOTS))
    return int(hits.sum())


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotTableRow:
    """One place and velocity of the robot, and the shot from there; NaN and None where there is none."""

    stand: Stand
    """Where the robot is; its bearing only counts where there is a shot."""
    problem: str = ""
    """Why there is no shot; empty: there is one."""
    band: ShotBand | None = None
    """What goes in from there; None where the robot has no place."""
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
    speeds: tuple[float, float] = (math.nan, math.nan)
    """Slowest and fastest that go in at this elevation [m/s]."""
    elevations: tuple[float, float] = (math.nan, math.nan)
    """Flattest and steepest that go in at this speed [rad]."""
    margin: float = math.nan
    """To the nearest shot that does not go in, in standard deviations of the scatter [-]."""
    bearings: tuple[tuple[float, Share], ...] = ()
    """Bearings, the row's own first, at which the robot can stand and the shot's way is free [rad], 15 deg or more
    apart, and the share that goes in from each."""
    share: Share | None = None
    """Of scattered shots that go in, from where fewest do."""
    between: Share | None = None
    """The same half way to the next distance, with elevation and speed half way between; None: there is none."""
    is_gap: bool = False
    """Whether clearly fewer go in there than from both ends."""

    @property
    def aim(self) -> tuple[FloatArray, FloatArray]:
        """Elevation [rad] and speed [m/s], as `ShotTask` takes them, shape (1,) each."""
        return np.array([self.elevation]), np.array([self.speed])

    @property
    def worst_stand(self) -> Stand:
        """The stand at the bearing from which fewest go in."""
        return self.stand._replace(bearing=min(self.bearings, key=lambda one: one[1].value)[0])

    @property
    def is_feasible(self) -> bool:
        """Whether there is a shot."""
        return not self.problem


@dataclass(frozen=True, slots=True)
class ShotTable:
    """All rows, and what they are of."""

    task: ShotTask
    scatter: Scatter
    rows: tuple[ShotTableRow, ...]

    @property
    def feasible(self) -> list[ShotTableRow]:
        """Rows with a shot."""
        return [row for row in self.rows if row.is_feasible]


def make_table(
    task: ShotTask, distances: Iterable[float], *, radial: Iterable[float] = (0.0,),
    tangential: Iterable[float] = (0.0,), scatter: Scatter | None = None, seed: int = 0, engine: str | None = None,
    on_row: Callable[[ShotTableRow], object] = lambda row: None,
) -> ShotTable:  # fmt: skip
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
    with PracticeField(task, engine=engine) as practice:
        for along, across in itertools.product(radial, tangential):
            places = [_place(task, practice, Stand(away, 0.0, along, across), spread) for away in aways]
            before: ShotTableRow | None = None
            for place, number in zip(places, _choose(places), strict=True):
                row = _row(task, practice, place, number, spread, seed)
                if before is not None and before.share is not None and row.share is not None:
                    middle = 0.5 * (before.elevation + row.elevation), 0.5 * (before.speed + row.speed)
                    stand = before.worst_stand._replace(distance=0.5 * (before.stand.distance + row.stand.distance))
                    between = task.share(stand, *middle, _draws(spread, seed, _BETWEEN_SHOTS))
                    is_gap = between.value < _KEPT * min(before.share.value, row.share.value)
                    rows[-1] = replace(before, between=between, is_gap=is_gap)
                rows.append(row)
                on_row(row)
                before = row
    return ShotTable(task, spread, tuple(sorted(rows, key=lambda row: row.stand.distance)))


class _Place(NamedTuple):
    """Where the robot stands for a row, and the shots from there."""

    stand: Stand
    problem: str
    """Why there is none; empty: there is one."""
    band: ShotBand | None
    speeds: FloatArray = _NONE
    """Of the widest shot of each elevation of the band [m/s], shape (n,)."""
    margins: FloatArray = _NONE
    """Of these shots, in standard deviations, shape (n,)."""
    widths: FloatArray = _NONE
    """The same, but no more than their shares say, shape (n,)."""


def _place(task: ShotTask, practice: PracticeField, wanted: Stand, scatter: Scatter) -> _Place:
    """Where shots are widest, of the places next to where they come straight."""
    stands = practice.stands(wanted)[:_MOST_PLACES]
    if not stands:
        return _Place(wanted, "the robot has no place on the field there", None)
    found = [_hits_by_place(task, stand, scatter) for stand in stands]
    stand = next(one for one, hits in zip(stands, found, strict=True) if hits >= _AS_GOOD * max(found))
    band = ShotBand.of(task, stand)
    speeds, margins = band.widest(scatter)
    shots = np.nonzero(margins)[0]
    if not len(shots):
        return _Place(wanted, "no elevation and speed of this shooter go in", band)
    hits = task.hits(stand, band.elevations[shots], speeds[shots], _draws(scatter, 0, _CHOICE_SHOTS))
    # A wide shot that misses does so by its direction, spin or piece: it is no safer than its share says.
    safe = np.where(hits.all(axis=1), np.inf, ndtri((hits.sum(axis=1) + 0.5) / (_CHOICE_SHOTS + 1.0)))
    widths = np.zeros(len(margins))
    widths[shots] = np.clip(margins[shots], 0.0, np.maximum(safe, _LEAST))
    return _Place(stand, "", band, speeds, margins, widths)


def _smoothest(rows: Sequence[FloatArray]) -> list[int]:
    """Of each of several bands, one after the other in distance, the row of the grid to shoot at.

    A margin is worth what it is up to 6 standard deviations, more is worth nothing; a change of 20 deg from one band to
    the next costs 1. So the table can be interpolated, and gives up margin only where there is plenty.

    Args:
        rows: Widest margin of each elevation of the grid, of each band, shape (n,).

    Returns:
        A row for each; what is best overall (Viterbi's algorithm).
    """
    steps = (_ELEVATION_STEP / _DEAR) * np.arange(len(rows[0]))
    cost = np.square(steps[:, None] - steps[None, :])
    worth = [np.where(row > 0.0, np.minimum(row, _ENOUGH) + _LITTLE * row, -np.inf) for row in rows]
    best, came_from = worth[0], []
    for more in worth[1:]:
        reached = best[:, None] - cost
        came_from.append(np.argmax(reached, axis=0))
        best = reached.max(axis=0) + more
    chosen = [int(np.argmax(best))]
    for origins in reversed(came_from):
        chosen.append(int(origins[chosen[-1]]))
    return chosen[::-1]


def _choose(places: Sequence[_Place]) -> list[int]:
    """The row of the grid to shoot at from each place, distance by distance; one without any (-1) begins anew."""
    chosen: list[int] = []
    for is_blocked, run in itertools.groupby(places, key=lambda place: bool(place.problem)):
        some = list(run)
        chosen += [-1] * len(some) if is_blocked else _smoothest([place.widths for place in some])
    return chosen


def _row(
    task: ShotTask, practice: PracticeField, place: _Place, number: int, scatter: Scatter, seed: int
) -> ShotTableRow:
    """The row of a place's shot, or of why there is none."""
    band, stand = place.band, place.stand
    if band is None or place.problem:
        return ShotTableRow(stand=stand, problem=place.problem, band=band)
    elevation, speed = float(band.elevations[number]), float(place.speeds[number])
    aim = np.array([elevation]), np.array([speed])
    yaw = task.lead(stand, *aim)
    seen = task.fly(task.rows(stand, *aim, yaw))
    vx, vy, vz = seen.vel[0].tolist()
    speeds, elevations = band.limits(elevation, speed)
    draws = _draws(scatter, seed, _CLAIM_SHOTS)
    some = [stand]
    for one in [] if task.boards else practice.stands(stand):
        is_apart = all(abs(wrap_angle(one.bearing - other.bearing)) > _APART for other in some)
        if is_apart and task.hits(one, *aim).all():
            some.append(one)
    bearings = tuple((one.bearing, task.share(one, elevation, speed, draws)) for one in some)
    return ShotTableRow(
        stand=stand, band=band, elevation=elevation, hood=task.hood_for(elevation), speed=speed,
        wheel_speed=task.shooter.wheel_speed_for(speed), lead=wrap_angle(float(yaw[0]) - stand.bearing),
        time_of_flight=float(seen.time[0]), entry_angle=math.atan2(-vz, math.hypot(vx, vy)),
        by_board=bool(seen.by_board[0]), speeds=speeds, elevations=elevations, margin=float(place.margins[number]),
        bearings=bearings, share=min((share for _, share in bearings), key=lambda share: share.value),
    )  # fmt: skip


def _draws(scatter: Scatter, seed: int, count: int) -> ShotDraws:
    return ShotDraws.of(scatter, qmc.Sobol(SPREADS, seed=seed).random(count))
