"""The loop solves for the bus voltage at which battery and motors balance."""

import math

import pytest

from simcore.loop.battery import bus_voltage
from simcore.loop.robot_state import SHAFT, records
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.dc_motor import motor
from simcore.robot.wheel_config import LimitedMotor
from simcore.robot.wheeled_drive import set_motor

# --- battery and motors ---------------------------------------------------------------------------------------------

KRAKEN = LimitedMotor.of(motor("Kraken X60"), gearing=6.75, efficiency=0.9, friction_volts=0.1)


def bus_of(voltage, *, speed=0.0, limit=math.inf, other=0.0):
    """Return the bus voltage [V] of a rested battery of 0.02 ohm with four Krakens at 12 V."""
    battery = Battery(BatteryConfig(full_voltage=voltage, empty_voltage=0.0, resistance=0.02))
    shafts = records(SHAFT, 4)
    for k in range(4):
        set_motor(shafts[k : k + 1], KRAKEN)
    shafts["wanted"], shafts["limit"], shafts["speed"] = 12.0, limit, speed
    return bus_voltage(battery.records, 0, voltage, other, shafts, 0, 4)


def test_four_stalled_krakens_lower_the_bus_voltage_like_a_resistor():
    """Motors at full duty act as R/4: 13.5 V * (R/4) / (R/4 + 0.02)."""
    r4 = KRAKEN.resistance / 4
    assert bus_of(13.5) == pytest.approx(13.5 * r4 / (r4 + 0.02), abs=1e-3)


def test_a_current_limit_makes_the_motors_a_constant_power_load():
    bus = bus_of(12.6, speed=3.0 / KRAKEN.emf, limit=60.0, other=10.0)
    power = 4 * 60.0 * (3.0 + 60.0 * KRAKEN.resistance)
    assert bus == pytest.approx(12.6 - 0.02 * (10.0 + power / bus), abs=1e-3)


def test_the_bus_voltage_of_a_dead_battery_is_zero():
    assert bus_of(0.0) == 0.0
