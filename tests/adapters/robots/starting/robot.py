"""Robot with autos at different starts, each of which resets the drivetrain's pose as PathPlanner autos do."""

import os
import time

import measures
import wpilib
from phoenix6.swerve import requests
from wpimath.geometry import Pose2d, Rotation2d

STARTS = {
    "left": (2.5, 6.0, 3.14159),
    "red": (14.0, 2.0, 3.14159),
    "outside": (40.0, 2.0, 0.0),
    "in the hub": (4.6, 4.035, 0.0),
}
LENGTH, WIDTH = 16.541, 8.069
LATER = Pose2d(1.0, 1.0, Rotation2d())


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        time.sleep(float(os.environ.get("SLOW_START", "0")))
        self.drivetrain = measures.build(coupling=3.57)
        self.drivetrain.reset_pose(Pose2d(3.0, 4.0, Rotation2d(1.0)))  # no auto has begun
        self.chooser = wpilib.SendableChooser()
        self.chooser.setDefaultOption("nothing", "nothing")
        for name in (*STARTS, "own side", "by name"):
            self.chooser.addOption(name, name)
        wpilib.SmartDashboard.putData("Auto", self.chooser)

    def autonomousInit(self) -> None:
        self.ticks = 0
        pose = STARTS.get(self.chooser.getSelected())
        if self.chooser.getSelected() == "own side":
            x, y, yaw = pose = STARTS["left"]
            if wpilib.DriverStation.getAlliance() == wpilib.DriverStation.Alliance.kRed:
                pose = LENGTH - x, WIDTH - y, yaw + 3.14159
        if pose is not None:
            self.drivetrain.seed_field_centric(Rotation2d(pose[2]))
            self.drivetrain.reset_pose(Pose2d(*pose))

    def autonomousPeriodic(self) -> None:
        self.ticks += 1
        self.drivetrain.set_control(requests.RobotCentric().with_velocity_x(1.0 if self.ticks > 5 else 0.0))
        if self.ticks == 15:
            self.drivetrain.reset_pose(LATER)  # during the auto, like a correction by a camera

    def teleopInit(self) -> None:
        self.drivetrain.reset_pose(LATER)
