"""The adapters of `simcore.phoenix6` work on the emulator unchanged: the scenarios of the real devices, in no time."""

from __future__ import annotations

import math

import pytest


@pytest.fixture(scope="module")
def mechanisms(scenario):
    return scenario("mechanisms", SIMULATED="1")


@pytest.fixture(scope="module")
def signs(scenario):
    return scenario("signs", SIMULATED="1")


@pytest.mark.parametrize("name", ["shooter", "feeder", "hood", "elevator", "rack"])
def test_a_closed_loop_settles_as_on_wpilibs_sim_of_the_same_plant(mechanisms, name):
    row = mechanisms[name]
    # the twin holds the volts that keep the rack within 120 A for a step, the mechanism keeps the current itself
    assert row["t90"] == pytest.approx(row["t90_wpilib"], abs=0.0101 if name == "rack" else 0.0051)
    assert row["end"] == pytest.approx(row["end_wpilib"], rel=0.001)


def test_followers_turn_with_their_leader_also_the_opposed_one(mechanisms):
    assert mechanisms["followers"] == pytest.approx([mechanisms["shooter"]["end"]] * 3, abs=1e-6)


def test_neutral_modes_are_told_apart(mechanisms):
    """A braked hood creeps at 0.5 deg/s, an open one falls; an open roller runs on, a disabled one brakes."""
    assert 41.0 < mechanisms["hood_after_brake_deg"] < 41.9
    assert 39.8 < mechanisms["hood_after_coast_deg"] < 41.0
    assert mechanisms["feeder_after_coast_rps"] == pytest.approx(50.0, abs=0.5)
    assert mechanisms["feeder_after_disable_rps"] == pytest.approx(0.0, abs=0.5)


def test_positive_volts_raise_what_robot_code_reads_for_every_inversion(signs):
    for row in signs["turned"]:
        sign = -1.0 if row["reversed"] else 1.0
        assert row["robot_rps"] == pytest.approx(48.0, rel=0.03), row
        assert row["sim_rps"] == pytest.approx(sign * row["robot_rps"] / 2.0, rel=0.02), row
        assert row["volts"] == pytest.approx(sign * 6.0, abs=0.1), row


def test_sensors_read_what_physics_wrote(signs):
    assert signs["far"] == pytest.approx([-12768.0, 159.9, 4.0])
    for angle, rate in signs["encoders"]:
        assert (angle, rate) == (pytest.approx(0.2), pytest.approx(0.5))
    assert signs["gyro"] == pytest.approx([1000.0, 10.0, -5.0])
    assert math.isfinite(signs["rate_dps"])
