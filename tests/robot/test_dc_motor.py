"""Table of motors and linear model of a motor."""

import math
from dataclasses import replace

import pytest
from each_case import each
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError, UnknownNameError
from simcore.loop.motor import line_in_force
from simcore.robot.dc_motor import MOTOR_NAMES, as_motor, motor
from simcore.robot.wheel_config import LimitedMotor


def test_the_table_holds_all_motors_of_wpilib_to_the_last_bit():
    plant = pytest.importorskip("wpimath.system.plant")
    theirs = [m for name in dir(plant.DCMotor) if isinstance(m := _one(plant.DCMotor, name), plant.DCMotor)]
    assert len(MOTOR_NAMES) == len(theirs)
    assert {_figures(as_motor(m)) for m in theirs} == {_figures(motor(name)) for name in MOTOR_NAMES}


def _one(kinds, name):
    try:
        return getattr(kinds, name)(1)
    except (TypeError, AttributeError):
        return None


def _figures(m):
    return m.nominal_voltage, m.stall_torque, m.stall_current, m.free_current, m.free_speed, m.resistance, m.kt, m.kv


def test_an_object_that_is_not_a_motor_is_refused():
    with pytest.raises(ConfigError, match="DCMotor; got"):
        as_motor("Kraken X60")


@each(
    ("name", "torque", "amps", "rpm"),
    [("Kraken X60", 7.09, 366, 6000), ("Kraken X60 FOC", 9.37, 483, 5800), ("NEO Vortex", 3.6, 211, 6784)],
)
def test_the_motor_constants_match_the_datasheet(name, torque, amps, rpm):
    m = motor(name)
    assert (m.stall_torque, m.stall_current) == (torque, amps)
    assert m.free_speed * 60 / math.tau == pytest.approx(rpm)
    assert m.kt * amps == pytest.approx(torque)
    # At the free speed and nominal voltage, exactly the free current flows.
    assert (12.0 - m.free_speed / m.kv) / m.resistance == pytest.approx(m.free_current)


def test_a_motor_name_matches_in_any_case_or_spacing_and_errors_suggest_a_name():
    assert motor("kraken-x60") is motor("Kraken X60")
    with pytest.raises(UnknownNameError, match="Kraken X60"):
        motor("Kraken X6")


@each("wrong", [{"stall_current": math.inf}, {"stall_torque": 0.0}, {"nominal_voltage": 0.0}, {"free_current": 400.0}])
def test_a_motor_with_invalid_figures_is_refused(wrong):
    with pytest.raises(ConfigError):
        replace(motor("Kraken X60"), **wrong)


def test_a_falcon_has_the_stall_torque_and_current_of_the_vendors_dynamometer():
    """At 4 V it has 2.15 N m and draws 39 A from a 12 V supply; at 12 V, 4.69 N m and 257 A (motors.vex.com)."""
    m = LimitedMotor.of(motor("Falcon 500"), gearing=1.0)
    for volts, torque, supply in ((4.0, 2.15, 39.0), (12.0, 4.69, 257.0)):
        at, resistance = line_in_force(volts, 12.0, 0.0, math.inf, m.resistance, m.winding)
        amps = at / resistance
        assert amps * m.torque_driving == pytest.approx(torque, rel=0.005)
        assert amps * at / 12.0 == pytest.approx(supply, rel=0.01)


@given(
    volts=st.floats(-12.0, 12.0),
    bus=st.floats(6.0, 13.0),
    emf=st.floats(-14.0, 14.0),
    limit=st.floats(5.0, 400.0),
    share=st.floats(0.0, 0.9),
)
def test_a_smaller_duty_cycle_never_draws_more_than_the_full_duty_cycle(volts, bus, emf, limit, share):
    """Driving, a motor draws the least of (V - e) / R_winding, (V_bus - e) / R and the limit; braking, the first."""
    model = motor("Kraken X60")
    m = LimitedMotor.of(replace(model, supply_resistance=share * model.resistance), gearing=1.0)
    at, resistance = line_in_force(volts, bus, emf, limit, m.resistance, m.winding)
    volts = max(-bus, min(bus, volts))
    amps = (at - emf) / resistance
    if (volts - emf) * volts > 0.0:
        full = abs(math.copysign(bus, volts) - emf) / m.resistance
        assert min(abs(amps), limit) == pytest.approx(min(abs(volts - emf) / m.winding, full, limit))
    else:
        assert amps == pytest.approx((volts - emf) / m.winding)


def test_the_supply_resistance_must_be_below_the_total_resistance():
    model = motor("Falcon 500")
    with pytest.raises(ConfigError, match="supply_resistance"):
        replace(model, supply_resistance=model.resistance)
