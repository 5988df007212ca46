"""A TimedCommandRobot whose mechanisms are REV's: a SPARK MAX pair as a shooter, a SPARK Flex arm with an absolute
encoder, a follower, an intake; the drivetrain is CTRE's, a member of the container's dictionary."""

import commands2
import measures
import rev
import wpilib
from commands2 import Subsystem
from commands2.button import CommandXboxController
from phoenix6.swerve import requests

SAFE, PERSIST = rev.ResetMode.kResetSafeParameters, rev.PersistMode.kPersistParameters
BRUSHLESS = rev.SparkLowLevel.MotorType.kBrushless


class Shooter(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.leader, self.follower = rev.SparkMax(31, BRUSHLESS), rev.SparkMax(32, BRUSHLESS)
        config = rev.SparkMaxConfig()
        config.setIdleMode(rev.SparkBaseConfig.IdleMode.kCoast).smartCurrentLimit(60)
        config.closedLoop.P(0.0002).I(0).D(0)
        config.closedLoop.feedForward.kV(12.0 / 5676.0)
        self.leader.configure(config, SAFE, PERSIST)
        follower = rev.SparkMaxConfig()
        follower.follow(31, True)
        self.follower.configure(follower, SAFE, PERSIST)
        self.encoder, self.control = self.leader.getEncoder(), self.leader.getClosedLoopController()

    def spin(self) -> commands2.Command:
        velocity = rev.SparkLowLevel.ControlType.kVelocity
        return self.runEnd(lambda: self.control.setReference(3000.0, velocity), self.leader.stopMotor)


class Arm(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.motor = rev.SparkFlex(33, BRUSHLESS)
        config = rev.SparkFlexConfig()
        config.encoder.positionConversionFactor(1.0 / 50.0).velocityConversionFactor(1.0 / 50.0 / 60.0)
        config.closedLoop.P(4.0)
        config.softLimit.forwardSoftLimit(0.3).forwardSoftLimitEnabled(True)
        self.motor.configure(config, SAFE, PERSIST)
        self.encoder, self.control = self.motor.getEncoder(), self.motor.getClosedLoopController()
        self.absolute = self.motor.getAbsoluteEncoder()

    def to(self, turns: float) -> commands2.Command:
        return self.run(lambda: self.control.setReference(turns, rev.SparkLowLevel.ControlType.kPosition))


class Intake(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.roller = rev.SparkMax(34, BRUSHLESS)
        config = rev.SparkMaxConfig()
        config.setIdleMode(rev.SparkBaseConfig.IdleMode.kBrake).inverted(True).voltageCompensation(12.0)
        self.roller.configure(config, SAFE, PERSIST)

    def take_in(self) -> commands2.Command:
        return self.runEnd(lambda: self.roller.set(0.7), lambda: self.roller.set(0.0))


class Robot(commands2.TimedCommandRobot):
    def robotInit(self) -> None:
        self.parts = {"drive": measures.build(inverted_steer=True, coupling=3.57)}
        self.shooter, self.arm, self.intake = Shooter(), Arm(), Intake()
        self.pad = CommandXboxController(0)
        self.pad.x().whileTrue(self.shooter.spin())
        self.pad.y().onTrue(self.arm.to(0.25)).onFalse(self.arm.to(0.0))
        self.pad.a().whileTrue(self.intake.take_in())

    def robotPeriodic(self) -> None:
        super().robotPeriodic()
        wpilib.SmartDashboard.putNumber("Shooter rpm", self.shooter.encoder.getVelocity())
        wpilib.SmartDashboard.putNumber("Arm", self.arm.encoder.getPosition())

    def autonomousInit(self) -> None:
        self.auto = commands2.cmd.parallel(self.shooter.spin(), self.intake.take_in()).withTimeout(2.0)
        self.auto.schedule()

    def teleopPeriodic(self) -> None:
        request = requests.RobotCentric().with_velocity_x(-4.0 * self.pad.getLeftY())
        self.parts["drive"].set_control(
            request.with_velocity_y(-4.0 * self.pad.getLeftX()).with_rotational_rate(-4.0 * self.pad.getRightX())
        )

    def facts(self) -> dict:
        encoders = {"rpm": self.shooter.encoder, "roller": self.intake.roller.getEncoder()}
        return {"arm": self.arm.encoder.getPosition(), **{name: e.getVelocity() for name, e in encoders.items()}}
