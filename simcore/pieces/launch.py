"""Position and velocity of a game piece at launch from a moving robot and turret, for one launch or for n launches.

Conventions: robot x forward, y left, z up; yaw positive counter-clockwise; elevation positive up from the horizontal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from simcore.quantities import ANGLE, ROBOT_HEIGHT, ROBOT_PLACE, Quantity, require, require_fields
from simcore.typing import FloatArray, IntArray
from simcore.world.rotation import matrix

__all__ = ["Aim", "Launch", "LaunchParameters", "launch_direction", "launch_state", "muzzle_offset", "to_field"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LaunchParameters:
    """Position of a launcher on the robot; a turret turns the muzzle about the pivot axis."""

    height: float
    """Height of the piece's center at launch above the robot's origin [m]."""
    forward: float = 0.0
    """Distance from the pivot to the muzzle, along the launch direction [m]."""
    pivot_x: float = 0.0
    """x coordinate of the pivot (turret axis), robot frame [m]; 0 is sufficient for a robot without a turret."""
    pivot_y: float = 0.0
    """y coordinate of the pivot, robot frame [m]."""
    heading: float = 0.0
    """Yaw of the launch direction in the robot frame at turret angle zero [rad]; pi for a launch to the rear."""
    barrels: tuple[float, ...] = (0.0,)
    """Sideways offset of each barrel, positive to the left [m]."""

    def __post_init__(self) -> None:
        require_fields(
            self, height=ROBOT_HEIGHT, forward=ROBOT_PLACE, pivot_x=ROBOT_PLACE, pivot_y=ROBOT_PLACE, heading=ANGLE,
            barrels=[ROBOT_PLACE],
        )  # fmt: skip
        require("LaunchParameters", "number of barrels", len(self.barrels), Quantity("", 1, 100, is_whole=True))


class Aim(NamedTuple):
    """Speed and direction of a launch relative to the robot, or of n launches, with arrays of shape (n,)."""

    elevation: float | FloatArray
    """Elevation above the robot's floor plane [rad]."""
    speed: float | FloatArray
    """Speed relative to the muzzle [m/s]."""
    turret_angle: float | FloatArray = 0.0
    """Turret angle, positive counter-clockwise [rad]."""
    turret_rate: float | FloatArray = 0.0
    """Angular velocity of the turret relative to the robot, positive counter-clockwise [rad/s]; the rotation adds to
    the velocity of the muzzle."""


class Launch(NamedTuple):
    """Launch of one piece within a tick."""

    barrel: int
    """Index into `LaunchParameters.barrels`."""
    delay: float
    """Time from the start of the tick to the launch [s]."""
    aim: Aim
    """Speed and direction relative to the robot at the launch."""
    spin: float = 1.0
    """Factor on the spin that the launcher wheels give the piece [-]."""


def launch_direction(yaw: float | FloatArray, elevation: float | FloatArray) -> FloatArray:
    """Compute the unit vector in the direction of a yaw and an elevation [rad], shape (3,), or (n, 3) for arrays."""
    level = np.cos(elevation)
    return _vectors(level * np.cos(yaw), level * np.sin(yaw), np.sin(elevation))


def muzzle_offset(
    launch: LaunchParameters, barrel: int | IntArray = 0, turret_angle: float | FloatArray = 0.0
) -> FloatArray:
    """Compute the vector from the robot's origin to the muzzle, robot frame [m], shape (3,), or (n, 3) for arrays."""
    yaw = launch.heading + turret_angle
    ahead, left = launch.forward, np.array(launch.barrels)[barrel]
    c, s = np.cos(yaw), np.sin(yaw)
    return _vectors(launch.pivot_x + c * ahead - s * left, launch.pivot_y + s * ahead + c * left, launch.height)


def launch_state(
    launch: LaunchParameters, aim: Aim, robot: Sequence[Sequence[float] | FloatArray], barrel: int | IntArray = 0
) -> tuple[FloatArray, FloatArray]:
    """Compute the position [m] and velocity [m/s] of launched pieces, field frame; the robot may pitch and roll.

    v = v_exit + v_turret + v_chassis + omega x r; the last term comes from the rotation of the robot.

    Args:
        launch: Position of the launcher.
        aim: Aim of one launch or of n launches.
        robot: Fields of a `PartState`, field frame: position of the origin [m], attitude as quaternion x, y, z, w,
            velocity [m/s] and angular velocity [rad/s]; for one robot, or shapes (n, 3) and (n, 4).
        barrel: Index of the barrel, or of each launch's barrel, shape (n,).
    """
    pos, quat, vel, rate = (np.asarray(one, dtype=np.float64) for one in robot)
    offset = muzzle_offset(launch, barrel, aim.turret_angle)
    arm = offset - (launch.pivot_x, launch.pivot_y, 0.0)
    carried = _vectors(-aim.turret_rate * arm[..., 1], aim.turret_rate * arm[..., 0], 0.0)
    leaves = np.asarray(aim.speed)[..., None] * launch_direction(launch.heading + aim.turret_angle, aim.elevation)
    muzzle = to_field(quat, offset)
    return pos + muzzle, to_field(quat, leaves + carried) + vel + np.cross(rate, muzzle)


def to_field(robot_rotation: Sequence[float] | FloatArray, vectors: FloatArray) -> FloatArray:
    """Rotate vectors from robot to field axes.

    Args:
        robot_rotation: Attitude as quaternion x, y, z, w, shape (4,) or (n, 4).
        vectors: Vectors in robot axes, shape (3,) or (n, 3).
    """
    turned: FloatArray = np.einsum("ij...,...j->...i", matrix(np.asarray(robot_rotation).T), vectors)
    return turned


def _vectors(x: float | FloatArray, y: float | FloatArray, z: float | FloatArray) -> FloatArray:
    """Return vectors with the given coordinates, shape (3,), or (n, 3) if any coordinate is an array."""
    return np.stack(np.broadcast_arrays(x, y, z), axis=-1)
