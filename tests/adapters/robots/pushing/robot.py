"""Pushes a wall with all it has and nothing limited, and writes down what its roboRIO tells it."""

import wpilib
from measures import modules
from phoenix6 import configs, controls, hardware, signals, swerve
from phoenix6.swerve import requests


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        constants = swerve.SwerveDrivetrainConstants().with_can_bus_name("").with_pigeon2_id(9)
        self.drivetrain = swerve.SwerveDrivetrain(
            hardware.TalonFX, hardware.TalonFX, hardware.CANcoder, constants, modules(slip_current=250.0)
        )
        self.shooter = hardware.TalonFX(1)
        self.followers = [hardware.TalonFX(2), hardware.TalonFX(3), hardware.TalonFX(4)]
        limits = configs.CurrentLimitsConfigs()
        limits.stator_current_limit_enable = limits.supply_current_limit_enable = False
        for motor in (self.shooter, *self.followers, *(m.drive_motor for m in self.drivetrain.modules)):
            motor.configurator.apply(limits)
        for motor in self.followers:
            motor.set_control(controls.Follower(1, signals.MotorAlignmentValue.ALIGNED))
        self.push = requests.RobotCentric().with_velocity_x(4.9)
        self.seen: list[tuple[float, bool, bool]] = []

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(self.push)
        self.shooter.set_control(controls.VoltageOut(12.0))
        rio = wpilib.RobotController
        self.seen.append((rio.getBatteryVoltage(), rio.getEnabled6V(), rio.isBrownedOut()))
