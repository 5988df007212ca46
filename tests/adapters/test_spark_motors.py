"""SPARK MAX and SPARK Flex on mechanisms: outputs match REVLib's model, and motion matches closed forms."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def sparks(scenario):
    found = find_spec("rev")
    if found is None or found.origin is None:
        pytest.skip("needs rev: pip install .[rev]")
    return scenario("sparks", path=(Path(found.origin).parents[1],))


def test_the_output_of_a_spark_matches_revlibs_own_model(sparks):
    """REVLib's model has single precision: 6e-8 of 1."""
    for name, (theirs, ours) in sparks["iterate"].items():
        assert ours == pytest.approx(theirs, abs=1e-7), name


def test_a_motor_at_a_duty_cycle_spins_up_exponentially_and_its_encoder_counts(sparks):
    row = sparks["forms"]
    assert row["speed"] == pytest.approx(row["speed_expected"], rel=1e-9)
    assert row["rpm"] == pytest.approx(row["speed"] * 2.0 * 60.0 / 6.283185307, rel=1e-6)  # rotor, with a gearing of 2
    assert row["rotations"] == pytest.approx(row["shaft"] * 2.0 / 6.283185307, rel=1e-6)
    assert row["applied"] == 0.5


def test_idle_modes_coast_or_brake_and_the_smart_current_limit_caps_the_current(sparks):
    row = sparks["forms"]
    assert row["coasts"] == 1.0  # without friction
    assert row["brakes"] == pytest.approx(row["brakes_expected"], rel=1e-9)
    assert row["stall_amps"] == pytest.approx(40.0)
    assert row["stall_volts"] == pytest.approx(40.0 * 12.0 / 105.0)  # R I of a NEO: 12 V, 105 A
    assert row["disabled"] == 0.0


def test_closed_loops_reach_their_goal_on_every_sensor(sparks):
    row = sparks["loops"]
    assert row["rpm"] == pytest.approx(3000.0, rel=1e-3)
    assert row["at_setpoint"] == [False, True]
    assert row["inverted"] == pytest.approx([1.2, 1.2], abs=1e-4)
    assert row["zeroed"] == pytest.approx([2.2, 1.2], abs=1e-4)  # the encoder was set to 0.2 at 1.2
    assert row["absolute_at_first"] == pytest.approx(340.0)  # 20 degrees, with inverted counting
    assert row["absolute"] == pytest.approx([60.0, 300.0], abs=1e-3)


def test_maxmotion_follows_its_trapezoid(sparks):
    """20 turns at 20 turns/s and 40 turns/s^2: half a second of acceleration, cruise and braking each."""
    shown = [setpoint for _, setpoint in sparks["loops"]["profile"]]
    assert shown == pytest.approx([1.25, 10.0, 18.75, 20.0], abs=1e-6)
    assert sparks["loops"]["profile"][-1][0] == pytest.approx(20.0, abs=0.05)


def test_a_steer_motor_with_any_absolute_encoder_turns_in_the_shorter_direction(sparks):
    """The motor turns from 350 to 20 degrees by way of 380; the analog encoder gives 3.3 V per turn."""
    row = sparks["sensors"]
    for sensor in ("Absolute", "Analog"):
        assert row[sensor] == pytest.approx([380.0, 20.0], abs=0.5), sensor
    assert row["volts"] == pytest.approx(3.3 * row["Analog"][1] / 360.0)


def test_encoders_count_from_the_position_set_by_robot_code_or_shaft(sparks):
    row = sparks["sensors"]
    assert row["centered"] == pytest.approx(-30.0, abs=1e-4)
    assert row["seeded"] == pytest.approx(1.5 + 0.5)  # one turn of the rotor
    assert row["brushed"] == pytest.approx(3.0)  # on the wheel, whatever the gearing in front of it


def test_followers_turn_with_their_leader(sparks):
    row = sparks["followers"]
    assert row["group"] == [[1, 2], [1]]
    assert row["rpm"] == pytest.approx([row["expected"], row["expected"], -row["expected"]], rel=1e-6)
    assert row["applied"] == [0.25, 0.25, -0.25]


def test_a_guess_takes_gearing_friction_and_weight_from_the_configuration(sparks):
    assert sparks["guess"]["text"].startswith("1 x NEO Vortex, 60:1")
    assert sparks["guess"]["text"].endswith("weight of its kCos as an arm")
    assert sparks["guess"]["friction_volts"] == pytest.approx(0.3)
