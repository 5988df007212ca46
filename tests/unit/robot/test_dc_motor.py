"""The motor table."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from simcore.errors import ConfigError, UnknownNameError
from simcore.robot.dc_motor import MOTOR_NAMES, motor


def test_table_is_all_of_wpilib():
    from wpimath.system.plant import DCMotor

    factories = {n for n in dir(DCMotor) if isinstance(getattr(DCMotor, n), object) and not n.startswith("_")}
    made = set()
    for name in factories:
        try:
            made.add(name) if isinstance(getattr(DCMotor, name)(1), DCMotor) else None
        except (TypeError, AttributeError):
            continue
    assert len(MOTOR_NAMES) == len(made - {"withReduction"})


@pytest.mark.parametrize(
    ("name", "torque", "amps", "rpm"),
    [("Kraken X60", 7.09, 366, 6000), ("Kraken X60 FOC", 9.37, 483, 5800), ("NEO Vortex", 3.6, 211, 6784)],
)
def test_figures_are_the_datasheet(name, torque, amps, rpm):
    m = motor(name)
    assert (m.stall_torque, m.stall_current) == (torque, amps)
    assert m.free_speed * 60 / math.tau == pytest.approx(rpm)
    assert m.kt * amps == pytest.approx(torque)
    # At free speed and nominal voltage exactly the free current flows.
    assert (12.0 - m.free_speed / m.kv) / m.resistance == pytest.approx(m.free_current)


def test_names_are_forgiving_and_errors_helpful():
    assert motor("kraken-x60") is motor("Kraken X60")
    with pytest.raises(UnknownNameError, match="Kraken X60"):
        motor("Kraken X6")


@pytest.mark.parametrize(
    "wrong", [{"stall_current": math.inf}, {"stall_torque": 0.0}, {"nominal_voltage": 0.0}, {"free_current": 400.0}]
)
def test_a_motor_without_resistance_cannot_be_written(wrong):
    with pytest.raises(ConfigError):
        replace(motor("Kraken X60"), **wrong)
