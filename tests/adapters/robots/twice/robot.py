"""Builds its drivetrain twice, in robot.py and in its container, which is the one that drives."""

import os

import measures
import wpilib

AMPS = float(os.environ.get("AMPS", "90"))  # of a drive motor, at which its wheel shall not slip


class Container:
    def __init__(self) -> None:
        self.drivetrain = measures.build(slip_current=AMPS)

    def drive(self) -> None:
        self.drivetrain.set_control(measures.driver_request())


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build(slip_current=AMPS)
        self.container = Container()

    def teleopPeriodic(self) -> None:
        self.container.drive()
