"""Devices of any maker that nothing simulates are named."""

from __future__ import annotations

from importlib.util import find_spec


def test_the_warning_names_each_device_without_simulation_and_its_attribute(scenario):
    names = scenario("unserved")["names"]
    expected = ["I2C (intake.bus)"]
    if find_spec("playingwithfusion"):
        expected += ["CANVenom (intake.motor)", "TimeOfFlight (intake.sensors.0)"]
    if find_spec("rev"):
        expected.append("ServoHub 4 (intake.hub)")
    assert names == sorted(expected)
