"""Autos that begin in different places, each of which sets the drivetrain's pose anew as PathPlanner's do."""

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
LATER = Pose2d(1.0, 1.0, Rotation2d())


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build(coupling=3.57)
        self.drivetrain.reset_pose(Pose2d(3.0, 4.0, Rotation2d(1.0)))  # no auto has begun
        self.chooser = wpilib.SendableChooser()
        self.chooser.setDefaultOption("nothing", "nothing")
        for name in (*STARTS, "by name"):
            self.chooser.addOption(name, name)
        wpilib.SmartDashboard.putData("Auto", self.chooser)

    def autonomousInit(self) -> None:
        self.ticks = 0
        pose = STARTS.get(self.chooser.getSelected())
        if pose is not None:
            self.drivetrain.seed_field_centric(Rotation2d(pose[2]))
            self.drivetrain.reset_pose(Pose2d(*pose))

    def autonomousPeriodic(self) -> None:
        self.ticks += 1
        self.drivetrain.set_control(requests.RobotCentric().with_velocity_x(1.0 if self.ticks > 5 else 0.0))
        if self.ticks == 15:
            self.drivetrain.reset_pose(LATER)  # on its way, as a team corrects it by a camera

    def teleopInit(self) -> None:
        self.drivetrain.reset_pose(LATER)
