"""A robot on a base class with a loop of its own."""

import measures
from own_loop_robot import OwnLoopRobot


class Robot(OwnLoopRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build(coupling=3.57)

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(measures.driver_request())
