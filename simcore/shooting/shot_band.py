"""Which elevations and speeds go in from a place, and how wide their margins are on all sides."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt

from simcore.match.scatter import Scatter
from simcore.pieces.shot_solver import NoShotError, solve_shot
from simcore.shooting.shot_task import ShotTask, Stand
from simcore.typing import BoolArray, FloatArray
from simcore.units import degrees

__all__ = ["ENOUGH", "BestShot", "ShotBand", "smoothest"]

_ELEVATION_STEP = degrees(0.5)
_SPEED_STEP = 0.0075  # of the speed
_SPARE_ELEVATION, _SPARE_SPEED = degrees(3.0), 0.05  # beyond the shooter's limits: scatter does not stop there
_SLOWER, _FASTER = 0.8, 1.5  # times the speed that meets the middle: from the rim in front to the top of a board
ENOUGH = 6.0
"""Margin beyond which more is worth nothing, in standard deviations: one shot in 10^9 is farther off."""
_LITTLE = 0.01  # what more than enough is worth
_DEAR = degrees(20.0)
_FINE_SPEED, _FINE_ELEVATION = 0.001, degrees(0.05)


@dataclass(frozen=True, slots=True)
class BestShot:
    """The shot with the widest margin from a place."""

    elevation: float
    """[rad]"""
    speed: float
    """Relative to the muzzle [m/s]."""
    margin: float
    """To the nearest elevation and speed that do not go in, in standard deviations of the scatter [-]."""


def smoothest(rows: Sequence[FloatArray]) -> list[int]:
    """Of each of several bands, one after the other in distance, the row of the grid to shoot at.

    A margin is worth what it is up to 6 standard deviations, more is worth nothing; a change of 20 deg from one band to
    the next costs 1. So the table can be interpolated, and gives up margin only where there is plenty.

    Args:
        rows: Widest margin of each elevation of the grid, of each band, shape (n,).

    Returns:
        A row for each; what is best overall (Viterbi's algorithm).
    """
    count = len(rows[0])
    steps = (_ELEVATION_STEP / _DEAR) * np.arange(count)
    cost = np.square(steps[:, None] - steps[None, :])
    best, came_from = _worth(rows[0]), []
    for margins in rows[1:]:
        reached = best[:, None] - cost
        came_from.append(np.argmax(reached, axis=0))
        best = reached.max(axis=0) + _worth(margins)
    chosen = [int(np.argmax(best))]
    for origins in reversed(came_from):
        chosen.append(int(origins[chosen[-1]]))
    return chosen[::-1]


def _worth(margins: FloatArray) -> FloatArray:
    """Minus infinity for what does not go in."""
    with np.errstate(divide="ignore"):
        worth: FloatArray = np.where(margins > 0.0, np.minimum(margins, ENOUGH) + _LITTLE * margins, -np.inf)
    return worth


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
        low, high = task.elevations
        spare = math.ceil(_SPARE_ELEVATION / _ELEVATION_STEP)
        count = math.floor((high - low) / _ELEVATION_STEP + 1e-9)
        grid = low + _ELEVATION_STEP * np.arange(-spare, count + spare + 1)
        elevations: FloatArray = np.array(grid[(grid > 0.0) & (grid < 0.5 * math.pi)], dtype=np.float64)
        middles = np.array([_speed_to_middle(task, stand, elevation) for elevation in elevations.tolist()])
        reachable = middles[middles < task.max_speed * (1.0 + _SPARE_SPEED)]
        if not len(reachable):
            return cls(task, stand, elevations, np.zeros(0), np.zeros((len(elevations), 0), dtype=bool))
        least = max(_SLOWER * float(reachable.min()), task.min_speed)
        most = min(_FASTER * float(reachable.max()), task.max_speed * (1.0 + _SPARE_SPEED))
        count = max(1, math.ceil(math.log(most / least) / _SPEED_STEP))
        speeds: FloatArray = least * np.exp(_SPEED_STEP * np.arange(count))
        ratio = speeds[None, :] / middles[:, None]
        row, column = np.nonzero((ratio > _SLOWER) & (ratio < _FASTER))
        inside: BoolArray = np.zeros(ratio.shape, dtype=bool)
        inside[row, column] = task.outcomes(stand, elevations[row], speeds[column])
        return cls(task, stand, elevations, speeds, inside)

    def widest(self, scatter: Scatter) -> dict[int, BestShot]:
        """The shot with the widest margin of each elevation that has one within the shooter's limits, by its row.

        Args:
            scatter: Measures the margins; where it has no exit speed or elevation, the default ones do.
        """
        usual = Scatter()
        sizes = (
            _ELEVATION_STEP / (scatter.elevation or usual.elevation),
            _SPEED_STEP / (scatter.exit_speed or usual.exit_speed),
        )
        margins: FloatArray = distance_transform_edt(np.pad(self.inside, 1), sampling=sizes)[1:-1, 1:-1]
        low, high = self.task.elevations
        margins[(self.elevations < low - 1e-9) | (self.elevations > high + 1e-9)] = 0.0
        margins[:, self.speeds > self.task.max_speed] = 0.0
        found = {}
        for row in np.nonzero(margins.any(axis=1))[0].tolist():
            column = int(np.argmax(margins[row]))
            found[row] = BestShot(float(self.elevations[row]), float(self.speeds[column]), float(margins[row, column]))
        return found

    def speed_limits(self, shot: BestShot) -> tuple[float, float]:
        """Slowest and fastest shot at the same elevation that goes in [m/s]."""
        speeds = shot.speed * np.exp(np.arange(math.log(_SLOWER), math.log(_FASTER), _FINE_SPEED))
        inside = self.task.outcomes(self.stand, np.full(len(speeds), shot.elevation), speeds)
        return _around(speeds, inside, shot.speed)

    def elevation_limits(self, shot: BestShot) -> tuple[float, float]:
        """Flattest and steepest shot at the same speed that goes in [rad]."""
        elevations: FloatArray = np.arange(_FINE_ELEVATION, 0.5 * math.pi, _FINE_ELEVATION)
        near = np.abs(elevations - shot.elevation) < degrees(25.0)
        elevations = elevations[near]
        inside = self.task.outcomes(self.stand, elevations, np.full(len(elevations), shot.speed))
        return _around(elevations, inside, shot.elevation)


def _around(values: FloatArray, inside: BoolArray, middle: float) -> tuple[float, float]:
    """Ends of the unbroken stretch around a value."""
    here = int(np.argmin(np.abs(values - middle)))
    if not inside[here]:
        return middle, middle
    out = np.nonzero(~inside)[0]
    first = int(out[out < here].max(initial=-1)) + 1
    last = int(out[out > here].min(initial=len(values))) - 1
    return float(values[first]), float(values[last])


def _speed_to_middle(task: ShotTask, stand: Stand, elevation: float) -> float:
    """Speed of the shot of an elevation that meets the middle of the opening [m/s]; infinite where none does."""
    try:
        shot = solve_shot(
            task.muzzle(stand, np.array([stand.bearing]))[0],
            task.opening.middle,
            elevation=elevation,
            drag=task.kind.air.drag,
            robot_velocity=stand.velocity,
        )
    except NoShotError:
        return math.inf
    return shot.speed
