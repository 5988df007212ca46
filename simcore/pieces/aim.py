"""Aim a whole robot: the muzzle moves with the direction that is looked for, so solve, turn and solve again."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

from simcore.errors import NonFiniteError
from simcore.pieces.launch import LaunchParameters, muzzle_offset
from simcore.pieces.shot_solver import NoShotError, Shot, solve_shot
from simcore.typing import FloatArray
from simcore.units import plain_sum

__all__ = ["aim_robot"]

_Vector: TypeAlias = Sequence[float] | FloatArray
_CLOSE_ENOUGH = 1e-4  # yaw from one round to the next [rad]: 20 um at the muzzle


def aim_robot(
    launch: LaunchParameters,
    target: _Vector,
    *,
    robot_pos: _Vector,
    robot_velocity: _Vector = (0.0, 0.0, 0.0),
    yaw_rate: float = 0.0,
    robot_yaw: float | None = None,
    elevation: float | None = None,
    speed: float | None = None,
    drag: float = 0.0,
    high_arc: bool = True,
    max_speed: float = math.inf,
    first_guess: float | None = None,
) -> Shot:
    """Shot of a level robot, aimed with the middle of its barrels. Two or three solves of about 1 ms each.

    Args:
        launch: Place of the launcher on the robot.
        target: The point to fall through, field frame [m], shape (3,).
        robot_pos: Origin of the robot frame, field frame [m], shape (3,).
        robot_velocity: Of that origin, field frame [m/s], shape (3,).
        yaw_rate: Counter-clockwise positive [rad/s].
        robot_yaw: With a turret, where the robot points [rad]; None if the robot itself turns to aim.
        elevation: Fixed elevation; give this or `speed` [rad].
        speed: Fixed speed [m/s].
        drag: k, from `drag_factor` [1/m].
        high_arc: With a fixed speed, which of the two elevations.
        max_speed: The launcher's best [m/s].
        first_guess: Yaw of the last shot, to save rounds [rad].

    Returns:
        A shot whose `yaw` is the field direction of the launch. Without a turret the robot has to turn to
        `shot.yaw - launch.heading`; with one, the turret to `shot.yaw - robot_yaw - launch.heading`.

    Raises:
        NoShotError: If nothing hits.
    """
    x, y, z = (float(c) for c in robot_pos)
    if not math.isfinite(x + y + z + yaw_rate + (robot_yaw or 0.0) + (first_guess or 0.0)):
        raise NonFiniteError(f"aim_robot: want finite numbers, got {robot_pos}, {yaw_rate}, {robot_yaw}, {first_guess}")
    sideways = plain_sum(launch.barrels) / len(launch.barrels)
    middle = LaunchParameters(
        height=launch.height,
        forward=launch.forward,
        pivot_x=launch.pivot_x,
        pivot_y=launch.pivot_y,
        heading=launch.heading,
        barrels=(sideways,),
    )
    yaw = math.atan2(float(target[1]) - y, float(target[0]) - x) if first_guess is None else first_guess
    last_move = last_change = 0.0
    for _ in range(20):
        heading = yaw - launch.heading if robot_yaw is None else robot_yaw
        offset = muzzle_offset(middle, 0, yaw - launch.heading - heading)
        c, s = math.cos(heading), math.sin(heading)
        ahead, left = float(offset[0]), float(offset[1])
        east, north = c * ahead - s * left, s * ahead + c * left
        shot = solve_shot(
            (x + east, y + north, z + launch.height),
            target,
            elevation=elevation,
            speed=speed,
            drag=drag,
            robot_velocity=robot_velocity,
            yaw_rate=yaw_rate,
            muzzle_offset=(east, north, launch.height),
            high_arc=high_arc,
            max_speed=max_speed,
        )
        change = math.remainder(shot.yaw - yaw, math.tau)
        if abs(change) < _CLOSE_ENOUGH:
            return shot
        # Secant on "change = 0"; the first round, and any that would overshoot, just takes the new yaw.
        slope = (change - last_change) / last_move if last_move != 0.0 else -1.0
        last_move, last_change = (-change / slope if -2.0 < slope < -0.5 else change), change
        yaw += last_move
    raise NoShotError(
        "the muzzle moves as far as the aim turns; too close to the target",
        distance=math.hypot(float(target[0]) - x, float(target[1]) - y),
        height=float(target[2]) - z - launch.height,
    )
