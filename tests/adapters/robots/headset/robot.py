"""Tells its headset, which looks to the left, where it is: in robotInit; goes by its frames alone from then on."""

import measures
import wpilib
from phoenix6.swerve import requests
from questnav import QuestNav
from wpimath.geometry import Pose2d, Pose3d, Rotation3d, Transform3d, Translation3d

ROBOT_TO_QUEST = Transform3d(Translation3d(0.15, 0.2, 0.5), Rotation3d.fromDegrees(0, 0, 90))


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build()
        self.quest = QuestNav()
        self.quest.set_pose(Pose3d(Pose2d(0.0, 0.0, 0.0)).transformBy(ROBOT_TO_QUEST))
        self.believed = Pose2d()

    def robotPeriodic(self) -> None:
        for frame in self.quest.unread_frames():
            self.believed = frame.pose.transformBy(ROBOT_TO_QUEST.inverse()).toPose2d()

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(requests.RobotCentric().with_velocity_x(1.0))
