"""TalonFX on mechanisms: on the emulator, and on the real Phoenix 6 simulation in real time."""

from __future__ import annotations

import math

import pytest

REAL = pytest.param("", id="real", marks=[pytest.mark.slow, pytest.mark.realtime])


@pytest.fixture(scope="module", params=[pytest.param("1", id="simulated"), REAL])
def is_real(request):
    return not request.param


@pytest.fixture(scope="module")
def mechanisms(is_real, scenario):
    return scenario("mechanisms", SIMULATED="" if is_real else "1")


@pytest.fixture(scope="module")
def signs(is_real, scenario):
    return scenario("signs", SIMULATED="" if is_real else "1")


@pytest.mark.parametrize("name", ["shooter", "feeder", "hood", "arm"])
def test_a_closed_loop_settles_as_on_wpilibs_sim_of_the_same_plant(mechanisms, is_real, name):
    """Same device loop and plant: t90 within 20 ms (two frames of the 100 Hz control), equal final value."""
    row = mechanisms[name]
    assert row["t90"] == pytest.approx(row["t90_wpilib"], abs=0.020 if is_real or name == "arm" else 0.0051)
    assert row["end"] == pytest.approx(row["end_wpilib"], rel=0.005 if is_real or name == "arm" else 0.001)


def test_aligned_and_opposed_followers_turn_with_their_leader(mechanisms, is_real):
    """Aligned or opposed, a follower has the inversion of its leader, so all motors read the same speed."""
    assert mechanisms["followers"] == pytest.approx([mechanisms["shooter"]["end"]] * 3, abs=0.1 if is_real else 1e-6)


def test_a_hood_sags_under_its_weight_as_far_as_its_gains_allow(mechanisms):
    """Holding takes m g c cos(a) R / (kt gearing) = 0.015 V, so with kp = 120 V/turn it sags by 0.015 / 120 turns."""
    volts = 1.2 * 9.81 * 0.12 * math.cos(math.radians(41.75)) * 0.024845 / (90 * 0.0194)
    sag = 360.0 * volts / 120.0
    assert mechanisms["hood_deg"] == pytest.approx(360.0 * 42 / 360 - sag, abs=0.25)


def test_brake_mode_holds_a_hood_that_coast_mode_lets_fall(mechanisms):
    """At 0 V, the hood creeps in brake mode and falls m g c cos(a) t^2 / (2 J) = 1.3 degrees in 0.3 s in coast mode."""
    assert 41.0 < mechanisms["hood_after_brake_deg"] < 41.9
    assert 39.8 < mechanisms["hood_after_coast_deg"] < 41.0


def test_a_coasting_roller_runs_on_and_a_disabled_roller_brakes(mechanisms):
    assert mechanisms["feeder_after_coast_rps"] == pytest.approx(50.0, abs=0.5)
    assert mechanisms["feeder_after_disable_rps"] == pytest.approx(0.0, abs=0.5)


def test_positive_volts_raise_the_position_in_robot_code_for_every_inversion(signs):
    for row in signs["turned"]:
        sign = -1.0 if row["reversed"] else 1.0
        assert row["robot_rps"] == pytest.approx(48.0, rel=0.03), row  # 6 V of 12 V on 5800 rpm
        assert row["sim_rps"] == pytest.approx(sign * row["robot_rps"] / 2.0, rel=0.02), row
        assert row["robot_rotations"] == pytest.approx(sign * 2.0 * row["sim_rotations"], abs=0.6), row  # 10 ms old
        assert row["volts"] == pytest.approx(sign * 6.0, abs=0.1), row


def test_the_battery_sags_while_four_motors_start(signs):
    """4 motors with supply currents of 60-120 A through 20 mohm: a sag above 1 V, within the battery's limits."""
    assert 7.2 < signs["lowest_volts"] < 12.4


def test_values_beyond_the_range_of_the_device_model_are_wrapped_or_clamped(signs):
    position, velocity, supply = signs["far"]
    assert position == pytest.approx(20000.0 - 32768.0, abs=0.01)
    assert velocity == pytest.approx(159.9, abs=0.1)
    assert supply == pytest.approx(4.0, abs=0.1)


def test_a_cancoder_measures_the_shaft_for_any_direction_and_offset(signs):
    for angle, rate in signs["encoders"]:
        assert angle == pytest.approx(0.2, abs=0.001)
        assert rate == pytest.approx(0.5, abs=0.01)


def test_a_pigeon_yaw_continues_beyond_a_turn_and_its_rates_stay_within_range(signs, is_real):
    assert signs["gyro"] == pytest.approx([1000.0, 10.0, -5.0], abs=0.05)
    assert not is_real or signs["rate_dps"] == pytest.approx(2047.0, abs=1.0)
