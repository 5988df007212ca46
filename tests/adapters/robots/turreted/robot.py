"""Turret that aims by odometry, a shooter with two wheels at different speeds, and an intake at each end.

No mechanism is that of the default robot; simcore.toml describes all of them.
"""

import math

import measures
import wpilib
from phoenix6 import controls, hardware
from wpimath.geometry import Pose2d, Translation2d

A, B, X = 1, 2, 3
HUB = Translation2d(4.625, 4.035)
LOWER, UPPER = 28.0, 22.0  # [turns/s]


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build()
        self.drivetrain.reset_pose(Pose2d(1.6, 5.96, 0.0))
        self.lower = measures.talon(31, k_v=0.125, k_p=0.4)
        self.upper = measures.talon(32, k_v=0.125, k_p=0.4)
        self.turret = measures.talon(33, ratio=20.0, k_p=60.0, k_d=0.5)
        self.feeder = measures.talon(34, ratio=2.0)
        self.kicker = measures.talon(35, ratio=2.0)
        self.front = hardware.TalonFX(36)
        self.back = hardware.TalonFX(37)

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(measures.driver_request())
        pressed = wpilib.DriverStation.getStickButton
        self.front.set_control(controls.VoltageOut(8.0 if pressed(0, A) else 0.0))
        self.back.set_control(controls.VoltageOut(8.0 if pressed(0, B) else 0.0))
        shoots = pressed(0, X)
        self.lower.set_control(controls.VelocityVoltage(LOWER if shoots else 0.0))
        self.upper.set_control(controls.VelocityVoltage(UPPER if shoots else 0.0))
        self.aim()
        is_fast = self.lower.get_velocity().value > 0.97 * LOWER and self.upper.get_velocity().value > 0.97 * UPPER
        for motor in (self.feeder, self.kicker):
            motor.set_control(controls.VoltageOut(6.0 if shoots and is_fast else 0.0))

    def aim(self) -> None:
        pose = self.drivetrain.get_state().pose
        way = HUB - pose.translation()
        turn = math.remainder(way.angle().radians() - pose.rotation().radians(), math.tau)
        self.turret.set_control(controls.PositionVoltage(turn / math.tau))
