"""Subsystem of REV's MAXSwerve template in Python, and modules with absolute encoders."""

import math

import rev
import wpilib
from commands2 import Subsystem
from constants import KINEMATICS, driving, turning
from wpimath.geometry import Pose2d, Rotation2d
from wpimath.kinematics import ChassisSpeeds, SwerveDrive4Odometry, SwerveModulePosition, SwerveModuleState

SAFE, PERSIST = rev.ResetMode.kResetSafeParameters, rev.PersistMode.kPersistParameters
BRUSHLESS, ControlType = rev.SparkLowLevel.MotorType.kBrushless, rev.SparkLowLevel.ControlType


class MAXSwerveModule:
    def __init__(self, driving_id: int, turning_id: int, chassis_angular_offset: float) -> None:
        self.driving_spark = rev.SparkMax(driving_id, BRUSHLESS)
        self.turning_spark = rev.SparkMax(turning_id, BRUSHLESS)
        self.driving_encoder = self.driving_spark.getEncoder()
        self.turning_encoder = self.turning_spark.getAbsoluteEncoder()
        self.driving_controller = self.driving_spark.getClosedLoopController()
        self.turning_controller = self.turning_spark.getClosedLoopController()
        self.driving_spark.configure(driving(), SAFE, PERSIST)
        self.turning_spark.configure(turning(), SAFE, PERSIST)
        self.offset = chassis_angular_offset
        self.desired = SwerveModuleState(0.0, Rotation2d(self.turning_encoder.getPosition()))
        self.driving_encoder.setPosition(0)

    def get_position(self) -> SwerveModulePosition:
        return SwerveModulePosition(
            self.driving_encoder.getPosition(), Rotation2d(self.turning_encoder.getPosition() - self.offset)
        )

    def set_desired_state(self, desired: SwerveModuleState) -> None:
        corrected = SwerveModuleState(desired.speed, desired.angle + Rotation2d(self.offset))
        corrected.optimize(Rotation2d(self.turning_encoder.getPosition()))
        self.driving_controller.setReference(corrected.speed, ControlType.kVelocity)
        self.turning_controller.setReference(corrected.angle.radians(), ControlType.kPosition)
        self.desired = desired


class DriveSubsystem(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.front_left = MAXSwerveModule(11, 10, -math.pi / 2)
        self.front_right = MAXSwerveModule(15, 14, 0.0)
        self.rear_left = MAXSwerveModule(13, 12, math.pi)
        self.rear_right = MAXSwerveModule(17, 16, math.pi / 2)
        self.gyro = wpilib.ADXRS450_Gyro()
        self.odometry = SwerveDrive4Odometry(KINEMATICS, self.heading(), self.positions())

    def modules(self) -> tuple:
        return self.front_left, self.front_right, self.rear_left, self.rear_right

    def heading(self) -> Rotation2d:
        return Rotation2d.fromDegrees(-self.gyro.getAngle())

    def positions(self) -> tuple:
        return tuple(m.get_position() for m in self.modules())

    def periodic(self) -> None:
        self.odometry.update(self.heading(), self.positions())

    def get_pose(self) -> Pose2d:
        return self.odometry.getPose()

    def drive(self, x: float, y: float, turn: float) -> None:
        states = KINEMATICS.toSwerveModuleStates(ChassisSpeeds(x, y, turn))
        for module, state in zip(self.modules(), KINEMATICS.desaturateWheelSpeeds(states, 4.8), strict=True):
            module.set_desired_state(state)
