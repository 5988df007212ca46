"""MagicBot with a drivetrain in a component, driven by torque current, with inverted steer motors."""

import magicbot
import measures
import wpilib


class Chassis:
    def setup(self) -> None:
        self.hardware = measures.build(torque_current=True, coupling=3.57)

    def execute(self) -> None:
        if wpilib.DriverStation.isEnabled():
            self.hardware.set_control(measures.driver_request())


class Robot(magicbot.MagicRobot):
    chassis: Chassis

    def createObjects(self) -> None:
        pass
