"""Motors and battery at one voltage."""

from __future__ import annotations

import math

import pytest

from simcore.robot.dc_motor import motor
from simcore.robot.limited_motor import LimitedMotor
from simcore.robot.motor_bus import bus_voltage

M = LimitedMotor.of(motor("Kraken X60"), gearing=6.75, efficiency=0.9, friction_volts=0.1)


def test_bus_voltage_of_four_stalled_krakens():
    """Motors at full duty are R/4: 13.5 V * (R/4) / (R/4 + 0.02)."""
    r4 = M.resistance / 4
    bus = bus_voltage(13.5, 13.5, 0.02, 0.0, [M] * 4, [12.0] * 4, [math.inf] * 4, [0.0] * 4)
    assert bus == pytest.approx(13.5 * r4 / (r4 + 0.02), abs=0.02)


def test_bus_voltage_with_a_current_limit_is_constant_power():
    bus = bus_voltage(12.6, 12.6, 0.02, 10.0, [M] * 4, [12.0] * 4, [60.0] * 4, [3.0] * 4)
    power = 4 * 60.0 * (3.0 + 60.0 * M.resistance)
    assert bus == pytest.approx(12.6 - 0.02 * (10.0 + power / bus), abs=0.02)


def test_dead_battery_gives_zero():
    assert bus_voltage(0.0, 0.0, 0.02, 0.0, [M], [12.0], [60.0], [0.0]) == 0.0
