"""Swerve with loops on the roboRIO: PWM drive controllers, SPARK Flex steered by voltage, encoders on roboRIO ports.

One steer encoder counts the other way, and the code corrects it.
"""

import math

import rev
import wpilib
from wpimath.controller import PIDController, SimpleMotorFeedforwardMeters
from wpimath.geometry import Rotation2d, Translation2d
from wpimath.kinematics import ChassisSpeeds, SwerveDrive4Kinematics, SwerveDrive4Odometry, SwerveModulePosition

ZEROS, SIGNS = (0.1, 0.4, 0.77, 0.9), (1.0, 1.0, -1.0, 1.0)
PLACES = ((0.27, 0.25), (0.27, -0.25), (-0.27, 0.25), (-0.27, -0.25))
WHEEL = 0.05


class Module:
    def __init__(self, k: int) -> None:
        self.k = k
        self.drive = wpilib.PWMSparkMax(k)
        self.drive.setInverted(k % 2 == 1)
        self.steer = rev.SparkFlex(k + 1, rev.SparkLowLevel.MotorType.kBrushless)
        self.wheel = wpilib.Encoder(2 * k, 2 * k + 1, k == 3)
        self.wheel.setDistancePerPulse(math.tau * WHEEL / 360)
        self.azimuth = wpilib.DutyCycleEncoder(8 + k) if k < 2 else wpilib.AnalogEncoder(k, 360.0, 0.0)
        self.unit = 1.0 if k < 2 else 360.0
        self.loop = PIDController(8.0, 0.0, 0.1)
        self.loop.enableContinuousInput(-math.pi, math.pi)
        self.feed = SimpleMotorFeedforwardMeters(0.15, 2.6)

    def angle(self) -> Rotation2d:
        return Rotation2d(SIGNS[self.k] * math.tau * (self.azimuth.get() / self.unit - ZEROS[self.k]))

    def position(self) -> SwerveModulePosition:
        return SwerveModulePosition(self.wheel.getDistance(), self.angle())

    def set(self, state) -> None:
        state.optimize(self.angle())
        self.steer.setVoltage(self.loop.calculate(self.angle().radians(), state.angle.radians()))
        self.drive.setVoltage(self.feed.calculate(state.speed) + 1.5 * (state.speed - self.wheel.getRate()))


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.modules = [Module(k) for k in range(4)]
        self.gyro = wpilib.ADXRS450_Gyro()
        self.kinematics = SwerveDrive4Kinematics(*(Translation2d(x, y) for x, y in PLACES))
        self.odometry = SwerveDrive4Odometry(self.kinematics, self.gyro.getRotation2d(), self.positions())
        self.pad = wpilib.Joystick(0)

    def positions(self) -> tuple:
        return tuple(m.position() for m in self.modules)

    def robotPeriodic(self) -> None:
        self.odometry.update(self.gyro.getRotation2d(), self.positions())

    def teleopPeriodic(self) -> None:
        axis = self.pad.getRawAxis
        speeds = ChassisSpeeds(-3.0 * axis(1), -3.0 * axis(0), -3.0 * axis(4))
        for module, state in zip(self.modules, self.kinematics.toSwerveModuleStates(speeds), strict=True):
            module.set(state)
