"""Shooters: wheels that throw pieces, with or without a hood that tilts the shot and a turret that turns it.

How fast a piece leaves follows from the speed of the rims that it touches. Between a wheel and a fixed hood it rolls
at half the rim's speed; between two driven wheels it takes the mean of both rims, and spins by their difference. What
it has less than that is slip, which falls as it is squeezed harder:

    exit speed = rims' mean speed * (1/2 or 1) * (1 - slip * compression / squeeze)

`exit_efficiency` is (1/2 or 1) * (1 - slip) of a piece of nominal size, whose squeeze is `compression`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol, TypeVar

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.geometry.linkage import MechanismMotion, PartState, require_mechanisms
from simcore.geometry.rotation import from_rpy, multiply
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

Number = TypeVar("Number", float, FloatArray)
_LEAST_SQUEEZE = 0.3  # of that; a piece that is squeezed less is not fed at all
_EARLIEST = -0.2  # of the period between shots: pieces behind each other do not leave at once
_SLOWEST = 0.5  # a piece that would leave slower jams [m/s]
_SAME_INSTANT = 1e-9  # a shot this close to the end of a tick belongs to the next one [s]

__all__ = ["Shooter", "ShooterConfig", "ShotErrors", "SpinningMotion"]


class SpinningMotion(MechanismMotion, Protocol):
    """A mechanism whose speed a shot changes."""

    velocity: float
    """[rad/s]"""

    @property
    def inertia(self) -> float:
        """Seen at the wheel [kg m^2]."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class ShooterConfig:
    """One shooter: what drives it, where pieces leave, and how often."""

    wheels: tuple[str, ...]
    """Mechanisms of the wheels: one (against a fixed hood), or two: the lower and the upper, or the left and the
    right."""
    wheel_radius: float
    """Of the wheels [m]."""
    second_wheel_radius: float | None = None
    """Of the second wheel, where it is another one [m]."""
    wheel_places: Literal["lower and upper", "left and right"] = "lower and upper"
    """Where two wheels are: a difference of their speeds spins the piece about a level or an upright axis."""
    exit_efficiency: float
    """Speed of the piece over the mean speed of the wheels' rims [-]: 0.5 at most against a fixed hood, 1 at most
    between two wheels. `simcore calibrate --shot` fits it to shots."""
    compression: float = 0.15
    """By how much of its diameter a piece of nominal size is squeezed [-]. Estimate, within a factor of 1.5: foam balls
    of 13 to 25 cm get two to four centimeters."""
    compression_loss: float = 0.0
    """Energy that the wheels lose to the foam at each shot beside what they give to the piece [J]. Squeezing a piece of
    stiffness k by s stores k s^2 / 2, of which 1 - e^2 is lost at a restitution e. Estimate: of a ball of 0.215 kg and
    0.15 m, with 3.5 kN/m, e = 0.55 and s = 22 mm, 0.6 J, a fiftieth of what a shot of 10 m/s takes; so left out."""
    launch: LaunchParameters
    """Where the muzzles are."""
    elevation: float
    """Of the shot over the robot's floor plane, with the hood at angle zero [rad]."""
    hood: str | None = None
    """Mechanism that tilts the shot; None for a fixed one."""
    elevation_per_hood: float = -1.0
    """Change of elevation per change of the hood's angle [-]."""
    turret: str | None = None
    """Mechanism that turns the shot about the vertical; None for a shooter that is fixed on the robot."""
    turret_ratio: float = 1.0
    """Turns of the shot per turn of the turret's mechanism [-]."""
    gate: tuple[str, ...] = ()
    """Mechanisms that must all turn forward for pieces to reach the wheels: feeders."""
    gate_reversed: tuple[str, ...] = ()
    """Those of them that must turn backward instead."""
    gate_speed: float = 0.5 * math.tau
    """How fast they must at least turn [rad/s]."""
    min_wheel_speed: float = 5.0 * math.tau
    """Slower wheels throw nothing [rad/s]; the mean of both if there are two."""
    shot_rate: float = 8.0
    """Shots a second, each with all barrels [1/s]."""
    storage: str = ""
    """Name of the storage that it empties; empty: the robot's first."""
    kinds: tuple[str, ...] = ()
    """Kinds of pieces that it throws; none named: all."""

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
        """All mechanisms that it names."""
        return (*self.wheels, self.hood, self.turret, *self.gate)

    @property
    def wheel_radii(self) -> tuple[float, ...]:
        """Of each wheel [m]."""
        if len(self.wheels) == 1:
            return (self.wheel_radius,)
        return self.wheel_radius, self.wheel_radius if self.second_wheel_radius is None else self.second_wheel_radius

    def wheel_speed_for(self, exit_speed: Number) -> Number:
        """Speed of all wheels that gives an exit speed [m/s]; [rad/s]."""
        return exit_speed / (0.5 * (self.wheel_radii[0] + self.wheel_radii[-1]) * self.exit_efficiency)

    def exit_speed(self, wheel_speeds: Sequence[float]) -> float:
        """Of a piece relative to the muzzle at speeds of the wheels [rad/s]; 0 if their rims move backward [m/s]."""
        rims = 0.5 * (wheel_speeds[0] * self.wheel_radii[0] + wheel_speeds[-1] * self.wheel_radii[-1])
        return max(0.0, rims) * self.exit_efficiency

    @property
    def slip(self) -> float:
        """Of a piece of nominal size: the share by which it is slower than rims that do not slip would make it [-]."""
        return max(0.0, 1.0 - self.exit_efficiency / (0.5 if len(self.wheels) == 1 else 1.0))

    def grip(self, size: float) -> float:
        """Factor of the exit speed of a piece whose diameter is so many times that of its kind [-].

        A piece that does not slip leaves at half the rim's speed along a fixed hood, and at the rims' between two
        wheels, whatever its size. What `exit_efficiency` lacks of that is slip, which falls as the piece is squeezed
        harder: the gap stays the same.
        """
        slip, squeeze = self.slip, max(_LEAST_SQUEEZE, 1.0 + (size - 1.0) / self.compression)
        return max(0.0, 1.0 - slip / squeeze) / (1.0 - slip)

    def spin_speed(self, exit_speed: Number, wheel_speeds: Sequence[Number]) -> Number:
        """Speed of a piece's rim about its center by the spin with which it leaves [m/s], of one or of n.

        Along a fixed hood it rolls: its rim there stands still. Between two wheels its rims move with theirs [rad/s].
        """
        if len(self.wheels) == 1:
            return exit_speed
        lower, upper = (speed * radius for speed, radius in zip(wheel_speeds, self.wheel_radii, strict=True))
        return 0.5 * (lower - upper) * self.exit_efficiency

    def launched(
        self, aim: Aim, robot: Sequence[Sequence[float] | FloatArray], *, wheel_speeds: Sequence[float | FloatArray],
        radius: float | FloatArray, barrel: int | IntArray = 0, spin: float | FloatArray = 1.0,
    ) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
        """Positions, velocities and angular velocities [rad/s] of pieces as they leave, of one or of n.

        Args:
            aim: As `robot` and `barrel`: see `launch_state`.
            robot: Its pose and motion.
            wheel_speeds: Of each wheel [rad/s].
            radius: Of the pieces [m].
            barrel: Which one.
            spin: Factor of the spin that the wheels give [-].
        """
        pos, vel = launch_state(self.launch, aim, robot, barrel)
        yaw = self.launch.heading + aim.turret_angle
        if self.wheel_places == "lower and upper":  # backspin is about the axis to the right of the shot
            axis = launch_direction(yaw - 0.5 * math.pi, 0.0)
        else:  # a faster left wheel turns it clockwise about what is upright to the shot
            axis = launch_direction(yaw, aim.elevation - 0.5 * math.pi)
        rim = self.spin_speed(np.asarray(aim.speed), [np.asarray(one) for one in wheel_speeds])
        return pos, vel, to_field(robot[1], np.asarray(spin * rim / radius)[..., None] * axis)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotErrors:
    """What single shots of a shooter are off by; suppliers are called once a shot, in the order of the shots."""

    exit_speed: FloatSupplier
    """Factor of the speed at which it leaves [-]."""
    elevation: FloatSupplier
    """[rad]"""
    azimuth: FloatSupplier
    """To the left [rad]."""
    spin: FloatSupplier
    """Factor [-]."""
    feed_time: FloatSupplier
    """Of the next shot against its turn after this one, a fifth of the period earlier at most [s]."""
    hood: float = 0.0
    """How much farther the hood truly is than its encoder shows [rad]."""
    turret: float = 0.0
    """The same of the turret [rad]."""


class Shooter:
    """One shooter of a robot, and when pieces leave it.

    Each shot fires every barrel for which there is a piece. The time left to the next one is carried over from tick to
    tick, so 8 shots a second are 8000 in 1000 s though 0.125 s is no whole number of ticks. While the gate is closed,
    or the robot is empty, this time only runs down to zero: the first shot then comes at once, and nothing that was
    missed is made up for.

    Args:
        config: What it is.
        mechanisms: Of the robot, by name.
        errors: What single shots are off by; None: nothing.

    Raises:
        UnknownNameError: The config names a mechanism that the robot does not have.
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
        """Mean of the wheels [rad/s]."""
        return plain_sum(wheel.velocity for wheel in self._wheels) / len(self._wheels)

    @property
    def gate_open(self) -> bool:
        """Whether pieces reach wheels that turn."""
        return min(self._gate_spares()) > 0.0

    @property
    def aim(self) -> Aim:
        """Speed and direction of a shot, as wheels, hood and turret are now."""
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
        """Note aim and gate as a tick begins: shots in the course of the tick lie between this and its end."""
        self._aim_before, self._gate_before = self.aim, self._gate_spares()

    def update(self, held: int, is_free: Callable[[Launch], bool] | None = None) -> list[Launch]:
        """Launches of the tick that ends now; the caller takes as many pieces out of the robot.

        Args:
            held: Pieces in the robot; no more than these are launched.
            is_free: Whether nothing is in the way of a launch. A piece that cannot leave stays in the robot; if that is
                so for all barrels, the shot stays due, and is tried again as the next tick begins. None: always free.

        Raises:
            NonFiniteError: If the gate is open and the aim is not finite.
        """
        launches: list[Launch] = []
        if self.gate_open:
            now = self.aim
            if not np.isfinite(now.elevation + now.speed + now.turret_angle):
                raise NonFiniteError(
                    f"Shooter: want finite numbers, got elevation {now.elevation} rad, speed {now.speed} m/s,"
                    f" turret {now.turret_angle} rad"
                )
            period, ready = 1.0 / self.config.shot_rate, held if now.speed >= _SLOWEST else 0
            self._until_next = max(self._until_next, self._opening() * TICK)  # what was missed is not made up for
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
        """A launch of `update` as it is of a piece whose diameter is so many times that of its kind [-]."""
        return (
            launch
            if size == 1.0
            else launch._replace(aim=launch.aim._replace(speed=launch.aim.speed * self.config.grip(size)))
        )

    def released(self, launch: Launch, *, radius: float, robot: PartState) -> PartState:
        """A piece of a radius [m] as it leaves a robot with a pose and motion at that instant, field frame.

        Its attitude is that of the muzzle, whose x axis is the direction of the shot.
        """
        aim, speeds = launch.aim, [wheel.velocity for wheel in self._wheels]
        rows = self.config.launched(
            aim, robot, wheel_speeds=speeds, radius=radius, barrel=launch.barrel, spin=launch.spin
        )
        pos, vel, rate = ((x, y, z) for x, y, z in (row.tolist() for row in rows))
        muzzle = from_rpy(0.0, -float(aim.elevation), self.config.launch.heading + float(aim.turret_angle))
        return PartState(pos=pos, quat=multiply(robot.quat, muzzle), vel=vel, rate=rate)

    def after_shot(self, mass: float, speed: float) -> None:
        """Take from the wheels what they give to a ball.

        A solid ball (I = 0.4 m r^2) that leaves at v with a backspin w gains the momentum m v from both its sides
        together, and the spin by the difference of their impulses: J_lower + J_upper = m v and
        (J_lower - J_upper) r = I w. So a side gives J = m v / 2 +- 0.2 m r w. Along a fixed hood the ball rolls,
        w r = v, and the wheel gives 0.7 m v; two wheels of one speed give m v / 2 each. A wheel of radius R loses J R.

        Args:
            mass: Of the piece [kg].
            speed: At which it left [m/s].
        """
        share = 0.2 * self.config.spin_speed(speed, [wheel.velocity for wheel in self._wheels])
        impulses = (0.5 * speed + share, 0.5 * speed - share)
        # a fixed hood's share moves nothing
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
        """By how much gate and wheels turn faster than they must for pieces to leave [rad/s]."""
        spares = [forward * part.velocity - self.config.gate_speed for part, forward in self._gate]
        return [*spares, self.wheel_speed - self.config.min_wheel_speed]

    def _opening(self) -> float:
        """Share of the tick after which a gate that is open at its end has been open."""
        share = 0.0
        for before, now in zip(self._gate_before, self._gate_spares(), strict=False):
            if before <= 0.0 < now:
                share = max(share, before / (before - now))
        return share

    def _aim_at(self, share: float) -> Aim:
        """The aim a share of the way through the tick."""
        now, before = self.aim, self._aim_before
        if before is None:
            return now
        back = 1.0 - share
        return Aim(*(back * then + share * later for then, later in zip(before, now, strict=True)))
