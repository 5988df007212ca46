"""A shooter table: for each distance and velocity of the robot a shot with much room, what it is worth, and checks.

Shots of all elevations and speeds are flown around those that `solve_shot` gives. Of each elevation the middle one of
those that go in is flown with scatter, and of the elevations from which most go in the middle one is the row's.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import binom, qmc

from simcore.geometry.rotation import wrap_angle
from simcore.match.scatter import Scatter
from simcore.pieces.shot_solver import NoShotError, solve_shot
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.shooting.practice_field import PracticeField
from simcore.shooting.shot_task import SPREADS, ShotDraws, ShotTask, Stand
from simcore.sweep.sweep_statistics import Share, wilson_share
from simcore.typing import BoolArray, FloatArray
from simcore.units import degrees

__all__ = [
    "Check", "ShotBand", "ShotTable", "ShotTableRow", "check_by_flights", "check_in_match", "make_table",
    "stated_interval", "stretches",
]  # fmt: skip

_ELEVATION_STEP, _SPEED_STEP = degrees(0.5), 0.0075  # of the grid; of the speed
_SPARE_ELEVATION, _SPARE_SPEED = degrees(15.0), 0.05  # flown beyond the shooter's limits, so that a margin has its end
_SLOWER, _FASTER, _TO_BOARD = 0.8, 1.3, 1.5  # times the speed that meets the middle: rim, rim behind, top of a board
_CLAIM_SHOTS, _BETWEEN_SHOTS, _STATED_SHOTS = 1024, 512, 512
"""Of a row's shares, from each bearing: powers of 2, as Sobol's sequence wants."""
_APART = degrees(14.9)  # at least, bearings for which a row's share is worked out
_CHOICE_SHOTS, _CHOICE_EVERY = 512, 3  # of every third elevation, among which a row's is chosen
_AS_SAFE = 0.01  # a share of them that is less than the best by no more is as good
_KEPT = 0.9  # half way between two rows at least this part of the worse of their shares goes in; else there is a gap
_MOST_PLACES, _PLACE_SHOTS, _PLACE_EVERY = 6, 8, 4  # tried for a row, with shots of every fourth elevation of the grid
_AS_GOOD = 0.95  # of what goes in from the best place, that takes the one that is most straight on
_ALARM = 0.05
"""How often a true table fails a check: the intervals of its rows together hold at 95 %."""
_COLUMNS = (
    "bearing_deg", "bearings_deg", "elevation_deg", "hood_turns", "speed_mps", "wheel_rps", "lead_deg",
    "time_of_flight_s", "entry_angle_deg", "by_board", "slowest_mps", "fastest_mps", "flattest_deg", "steepest_deg",
    "margin_sd",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ShotBand:
    """What goes in, from every barrel, of a grid of elevations and speeds."""

    elevations: FloatArray
    """Of the grid [rad], shape (n,)."""
    speeds: FloatArray
    """Of the grid, relative to the muzzle, each a fixed share above the one before [m/s], shape (m,)."""
    inside: BoolArray
    """Shape (n, m)."""

    @classmethod
    def of(cls, task: ShotTask, stand: Stand) -> ShotBand:
        """Fly the shots of a grid around those that meet the target's middle."""
        elevations = _grid(task)
        middles = _to_middle(task, stand, elevations)
        most, fastest = task.max_speed * (1.0 + _SPARE_SPEED), _TO_BOARD if task.boards else _FASTER
        reachable = middles[middles < most]
        if not len(reachable):
            return cls(elevations, np.zeros(0), np.zeros((len(elevations), 0), dtype=bool))
        least = max(_SLOWER * float(reachable.min()), task.min_speed)
        most = min(fastest * float(reachable.max()), most)
        speeds = least * np.exp(_SPEED_STEP * np.arange(max(1, math.ceil(math.log(most / least) / _SPEED_STEP))))
        ratio = speeds[None, :] / middles[:, None]
        row, column = np.nonzero((ratio > _SLOWER) & (ratio < fastest))
        inside: BoolArray = np.zeros(ratio.shape, dtype=bool)
        inside[row, column] = task.hits(stand, elevations[row], speeds[column]).all(axis=1)
        return cls(elevations, speeds, inside)


def _grid(task: ShotTask) -> FloatArray:
    """Elevations that are flown [rad], shape (n,)."""
    low, high = task.elevations
    spare = math.ceil(_SPARE_ELEVATION / _ELEVATION_STEP)
    count = math.floor((high - low) / _ELEVATION_STEP + 1e-9)
    grid: FloatArray = np.array(low + _ELEVATION_STEP * np.arange(-spare, count + spare + 1), dtype=np.float64)
    return grid[(grid > 0.0) & (grid < 0.5 * math.pi)]


def _to_middle(task: ShotTask, stand: Stand, elevations: FloatArray) -> FloatArray:
    """Speed of each elevation that meets the middle of the opening [m/s], infinite for none, shape (n,)."""
    speeds, muzzle = np.full(len(elevations), np.inf), task.muzzle(stand, np.array([stand.bearing]))[0]
    for number, elevation in enumerate(elevations.tolist()):
        with contextlib.suppress(NoShotError):
            speeds[number] = solve_shot(
                muzzle, task.opening.middle, elevation=elevation, drag=task.kind.air.drag,
                robot_velocity=stand.velocity, rising=not task.zone.downward,
            ).speed  # fmt: skip
    return speeds


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotTableRow:
    """One place and velocity of the robot, and the shot from there."""

    stand: Stand
    """Where the robot is; its bearing only counts where there is a shot."""
    problem: str = ""
    """Why there is no shot; empty: there is one."""
    band: ShotBand | None = None
    """What goes in from there; None where the robot has no place."""
    elevation: float = math.nan
    """[rad]"""
    speed: float = math.nan
    """Relative to the muzzle [m/s]."""
    shot: Mapping[str, Any] = field(default_factory=lambda: dict.fromkeys(_COLUMNS))
    """By column, with its unit; None for what there is not. Columns that are not plain:

    - `lead_deg`: direction of the shot from that to the target, counter-clockwise;
    - `by_board`: whether it touches a board on its way in;
    - `slowest_mps`, `fastest_mps`, `flattest_deg`, `steepest_deg`: ends of what goes in with the other one as it is;
    - `margin_sd`: to the nearest of these ends, in standard deviations of the scatter (where it has none, the default).
    """
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


@dataclass(frozen=True, slots=True)
class ShotTable:
    """All rows, and what they are of."""

    task: ShotTask
    scatter: Scatter
    rows: tuple[ShotTableRow, ...]

    @property
    def feasible(self) -> list[ShotTableRow]:
        """Rows with a shot."""
        return [row for row in self.rows if not row.problem]


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
    spread, aways = scatter or Scatter(), sorted(distances)
    rows: list[ShotTableRow] = []
    with PracticeField(task, engine=engine) as practice:
        for along, across in itertools.product(radial, tangential):
            before: ShotTableRow | None = None
            for away in aways:
                row = _row(task, practice, Stand(away, 0.0, along, across), spread, seed)
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


def _row(task: ShotTask, practice: PracticeField, wanted: Stand, scatter: Scatter, seed: int) -> ShotTableRow:
    """The row of a distance and velocity: its shot, or why there is none."""
    stands = practice.stands(wanted)
    if not stands:
        return ShotTableRow(stand=wanted, problem="the robot has no place on the field there")
    stand = _clearest(task, stands[:_MOST_PLACES], scatter)
    band = ShotBand.of(task, stand)
    usable = band.inside & task.can_tilt(band.elevations)[:, None] & (band.speeds <= task.max_speed)
    shots = np.nonzero(usable.any(axis=1))[0][::_CHOICE_EVERY]
    if not len(shots):
        return ShotTableRow(stand=wanted, problem="no elevation and speed of this shooter go in", band=band)
    columns = [_middle(usable[shot]) for shot in shots]
    draws = _draws(scatter, 0, _CHOICE_SHOTS)
    shares = task.hits(stand, band.elevations[shots], band.speeds[columns], draws).mean(axis=1)
    good = np.nonzero(shares >= shares.max() - _AS_SAFE)[0]
    best = int(good[len(good) // 2])
    number, column = int(shots[best]), columns[best]
    elevation, speed = float(band.elevations[number]), float(band.speeds[column])
    aim = np.array([elevation]), np.array([speed])
    some = [stand]
    for one in [] if task.boards else stands:
        is_apart = all(abs(wrap_angle(one.bearing - other.bearing)) > _APART for other in some)
        if is_apart and task.hits(one, *aim).all():
            some.append(one)
    draws = _draws(scatter, seed, _CLAIM_SHOTS)
    bearings = tuple((one.bearing, task.share(one, elevation, speed, draws)) for one in some)
    return ShotTableRow(
        stand=stand, band=band, elevation=elevation, speed=speed,
        shot=_described(task, stand, band, number, column, [bearing for bearing, _ in bearings], scatter),
        bearings=bearings, share=min((share for _, share in bearings), key=lambda share: share.value),
    )  # fmt: skip


def _described(
    task: ShotTask, stand: Stand, band: ShotBand, number: int, column: int, bearings: Sequence[float], scatter: Scatter
) -> dict[str, Any]:
    """The columns of the shot of an elevation and a speed of a band, by number."""
    elevation, speed, deg = float(band.elevations[number]), float(band.speeds[column]), math.degrees
    aim = np.array([elevation]), np.array([speed])
    yaw, hood = task.lead(stand, *aim), task.hood_for(elevation)
    seen = task.fly(task.rows(stand, *aim, yaw))
    vx, vy, vz = seen.vel[0].tolist()
    speeds = _around(band.speeds, band.inside[number], column)
    elevations = _around(band.elevations, band.inside[:, column], number)
    margin = min(
        min(math.log(speed / speeds[0]), math.log(speeds[1] / speed)) / (scatter.exit_speed or Scatter().exit_speed),
        min(elevation - elevations[0], elevations[1] - elevation) / (scatter.elevation or Scatter().elevation),
    )
    values = (
        deg(stand.bearing), " ".join(f"{bearing:.0f}" for bearing in sorted(map(deg, bearings))), deg(elevation),
        None if hood is None else hood / math.tau, speed, task.shooter.wheel_speed_for(speed) / math.tau,
        deg(wrap_angle(float(yaw[0]) - stand.bearing)), float(seen.time[0]), deg(math.atan2(-vz, math.hypot(vx, vy))),
        bool(seen.by_board[0]), *speeds, *map(deg, elevations), margin,
    )  # fmt: skip
    return dict(zip(_COLUMNS, values, strict=True))


def _clearest(task: ShotTask, stands: Sequence[Stand], scatter: Scatter) -> Stand:
    """The first stand from which about as many shots at the middle go in as from the best: nothing is in their way."""
    found, up = [], _grid(task)
    up = up[task.can_tilt(up)][::_PLACE_EVERY]
    for stand in stands:
        fast = _to_middle(task, stand, up)
        usable = fast < task.max_speed
        found.append(int(task.hits(stand, up[usable], fast[usable], _draws(scatter, 0, _PLACE_SHOTS)).sum()))
    return next(one for one, hits in zip(stands, found, strict=True) if hits >= _AS_GOOD * max(found))


def stretches(inside: BoolArray) -> list[tuple[int, int]]:
    """First and last number of each unbroken stretch."""
    edges = np.nonzero(np.diff(np.pad(inside.astype(int), 1)))[0].tolist()
    return [(first, after - 1) for first, after in zip(edges[::2], edges[1::2], strict=True)]


def _middle(inside: BoolArray) -> int:
    """Number in the middle of the longest stretch."""
    first, last = max(stretches(inside), key=lambda ends: ends[1] - ends[0])
    return (first + last) // 2


def _around(values: FloatArray, inside: BoolArray, here: int) -> tuple[float, float]:
    """Ends of the stretch around a number."""
    first, last = next(ends for ends in stretches(inside) if ends[0] <= here <= ends[1])
    return float(values[first]), float(values[last])


def _draws(scatter: Scatter, seed: int, count: int) -> ShotDraws:
    return ShotDraws.of(scatter, qmc.Sobol(SPREADS, seed=seed).random(count))


# --- checks ---------------------------------------------------------------------------------------------------------


class Check(NamedTuple):
    """What came of checking one row."""

    found: Share
    """Of the flights or shots that scored."""
    holds: bool
    text: str
    """One line."""


def stated_interval(share: Share, shots: int) -> tuple[int, int]:
    """Least and most of so many real shots that go in, in 95 % of tries, of a share of flights.

    The binomial quantiles at the ends of the share's own interval.
    """
    low, high = (int(binom.ppf(level, shots, p)) for level, p in ((0.025, share.lower), (0.975, share.upper)))
    return low, high


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
            draws, claimed = _fresh_draws(table.scatter, (seed, len(checks)), shots), row.share.value
            level = 1.0 - _ALARM / len(table.feasible)
            found = table.task.share(row.worst_stand, row.elevation, row.speed, draws, level)
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
        with PracticeField(table.task, barrel=barrel, seed=seed, engine=engine) as practice:
            for number, row in enumerate(rows):
                draws = _fresh_draws(scatter, (seed, number, barrel), shots)
                for one in range(len(range(barrel, shots, barrels))):
                    aim = row.elevation + float(draws.elevation[one]), row.speed * float(draws.exit_speed[one])
                    stand = row.stand._replace(bearing=row.bearings[one % len(row.bearings)][0])
                    shot = practice.shoot(stand, *aim, turn=float(draws.azimuth[one]))
                    scored[number] += [] if shot is None else [shot]
    checks = []
    for number, (row, found) in enumerate(zip(rows, scored, strict=True)):
        draws = _fresh_draws(scatter, (seed, number), _STATED_SHOTS)
        stands = [row.stand._replace(bearing=bearing) for bearing, _ in row.bearings]
        hits = np.array([table.task.hits(one, *row.aim, draws) for one in stands])
        stated = wilson_share(int(hits.sum()), hits.size)
        (low, high), count = stated_interval(stated, len(found)), found.count(True)
        text = f"{len(found)} shots in a match, {count} scored, {low} to {high} should ({stated.value:.1%} of flights)"
        checks.append(_check(row, wilson_share(count, max(1, len(found))), low <= count <= high, text))
    return checks


def _check(row: ShotTableRow, found: Share, holds: bool, text: str) -> Check:
    return Check(found, holds, f"{row.stand.distance:g} m: {text}: {'holds' if holds else 'does NOT hold'}")


def _fresh_draws(scatter: Scatter, seed: tuple[int, ...], shots: int) -> ShotDraws:
    return ShotDraws.of(scatter, np.random.default_rng(seed).uniform(size=(shots, SPREADS)))
