"""Driver's course for any swerve robot: stand, 5 m across the field, into fuel, against the wall, every button.

The driver watches the robot, so sticks are rotated where the odometry heading differs from the true one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from wpilib.simulation import DriverStationSim

import simcore.robotcode.makers.phoenix6.swerve as swerve

WAY = 5.0  # [m]
FIELD_WIDTH = 8.069  # [m]
DEPOT_Y = 5.96  # [m]
A, X, Y = 1, 3, 4


class Course:
    """One run of a robot over the course.

    Args:
        physics: Simcore's physics of the robot program.
        is_field_centric: Whether the program's sticks are field-centric by its odometry, not robot-centric.
        enable: Function that starts teleop.
    """

    def __init__(self, physics: Any, *, is_field_centric: bool, enable: Callable[[], None]) -> None:
        self.physics = physics
        self.chassis = physics.robot_sim.chassis
        self.drivetrain = swerve.only_drivetrain()
        self.is_field_centric = is_field_centric
        self.enable = enable
        self.results: dict[str, Any] = {}

    def run(self) -> Iterator[None]:
        """Play the course, one tick of 20 ms at each `next`."""
        DriverStationSim.setJoystickAxisCount(0, 6)
        DriverStationSim.setJoystickButtonCount(0, 10)
        DriverStationSim.setJoystickPOVCount(0, 1)
        self.push(0.0, 0.0)
        yield from self.stand(15)
        self.enable()
        yield from self.stand(15)
        yield from self.across()
        yield from self.through_fuel()
        yield from self.against_the_wall()
        yield from self.mechanisms()
        self.take_stock()

    def believed(self) -> tuple[float, float, float]:
        pose = self.drivetrain.get_state().pose
        return pose.X(), pose.Y(), pose.rotation().radians()

    # --- parts of the course ------------------------------------------------------------------------------------------

    def stand(self, ticks: int) -> Iterator[None]:
        """Record the drift of odometry from the truth while the robot stands."""
        true, told = self.chassis.pose, self.believed()
        for _ in range(ticks):
            yield
            way, thought = self.since(self.chassis.pose, true), self.since(self.believed(), told)
            crept = max(self.results.get("crept", 0.0), math.dist(way, thought))
            self.results["crept"] = crept

    def across(self) -> Iterator[None]:
        true, told = self.chassis.pose, self.believed()
        self.results["start"], self.results["believed_start"] = true, told
        for _ in range(250):
            self.push(0.0, 0.7)
            yield
            if math.dist(self.chassis.pose[:2], true[:2]) > WAY:
                break
        self.push(0.0, 0.0)
        for _ in range(30):
            yield
        self.results["true_way"] = math.dist(self.chassis.pose[:2], true[:2])
        self.results["off"] = math.dist(self.since(self.chassis.pose, true), self.since(self.believed(), told))

    def through_fuel(self) -> Iterator[None]:
        before = self.physics.match.piece_positions()["Fuel"].copy()
        for _ in range(120):
            self.push(-0.4, min(max(DEPOT_Y - self.chassis.pose[1], -0.4), 0.4))
            yield
            if self.chassis.pose[0] < 0.75:
                break
        after = self.physics.match.piece_positions()["Fuel"]
        moved = np.linalg.norm(after - before[: len(after)], axis=1) > 0.02
        self.results["pushed"] = len(before) - len(after) + int(moved.sum())
        for _ in range(100):
            self.push(0.5, 0.0)
            yield
            if self.chassis.pose[0] > 2.0:
                break

    def against_the_wall(self) -> Iterator[None]:
        farthest, bumper, places = 0.0, self.chassis.config, []
        for _ in range(150):
            self.push(0.0, 0.6)
            yield
            _, y, yaw = self.chassis.pose
            corner = 0.5 * (bumper.bumper_width * abs(math.cos(yaw)) + bumper.bumper_length * abs(math.sin(yaw)))
            farthest = max(farthest, y + corner)
            places.append(y)
        self.results["gap_at_wall"] = FIELD_WIDTH - farthest
        # mean of the last second: pushing with all its grip the robot rattles by 1 mm at up to 0.09 m/s
        self.results["speed_at_wall"] = abs(self.chassis.pose[1] - places[-50])

    def mechanisms(self) -> Iterator[None]:
        """Record the program's `facts` after 1.5 s with its buttons pressed, and 2 s after their release."""
        self.push(0.0, 0.0)
        robot = self.physics.robot
        for pressed, ticks, name in ((True, 75, "pressed"), (False, 100, "released")):
            for button in (A, X, Y):
                DriverStationSim.setJoystickButton(0, button, pressed)
            DriverStationSim.notifyNewData()
            for _ in range(ticks):
                yield
            self.results[name] = robot.facts() if hasattr(robot, "facts") else {}

    def take_stock(self) -> None:
        match = self.physics.match
        count = match.count
        self.results["staged"] = count.staged
        on_field = count.on_field + count.in_flight + count.placed
        self.results["counted"] = on_field + count.held + count.scored + count.off_field
        self.results["taken_in"], self.results["shots"] = len(match.record.taken_in), len(match.record.shots)

    # --- sticks -------------------------------------------------------------------------------------------------------

    def push(self, ahead: float, left: float) -> None:
        """Set the sticks to drive along the field axes with the heading held at zero."""
        yaw = self.chassis.pose[2]
        frame = self.believed()[2] - yaw if self.is_field_centric else -yaw
        x = ahead * math.cos(frame) - left * math.sin(frame)
        y = ahead * math.sin(frame) + left * math.cos(frame)
        turn = min(max(-0.8 * math.remainder(yaw, math.tau), -0.5), 0.5) if (ahead or left) else 0.0
        for axis, value in ((0, -y), (1, -x), (4, -turn)):
            DriverStationSim.setJoystickAxis(0, axis, min(max(value, -1.0), 1.0))
        DriverStationSim.notifyNewData()

    @staticmethod
    def since(pose: tuple[float, float, float], start: tuple[float, float, float]) -> tuple[float, float]:
        """Return the displacement from a start, in the axes of the start heading."""
        dx, dy = pose[0] - start[0], pose[1] - start[1]
        c, s = math.cos(start[2]), math.sin(start[2])
        return c * dx + s * dy, c * dy - s * dx
