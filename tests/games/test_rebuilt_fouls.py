"""Fouls and tower levels in matches of REBUILT: positive and negative cases of each."""

from __future__ import annotations

import math

import numpy as np
import pytest
from foul_trials import begin, foul_trials, told

from games.rebuilt import REBUILT, RebuiltSim
from games.rebuilt import dimensions as dim
from games.rebuilt.field import FIELD
from games.rebuilt.scoring import EventSettings
from simcore.match.game import RobotEntry
from simcore.match.scoring import ScoreEvent
from simcore.pieces.pool import PieceStatus

HALF = 0.4
MIDDLE = dim.FIELD_CENTER[0]
LINE = dim.ALLIANCE_ZONE_DEPTH
PUSH = {1: (1.0, 0.0, 0.0)}
AT_TOWER = (dim.TOWER_UPRIGHT_X + 0.5 * dim.TOWER_UPRIGHT_DEPTH + HALF + 0.01, dim.TOWER_Y, math.pi)


@pytest.fixture(scope="module")
def play():
    """Yield `play`; robots 0 and 2 are blue, robot 1 is red."""
    yield from foul_trials(REBUILT, far=((2.5, 1.5, 0.0), (14.0, 6.5, 0.0), (2.5, 6.5, 0.0)))


def free_fuel(match):
    """Return slots of fuel outside robots."""
    return match.pieces.on_field()


def shoot(match, number, *, into="blue"):
    """Launch a fuel from a robot so that it falls into a hub."""
    slot = int(free_fuel(match)[-1])
    match.pieces.hold(np.array([slot]), number)
    match.robots[number].storage.add([slot])
    match.tick()
    match.robots[number].storage.pieces.remove(slot)
    x, y = dim.HUB_CENTER if into == "blue" else FIELD.symmetry.flip_point(*dim.HUB_CENTER)
    match.pieces.launch(number, (x, y, 2.3), (0.0, 0.0, -1.0), slot=slot)


@pytest.mark.parametrize("side", ["blue", "red"])
@pytest.mark.parametrize(
    ("ahead", "fouls"), [(0.001, 1), (-0.001, 0)], ids=["a millimeter outside of the zone", "a millimeter inside"]
)
def test_g407_shooting_from_outside_the_alliance_zone_is_a_major_foul(play, side, ahead, fouls):
    pose = (LINE + HALF + ahead, 7.43, 0.0)
    match = play({0: pose}, 60.0, act=lambda match: shoot(match, 0, into=side), side=side, seconds=0.8)
    assert told(match) == [("G407", side, 15)] * fouls
    assert match.tracker.pieces[f"{side.capitalize()}Hub"] == 1


def test_g407_applies_only_to_the_robots_own_hub(play):
    match = play({0: (LINE + 1.0, 7.43, 0.0)}, 60.0, act=lambda match: shoot(match, 0, into="red"), seconds=0.8)
    assert told(match) == [] and match.tracker.pieces["RedHub"] == 1


def test_g403_contact_in_auto_is_a_foul_beyond_the_center_line(play):
    across = {1: (MIDDLE - HALF - 0.3, 1.0, math.pi), 0: (MIDDLE - 3 * HALF - 0.4, 1.0, 0.0)}
    assert told(play(across, 5.0, drive=PUSH)) == [("G403", "red", 15)]
    assert told(play(across, 60.0, drive=PUSH)) == [], "in teleop they may"
    on_it = {1: (MIDDLE, 1.0, math.pi), 0: (MIDDLE - 2 * HALF - 0.08, 1.0, 0.0)}
    match = play(on_it, 5.0, drive=PUSH)
    assert match.contacts.robots and told(match) == []


@pytest.mark.parametrize("side", ["blue", "red"])
def test_g420_contact_with_an_opponent_at_its_tower_in_the_last_30_s_is_a_foul(play, side):
    other = "red" if side == "blue" else "blue"
    poses = {0: AT_TOWER, 1: (AT_TOWER[0] + 2 * HALF + 0.1, AT_TOWER[1], math.pi)}
    drive = {0: (0.3, 0.0, 0.0), 1: (1.0, 0.0, 0.0)}
    match = play(poses, 140.0, drive=drive, side=side)
    assert told(match) == [("G420", other, 15)]
    assert match.rules.towers.awarded == set(), "it stands on the carpet"
    assert told(play(poses, 120.0, drive=drive, side=side)) == [], "before, they may"


def test_g420_gives_level_3_to_a_robot_off_the_carpet_and_does_not_apply_to_partners(play, monkeypatch):
    """The touched robot gets 30 points whatever its final position."""
    poses = {0: AT_TOWER, 1: (AT_TOWER[0] + 2 * HALF + 0.1, AT_TOWER[1], math.pi)}
    partners = {0: AT_TOWER, 2: poses[1]}
    drive = {0: (0.3, 0.0, 0.0), 1: (1.0, 0.0, 0.0), 2: (1.0, 0.0, 0.0)}
    match = play(partners, 140.0, drive=drive)
    assert (0, 2) in match.contacts.robots and told(match) == []
    monkeypatch.setattr("games.rebuilt.fouls.is_airborne", lambda robot: True)
    match = play(poses, 140.0, drive={number: drive[number] for number in poses})
    assert match.rules.towers.awarded == {0} and match.rules.breakdown()["Blue/endGameTowerPoints"] == 30


def test_g420_contact_through_fuel_counts_as_contact(play):
    """A fuel is between two robots, one of them at its tower."""
    gap = 2 * 0.075 - 0.01

    def between(match):
        slot = free_fuel(match)[:1]
        match.pieces.release(slot, np.array([[AT_TOWER[0] + HALF + 0.5 * gap, dim.TOWER_Y, 0.12]]))
        match.pieces.push(slot, np.array([[0.0, 0.0, 0.0]]))

    poses = {0: AT_TOWER, 1: (AT_TOWER[0] + 2 * HALF + gap + 0.02, AT_TOWER[1], math.pi)}
    match = play(poses, 140.0, drive={0: (0.3, 0.0, 0.0), 1: (0.6, 0.0, 0.0)}, act=between, seconds=0.3)
    assert told(match) == [("G420", "red", 15)] and not match.contacts.robots


def test_g418_a_robot_held_against_a_wall_for_three_seconds_is_pinned(play):
    """The pushing robot gets the foul; a robot that does not try to move is not pinned."""
    poses = {0: (6.5, HALF + 0.02, 0.0), 1: (6.5, 3 * HALF + 0.06, -math.pi / 2)}
    drive = {0: (0.0, 2.0, 0.0), 1: (2.5, 0.0, 0.0)}
    match = play(poses, 60.0, drive=drive, seconds=3.6)
    assert told(match) == [("G418", "red", 5)]
    match.play(3.0)
    assert told(match) == [("G418", "red", 5), ("G418", "red", 15)]
    assert told(play(poses, 60.0, drive=drive, seconds=2.6)) == []
    assert told(play(poses, 60.0, drive={1: (0.6, 0.0, 0.0)}, seconds=3.6)) == []


def test_g419_two_robots_in_both_trenches_commit_a_foul_every_three_seconds(play):
    trenches = {0: (dim.TRENCH_X, dim.TRENCH_LEFT_Y, 0.0), 2: (dim.TRENCH_X, dim.TRENCH_RIGHT_Y, 0.0)}
    assert told(play(trenches, 60.0, seconds=2.8)) == []
    match = play(trenches, 60.0, seconds=3.4)
    assert told(match) == [("G419", "blue", 15)]
    match.play(2.8)
    assert told(match) == [("G419", "blue", 15)] * 2, "and every three seconds another"
    one = {0: trenches[0], 2: (6.5, 4.0, 0.0)}
    assert told(play(one, 60.0, seconds=3.4)) == []


def test_g415_a_deployed_intake_inside_an_opponent_is_a_foul(play):
    def reach(match):
        for _ in range(60):
            match.robots[0].mechanisms["intake_deploy"].set_volts(8.0)
            match.robots[0].mechanisms["intake_roller"].set_volts(9.0)
            match.tick()

    gap = {0: (6.5, 2.0, 0.0), 1: (6.5 - 2 * HALF - 0.15, 2.0, 0.0)}
    match = play(gap, 60.0, drive=PUSH, act=reach, seconds=0.5)
    assert told(match) == [("G415", "blue", 5)]
    for name in ("intake_deploy", "intake_roller"):
        match.robots[0].mechanisms[name].set_volts(-8.0 if name == "intake_deploy" else 0.0)
    match.play(1.5)
    assert told(play(gap, 60.0, drive=PUSH)) == []


def test_g408_catching_and_keeping_fuel_out_of_a_hub_is_a_foul(play):
    """The robot must hold the fuel for more than a moment; fuel that has touched the carpet may be kept."""

    def emerge(*, met=True, falls=False, held=0.8):
        def act(match):
            slot = free_fuel(match)[:1]
            match.pieces.release(slot, np.array([[6.5, 2.0, 0.8] if met else [6.0, 3.0, 0.5]]))
            match.pieces.push(slot, np.array([[0.0, 0.0, -1.0]]), flying=True)
            match.rules.fouls.emerged(int(slot[0]))
            for _ in range(50):
                match.tick()
                if not match.pieces.is_untouched[slot[0]]:
                    break
            match.tick()
            if falls:
                match.pieces.release(slot, np.array([[6.0, 3.0, 0.08]]))
                match.tick()
            match.pieces.hold(slot, 0)
            match.robots[0].storage.add(slot.tolist())
            match.play(held)
            match.robots[0].forget_pieces()
            match.pieces.release(slot, np.array([[3.0, 6.0, 0.3]]))

        return act

    poses = {0: (6.5, 2.0, 0.0)}
    assert told(play(poses, 60.0, act=emerge())) == [("G408", "blue", 5)]
    assert told(play(poses, 60.0, act=emerge(held=0.4))) == []
    assert told(play(poses, 60.0, act=emerge(met=False))) == [], "it has been on the carpet"
    assert told(play(poses, 60.0, act=emerge(falls=True))) == [], "it fell off the robot first"


def test_g405_fuel_shot_over_the_guardrail_is_a_minor_and_then_a_major_foul(play):
    def over(match):
        for number in range(2):
            slot = int(free_fuel(match)[-1 - number])
            match.pieces.hold(np.array([slot]), 0)
            match.robots[0].storage.add([slot])
            match.tick()
            match.robots[0].storage.pieces.remove(slot)
            match.pieces.launch(0, (2.5, 7.0, 1.0), (0.0, 6.0, 2.0), slot=slot)
            match.play(0.6)

    match = play({}, 60.0, act=over)
    assert told(match) == [("G405", "blue", 5), ("G405", "blue", 15)]


def test_g405_counts_per_robot_and_only_for_fuel_that_touched_nothing():
    with RebuiltSim(robots=[RobotEntry(preload=0), RobotEntry(preload=0)]) as match:
        fouls = match.rules.fouls
        for slot, (robot, untouched) in enumerate(((0, True), (1, True), (0, False), (1, True))):
            fouls._shots[slot] = robot, False
            fouls.left_field(slot, untouched=untouched)
        fouls.left_field(8, untouched=True)  # no robot shot it
        assert [foul[2] for foul in told(match)] == [5, 5, 15]


def test_g419_the_three_seconds_restart_after_a_gap(play):
    trenches = {0: (dim.TRENCH_X, dim.TRENCH_LEFT_Y, 0.0), 2: (dim.TRENCH_X, dim.TRENCH_RIGHT_Y, 0.0)}

    def twice(match):
        match.play(2.0)
        away = match.robots[0].chassis.pose
        match.carry_to(0, (6.5, 4.0, 0.0))
        match.play(0.1)
        match.carry_to(0, away)
        match.play(2.0)

    assert told(play(trenches, 60.0, act=twice)) == []


def test_g419_also_applies_to_bumps_with_robots_at_rest(play):
    """Robots block both bumps of a side; driving side by side through the trenches at 0.6 m/s is no foul."""
    bumps = {0: (dim.BUMP_X, dim.BUMP_LEFT_Y, 0.0), 2: (dim.BUMP_X, dim.BUMP_RIGHT_Y, 0.0)}
    assert told(play(bumps, 60.0, seconds=3.2)) == [("G419", "blue", 15)]
    before = dim.TRENCH_X - 0.5 * dim.TRENCH_DEPTH - HALF
    drive = dict.fromkeys((0, 2), (0.6, 0.0, 0.0))
    through = {0: (before, dim.TRENCH_LEFT_Y, 0.0), 2: (before, dim.TRENCH_RIGHT_Y, 0.0)}
    assert told(play(through, 60.0, drive=drive, seconds=3.3)) == []


def test_fuel_that_has_come_to_rest_is_no_longer_a_shot_of_its_shooter(play):
    """G405 and G407 apply to the shooter; a robot that moves the fuel later did not shoot it."""

    def rest(match):
        slot = int(free_fuel(match)[-1])
        assert match.pieces.state.status[slot] == PieceStatus.ASLEEP
        match.rules.fouls._shots[slot] = 0, True
        match.tick()
        match.rules.fouls.scored(ScoreEvent(match.time, "BlueHub", "blue", 1, slot))
        match.rules.fouls.left_field(slot, untouched=True)

    assert told(play({}, 60.0, act=rest)) == []


# --- fuel, tower and score sheet --------------------------------------------------------------------------------------


def drop(match, alliance, time):
    """Return the points of a fuel that passes the throat of a hub at a match time [s]."""
    begin(match, time)
    match.rules.hubs.count("blue", 5.0)
    match.rules.hubs.count("blue", 5.0)
    zone = next(zone for zone in match.game.zones if zone.alliance == alliance)
    return match.rules.worth(zone)


@pytest.mark.parametrize(
    ("sentence", "alliance", "time", "points"),
    [
        ("a hub that turns on in 0.1 s counts what falls in now: its sensors see it later", "blue", 57.9, 1),
        ("... in 0.3 s it does not", "blue", 57.7, 0),
        ("a shot after the hub went inactive has 3 s until the sensors, not until the rim", "blue", 35.7, 1),
        ("... a tenth later it has not", "blue", 35.8, 0),
    ],
)
def test_a_hub_counts_fuel_by_the_time_at_which_its_sensors_detect_it(sentence, alliance, time, points):
    with RebuiltSim() as match:
        assert drop(match, alliance, time) == points, sentence


def test_fuel_thrown_by_a_human_player_counts_in_auto():
    """G402 allows human players to enter fuel in auto."""
    with RebuiltSim(options=["human_players"], robots=(RobotEntry(preload=0),), seed=2) as match:
        match.play(20.0)
        thrown = 24 - match.rules.human_players.stock["blue"]
        sheet = match.rules.breakdown()
        assert thrown >= 10 and 0 < sheet["Blue/hubScore/autoCount"] <= thrown
        assert match.score.blue == sheet["Blue/totalAutoPoints"] == sheet["Blue/hubScore/autoCount"]


def test_the_score_sheet_adds_up_and_contains_the_ranking_points():
    with RebuiltSim(robots=(RobotEntry(), RobotEntry(alliance="red"), RobotEntry())) as match:
        match.rules.event = EventSettings(traversal=60)  # each threshold is met exactly
        begin(match, 165.94)
        for alliance, count in (("red", 100), ("blue", 360)):
            for _ in range(count):
                match.rules.hubs.count(alliance, 140.0)
        match.rules.towers.awarded = {0, 2}
        match.tracker.add("blue", 300)
        match.play(0.1)
        rows = match.rules.breakdown()
        assert rows["Blue/endGameTowerPoints"] == rows["Blue/totalTowerPoints"] == 60
        assert (rows["Blue/energizedAchieved"], rows["Blue/superchargedAchieved"]) == (1, 1)
        assert rows["Blue/traversalAchieved"] == 1 and rows["Red/traversalAchieved"] == 0
        assert (rows["Red/energizedAchieved"], rows["Red/superchargedAchieved"]) == (1, 0)
        assert rows["Blue/rp"] == 3 + 3 and rows["Red/rp"] == 1
        assert rows["Blue/totalPoints"] == 360 + 60
        telemetry = match.snapshot().strings
        assert telemetry["Sim/Match/EndGameTowerRobot1"] == "Level3"
        assert telemetry["Sim/Match/EndGameTowerRobot2"] == "None"


@pytest.mark.parametrize("totals", [(7, 7), (8, 7)])
def test_after_the_assessment_a_win_gives_three_ranking_points_and_a_tie_gives_one(totals):
    with RebuiltSim() as match:
        match.tracker.add("blue", totals[0])
        match.tracker.add("red", totals[1])
        match.timer.time = 165.9
        assert match.rules.breakdown()["Blue/rp"] == 0
        match.timer.time = 166.0
        rows = match.rules.breakdown()
        assert (rows["Blue/rp"], rows["Red/rp"]) == ((1, 1) if totals == (7, 7) else (3, 0))


def test_in_auto_only_tower_level_1_counts():
    """It is worth 15 points, however high a robot is at 0:00."""
    with RebuiltSim(robots=(RobotEntry(preload=0),)) as match:
        begin(match, 19.99)
        match.rules.towers.level = lambda robot: 3
        match.tick()
        assert match.snapshot().strings["Sim/Match/AutoTowerRobot1"] == "Level1"
        assert match.rules.towers.points("blue") == (15, 0)


def test_the_tower_counts_at_most_two_robots_in_auto_and_no_carried_robot():
    robots = tuple(RobotEntry(preload=0) for _ in range(3))
    with RebuiltSim(robots=robots) as match:
        towers = match.rules.towers
        towers.auto = {0: 1, 1: 1, 2: 1}
        towers.final = {0: 3, 1: 2, 2: 1}
        assert towers.points("blue") == (30, 60) and towers.points("red") == (0, 0)
        towers.carried = {0}
        assert towers.points("blue") == (30, 30)
        towers.awarded = {2}
        assert towers.points("blue") == (30, 20 + 30)


def test_g414_a_robot_carried_by_its_partner_loses_its_tower_points():
    robots = (RobotEntry(preload=0), RobotEntry(preload=0))
    with RebuiltSim(robots=robots) as match:
        below, above = match.robots
        begin(match, 100.0)
        above.chassis.pos = (below.chassis.pos[0], below.chassis.pos[1], 0.5)
        match.contacts.robots |= {(0, 1), (1, 0)}
        match.rules.fouls.after_tick()
        assert match.rules.towers.carried == {1}


def test_a_robot_must_keep_its_tower_level_until_the_end_of_the_assessment():
    """A robot that hangs at the low rung but falls 2.5 s after the match has no level."""
    with RebuiltSim(robots=(RobotEntry(start=AT_TOWER, preload=0),)) as match:
        levels = {True: 1, False: 0}
        hangs = True
        begin(match, 162.9)
        match.rules.towers.level = lambda robot: levels[hangs]
        match.play(2.5)
        assert match.rules.breakdown()["Blue/endGameTowerPoints"] == 10
        hangs = False
        match.play(0.2)
        assert match.rules.breakdown()["Blue/endGameTowerPoints"] == 0 == match.score.blue
        match.play(1.0)
        hangs = True
        match.play(0.1)
        assert match.rules.breakdown()["Blue/endGameTowerPoints"] == 0, "the assessment is over"
