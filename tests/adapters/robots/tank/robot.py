"""Kit bot: two PWM controllers a side, the second one a follower, encoders on the wheels and an analog gyro."""

import math

import wpilib
import wpilib.drive
from wpimath.geometry import Rotation2d
from wpimath.kinematics import DifferentialDriveOdometry

WHEEL_RADIUS = 0.0762
PULSES = 360


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.left, self.right = wpilib.PWMSparkMax(0), wpilib.PWMSparkMax(1)
        self.followers = [wpilib.PWMSparkMax(2), wpilib.PWMSparkMax(3)]
        self.left.addFollower(self.followers[0])
        self.right.addFollower(self.followers[1])
        self.right.setInverted(True)
        self.drive = wpilib.drive.DifferentialDrive(self.left, self.right)
        self.drive.setSafetyEnabled(False)  # polls in its own thread, at its own times
        self.encoders = [wpilib.Encoder(0, 1), wpilib.Encoder(2, 3, True)]
        for encoder in self.encoders:
            encoder.setDistancePerPulse(math.tau * WHEEL_RADIUS / PULSES)
        self.gyro = wpilib.AnalogGyro(0)
        self.odometry = DifferentialDriveOdometry(Rotation2d(), 0.0, 0.0)
        self.goal = (0.0, 0.0, 0.0)

    def robotPeriodic(self) -> None:
        self.odometry.update(self.gyro.getRotation2d(), *(e.getDistance() for e in self.encoders))

    def teleopPeriodic(self) -> None:
        speed, _, turn = self.goal
        self.drive.arcadeDrive(speed / 4.0, turn / 3.0, False)
