"""Talon SRX and Victor SPX: their outputs are those of CTRE's simulation, their motion that of closed forms."""

from __future__ import annotations

import math
from importlib.util import find_spec

import pytest


@pytest.fixture(scope="module")
def talons(scenario):
    if find_spec("phoenix5") is None:
        pytest.skip("needs phoenix5: pip install .[phoenix5]")
    return scenario("talon_srx")


def test_the_output_is_that_of_ctres_own_simulation(talons):
    """Theirs is in whole steps of 1/1023, and a step short at times."""
    for name, (theirs, ours) in talons["ctre"].items():
        assert ours == pytest.approx(theirs, abs=2.1 / 1023.0), name
    assert talons["ctre"]["position"][1] == pytest.approx(0.2 * 3500.0 / 1023.0)
    assert talons["ctre"]["velocity"][1] == pytest.approx((0.2 * 1900.0 + 0.1 * 2000.0) / 1023.0)


def test_an_output_spins_up_as_the_exponential_and_the_encoder_counts_whole_units(talons):
    row = talons["forms"]
    assert row["speed"] == pytest.approx(row["speed_expected"], rel=1e-9)
    for shown, exact in (row["units"], row["rate"]):
        assert shown == math.floor(exact)
    assert row["percent"] == [0.5, 6.0, 12.0]
    assert row["set"] == [100, 100]
    assert row["feed-forward"] == pytest.approx(0.3)


def test_neutral_modes_and_current_limits(talons):
    row = talons["forms"]
    assert row["coasts"] == 1.0  # without friction
    assert row["brakes"][0] == pytest.approx(row["brakes"][1], rel=1e-9)
    assert row["stall"] == pytest.approx([131.0 * 0.5, 131.0 * 0.25], rel=0.02)  # a CIM, 131 A at 12 V
    assert row["before the limit"] == pytest.approx(row["stall"][1])  # the trigger's time is not over
    assert row["limited"] == pytest.approx(10.0, rel=1e-6)
    assert row["disabled"] == 0.0


def test_closed_loops_arrive_and_motion_magic_follows_its_trapezoid(talons):
    """5 turns at 5 rps and 10 rps^2: half a second up, half along, half down."""
    row = talons["forms"]
    position, angle, error = row["position"]
    assert position == pytest.approx(4096.0, abs=103.0)  # from where 0.4 x error / 1023 is within the deadband
    assert angle == pytest.approx(-position / 4096.0 * math.tau, rel=1e-3)  # reversed
    assert error == pytest.approx(4096.0 - position)
    start = position / 4096.0
    assert row["profile"][:2] == pytest.approx([start + 1.25, start + 3.75], abs=2e-3)
    assert row["profile"][3] == pytest.approx(6.0, abs=1e-6)
    assert row["profile end"] == pytest.approx(6.0, abs=0.03)


def test_a_victor_follows_and_an_undescribed_pair_is_guessed_as_one(talons):
    row = talons["forms"]
    assert row["groups"] == [["Talon SRX 5", "Victor SPX 6"]]
    assert row["guess"].startswith("2 x CIM, 1:1")
    assert row["follower"] == pytest.approx([0.6, 0.6])


def test_a_tank_drives_straight_and_stalls_at_a_wall_with_the_current_of_its_motors(talons):
    row = talons["tank"]
    x, y, yaw = row["straight"]
    assert x > 2.5
    assert abs(y) < 1e-3
    assert abs(yaw) < 1e-3
    assert row["odometry"] == pytest.approx([x, x], rel=0.02)
    assert row["follower"][0] == pytest.approx(row["follower"][1], rel=0.02)
    assert row["at the wall"] == pytest.approx([15.6, 0.0], abs=0.02)  # a bumper's half length before 16 m
    amps, volts, resistance = row["stall"]
    assert amps == pytest.approx(volts / resistance, rel=0.02)
    assert row["currents"][1] == pytest.approx(amps, rel=1e-3)
