"""Swerve of SPARK MAX with absolute encoders in REVLib 2027: turns and RPM, no conversion factors."""

import math

import rev
import wpilib
import wpimath
from phoenix6 import CANBus
from phoenix6.hardware import Pigeon2

PORT, BRUSHLESS, CONTROL = wpilib.CANPort.CAN_S0, rev.SparkLowLevel.MotorType.BRUSHLESS, rev.SparkLowLevel.ControlType
SAFE, PERSIST = rev.ResetMode.RESET_SAFE_PARAMETERS, rev.PersistMode.PERSIST_PARAMETERS
GEARING = (45.0 * 22) / (14 * 15)
METERS_PER_TURN = math.pi * 0.0762 / GEARING
TOP_SPEED = 4.5  # [m/s]
KINEMATICS = wpimath.SwerveDrive4Kinematics(
    *(wpimath.Translation2d(x, y) for x in (0.33, -0.33) for y in (0.33, -0.33)),
)


class Module:
    def __init__(self, drive_id: int, steer_id: int) -> None:
        self.drive = rev.SparkMax(PORT, drive_id, BRUSHLESS)
        self.steer = rev.SparkMax(PORT, steer_id, BRUSHLESS)
        drive, steer = rev.SparkMaxConfig(), rev.SparkMaxConfig()
        drive.smart_current_limit(50)
        drive.closed_loop.pid(0.0001, 0.0, 0.0)
        drive.closed_loop.feed_forward.v(12.0 / 5676.0)
        steer.smart_current_limit(20)
        steer.closed_loop.set_feedback_sensor(rev.FeedbackSensor.ABSOLUTE_ENCODER)
        steer.closed_loop.pid(6.0, 0.0, 0.0).position_wrapping_enabled(True)
        self.drive.configure(drive, SAFE, PERSIST)
        self.steer.configure(steer, SAFE, PERSIST)
        self.turns, self.angle = self.drive.get_encoder(), self.steer.get_absolute_encoder()
        self.drive_loop, self.steer_loop = (m.get_closed_loop_controller() for m in (self.drive, self.steer))

    def position(self) -> wpimath.SwerveModulePosition:
        return wpimath.SwerveModulePosition(self.turns.get_position().get() * METERS_PER_TURN, self.heading())

    def heading(self) -> wpimath.Rotation2d:
        return wpimath.Rotation2d(math.tau * self.angle.get_position().get())

    def set_velocity(self, wanted: wpimath.SwerveModuleVelocity) -> None:
        wanted = wanted.optimize(self.heading())
        self.drive_loop.set_setpoint(60.0 * wanted.velocity / METERS_PER_TURN, CONTROL.VELOCITY)
        self.steer_loop.set_setpoint(wanted.angle.radians() / math.tau, CONTROL.POSITION)


class Robot(wpilib.TimedRobot):
    def __init__(self) -> None:
        super().__init__()
        self.modules = [Module(10 + k, 20 + k) for k in range(4)]
        self.gyro = Pigeon2(3, CANBus(""))
        self.pad = wpilib.Joystick(0)
        self.odometry = wpimath.SwerveDrive4Odometry(KINEMATICS, self.gyro.get_rotation2d(), self.positions())

    def positions(self) -> tuple:
        return tuple(m.position() for m in self.modules)

    def robot_periodic(self) -> None:
        self.odometry.update(self.gyro.get_rotation2d(), self.positions())

    def teleop_periodic(self) -> None:
        ahead, left, turn = (-self.pad.get_raw_axis(k) for k in (1, 0, 4))
        asked = wpimath.ChassisVelocities(3.0 * ahead, 3.0 * left, 3.0 * turn)
        wanted = KINEMATICS.to_swerve_module_velocities(asked)
        for module, velocity in zip(self.modules, wanted, strict=True):
            module.set_velocity(velocity)
