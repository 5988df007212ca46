"""Swerve on TalonFX and CANcoders in a class of the team's own; wheel size and gearing are only in its arithmetic."""

import math

import commands2
import wpilib
from phoenix6 import configs, controls, hardware, signals
from wpimath.geometry import Rotation2d, Translation2d
from wpimath.kinematics import ChassisSpeeds, SwerveDrive4Kinematics, SwerveDrive4Odometry, SwerveModulePosition

RATIO, STEER_RATIO, CIRCUMFERENCE = 6.12, 12.8, math.tau * 0.0495
PLACES = ((0.25, 0.3), (0.25, -0.3), (-0.25, 0.3), (-0.25, -0.3))


class Module:
    def __init__(self, number: int, inverted: bool) -> None:
        self._drive = hardware.TalonFX(number)
        self._turn = hardware.TalonFX(number + 10)
        self._encoder = hardware.CANcoder(number + 20)
        sensor = configs.CANcoderConfiguration()
        sensor.magnet_sensor.magnet_offset = 0.13 * number
        self._encoder.configurator.apply(sensor)
        drive = configs.TalonFXConfiguration()
        drive.slot0.k_p, drive.slot0.k_v = 0.2, 0.12
        drive.motor_output.neutral_mode = signals.NeutralModeValue.BRAKE
        if inverted:
            drive.motor_output.inverted = signals.InvertedValue.CLOCKWISE_POSITIVE
        drive.current_limits.stator_current_limit = 80.0
        self._drive.configurator.apply(drive)
        turn = configs.TalonFXConfiguration()
        turn.motor_output.inverted = signals.InvertedValue.CLOCKWISE_POSITIVE
        turn.feedback.feedback_remote_sensor_id = number + 20
        turn.feedback.feedback_sensor_source = signals.FeedbackSensorSourceValue.FUSED_CANCODER
        turn.feedback.rotor_to_sensor_ratio = STEER_RATIO
        turn.slot0.k_p, turn.slot0.k_d = 60.0, 0.2
        turn.closed_loop_general.continuous_wrap = True
        self._turn.configurator.apply(turn)
        self._speed, self._angle = controls.VelocityVoltage(0.0), controls.PositionVoltage(0.0)

    def angle(self) -> Rotation2d:
        return Rotation2d(math.tau * self._turn.get_position().value)

    def get_position(self) -> SwerveModulePosition:
        return SwerveModulePosition(self._drive.get_position().value / RATIO * CIRCUMFERENCE, self.angle())

    def set_state(self, state) -> None:
        state.optimize(self.angle())
        self._drive.set_control(self._speed.with_velocity(state.speed / CIRCUMFERENCE * RATIO))
        self._turn.set_control(self._angle.with_position(state.angle.degrees() / 360.0))


class Swerve(commands2.Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.modules = [Module(k + 1, k % 2 == 1) for k in range(4)]
        self.pigeon = hardware.Pigeon2(0)
        self.kinematics = SwerveDrive4Kinematics(*(Translation2d(x, y) for x, y in PLACES))
        self.odometry = SwerveDrive4Odometry(self.kinematics, self.pigeon.getRotation2d(), self.positions())

    def positions(self) -> tuple:
        return tuple(m.get_position() for m in self.modules)

    def periodic(self) -> None:
        self.odometry.update(self.pigeon.getRotation2d(), self.positions())

    def drive(self, speeds: ChassisSpeeds) -> None:
        for module, state in zip(self.modules, self.kinematics.toSwerveModuleStates(speeds), strict=True):
            module.set_state(state)


class Robot(commands2.TimedCommandRobot):
    def robotInit(self) -> None:
        self.swerve = Swerve()
        self.pad = wpilib.Joystick(0)

    def teleopPeriodic(self) -> None:
        axis = self.pad.getRawAxis
        self.swerve.drive(ChassisSpeeds(-3.0 * axis(1), -3.0 * axis(0), -3.0 * axis(4)))
