"""Scripted actions keep a robot within its limits and end at their timeouts."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from simcore.match.scripted import ScriptedRobot, ScriptSettings
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ShaftSim
from simcore.robot.swerve_drive import SwerveDrive
from simcore.world.symmetry import FieldSymmetry

DT = 0.02
SIZE = (16.0, 8.0)
GEARBOX = GearboxConfig(motor=motor("Kraken X60"), gearing=50.0)


class Ideal(SwerveDrive):
    """Robot that follows commands at once or, if `stuck`, does not move."""

    def __init__(self, pose, stuck=False):
        self.pose, self.stuck, self.asked = list(pose), stuck, []
        self.number = 0
        self.chassis = self.drive = self
        self.intakes = [SimpleNamespace(zone=SimpleNamespace(y_max=0.33))]
        self.shooters, self.mechanisms, self.setpoints, self.held = [], {}, {}, []
        self.storage = SimpleNamespace(room=1)
        self.__dict__["config"] = SimpleNamespace(intakes=())

    @property
    def reckoned_pose(self):
        return tuple(self.pose)

    def set_chassis_speeds(self, vx, vy, omega):
        x, y, yaw = self.pose
        c, s = math.cos(yaw), math.sin(yaw)
        self.asked.append((c * vx - s * vy, s * vx + c * vy, omega))
        if not self.stuck:
            field = self.asked[-1]
            self.pose = [x + field[0] * DT, y + field[1] * DT, yaw + omega * DT]


def made(script, alliance="blue", symmetry="rotate", pieces=None):
    pieces = np.zeros((0, 3)) if pieces is None else pieces
    field = SimpleNamespace(symmetry=FieldSymmetry(symmetry, SIZE))
    state = SimpleNamespace(pos=pieces)
    manager = SimpleNamespace(state=state, on_field=lambda kind: np.arange(len(pieces)))
    match = SimpleNamespace(game=SimpleNamespace(field=field), pieces=manager)
    return ScriptedRobot(script, match, alliance, ScriptSettings(intake_x=-0.62))


def follow(script, robot, *, ticks=2000, **more):
    """Play a script on the ideal robot; return the number of ticks until it ends."""
    code = made(script, **more)
    for tick in range(ticks):
        code(robot, DT * tick)
        if code.is_done:
            return tick
    raise AssertionError("the script does not end")


def test_a_scripted_robot_stays_within_its_speed_and_acceleration():
    robot = Ideal((2.0, 3.0, 0.0))
    follow(lambda r: r.drive_to(7.0, 3.0, 0.0, speed=2.0), robot)
    speeds = np.array(robot.asked)[:, :2]
    assert np.linalg.norm(speeds, axis=1).max() <= 2.0 + 1e-9
    steps = np.linalg.norm(np.diff(speeds[:-2], axis=0), axis=1)
    assert steps.max() <= 6.0 * DT + 1e-9, "6 m/s^2: half of what the tires give"


def test_a_blocked_drive_ends_at_its_timeout():
    robot = Ideal((2.0, 3.0, 0.0), stuck=True)
    assert follow(lambda r: r.drive_to(7.0, 3.0, 0.0, timeout=1.0), robot) == 51


def test_collecting_ends_when_the_region_is_empty_or_time_is_up():
    region = {"low": (0.0, 5.0), "high": (1.0, 7.0), "aside": 0.2}
    elsewhere = np.array([[5.0, 5.0, 0.075], [0.5, 6.0, 0.9]])  # the second is too high to be on the carpet
    assert follow(lambda r: r.collect_in(**region, timeout=5.0), Ideal((3.0, 6.0, 0.0)), pieces=elsewhere) == 1
    there = np.array([[0.3, 6.1, 0.075]])
    robot = Ideal((3.0, 6.0, 0.0))
    assert follow(lambda r: r.collect_in(**region, timeout=4.0), robot, pieces=there) == 201
    assert robot.pose[:2] == pytest.approx((0.3 + 0.62, 6.1), abs=0.05), "with the intake, 0.62 m behind, over the fuel"


def test_a_finished_script_stops_the_robot_and_a_new_robot_restarts_it():
    def script(robot):
        yield from robot.wait(0.04)

    robot, code = Ideal((2.0, 3.0, 0.0)), made(script)
    ended = []
    for _ in range(4):
        code(robot, 0.0)
        ended.append(code.is_done)
    assert ended == [False, False, True, True]
    assert robot.asked[-1] == (0.0, 0.0, 0.0)
    code(Ideal((2.0, 3.0, 0.0)), 0.0)
    assert not code.is_done


def test_mechanisms_keep_their_commanded_positions_and_voltages():
    arm, claw = ShaftSim(GEARBOX, 0.5), ShaftSim(GEARBOX, 0.01)
    robot = Ideal((2.0, 3.0, 0.0))
    robot.mechanisms = {"arm": arm, "claw": claw}

    def script(code):
        code.set_position("arm", 0.7)
        code.set_volts("claw", 5.0)
        yield from code.wait(1.0)
        code.set_volts("arm", -2.0)
        yield

    code = made(script)
    for tick in range(50):
        code(robot, DT * tick)
        arm.step(DT)
    assert arm.position == pytest.approx(0.7, abs=0.02)
    assert claw.volts == 5.0
    code(robot, 1.0)
    assert arm.volts == -2.0
