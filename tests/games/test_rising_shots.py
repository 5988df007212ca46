"""Zone above the field that accepts rising pieces: scripts and the shooter table aim at it."""

from __future__ import annotations

import math

import pytest
from crates import BALL, crates_robot

from simcore.match.game import Game, PieceSupply, RobotEntry
from simcore.match.match import Match
from simcore.match.scoring import ScoringZone
from simcore.match.scripted import ScriptSettings
from simcore.pieces.shot_opening import ShotOpening
from simcore.sweep.shot_table import make_table
from simcore.sweep.shot_task import ShotTask
from simcore.world.zones import BoxZone

FACE, LOW, HIGH = 0.5, 1.3, 2.1
TARGET = (FACE, 4.0, 0.5 * (LOW + HIGH))
SLOT = ((FACE, 3.4, LOW), (FACE, 4.6, LOW), (FACE, 4.6, HIGH), (FACE, 3.4, HIGH))


def game(*, downward):
    zone = BoxZone((FACE - 0.4, 3.4, LOW), (FACE, 4.6, HIGH))
    slot = ScoringZone(
        name="Slot", alliance="blue", zone=zone, downward=downward, opening=ShotOpening(corners=SLOT, approach=math.pi)
    )
    return Game.bare(pieces=(PieceSupply(BALL, 4),), robot=crates_robot, zones=(slot,))


@pytest.mark.parametrize("downward", [False, True])
def test_a_script_shoots_upward_only_at_a_zone_that_accepts_rising_shots(downward, caplog):
    def script(robot):
        yield from robot.shoot_until_empty(TARGET, timeout=4.0)

    with Match(game(downward=downward), robots=[RobotEntry(start=(1.7, 4.0, math.pi))]) as match:
        slots = match.pieces.stage(BALL.name, 2)
        match.pieces.hold(slots, 0)
        match.robots[0].storage.add(slots.tolist())
        match.set_controller(0, ScriptSettings(feed_volts={"feeder": 8.0}).controller(script)(match, "blue"))
        match.play(4.5)
        assert match.tracker.pieces["Slot"] == (0 if downward else 2)
    assert caplog.text.count("the ball would pass it on the way up") == (1 if downward else 0)


def test_a_shooter_table_includes_rising_shots():
    task = ShotTask(game(downward=False))
    table = make_table(task, (1.1, 1.3))
    assert [row.problem for row in table.rows] == ["", ""]
    assert all(row.shot["entry_angle_deg"] < 0.0 for row in table.rows)
    falling = make_table(ShotTask(game(downward=True)), (1.1,))
    assert falling.rows[0].problem == "no elevation and speed of this shooter go in"
