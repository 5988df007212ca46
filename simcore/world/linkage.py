"""Kinematics of a robot's moving parts: a chain of joints from the robot frame to the part.

An elevator is a slide joint, and an arm is a hinge joint. A claw on an arm on an elevator has a chain of a slide joint
and a hinge joint. The chain determines the poses of drawn parts and intake zones, and the pose and velocity of a held
game piece.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from simcore.errors import ConfigError, UnknownNameError
from simcore.quantities import RATIO, ROBOT_PLACE, require_fields
from simcore.world.rotation import IDENTITY, Quaternion, Vector, multiply, rotate

__all__ = ["Joint", "MechanismMotion", "PartState", "part_pose", "part_state", "require_mechanisms"]


class MechanismMotion(Protocol):
    """Position and velocity of a mechanism that drives a joint."""

    @property
    def position(self) -> float:
        """Angle of the mechanism's shaft [rad]."""
        ...

    @property
    def velocity(self) -> float:
        """Angular velocity of the mechanism's shaft [rad/s]."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """Hinge or slide joint in a chain of joints, driven by a mechanism."""

    mechanism: str
    """Name of the mechanism that drives the joint."""
    axis: Vector
    """Axis of a hinge (right-hand rule) or direction of a slide: unit vector in the frame before the joint."""
    origin: Vector = (0.0, 0.0, 0.0)
    """Origin of the joint at shaft angle zero, in the frame before the joint [m]."""
    slides: bool = False
    """Whether the joint is a slide joint; otherwise the joint is a hinge joint."""
    ratio: float = 1.0
    """Angle of a hinge [rad/rad] or travel of a slide [m/rad] per angle of the mechanism's shaft."""

    def __post_init__(self) -> None:
        owner = f"Joint of {self.mechanism!r}"
        require_fields(self, owner, axis=(RATIO,) * 3, origin=(ROBOT_PLACE,) * 3, ratio=RATIO)
        if not math.isclose(math.hypot(*self.axis), 1.0, abs_tol=1e-6):
            raise ConfigError(f"{owner}: axis must be a unit vector, got {self.axis}")


class PartState(NamedTuple):
    """Pose and velocity of a part or a robot, in the robot frame unless stated otherwise."""

    pos: Vector
    """Position of the origin [m]."""
    quat: Quaternion
    """Attitude: rotation from part axes to robot axes, unit quaternion x, y, z, w."""
    vel: Vector
    """Velocity of the origin [m/s]."""
    rate: Vector
    """Angular velocity [rad/s]."""


def part_pose(
    joints: Sequence[Joint], mechanisms: Mapping[str, MechanismMotion], offset: Vector = (0.0, 0.0, 0.0)
) -> tuple[Vector, Quaternion]:
    """Compute the position [m] and attitude of a part in the robot frame.

    Args:
        joints: Joints from the robot outward; empty for a fixed part.
        mechanisms: Mechanisms by name.
        offset: Position of the part in the frame after the last joint [m].
    """
    x = y = z = 0.0
    quat = IDENTITY
    for joint in joints:
        travel = joint.ratio * mechanisms[joint.mechanism].position
        ox, oy, oz = joint.origin
        if joint.slides:
            ax, ay, az = joint.axis
            ox, oy, oz = ox + travel * ax, oy + travel * ay, oz + travel * az
        if quat is not IDENTITY:
            ox, oy, oz = rotate(quat, (ox, oy, oz))
        x, y, z = x + ox, y + oy, z + oz
        if not joint.slides:
            turn = _turn(joint.axis, travel)
            quat = turn if quat is IDENTITY else multiply(quat, turn)
    ox, oy, oz = offset if quat is IDENTITY else rotate(quat, offset)
    return (x + ox, y + oy, z + oz), quat


def part_state(
    joints: Sequence[Joint], mechanisms: Mapping[str, MechanismMotion], offset: Vector = (0.0, 0.0, 0.0)
) -> PartState:
    """Compute the pose and velocity of a part in the robot frame; `part_pose` describes the arguments."""
    (x, y, z), quat = part_pose(joints, mechanisms, offset)
    vx = vy = vz = wx = wy = wz = 0.0
    for number, joint in enumerate(joints):
        here, before = part_pose(joints[:number], mechanisms, joint.origin)
        axis = rotate(before, joint.axis)
        speed = joint.ratio * mechanisms[joint.mechanism].velocity
        ax, ay, az = axis[0] * speed, axis[1] * speed, axis[2] * speed
        if joint.slides:
            vx, vy, vz = vx + ax, vy + ay, vz + az
        else:
            rx, ry, rz = x - here[0], y - here[1], z - here[2]
            vx, vy, vz = vx + ay * rz - az * ry, vy + az * rx - ax * rz, vz + ax * ry - ay * rx
            wx, wy, wz = wx + ax, wy + ay, wz + az
    return PartState((x, y, z), quat, (vx, vy, vz), (wx, wy, wz))


def require_mechanisms(owner: str, names: Iterable[str | None], known: Iterable[str]) -> None:
    """Check that all mechanism names in a config, except None, are in `known`.

    Raises:
        UnknownNameError: If a name is not in `known`; the message contains `owner`, the name of the config.
    """
    known = list(known)
    for name in names:
        if name is not None and name not in known:
            raise UnknownNameError(f"mechanism (for {owner})", name, known)


def _turn(axis: Vector, angle: float) -> Quaternion:
    half = 0.5 * math.fmod(angle, 4.0 * math.pi)
    s = math.sin(half)
    return axis[0] * s, axis[1] * s, axis[2] * s, math.cos(half)
