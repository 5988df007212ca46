"""Whether shot tables hold where a robot stands: real shots by distance, bearing and motion, against stated intervals.

Each cell shoots scattered shots in a match, from where the robot comes by at the row's velocity, at a bearing. Speed,
elevation and direction are scattered, as in the table; pieces are as the game has them. Bearings at which the robot has
no place, or something is in the way, are left out.

    python scripts/shot_cells.py --shots 200
"""

from __future__ import annotations

import argparse
import math
import sys
from typing import NamedTuple

import numpy as np

from games.rebuilt import REBUILT
from simcore.match.scatter import Scatter
from simcore.shooting.practice_field import PracticeField
from simcore.shooting.shot_table import make_table, stated_interval
from simcore.shooting.shot_task import SPREADS, ShotDraws, ShotTask, Stand
from simcore.sweep.sweep_statistics import Share

SCATTER = Scatter.parse("1,spin=0,piece_mass=0,piece_diameter=0,drag=0")
MOTIONS = ((0.0, 0.0), (0.8, 0.8))  # radial, tangential [m/s]


class Cell(NamedTuple):
    """One distance, bearing and motion."""

    stand: Stand
    stated: Share
    """Of flights."""
    least: int
    most: int
    """Of the interval for the real shots."""
    scored: int
    shots: int

    @property
    def holds(self) -> bool:
        """Whether as many scored as was stated."""
        return self.least <= self.scored <= self.most

    def __str__(self) -> str:
        s = self.stand
        return (
            f"{s.distance:g} m, {math.degrees(s.bearing):+.0f} deg, {s.radial:g} / {s.tangential:g} m/s: "
            f"stated {self.stated.value:.1%} ({self.least} to {self.most} of {self.shots}), scored {self.scored}: "
            f"{'holds' if self.holds else 'does NOT hold'}"
        )


def cells(
    distances: tuple[float, ...], shots: int, *, bearings: int = 5, motions: tuple[tuple[float, float], ...] = MOTIONS,
    engine: str | None = None, seed: int = 1,
) -> list[Cell]:  # fmt: skip
    """All cells in which the table has a shot."""
    task, found = ShotTask(REBUILT), []
    for radial, tangential in motions:
        table = make_table(task, distances, radial=[radial], tangential=[tangential], scatter=SCATTER, engine=engine)
        for row in table.feasible:
            by_side = sorted(row.bearings)
            picked = np.unique(np.linspace(0, len(by_side) - 1, bearings).round().astype(int))
            for bearing, share in (by_side[number] for number in picked):
                stand = row.stand._replace(bearing=bearing)
                rng = np.random.default_rng((seed, len(found)))
                draws = ShotDraws.of(SCATTER, rng.uniform(size=(shots, SPREADS)))
                scored = left = 0
                for barrel in range(len(task.barrels)):
                    with PracticeField(task, barrel=barrel, seed=seed, engine=engine) as field:
                        for one in range(barrel, shots, len(task.barrels)):
                            shot = field.shoot(
                                stand,
                                row.elevation + float(draws.elevation[one]),
                                row.speed * float(draws.exit_speed[one]),
                                turn=float(draws.azimuth[one]),
                            )
                            if shot is not None:
                                left, scored = left + 1, scored + shot
                found.append(Cell(stand, share, *stated_interval(share, left), scored, left))
                print(found[-1], flush=True)
    return found


def main() -> int:
    """Print each cell; 0 if 19 of 20 hold."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shots", type=int, default=200, metavar="N", help="of each cell (default: 200)")
    parser.add_argument("--engine", choices=("bullet", "mujoco"), help="physics engine (default: the usual one)")
    options = parser.parse_args()
    found = cells((2.0, 3.0, 4.0, 5.0, 6.0), options.shots, engine=options.engine)
    good = sum(cell.holds for cell in found)
    print(f"{good} of {len(found)} cells hold")
    return 0 if 20 * good >= 19 * len(found) else 1


if __name__ == "__main__":
    sys.exit(main())
