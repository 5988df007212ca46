"""Climbs in the 2025 game: swinging cages, deep and shallow, and judging at the end."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from match_laws import show_time

from games.reefscape import REEFSCAPE
from games.reefscape import dimensions as dim
from games.reefscape.robot import reefscape_robot
from games.reefscape.rules import MATCH
from simcore.match.game import RobotEntry
from simcore.match.match import Match

RAISED = replace(
    reefscape_robot(),
    mechanisms=reefscape_robot().mechanisms
    | {"climber": replace(reefscape_robot().mechanisms["climber"], start_height=0.55)},
)
"""Robot of the game with a raised hook."""


def entry(alliance, cage):
    return RobotEntry(alliance=alliance, start=(dim.CAGE_X - 0.75, dim.CAGE_YS[cage - 1], math.pi), config=RAISED)


def climber(match, number, falls_at=math.inf):
    """Back into the cage, pull up and cut the motors; release at `falls_at` [s]."""

    def control(robot, time):
        volts = 0.0 if time > 4.8 else -12.0 if time > 2.2 else 0.0
        robot.drive.set_chassis_speeds(-0.6 if robot.chassis.pos[2] < 0.05 and 0.2 < time < 1.46 else 0.0, 0.0, 0.0)
        robot.mechanisms["climber"].set_volts(12.0 if time > falls_at else volts)

    match.set_controller(number, control)


@pytest.fixture(scope="module")
def hung():
    """Climb with four robots in the last seconds: two on deep and two on shallow cages; one robot lets go."""
    entries = (entry("blue", 2), entry("red", 2), entry("blue", 1), entry("red", 3))
    options = ("blue_cage_1_shallow", "red_cage_3_shallow")
    with Match(REEFSCAPE, robots=entries, options=options) as match:
        show_time(match, MATCH.duration - 5.0)
        for number in range(4):
            climber(match, number, falls_at=5.2 if number == 3 else math.inf)
        match.play(4.9)
        before = match.score
        match.play(0.2)
        at_end, heights = match.score, [robot.chassis.pos[2] for robot in match.robots]
        match.play(3.0)
        yield match, before, at_end, heights


def test_climbs_on_deep_and_shallow_cages_hold_for_three_seconds_without_power(hung):
    match, before, at_end, heights = hung
    assert before.total == 0
    assert (at_end.blue, at_end.red) == (12 + 6, 12 + 6)
    sags = [h - robot.chassis.pos[2] for h, robot in zip(heights, match.robots, strict=True)]
    assert max(abs(sag) for sag in sags[:3]) < 0.003, sags
    assert min(heights) > 0.2
    for robot in match.robots[:3]:
        assert robot.mechanisms["climber"].supply_current == pytest.approx(0.0, abs=0.01)
        assert abs(robot.mechanisms["climber"].velocity) < 1e-6, "friction of the gears holds it"


def test_a_robot_that_lets_go_of_its_cage_falls_and_does_not_count(hung):
    match, *_ = hung
    assert match.robots[3].climbers[0].rung is None
    assert match.robots[3].chassis.pos[2] < 0.05
    assert (match.score.blue, match.score.red) == (12 + 6, 12 + 2), "it parks"
    ends = [*match.rules.ends.values()][:4]
    assert ends == ["DeepCage", "DeepCage", "ShallowCage", "Parked"]
    rows = match.rules.breakdown()
    assert rows["Blue/endGameBargePoints"] == rows["Blue/teleopPoints"] == 18
    assert rows["Blue/bargeBonusAchieved"] == 1 and rows["Red/bargeBonusAchieved"] == 1
    assert (rows["Blue/rp"], rows["Red/rp"]) == (3 + 1, 1), "red's 14 points are enough for its barge"
    assert [match.rules.worth(zone) for zone in REEFSCAPE.zones] == [0, 0], "nothing counts any more"


def test_a_red_climb_equals_a_blue_climb(hung):
    match, *_ = hung
    blue, red = (match.robots[n].chassis.pose for n in (0, 1))
    flipped = REEFSCAPE.field.symmetry.flip_pose(*red)
    assert np.allclose(blue[:2], flipped[:2], atol=0.01)
    cages = {body.config.name: body for body in match.hanging}
    assert cages["blue_cage_2"].is_awake and not cages["blue_cage_3"].is_awake
    x, y = REEFSCAPE.field.symmetry.flip_point(*cages["red_cage_2"].pos[:2])
    assert math.dist((x, y), cages["blue_cage_2"].pos[:2]) < 0.02
