"""Where a piece leaves the robot, and how fast, when robot and turret move.

Conventions: robot x forward, y left, z up; yaw counter-clockwise positive; elevation positive up from the horizontal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.geometry.rotation import matrix
from simcore.quantities import ANGLE, ROBOT_HEIGHT, ROBOT_PLACE, Quantity, require, require_fields
from simcore.typing import FloatArray

__all__ = [
    "Aim",
    "LaunchParameters",
    "launch_direction",
    "launch_state",
    "muzzle_offset",
    "muzzle_velocity",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class LaunchParameters:
    """Place of a launcher on the robot. With a turret, the muzzle turns about the pivot."""

    height: float
    """Of the piece's center as it leaves, over the robot's origin [m]."""
    forward: float = 0.0
    """From the pivot to the muzzle, along the launch direction [m]."""
    pivot_x: float = 0.0
    """Of the turret's axis, robot frame [m]; without a turret the robot's center is as good."""
    pivot_y: float = 0.0
    """Of the turret's axis, robot frame [m]."""
    heading: float = 0.0
    """Launch direction in the robot frame at turret angle zero: pi shoots out of the back [rad]."""
    barrels: tuple[float, ...] = (0.0,)
    """Sideways offset of each barrel, left positive [m]."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            height=ROBOT_HEIGHT,
            forward=ROBOT_PLACE,
            pivot_x=ROBOT_PLACE,
            pivot_y=ROBOT_PLACE,
            heading=ANGLE,
            barrels=[ROBOT_PLACE],
        )
        require("LaunchParameters", "number of barrels", len(self.barrels), Quantity("", 1, 100, is_whole=True))


@dataclass(frozen=True, slots=True)
class Aim:
    """Speed and direction of a launch at one instant, relative to the robot."""

    elevation: float
    """Over the robot's floor plane [rad]."""
    speed: float
    """Relative to the muzzle [m/s]."""
    turret_angle: float = 0.0
    """Counter-clockwise positive [rad]."""
    turret_rate: float = 0.0
    """Rate of the turret against the robot, which carries the muzzle round its pivot [rad/s]."""


def launch_direction(yaw: float, elevation: float) -> FloatArray:
    """Unit vector of a direction, shape (3,)."""
    level = math.cos(elevation)
    return np.array([level * math.cos(yaw), level * math.sin(yaw), math.sin(elevation)])


def muzzle_offset(launch: LaunchParameters, barrel: int = 0, turret_angle: float = 0.0) -> FloatArray:
    """From the robot's origin to a muzzle, robot frame [m], shape (3,)."""
    yaw = launch.heading + turret_angle
    ahead, left = launch.forward, launch.barrels[barrel]
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([launch.pivot_x + c * ahead - s * left, launch.pivot_y + s * ahead + c * left, launch.height])


def muzzle_velocity(
    exit_velocity: FloatArray,
    chassis_velocity: FloatArray,
    yaw_rate: float | FloatArray,
    muzzle: FloatArray,
) -> FloatArray:
    """Velocity of a piece as it leaves a launcher on a moving robot.

    v = v_exit + v_chassis + omega x r; the last term is what a spinning robot adds.

    Args:
        exit_velocity: Relative to the muzzle, field axes [m/s], shape (3,).
        chassis_velocity: Of the robot center, field frame [m/s], shape (3,).
        yaw_rate: Counter-clockwise positive, or the whole angular velocity, shape (3,) [rad/s].
        muzzle: From robot center to muzzle, field axes [m], shape (3,).

    Returns:
        Field-frame velocity [m/s], shape (3,).
    """
    if isinstance(yaw_rate, np.ndarray):
        turning = _cross(yaw_rate, muzzle)
    else:
        turning = np.array([-yaw_rate * muzzle[1], yaw_rate * muzzle[0], 0.0])
    return exit_velocity + chassis_velocity + turning


def launch_state(
    launch: LaunchParameters,
    aim: Aim,
    *,
    robot_pos: FloatArray,
    robot_rotation: FloatArray,
    robot_velocity: FloatArray,
    robot_spin: FloatArray,
    barrel: int = 0,
) -> tuple[FloatArray, FloatArray]:
    """Position and velocity of a piece at the moment it leaves a robot that may pitch and roll.

    Args:
        launch: Place of the launcher.
        aim: Speed and direction relative to the robot.
        robot_pos: Origin of the robot frame, field frame [m], shape (3,).
        robot_rotation: Robot to field, quaternion xyzw, shape (4,); yaw alone is (0, 0, sin(yaw/2), cos(yaw/2)).
        robot_velocity: Of the robot's origin, field frame [m/s], shape (3,).
        robot_spin: Angular velocity, field axes [rad/s], shape (3,).
        barrel: Which one.

    Returns:
        Position [m] and velocity [m/s] in the field frame, shape (3,) each.
    """
    robot_to_field = matrix(robot_rotation)
    offset = muzzle_offset(launch, barrel, aim.turret_angle)
    muzzle = robot_to_field @ offset
    exit_velocity = aim.speed * launch_direction(launch.heading + aim.turret_angle, aim.elevation)
    if aim.turret_rate != 0.0:
        ahead, left, _ = (offset - np.array([launch.pivot_x, launch.pivot_y, 0.0])).tolist()
        exit_velocity += np.array([-aim.turret_rate * left, aim.turret_rate * ahead, 0.0])
    exit_velocity = robot_to_field @ exit_velocity
    return robot_pos + muzzle, muzzle_velocity(exit_velocity, robot_velocity, robot_spin, muzzle)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross product of two vectors; np.cross takes ten times as long for one pair."""
    ax, ay, az = a.tolist()
    bx, by, bz = b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
