"""Motors whose attributes say what they turn, in the ways in which teams write them."""

import measures
import wpilib
from phoenix6 import hardware

LIFT_MOTOR = hardware.TalonFX(40)


class Shooter:
    def __init__(self) -> None:
        self.shooterMotorTop, self.bottom = hardware.TalonFX(31), hardware.TalonFX(32)


class IntakeSubsystem:
    def __init__(self) -> None:
        self.motor = hardware.TalonFX(33)
        self.m_pivotTalonFX = hardware.TalonFX(34)


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.drivetrain = measures.build()
        self.shooter, self.intake = Shooter(), IntakeSubsystem()
        self.Feeder1Motor = hardware.TalonFX(35)
        self.WristMotor = hardware.TalonFX(36)
        self.all = [hardware.TalonFX(37)]
