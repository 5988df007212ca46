"""Whole matches of scripted players: no fuel is lost, runs repeat, and each role does its task."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from match_laws import match_of

from games.rebuilt import REBUILT
from games.rebuilt.autos import SETTINGS
from games.rebuilt.scoring import MATCH
from simcore.match.players.lineup import lineup, play_match
from simcore.match.players.player import SKILLS, Player

SIX = {"red": "collector:3,shuttle:2,defender:3", "blue": "collector:3,climber:2,idle"}
played = partial(match_of, REBUILT, options=("hub_exits", "human_players"))

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def _engine(engine_name, whole):
    if engine_name == "mujoco" and not whole:
        pytest.skip("sampled: --whole plays on both engines")


def test_no_fuel_is_lost_at_any_tick(whole):
    def look(match):
        count = match.count
        assert count.is_conserved and count.staged == 504, f"{match.time} s: {count}"

    run = play_match(REBUILT, lineup(REBUILT, **SIX), seconds=None if whole else 24.0, seed=4, on_tick=look)
    with run.match as match:
        assert run.report.players[0] == "blue collector:3" and run.report.auto == "match"
        rows, hubs = run.report.breakdown, match.rules.hubs.fuel
        assert run.report.hits > 10 and match.score.total > 10
        thrown = rows["Blue/humanPlayerPoints"] + rows["Red/humanPlayerPoints"]
        others = sum(hub.total() for hub in hubs.values()) - run.report.hits - thrown
        assert 0 <= others <= sum(hub["uncounted"] for hub in hubs.values()), "throws at a hub that is off"
        length, width = REBUILT.field.size
        for robot in match.robots:
            assert 0.3 < robot.chassis.pose[0] < length - 0.3 and 0.3 < robot.chassis.pose[1] < width - 0.3
        if whole:
            assert match.timer.is_over and rows["Blue/rp"] + rows["Red/rp"] >= 2
            assert rows["Blue/totalPoints"] == match.score.blue and rows["Red/totalPoints"] == match.score.red


def test_a_collector_does_not_shoot_while_its_hub_is_inactive():
    """In shifts 1 and 3 the hub of the auto leader is inactive."""
    with played({"blue": "collector:3"}, at=MATCH.start("shift 1") + 4.0) as match:
        match.rules.hubs.fuel["blue"]["auto"] = 1
        match.play(14.0)
        assert match.rules.hubs.fuel["blue"]["uncounted"] <= 2, "what the human player throws"
        assert len(match.robots[0].held) >= SKILLS[2].load
        assert not match.rules.is_active("blue")


def test_a_climber_hangs_on_the_low_rung_when_the_match_ends():
    with played({"blue": "climber:3"}, at=MATCH.duration - 14.5) as match:
        match.play(17.6)
        assert match.rules.breakdown()["Blue/endGameTowerPoints"] == 10
        assert match.robots[0].climbers[0].rung.name == "blue_tower_rung_low"


def test_a_shuttle_throws_fuel_into_its_alliance_zone():
    with played({"blue": "shuttle:3"}, at=MATCH.start("transition")) as match:
        match.play(14.0)
        zone = match.pieces.state.pos[match.pieces.on_field(), 0] < 4.0
        assert zone.sum() > 24 + 8, "beside the depot's"


def test_a_defender_makes_contact_with_an_opponent_without_committing_a_foul():
    """The defender makes contact, but neither pins (G418) nor reaches into the other robot (G415)."""
    with played({"blue": "collector:2", "red": "defender:3"}, at=MATCH.start("transition")) as match:
        touches = 0
        for _ in range(1000):
            match.tick()
            touches += (0, 1) in match.contacts.robots
        assert touches > 25
        assert [foul for foul in match.tracker.fouls if foul.alliance == "red"] == []


@pytest.mark.parametrize("under", [[(0.0, 0.0)], [(0.3, -0.17)], [(0.02, 0.2), (0.0, -0.06), (0.3, 0.21)]], ids=str)
def test_a_player_frees_its_robot_from_the_fuel_underneath(under):
    """Placed on fuel, the player drives toward the robot's lower side until it stands on its wheels."""
    with played({"blue": "idle"}, at=MATCH.start("transition")) as match:
        robot, pieces = match.robots[0], match.pieces
        slots = np.nonzero(pieces.on_field())[0][: len(under)]
        pieces.push(slots, np.zeros((len(slots), 3)))
        for slot, (x, y) in zip(slots.tolist(), under, strict=True):
            pieces.state.pos[slot] = 8.3 + x, 0.9 + y, 0.075
        match.world.set_pose(robot.chassis.row, (8.3, 0.9, 0.3), (0.0, 0.0, 0.0, 1.0))
        player = Player(lambda player: player.shake_off(), match, "blue", SKILLS[2], SETTINGS)
        match.play(1.5)  # until it no longer bounces
        robot.chassis.read()
        match.set_controller(0, player)
        match.tick()
        assert player.is_beached
        while not player.is_done and match.time < 6.0:
            match.tick()
        match.play(0.5)
        assert not player.is_beached and match.time < 5.0
        assert robot.chassis.pos[2] < 0.01, "all wheels stand on the carpet"


@pytest.mark.parametrize(
    ("opponent", "at", "seconds", "rule"),
    [
        ("collector:3", 0.0, 22.0, "G403"),  # stays on its side of the center line in auto
        ("climber:3", MATCH.duration - 16.0, 15.5, "G420"),  # keeps away from a robot at the tower in the end game
    ],
)
def test_a_defender_avoids_the_fouls_of_its_role(opponent, at, seconds, rule):
    with played({"blue": opponent, "red": "defender:4"}, at=at) as match:
        match.play(seconds)
        assert [foul for foul in match.tracker.fouls if foul.rule == rule] == []
        x, _, _ = match.robots[1].chassis.pose
        if rule == "G403":
            assert x > 0.5 * REBUILT.field.size[0]
        else:
            assert x < 0.75 * REBUILT.field.size[0], "it has come to defend"
