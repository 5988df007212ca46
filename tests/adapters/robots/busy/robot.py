"""A MagicBot that takes its time: eleven motors configured and read back, slow components, and one very slow loop."""

import time

import magicbot
import measures
import wpilib
from phoenix6 import configs, controls, hardware


def compute(seconds: float) -> None:
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        pass


class Chassis:
    def setup(self) -> None:
        self.drivetrain = measures.build()

    def execute(self) -> None:
        self.drivetrain.set_control(measures.driver_request())


class Mechanisms:
    def setup(self) -> None:
        self.motors = [hardware.TalonFX(30 + k) for k in range(11)]
        for motor in self.motors:
            motor.configurator.apply(configs.TalonFXConfiguration())
            motor.configurator.refresh(configs.TalonFXConfiguration())
        compute(0.5)

    def execute(self) -> None:
        for motor in self.motors:
            motor.set_control(controls.VoltageOut(4.0))


class Robot(magicbot.MagicRobot):
    chassis: Chassis
    mechanisms: Mechanisms

    def createObjects(self) -> None:
        self.loops = 0
        compute(1.0)

    def robotInit(self) -> None:
        super().robotInit()
        compute(1.5)  # after physics is built, before the program says that it has started

    def robotPeriodic(self) -> None:
        super().robotPeriodic()
        self.loops += 1
        if self.loops == 50:
            compute(2.5)
        wpilib.SmartDashboard.putNumber("Loops", self.loops)
