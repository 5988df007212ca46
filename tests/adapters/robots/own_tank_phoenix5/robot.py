"""A tank drive on Talon SRX with Victor SPX following, mag encoders on the wheels and a navX."""

import math

import navx
import wpilib
import wpilib.drive
from phoenix5 import FeedbackDevice, InvertType, NeutralMode, WPI_TalonSRX, WPI_VictorSPX
from wpimath.kinematics import DifferentialDriveOdometry

METERS_PER_UNIT = math.tau * 0.0762 / 4096


class DriveTrain:
    def __init__(self) -> None:
        self.left, self.right = WPI_TalonSRX(1), WPI_TalonSRX(3)
        self.followers = [WPI_VictorSPX(2), WPI_VictorSPX(4)]
        for talon, follower in zip((self.left, self.right), self.followers, strict=True):
            talon.configFactoryDefault()
            talon.configSelectedFeedbackSensor(FeedbackDevice.CTRE_MagEncoder_Relative, 0, 10)
            talon.configContinuousCurrentLimit(40, 10)
            talon.configPeakCurrentLimit(60, 10)
            talon.configPeakCurrentDuration(100, 10)
            talon.enableCurrentLimit(True)
            talon.setNeutralMode(NeutralMode.Brake)
            talon.setSelectedSensorPosition(0, 0, 10)
            follower.follow(talon)
            follower.setInverted(InvertType.FollowMaster)
        self.right.setInverted(True)
        self.drive = wpilib.drive.DifferentialDrive(self.left, self.right)
        self.gyro = navx.AHRS(navx.AHRS.NavXComType.kMXP_SPI)
        self.odometry = DifferentialDriveOdometry(self.gyro.getRotation2d(), 0.0, 0.0)

    def update(self) -> None:
        ways = [t.getSelectedSensorPosition() * METERS_PER_UNIT for t in (self.left, self.right)]
        self.odometry.update(self.gyro.getRotation2d(), *ways)


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.train = DriveTrain()
        self.pad = wpilib.Joystick(0)

    def robotPeriodic(self) -> None:
        self.train.update()

    def teleopPeriodic(self) -> None:
        self.train.drive.arcadeDrive(-0.8 * self.pad.getRawAxis(1), -0.8 * self.pad.getRawAxis(4), False)
