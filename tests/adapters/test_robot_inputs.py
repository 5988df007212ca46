"""Battery values that robot code reads, on the simulated HAL."""

from __future__ import annotations

import math

import pytest

pytest.importorskip("pyfrc", reason="needs pyfrc: pip install .[robotpy]")

from wpilib import PowerDistribution, RobotController

from simcore import Match
from simcore.loop.battery import draw
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robotcode.sim.robot_physics import LatenessReport
from simcore.robotcode.sim.robot_power import PowerDistributionView, RoboRioPower


def test_a_brownout_switches_the_rails_off_and_is_counted():
    battery = Battery(BatteryConfig(recovery_resistance=0.0))
    power = RoboRioPower(battery)
    before = RobotController.getFaultCount6V()
    for _ in range(2):
        draw(battery.records, 0, 0.02, 400.0, math.nan)  # one heartbeat later the motors react
        power.show_voltage()
        power.show_rails()
        assert RobotController.getBatteryVoltage() == pytest.approx(battery.voltage)
        assert battery.voltage < 6.75
        assert (
            RobotController.isBrownedOut() and not RobotController.getEnabled6V() and not RobotController.getEnabled5V()
        )
        draw(battery.records, 0, 0.02, 0.0, math.nan)
        power.show_rails()
        assert not RobotController.isBrownedOut() and RobotController.getEnabled6V() and RobotController.getEnabled3V3()
    assert RobotController.getFaultCount6V() == before + 2


def test_robot_code_can_set_the_brownout_voltage_of_a_roborio_2():
    battery = Battery(BatteryConfig(recovery_resistance=0.0))
    power = RoboRioPower(battery)
    RobotController.setBrownoutVoltage(9.0)
    power.show_voltage()
    draw(battery.records, 0, 0.02, 200.0, math.nan)  # 12.9 V - 20 mohm x 200 A = 8.9 V
    assert battery.voltage == pytest.approx(8.9, abs=0.01) and RobotController.isBrownedOut()
    RobotController.setBrownoutVoltage(6.75)


def test_the_power_panel_shows_the_battery_current_by_channel():
    """Four drive motors accelerate: all of the battery current is on their channels."""
    panel = PowerDistribution(1, PowerDistribution.ModuleType.kRev)
    with Match.bare() as match:
        robot = match.robots[0]
        view = PowerDistributionView(robot)
        robot.drive.set_volts([6.0] * 4, [0.0] * 4)
        match.play(0.1)
        view.update()
        channels = [panel.getCurrent(channel) for channel in range(24)]
        assert min(channels[:4]) > 10.0 and channels[8:] == [0.0] * 16
        assert panel.getTotalCurrent() == pytest.approx(robot.battery.current, rel=0.02)
        assert panel.getVoltage() == pytest.approx(robot.battery.voltage)


def test_the_total_lateness_of_a_run_is_reported_in_one_sentence(caplog):
    report = LatenessReport(every=0.0, start=0.0)
    report.note(0.5, tick_ms=4.0)
    quiet = LatenessReport(every=60.0, start=0.0)
    for _ in range(100):
        quiet.note(0.1, tick_ms=31.0)
    said = [r.getMessage() for r in caplog.records]
    assert len(said) == 2 and "0.50 s" in said[0] and "robot tests are not affected" in said[1]
    assert "busy with other programs or robot code blocks" in said[0]
    assert "the computer is too slow: physics alone takes 31 ms for a tick of 20 ms" in said[1]
    assert quiet.given_up == pytest.approx(9.9)  # for the next report
