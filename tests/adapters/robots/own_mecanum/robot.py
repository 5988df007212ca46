"""A mecanum drive on Talon FX and MecanumDrive, with kinematics and odometry of WPILib."""

import math

import wpilib
import wpilib.drive
from phoenix6 import configs, controls, hardware, signals
from wpimath.geometry import Translation2d
from wpimath.kinematics import MecanumDriveKinematics, MecanumDriveOdometry, MecanumDriveWheelPositions

RATIO, CIRCUMFERENCE = 10.71, math.pi * 0.1524
NAMES = ("front_left", "front_right", "rear_left", "rear_right")


class Drive:
    def __init__(self) -> None:
        self.motors = {name: hardware.TalonFX(k + 1) for k, name in enumerate(NAMES)}
        for name, motor in self.motors.items():
            config = configs.TalonFXConfiguration()
            config.feedback.sensor_to_mechanism_ratio = RATIO / CIRCUMFERENCE  # positions in meters
            config.motor_output.neutral_mode = signals.NeutralModeValue.BRAKE
            if name.endswith("right"):
                config.motor_output.inverted = signals.InvertedValue.CLOCKWISE_POSITIVE
            motor.configurator.apply(config)
        setters = [self.setter(name) for name in ("front_left", "rear_left", "front_right", "rear_right")]
        self.mecanum = wpilib.drive.MecanumDrive(*setters)
        self.gyro = hardware.Pigeon2(9)
        corners = ((0.25, 0.27), (0.25, -0.27), (-0.25, 0.27), (-0.25, -0.27))
        self.kinematics = MecanumDriveKinematics(*(Translation2d(x, y) for x, y in corners))
        self.odometry = MecanumDriveOdometry(self.kinematics, self.gyro.getRotation2d(), self.positions())

    def setter(self, name: str):
        motor, request = self.motors[name], controls.DutyCycleOut(0.0)
        return lambda output: motor.set_control(request.with_output(output))

    def positions(self) -> MecanumDriveWheelPositions:
        found = MecanumDriveWheelPositions()
        found.frontLeft, found.frontRight, found.rearLeft, found.rearRight = (
            self.motors[name].get_position().value for name in NAMES
        )
        return found


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drive = Drive()
        self.pad = wpilib.Joystick(0)

    def robotPeriodic(self) -> None:
        self.drive.odometry.update(self.drive.gyro.getRotation2d(), self.drive.positions())

    def teleopPeriodic(self) -> None:
        axis = self.pad.getRawAxis
        self.drive.mecanum.driveCartesian(-0.5 * axis(1), 0.5 * axis(0), 0.5 * axis(4))
