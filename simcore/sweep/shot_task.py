"""Simulation of shots of a robot's shooter at the opening of a scoring zone, many shots in one call.

The launch model is that of `simcore.robot.shooter`. The robot is at rest and level. The turret, if the robot has one,
is at angle zero.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.loop.state import Balls
from simcore.match.game import Game
from simcore.match.scatter import Scatter
from simcore.match.scoring import Alliance, ScoringZone
from simcore.pieces.flight import ShotOutcomes, fly_shots, flying_balls
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.launch import Aim, muzzle_offset, to_field
from simcore.robot.robot_config import RobotConfig, build_mechanism
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import degrees
from simcore.world.ball_dynamics import StandingField
from simcore.world.contact_law import CARPET
from simcore.world.shapes import Sphere

__all__ = ["ShotDraws", "ShotTask", "Stand"]

_VOLTS = 12.0  # [V]; voltage of a charged battery
_SPEED_RESERVE = 0.9  # fraction of the wheels' free speed; the rest is for control and battery sag; estimate
_FLATTEST, _STEEPEST = degrees(5.0), degrees(87.0)
_CORRECTIONS = 4  # iterations of the yaw, because the muzzle position depends on the yaw


class Stand(NamedTuple):
    """Position of a robot relative to the target at the time of a shot."""

    distance: float
    """Distance from the robot's origin to the middle of the opening, along the floor [m]."""
    bearing: float
    """Bearing from the robot to the target, field frame [rad]."""

    def place(self, middle: FloatArray) -> tuple[float, float]:
        """Return x and y of the robot's origin, field frame [m], for a target opening with the middle at `middle`."""
        x, y, _ = middle.tolist()
        return x - self.distance * math.cos(self.bearing), y - self.distance * math.sin(self.bearing)


class ShotDraws(NamedTuple):
    """Random errors of n shots, with arrays of shape (n,).

    The errors of elevation and azimuth are added to the angles [rad]. All other errors are factors [-].
    """

    exit_speed: FloatArray
    elevation: FloatArray
    azimuth: FloatArray
    """Azimuth error, counter-clockwise [rad]."""
    spin: FloatArray
    mass: FloatArray
    diameter: FloatArray
    drag: FloatArray
    """Factor on the drag coefficient [-]."""

    @staticmethod
    def of(scatter: Scatter, rng: np.random.Generator, n: int) -> ShotDraws:
        """Draw the errors of n shots from a scatter."""
        normal, even = rng.standard_normal((5, n)), rng.uniform(-1.0, 1.0, (2, n))
        return ShotDraws(
            exit_speed=np.exp(scatter.exit_speed * normal[0]),
            elevation=scatter.elevation * normal[1],
            azimuth=scatter.azimuth * normal[2],
            spin=np.exp(scatter.spin * normal[3]),
            mass=1.0 + scatter.piece_mass * even[0],
            diameter=1.0 + scatter.piece_diameter * even[1],
            drag=np.exp(scatter.drag * normal[4]),
        )

    @staticmethod
    def none(n: int) -> ShotDraws:
        """Return draws for n shots without errors: factors of 1 and angle errors of 0."""
        return ShotDraws.of(Scatter.none(), np.random.default_rng(0), n)


class ShotTask:
    """Shooter and target of simulated shots.

    The arguments `elevation` [rad] and `speed` relative to the muzzle [m/s], both of shape (n,), describe the intended
    shots. The argument `stand` is the position of the robot.

    Args:
        game: Game that provides the field and the pieces.
        robot: Config of a robot with a shooter; None for the game's robot.
        target: Name of the target zone; None for the first zone with an opening, of the alliance if possible.
        alliance: Alliance of the target zone if `target` is None.
        shooter: Number of the shooter, from 0.

    Raises:
        ConfigError: If the robot has no shooter with this number, a wheel of the shooter has no motor, the piece is not
            a ball, the hood has no stops or no usable elevation, or the game has no zone with an opening for the piece.
        UnknownNameError: If the target does not exist.
    """

    def __init__(
        self, game: Game, robot: RobotConfig | None = None, *, target: str | None = None, alliance: Alliance = "blue",
        shooter: int = 0,
    ) -> None:  # fmt: skip
        self.game = game
        self.robot = robot or game.robot()
        shooters = self.robot.shooters
        if not shooters:
            raise ConfigError(
                f"the robot has no shooter, for {game.name}: give one that has, e.g. --robot simcore.toml"
            )
        if not 0 <= shooter < len(shooters):
            known = ", ".join(map(str, range(len(shooters))))
            raise ConfigError(f"no shooter number {shooter}, counted from 0. Known: {known}")
        self.shooter = shooters[shooter]
        self.barrels = self.shooter.launch.barrels
        """Sideways offset of each barrel, left positive [m]."""
        self.zone = self._zone(target, alliance)
        opening = self.zone.opening
        assert opening is not None
        self.opening = opening
        self.kind = self._kind()
        self.max_speed = self._max_speed()
        """Speed of the fastest shot relative to the muzzle [m/s], at 90 % of the wheels' free speed at 12 V."""
        self.min_speed = self.shooter.exit_speed([self.shooter.min_wheel_speed] * len(self.shooter.wheels))
        """Speed of the slowest shot relative to the muzzle [m/s]."""
        self.elevations = self._elevations()
        """Lowest and highest elevation of a shot [rad]; equal without a hood."""

    # --- parts of the task ------------------------------------------------------------------------------------------

    def _zone(self, name: str | None, alliance: Alliance) -> ScoringZone:
        targets = {zone.name: zone for zone in self.game.zones if zone.opening is not None}
        if not targets:
            raise ConfigError(
                f"game {self.game.name} has no target for shots: a scoring zone needs an `opening` (docs/new_game.md)"
            )
        if name is None:
            name = next((zone.name for zone in targets.values() if zone.alliance == alliance), next(iter(targets)))
        if name not in targets:
            raise UnknownNameError("target", name, targets)
        return targets[name]

    def _kind(self) -> GamePieceConfig:
        thrown = [one.kind for one in self.game.pieces if one.kind.name in (self.shooter.kinds or (one.kind.name,))]
        fitting = [kind for kind in thrown if not self.zone.kinds or kind.name in self.zone.kinds]
        if not fitting:
            names = ", ".join(kind.name for kind in thrown) or "nothing of this game"
            raise ConfigError(f"{self.zone.name} takes {', '.join(self.zone.kinds)}, and the shooter throws {names}")
        if not isinstance(fitting[0].shape, Sphere):
            raise ConfigError(f"shooter tables are for balls, got {fitting[0].name}, which is not a ball")
        return fitting[0]

    def _max_speed(self) -> float:
        speeds = []
        for name in self.shooter.wheels:
            gearbox = getattr(self.robot.mechanisms[name], "gearbox", None)
            if gearbox is None:
                raise ConfigError(f"the shooter's wheel {name!r} must have a motor")
            speeds.append(gearbox.free_speed(_VOLTS))
        return self.shooter.exit_speed([_SPEED_RESERVE * min(speeds)] * len(speeds))

    def _elevations(self) -> tuple[float, float]:
        shooter = self.shooter
        if shooter.hood is None:
            return shooter.elevation, shooter.elevation
        hood = build_mechanism(self.robot.mechanisms[shooter.hood])
        ends = sorted(shooter.elevation + shooter.elevation_per_hood * stop for stop in hood.stops)
        if not all(map(math.isfinite, ends)):
            raise ConfigError(f"hood {shooter.hood!r} must have stops: be an arm, a rack or an elevator")
        low, high = max(ends[0], _FLATTEST), min(ends[1], _STEEPEST)
        if low > high:
            raise ConfigError(
                f"hood {shooter.hood!r} gives elevations of {math.degrees(ends[0]):.0f} to {math.degrees(ends[1]):.0f} "
                f"deg; shots need some of {math.degrees(_FLATTEST):.0f} to {math.degrees(_STEEPEST):.0f}"
            )
        return low, high

    def can_tilt(self, elevation: FloatArray) -> BoolArray:
        """Return whether the shooter can reach each elevation [rad], shape (n,)."""
        low, high = self.elevations
        within: BoolArray = (elevation > low - 1e-9) & (elevation < high + 1e-9)
        return within

    def hood_for(self, elevation: float) -> float | None:
        """Return the hood angle [rad] for an elevation [rad]; None without a hood."""
        shooter = self.shooter
        return None if shooter.hood is None else (elevation - shooter.elevation) / shooter.elevation_per_hood

    # --- shots ------------------------------------------------------------------------------------------------------

    def robot_pose(self, stand: Stand, yaw: float) -> tuple[FloatArray, FloatArray]:
        """Return the pose, field frame, of a robot at a stand whose shooter points along a yaw [rad].

        Returns:
            Position [m], shape (1, 3), and attitude quaternion (x, y, z, w), shape (1, 4).
        """
        half = 0.5 * (yaw - self.shooter.launch.heading)
        return np.array([(*stand.place(self.opening.middle), 0.0)]), np.array(
            [(0.0, 0.0, math.sin(half), math.cos(half))]
        )

    def muzzle(self, stand: Stand, yaw: float) -> FloatArray:
        """Return the mean muzzle position of a shooter that points along a yaw [rad], field frame [m], shape (3,)."""
        pos, rotation = self.robot_pose(stand, yaw)
        middle = replace(self.shooter.launch, barrels=(float(np.mean(self.barrels)),))
        place: FloatArray = (pos + to_field(rotation, muzzle_offset(middle)))[0]
        return place

    def aim(self, stand: Stand) -> float:
        """Return the yaw of a shot from the middle of the muzzles to the middle of the opening, field frame [rad]."""
        yaw = stand.bearing
        for _ in range(_CORRECTIONS):
            x, y, _ = (self.opening.middle - self.muzzle(stand, yaw)).tolist()
            yaw = math.atan2(y, x)
        return yaw

    def rows(
        self, stand: Stand, elevation: FloatArray, speed: FloatArray, barrel: IntArray | int = 0,
        draws: ShotDraws | None = None,
    ) -> Balls:  # fmt: skip
        """Return the balls of n shots at the muzzle, with position, velocity and spin.

        Args:
            stand: Position of the robot; the robot aims at the middle of the opening.
            elevation: Intended elevations [rad], shape (n,).
            speed: Intended speeds relative to the muzzle [m/s], shape (n,).
            barrel: Number of the barrel, for all shots or for each shot.
            draws: Errors of the shots; None for no errors.
        """
        n = len(speed)
        d = draws or ShotDraws.none(n)
        pos, rotation = self.robot_pose(stand, self.aim(stand))
        pos, vel, spin = self.shooter.launched(
            Aim(elevation + d.elevation, speed * d.exit_speed, d.azimuth),
            (np.tile(pos, (n, 1)), np.tile(rotation, (n, 1)), np.zeros(3), np.zeros(3)),
            wheel_speeds=[self.shooter.wheel_speed_for(speed)] * len(self.shooter.wheels),
            radius=self.kind.bounding_radius * d.diameter, barrel=barrel, spin=d.spin,
        )  # fmt: skip
        return flying_balls(self.kind, pos, vel, spin, mass=d.mass, diameter=d.diameter, drag=d.drag)

    @cached_property
    def field(self) -> StandingField:
        """Static collision model of the game's field."""
        return StandingField.of(self.game.field.load().elements, CARPET)

    def fly(self, balls: Balls, *, clean: bool = False) -> ShotOutcomes:
        """Simulate the flights of balls through the field, and return the outcomes.

        Args:
            balls: Balls at the start of the flight.
            clean: Whether to end the flight of a shot that misses the opening or touches the rim or an obstacle.
        """
        return fly_shots(self.field, balls, self.opening, self.zone.zone, downward=self.zone.downward, clean=clean)

    def hits(self, stand: Stand, elevation: FloatArray, speed: FloatArray, draws: ShotDraws | None = None) -> BoolArray:
        """Simulate n shots for each of m intended shots, and return whether each shot goes in, shape (m, n).

        The n shots are distributed evenly over the barrels.

        Args:
            stand: Position of the robot.
            elevation: Intended elevations [rad], shape (m,).
            speed: Intended speeds relative to the muzzle [m/s], shape (m,).
            draws: Errors of the n shots; None for one shot without errors from each barrel. A shot without errors
                counts only if the ball does not touch the rim or the board of the target.
        """
        d = draws or ShotDraws.none(len(self.barrels))
        m, n = len(speed), len(d.elevation)
        barrel = np.tile(np.arange(n) * len(self.barrels) // n, m)
        each = ShotDraws(*(np.tile(part, m) for part in d))
        found = self.fly(
            self.rows(stand, np.repeat(elevation, n), np.repeat(speed, n), barrel, each), clean=draws is None
        )
        goes_in: BoolArray = found.goes_in
        if draws is None:
            goes_in = goes_in & ~(found.by_rim | found.by_board)
        return goes_in.reshape(m, n)

    def share(self, stand: Stand, elevation: float, speed: float, draws: ShotDraws) -> float:
        """Simulate an intended shot with random errors, and return the fraction of the shots that go in [-]."""
        return float(self.hits(stand, np.array([elevation]), np.array([speed]), draws).mean())
