"""Shot table: the shot with the best margin at each distance, and the fraction of scattered shots that go in.

`make_table` simulates a grid of elevations and speeds around the solutions of `solve_shot`. For each elevation, the
candidate has the middle speed of the range that goes in. The margin of a candidate is the smallest error of speed or
elevation for which the shot misses, in standard deviations of the scatter. The row has the candidate with the best
margin. Simulated shots with scatter around this candidate give the fraction that goes in.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.scatter import Scatter
from simcore.match.starts import StartError
from simcore.pieces.shot_solver import NoShotError, solve_shot
from simcore.sweep.shot_task import ShotDraws, ShotTask, Stand
from simcore.typing import BoolArray, FloatArray
from simcore.units import degrees

__all__ = ["ShotBand", "ShotTable", "ShotTableRow", "make_table"]

_ELEVATION_STEP, _SPEED_STEP = degrees(0.5), 0.0075  # steps of the grid; the speed step is relative to the speed
_SPARE_ELEVATION, _SPARE_SPEED = degrees(15.0), 0.05  # margin beyond the shooter's limits, to find the ends of ranges
_SLOWER, _FASTER = 0.8, 1.3  # factors on the speed that hits the middle; shots at both ends miss the opening
_SHOTS = 1024  # number of scattered shots per row
_AS_SAFE = 0.97  # fraction of the best margin from which shots are equally good; the row has the middle one
_TURN, _FARTHEST_TURN = degrees(5.0), degrees(90.0)  # step between bearings, and largest angle from the approach
_LEVEL = 0.005  # [m] and [rad], tolerance: a robot on a bump shoots differently
_MOST_PLACES = 6  # largest number of robot positions tried for a row
_COLUMNS = (
    "bearing_deg", "elevation_deg", "hood_turns", "speed_mps", "wheel_rps", "time_of_flight_s", "entry_angle_deg",
    "slowest_mps", "fastest_mps", "flattest_deg", "steepest_deg", "margin_sd",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ShotBand:
    """Grid of elevations and speeds, and the result of each shot."""

    elevations: FloatArray
    """Elevations of the grid [rad], shape (n,)."""
    speeds: FloatArray
    """Speeds of the grid relative to the muzzle, in geometric steps [m/s], shape (m,)."""
    inside: BoolArray
    """Whether the shot at each elevation and speed goes in from every barrel, shape (n, m)."""

    @classmethod
    def of(cls, task: ShotTask, stand: Stand) -> ShotBand:
        """Simulate a grid of shots around the shots that hit the middle of the opening, and return the grid.

        Shots with less than 0.8 times or more than 1.3 times the speed that hits the middle are not simulated and count
        as misses.
        """
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
    """Return the elevations of the grid [rad], shape (n,): the shooter's range and a margin at both ends.

    All elevations are above 0 and below pi / 2.
    """
    low, high = task.elevations
    spare = math.ceil(_SPARE_ELEVATION / _ELEVATION_STEP)
    count = math.floor((high - low) / _ELEVATION_STEP + 1e-9)
    grid: FloatArray = np.array(low + _ELEVATION_STEP * np.arange(-spare, count + spare + 1), dtype=np.float64)
    return grid[(grid > 0.0) & (grid < 0.5 * math.pi)]


def _to_middle(task: ShotTask, stand: Stand, elevations: FloatArray) -> FloatArray:
    """Return the speed that hits the middle of the opening at each elevation [m/s], shape (n,).

    The speed is infinite for an elevation at which no shot hits the middle.
    """
    speeds, muzzle = np.full(len(elevations), np.inf), task.muzzle(stand, stand.bearing)
    for number, elevation in enumerate(elevations.tolist()):
        with contextlib.suppress(NoShotError):
            speeds[number] = solve_shot(
                muzzle, task.opening.middle, elevation=elevation, drag=task.kind.air.drag,
                rising=not task.zone.downward,
            ).speed  # fmt: skip
    return speeds


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotTableRow:
    """Row of a shot table: the best shot from a distance, or the reason why there is no shot."""

    stand: Stand
    """Distance and bearing of the robot relative to the target. The bearing is valid only if the row has a shot."""
    problem: str = ""
    """Reason why the row has no shot; empty for a row with a shot."""
    band: ShotBand | None = None
    """Grid of shots from the last position tried; None if the robot has no position on the field at the distance."""
    elevation: float = math.nan
    """Elevation of the shot [rad]; NaN without a shot."""
    speed: float = math.nan
    """Speed of the shot relative to the muzzle [m/s]; NaN without a shot."""
    shot: Mapping[str, Any] = field(default_factory=lambda: dict.fromkeys(_COLUMNS))
    """Values of the shot by column name; None for missing values. Column names end in the unit.

    - `slowest_mps`, `fastest_mps`: ends of the range of speeds that go in at the elevation of the shot;
    - `flattest_deg`, `steepest_deg`: ends of the range of elevations that go in at the speed of the shot;
    - `margin_sd`: distance to the nearest of these ends, in standard deviations of the scatter. The default scatter
      replaces a spread of 0.
    """
    share: float | None = None
    """Fraction of scattered shots that go in [-]; None without a shot."""


@dataclass(frozen=True, slots=True)
class ShotTable:
    """Shot table of a shooter and a target, computed for a scatter."""

    task: ShotTask
    scatter: Scatter
    rows: tuple[ShotTableRow, ...]

    @property
    def feasible(self) -> list[ShotTableRow]:
        """Rows with a shot."""
        return [row for row in self.rows if not row.problem]


def make_table(
    task: ShotTask, distances: Iterable[float], *, scatter: Scatter | None = None,
    on_row: Callable[[ShotTableRow], object] = lambda row: None,
) -> ShotTable:  # fmt: skip
    """Compute a shot table with one row per distance, in ascending order.

    Args:
        task: Shooter and target.
        distances: Horizontal distances from the robot's origin to the middle of the target's opening [m].
        scatter: Scatter of the shots; None for the default scatter.
        on_row: Function that is called with each finished row.
    """
    spread = scatter or Scatter()
    rows: list[ShotTableRow] = []
    bare = replace(task.game, staging=lambda rng, entries: [], preload=0)
    with Match(bare, robots=[RobotEntry(config=task.robot, preload=0)], practice=True) as match:
        for distance in sorted(distances):
            rows.append(_row(task, match, distance, spread))
            on_row(rows[-1])
    return ShotTable(task, spread, tuple(rows))


def _row(task: ShotTask, match: Match, distance: float, scatter: Scatter) -> ShotTableRow:
    """Return the row for a distance: the best shot from the first usable position, or the reason for no shot."""
    problem, band = "the robot does not fit on the field there", None
    for stand in itertools.islice(_stands(task, match, distance), _MOST_PLACES):
        band = ShotBand.of(task, stand)
        usable = band.inside & task.can_tilt(band.elevations)[:, None] & (band.speeds <= task.max_speed)
        shots = [(number, _middle(usable[number])) for number in np.nonzero(usable.any(axis=1))[0].tolist()]
        if shots:
            return _best(task, stand, band, shots, scatter)
        problem = "no elevation and speed of this shooter go in"
    return ShotTableRow(stand=Stand(distance, 0.0), problem=problem, band=band)


def _best(
    task: ShotTask, stand: Stand, band: ShotBand, shots: Sequence[tuple[int, int]], scatter: Scatter
) -> ShotTableRow:
    """Return the row with the best shot among candidates (elevation index, speed index).

    The best shot has the middle elevation of the shots whose margins are within 3 % of the best margin.
    """
    margins = np.array([_margin(band, *shot, scatter) for shot in shots])
    good = np.nonzero(margins >= _AS_SAFE * margins.max())[0]
    number, column = shots[int(good[len(good) // 2])]
    elevation, speed = float(band.elevations[number]), float(band.speeds[column])
    draws = ShotDraws.of(scatter, np.random.default_rng(0), _SHOTS)
    return ShotTableRow(
        stand=stand, band=band, elevation=elevation, speed=speed, share=task.share(stand, elevation, speed, draws),
        shot=_described(task, stand, band, number, column, scatter),
    )  # fmt: skip


def _stands(task: ShotTask, match: Match, distance: float) -> Iterator[Stand]:
    """Yield positions at a distance where the robot fits on the field, the position in front of the opening first.

    At each position, the robot is level on the carpet and the shooter points at the target. The bearing to the target
    is within 90 degrees of the opening's approach direction. The function moves the robot of `match`.
    """
    chassis = match.robots[0].chassis
    for number in range(round(_FARTHEST_TURN / _TURN) + 1):
        for side in (1.0, -1.0) if number else (1.0,):
            stand = Stand(distance, task.opening.approach + side * number * _TURN)
            with contextlib.suppress(StartError):
                match.carry_to(0, (*stand.place(task.opening.middle), stand.bearing - task.shooter.launch.heading))
                if abs(chassis.pos[2]) < _LEVEL and math.hypot(*chassis.roll_pitch_yaw[:2]) < _LEVEL:
                    yield stand


def _described(
    task: ShotTask, stand: Stand, band: ShotBand, number: int, column: int, scatter: Scatter
) -> dict[str, Any]:
    """Return the values of `_COLUMNS` for the shot at an elevation index `number` and a speed index `column`."""
    elevation, speed, deg = float(band.elevations[number]), float(band.speeds[column]), math.degrees
    hood = task.hood_for(elevation)
    seen = task.fly(task.rows(stand, np.array([elevation]), np.array([speed])))
    vx, vy, vz = seen.vel[0].tolist()
    values = (
        deg(stand.bearing), deg(elevation), None if hood is None else hood / math.tau, speed,
        task.shooter.wheel_speed_for(speed) / math.tau, float(seen.time[0]), deg(math.atan2(-vz, math.hypot(vx, vy))),
        *_around(band.speeds, band.inside[number], column),
        *map(deg, _around(band.elevations, band.inside[:, column], number)), _margin(band, number, column, scatter),
    )  # fmt: skip
    return dict(zip(_COLUMNS, values, strict=True))


def _margin(band: ShotBand, number: int, column: int, scatter: Scatter) -> float:
    """Return the margin of a shot: the distance to the nearest end of the speeds and elevations that go in.

    The unit is the standard deviation of the scatter, or of the default scatter if the spread is 0.
    """
    slowest, fastest = np.log(_around(band.speeds, band.inside[number], column)) - math.log(band.speeds[column])
    flattest, steepest = np.array(_around(band.elevations, band.inside[:, column], number)) - band.elevations[number]
    return min(
        float(min(-slowest, fastest)) / (scatter.exit_speed or Scatter().exit_speed),
        float(min(-flattest, steepest)) / (scatter.elevation or Scatter().elevation),
    )


def _stretches(inside: BoolArray) -> list[tuple[int, int]]:
    """Return the first and last index of each range of consecutive true values."""
    edges = np.nonzero(np.diff(np.pad(inside.astype(int), 1)))[0].tolist()
    return [(first, after - 1) for first, after in zip(edges[::2], edges[1::2], strict=True)]


def _middle(inside: BoolArray) -> int:
    """Return the middle index of the longest range of consecutive true values."""
    first, last = max(_stretches(inside), key=lambda ends: ends[1] - ends[0])
    return (first + last) // 2


def _around(values: FloatArray, inside: BoolArray, here: int) -> tuple[float, float]:
    """Return the values at both ends of the range of true entries of `inside` that contains the index `here`."""
    first, last = next(ends for ends in _stretches(inside) if ends[0] <= here <= ends[1])
    return float(values[first]), float(values[last])
