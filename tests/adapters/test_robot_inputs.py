"""What robot code sees of a battery, on the simulated HAL."""

from __future__ import annotations

import pytest

pytest.importorskip("pyfrc", reason="needs pyfrc: pip install simcore[robotpy]")

from wpilib import RobotController

from simcore.robot.battery import Battery, BatteryConfig
from simcore.robotpy.robot_inputs import RoboRioPower


def test_a_brown_out_switches_the_rails_and_counts():
    battery = Battery(BatteryConfig(recovery_resistance=0.0))
    power = RoboRioPower(battery)
    before = RobotController.getFaultCount6V()
    for _ in range(2):
        battery.step(0.005, 400.0)
        power.show_voltage()
        power.show_rails()
        assert RobotController.getBatteryVoltage() == pytest.approx(battery.voltage)
        assert battery.voltage < 6.75
        assert not RobotController.getEnabled6V() and not RobotController.getEnabled5V()
        battery.step(0.005, 0.0)
        power.show_rails()
        assert RobotController.getEnabled6V() and RobotController.getEnabled3V3()
    assert RobotController.getFaultCount6V() == before + 2
