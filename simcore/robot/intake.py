"""Intakes: zones on the robot, or on a moving part, where a turning roller takes in game pieces.

Each tick tests the paths of all pieces relative to the robot since the last tick. The test therefore also finds pieces
that pass through a zone between two ticks.
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

_DEPLOYED = 0.8  # [-]; fraction of the travel to the hard stop beyond which an intake counts as deployed


@dataclass(frozen=True, slots=True, kw_only=True)
class IntakeZone:
    """Box in the robot frame (x forward, y left, z up from the floor), tested against the centers of pieces.

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
    """Lower bound along z [m]; below the floor by default, for a robot that pitches on a bump."""
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
        """Corners with the smallest and largest coordinates [m]."""
        return (self.x_min, self.y_min, self.z_min), (self.x_max, self.y_max, self.z_max)

    @property
    def ball(self) -> tuple[Vector, float]:
        """Center and radius of the bounding sphere [m]."""
        return _ball(*self.corners)

    def contains(self, pos_robot: FloatArray) -> BoolArray:
        """Return whether each piece is in the box.

        Args:
            pos_robot: Centers of the pieces, robot frame [m], shape (n, 3).

        Returns:
            Mask, shape (n,); False for NaN.
        """
        return BoxZone(*self.corners).contains(pos_robot)

    def captured(self, prev_robot: FloatArray, now_robot: FloatArray) -> BoolArray:
        """Return whether each piece is in the box or passed through the box since the last tick.

        Paths are straight lines in the robot frame, so the test covers motion of the piece and motion of the robot.

        Args:
            prev_robot: Centers of the pieces a tick ago, in the robot frame of that time [m], shape (n, 3).
            now_robot: Current centers of the pieces, in the current robot frame [m], shape (n, 3).

        Returns:
            Mask, shape (n,).
        """
        return _swept(*self.corners, prev_robot, now_robot)


def _ball(low: Vector, high: Vector) -> tuple[Vector, float]:
    """Return the center and radius of a box's bounding sphere [m]."""
    middle = (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]))
    return middle, 0.5 * math.dist(low, high)


def _swept(low: Vector, high: Vector, before: FloatArray, now: FloatArray) -> BoolArray:
    """Return whether each of n straight paths touches a box, shape (n,).

    Args:
        low: Corner of the box with the smallest coordinates [m].
        high: Corner of the box with the largest coordinates [m].
        before: Starts of the paths [m], shape (n, 3).
        now: Ends of the paths [m], shape (n, 3).
    """
    # A test of the bounding boxes of all paths comes first (18 us for 400): only few paths need the exact test.
    near: BoolArray = np.all((np.maximum(before, now) >= low) & (np.minimum(before, now) <= high), axis=1)
    if near.any():
        near[near] = box_crossed(low, high, before[near], now[near])
    return near


def field_to_robot(pos_field: FloatArray, robot_pos: FloatArray, robot_rotation: FloatArray) -> FloatArray:
    """Transform positions from the field frame to the robot frame.

    Args:
        pos_field: Positions, field frame [m], shape (n, 3).
        robot_pos: Origin of the robot, field frame [m], shape (3,).
        robot_rotation: Rotation from robot to field axes, unit quaternion x, y, z, w, shape (4,).

    Returns:
        Positions, robot frame [m], shape (n, 3).

    Raises:
        ConfigError: If the quaternion is not a unit quaternion.
    """
    x, y, z, w = (float(c) for c in robot_rotation)
    if not math.isclose(x * x + y * y + z * z + w * w, 1.0, rel_tol=1e-3):
        raise ConfigError(f"field_to_robot: need a unit quaternion xyzw, got {robot_rotation}")
    result: FloatArray = (pos_field - robot_pos) @ matrix((x, y, z, w))  # rows times R are R transposed times columns
    return result


class StoppedMotion(MechanismMotion, Protocol):
    """Motion of a mechanism, with the positions of the hard stops."""

    @property
    def stops(self) -> tuple[float, float]:
        """Positions of the lower and upper hard stop [rad]; infinite without a stop."""
        ...


def is_deployed(position: float, stops: tuple[float, float], deployed_at: Literal["upper", "lower"]) -> bool:
    """Return whether `position` [rad] is in the last fifth of the travel to the stop `deployed_at`."""
    low, high = stops
    fraction = (position - low) / (high - low)
    return fraction > _DEPLOYED if deployed_at == "upper" else fraction < 1.0 - _DEPLOYED


@dataclass(frozen=True, slots=True, kw_only=True)
class IntakeConfig:
    """Config of an intake: zone, roller and deployment."""

    zone: IntakeZone
    """Zone in the robot frame, or in the frame after the last of `joints`."""
    roller: str | None = None
    """Name of the roller mechanism that pulls in pieces; None for an intake without a roller."""
    roller_speed: float = math.tau
    """Roller speed in the intake direction above which the intake takes in pieces [rad/s]."""
    roller_reversed: bool = False
    """Whether the roller pulls in pieces when the mechanism turns backward."""
    deploy: str | None = None
    """Name of the mechanism that deploys the intake; None for an intake that is always deployed."""
    deployed_at: Literal["upper", "lower"] = "upper"
    """Hard stop of `deploy` at which the intake is deployed."""
    joints: tuple[Joint, ...] = ()
    """Joints that move the zone; empty for a zone fixed to the robot."""
    stretch: Joint | None = None
    """Slide joint that extends the zone along the joint axis; None for a zone of constant size. `zone` is
    the zone at shaft angle zero."""
    storage: str = ""
    """Name of the storage that the intake fills; empty for the robot's first storage."""
    kinds: tuple[str, ...] = ()
    """Kinds of pieces that the intake takes; empty for all kinds."""

    def __post_init__(self) -> None:
        require_fields(self, roller_speed=TURN_RATE)
        if self.stretch is not None and not self.stretch.slides:
            raise ConfigError("IntakeConfig: stretch must be a joint that slides")

    @property
    def mechanism_names(self) -> tuple[str | None, ...]:
        """Names of the mechanisms that the intake uses; None in place of a missing roller, deployment or stretch."""
        stretch = None if self.stretch is None else self.stretch.mechanism
        return (self.roller, self.deploy, stretch, *(joint.mechanism for joint in self.joints))


class Intake:
    """Intake of a robot, with the zone at the current positions of the mechanisms.

    Args:
        config: Config of the intake.
        mechanisms: Mechanisms of the robot, by name.

    Raises:
        UnknownNameError: If the config names a mechanism that the robot does not have.
        ConfigError: If `deploy` has no hard stops.
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
        """Whether the intake is deployed, and the roller, if any, turns inward faster than `roller_speed`."""
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
        """Corners of the zone at the current extension with the smallest and largest coordinates [m].

        The frame is the frame after the last of `IntakeConfig.joints`, or the robot frame without joints.
        """
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
        """Zone at the current extension, in the frame after the last joint."""
        (a, b, c), (d, e, f) = self.corners
        return IntakeZone(x_min=a, x_max=d, y_min=b, y_max=e, z_min=c, z_max=f)

    @property
    def around(self) -> tuple[Vector, Vector, float]:
        """Bounding sphere of the zone: center a tick ago, current center and radius, robot frame [m]."""
        middle, radius = _ball(*self.corners)
        if not self.config.joints:
            return middle, middle, radius
        part = part_pose(self.config.joints, self._mechanisms)
        return on_part(self._part_before or part, middle), on_part(part, middle), radius

    def pass_tick(self) -> None:
        """Record the current pose of the zone; call this method in a tick without a call of `captured`."""
        if self.config.joints:
            self._part_before = part_pose(self.config.joints, self._mechanisms)

    def captured(self, prev_robot: FloatArray, now_robot: FloatArray) -> BoolArray:
        """Return whether the intake takes in each piece, and record the current pose of the zone.

        An active intake takes in pieces that are in the zone or passed through the zone in this tick. Call either this
        method or `pass_tick` once per tick.

        Args:
            prev_robot: Centers of the pieces a tick ago, in the robot frame of that time [m], shape (n, 3).
            now_robot: Current centers of the pieces, in the current robot frame [m], shape (n, 3).

        Returns:
            Mask, shape (n,); all False while the intake is inactive.
        """
        before = self._part_before
        self._part_before = part = None if not self.config.joints else part_pose(self.config.joints, self._mechanisms)
        if not len(now_robot) or not self.is_active:
            return np.zeros(len(now_robot), dtype=np.bool_)
        if part is not None:
            prev_robot, now_robot = _into(prev_robot, before or part), _into(now_robot, part)
        return _swept(*self.corners, prev_robot, now_robot)


def on_part(part: tuple[Vector, Quaternion], point: Vector) -> Vector:
    """Transform a point [m] from the frame of a part to the reference frame of the part's pose."""
    (x, y, z), quat = part
    dx, dy, dz = rotate(quat, point)
    return x + dx, y + dy, z + dz


def _into(points: FloatArray, part: tuple[Vector, Quaternion]) -> FloatArray:
    pos, quat = part
    moved: FloatArray = points - np.array(pos)
    return moved if quat is IDENTITY else moved @ matrix(quat)
