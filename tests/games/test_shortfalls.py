"""Explanations of runs without intake or shots where the cause is known; none for successful runs."""

from __future__ import annotations

import re
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

OWN = REBUILT.robot()
BACKWARD = replace(OWN, shooters=tuple(replace(one, gate_reversed=one.gate) for one in OWN.shooters))
CASES = {
    "an intake that is driven against the wrong stop": (
        *({"intake_deploy": -6.0, "intake_roller": 8.0}, {}),
        r"intake 1 was never out: 'intake_deploy' stayed at its lower stop, 0\.00 m, and was driven against it: does "
        r"your code count the other way\? reversed = true \(it is out near its upper stop\)",
    ),
    "an intake that nobody moved": (
        *({"intake_roller": 8.0}, {}),
        r".*'intake_deploy' stayed at its lower stop, 0\.00 m, and was not asked to move.*",
    ),
    "a roller that turns the other way": (
        *({"intake_deploy": 6.0, "intake_roller": -8.0}, {}),
        r"intake 1: 'intake_roller' reached 0\.0 of the 1\.0 turns/s that it needs, but .* backward: does your "
        r"code count the other way\? reversed = true",
    ),
    "wheels that are never fast enough": (
        *({"shooter": 0.4, "feeder": 8.0}, {"preload": 8}),
        r"shooter 1: 'shooter' reached .* of the 5\.0 turns/s that it needs.*",
    ),
    "a feeder that never feeds": (
        *({"shooter": 8.0}, {"preload": 8}),
        r"shooter 1: 'feeder' reached 0\.0 of the 0\.5 turns/s that it needs",
    ),
    "a feeder that should turn backward": (
        *({"shooter": 8.0, "feeder": 8.0}, {"preload": 8, "config": BACKWARD}),
        r"shooter 1: 'feeder' reached 0\.0 of the 0\.5 turns/s that it needs, but .*",
    ),
    "a hopper that is empty at the shot": (
        *({"shooter": 8.0, "feeder": 8.0}, {}),
        r"shooter 1 had nothing to throw: its storage was empty as it opened, at 0\..*",
    ),
    "a program that believes to be elsewhere": (
        *({}, {"believed": (5.8, 3.0, 0.0)}),
        r"the program believes that it is at \(5\.80, 3\.00\) m, but the robot is at \(5\.80, 1\.00\) m",
    ),
}
"""Voltages of mechanisms, further settings and the expected message."""


@pytest.mark.parametrize("case", CASES)
def test_each_shortfall_is_reported_once(case):
    """The robot is in a corner without fuel."""
    volts, more, said = CASES[case]
    entry = RobotEntry(start=(5.8, 1.0, 0.0), preload=more.get("preload", 0), config=more.get("config"))
    with Match(REBUILT, robots=[entry], seed=1) as match:
        robot = match.robots[0]
        for name, value in volts.items():
            robot.mechanisms[name].set_volts(value)
        robot.estimated_pose = more.get("believed")
        match.play(1.0)
        (line,) = match.record.shortfalls
    assert re.fullmatch(said, line), line


def test_shots_from_a_coasting_feeder_are_reported():
    with Match(REBUILT, robots=[RobotEntry(start=(5.8, 1.0, 0.0), preload=8)], seed=1) as match:
        parts = match.robots[0].mechanisms
        parts["feeder"].velocity, parts["shooter"].velocity = 60.0, 300.0
        parts["feeder"].coast()
        match.play(0.3)
        (line,) = match.record.shortfalls
        shots = len(match.record.shots)
    assert shots >= 2
    assert line.startswith(f"{shots} of {shots} shots left while 'feeder' had no output and coasted: brake it")


def test_a_successful_run_reports_no_shortfall():
    run = play_auto(REBUILT, "depot", seconds=8.0)
    run.match.close()
    assert run.report.shortfalls == ()


@pytest.mark.parametrize("period", [0.02, 0.7])
def test_the_log_and_the_page_report_the_shortfall(tmp_path, period):
    """The report comes even between two due rows; a closed sink accepts nothing more."""
    log, closed = tmp_path / "run.wpilog", MemorySink()
    sinks = [WpilogSink(log, period=period), closed]
    with Match(REBUILT, robots=[RobotEntry(start=(5.8, 1.0, 0.0))], sinks=sinks) as match:
        match.robots[0].mechanisms["intake_roller"].set_volts(8.0)
        match.play(1.0)
        closed.close()
        taken = len(closed.snapshots)
    column = read_log(log).columns["Sim/Warnings"]
    assert len(column) == 1 and column.value(0).startswith("intake 1 was never out") and len(closed.snapshots) == taken
    assert main(["view", "--no-browser", str(log), "--page", str(tmp_path / "run.html")]) == 0
    assert ending_of(recording_of(read_log(log))) == [column.value(0)]
