"""Shooters: wheels that launch game pieces, with an optional hood for the elevation and turret for the heading.

The exit speed follows from the rim speed of the wheels. Between a wheel and a fixed hood, the piece rolls at half the
rim speed. Between two driven wheels, the piece moves at the mean rim speed, and the difference of the rim speeds makes
the piece spin. Slip reduces the exit speed; a more compressed piece slips less:

    exit speed = mean rim speed * (1/2 or 1) * (1 - slip * compression / actual compression)

`exit_efficiency` is (1/2 or 1) * (1 - slip) for a piece of nominal size, whose compression is `compression`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol, TypeVar

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.pieces.launch import Aim, Launch, LaunchParameters, launch_direction, launch_state, to_field
from simcore.quantities import (
    ANGLE,
    EFFICIENCY,
    FACTOR,
    RATE,
    RATIO,
    ROBOT_LENGTH,
    TURN_RATE,
    TURN_RATE_OR_NONE,
    require_fields,
)
from simcore.typing import FloatArray, FloatSupplier, IntArray
from simcore.units import TICK, plain_sum
from simcore.world.linkage import MechanismMotion, PartState, require_mechanisms
from simcore.world.rotation import from_rpy, multiply

Number = TypeVar("Number", float, FloatArray)
_LEAST_SQUEEZE = 0.3  # of `compression`, lower limit; a piece compressed less would not be fed at all
_EARLIEST = -0.2  # of the period between shots; limit on early shots, as pieces in a row cannot leave at once
_SLOWEST = 0.5  # [m/s]; at a lower exit speed, the piece stays in the shooter
_SAME_INSTANT = 1e-9  # [s]; a shot this close to the end of a tick belongs to the next tick

__all__ = ["Shooter", "ShooterConfig", "ShotErrors", "SpinningMotion"]


class SpinningMotion(MechanismMotion, Protocol):
    """Motion of a wheel mechanism that a shot slows down."""

    velocity: float
    """Angular velocity of the wheel [rad/s]."""

    @property
    def inertia(self) -> float:
        """Moment of inertia referred to the wheel [kg m^2]."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class ShooterConfig:
    """Config of a shooter: wheels, muzzles, hood, turret, feeder and shot rate."""

    wheels: tuple[str, ...]
    """Names of the wheel mechanisms: one wheel opposite a fixed hood, or two wheels in the order of `wheel_places`."""
    wheel_radius: float
    """Radius of the wheels, or of the first wheel if `second_wheel_radius` is given [m]."""
    second_wheel_radius: float | None = None
    """Radius of the second wheel [m]; None if equal to `wheel_radius`."""
    wheel_places: Literal["lower and upper", "left and right"] = "lower and upper"
    """Arrangement of two wheels. A speed difference makes the piece spin about a horizontal axis for lower and upper
    wheels, and about an upright axis for left and right wheels."""
    exit_efficiency: float
    """Ratio of exit speed to mean rim speed [-]: at most 0.5 against a fixed hood, at most 1 between two wheels.
    `simcore calibrate --shot` fits the ratio to measured shots."""
    compression: float = 0.15
    """Compression of a piece of nominal size, as a fraction of the diameter [-]. Estimate, within a factor of 1.5:
    shooters compress foam balls of 13 to 25 cm in diameter by two to four centimeters."""
    compression_loss: float = 0.0
    """Energy that the wheels lose to the foam in each shot, in addition to the kinetic energy of the piece [J]. A piece
    of stiffness k that is compressed by s stores the energy k s^2 / 2, and dissipates the fraction 1 - e^2 of this
    energy at a coefficient of restitution e. A ball of 0.215 kg and 0.15 m with an estimated 3.5 kN/m, e = 0.55 and
    s = 22 mm dissipates 0.6 J. The default is 0, because 0.6 J are only 2 % of the energy of a shot at 10 m/s."""
    launch: LaunchParameters
    """Positions and heading of the muzzles on the robot."""
    elevation: float
    """Elevation of the shot above the robot's floor plane at hood angle zero [rad]."""
    hood: str | None = None
    """Name of the hood mechanism; None for a fixed hood."""
    elevation_per_hood: float = -1.0
    """Change of the elevation per change of the position of the hood mechanism [-]."""
    turret: str | None = None
    """Name of the turret mechanism; None for a shooter without a turret."""
    turret_ratio: float = 1.0
    """Turns of the launch direction per turn of the turret mechanism [-]."""
    gate: tuple[str, ...] = ()
    """Names of the feeder mechanisms, which must all turn forward to feed pieces to the wheels."""
    gate_reversed: tuple[str, ...] = ()
    """Names of the mechanisms of `gate` that must turn backward instead of forward."""
    gate_speed: float = 0.5 * math.tau
    """Speed of each `gate` mechanism above which the mechanism feeds pieces [rad/s]."""
    min_wheel_speed: float = 5.0 * math.tau
    """Mean speed of the wheels above which the shooter fires [rad/s]."""
    shot_rate: float = 8.0
    """Shots per second [1/s]; each shot fires all barrels that have a piece."""
    storage: str = ""
    """Name of the storage that feeds the shooter; empty for the robot's first storage."""
    kinds: tuple[str, ...] = ()
    """Kinds of pieces that the shooter launches; empty for all kinds."""

    def __post_init__(self) -> None:
        owner = "ShooterConfig"
        require_fields(
            self, wheel_radius=ROBOT_LENGTH, second_wheel_radius=ROBOT_LENGTH, exit_efficiency=EFFICIENCY,
            compression=EFFICIENCY, compression_loss=FACTOR, elevation=ANGLE, elevation_per_hood=RATIO,
            turret_ratio=RATIO, gate_speed=TURN_RATE, min_wheel_speed=TURN_RATE_OR_NONE, shot_rate=RATE,
        )  # fmt: skip
        if len(self.wheels) not in (1, 2):
            raise ConfigError(f"{owner}: wheels must name one or two mechanisms, got {self.wheels}")
        if self.second_wheel_radius is not None and len(self.wheels) == 1:
            raise ConfigError(f"{owner}: second_wheel_radius needs two wheels, got {self.wheels}")
        for name in set(self.gate_reversed) - set(self.gate):
            raise ConfigError(f"{owner}: gate_reversed must name mechanisms of gate {self.gate}, got {name!r}")

    @property
    def mechanism_names(self) -> tuple[str | None, ...]:
        """Names of the mechanisms that the shooter uses; None in place of a missing hood or turret."""
        return (*self.wheels, self.hood, self.turret, *self.gate)

    @property
    def wheel_radii(self) -> tuple[float, ...]:
        """Radius of each wheel [m]."""
        if len(self.wheels) == 1:
            return (self.wheel_radius,)
        return self.wheel_radius, self.wheel_radius if self.second_wheel_radius is None else self.second_wheel_radius

    def wheel_speed_for(self, exit_speed: Number) -> Number:
        """Return the wheel speed [rad/s], equal for all wheels, that gives an exit speed.

        Args:
            exit_speed: Exit speed relative to the muzzle, for one shot or for n shots [m/s].
        """
        return exit_speed / (0.5 * (self.wheel_radii[0] + self.wheel_radii[-1]) * self.exit_efficiency)

    def exit_speed(self, wheel_speeds: Sequence[float]) -> float:
        """Return the exit speed of a piece of nominal size relative to the muzzle [m/s].

        The exit speed is 0 if the mean rim speed is negative.

        Args:
            wheel_speeds: Speed of each wheel [rad/s].
        """
        rims = 0.5 * (wheel_speeds[0] * self.wheel_radii[0] + wheel_speeds[-1] * self.wheel_radii[-1])
        return max(0.0, rims) * self.exit_efficiency

    @property
    def slip(self) -> float:
        """Fraction of the no-slip exit speed that a piece of nominal size loses to slip [-]."""
        return max(0.0, 1.0 - self.exit_efficiency / (0.5 if len(self.wheels) == 1 else 1.0))

    def grip(self, size: float) -> float:
        """Return the factor on the exit speed for a piece with `size` times the nominal diameter [-].

        Without slip, the ratio of exit speed to rim speed would be 0.5 along a fixed hood and 1 between two wheels, for
        a piece of any size. Slip reduces the ratio for a nominal piece to `exit_efficiency`. In the gap of constant
        width, a larger piece is compressed more and slips less.
        """
        slip, squeeze = self.slip, max(_LEAST_SQUEEZE, 1.0 + (size - 1.0) / self.compression)
        return max(0.0, 1.0 - slip / squeeze) / (1.0 - slip)

    def spin_speed(self, exit_speed: Number, wheel_speeds: Sequence[Number]) -> Number:
        """Return the surface speed of a spinning piece relative to the center, for one piece or n pieces [m/s].

        Along a fixed hood, the piece rolls. Between two wheels, the surface of the piece moves with the rims. The speed
        is positive for backspin; with left and right wheels, for clockwise spin seen from above.

        Args:
            exit_speed: Exit speed [m/s].
            wheel_speeds: Speed of each wheel [rad/s].
        """
        if len(self.wheels) == 1:
            return exit_speed
        lower, upper = (speed * radius for speed, radius in zip(wheel_speeds, self.wheel_radii, strict=True))
        return 0.5 * (lower - upper) * self.exit_efficiency

    def launched(
        self, aim: Aim, robot: Sequence[Sequence[float] | FloatArray], *, wheel_speeds: Sequence[float | FloatArray],
        radius: float | FloatArray, barrel: int | IntArray = 0, spin: float | FloatArray = 1.0,
    ) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
        """Compute position, velocity and spin of one piece or n pieces at launch; see `launch_state`.

        Args:
            aim: Aim of one shot or of n shots.
            robot: Pose and motion of the robot, field frame, as for `launch_state`.
            wheel_speeds: Speed of each wheel [rad/s].
            radius: Radius of the pieces [m].
            barrel: Index of the barrel.
            spin: Factor on the spin from the wheels [-].

        Returns:
            Positions [m], velocities [m/s] and angular velocities [rad/s], field frame.
        """
        pos, vel = launch_state(self.launch, aim, robot, barrel)
        yaw = self.launch.heading + aim.turret_angle
        if self.wheel_places == "lower and upper":  # backspin is about the axis to the right of the shot
            axis = launch_direction(yaw - 0.5 * math.pi, 0.0)
        else:  # a faster left wheel turns the piece clockwise about the upright axis of the shot
            axis = launch_direction(yaw, aim.elevation - 0.5 * math.pi)
        rim = self.spin_speed(np.asarray(aim.speed), [np.asarray(one) for one in wheel_speeds])
        return pos, vel, to_field(robot[1], np.asarray(spin * rim / radius)[..., None] * axis)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotErrors:
    """Errors of a shooter.

    The shooter calls `feed_time` once per shot, and the other suppliers once per launched piece, in order.
    """

    exit_speed: FloatSupplier
    """Supplier of the factor on the exit speed [-]."""
    elevation: FloatSupplier
    """Supplier of the elevation error, positive up [rad]."""
    azimuth: FloatSupplier
    """Supplier of the azimuth error, positive to the left [rad]."""
    spin: FloatSupplier
    """Supplier of the factor on the spin [-]."""
    feed_time: FloatSupplier
    """Supplier of the additional delay before the next shot [s]; the shooter limits a negative delay to a fifth of the
    shot period."""
    hood: float = 0.0
    """Error of the hood encoder: true angle minus reading [rad]."""
    turret: float = 0.0
    """Error of the turret encoder: true angle minus reading [rad]."""


class Shooter:
    """Shooter of a robot: aim, timing of shots, and speed loss of the wheels.

    Each shot fires every barrel that has a piece. The time until the next shot carries over from tick to tick: 8 shots
    per second are exactly 8000 in 1000 s, although 0.125 s is not a whole number of ticks. While the gate is closed or
    the robot is empty, the time until the next shot stops at zero. The first shot then fires immediately, and the
    shooter does not make up for missed shots.

    Args:
        config: Config of the shooter.
        mechanisms: Mechanisms of the robot, by name.
        errors: Errors of the shooter; None for a shooter without errors.

    Raises:
        UnknownNameError: If the config names a mechanism that the robot does not have.
    """

    def __init__(
        self, config: ShooterConfig, mechanisms: Mapping[str, SpinningMotion], errors: ShotErrors | None = None
    ) -> None:
        require_mechanisms("a shooter", config.mechanism_names, mechanisms)
        self.config = config
        self._wheels = [mechanisms[name] for name in config.wheels]
        self._gate = [(mechanisms[name], -1.0 if name in config.gate_reversed else 1.0) for name in config.gate]
        self._hood = None if config.hood is None else mechanisms[config.hood]
        self._turret = None if config.turret is None else mechanisms[config.turret]
        self._errors = errors
        self._until_next = 0.0
        self._aim_before: Aim | None = None
        self._gate_before: list[float] = []

    @property
    def wheel_speed(self) -> float:
        """Mean angular velocity of the wheels [rad/s]."""
        return plain_sum(wheel.velocity for wheel in self._wheels) / len(self._wheels)

    @property
    def gate_open(self) -> bool:
        """Whether each `gate` mechanism exceeds `gate_speed`, and the mean wheel speed exceeds `min_wheel_speed`."""
        return min(self._gate_spares()) > 0.0

    @property
    def aim(self) -> Aim:
        """Current aim: speed and direction of a shot with the current state of wheels, hood and turret."""
        config = self.config
        hood = 0.0 if self._hood is None else self._hood.position
        turret, rate = (0.0, 0.0) if self._turret is None else (self._turret.position, self._turret.velocity)
        return Aim(
            config.elevation + config.elevation_per_hood * hood,
            config.exit_speed([wheel.velocity for wheel in self._wheels]),
            config.turret_ratio * turret,
            config.turret_ratio * rate,
        )

    def begin_tick(self) -> None:
        """Record aim and gate at the start of a tick, for interpolation at the times of shots within the tick."""
        self._aim_before, self._gate_before = self.aim, self._gate_spares()

    def update(self, held: int, is_free: Callable[[Launch], bool] | None = None) -> list[Launch]:
        """Advance the timing of shots by a tick, and return the launches of the tick that ends now.

        The caller removes the launched pieces from the robot, and calls `after_shot` to slow the wheels.

        Args:
            held: Number of pieces in the robot, which limits the number of launches.
            is_free: Function that returns whether the path of a launch is free; None if paths are always free. A
                blocked piece stays in the robot. If all barrels are blocked, the shooter repeats the shot at the start
                of the next tick.

        Raises:
            NonFiniteError: If the gate is open and the aim is not finite.
        """
        launches: list[Launch] = []
        if self.gate_open:
            now = self.aim
            if not np.isfinite(now.elevation + now.speed + now.turret_angle):
                raise NonFiniteError(
                    f"Shooter: need finite numbers, got elevation {now.elevation} rad, speed {now.speed} m/s,"
                    f" turret {now.turret_angle} rad"
                )
            period, ready = 1.0 / self.config.shot_rate, held if now.speed >= _SLOWEST else 0
            self._until_next = max(self._until_next, self._opening() * TICK)  # missed shots are not made up
            while ready > 0 and self._until_next < TICK - _SAME_INSTANT:
                delay = max(0.0, self._until_next)
                aim = self._aim_at(delay / TICK)
                shot = [Launch(barrel, delay, aim) for barrel in range(len(self.config.launch.barrels))]
                if is_free is not None:
                    shot = [launch for launch in shot if is_free(launch)]
                if not shot:
                    break
                launches += shot[:ready]
                ready = max(0, ready - len(shot))
                self._until_next += period
                if self._errors is not None:
                    self._until_next += max(_EARLIEST * period, self._errors.feed_time())
        self._until_next -= TICK
        self._aim_before, self._gate_before = None, []
        return launches if self._errors is None else [self._with_errors(launch, self._errors) for launch in launches]

    def gripped(self, launch: Launch, size: float) -> Launch:
        """Return a launch with the exit speed corrected for a piece of `size` times the nominal diameter [-]."""
        return (
            launch
            if size == 1.0
            else launch._replace(aim=launch.aim._replace(speed=launch.aim.speed * self.config.grip(size)))
        )

    def released(self, launch: Launch, *, radius: float, robot: PartState) -> PartState:
        """Return the pose and motion of a piece at launch, field frame.

        The piece has the attitude of the muzzle, whose x axis points in the direction of the shot.

        Args:
            launch: Launch of the piece.
            radius: Radius of the piece [m].
            robot: Pose and motion of the robot, field frame.
        """
        aim, speeds = launch.aim, [wheel.velocity for wheel in self._wheels]
        rows = self.config.launched(
            aim, robot, wheel_speeds=speeds, radius=radius, barrel=launch.barrel, spin=launch.spin
        )
        pos, vel, rate = ((x, y, z) for x, y, z in (row.tolist() for row in rows))
        muzzle = from_rpy(0.0, -float(aim.elevation), self.config.launch.heading + float(aim.turret_angle))
        return PartState(pos=pos, quat=multiply(robot.quat, muzzle), vel=vel, rate=rate)

    def after_shot(self, mass: float, speed: float) -> None:
        """Reduce the wheel speeds by the momentum, spin and compression loss of a launched ball.

        A solid ball (I = 0.4 m r^2) that leaves at v with a backspin w gets the impulses J_lower and J_upper from the
        two sides: J_lower + J_upper = m v and (J_lower - J_upper) r = I w, so J = m v / 2 +- 0.2 m r w. Along a fixed
        hood the ball rolls, w r = v, and the wheel contributes 0.7 m v; two wheels of equal speed contribute m v / 2
        each. A wheel of radius R loses the angular momentum J R.

        Args:
            mass: Mass of the piece [kg].
            speed: Exit speed [m/s].
        """
        share = 0.2 * self.config.spin_speed(speed, [wheel.velocity for wheel in self._wheels])
        impulses = (0.5 * speed + share, 0.5 * speed - share)
        # the impulse of a fixed hood changes no wheel
        for wheel, radius, impulse in zip(self._wheels, self.config.wheel_radii, impulses, strict=False):
            wheel.velocity += -mass * impulse * radius / wheel.inertia
            if lost := self.config.compression_loss / len(self._wheels):
                left = wheel.velocity**2 - 2.0 * lost / wheel.inertia
                wheel.velocity = math.copysign(math.sqrt(max(0.0, left)), wheel.velocity)

    def _with_errors(self, launch: Launch, errors: ShotErrors) -> Launch:
        aim = launch.aim
        off = aim._replace(
            elevation=aim.elevation + errors.elevation() + self.config.elevation_per_hood * errors.hood,
            speed=aim.speed * errors.exit_speed(),
            turret_angle=aim.turret_angle + errors.azimuth() + self.config.turret_ratio * errors.turret,
        )
        return launch._replace(aim=off, spin=errors.spin())

    def _gate_spares(self) -> list[float]:
        """Return gate mechanism speeds minus `gate_speed`, then the mean wheel speed minus `min_wheel_speed` [rad/s].

        The gate is open while all values are positive.
        """
        spares = [forward * part.velocity - self.config.gate_speed for part, forward in self._gate]
        return [*spares, self.wheel_speed - self.config.min_wheel_speed]

    def _opening(self) -> float:
        """Return the fraction of the tick before the gate opened; 0 if the gate did not open in this tick."""
        share = 0.0
        for before, now in zip(self._gate_before, self._gate_spares(), strict=False):
            if before <= 0.0 < now:
                share = max(share, before / (before - now))
        return share

    def _aim_at(self, share: float) -> Aim:
        """Interpolate the aim at a fraction of the tick; return the current aim if `begin_tick` was not called."""
        now, before = self.aim, self._aim_before
        if before is None:
            return now
        back = 1.0 - share
        return Aim(*(back * then + share * later for then, later in zip(before, now, strict=True)))
