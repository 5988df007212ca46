"""What a script can ask of its robot: motion within limits, timeouts that end, and red turned into blue."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from games.rebuilt.scripted import ScriptedRobot

from games.rebuilt.dimensions import FIELD_LENGTH, FIELD_WIDTH
from games.rebuilt.robot import RebuiltRobotConfig

DT = 0.02


class Ideal:
    """A robot that does at once what it is told; `stuck`: one that a wall holds."""

    def __init__(self, pose, stuck=False):
        self.pose, self.stuck, self.asked = list(pose), stuck, []
        self.number = 0
        self.chassis = self
        self.drive = self
        self.config = RebuiltRobotConfig()

    def set_chassis_speeds(self, vx, vy, omega):
        x, y, yaw = self.pose
        c, s = math.cos(yaw), math.sin(yaw)
        self.asked.append((c * vx - s * vy, s * vx + c * vy, omega))
        if not self.stuck:
            field = self.asked[-1]
            self.pose = [x + field[0] * DT, y + field[1] * DT, yaw + omega * DT]


def follow(script, robot, *, alliance="blue", fuel=None, ticks=2000):
    """Play a script on the ideal robot, mechanisms left out; returns the code and the number of ticks."""
    code = ScriptedRobot(script, alliance=alliance, held=lambda n: 0, fuel_places=lambda: fuel)
    code._robot = robot
    for tick, _ in enumerate(script(code)):
        code._drive()
        if tick > ticks:
            raise AssertionError("the script does not end")
    return tick + 1


def test_it_drives_to_a_pose_and_stops_there():
    robot = Ideal((2.0, 3.0, 0.0))
    follow(lambda r: r.drive_to(4.0, 4.0, 1.0), robot)
    assert robot.pose[:2] == pytest.approx((4.0, 4.0), abs=0.08)
    assert robot.pose[2] == pytest.approx(1.0, abs=math.radians(3.5))
    assert robot.asked[-1] == (0.0, 0.0, 0.0)


def test_it_keeps_to_its_speed_and_acceleration():
    robot = Ideal((2.0, 3.0, 0.0))
    follow(lambda r: r.drive_to(7.0, 3.0, 0.0, speed=2.0), robot)
    speeds = np.array(robot.asked)[:, :2]
    assert np.linalg.norm(speeds, axis=1).max() <= 2.0 + 1e-9
    steps = np.linalg.norm(np.diff(speeds[:-1], axis=0), axis=1)
    assert steps.max() <= 6.0 * DT + 1e-9, "6 m/s^2: half of what the tires give"


def test_it_gives_up_after_the_timeout_when_something_is_in_the_way():
    robot = Ideal((2.0, 3.0, 0.0), stuck=True)
    assert follow(lambda r: r.drive_to(7.0, 3.0, 0.0, timeout=1.0), robot) == 51


def test_it_passes_all_corners_in_order():
    robot, corners = Ideal((1.0, 1.0, 0.0)), [(3.0, 1.0), (3.0, 3.0), (1.0, 3.0)]
    track = []
    drive = robot.set_chassis_speeds
    robot.set_chassis_speeds = lambda *v: (drive(*v), track.append(tuple(robot.pose[:2])))
    follow(lambda r: r.drive_through(corners, 0.0), robot)
    nearest = [min(range(len(track)), key=lambda i, c=c: math.dist(track[i], c)) for c in corners]
    assert nearest == sorted(nearest)
    assert all(math.dist(track[i], c) < 0.4 for i, c in zip(nearest, corners, strict=True))


def test_a_red_robot_does_the_same_turned_by_180_degrees():
    blue, red = Ideal((2.0, 3.0, 0.3)), Ideal((FIELD_LENGTH - 2.0, FIELD_WIDTH - 3.0, 0.3 + math.pi))
    for robot, alliance in ((blue, "blue"), (red, "red")):
        follow(lambda r: r.drive_to(4.0, 4.0, 1.0), robot, alliance=alliance)
    assert (FIELD_LENGTH - red.pose[0], FIELD_WIDTH - red.pose[1]) == pytest.approx(blue.pose[:2], abs=1e-9)
    assert math.remainder(red.pose[2] - math.pi - blue.pose[2], math.tau) == pytest.approx(0.0, abs=1e-9)


def test_collecting_ends_when_the_region_is_empty_and_when_time_is_up():
    region = {"low": (0.0, 5.0), "high": (1.0, 7.0), "aside": 0.2}
    elsewhere = np.array([[5.0, 5.0, 0.075], [0.5, 6.0, 0.9]])  # the second lies too high to be on the carpet
    assert follow(lambda r: r.collect_in(**region, timeout=5.0), Ideal((3.0, 6.0, 0.0)), fuel=elsewhere) == 1
    there = np.array([[0.3, 6.1, 0.075]])
    robot = Ideal((3.0, 6.0, 0.0))
    assert follow(lambda r: r.collect_in(**region, timeout=4.0), robot, fuel=there) == 201
    assert robot.pose[:2] == pytest.approx((0.3 + 0.62, 6.1), abs=0.05), "with the intake, 0.62 m behind, over the fuel"


def test_waiting_takes_as_long_as_it_says():
    assert follow(lambda r: r.wait(0.5), Ideal((2.0, 3.0, 0.0))) == 25


def test_a_script_that_has_ended_stops_the_robot():
    def script(robot):
        yield from robot.wait(0.04)

    robot = Ideal((2.0, 3.0, 0.0))
    robot.config = SimpleNamespace(shooter=SimpleNamespace(gearbox=None))
    code = ScriptedRobot(script, alliance="blue", held=lambda n: 0, fuel_places=lambda: np.zeros((0, 3)))
    code._steps = script(code)
    code._command_mechanisms = lambda: None
    ended = []
    for _ in range(4):
        code(robot, 0.0)
        ended.append(code.is_done)
    assert ended == [False, False, True, True]
    assert robot.asked[-1] == (0.0, 0.0, 0.0)
