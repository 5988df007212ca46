"""Where a piece leaves the robot, and how fast, when robot and turret move: one formula for one launch or for n.

Conventions: robot x forward, y left, z up; yaw counter-clockwise positive; elevation positive up from the horizontal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from simcore.geometry.rotation import matrix
from simcore.quantities import ANGLE, ROBOT_HEIGHT, ROBOT_PLACE, Quantity, require, require_fields
from simcore.typing import FloatArray

__all__ = ["Aim", "LaunchParameters", "launch_direction", "launch_state", "muzzle_offset", "to_field"]


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


def launch_direction(yaw: float | FloatArray, elevation: float | FloatArray) -> FloatArray:
    """Unit vectors of directions, shape (3,), or (n, 3) of arrays."""
    level = np.cos(elevation)
    return _vectors(level * np.cos(yaw), level * np.sin(yaw), np.sin(elevation))


def muzzle_offset(
    launch: LaunchParameters, barrel: int | npt.NDArray[np.int64] = 0, turret_angle: float | FloatArray = 0.0
) -> FloatArray:
    """From the robot's origin to muzzles, robot frame [m], shape (3,), or (n, 3) of arrays."""
    yaw = launch.heading + turret_angle
    ahead, left = launch.forward, np.array(launch.barrels)[barrel]
    c, s = np.cos(yaw), np.sin(yaw)
    return _vectors(launch.pivot_x + c * ahead - s * left, launch.pivot_y + s * ahead + c * left, launch.height)


def launch_state(
    launch: LaunchParameters,
    *,
    elevation: float | FloatArray,
    speed: float | FloatArray,
    robot_pos: npt.ArrayLike,
    robot_rotation: npt.ArrayLike,
    robot_velocity: npt.ArrayLike,
    robot_spin: npt.ArrayLike = (0.0, 0.0, 0.0),
    turret_angle: float | FloatArray = 0.0,
    turret_rate: float | FloatArray = 0.0,
    barrel: int | npt.NDArray[np.int64] = 0,
) -> tuple[FloatArray, FloatArray]:
    """Position and velocity of pieces at the moment they leave a robot that may pitch and roll.

    v = v_exit + v_turret + v_chassis + omega x r; the last term is what a robot that turns adds. Each argument is of
    one launch, or of n.

    Args:
        launch: Place of the launcher.
        elevation: Over the robot's floor plane [rad].
        speed: Relative to the muzzle [m/s].
        robot_pos: Origin of the robot frame, field frame [m], shape (3,) or (n, 3).
        robot_rotation: Robot to field, quaternion xyzw, shape (4,) or (n, 4).
        robot_velocity: Of the robot's origin, field frame [m/s], shape (3,) or (n, 3).
        robot_spin: Angular velocity, field axes [rad/s], shape (3,) or (n, 3).
        turret_angle: Counter-clockwise positive [rad].
        turret_rate: Rate of the turret against the robot, which carries the muzzle round its pivot [rad/s].
        barrel: Which one.

    Returns:
        Position [m] and velocity [m/s] in the field frame, shape (3,) or (n, 3) each.
    """
    offset = muzzle_offset(launch, barrel, turret_angle)
    arm = offset - (launch.pivot_x, launch.pivot_y, 0.0)
    carried = _vectors(-turret_rate * arm[..., 1], turret_rate * arm[..., 0], 0.0)
    exit_velocity = np.asarray(speed)[..., None] * launch_direction(launch.heading + turret_angle, elevation) + carried
    muzzle = to_field(robot_rotation, offset)
    velocity = to_field(robot_rotation, exit_velocity) + robot_velocity + np.cross(robot_spin, muzzle)
    return robot_pos + muzzle, velocity


def to_field(robot_rotation: npt.ArrayLike, vectors: FloatArray) -> FloatArray:
    """Vectors of the robot's axes in the field's, by quaternions xyzw; shape (3,) and (4,), or (n, 3) and (n, 4)."""
    turned: FloatArray = np.einsum("ij...,...j->...i", matrix(np.asarray(robot_rotation).T), vectors)
    return turned


def _vectors(x: float | FloatArray, y: float | FloatArray, z: float | FloatArray) -> FloatArray:
    """Vectors of coordinates, shape (3,), or (n, 3) where one of them is an array."""
    return np.stack(np.broadcast_arrays(x, y, z), axis=-1)
