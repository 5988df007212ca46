"""A robot that does what makes two runs differ: Notifiers that meet, random without a seed, clocks, sets of strings."""

import random
import time
from time import monotonic

import measures
import numpy as np
import wpilib
from phoenix6.swerve import requests

VELOCITY = measures.swerve.SwerveModule.DriveRequestType.VELOCITY


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build(coupling=3.57)
        self.order = []
        self.gain = 0.0
        self.notifiers = [wpilib.Notifier(lambda n=n: self.tick(n)) for n in range(4)]
        for notifier in self.notifiers:
            notifier.startPeriodic(0.02)
        self.begin = time.time()

    def tick(self, number: int) -> None:
        self.order.append(number)
        self.gain = 0.5 * self.gain + 0.1 * number + 0.1 * random.random() + 0.1 * float(np.random.rand())  # noqa: NPY002

    def autonomousPeriodic(self) -> None:
        name = next(iter({"a", "bb", "ccc", "dddd"}))
        speed = 0.5 + self.gain + 0.2 * (monotonic() % 1.0) + 0.1 * len(name)
        self.drivetrain.set_control(requests.RobotCentric().with_velocity_x(speed).with_drive_request_type(VELOCITY))
