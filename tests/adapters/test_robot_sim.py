"""Whole robot projects under `robotpy sim --nogui`, enabled from inside, in real time."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.realtime]

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = str(ROOT / "examples" / "rebuilt_robot")
FIRST = str(ROOT / "examples" / "first_robot")
PLAIN = str(Path(__file__).parent / "robots" / "plain")


@pytest.fixture(scope="module", params=["blue", "red"])
def auto(request, scenario):
    return {**scenario("robot_sim", EXAMPLE, "auto", request.param), "alliance": request.param}


@pytest.fixture(scope="module")
def drawn_auto(scenario):
    """Red: drawn for blue, so it is turned by the library."""
    pytest.importorskip("pathplannerlib", reason="needs PathPlanner: pip install robotpy-pathplannerlib")
    return scenario("robot_sim", EXAMPLE, "auto", "red", AUTO="neutral (PathPlanner)")


@pytest.fixture(scope="module")
def teleop(scenario):
    return scenario("robot_sim", EXAMPLE, "teleop", "blue")


def test_the_auto_drives_takes_in_and_scores(auto):
    """8 preloaded fuel and what it finds in the depot, all for its own alliance."""
    other = "red" if auto["alliance"] == "blue" else "blue"
    assert auto["distance"] > 3.0
    assert auto["taken_in"] >= 5
    assert auto["score"][auto["alliance"]] >= 8
    assert auto["score"][other] == 0
    assert auto["counted"] == auto["staged"]


def test_an_auto_drawn_in_pathplanner_crosses_the_trench_takes_in_and_scores(drawn_auto):
    """Through the trench to the neutral zone, an intake full of fuel, and back: a hopper of 50 and the preload."""
    assert drawn_auto["distance"] > 12.0
    assert drawn_auto["taken_in"] >= 30
    assert drawn_auto["score"]["red"] >= 35
    assert drawn_auto["odometry_error"] < 0.02 * drawn_auto["distance"]
    assert drawn_auto["min_volts"] > 6.75


def test_odometry_stays_near_the_truth_through_the_auto(auto):
    assert auto["odometry_error"] < 0.03 * auto["distance"]


def test_match_time_counts_down(auto):
    assert 0.0 <= auto["match_time"] <= 1.0


def test_sticks_and_buttons_drive_take_in_and_shoot(teleop):
    """Half a stick is 2 m/s on this robot, 0.4 of a turn stick 2.4 rad/s; ramps take a part of it."""
    assert teleop["hits_of_preload"] >= 7
    assert 0.7 < teleop["ahead"] < 1.4
    assert 0.6 < teleop["turned"] < 1.4
    assert teleop["hood_raised_deg"] == pytest.approx(10.0, abs=1.0)
    assert teleop["intake_active"]
    assert teleop["held"] >= 5
    assert teleop["score"]["blue"] >= 12


def test_cameras_correct_odometry_and_find_fuel(scenario):
    """Told of a place 0.58 m off, odometry is back within 5 cm in 2 s; N drives to fuel and takes it in."""
    run = scenario("robot_sim", EXAMPLE, "cameras", "blue")
    assert run["error_before"] == pytest.approx(math.hypot(0.5, 0.3), abs=0.03)
    assert run["seconds_to_5_cm"] < 2.0
    assert run["error_after"] < 0.05
    assert run["heading_told"] == pytest.approx(run["heading"], abs=1.5)
    assert run["taken_in"] >= 3


def test_a_brown_out_reaches_robot_code(scenario):
    """All drive motors and the shooter stalled with no limits: 8 motors of 270 A at 6.75 V on a battery of 20 mohm.

    The motors are cut, robot code sees the voltage and the rails of the roboRIO, and all comes back.
    """
    run = scenario("robot_sim", str(Path(PLAIN).parent / "pushing"), "push", "blue")
    assert run["moved"] < 0.1  # it leans on the wall
    assert min(run["seen_volts"]) < 6.75
    assert run["ticks_off"] > 5 and run["rail_was_off"] > 5 and run["faults"] >= 5
    assert max(run["shooter_amps"]) > 200.0  # 8 motors of 33 mohm leave 2.2 V of 12.9, 67 A each
    assert sum(amps == 0.0 for amps in run["shooter_amps"]) >= run["ticks_off"]
    assert run["volts_after"] > 12.0 and run["rail_after"]


def test_a_dashboard_and_robot_code_act_on_the_field(scenario):
    """Robot code has its own chooser of autos, so there is none of ours."""
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


def test_a_shot_waits_for_the_wheels_and_for_the_feeder(teleop):
    """Robot code feeds within 2.5 % of the goal, as its motors say; without a feeder nothing leaves."""
    assert teleop["wheels_rps"] == pytest.approx(teleop["goal_rps"], rel=0.035)  # and 10 ms of spinning up
    assert teleop["shots_while_jammed"] == 0
    assert teleop["wheels_rps_while_jammed"] == pytest.approx(teleop["goal_rps"], rel=0.025)


@pytest.mark.parametrize("period", ["0.005", "0.01", "0.02"])
def test_a_robot_of_any_period_with_its_own_ids_ratios_and_inversions(scenario, period):
    run = scenario("robot_sim", PLAIN, "straight", "blue", ROBOT_PERIOD=period)
    assert run["true_speed"] == pytest.approx(2.0, rel=0.03)
    assert run["told_speed"] == pytest.approx(run["true_speed"], rel=0.02)
    assert run["odometry_way"] == pytest.approx(run["true_way"], rel=0.02)
    assert run["speed_at_end"] < 0.01
    assert run["drawn_fuel"] == 448 and run["drawn_robot_off"] < 0.01
    assert 11.5 < run["volts_seen"] < 13.0
    assert "Robot._simulationPeriodic is not called while there is a physics.py" in run["output"]


def test_the_robot_of_the_first_page_drives_by_stick(scenario):
    """Half a stick of 4.4 m/s, open loop, through the trench."""
    run = scenario("robot_sim", FIRST, "straight", "blue")
    assert run["true_speed"] == pytest.approx(2.2, rel=0.08)
    assert run["told_speed"] == pytest.approx(run["true_speed"], rel=0.02)
    assert run["true_way"] > 3.0
    assert run["odometry_way"] == pytest.approx(run["true_way"], rel=0.05)
    assert run["drawn_robot_off"] < 0.01
