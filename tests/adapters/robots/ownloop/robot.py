"""A robot on a base class with a loop of its own: no addPeriodic, and no wait when it is late."""

import measures
from logged_robot import LoggedRobot


class Robot(LoggedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build(coupling=3.57)

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(measures.driver_request())
