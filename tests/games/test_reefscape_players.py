"""Whole matches of REEFSCAPE with scripted players: coral scores, no piece is lost, and each role does its task."""

from __future__ import annotations

import math

import pytest
from match_laws import match_of

from games.reefscape import REEFSCAPE
from games.reefscape import dimensions as dim
from games.reefscape.handling import lower_claw, make_ready
from games.reefscape.rules import MATCH
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.players.lineup import lineup, play_match
from simcore.match.scripted import ScriptedRobot

SIX = {"red": "scorer:3,scorer:2,defender", "blue": "scorer:3,algae:2,parker"}

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def _engine(engine_name, whole):
    if engine_name == "mujoco" and not whole:
        pytest.skip("sampled: --whole plays on both engines")


def test_six_robots_score_coral_without_losing_a_piece_and_repeat_exactly(whole):
    def look(match):
        count = match.count
        assert count.is_conserved and count.staged == 144, f"{match.time} s: {count}"

    digests = []
    for _ in range(2):
        run = play_match(REEFSCAPE, lineup(REEFSCAPE, **SIX), seconds=None if whole else 20.0, seed=4, on_tick=look)
        with run.match as match:
            digests.append(run.report.digest)
            rows = match.rules.breakdown()
            for side in ("Blue", "Red"):
                assert rows[f"{side}/autoMobilityPoints"] == 9 and rows[f"{side}/autoBonusAchieved"] == 1
                assert sum(rows[f"{side}/autoReef/{row}"] for row in ("topRow", "midRow", "botRow")) >= 3
            assert rows["Blue/totalPoints"] == match.score.blue and rows["Red/totalPoints"] == match.score.red
            if whole:
                assert match.timer.is_over and rows["Blue/rp"] + rows["Red/rp"] >= 2
    assert digests[0] == digests[1]


def test_a_scorer_fetches_coral_from_the_station_and_the_carpet():
    with match_of(REEFSCAPE, {"blue": "scorer:4"}, at=MATCH.start("teleop")) as match:
        match.play(32.0)
        assert match.rules.human_players.stock["blue"] < 59, "from a station"
        lying = match.pieces.state.pos[match.pieces.on_field("Coral")]
        lying = lying[(lying[:, 0] < 2.0) & (lying[:, 2] < 0.3)]
        assert len(lying) < 3, "off the marks"
        assert match.rules.breakdown()["Blue/teleopReef/topRow"] >= 3
        assert match.tracker.fouls == [], "it never holds two (G409)"


@pytest.mark.parametrize("preload", [0, 1])
def test_a_lowered_claw_takes_a_coral_off_the_carpet_unless_the_claw_is_full(preload):
    x, y = dim.MARK_X, dim.MARK_YS[0]
    entry = RobotEntry(start=(x + 1.2, y, math.pi), preload=preload)

    def drive(robot):
        make_ready(robot)
        yield from robot.wait(0.5)
        lower_claw(robot)
        yield from robot.wait(1.0)
        yield from robot.drive_to(x + 0.3, y, math.pi, speed=0.6, timeout=3.0)

    with Match(REEFSCAPE, robots=[entry]) as match:
        match.set_controller(0, ScriptedRobot(drive, match, "blue"))
        match.play(5.0)
        held = match.robots[0].held
        assert [match.pieces.kind_name(slot) for slot in held] == ["Coral"]
        assert len(match.pieces.on_field("Coral")) == 5 + preload


def test_an_algae_player_fills_the_processor_until_coopertition_and_then_the_net():
    with match_of(REEFSCAPE, {"blue": "algae:4"}, at=MATCH.start("teleop")) as match:
        match.play(45.0)
        rows = match.rules.breakdown()
        assert rows["Blue/wallAlgaeCount"] == 2 and rows["Blue/netAlgaeCount"] >= 1


@pytest.mark.parametrize("level", [2, 4])
def test_a_defender_makes_contact_with_an_opponent_without_committing_a_foul(level):
    """The defender crosses between its cages and makes contact without G425, G427 or G418."""
    with match_of(REEFSCAPE, {"blue": "scorer:2", "red": f"defender:{level}"}, at=MATCH.start("teleop")) as match:
        touches = 0
        for _ in range(2250):
            match.tick()
            touches += (0, 1) in match.contacts.robots
        assert touches > 10
        assert [foul for foul in match.tracker.fouls if foul.alliance == "red"] == []


@pytest.mark.parametrize(("role", "points", "before"), [("parker:2", 2, 12.0), ("climber:3", 12, 20.0)])
def test_parking_and_climbing_players_get_their_barge_points_at_the_end(role, points, before):
    with match_of(REEFSCAPE, {"blue": role}, at=MATCH.duration - before) as match:
        match.play(before + 3.0)
        assert match.rules.breakdown()["Blue/endGameBargePoints"] == points
