"""CANdi, CANrange and TalonFXS: robot code reads the values of physics."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.realtime


@pytest.fixture(scope="module")
def read(scenario):
    return scenario("sensors")


def test_a_pulse_width_encoder_measures_the_shaft_angle_for_any_direction_and_offset(read):
    assert read["pwm"] == pytest.approx([0.3, 0.3], abs=0.002)
    assert read["pwm_velocity"] == pytest.approx([0.5, 0.5], abs=0.01)


def test_a_canrange_measures_the_true_distance(read):
    assert read["distance"] == pytest.approx(0.25, abs=0.002)


def test_a_talonfxs_closes_its_loop_on_its_own_encoder(read):
    """Ratios are 10 from rotor to encoder and 4 to the arm; the arm's weight leaves an error of 0.01 turns."""
    assert read["true_arm"] == pytest.approx(read["arm"], abs=0.001)
    assert read["arm"] == pytest.approx(0.2, abs=0.01)


def test_the_error_names_the_mistake_in_a_sensor_setting(read):
    assert "TalonFXS 4: motor_type is for a TalonFX; a TalonFXS has it in its configuration" in read["wrong_type"]
    assert read["wrong_pin"] == "CANdi 1: pin must be 1 or 2, got 3"
    assert "distance must be a number from 0 to 100 m, got -0.1" in read["too_near"]
