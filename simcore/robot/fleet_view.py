"""Telemetry values of all robots of a match, computed in one compiled call from the arrays of the loop."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from simcore.loop.compiled import compiled, inlined
from simcore.loop.robot_state import TARGET, Fleet, Records
from simcore.robot.robot import Robot
from simcore.robot.swerve_drive import NO_STATES, SwerveDrive
from simcore.typing import FloatArray, IntArray

__all__ = ["FleetView"]


class FleetView:
    """Telemetry of n robots: poses, wheel heights, tire slip, pose estimates and module states.

    Args:
        robots: All robots of the match.
    """

    def __init__(self, robots: Sequence[Robot]) -> None:
        self._robots, count = robots, len(robots)
        soles = [robot.chassis.soles[:, :2] for robot in robots]
        self._soles, self._first_sole = np.concatenate(soles), np.cumsum([0, *map(len, soles)])
        modules = [len(robot.drive.wheel_records) * isinstance(robot.drive, SwerveDrive) for robot in robots]
        self._first_module = np.cumsum([0, *modules])
        self._spans = [
            slice(end - size, end) for end, size in zip(self._first_module[1:].tolist(), modules, strict=True)
        ]
        self._has_targets = np.zeros(count, np.uint8)
        self.places = np.empty((count, 7))
        """Pose of each robot, field frame: x, y, z [m] and quaternion w, x, y, z, shape (n, 7)."""
        self.heights = np.empty(count)
        """Height above z = 0 of the lowest point of each robot's wheels [m], shape (n,)."""
        self.slips = np.empty(count)
        """Slip speed of each robot's fastest sliding tire [m/s], shape (n,); 0 for a robot without a sliding tire."""
        self.believed = np.zeros((count, 7))
        """Pose estimates (`Robot.believed_pose`) in the format of `places`, shape (n, 7).

        Rounding to 1 mm and 1 mrad hides gyro noise at rest.
        """
        self.module_states: list[FloatArray | None] = []
        """Module states of each robot from the encoders; None for a robot without a swerve drive.

        Rows are wheel speed [m/s] and steer angle [rad] of each module, rounded to 1 mm/s and 1 mrad.
        """
        self.module_setpoints: list[FloatArray | None] = []
        """Module setpoints of each robot, in the format of `module_states`; None for a robot without a swerve drive.

        The setpoints are those of robot code (`Robot.module_setpoints`) or otherwise the targets of the on-board loops.
        The array has no rows if neither exists.
        """

    def look(self, fleet: Fleet, bodies: Records) -> None:
        """Update all values from the loop's current records of robots (`fleet`) and bodies."""
        states, targets = np.empty((2, int(self._first_module[-1]), 2))
        believed = np.array([robot.believed_pose for robot in self._robots])
        _look(
            fleet.robots, bodies, fleet.shafts, fleet.wheels, believed, self._soles, self._first_sole,
            self._first_module, self.places, self.heights, self.slips, self.believed, states, targets,
            self._has_targets,
        )  # fmt: skip
        states.setflags(write=False)
        targets.setflags(write=False)
        self.module_states = [states[span] if span.stop > span.start else None for span in self._spans]
        self.module_setpoints = [
            None if span.stop == span.start
            else _settled(robot.module_setpoints) if robot.module_setpoints is not None
            else targets[span] if has_targets else NO_STATES
            for robot, span, has_targets in zip(self._robots, self._spans, self._has_targets.tolist(), strict=True)
        ]  # fmt: skip


def _settled(rows: FloatArray) -> FloatArray:
    """Return a read-only copy of module states, rows (speed, angle), rounded by `_shown_state`, shape (n, 2)."""
    found = np.empty((len(rows), 2))
    for number, (speed, angle) in enumerate(rows.tolist()):
        found[number] = _shown_state(speed, angle)
    found.setflags(write=False)
    return found


@inlined
def _rounded(value: float, scale: float) -> float:
    """Round a value to a multiple of 1 / scale, and return 0.0 in place of -0.0, for stable telemetry."""
    rounded: float = np.rint(value * scale) / scale + 0.0
    return rounded


@compiled
def _shown_state(speed: float, angle: float) -> tuple[float, float]:
    """Round a module state to 1 mm/s and 1 mrad, and wrap the angle to -pi..pi."""
    return _rounded(speed, 1e3), _rounded(math.atan2(math.sin(angle), math.cos(angle)), 1e3)


@compiled
def _look(
    robots: Records,
    bodies: Records,
    shafts: Records,
    wheels: Records,
    beliefs: FloatArray,
    soles: FloatArray,
    first_sole: IntArray,
    first_module: IntArray,
    places: FloatArray,
    heights: FloatArray,
    slips: FloatArray,
    believed: FloatArray,
    states: FloatArray,
    targets: FloatArray,
    has_targets: npt.NDArray[np.uint8],
) -> None:
    """Write the values of `FleetView` to the arrays from `places` to `has_targets`.

    `states` and `targets` have one row per swerve module: states from the encoders, and targets of the on-board loops.
    `has_targets` has one value per robot: whether the on-board loops have targets.
    """
    for number in range(len(robots)):
        robot = robots[number]
        body = bodies[robot["model"]["body"]]
        pos, quat = body["pos"], body["quat"]
        x, y, z, w = quat[0], quat[1], quat[2], quat[3]
        place = places[number]
        place[0], place[1], place[2] = pos[0], pos[1], pos[2]
        place[3], place[4], place[5], place[6] = w, x, y, z
        along, across = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x)  # z components of the robot's x and y axes
        height = math.inf
        for k in range(first_sole[number], first_sole[number + 1]):
            height = min(height, soles[k, 0] * along + soles[k, 1] * across + pos[2])
        heights[number] = height
        slip = 0.0
        if robot["is_sliding"]:
            for k in range(robot["model"]["first_wheel"], robot["model"]["last_wheel"]):
                slip = max(slip, wheels[k]["slip"])
        slips[number] = slip
        yaw = _rounded(beliefs[number, 2], 1e3)
        believed[number, 0], believed[number, 1] = _rounded(beliefs[number, 0], 1e3), _rounded(beliefs[number, 1], 1e3)
        believed[number, 3], believed[number, 6] = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
        first, last = first_module[number], first_module[number + 1]
        shaft = robot["model"]["first_shaft"]
        is_told = last > first and robot["request"]["is_enabled"] and shafts[shaft]["request"]["mode"] == TARGET
        has_targets[number] = is_told
        for k in range(first, last):
            wheel, azimuth = shafts[shaft + k - first], shafts[shaft + k - first + last - first]
            speed = wheel["speed"] * wheel["model"]["known_radius"]
            states[k, 0], states[k, 1] = _shown_state(speed, azimuth["position"])
            if is_told:
                targets[k, 0], targets[k, 1] = _shown_state(wheel["request"]["value"], azimuth["request"]["value"])
