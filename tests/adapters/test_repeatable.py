"""Two runs of one robot, one of them on a computer with four busy processes, agree to the last bit."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow

RESTLESS = """
import random
import time
from time import monotonic

import measures
import numpy as np
import wpilib
from phoenix6.swerve import requests

VELOCITY = measures.swerve.SwerveModule.DriveRequestType.VELOCITY


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.drivetrain = measures.build(coupling=3.57)
        self.order = []
        self.gain = 0.0
        self.notifiers = [wpilib.Notifier(lambda n=n: self.tick(n)) for n in range(4)]
        for notifier in self.notifiers:
            notifier.startPeriodic(0.02)
        self.begin = time.time()

    def tick(self, number):
        self.order.append(number)
        self.gain = 0.5 * self.gain + 0.1 * number + 0.1 * random.random() + 0.1 * float(np.random.rand())

    def autonomousPeriodic(self):
        name = next(iter({"a", "bb", "ccc", "dddd"}))
        speed = 0.5 + self.gain + 0.2 * (monotonic() % 1.0) + 0.1 * len(name)
        self.drivetrain.set_control(requests.RobotCentric().with_velocity_x(speed).with_drive_request_type(VELOCITY))
"""
"""Robot with typical sources of differences: Notifiers at equal times, unseeded random, clocks, sets of strings."""
TEST = """
import os

def test_it(sim):
    sim.autonomous(seconds=0.4)
    order = sim.robot.order
    assert len(order) > 100 and order == [0, 1, 2, 3] * (len(order) // 4)  # all four at every instant, in one order
    assert sim.robot.begin == 1_700_000_000.0  # its clocks are simulated
    with open(os.environ["DIGESTS"], "a") as file:
        file.write(f"{sim.digest} {sim.battery.min_voltage!r}\\n")
"""


def test_a_busy_computer_changes_no_bit_of_a_run(project_of, tmp_path):
    run, digests = project_of(RESTLESS), tmp_path / "digests"
    code, said = run(TEST, DIGESTS=str(digests))
    assert code == 0, said
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(4)]
    try:
        code, said = run(TEST, command=("-m", "robotpy", "test"), DIGESTS=str(digests))
    finally:
        for process in busy:
            process.kill()
            process.wait()
    assert code == 0, said
    quiet, loaded = digests.read_text().splitlines()
    assert quiet == loaded
