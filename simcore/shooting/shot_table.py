"""A shooter table: for each distance and velocity of the robot the shot with the best margin, and what it is worth.

The loop flies shots of all elevations and speeds around those that `solve_shot` gives. Of each elevation the middle one
of the speeds that go in is looked at; the row's shot is the one whose elevation and speed may be farthest off, counted
in standard deviations of the scatter. Scattered flights of it say how many go in.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from simcore.geometry.rotation import wrap_angle
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.scatter import Scatter
from simcore.match.starts import StartError
from simcore.pieces.shot_solver import NoShotError, solve_shot
from simcore.shooting.shot_task import ShotDraws, ShotTask, Stand
from simcore.typing import BoolArray, FloatArray
from simcore.units import degrees

__all__ = ["ShotBand", "ShotTable", "ShotTableRow", "make_table"]

_ELEVATION_STEP, _SPEED_STEP = degrees(0.5), 0.0075  # of the grid; of the speed
_SPARE_ELEVATION, _SPARE_SPEED = degrees(15.0), 0.05  # flown beyond the shooter's limits, so that a margin has its end
_SLOWER, _FASTER = 0.8, 1.3  # times the speed that meets the middle: rim and rim behind
_SHOTS, _BETWEEN_SHOTS = 1024, 512  # scattered, of a row's share from each bearing, and half way between two rows
_AS_SAFE = 0.97  # of the best margin, above which a shot is as good; the middle one of these is the row's
_KEPT = 0.9  # half way between two rows at least this part of the worse of their shares goes in; else there is a gap
_TURN, _FARTHEST_TURN = degrees(5.0), degrees(90.0)  # between bearings that are tried, and from where shots come in
_APART = degrees(14.9)  # at least, bearings for which a row's share is worked out
_LEVEL = 0.005  # [m] and [rad]: a robot on a bump shoots otherwise
_MOST_PLACES, _PLACE_EVERY = 6, 4  # tried for a row, with every fourth elevation of the grid
_AS_GOOD = 0.95  # of what goes in from the best place, that takes the one that is most straight on
_COLUMNS = (
    "bearing_deg", "bearings_deg", "elevation_deg", "hood_turns", "speed_mps", "wheel_rps", "lead_deg",
    "time_of_flight_s", "entry_angle_deg", "slowest_mps", "fastest_mps", "flattest_deg", "steepest_deg",
    "margin_sd",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ShotBand:
    """Shots that go in, from every barrel, of a grid of elevations and speeds."""

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
        most = task.max_speed * (1.0 + _SPARE_SPEED)
        reachable = middles[middles < most]
        if not len(reachable):
            return cls(elevations, np.zeros(0), np.zeros((len(elevations), 0), dtype=bool))
        least = max(_SLOWER * float(reachable.min()), task.min_speed)
        most = min(_FASTER * float(reachable.max()), most)
        speeds = least * np.exp(_SPEED_STEP * np.arange(max(1, math.ceil(math.log(most / least) / _SPEED_STEP))))
        ratio = speeds[None, :] / middles[:, None]
        row, column = np.nonzero((ratio > _SLOWER) & (ratio < _FASTER))
        inside: BoolArray = np.zeros(ratio.shape, dtype=bool)
        inside[row, column] = task.hits(stand, elevations[row], speeds[column]).all(axis=1)
        return cls(elevations, speeds, inside)


def _grid(task: ShotTask) -> FloatArray:
    """Return the elevations that are flown [rad], shape (n,)."""
    low, high = task.elevations
    spare = math.ceil(_SPARE_ELEVATION / _ELEVATION_STEP)
    count = math.floor((high - low) / _ELEVATION_STEP + 1e-9)
    grid: FloatArray = np.array(low + _ELEVATION_STEP * np.arange(-spare, count + spare + 1), dtype=np.float64)
    return grid[(grid > 0.0) & (grid < 0.5 * math.pi)]


def _to_middle(task: ShotTask, stand: Stand, elevations: FloatArray) -> FloatArray:
    """Return the speed of each elevation that meets the middle of the opening [m/s], infinite for none, shape (n,)."""
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
    """Shots that go in from there; None where the robot has no place."""
    elevation: float = math.nan
    """[rad]"""
    speed: float = math.nan
    """Relative to the muzzle [m/s]."""
    shot: Mapping[str, Any] = field(default_factory=lambda: dict.fromkeys(_COLUMNS))
    """By column, with its unit; None for what there is not. Columns that are not plain:

    - `bearings_deg`: bearings, 15 degrees or more apart, at which the robot can stand and the shot goes in as meant;
    - `lead_deg`: direction of the shot from that to the target, counter-clockwise;
    - `slowest_mps`, `fastest_mps`, `flattest_deg`, `steepest_deg`: ends of what goes in with the other one as it is;
    - `margin_sd`: to the nearest of these ends, in standard deviations of the scatter (where it has none, the default).
    """
    share: float | None = None
    """Of scattered shots that go in, from where fewest do."""
    worst_stand: Stand | None = None
    """Stand at that bearing."""
    between: float | None = None
    """Share half way to the next distance, with elevation and speed half way between; None: there is none."""
    is_gap: bool = False
    """Whether clearly fewer go in there than from both ends."""


@dataclass(frozen=True, slots=True)
class ShotTable:
    """All rows, and the task and the scatter that they are of."""

    task: ShotTask
    scatter: Scatter
    rows: tuple[ShotTableRow, ...]

    @property
    def feasible(self) -> list[ShotTableRow]:
        """Rows with a shot."""
        return [row for row in self.rows if not row.problem]


def make_table(
    task: ShotTask, distances: Iterable[float], *, radial: Iterable[float] = (0.0,),
    tangential: Iterable[float] = (0.0,), scatter: Scatter | None = None,
    on_row: Callable[[ShotTableRow], object] = lambda row: None,
) -> ShotTable:  # fmt: skip
    """Work a table out.

    Args:
        task: Which shooter, at what.
        distances: From the robot's origin to the target [m].
        radial: Speeds of the robot toward the target [m/s].
        tangential: Speeds of the robot to the left of it [m/s].
        scatter: Of the shots; None: the default one.
        on_row: Called with each row as it is done.
    """
    spread, aways = scatter or Scatter(), sorted(distances)
    rows: list[ShotTableRow] = []
    bare = replace(task.game, staging=lambda rng, entries: [], preload=0)
    with Match(bare, robots=[RobotEntry(config=task.robot, preload=0)], practice=True) as match:
        for along, across in itertools.product(radial, tangential):
            before: ShotTableRow | None = None
            for away in aways:
                row = _row(task, match, Stand(away, 0.0, along, across), spread)
                if before is not None and before.share is not None and row.share is not None:
                    assert before.worst_stand is not None
                    middle = 0.5 * (before.elevation + row.elevation), 0.5 * (before.speed + row.speed)
                    stand = before.worst_stand._replace(distance=0.5 * (before.stand.distance + row.stand.distance))
                    between = task.share(stand, *middle, _draws(spread, _BETWEEN_SHOTS))
                    is_gap = between < _KEPT * min(before.share, row.share)
                    rows[-1] = replace(before, between=between, is_gap=is_gap)
                rows.append(row)
                on_row(row)
                before = row
    return ShotTable(task, spread, tuple(sorted(rows, key=lambda row: row.stand.distance)))


def _row(task: ShotTask, match: Match, wanted: Stand, scatter: Scatter) -> ShotTableRow:
    """Return the row of a distance and velocity: its shot, or why there is none."""
    stands = _stands(task, match, wanted)
    if not stands:
        return ShotTableRow(stand=wanted, problem="the robot has no place on the field there")
    stand = _clearest(task, stands[:_MOST_PLACES])
    band = ShotBand.of(task, stand)
    usable = band.inside & task.can_tilt(band.elevations)[:, None] & (band.speeds <= task.max_speed)
    shots = [(number, _middle(usable[number])) for number in np.nonzero(usable.any(axis=1))[0].tolist()]
    if not shots:
        return ShotTableRow(stand=wanted, problem="no elevation and speed of this shooter go in", band=band)
    margins = np.array([_margin(band, *shot, scatter) for shot in shots])
    good = np.nonzero(margins >= _AS_SAFE * margins.max())[0]
    number, column = shots[int(good[len(good) // 2])]
    elevation, speed = float(band.elevations[number]), float(band.speeds[column])
    aim = np.array([elevation]), np.array([speed])
    some = [stand]
    for one in stands:
        is_apart = all(abs(wrap_angle(one.bearing - other.bearing)) > _APART for other in some)
        if is_apart and task.hits(one, *aim).all():
            some.append(one)
    draws = _draws(scatter, _SHOTS)
    share, worst = min((task.share(one, elevation, speed, draws), number) for number, one in enumerate(some))
    return ShotTableRow(
        stand=stand, band=band, elevation=elevation, speed=speed, share=share, worst_stand=some[worst],
        shot=_described(task, stand, band, number, column, [one.bearing for one in some], scatter),
    )  # fmt: skip


def _stands(task: ShotTask, match: Match, wanted: Stand) -> list[Stand]:
    """Return where the robot can stand at a distance and look at the target, the most straight on first.

    Level, on the carpet, up to 90 degrees to either side of where a shot comes straight at the opening.
    """
    found, chassis = [], match.robots[0].chassis
    for number in range(round(_FARTHEST_TURN / _TURN) + 1):
        for side in (1.0, -1.0) if number else (1.0,):
            stand = wanted._replace(bearing=task.opening.approach + side * number * _TURN)
            with contextlib.suppress(StartError):
                match.carry_to(0, (*stand.place(task.opening.middle), stand.bearing - task.shooter.launch.heading))
                if abs(chassis.pos[2]) < _LEVEL and math.hypot(*chassis.roll_pitch_yaw[:2]) < _LEVEL:
                    found.append(stand)
    return found


def _clearest(task: ShotTask, stands: Sequence[Stand]) -> Stand:
    """Return the first stand from which about as many shots at the middle go in as from the best: the way is free."""
    found, up = [], _grid(task)
    up = up[task.can_tilt(up)][::_PLACE_EVERY]
    for stand in stands:
        fast = _to_middle(task, stand, up)
        usable = fast < task.max_speed
        found.append(int(task.hits(stand, up[usable], fast[usable]).sum()))
    return next(one for one, hits in zip(stands, found, strict=True) if hits >= _AS_GOOD * max(found))


def _described(
    task: ShotTask, stand: Stand, band: ShotBand, number: int, column: int, bearings: Sequence[float], scatter: Scatter
) -> dict[str, Any]:
    """Return the columns of the shot of an elevation and a speed of a band, by number."""
    elevation, speed, deg = float(band.elevations[number]), float(band.speeds[column]), math.degrees
    aim = np.array([elevation]), np.array([speed])
    yaw, hood = task.lead(stand, *aim), task.hood_for(elevation)
    seen = task.fly(task.rows(stand, *aim, yaw))
    vx, vy, vz = seen.vel[0].tolist()
    values = (
        deg(stand.bearing), " ".join(f"{bearing:.0f}" for bearing in sorted(map(deg, bearings))), deg(elevation),
        None if hood is None else hood / math.tau, speed, task.shooter.wheel_speed_for(speed) / math.tau,
        deg(wrap_angle(float(yaw[0]) - stand.bearing)), float(seen.time[0]), deg(math.atan2(-vz, math.hypot(vx, vy))),
        *_around(band.speeds, band.inside[number], column),
        *map(deg, _around(band.elevations, band.inside[:, column], number)), _margin(band, number, column, scatter),
    )  # fmt: skip
    return dict(zip(_COLUMNS, values, strict=True))


def _margin(band: ShotBand, number: int, column: int, scatter: Scatter) -> float:
    """Return how far a shot of a band is from what does not go in, in standard deviations of the scatter."""
    slowest, fastest = np.log(_around(band.speeds, band.inside[number], column)) - math.log(band.speeds[column])
    flattest, steepest = np.array(_around(band.elevations, band.inside[:, column], number)) - band.elevations[number]
    return min(
        float(min(-slowest, fastest)) / (scatter.exit_speed or Scatter().exit_speed),
        float(min(-flattest, steepest)) / (scatter.elevation or Scatter().elevation),
    )


def _stretches(inside: BoolArray) -> list[tuple[int, int]]:
    """Return the first and last number of each unbroken stretch."""
    edges = np.nonzero(np.diff(np.pad(inside.astype(int), 1)))[0].tolist()
    return [(first, after - 1) for first, after in zip(edges[::2], edges[1::2], strict=True)]


def _middle(inside: BoolArray) -> int:
    """Return the number in the middle of the longest stretch."""
    first, last = max(_stretches(inside), key=lambda ends: ends[1] - ends[0])
    return (first + last) // 2


def _around(values: FloatArray, inside: BoolArray, here: int) -> tuple[float, float]:
    """Return the ends of the stretch around a number."""
    first, last = next(ends for ends in _stretches(inside) if ends[0] <= here <= ends[1])
    return float(values[first]), float(values[last])


def _draws(scatter: Scatter, count: int) -> ShotDraws:
    return ShotDraws.of(scatter, np.random.default_rng(0), count)
