"""A plain RobotBase: everything in startCompetition, which waits as LOOP says; beside it a physics.py of the team's."""

import os
import threading
import time
from time import sleep

import hal
import measures
import wpilib


class Robot(wpilib.RobotBase):
    def __init__(self) -> None:
        super().__init__()
        self.is_over = threading.Event()
        self.drivetrain = measures.build(coupling=3.57)

    def startCompetition(self) -> None:
        hal.observeUserProgramStarting()
        loop, last = os.environ.get("LOOP", "sleep"), 0.0
        while not self.is_over.is_set():
            wpilib.DriverStation.refreshData()
            if self.isTeleopEnabled():
                self.drivetrain.set_control(measures.driver_request())
            if loop == "sleep":
                sleep(0.02)
            elif loop == "event":
                self.is_over.wait(0.02)
            else:
                while time.perf_counter() - last < 0.02:
                    pass
                last = time.perf_counter()

    def endCompetition(self) -> None:
        self.is_over.set()
