"""Wheel speeds that a shooter needs to reach a goal."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.match.game import Game
from simcore.match.scoring import ScoringZone
from simcore.pieces.launch import muzzle_offset
from simcore.pieces.shot_solver import NoShotError, solve_shot
from simcore.robot.robot_config import RobotConfig, build_mechanism
from simcore.robot.shooter import ShooterConfig

__all__ = ["NeededSpeed", "elevations", "goal_of", "needed_speeds"]

DISTANCES = (2.0, 3.0, 4.0, 5.0)
"""Distances for which `simcore check` shows the needed speeds [m]."""


@dataclass(frozen=True, slots=True)
class NeededSpeed:
    """Speeds of piece and wheels for a shot into the goal from one distance."""

    distance: float
    """Distance from the robot's center to the goal [m]."""
    elevation: float
    """Elevation of the shot [rad]."""
    speed: float
    """Speed of the piece relative to the muzzle [m/s]."""
    wheel_rps: float
    """Wheel speed that gives the piece `speed`, at the exit efficiency of the shooter [turns/s]."""


def goal_of(shooter: ShooterConfig, game: Game) -> ScoringZone | None:
    """Return the first zone that has an opening and accepts the shooter's pieces; None without such a zone."""
    takes = [z for z in game.zones if not z.kinds or not shooter.kinds or set(z.kinds) & set(shooter.kinds)]
    return next((zone for zone in takes if zone.opening is not None), None)


def elevations(shooter: ShooterConfig, config: RobotConfig) -> tuple[float, float]:
    """Return the lowest and highest elevation of a shooter [rad]; equal for a hood without stops, or no hood."""
    stops = (0.0, 0.0) if shooter.hood is None else build_mechanism(config.mechanisms[shooter.hood]).stops
    low, high = sorted(shooter.elevation + shooter.elevation_per_hood * stop for stop in stops)
    return (low, high) if math.isfinite(high - low) else (shooter.elevation, shooter.elevation)


def needed_speeds(shooter: ShooterConfig, config: RobotConfig, game: Game) -> list[NeededSpeed]:
    """Return the needed speeds for `DISTANCES`, each at the elevation that needs the lowest exit speed.

    Distances from which no shot reaches the goal are left out.
    """
    low, high = elevations(shooter, config)
    steps = np.linspace(low, high, 1 if low == high else 31)
    found = []
    for distance in DISTANCES:
        speeds = [(_exit_speed(shooter, game, distance, angle), angle) for angle in steps.tolist()]
        speed, angle = min(speeds)
        if math.isfinite(speed):
            found.append(NeededSpeed(distance, angle, speed, shooter.wheel_speed_for(speed) / math.tau))
    return found


def _exit_speed(shooter: ShooterConfig, game: Game, distance: float, elevation: float) -> float:
    """Return the exit speed of a shot from rest into the middle of the goal [m/s]; infinite without such a shot."""
    if not abs(elevation) < 0.5 * math.pi:
        return math.inf
    goal = goal_of(shooter, game)
    kind = next(s.kind for s in game.pieces if not shooter.kinds or s.kind.name in shooter.kinds)
    assert goal is not None and goal.opening is not None
    launch = shooter.launch
    muzzle = muzzle_offset(launch)
    ahead = float(muzzle[0] * math.cos(launch.heading) + muzzle[1] * math.sin(launch.heading))
    try:
        shot = solve_shot(
            (ahead, 0.0, float(muzzle[2])),
            (distance, 0.0, float(goal.opening.middle[2])),
            elevation=elevation,
            drag=float(kind.air.drag),
        )
    except NoShotError:
        return math.inf
    return shot.speed
