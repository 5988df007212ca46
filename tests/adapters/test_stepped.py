"""Robots without CAN, in stepped time: many times faster than real time, and the same every time."""

from __future__ import annotations

from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROBOTS = Path(__file__).parent / "robots"


@pytest.fixture(scope="module", params=[("pwm", "swerve"), ("tank", "tank")], ids=["swerve", "tank"])
def runs(request, scenario):
    project, kind = request.param
    return [scenario("stepped", str(ROBOTS / project), kind) for _ in range(2)]


def test_it_drives_and_odometry_agrees(runs):
    run = runs[0]
    assert run["true_way"] > 4.5
    assert run["odometry_way"] == pytest.approx(run["true_way"], rel=0.02)
    assert abs(run["turned"]) > 1.0  # of a tank to more than half a turn, the remainder of a whole one
    assert run["believed_turn"] == pytest.approx(run["turned"], abs=0.03)


def test_disabled_it_stops_though_its_code_never_takes_the_volts_back(runs):
    assert runs[0]["speed_disabled"] < 0.02


def test_two_processes_do_bit_for_bit_the_same(runs):
    assert runs[0]["digest"] == runs[1]["digest"]


def test_it_does_not_wait_for_the_wall_clock(runs):
    """Some ten times faster on a free core; the rest is other work's."""
    assert min(run["wall"] for run in runs) < runs[0]["simulated"]


def test_game_data_comes_with_teleop(runs):
    """In teleop without auto (practice) too; a new auto starts with none."""
    run = runs[0]
    practice, auto, teleop = run["messages"]
    assert practice == teleop == run["first_inactive"][0].upper()
    assert auto == ""
