"""Intakes: boxes on the robot, or on a moving part, that take pieces in while a roller turns.

Each tick tests all pieces at once, along their paths relative to the robot since the last tick, so that no piece
passes through the box between two ticks.
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

_DEPLOYED = 0.8  # [-]; fraction of the travel to its stop beyond which an intake counts as deployed


@dataclass(frozen=True, slots=True, kw_only=True)
class IntakeZone:
    """Box in the robot frame (x forward, y left, z up from the floor); contains the pieces whose center is inside.

    >>> zone = IntakeZone(x_min=-0.50, x_max=-0.35, y_min=-0.25, y_max=0.25, z_max=0.20)
    >>> zone.contains(np.array([[-0.4, 0.0, 0.075], [0.4, 0.0, 0.075]])).tolist()
    [True, False]
    """

    x_min: float
    """Lower bound along x [m]."""
    x_max: float
    """Upper bound along x [m]."""
    y_min: float
    """Lower bound along y [m]."""
    y_max: float
    """Upper bound along y [m]."""
    z_min: float = -0.10
    """Lower bound along z [m]; below the floor plane, for a robot that pitches over a bump."""
    z_max: float
    """Upper bound along z [m]."""

    def __post_init__(self) -> None:
        require_fields(self, **dict.fromkeys(("x_min", "x_max", "y_min", "y_max", "z_min", "z_max"), FIELD_PLACE))
        for axis in "xyz":
            low, high = getattr(self, f"{axis}_min"), getattr(self, f"{axis}_max")
            if not low < high:
                raise ConfigError(f"IntakeZone: {axis}_min must be below {axis}_max, got {low} and {high} m")

    @property
    def corners(self) -> tuple[Vector, Vector]:
        """Lowest and highest corner [m]."""
        return (self.x_min, self.y_min, self.z_min), (self.x_max, self.y_max, self.z_max)

    @property
    def ball(self) -> tuple[Vector, float]:
        """Center and radius of the bounding sphere [m]."""
        return _ball(*self.corners)

    def contains(self, pos_robot: FloatArray) -> BoolArray:
        """Return a mask of the positions in the box; False for NaN.

        Args:
            pos_robot: Centers, robot frame [m], shape (n, 3).

        Returns:
            Mask, shape (n,).
        """
        return BoxZone(*self.corners).contains(pos_robot)

    def captured(self, prev_robot: FloatArray, now_robot: FloatArray) -> BoolArray:
        """Return a mask of the pieces that are in the box or went through it since the last tick.

        A path is a straight line in the robot frame, so it does not matter whether piece or robot moved.

        Args:
            prev_robot: Centers a tick ago, in the robot frame of that time [m], shape (n, 3).
            now_robot: Centers now, in the robot frame of now [m], shape (n, 3).

        Returns:
            Mask, shape (n,).
        """
        return _swept(*self.corners, prev_robot, now_robot)


def _ball(low: Vector, high: Vector) -> tuple[Vector, float]:
    """Return center and radius of the bounding sphere of the box between two corners [m]."""
    middle = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]))
    return middle, 0.5 * math.dist(low, high)


def _swept(low: Vector, high: Vector, before: FloatArray, now: FloatArray) -> BoolArray:
    """Return a mask of the straight paths between places (n, 3) that touch the box between two corners [m]."""
    # Few pieces are near: testing the bounding boxes of all paths (18 us for 400) leaves those worth the exact test.
    near: BoolArray = np.all((np.maximum(before, now) >= low) & (np.minimum(before, now) <= high), axis=1)
    if near.any():
        near[near] = box_crossed(low, high, before[near], now[near])
    return near


def field_to_robot(pos_field: FloatArray, robot_pos: FloatArray, robot_rotation: FloatArray) -> FloatArray:
    """Transform positions from the field frame to the robot frame.

    Args:
        pos_field: Field frame [m], shape (n, 3).
        robot_pos: Origin of the robot frame, field frame [m], shape (3,).
        robot_rotation: Robot to field, unit quaternion xyzw, shape (4,).

    Returns:
        Robot frame [m], shape (n, 3).
    """
    x, y, z, w = (float(c) for c in robot_rotation)
    if not math.isclose(x * x + y * y + z * z + w * w, 1.0, rel_tol=1e-3):
        raise ConfigError(f"field_to_robot: need a unit quaternion xyzw, got {robot_rotation}")
    result: FloatArray = (pos_field - robot_pos) @ matrix((x, y, z, w))  # rows times R is R transposed times each
    return result


class StoppedMotion(MechanismMotion, Protocol):
    """Mechanism between two hard stops."""

    @property
    def stops(self) -> tuple[float, float]:
        """Lower and upper hard stop [rad]."""
        ...


def is_deployed(position: float, stops: tuple[float, float], deployed_at: Literal["upper", "lower"]) -> bool:
    """Return whether a mechanism is near the hard stop at which it is deployed [rad]."""
    low, high = stops
    fraction = (position - low) / (high - low)
    return fraction > _DEPLOYED if deployed_at == "upper" else fraction < 1.0 - _DEPLOYED


@dataclass(frozen=True, slots=True, kw_only=True)
class IntakeConfig:
    """Zone of an intake, and the conditions under which it takes pieces in."""

    zone: IntakeZone
    """Zone in the robot frame; with `joints`, in the frame after the last of them."""
    roller: str | None = None
    """Mechanism that pulls pieces in; None: the intake takes whatever is in the zone."""
    roller_speed: float = math.tau
    """Forward speed above which the roller takes pieces [rad/s]."""
    roller_reversed: bool = False
    """Whether it takes pieces while the roller turns backward instead."""
    deploy: str | None = None
    """Mechanism that must be deployed; None: the intake always is."""
    deployed_at: Literal["upper", "lower"] = "upper"
    """Hard stop at which `deploy` is out."""
    joints: tuple[Joint, ...] = ()
    """Joints that carry the zone; empty: it is fixed on the robot."""
    stretch: Joint | None = None
    """Sliding joint whose travel from the retracted position extends the zone; None: the zone keeps its size."""
    storage: str = ""
    """Name of the storage that the intake fills; empty: the robot's first."""
    kinds: tuple[str, ...] = ()
    """Kinds of pieces that the intake takes; empty: all."""

    def __post_init__(self) -> None:
        require_fields(self, roller_speed=TURN_RATE)
        if self.stretch is not None and not self.stretch.slides:
            raise ConfigError("IntakeConfig: stretch must be a joint that slides")

    @property
    def mechanism_names(self) -> tuple[str | None, ...]:
        """Names of the mechanisms that it uses."""
        stretch = None if self.stretch is None else self.stretch.mechanism
        return (self.roller, self.deploy, stretch, *(joint.mechanism for joint in self.joints))


class Intake:
    """One intake of a robot.

    Args:
        config: Zone and conditions.
        mechanisms: Mechanisms of the robot, by name.

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
        """Whether the intake is deployed and its roller pulls in."""
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
        """Lowest and highest corner of the zone at the mechanisms' current positions, in the carrying frame [m]."""
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
        """Zone at the mechanisms' current positions, in the carrying frame."""
        (a, b, c), (d, e, f) = self.corners
        return IntakeZone(x_min=a, x_max=d, y_min=b, y_max=e, z_min=c, z_max=f)

    @property
    def around(self) -> tuple[Vector, Vector, float]:
        """Centers of the zone's bounding sphere a tick ago and now, robot frame, and its radius [m]."""
        middle, radius = _ball(*self.corners)
        if not self.config.joints:
            return middle, middle, radius
        part = part_pose(self.config.joints, self._mechanisms)
        return on_part(self._part_before or part, middle), on_part(part, middle), radius

    def pass_tick(self) -> None:
        """Record the zone's pose in a tick in which there is nothing to take in."""
        if self.config.joints:
            self._part_before = part_pose(self.config.joints, self._mechanisms)

    def captured(self, prev_robot: FloatArray, now_robot: FloatArray) -> BoolArray:
        """Return a mask of the pieces that the intake takes: in its zone now, or through it since the last tick.

        Call this or `pass_tick` once a tick.

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
    """Transform a point from the frame of a part to the frame of the part's pose [m]."""
    (x, y, z), quat = part
    dx, dy, dz = rotate(quat, point)
    return x + dx, y + dy, z + dz


def _into(points: FloatArray, part: tuple[Vector, Quaternion]) -> FloatArray:
    pos, quat = part
    moved: FloatArray = points - np.array(pos)
    return moved if quat is IDENTITY else moved @ matrix(quat)
