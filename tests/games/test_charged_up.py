"""CHARGED UP, built from public parts: cones on poles, cubes on shelves, links, docked and engaged robots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from charged_up import CHARGED_UP, COLUMNS, CONE, CUBE, LEVEL_WITHIN, POLES, SHELVES, STATION, links

from simcore.match.clock import MatchClock, Phase
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.runner import play_auto


@pytest.mark.parametrize("alliance", ["blue", "red"])
@pytest.mark.parametrize(("auto", "points"), [("cone", 4), ("balance", 12)])
def test_the_autos_score_the_same_for_red_and_blue(auto, points, alliance):
    run = play_auto(CHARGED_UP, auto, alliance=alliance, seconds=15.1)
    with run.match as match:
        assert getattr(run.report.score, alliance) == run.report.score.total == points
        assert match.count.is_conserved and run.report.shortfalls == ()
        if auto == "balance":
            angles = [abs(body.angle) for body in match.hanging if body.config.alliance == alliance]
            assert angles[0] < LEVEL_WITHIN and match.robots[0].chassis.pos[2] == pytest.approx(0.23, abs=0.02)


def test_an_off_center_robot_is_docked_but_not_engaged():
    with Match(CHARGED_UP, robots=[RobotEntry(start=(2.0, STATION[1], 0.0), preload=0)], seed=1) as match:
        (robot,), blue = match.robots, match.hanging[0]
        robot.carry_to((STATION[0] + 0.1, STATION[1], 0.0))
        match.play(15.1)
        assert blue.angle > LEVEL_WITHIN and match.score.blue == 8


def place(match, kind, column, row):
    x, height = POLES[row]
    top = SHELVES[row] + 0.15 if kind is CUBE else height + 0.05
    match.pieces.release(match.pieces.spare(kind.name, 1), np.array([[x, COLUMNS[column], top]]))


def test_a_link_counts_from_its_third_piece_until_a_piece_falls():
    clock = MatchClock([Phase("teleop", 20.0)])
    with Match(replace(CHARGED_UP, clock=clock), robots=[RobotEntry(preload=0)], seed=1) as match:
        for kind, column in ((CONE, 0), (CUBE, 1), (CONE, 2), (CUBE, 4)):
            place(match, kind, column, "Mid")
        match.play(4.0)
        assert match.score.blue == 4 * 3 + 5 and match.rules.breakdown()["BlueLinks"] == 1
        (cube,) = match.pieces.places.slots("Blue Mid 2")
        match.pieces.push(np.array([cube]), np.array([[2.0, 0.0, 2.0]]), flying=True)
        match.play(2.0)
        assert match.pieces.places.count("Blue Mid 2") == 0
        assert match.rules.breakdown()["BlueLinks"] == 0 and match.score.blue < 4 * 3 + 5
        assert match.count.is_conserved


def test_a_cone_on_a_cube_node_does_not_count():
    with Match(CHARGED_UP, robots=[RobotEntry(preload=0)], seed=1) as match:
        x, _ = POLES["Top"]
        match.pieces.release(match.pieces.spare("Cone", 1), np.array([[x, COLUMNS[1], SHELVES["Top"] + 0.2]]))
        match.play(3.0)
        assert match.score.blue == 0 and match.pieces.places.count() == 0


@pytest.mark.parametrize(
    ("row", "found"),
    [([1] * 9, 3), ([1, 1, 0, 1, 1, 1, 1, 0, 0], 1), ([1] * 5 + [0] * 4, 1), ([0, 1, 1, 1, 1, 1, 1, 0, 0], 2)],
)
def test_no_node_is_in_two_links(row, found):
    assert links(row) == found
