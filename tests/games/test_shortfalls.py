"""A run in which nothing was taken in or thrown says why, where it can be known; one that went well says nothing."""

from __future__ import annotations

from dataclasses import replace

import pytest

from games.rebuilt import REBUILT
from simcore.cli import main
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.runner import play_auto
from simcore.show.log_page import recording_of
from simcore.show.run_events import ending_of
from simcore.telemetry.sinks import MemorySink
from simcore.telemetry.wpilog import WpilogSink, read_log


def shortfalls(volts, *, preload=0, believed=None, config=None):
    """Of REBUILT's robot, or another one, in a corner without fuel, with volts on its mechanisms."""
    entry = RobotEntry(start=(5.8, 1.0, 0.0), preload=preload, config=config)
    with Match(REBUILT, robots=[entry], seed=1) as match:
        robot = match.robots[0]
        for name, value in volts.items():
            robot.mechanisms[name].set_volts(value)
        robot.estimated_pose = believed
        match.play(1.0)
        return match.record.shortfalls


def test_an_intake_that_is_driven_against_the_wrong_stop():
    (line,) = shortfalls({"intake_deploy": -6.0, "intake_roller": 8.0})
    assert line == (
        "intake 1 was never out: 'intake_deploy' stayed at its lower stop, 0.00 m, and was driven against it: does "
        "your code count the other way? reversed = true (it is out near its upper stop)"
    )


def test_an_intake_that_nobody_moved():
    (line,) = shortfalls({"intake_roller": 8.0})
    assert "'intake_deploy' stayed at its lower stop, 0.00 m, and was not asked to move" in line


def test_a_roller_that_turns_the_other_way():
    (line,) = shortfalls({"intake_deploy": 6.0, "intake_roller": -8.0})
    assert line.startswith("intake 1: 'intake_roller' reached 0.0 of the 1.0 turns/s from which it works, but ")
    assert line.endswith(" backward: does your code count the other way? reversed = true")


def test_wheels_that_are_never_fast_enough():
    (line,) = shortfalls({"shooter": 0.4, "feeder": 8.0}, preload=8)
    assert line.startswith("shooter 1: 'shooter' reached ") and "of the 5.0 turns/s from which it works" in line


def test_a_feeder_that_never_feeds():
    (line,) = shortfalls({"shooter": 8.0}, preload=8)
    assert line == "shooter 1: 'feeder' reached 0.0 of the 0.5 turns/s from which it works"


def test_a_feeder_that_should_turn_backward_and_does_not():
    own = REBUILT.robot()
    config = replace(own, shooters=tuple(replace(one, gate_reversed=one.gate) for one in own.shooters))
    (line,) = shortfalls({"shooter": 8.0, "feeder": 8.0}, preload=8, config=config)
    assert line.startswith("shooter 1: 'feeder' reached 0.0 of the 0.5 turns/s from which it works, but ")


def test_a_hopper_that_is_empty_at_the_shot():
    (line,) = shortfalls({"shooter": 8.0, "feeder": 8.0})
    assert line.startswith("shooter 1 had nothing to throw: its storage was empty as it opened, at 0.")


def test_a_feeder_that_coasts_and_throws_out():
    with Match(REBUILT, robots=[RobotEntry(start=(5.8, 1.0, 0.0), preload=8)], seed=1) as match:
        parts = match.robots[0].mechanisms
        parts["feeder"].velocity, parts["shooter"].velocity = 60.0, 300.0
        parts["feeder"].coast()
        match.play(0.3)
        (line,) = match.record.shortfalls
        shots = len(match.record.shots)
    assert shots >= 2
    assert line.startswith(f"{shots} of {shots} shots left while 'feeder' was let go and coasted: brake it")


def test_a_program_that_believes_to_be_elsewhere():
    (line,) = shortfalls({}, believed=(5.8, 3.0, 0.0))
    assert line == "the program believes to be at (5.80, 3.00) m, and the robot is at (5.80, 1.00) m"


@pytest.mark.parametrize("auto", ["depot", "tour"])
def test_a_run_that_went_as_meant_says_nothing(auto):
    run = play_auto(REBUILT, auto, seconds=8.0)
    run.match.close()
    assert run.report.shortfalls == ()


@pytest.mark.parametrize("period", [0.02, 0.7])
def test_a_log_says_it_at_its_end_and_so_does_its_page(tmp_path, period):
    """Also one that is not due in the last tick; a sink that is closed by then takes nothing more."""
    log, closed = tmp_path / "run.wpilog", MemorySink()
    with Match(
        REBUILT, robots=[RobotEntry(start=(5.8, 1.0, 0.0))], sinks=[WpilogSink(log, period=period), closed]
    ) as m:
        m.robots[0].mechanisms["intake_roller"].set_volts(8.0)
        m.play(1.0)
        closed.close()
        taken = len(closed.snapshots)
    column = read_log(log).columns["Sim/Warnings"]
    assert len(column) == 1 and column.value(0).startswith("intake 1 was never out") and len(closed.snapshots) == taken
    assert main(["page", str(log), "--page", str(tmp_path / "run.html")]) == 0
    recording = recording_of(read_log(log))
    assert ending_of(recording) == [column.value(0)]
