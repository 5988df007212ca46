"""TimedRobot without commands; its period comes from the environment."""

import os

import measures
import wpilib
from phoenix6.swerve import SwerveModule, requests


class Robot(wpilib.TimedRobot):
    def __init__(self) -> None:
        super().__init__(float(os.environ.get("ROBOT_PERIOD", "0.02")))

    def robotInit(self) -> None:
        self.drivetrain = measures.build(k_s=0.25)
        self.own_hook = 0
        velocity = SwerveModule.DriveRequestType.VELOCITY
        self.drive = requests.RobotCentric().with_velocity_x(2.0).with_drive_request_type(velocity)

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(self.drive)

    def _simulationPeriodic(self) -> None:
        self.own_hook += 1
