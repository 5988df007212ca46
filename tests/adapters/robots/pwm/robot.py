"""Swerve of a team without CAN: PWM controllers, encoders on DIO and analog inputs, an ADXRS450."""

import math

import wpilib
from wpimath.controller import PIDController
from wpimath.geometry import Rotation2d, Translation2d
from wpimath.kinematics import ChassisSpeeds, SwerveDrive4Kinematics, SwerveDrive4Odometry, SwerveModulePosition

PLACES = ((0.27, 0.25), (0.27, -0.25), (-0.27, 0.25), (-0.27, -0.25))
ZEROS = (0.1, 0.4, 0.77, 0.9)
PULSES = 2048
WHEEL_RADIUS = 0.05


class Module:
    def __init__(self, k: int) -> None:
        self.drive = wpilib.PWMSparkMax(2 * k)
        self.steer = wpilib.PWMVictorSPX(2 * k + 1)
        self.drive.setInverted(k % 2 == 1)
        self.steer.setInverted(k > 1)
        self.wheel = wpilib.Encoder(2 * k, 2 * k + 1, k == 3)
        self.wheel.setDistancePerPulse(math.tau * WHEEL_RADIUS / PULSES)
        self.azimuth = wpilib.DutyCycleEncoder(8 + k) if k < 2 else wpilib.AnalogEncoder(k)
        self.zero = ZEROS[k]
        self.loop = PIDController(2.5, 0.0, 0.03)
        self.loop.enableContinuousInput(-math.pi, math.pi)

    @property
    def angle(self) -> Rotation2d:
        return Rotation2d(math.tau * (self.azimuth.get() - self.zero))

    @property
    def position(self) -> SwerveModulePosition:
        return SwerveModulePosition(self.wheel.getDistance(), self.angle)

    def set(self, state) -> None:
        state.optimize(self.angle)
        self.steer.setVoltage(self.loop.calculate(self.angle.radians(), state.angle.radians()) * 4.0)
        self.drive.setVoltage(2.75 * state.speed + 1.0 * (state.speed - self.wheel.getRate()))


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.modules = [Module(k) for k in range(4)]
        self.gyro = wpilib.ADXRS450_Gyro()
        self.kinematics = SwerveDrive4Kinematics(*(Translation2d(x, y) for x, y in PLACES))
        self.odometry = SwerveDrive4Odometry(self.kinematics, self.gyro.getRotation2d(), self.positions)
        self.goal = (0.0, 0.0, 0.0)

    @property
    def positions(self):
        return tuple(m.position for m in self.modules)

    def robotPeriodic(self) -> None:
        self.odometry.update(self.gyro.getRotation2d(), self.positions)

    def teleopInit(self) -> None:
        self.gyro.reset()
        for module in self.modules:
            module.wheel.reset()
        self.odometry.resetPosition(self.gyro.getRotation2d(), self.positions, self.odometry.getPose())

    def teleopPeriodic(self) -> None:
        states = self.kinematics.toSwerveModuleStates(ChassisSpeeds(*self.goal))
        for module, state in zip(self.modules, states, strict=True):
            module.set(state)
