"""Pushes a wall with all it has and nothing limited, and writes down what its roboRIO tells it."""

import wpilib
from measures import build
from phoenix6 import configs, controls, hardware, signals
from phoenix6.swerve import requests


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = build(slip_current=250.0)
        self.shooter = hardware.TalonFX(31)
        self.followers = [hardware.TalonFX(32), hardware.TalonFX(33), hardware.TalonFX(34)]
        limits = configs.CurrentLimitsConfigs()
        limits.stator_current_limit_enable = limits.supply_current_limit_enable = False
        for motor in (self.shooter, *self.followers, *(m.drive_motor for m in self.drivetrain.modules)):
            motor.configurator.apply(limits)
        for motor in self.followers:
            motor.set_control(controls.Follower(31, signals.MotorAlignmentValue.ALIGNED))
        self.push = requests.RobotCentric().with_velocity_x(4.9)
        self.seen: list[tuple[float, bool, bool]] = []

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(self.push)
        self.shooter.set_control(controls.VoltageOut(12.0))
        rio = wpilib.RobotController
        self.seen.append((rio.getBatteryVoltage(), rio.getEnabled6V(), rio.isBrownedOut()))
