"""Robot of REV's MAXSwerve template in Python: command-based, SPARK MAX with absolute encoders."""

import commands2
import wpilib
from commands2.cmd import run
from subsystems import DriveSubsystem


class RobotContainer:
    def __init__(self) -> None:
        self.robot_drive = DriveSubsystem()
        self.pad = wpilib.XboxController(0)
        self.robot_drive.setDefaultCommand(
            run(
                lambda: self.robot_drive.drive(
                    -3.0 * self.pad.getLeftY(), -3.0 * self.pad.getLeftX(), -3.0 * self.pad.getRightX()
                ),
                self.robot_drive,
            )
        )


class Robot(commands2.TimedCommandRobot):
    def robotInit(self) -> None:
        self.container = RobotContainer()
