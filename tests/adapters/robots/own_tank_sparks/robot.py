"""A tank drive on SPARK MAX with followers, DifferentialDrive and the SPARKs' own encoders."""

import math

import rev
import wpilib
import wpilib.drive
from wpimath.kinematics import DifferentialDriveOdometry

SAFE, PERSIST = rev.ResetMode.kResetSafeParameters, rev.PersistMode.kPersistParameters
BRUSHLESS = rev.SparkLowLevel.MotorType.kBrushless
METERS_PER_TURN = math.tau * 0.0762 / 8.45


class DriveTrain:
    def __init__(self) -> None:
        self.left_leader, self.left_follower = rev.SparkMax(1, BRUSHLESS), rev.SparkMax(2, BRUSHLESS)
        self.right_leader, self.right_follower = rev.SparkMax(3, BRUSHLESS), rev.SparkMax(4, BRUSHLESS)
        for leader, follower, inverted in (
            (self.left_leader, self.left_follower, False),
            (self.right_leader, self.right_follower, True),
        ):
            config = rev.SparkMaxConfig()
            config.setIdleMode(rev.SparkMaxConfig.IdleMode.kBrake).smartCurrentLimit(50).inverted(inverted)
            config.encoder.positionConversionFactor(METERS_PER_TURN).velocityConversionFactor(METERS_PER_TURN / 60.0)
            leader.configure(config, SAFE, PERSIST)
            config.follow(leader)
            follower.configure(config, SAFE, PERSIST)
        self.drive = wpilib.drive.DifferentialDrive(self.left_leader, self.right_leader)
        self.left_encoder, self.right_encoder = self.left_leader.getEncoder(), self.right_leader.getEncoder()
        self.gyro = wpilib.ADXRS450_Gyro()
        self.odometry = DifferentialDriveOdometry(self.gyro.getRotation2d(), 0.0, 0.0)

    def update(self) -> None:
        self.odometry.update(
            self.gyro.getRotation2d(), self.left_encoder.getPosition(), self.right_encoder.getPosition()
        )


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.train = DriveTrain()
        self.pad = wpilib.Joystick(0)

    def robotPeriodic(self) -> None:
        self.train.update()

    def teleopPeriodic(self) -> None:
        self.train.drive.arcadeDrive(-0.8 * self.pad.getRawAxis(1), -0.8 * self.pad.getRawAxis(4), False)
