"""Whole robot projects under `robotpy sim --nogui`, enabled from inside, in real time.

Drivers and other autos of the example are in its own tests, in simulated time.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.realtime]

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = str(ROOT / "examples" / "rebuilt_robot")
FIRST = str(ROOT / "examples" / "first_robot")
PLAIN = str(Path(__file__).parent / "robots" / "plain")


def test_the_robot_drives_intakes_and_scores_in_the_example_auto(scenario):
    """The robot scores 8 preloaded fuel and fuel from the depot, all for its own alliance."""
    run = scenario("robot_sim", EXAMPLE, "auto", "red")
    assert run["distance"] > 3.0 and run["odometry_error"] < 0.03 * run["distance"]
    assert run["taken_in"] >= 5 and run["counted"] == run["staged"]
    assert run["score"]["red"] >= 8 and run["score"]["blue"] == 0
    assert 0.0 <= run["match_time"] <= 1.0


def test_a_dashboard_and_robot_code_control_the_field(scenario):
    """Robot code has its own chooser of autos, so simcore publishes none."""
    run = scenario("robot_sim", PLAIN, "control", "blue")
    assert "/Sim/Control/Piece/options" in run["topics"] and not any("Auto" in topic for topic in run["topics"])
    pose, said = run["placed"]
    assert pose == pytest.approx([3.0, 6.5, math.pi / 2], abs=0.01)
    assert said == "1 done: robot 0 stands at (3.00, 6.50) m, 90 deg"
    on_field, said = run["spawned"]
    assert on_field == 457 and said.startswith("2 done: 1 Fuel put down at")
    assert run["said"][2] == "3 refused: robot 0 is driven by robot code, whose own chooser says which auto it plays"
    assert run["said"][3].startswith("4 done: robot 0 stands at its start")
    assert run["said"][4] == "5 refused: this run of rebuilt has no human players; whole matches may have"
    assert run["counted"] == run["staged"]


@pytest.mark.parametrize("period", ["0.005", "0.01", "0.02"])
def test_a_robot_of_any_period_with_its_own_ids_and_ratios_has_true_odometry(scenario, period):
    run = scenario("robot_sim", PLAIN, "straight", "blue", ROBOT_PERIOD=period)
    assert run["true_speed"] == pytest.approx(2.0, rel=0.03)
    assert run["told_speed"] == pytest.approx(run["true_speed"], rel=0.02)
    assert run["odometry_way"] == pytest.approx(run["true_way"], rel=0.02)
    assert run["speed_at_end"] < 0.01
    assert run["drawn_fuel"] == 448 and run["drawn_robot_off"] < 0.01
    assert 11.5 < run["volts_seen"] < 13.0
    assert run["own_hook"] > 100  # a physics.py does not replace the program's own hook


def test_the_robot_on_the_first_page_drives_at_half_speed_for_half_a_stick(scenario):
    """In open loop, half a stick is half of 4.4 m/s; the robot drives through the trench."""
    run = scenario("robot_sim", FIRST, "straight", "blue")
    assert run["true_speed"] == pytest.approx(2.2, rel=0.08)
    assert run["told_speed"] == pytest.approx(run["true_speed"], rel=0.02)
    assert run["true_way"] > 3.0
    assert run["odometry_way"] == pytest.approx(run["true_way"], rel=0.05)
    assert run["drawn_robot_off"] < 0.01
