"""Robot programs as teams write them, made of short sources: what is told apart here is how a program drives.

`source(name)` is a robot.py; each differs from one of three by the lines that its habit changes.
"""

from __future__ import annotations

SWERVE = """
import math
import rev
import wpilib
from wpilib import RobotBase
from wpimath.controller import PIDController
from wpimath.estimator import SwerveDrive4PoseEstimator
from wpimath.geometry import Pose2d, Rotation2d, Translation2d
from wpimath.kinematics import (
    ChassisSpeeds, SwerveDrive4Kinematics, SwerveDrive4Odometry, SwerveModulePosition, SwerveModuleState)

X = Y = 0.28
KIN = SwerveDrive4Kinematics(Translation2d(X, Y), Translation2d(X, -Y), Translation2d(-X, Y), Translation2d(-X, -Y))
METERS = 0.1016 * math.pi / 6.75
TURNS = math.tau / 21.43
BRUSHLESS = rev.SparkLowLevel.MotorType.kBrushless


class Module:
    def __init__(self, k):
        self.drive = rev.SparkMax(2 * k + 1, BRUSHLESS)
        self.steer = rev.SparkMax(2 * k + 2, BRUSHLESS)
        c = rev.SparkMaxConfig()
        c.encoder.positionConversionFactor(METERS).velocityConversionFactor(METERS / 60)
        c.closedLoop.pid(0.1, 0, 0)
        c.closedLoop.feedForward.kV(2.4)
        self.drive.configure(c, rev.ResetMode.kResetSafeParameters, rev.PersistMode.kNoPersistParameters)
        c = rev.SparkMaxConfig()
        c.encoder.positionConversionFactor(TURNS).velocityConversionFactor(TURNS / 60)
        c.closedLoop.pid(1.0, 0, 0).positionWrappingEnabled(True).positionWrappingInputRange(-math.pi, math.pi)
        self.steer.configure(c, rev.ResetMode.kResetSafeParameters, rev.PersistMode.kNoPersistParameters)

    def angle(self):
        return Rotation2d(self.steer.getEncoder().getPosition())

    def get_position(self):
        return SwerveModulePosition(self.drive.getEncoder().getPosition(), self.angle())

    def steer_to(self, angle):
        self.steer.getClosedLoopController().setReference(angle.radians(), rev.SparkLowLevel.ControlType.kPosition)

    def go(self, state):
        state.optimize(self.angle())
        self.drive.getClosedLoopController().setReference(state.speed, rev.SparkLowLevel.ControlType.kVelocity)
        self.steer_to(state.angle)


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.modules = [Module(k) for k in range(4)]
        self.gyro, self.pad = wpilib.ADXRS450_Gyro(), wpilib.XboxController(0)
        self.odometry = SwerveDrive4Odometry(KIN, self.heading(), self.positions())

    def heading(self):
        return self.gyro.getRotation2d()

    def positions(self):
        return tuple(m.get_position() for m in self.modules)

    def robotPeriodic(self):
        self.odometry.update(self.heading(), self.positions())

    def teleopPeriodic(self):
        speeds = ChassisSpeeds(-3 * self.pad.getLeftY(), -3 * self.pad.getLeftX(), -2 * self.pad.getRightX())
        for module, state in zip(self.modules, KIN.toSwerveModuleStates(speeds)):
            module.go(state)
"""
TANK = """
import math
import rev
import wpilib
from wpilib.drive import DifferentialDrive
from wpimath.kinematics import DifferentialDriveOdometry

FACTOR = 0.1524 * math.pi / 8.45


def spark(number, inverted=False, leader=None):
    motor = rev.SparkMax(number, rev.SparkLowLevel.MotorType.kBrushless)
    c = rev.SparkMaxConfig().setIdleMode(rev.SparkBaseConfig.IdleMode.kBrake)
    c.encoder.positionConversionFactor(FACTOR).velocityConversionFactor(FACTOR / 60)
    c.inverted(inverted) if leader is None else c.follow(leader)
    motor.configure(c, rev.ResetMode.kResetSafeParameters, rev.PersistMode.kNoPersistParameters)
    return motor


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.motorL1, self.motorL2 = spark(1), spark(2, leader=1)
        self.motorR1, self.motorR2 = spark(3, True), spark(4, leader=3)
        self.drive = DifferentialDrive(self.motorL1, self.motorR1)
        self.gyro, self.pad = wpilib.ADXRS450_Gyro(), wpilib.XboxController(0)
        self.odometry = DifferentialDriveOdometry(self.gyro.getRotation2d(), 0.0, 0.0)

    def robotPeriodic(self):
        left, right = self.motorL1.getEncoder().getPosition(), self.motorR1.getEncoder().getPosition()
        self.odometry.update(self.gyro.getRotation2d(), left, right)

    def teleopPeriodic(self):
        self.drive.arcadeDrive(-self.pad.getLeftY(), -self.pad.getRightX(), False)
"""
MECANUM = """
import math
import rev
import wpilib
from wpilib.drive import MecanumDrive
from wpimath.geometry import Translation2d
from wpimath.kinematics import MecanumDriveKinematics, MecanumDriveOdometry, MecanumDriveWheelPositions

FACTOR = 0.1524 * math.pi / 8.45
PLACES = [(0.26, 0.28), (0.26, -0.28), (-0.26, 0.28), (-0.26, -0.28)]
KIN = MecanumDriveKinematics(*(Translation2d(*place) for place in PLACES))


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.wheels = []
        for number in (1, 2, 3, 4):
            motor = rev.SparkMax(number, rev.SparkLowLevel.MotorType.kBrushless)
            c = rev.SparkMaxConfig().inverted(number in (2, 4))
            c.encoder.positionConversionFactor(FACTOR).velocityConversionFactor(FACTOR / 60)
            motor.configure(c, rev.ResetMode.kResetSafeParameters, rev.PersistMode.kNoPersistParameters)
            self.wheels.append(motor)
        fl, fr, rl, rr = self.wheels
        self.drive = MecanumDrive(fl, rl, fr, rr)
        self.gyro, self.pad = wpilib.ADXRS450_Gyro(), wpilib.XboxController(0)
        self.odometry = MecanumDriveOdometry(KIN, self.gyro.getRotation2d(), self.positions())

    def positions(self):
        now = MecanumDriveWheelPositions()
        now.frontLeft, now.frontRight, now.rearLeft, now.rearRight = (
            motor.getEncoder().getPosition() for motor in self.wheels)
        return now

    def robotPeriodic(self):
        self.odometry.update(self.gyro.getRotation2d(), self.positions())

    def teleopPeriodic(self):
        self.drive.driveCartesian(-self.pad.getLeftY(), -self.pad.getLeftX(), -self.pad.getRightX())
"""
_RIO = (
    "self.steer.getClosedLoopController().setReference(angle.radians(), rev.SparkLowLevel.ControlType.kPosition)",
    "self.steer.setVoltage({sign}self.loop.calculate(self.angle().radians(), angle.radians()))",
)
_LOOP = (
    "    def angle(self):",
    "        self.loop = PIDController(3.0, 0, 0)\n        self.loop.enableContinuousInput(-math.pi, math.pi)\n{more}\n    def angle(self):",
)
_DIO = (
    "return Rotation2d(self.steer.getEncoder().getPosition())",
    "return Rotation2d.fromRotations({sign}self.azimuth.get())",
)
_SIM_WRITES = (
    "    def teleopPeriodic(self):",
    "    def {hook}(self):\n        for k, motor in enumerate(m for module in self.modules for m in (module.drive, module.steer)):\n"
    "            self.sims[k].iterate(motor.getAppliedOutput() * 12.0, 12.0, 0.02)\n"
    "            self.sims[k].getRelativeEncoderSim().setPosition(0.1)\n\n    def teleopPeriodic(self):",
)
_SIMS = (
    "        self.odometry = ",
    "        from wpimath.system.plant import DCMotor\n"
    "        self.sims = [rev.{cls}(m, DCMotor.NEO()) for module in self.modules for m in (module.drive, module.steer)]\n"
    "        self.odometry = ",
)
_MOVES_ITSELF = (
    "        self.odometry.update(self.heading(), self.positions())",
    "        self.odometry.update(self.heading(), self.positions())\n        if RobotBase.isSimulation():\n"
    "            p = self.odometry.getPose()\n            v = 0.7 * self.asked\n"
    "            self.odometry.resetPosition(self.heading(), self.positions(), Pose2d(p.x, p.y + 0.02 * v, p.rotation()))",
)
_ASKED = (
    "        for module, state in",
    "        self.asked = -3 * self.pad.getLeftX()\n        for module, state in",
)


def _with(text: str, *changes: tuple[str, str], **words: str) -> str:
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new.format(**words) if words else new, 1)
    return text


_IDLE = ("        self.modules = [", "        self.asked = 0.0\n        self.modules = [")
_AZIMUTH = "        self.azimuth = wpilib.DutyCycleEncoder(k)\n"
CLEAN: dict[str, str] = {
    "loops on SPARKs": SWERVE,
    "SparkSim in simulationPeriodic": _with(
        _with(SWERVE, _SIMS, cls="SparkSim"), _SIM_WRITES, hook="simulationPeriodic"
    ),
    "SparkMaxSim in _simulationPeriodic": _with(
        _with(SWERVE, _SIMS, cls="SparkMaxSim"), _SIM_WRITES, hook="_simulationPeriodic"
    ),
    "loops on the roboRIO, DIO encoders": _with(
        _with(_with(SWERVE, _RIO, sign=""), _LOOP, more=_AZIMUTH), _DIO, sign=""
    ),
    "steer motors turn the other way": _with(
        _with(_with(SWERVE, _RIO, sign="-"), _LOOP, more=_AZIMUTH), _DIO, sign=""
    ),
    "encoders count clockwise": _with(_with(_with(SWERVE, _RIO, sign=""), _LOOP, more=_AZIMUTH), _DIO, sign="-"),
    "places in inches": _with(SWERVE, ("X = Y = 0.28", "X = Y = 11.0"), ("getRightX())", "getRightX() * 0)")),
    "a pose that the program moves in simulation": _with(SWERVE, _MOVES_ITSELF, _ASKED, _IDLE),
    "an estimator": _with(SWERVE, ("SwerveDrive4Odometry(KIN, self.heading(), self.positions())",
                                   "SwerveDrive4PoseEstimator(KIN, self.heading(), self.positions(), Pose2d())")),
    "tank of motors L1 and R1": TANK,
    "tank of lDrive and rDrive": TANK.replace("motorL", "lDrive").replace("motorR", "rDrive"),
    "tank of fl_motor and rr_motor": TANK.replace("motorL1", "fl_motor").replace("motorL2", "rl_motor")
    .replace("motorR1", "fr_motor").replace("motorR2", "rr_motor"),
    "mecanum": MECANUM,
}  # fmt: skip
"""Programs with which nothing is wrong, by their habit: belief holds with no line of code."""

FAULTS: dict[str, tuple[str, str, str]] = {
    "a gyro that is not negated": (
        _with(SWERVE, ("return self.gyro.getRotation2d()", "return Rotation2d.fromDegrees(self.gyro.getAngle())")),
        "",
        "gyro is not negated",
    ),
    "wheels of another size": (SWERVE, "drive_gearing = 6.75\nwheel_diameter = 0.13", "wheel size"),
    "zeros that differ": (SWERVE, "zeros_deg = [40.0, 40.0, 40.0, 40.0]", "zeros"),
    "a tank that drives backward": (
        _with(TANK, ("getRotation2d(), left, right)", "getRotation2d(), -left, -right)")),
        "",
        "goes the other way",
    ),
    "a heading in degrees": (
        _with(SWERVE, ("return self.gyro.getRotation2d()", "return Rotation2d(0.5 * self.gyro.getRotation2d().radians())")),
        "",
        "times as far",
    ),
}  # fmt: skip
"""Programs with an error: source, keys of [drivetrain], and what the warning says."""
