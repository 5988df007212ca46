import math

import navx
from commands2 import Subsystem
from constants import KINEMATICS
from pathplannerlib.auto import AutoBuilder
from pathplannerlib.config import PIDConstants, RobotConfig
from pathplannerlib.controller import PPHolonomicDriveController
from subsystems import MAXSwerveModule
from vision import Vision
from wpilib import DriverStation
from wpimath.estimator import SwerveDrive4PoseEstimator
from wpimath.geometry import Pose2d
from wpimath.kinematics import ChassisSpeeds, SwerveModuleState


class Drive(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.modules = [
            MAXSwerveModule(11, 10, -math.pi / 2),
            MAXSwerveModule(15, 14, 0.0),
            MAXSwerveModule(13, 12, math.pi),
            MAXSwerveModule(17, 16, math.pi / 2),
        ]
        self.gyro = navx.AHRS(navx.AHRS.NavXComType.kMXP_SPI)
        self.vision = Vision()
        self.estimator = SwerveDrive4PoseEstimator(KINEMATICS, self.gyro.getRotation2d(), self.positions(), Pose2d())
        AutoBuilder.configure(
            self.get_pose,
            self.reset_pose,
            self.get_speeds,
            lambda speeds, _: self.drive(speeds),
            PPHolonomicDriveController(PIDConstants(5.0), PIDConstants(5.0)),
            RobotConfig.fromGUISettings(),
            lambda: DriverStation.getAlliance() == DriverStation.Alliance.kRed,
            self,
        )

    def positions(self) -> tuple:
        return tuple(module.get_position() for module in self.modules)

    def get_pose(self) -> Pose2d:
        return self.estimator.getEstimatedPosition()

    def reset_pose(self, pose: Pose2d) -> None:
        self.estimator.resetPosition(self.gyro.getRotation2d(), self.positions(), pose)

    def get_speeds(self) -> ChassisSpeeds:
        return KINEMATICS.toChassisSpeeds(
            tuple(SwerveModuleState(m.driving_encoder.getVelocity(), m.get_position().angle) for m in self.modules)
        )

    def drive(self, speeds: ChassisSpeeds) -> None:
        states = KINEMATICS.toSwerveModuleStates(ChassisSpeeds.discretize(speeds, 0.02))
        for module, state in zip(self.modules, KINEMATICS.desaturateWheelSpeeds(states, 4.8), strict=True):
            module.set_desired_state(state)

    def periodic(self) -> None:
        self.estimator.update(self.gyro.getRotation2d(), self.positions())
        for pose, time, deviations in self.vision.measurements():
            self.estimator.addVisionMeasurement(pose, time, deviations)
