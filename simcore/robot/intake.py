"""Intakes: a box on the robot, or on a part that moves, where pieces are taken in while a roller turns.

The box is tested on all pieces at once, along the paths that they made relative to the robot since the last tick, so
that nothing passes through it between two ticks.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from simcore.errors import ConfigError
from simcore.quantities import FIELD_PLACE, TURN_RATE, require_fields
from simcore.typing import BoolArray, FloatArray
from simcore.world.linkage import Joint, MechanismMotion, part_pose, require_mechanisms
from simcore.world.rotation import IDENTITY, Quaternion, Vector, matrix, rotate
from simcore.world.zones import BoxZone, box_crossed

__all__ = ["Intake", "IntakeConfig", "IntakeZone", "StoppedMotion", "field_to_robot", "is_deployed", "on_part"]

_DEPLOYED = 0.8  # [-]; of the way to its stop at which a deployed intake works


@dataclass(frozen=True, slots=True, kw_only=True)
class IntakeZone:
    """A box in the robot frame (x forward, y left, z up from the floor); a piece is in it when its center is.

    >>> zone = IntakeZone(x_min=-0.50, x_max=-0.35, y_min=-0.25, y_max=0.25, z_max=0.20)
    >>> zone.contains(np.array([[-0.4, 0.0, 0.075], [0.4, 0.0, 0.075]])).tolist()
    [True, False]
    """

    x_min: float
    """[m]"""
    x_max: float
    """[m]"""
    y_min: float
    """[m]"""
    y_max: float
    """[m]"""
    z_min: float = -0.10
    """Below the floor plane, for a robot that pitches over a bump [m]."""
    z_max: float
    """[m]"""

    def __post_init__(self) -> None:
        require_fields(self, **dict.fromkeys(("x_min", "x_max", "y_min", "y_max", "z_min", "z_max"), FIELD_PLACE))
        for axis in "xyz":
            low, high = getattr(self, f"{axis}_min"), getattr(self, f"{axis}_max")
            if not low < high:
                raise ConfigError(f"IntakeZone: {axis}_min must be below {axis}_max, got {low} and {high} m")

    @property
    def corners(self) -> tuple[Vector, Vector]:
        """The lowest and the highest [m]."""
        return (self.x_min, self.y_min, self.z_min), (self.x_max, self.y_max, self.z_max)

    @property
    def ball(self) -> tuple[Vector, float]:
        """Middle and radius of the ball around the box [m]."""
        return _ball(*self.corners)

    def contains(self, pos_robot: FloatArray) -> BoolArray:
        """Which positions are in the box; NaN is never in it.

        Args:
            pos_robot: Centers, robot frame [m], shape (n, 3).

        Returns:
            Mask, shape (n,).
        """
        return BoxZone(*self.corners).contains(pos_robot)

    def captured(self, prev_robot: FloatArray, now_robot: FloatArray) -> BoolArray:
        """Which pieces are in the box or went through it since the last tick.

        A path is the straight line in the robot frame, so it does not matter whether piece or robot moved.

        Args:
            prev_robot: Centers a tick ago, in the robot frame of that time [m], shape (n, 3).
            now_robot: Centers now, in the robot frame of now [m], shape (n, 3).

        Returns:
            Mask, shape (n,).
        """
        return _swept(*self.corners, prev_robot, now_robot)


def _ball(low: Vector, high: Vector) -> tuple[Vector, float]:
    """Middle and radius of the ball around the box between two corners [m]."""
    middle = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]))
    return middle, 0.5 * math.dist(low, high)


def _swept(low: Vector, high: Vector, before: FloatArray, now: FloatArray) -> BoolArray:
    """Which straight ways between places (n, 3) touch the box between two corners [m], shape (n,)."""
    # Few pieces are near: a test of the boxes round all paths (18 us for 400) leaves those worth the exact one.
    near: BoolArray = np.all((np.maximum(before, now) >= low) & (np.minimum(before, now) <= high), axis=1)
    if near.any():
        near[near] = box_crossed(low, high, before[near], now[near])
    return near


def field_to_robot(pos_field: FloatArray, robot_pos: FloatArray, robot_rotation: FloatArray) -> FloatArray:
    """Positions as the robot sees them.

    Args:
        pos_field: Field frame [m], shape (n, 3).
        robot_pos: Origin of the robot frame, field frame [m], shape (3,).
        robot_rotation: Robot to field, unit quaternion xyzw, shape (4,).

    Returns:
        Robot frame [m], shape (n, 3).
    """
    x, y, z, w = (float(c) for c in robot_rotation)
    if not math.isclose(x * x + y * y + z * z + w * w, 1.0, rel_tol=1e-3):
        raise ConfigError(f"field_to_robot: want a unit quaternion xyzw, got {robot_rotation}")
    result: FloatArray = (pos_field - robot_pos) @ matrix((x, y, z, w))  # rows times R is R transposed times each
    return result


class StoppedMotion(MechanismMotion, Protocol):
    """A mechanism between two hard stops."""

    @property
    def stops(self) -> tuple[float, float]:
        """Lower and upper hard stop [rad]."""
        ...


def is_deployed(position: float, stops: tuple[float, float], deployed_at: Literal["upper", "lower"]) -> bool:
    """Whether a mechanism at a position is near enough to that of its stops at which it is out [rad]."""
    low, high = stops
    way = (position - low) / (high - low)
    return way > _DEPLOYED if deployed_at == "upper" else way < 1.0 - _DEPLOYED


@dataclass(frozen=True, slots=True, kw_only=True)
class IntakeConfig:
    """Where pieces are taken in, and when."""

    zone: IntakeZone
    """In the robot frame; with `joints`, in the frame after the last of them."""
    roller: str | None = None
    """Mechanism that pulls pieces in; None: whatever is in the zone is taken."""
    roller_speed: float = math.tau
    """The roller takes pieces while it turns forward faster than this [rad/s]."""
    roller_reversed: bool = False
    """Whether it takes pieces while the roller turns backward instead."""
    deploy: str | None = None
    """Mechanism that must be out; None for an intake that always is."""
    deployed_at: Literal["upper", "lower"] = "upper"
    """At which of its stops `deploy` is out."""
    joints: tuple[Joint, ...] = ()
    """What carries the zone; none for one that is fixed on the robot."""
    stretch: Joint | None = None
    """A sliding joint whose travel the zone covers from where it is retracted; None: the zone keeps its size."""
    storage: str = ""
    """Name of the storage that it fills; empty: the robot's first."""
    kinds: tuple[str, ...] = ()
    """Kinds of pieces that it takes; none named: all."""

    def __post_init__(self) -> None:
        require_fields(self, roller_speed=TURN_RATE)
        if self.stretch is not None and not self.stretch.slides:
            raise ConfigError("IntakeConfig: stretch must be a joint that slides")

    @property
    def mechanism_names(self) -> tuple[str | None, ...]:
        """All mechanisms that it names."""
        stretch = None if self.stretch is None else self.stretch.mechanism
        return (self.roller, self.deploy, stretch, *(joint.mechanism for joint in self.joints))


class Intake:
    """One intake of a robot.

    Args:
        config: Where and when.
        mechanisms: Of the robot, by name.

    Raises:
        UnknownNameError: The config names a mechanism that the robot does not have.
        ConfigError: `deploy` has no stops.
    """

    def __init__(self, config: IntakeConfig, mechanisms: Mapping[str, StoppedMotion]) -> None:
        require_mechanisms("an intake", config.mechanism_names, mechanisms)
        if config.deploy is not None and not all(map(math.isfinite, mechanisms[config.deploy].stops)):
            raise ConfigError(f"IntakeConfig: deploy must have stops, like an arm or a rack; got {config.deploy!r}")
        self.config = config
        self._mechanisms = mechanisms
        self._part_before: tuple[Vector, Quaternion] | None = None

    @property
    def is_active(self) -> bool:
        """Whether it is out and its roller pulls in."""
        c = self.config
        if c.roller is not None:
            forward = self._mechanisms[c.roller].velocity
            if not (-forward if c.roller_reversed else forward) > c.roller_speed:
                return False
        if c.deploy is None:
            return True
        deploy = self._mechanisms[c.deploy]
        return is_deployed(deploy.position, deploy.stops, c.deployed_at)

    @property
    def corners(self) -> tuple[Vector, Vector]:
        """Lowest and highest corner of its zone, with mechanisms as they are now, in the frame that carries it [m]."""
        low, high = self.config.zone.corners
        stretch = self.config.stretch
        if stretch is None:
            return low, high
        travel = stretch.ratio * self._mechanisms[stretch.mechanism].position
        x, y, z = (travel * share for share in stretch.axis)
        return (
            (low[0] + min(x, 0.0), low[1] + min(y, 0.0), low[2] + min(z, 0.0)),
            (high[0] + max(x, 0.0), high[1] + max(y, 0.0), high[2] + max(z, 0.0)),
        )

    @property
    def zone(self) -> IntakeZone:
        """With mechanisms where they are now, in the frame that carries it."""
        (a, b, c), (d, e, f) = self.corners
        return IntakeZone(x_min=a, x_max=d, y_min=b, y_max=e, z_min=c, z_max=f)

    @property
    def around(self) -> tuple[Vector, Vector, float]:
        """Middles of the ball around its zone a tick ago and now, robot frame, and the ball's radius [m]."""
        middle, radius = _ball(*self.corners)
        if not self.config.joints:
            return middle, middle, radius
        part = part_pose(self.config.joints, self._mechanisms)
        return on_part(self._part_before or part, middle), on_part(part, middle), radius

    def pass_tick(self) -> None:
        """Note where the zone is, in a tick in which nothing can be taken in."""
        if self.config.joints:
            self._part_before = part_pose(self.config.joints, self._mechanisms)

    def captured(self, prev_robot: FloatArray, now_robot: FloatArray) -> BoolArray:
        """Which pieces it takes: those that are in its zone or went through it since the last tick.

        Call it or `pass_tick` once a tick.

        Args:
            prev_robot: Centers a tick ago, in the robot frame of that time [m], shape (n, 3).
            now_robot: Centers now, in the robot frame of now [m], shape (n, 3).

        Returns:
            Mask, shape (n,); all False while the intake is not active.
        """
        before = self._part_before
        self._part_before = part = None if not self.config.joints else part_pose(self.config.joints, self._mechanisms)
        if not len(now_robot) or not self.is_active:
            return np.zeros(len(now_robot), dtype=np.bool_)
        if part is not None:
            prev_robot, now_robot = _into(prev_robot, before or part), _into(now_robot, part)
        return _swept(*self.corners, prev_robot, now_robot)


def on_part(part: tuple[Vector, Quaternion], point: Vector) -> Vector:
    """A point that is given in the frame of a part, in the frame that the part's pose is given in [m]."""
    (x, y, z), quat = part
    dx, dy, dz = rotate(quat, point)
    return x + dx, y + dy, z + dz


def _into(points: FloatArray, part: tuple[Vector, Quaternion]) -> FloatArray:
    pos, quat = part
    moved: FloatArray = points - np.array(pos)
    return moved if quat is IDENTITY else moved @ matrix(quat)
