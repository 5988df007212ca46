"""A robot of an earlier run's log: it drives the same way again, and who stands in the way holds it up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from games.rebuilt import REBUILT
from simcore.errors import ConfigError
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.runner import play_auto
from simcore.robot_file.further_robots import FurtherRobot, add_controllers
from simcore.telemetry.wpilog import WpilogSink

SECONDS = 5.0  # before it comes into fuel, which lies otherwise each time


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A log of an auto, and where the robot was at each of its ticks."""
    path = tmp_path_factory.mktemp("log") / "run.wpilog"
    run = play_auto(REBUILT, "neutral", seconds=SECONDS, seed=3, sinks=[WpilogSink(path)])
    run.match.close()
    return path, run.path


def play(path, *, role, stands=(8.3, 1.0, 0.0), on_tick=lambda match: None):
    """Where the recorded robot was in a match in which ours stands somewhere."""
    one = FurtherRobot(name="again", role=role, log=path.name, folder=path.parent, where="[[partner]]")
    ours = RobotEntry(start=stands, preload=0)
    way = []
    with Match(REBUILT, robots=[ours, one.entry(REBUILT)], seed=3) as match:
        add_controllers(match, [one])
        for _ in range(round(SECONDS / 0.02)):
            match.tick()
            way.append(match.robots[1].chassis.pose)
            on_tick(match)
    return np.array(way)


def off(way, path):
    return np.hypot(*(way[:, :2] - path[: len(way), :2]).T)


@pytest.mark.slow
def test_it_drives_again_within_5_cm(recorded):
    log, path = recorded
    assert np.ptp(path[:, 0]) > 1.0
    assert off(play(log, role="partner"), path).max() < 0.05


@pytest.mark.slow
def test_as_an_opponent_it_drives_on_the_other_side(recorded):
    log, path = recorded
    flipped = np.array([REBUILT.field.symmetry.flip_pose(*row) for row in path.tolist()])
    assert off(play(log, role="opponent"), flipped).max() < 0.05


@pytest.mark.slow
def test_it_yields_to_who_stands_in_its_way(recorded):
    """Robots in contact keep their distance, and the path is left by as much as the other one takes up."""
    log, path = recorded
    far = path[int(np.argmax(np.hypot(*(path[:, :2] - path[0, :2]).T)))]
    apart = []

    def look(match):
        a, b = (robot.chassis.pose for robot in match.robots)
        apart.append(math.dist(a[:2], b[:2]))

    way = play(log, role="partner", stands=(float(far[0]), float(far[1]), 0.0), on_tick=look)
    assert min(apart) > 0.75 and off(way, path).max() > 0.2


def test_a_log_that_is_not_there_is_refused(tmp_path):
    one = FurtherRobot(name="again", role="partner", log="none.wpilog", folder=tmp_path, where="[[partner]]")
    with pytest.raises(ConfigError, match=r"log '.*none.wpilog', robot 0: cannot read the log"):
        one.entry(REBUILT)
