"""Sets its pose while disabled: in robotInit, on a change of the chooser, or never; its auto only drives ahead."""

import os

import measures
import wpilib
from phoenix6.swerve import requests
from wpimath.geometry import Pose2d

PLACES = {"left": (3.0, 6.0, 1.0), "right": (3.0, 2.0, 0.0), "in the hub": (4.6, 4.035, 0.0), "none": None}


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build()
        if "AT_ONCE" in os.environ:
            self.drivetrain.reset_pose(Pose2d(3.0, 6.0, 1.0))
        self.chooser = wpilib.SendableChooser()
        self.chooser.setDefaultOption("none", "none")
        for name in PLACES:
            self.chooser.addOption(name, name)
        wpilib.SmartDashboard.putData("Auto", self.chooser)
        self.chosen = "none"

    def disabledPeriodic(self) -> None:
        name = self.chooser.getSelected()
        if name != self.chosen:
            self.chosen = name
            if PLACES[name] is not None:
                self.drivetrain.reset_pose(Pose2d(*PLACES[name]))

    def autonomousPeriodic(self) -> None:
        self.drivetrain.set_control(requests.RobotCentric().with_velocity_x(1.0))

    def disabledInit(self) -> None:
        self.drivetrain.set_control(requests.SwerveDriveBrake())
