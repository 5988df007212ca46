"""Devices of a program that nothing simulates, by name."""

from __future__ import annotations

import json
from importlib.util import find_spec

import hal
import wpilib

from simcore.robotcode.program.makers import watch_makers
from simcore.robotcode.program.object_graph import ObjectGraph
from simcore.robotcode.program.unserved import unserved_devices


class Intake:
    def __init__(self) -> None:
        self.gyro = wpilib.ADXRS450_Gyro()  # simulated
        self.bus = wpilib.I2C(wpilib.I2C.Port.kMXP, 0x10)
        if find_spec("playingwithfusion"):
            import playingwithfusion

            self.motor = playingwithfusion.CANVenom(7)
            self.sensors = [playingwithfusion.TimeOfFlight(8)]
        if find_spec("rev"):
            import rev

            self.spark = rev.SparkMax(3, rev.SparkMax.MotorType.kBrushless)  # simulated
            self.hub = rev.ServoHub(4)


class Robot:
    def __init__(self) -> None:
        self.intake = Intake()


def main() -> None:
    hal.initialize(500, 0)
    watch_makers()
    robot = Robot()
    print(json.dumps({"lateness_ms": 0.0, "names": unserved_devices(ObjectGraph(robot))}))


if __name__ == "__main__":
    main()
