"""Shot tables that 2026 teams measured on their robots, flown in simcore's ball loop.

A row has the distance from the turret's axis to the middle of the hub [m], the hood's angle from the vertical [deg] and
the wheel's speed; flight times run from the wheel to the hub. Two numbers of each robot are not published and are
fitted, one value each for all distances: the angle by which the shot is steeper than the hood, and the exit efficiency.
The efficiency is for a 4 in wheel; wheel sizes are not published either, and only efficiency times radius matters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from games.rebuilt import REBUILT
from simcore.pieces.flight import ShotOutcomes
from simcore.pieces.launch import LaunchParameters
from simcore.sweep.shot_task import ShotTask, Stand
from simcore.units import degrees, inches

BEARING = degrees(44.0)
"""Bearing from the right corner of the alliance zone, clear of tower and trench at all distances of the tables."""
WITHIN = 0.08
"""Tolerance of measured flight times [s]: teams count video frames, to a tenth of a second at worst."""


@dataclass(frozen=True)
class Measured:
    """Measured shot table of one robot."""

    height: float
    """Height of the muzzle [m]."""
    distances: tuple[float, ...]
    hoods_deg: tuple[float, ...]
    wheels: tuple[float, ...]
    """Wheel speeds [rad/s]."""
    flights: tuple[tuple[float, float], ...]
    """Distance [m] and time of flight [s]."""
    steeper_deg: float
    """Elevation of the shot above that of the hood [deg]; fitted."""
    efficiency: float
    """Exit efficiency [-]; fitted."""

    def task(self) -> ShotTask:
        """Return a shot task for this shooter on the REBUILT robot."""
        robot = REBUILT.robot()
        shooter = replace(
            robot.shooters[0], launch=LaunchParameters(height=self.height), wheel_radius=inches(2.0),
            exit_efficiency=self.efficiency,
        )  # fmt: skip
        return ShotTask(REBUILT, replace(robot, shooters=(shooter,)))

    def fly(self, task: ShotTask, distance: float, *, turns: float = 0.0) -> ShotOutcomes:
        """Fly a shot of the table, with the wheel faster by `turns` [turns/s]."""
        hood = np.interp(distance, self.distances, self.hoods_deg)
        wheel = np.interp(distance, self.distances, self.wheels) + math.tau * turns
        elevation = np.array([degrees(90.0 - hood + self.steeper_deg)])
        speed = np.array([task.shooter.exit_speed([wheel])])
        stand = Stand(distance, BEARING)
        return task.fly(task.rows(stand, elevation, speed))


# Mechanical-Advantage/RobotCode2026Public at 0a8f5f5a, subsystems/shooter: ShotCalculator.java, ShooterConstants.java
ROBOT_A = Measured(
    height=0.44,
    distances=(1.17, 1.55, 1.96, 2.14, 2.40, 2.78, 3.10, 3.44, 3.84, 4.60, 5.12, 5.63),
    hoods_deg=(19.0, 19.0, 19.0, 20.0, 21.0, 22.0, 24.0, 26.0, 27.0, 32.0, 33.0, 36.0),
    wheels=(185.0, 205.0, 225.0, 225.0, 225.0, 230.0, 235.0, 238.0, 245.0, 252.0, 265.0, 270.0),
    flights=((1.38, 0.90), (1.88, 1.09), (3.15, 1.11), (4.55, 1.12), (5.68, 1.16)),
    steeper_deg=4.25,
    efficiency=0.642,
)
# benjaminlinn1212/2026Main-WithSim at 1bdd4829: util/ShooterSetpoint.java, and Constants.java for the height
_C_DISTANCES = (1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 4.83)
_C_TIMES = (1.00, 1.02, 1.08, 1.13, 1.13, 1.18, 1.34, 1.34, 1.29, 1.33)
ROBOT_C = Measured(
    height=0.3887 + 0.065,
    distances=_C_DISTANCES,
    hoods_deg=(21.0, 21.0, 22.0, 23.0, 25.0, 29.0, 29.0, 30.0, 34.0, 37.0),
    wheels=tuple(math.tau * turns for turns in (45.0, 50.0, 50.0, 50.0, 55.0, 55.0, 60.0, 65.0, 65.0, 65.0)),
    flights=tuple(zip(_C_DISTANCES, _C_TIMES, strict=True)),
    steeper_deg=8.5,
    efficiency=0.4325,
)
ROBOTS = {"A": ROBOT_A, "C": ROBOT_C}


@pytest.mark.parametrize("name", ROBOTS)
def test_every_shot_in_a_measured_table_scores_with_a_single_exit_efficiency(name: str):
    """Shots from 1.2 m to 5.6 m touch neither rim nor net."""
    robot = ROBOTS[name]
    task = robot.task()
    for distance in robot.distances:
        shot = robot.fly(task, distance)
        assert shot.goes_in[0] and not shot.by_rim[0] and not shot.by_board[0], f"{name}, {distance} m"


def lateness(robot: Measured, *, turns: float = 0.0) -> np.ndarray:
    """Return how much longer simulated flights take than measured [s], with wheels faster by `turns` [turns/s]."""
    task = robot.task()
    return np.array([float(robot.fly(task, at, turns=turns).time[0]) - measured for at, measured in robot.flights])


@pytest.mark.parametrize(("name", "step"), [("A", 0.0), ("C", 5.0)])
def test_simulated_flight_times_match_measurements(name: str, step: float):
    """The RMS error is below 80 ms, and each row is within the step [turns/s] to which its wheel speed is given.

    C's wheel speed is given in steps of 5 turns/s, a tenth of the speed; as given, three of its rows are 82 to 107 ms
    off.
    """
    slow, mean, fast = (lateness(ROBOTS[name], turns=turns) for turns in (-step / 2.0, 0.0, step / 2.0))
    assert math.sqrt(np.mean(mean**2)) < WITHIN, mean
    nearest = np.nanmin(np.abs([slow, mean, fast]), axis=0)
    assert (nearest < WITHIN).all(), nearest


def test_the_docs_page_states_the_fitted_values():
    page = " ".join((Path(__file__).parents[2] / "docs" / "real_robots.md").read_text(encoding="utf-8").split())
    for robot in (ROBOT_A, ROBOT_C):
        assert f"{1e3 * math.sqrt(np.mean(lateness(robot) ** 2)):.0f} ms rms" in page
    assert f"{ROBOT_A.steeper_deg:g} and {ROBOT_C.steeper_deg:g} degrees, and `exit_efficiency`" in page
