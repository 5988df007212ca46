"""A tank drive handed over as functions: groups of two PWM controllers a side, of which the right one is inverted."""

import math

import wpilib
import wpilib.drive
from wpimath.geometry import Pose2d
from wpimath.kinematics import DifferentialDriveKinematics, DifferentialDriveOdometry


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.left = wpilib.MotorControllerGroup(wpilib.Spark(0), wpilib.Spark(2))
        self.right = wpilib.MotorControllerGroup(wpilib.Spark(1), wpilib.Spark(3))
        self.right.setInverted(True)
        self.robot_drive = wpilib.drive.DifferentialDrive(lambda speed: self.left.set(speed), self.set_right)
        self.left_encoder, self.right_encoder = wpilib.Encoder(0, 1), wpilib.Encoder(2, 3, True)
        for encoder in (self.left_encoder, self.right_encoder):
            encoder.setDistancePerPulse(math.pi * 0.1524 / 360)
        self.gyro = wpilib.ADXRS450_Gyro()
        self.kinematics = DifferentialDriveKinematics(0.6)
        self.odometry = DifferentialDriveOdometry(self.gyro.getRotation2d(), 0.0, 0.0, Pose2d())
        self.pad = wpilib.Joystick(0)

    def robotPeriodic(self) -> None:
        self.odometry.update(
            self.gyro.getRotation2d(), self.left_encoder.getDistance(), self.right_encoder.getDistance()
        )

    def teleopPeriodic(self) -> None:
        self.robot_drive.arcadeDrive(-self.pad.getRawAxis(1), -self.pad.getRawAxis(4), False)

    def set_right(self, speed: float) -> None:
        """Speed of the right side [-1..1]."""
        self.right.set(speed)
