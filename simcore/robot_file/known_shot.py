"""Exit efficiency from one known shot, and the wheel speeds that a shooter needs for a goal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from simcore.errors import ConfigError
from simcore.match.game import Game
from simcore.match.scoring import ScoringZone
from simcore.pieces.launch import muzzle_offset
from simcore.pieces.shot_solver import NoShotError, solve_shot
from simcore.quantities import COUNT, DEGREES, FIELD_LENGTH, RATE, Quantity, require
from simcore.robot.robot_config import RobotConfig, build_mechanism
from simcore.robot.shooter import ShooterConfig

__all__ = ["KnownShot", "NeededSpeed", "elevations", "exit_efficiency", "goal_of", "needed_speeds"]

DISTANCES = (2.0, 3.0, 4.0, 5.0)
"""Distances for which needed speeds are shown [m]."""
_KEYS: dict[str, Quantity] = {
    "distance": FIELD_LENGTH, "rps": RATE, "elevation_deg": DEGREES, "hood_deg": DEGREES, "shooter": COUNT
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownShot:
    """Shot from standstill that a team knows to go in."""

    distance: float
    """Distance from the robot's center to the middle of the goal, along the floor [m]."""
    rps: float
    """Setpoint of the wheels [turns/s]; for two wheels their mean."""
    elevation_deg: float | None = None
    """Elevation of the shot [deg]; None: from the hood's angle, or fixed without a hood."""
    hood_deg: float | None = None
    """Angle of the hood [deg]."""
    shooter: int = 1
    """Number of the shooter, in the order of the file."""

    @classmethod
    def parse(cls, text: str) -> KnownShot:
        """Parse a text like `distance=2.8,rps=38`.

        Raises:
            ConfigError: A key is unknown or missing, or a value is invalid.

        >>> KnownShot.parse("distance=2.8,rps=38").rps
        38.0
        >>> KnownShot.parse("distance=2.8,rpm=2280")
        Traceback (most recent call last):
        simcore.errors.ConfigError: known shot: no key 'rpm'. Known: distance, rps, elevation_deg, hood_deg, shooter
        """
        values: dict[str, Any] = {}
        for part in text.split(","):
            key, _, value = (word.strip() for word in part.partition("="))
            if key not in _KEYS:
                hint = "; decimals take a point, as in distance=2.8,rps=38" if key[:1].isdigit() else ""
                raise ConfigError(f"known shot: no key {key!r}. Known: {', '.join(_KEYS)}{hint}")
            try:
                values[key] = int(value) if _KEYS[key].is_whole else float(value)
            except ValueError:
                values[key] = value
            require("known shot", key, values[key], _KEYS[key])
        for key in ("distance", "rps"):
            if key not in values:
                raise ConfigError(f"known shot: {key} is missing, e.g. distance=2.8,rps=38")
        return cls(**values)


@dataclass(frozen=True, slots=True)
class NeededSpeed:
    """Requirements of a shot into a goal."""

    distance: float
    """Distance from the robot's center [m]."""
    elevation: float
    """Elevation of the shot [rad]."""
    speed: float
    """Speed of the piece relative to the muzzle [m/s]."""
    wheel_rps: float
    """Speed of the wheels at the exit efficiency of the shooter [turns/s]."""


def goal_of(shooter: ShooterConfig, game: Game) -> ScoringZone | None:
    """Return the first zone with an opening for what the shooter launches; None: the game has none."""
    takes = [z for z in game.zones if not z.kinds or not shooter.kinds or set(z.kinds) & set(shooter.kinds)]
    return next((zone for zone in takes if zone.opening is not None), None)


def elevations(shooter: ShooterConfig, config: RobotConfig) -> tuple[float, float]:
    """Return the lowest and highest elevation that the hood allows [rad]."""
    stops = (0.0, 0.0) if shooter.hood is None else build_mechanism(config.mechanisms[shooter.hood]).stops
    low, high = sorted(shooter.elevation + shooter.elevation_per_hood * stop for stop in stops)
    return (low, high) if math.isfinite(high - low) else (shooter.elevation, shooter.elevation)


def needed_speeds(shooter: ShooterConfig, config: RobotConfig, game: Game) -> list[NeededSpeed]:
    """Return wheel speeds for shots into the goal from `DISTANCES`, each at the elevation that needs the least."""
    low, high = elevations(shooter, config)
    steps = np.linspace(low, high, 1 if low == high else 31)
    found = []
    for distance in DISTANCES:
        speeds = [(_exit_speed(shooter, game, distance, angle), angle) for angle in steps.tolist()]
        speed, angle = min(speeds)
        if math.isfinite(speed):
            found.append(NeededSpeed(distance, angle, speed, shooter.wheel_speed_for(speed) / math.tau))
    return found


def exit_efficiency(shot: KnownShot, shooter: ShooterConfig, config: RobotConfig, game: Game) -> float:
    """Compute the exit efficiency with which a known shot goes through the middle of the goal [-].

    Raises:
        ConfigError: No speed reaches the goal, or the elevation is unknown.
    """
    if shot.elevation_deg is not None:
        elevation = math.radians(shot.elevation_deg)
    elif shot.hood_deg is not None:
        elevation = shooter.elevation + shooter.elevation_per_hood * math.radians(shot.hood_deg)
    else:
        elevation, highest = elevations(shooter, config)
        if elevation != highest:
            raise ConfigError(
                f"known shot: shooter {shot.shooter} has a hood: add elevation_deg=<of the shot> or hood_deg=<its own>"
            )
    speed = _exit_speed(shooter, game, shot.distance, elevation)
    if not math.isfinite(speed):
        raise ConfigError(
            f"known shot: nothing goes in from {shot.distance:g} m at {math.degrees(elevation):.0f} deg, at any speed"
        )
    return shooter.exit_efficiency * shooter.wheel_speed_for(speed) / (shot.rps * math.tau)


def _exit_speed(shooter: ShooterConfig, game: Game, distance: float, elevation: float) -> float:
    """Return the speed of the shot that hits the middle of the goal [m/s]; infinite if there is none."""
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
