"""Swerve on SPARK MAX with CANcoders: the steer motors' own encoders are seeded once from these, in degrees."""

import math

import rev
import wpilib
from phoenix6.configs import CANcoderConfiguration
from phoenix6.hardware import CANcoder, Pigeon2
from wpimath.estimator import SwerveDrive4PoseEstimator
from wpimath.geometry import Pose2d, Rotation2d, Translation2d
from wpimath.kinematics import ChassisSpeeds, SwerveDrive4Kinematics, SwerveModulePosition

SAFE, PERSIST = rev.ResetMode.kResetSafeParameters, rev.PersistMode.kPersistParameters
BRUSHLESS, ControlType = rev.SparkLowLevel.MotorType.kBrushless, rev.SparkLowLevel.ControlType
DRIVE_RATIO, STEER_RATIO, WHEEL = 6.75, 150.0 / 7.0, 0.0508
CORNERS = {"front_left": (1, 1), "front_right": (1, -1), "back_left": (-1, 1), "back_right": (-1, -1)}


class SwerveModule:
    def __init__(self, drive_id: int, steer_id: int, encoder_id: int, offset_deg: float) -> None:
        self.drive_motor = rev.SparkMax(drive_id, BRUSHLESS)
        self.angle_motor = rev.SparkMax(steer_id, BRUSHLESS)
        self.can_coder = CANcoder(encoder_id)
        config = CANcoderConfiguration()
        config.magnet_sensor.magnet_offset = offset_deg / 360.0
        self.can_coder.configurator.apply(config)
        drive = rev.SparkMaxConfig()
        drive.inverted(True).setIdleMode(rev.SparkMaxConfig.IdleMode.kBrake).smartCurrentLimit(60)
        drive.encoder.positionConversionFactor(math.tau * WHEEL / DRIVE_RATIO)
        drive.encoder.velocityConversionFactor(math.tau * WHEEL / DRIVE_RATIO / 60.0)
        drive.closedLoop.pid(0.1, 0.0, 0.0).feedForward.kV(2.6)
        self.drive_motor.configure(drive, SAFE, PERSIST)
        steer = rev.SparkMaxConfig()
        steer.inverted(True).setIdleMode(rev.SparkMaxConfig.IdleMode.kBrake).smartCurrentLimit(30)
        steer.encoder.positionConversionFactor(360.0 / STEER_RATIO)
        steer.encoder.velocityConversionFactor(360.0 / STEER_RATIO / 60.0)
        steer.closedLoop.pid(0.012, 0.0, 0.0)
        self.angle_motor.configure(steer, SAFE, PERSIST)
        self.drive_encoder, self.angle_encoder = self.drive_motor.getEncoder(), self.angle_motor.getEncoder()
        self.drive_loop = self.drive_motor.getClosedLoopController()
        self.angle_loop = self.angle_motor.getClosedLoopController()
        self.angle_encoder.setPosition(360.0 * self.can_coder.get_absolute_position().value)

    @property
    def angle(self) -> Rotation2d:
        return Rotation2d.fromDegrees(self.angle_encoder.getPosition())

    def getPosition(self) -> SwerveModulePosition:
        return SwerveModulePosition(self.drive_encoder.getPosition(), self.angle)

    def setState(self, state) -> None:
        state.optimize(self.angle)
        here = self.angle_encoder.getPosition()
        goal = here + math.remainder(state.angle.degrees() - here, 360.0)
        self.angle_loop.setReference(goal, ControlType.kPosition)
        self.drive_loop.setReference(state.speed, ControlType.kVelocity)


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.swerve = {
            name: SwerveModule(2 * k + 1, 2 * k + 2, 20 + k, (37.0, -121.0, 90.0, 5.0)[k])
            for k, name in enumerate(CORNERS)
        }
        self.gyro = Pigeon2(9)
        places = [Translation2d(0.29 * x, 0.26 * y) for x, y in CORNERS.values()]
        self.kinematics = SwerveDrive4Kinematics(*places)
        self.estimator = SwerveDrive4PoseEstimator(
            self.kinematics, self.gyro.getRotation2d(), self.positions(), Pose2d(2.0, 1.2, 0.0)
        )
        self.pad = wpilib.Joystick(0)

    def positions(self) -> tuple:
        return tuple(m.getPosition() for m in self.swerve.values())

    def robotPeriodic(self) -> None:
        self.estimator.update(self.gyro.getRotation2d(), self.positions())

    def teleopPeriodic(self) -> None:
        axis = self.pad.getRawAxis
        speeds = ChassisSpeeds(-3.0 * axis(1), -3.0 * axis(0), -3.0 * axis(4))
        for module, state in zip(self.swerve.values(), self.kinematics.toSwerveModuleStates(speeds), strict=True):
            module.setState(state)
