"""Outlines that referees look at: bumpers, frame perimeters, what reaches out of them, and who stands on whom."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from simcore.geometry.footprints import corners, overlaps
from simcore.geometry.rotation import rotate
from simcore.robot.robot import Robot
from simcore.robot.wheel_ground import ground_clearance
from simcore.typing import FloatArray

if TYPE_CHECKING:
    from simcore.match.game import PlayedMatch

__all__ = ["is_airborne", "is_carried", "lowest_bumper", "reaches_into", "robot_near"]


def is_airborne(robot: Robot) -> bool:
    """Whether no wheel of a robot touches what is under it."""
    return ground_clearance(*robot.chassis.wheel_ground()).is_airborne


def lowest_bumper(robot: Robot) -> float:
    """Height of the lowest point of a robot's bumpers [m]."""
    body, chassis = robot.chassis.config, robot.chassis
    x, y = 0.5 * body.bumper_length, 0.5 * body.bumper_width
    return chassis.pos[2] + min(rotate(chassis.quat, (a, b, body.clearance))[2] for a in (-x, x) for b in (-y, y))


def robot_near(robots: Sequence[Robot], place: FloatArray, reach: float) -> int:
    """Number of the first robot whose bumpers are within so much of a place, field frame [m], shape (2,); -1: none."""
    for robot in robots:
        body = robot.chassis.config
        size = body.bumper_length + 2.0 * reach, body.bumper_width + 2.0 * reach
        if overlaps(corners(*robot.chassis.pose, *size), place[None]):
            return robot.number
    return -1


def is_carried(match: PlayedMatch, number: int, by: int) -> bool:
    """Whether a robot that touches another one is fully carried by it: it is above it, and touches nothing else."""
    above, below = match.robots[number], match.robots[by]
    is_higher = above.chassis.pos[2] > below.chassis.pos[2] + above.chassis.config.clearance
    return is_higher and is_airborne(above) and not match.contacts.elements(number)


def reaches_into(robot: Robot, other: Robot) -> bool:
    """Whether an intake that is out of a robot's bumpers is inside of another robot's frame perimeter."""
    body, frame = other.chassis.config, 2.0 * other.chassis.config.bumper_thickness
    perimeter = corners(*other.chassis.pose, body.bumper_length - frame, body.bumper_width - frame)
    return any(overlaps(perimeter, outline) for outline in _reaching_out(robot))


def _reaching_out(robot: Robot) -> list[FloatArray]:
    """Outlines of the intakes that are out of the bumpers, as far as they are, field frame [m], shape (n, 2) each."""
    (px, py, yaw), outlines = robot.chassis.pose, []
    c, s, half = math.cos(yaw), math.sin(yaw), 0.5 * robot.chassis.config.bumper_length
    for intake in robot.intakes:
        if not intake.is_active:
            continue
        ends = np.array([intake.around[1][:2]])
        if not intake.config.joints:
            zone = intake.zone
            ends = np.array([(x, y) for x in (zone.x_min, zone.x_max) for y in (zone.y_min, zone.y_max)])[[0, 1, 3, 2]]
        if np.abs(ends[:, 0]).max() > half:
            ends[:, 0] = np.where(np.abs(ends[:, 0]) < half, np.copysign(half, ends[:, 0]), ends[:, 0])
            x, y = ends.T
            outlines.append(np.column_stack((px + c * x - s * y, py + s * x + c * y)))
    return outlines
