"""MagicBot with a swerve component and modules of its own; loops run on the roboRIO.

Modules drive by TalonFX and steer by SPARK MAX with analog encoders.
"""

import math

import rev
import wpilib
from magicbot import MagicRobot
from phoenix6 import controls, hardware
from wpimath.controller import PIDController
from wpimath.geometry import Rotation2d, Translation2d
from wpimath.kinematics import ChassisSpeeds, SwerveDrive4Kinematics, SwerveDrive4Odometry, SwerveModulePosition

METERS_PER_TURN = math.tau * 0.0508 / 6.75


class SwerveModule:
    def __init__(self, name: str, x: float, y: float, drive_id: int, steer_id: int, channel: int, zero: float) -> None:
        self.name, self.place, self.zero = name, Translation2d(x, y), zero
        self.drive = hardware.TalonFX(drive_id)
        self.steer = rev.SparkMax(steer_id, rev.SparkLowLevel.MotorType.kBrushless)
        self.absolute = wpilib.AnalogEncoder(channel)
        self.controller = PIDController(5.0, 0.0, 0.05)
        self.controller.enableContinuousInput(-math.pi, math.pi)
        self.request = controls.VoltageOut(0.0)

    def get_rotation(self) -> Rotation2d:
        return Rotation2d(math.tau * self.absolute.get() - self.zero)

    def get_position(self) -> SwerveModulePosition:
        return SwerveModulePosition(self.drive.get_position().value * METERS_PER_TURN, self.get_rotation())

    def set(self, state) -> None:
        state.optimize(self.get_rotation())
        self.steer.setVoltage(self.controller.calculate(self.get_rotation().radians(), state.angle.radians()))
        self.drive.set_control(self.request.with_output(2.45 * state.speed))


class Chassis:
    gyro: hardware.Pigeon2

    def setup(self) -> None:
        self.modules = (
            SwerveModule("fl", 0.25, 0.25, 1, 5, 0, 0.5),
            SwerveModule("rl", -0.25, 0.25, 2, 6, 1, 1.5),
            SwerveModule("rr", -0.25, -0.25, 3, 7, 2, 2.5),
            SwerveModule("fr", 0.25, -0.25, 4, 8, 3, -0.5),
        )
        self.kinematics = SwerveDrive4Kinematics(*(m.place for m in self.modules))
        self.odometry = SwerveDrive4Odometry(self.kinematics, self.gyro.getRotation2d(), self.positions())
        self.speeds = ChassisSpeeds()

    def positions(self) -> tuple:
        return tuple(m.get_position() for m in self.modules)

    def drive(self, x: float, y: float, turn: float) -> None:
        self.speeds = ChassisSpeeds(x, y, turn)

    def execute(self) -> None:
        for module, state in zip(self.modules, self.kinematics.toSwerveModuleStates(self.speeds), strict=True):
            module.set(state)
        self.odometry.update(self.gyro.getRotation2d(), self.positions())


class Robot(MagicRobot):
    chassis: Chassis

    def createObjects(self) -> None:
        self.gyro = hardware.Pigeon2(20)
        self.pad = wpilib.Joystick(0)

    def teleopPeriodic(self) -> None:
        axis = self.pad.getRawAxis
        self.chassis.drive(-3.0 * axis(1), -3.0 * axis(0), -3.0 * axis(4))
