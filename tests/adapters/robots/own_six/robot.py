"""Six modules on a long frame, SPARK Flex for both motors, absolute encoders wired to them, offsets in the code."""

import math

import rev
import wpilib
from wpimath.geometry import Rotation2d, Translation2d
from wpimath.kinematics import ChassisSpeeds, SwerveDrive6Kinematics, SwerveDrive6Odometry, SwerveModulePosition

SAFE, PERSIST = rev.ResetMode.kResetSafeParameters, rev.PersistMode.kPersistParameters
BRUSHLESS, ControlType = rev.SparkLowLevel.MotorType.kBrushless, rev.SparkLowLevel.ControlType
PLACES = ((0.32, 0.26), (0.32, -0.26), (0.0, 0.3), (0.0, -0.3), (-0.32, 0.26), (-0.32, -0.26))
TURN = math.tau * 0.0508 / 5.9


class Wheel:
    def __init__(self, k: int) -> None:
        self.motors = (rev.SparkFlex(10 + k, BRUSHLESS), rev.SparkFlex(20 + k, BRUSHLESS))
        drive, steer = rev.SparkFlexConfig(), rev.SparkFlexConfig()
        drive.encoder.positionConversionFactor(TURN).velocityConversionFactor(TURN / 60.0)
        drive.closedLoop.pid(0.05, 0.0, 0.0).feedForward.kV(2.1)
        drive.smartCurrentLimit(50)
        steer.absoluteEncoder.positionConversionFactor(math.tau)
        steer.closedLoop.setFeedbackSensor(rev.FeedbackSensor.kAbsoluteEncoder).pid(0.8, 0.0, 0.0)
        steer.closedLoop.positionWrappingEnabled(True).positionWrappingInputRange(0.0, math.tau)
        for motor, config in zip(self.motors, (drive, steer), strict=True):
            motor.configure(config, SAFE, PERSIST)
        self.loops = [motor.getClosedLoopController() for motor in self.motors]
        self.encoders = (self.motors[0].getEncoder(), self.motors[1].getAbsoluteEncoder())
        self.offset = 0.4 * k

    def swerve_position(self) -> SwerveModulePosition:
        return SwerveModulePosition(
            self.encoders[0].getPosition(), Rotation2d(self.encoders[1].getPosition() + self.offset)
        )

    def drive(self, state) -> None:
        state.optimize(self.swerve_position().angle)
        self.loops[0].setReference(state.speed, ControlType.kVelocity)
        self.loops[1].setReference((state.angle.radians() - self.offset) % math.tau, ControlType.kPosition)


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.wheels = [Wheel(k) for k in range(6)]
        self.gyro = wpilib.AnalogGyro(0)
        self.kinematics = SwerveDrive6Kinematics(*(Translation2d(*place) for place in PLACES))
        self.odometry = SwerveDrive6Odometry(self.kinematics, self.gyro.getRotation2d(), self.positions())
        self.pad = wpilib.Joystick(0)

    def positions(self) -> tuple:
        return tuple(wheel.swerve_position() for wheel in self.wheels)

    def robotPeriodic(self) -> None:
        self.odometry.update(self.gyro.getRotation2d(), self.positions())

    def teleopPeriodic(self) -> None:
        axis = self.pad.getRawAxis
        speeds = ChassisSpeeds(-3.0 * axis(1), -3.0 * axis(0), -3.0 * axis(4))
        for wheel, state in zip(self.wheels, self.kinematics.toSwerveModuleStates(speeds), strict=True):
            wheel.drive(state)
