"""Geometric fouls in the 2025 game: positive and negative cases of each."""

from __future__ import annotations

import math

import numpy as np
import pytest
from foul_trials import foul_trials, told

from games.reefscape import REEFSCAPE
from games.reefscape import dimensions as dim
from games.reefscape.places import branch_ends
from simcore.pieces.pool import PieceStatus
from simcore.pieces.resting_places import PlaceEvent

HALF = 0.4


@pytest.fixture(scope="module")
def play():
    """Yield `play`; robots 0 and 2 are blue, robot 1 is red."""
    yield from foul_trials(REEFSCAPE, far=((2.5, 7.0, 0.0), (15.0, 1.0, 0.0), (2.5, 1.0, 0.0)))


AT_REEF = (dim.REEF_CENTER[0] + dim.REEF_APOTHEM + HALF + 0.05, dim.REEF_CENTER[1], math.pi)
BEHIND = (AT_REEF[0] + 2 * HALF + 0.1, AT_REEF[1], math.pi)
OPEN = ((7.0, 2.0, 0.0), (7.0 - 2 * HALF - 0.1, 2.0, 0.0))


@pytest.mark.parametrize("side", ["blue", "red"])
def test_g427_contact_with_an_opponent_in_its_reef_zone_is_a_foul(play, side):
    other = "red" if side == "blue" else "blue"
    push = {1: (1.0, 0.0, 0.0)}
    match = play({0: AT_REEF, 1: BEHIND}, 60.0, drive=push, side=side)
    assert told(match) == [("G427", other, 6)], "once, however long it lasts"
    assert match.tracker.totals == {side: 6, other: 0}
    name = side.capitalize()
    assert match.rules.breakdown()[f"{name}/foulPoints"] == 6
    assert match.rules.breakdown()[f"{other.capitalize()}/techFoulCount"] == 1
    said = match.snapshot().strings["Sim/Match/LastFoul"]
    assert said == f"1. G427, {other} robot 1 touches robot 0 in its zone: {side} +6"
    match = play({0: OPEN[0], 1: OPEN[1]}, 60.0, drive=push, side=side)
    assert match.contacts.robots and told(match) == [], "in the open field they may"
    match = play({0: AT_REEF, 1: (BEHIND[0] + 0.2, *BEHIND[1:])}, 60.0, side=side)
    assert not match.contacts.robots and told(match) == [], "beside it, it may stand"
    match = play({0: AT_REEF, 2: BEHIND}, 60.0, drive={2: (1.0, 0.0, 0.0)}, side=side)
    assert match.contacts.robots and told(match) == [], "a partner may"


def test_g425_a_pin_is_a_foul_after_three_seconds_and_again_three_seconds_later(play):
    poses = {0: (6.8, HALF + 0.02, 0.0), 1: (6.8, 3 * HALF + 0.06, -math.pi / 2)}
    drive = {0: (0.0, 2.0, 0.0), 1: (2.5, 0.0, 0.0)}
    match = play(poses, 60.0, drive=drive, seconds=3.6)
    assert told(match) == [("G425", "red", 2)]
    match.play(3.0)
    assert told(match) == [("G425", "red", 2), ("G425", "red", 6)]
    assert told(play(poses, 60.0, drive=drive, seconds=2.6)) == []


def test_auto_contact_is_a_foul_only_beyond_the_barge(play):
    push = {1: (1.0, 0.0, 0.0)}
    match = play({0: OPEN[0], 1: OPEN[1]}, 5.0, drive=push)
    assert told(match) == [("G403", "red", 6)], "red's robot is on blue's side"
    barge = dim.FIELD_CENTER[0] - 0.5 * dim.BARGE_ZONE_DEPTH
    poses = {0: (barge - 3 * HALF, 2.0, 0.0), 1: (barge - HALF + 0.08, 2.0, 0.0)}
    match = play(poses, 5.0, drive={0: (1.0, 0.0, 0.0)})
    assert match.contacts.robots and told(match) == []


def test_touching_an_opponents_cage_is_a_foul(play):
    """G405 applies in auto and G418, with the barge ranking point, in teleop. A robot may touch its own cages."""

    def at(cage):
        return (dim.CAGE_X + HALF + 0.15, dim.CAGE_YS[cage], math.pi)

    push = {1: (0.5, 0.0, 0.0)}
    assert told(play({1: at(0)}, 5.0, drive=push)) == [("G405", "red", 6)]
    match = play({1: at(1)}, 60.0, drive=push)
    assert told(match) == [("G418", "red", 6)]
    rows = match.rules.breakdown()
    assert rows["Red/g418Penalty"] == 1 and rows["Blue/bargeBonusAchieved"] == 1 and not rows["Red/bargeBonusAchieved"]
    match = play({0: at(2)}, 60.0, drive={0: (0.5, 0.0, 0.0)})
    assert match.hanging[2].is_awake and told(match) == []


def test_touching_a_climber_in_the_end_game_is_a_foul(play):
    """G428 applies to contact with a robot at its cage; before the end game the rule is G427.

    On MuJoCo the cage swings away for a tick, so G427 follows as well.
    """

    def beside(cage):
        x, y = dim.CAGE_X - HALF - 0.11, dim.CAGE_YS[cage]
        return {0: (x, y, 0.0), 1: (x - 2 * HALF - 0.15, y, 0.0)}

    drive = {0: (0.6, 0.0, 0.0), 1: (1.2, 0.0, 0.0)}
    match = play(beside(0), 140.0, drive=drive, seconds=0.7)
    assert ("G428", "red", 6) in told(match) and set(told(match)) <= {("G428", "red", 6), ("G427", "red", 6)}
    assert match.rules.breakdown()["Blue/bargeBonusAchieved"] == 1
    assert told(play(beside(2), 60.0, drive=drive, seconds=0.7)) == [("G427", "red", 6)]


def test_g409_holding_more_than_one_coral_or_one_algae_is_a_foul(play):
    def take(*kinds):
        def act(match):
            state, robot = match.pieces.state, match.robots[0]
            for kind in kinds:
                name = [supply.kind.name for supply in REEFSCAPE.pieces].index(kind)
                free = (state.kind == name) & (state.holder != 0)
                free &= state.status != PieceStatus.HELD
                slot = np.nonzero(free)[0][-1:]
                match.pieces.hold(slot, 0)
                robot.storage.pieces.append(int(slot[0]))

        return act

    match = play({}, 60.0, act=take("Coral", "Algae"))
    assert told(match) == []
    match = play({}, 60.0, act=take("Coral"), seconds=1.5)
    assert told(match) == [("G409", "blue", 2)]
    assert match.rules.breakdown()["Blue/foulCount"] == 1
    match.robots[0].forget_pieces()
    match.pieces.release(match.pieces.held(0), np.array([[3.0, 6.0 + 0.5 * n, 0.3] for n in range(3)]))


def test_taking_a_coral_off_the_opponents_reef_gives_the_opponents_the_ranking_point(play):
    """The rule is G410; a robot may take coral off its own reef."""

    def put_and_take(number):
        def act(match):
            _, tip = (np.array(end) for end in branch_ends(2 + number, 4))
            state = match.pieces.state
            slot = np.nonzero((state.kind == 0) & (state.status == PieceStatus.STAGED))[0][:1]
            match.pieces.release(slot, tip[None] + (0.0, 0.0, 0.17))
            match.play(1.5)
            assert match.pieces.places.count(f"Blue {'ABCD'[2 + number]} L4") == 1
            match.pieces.hold(slot, number)

        return act

    match = play({}, 60.0, act=put_and_take(1))
    assert told(match) == [("G410", "red", 6)]
    rows = match.rules.breakdown()
    assert rows["Red/g410Penalty"] == 1 and rows["Blue/coralBonusAchieved"] == 1 and rows["Red/coralBonusAchieved"] == 0
    assert told(play({}, 60.0, act=put_and_take(0))) == []


@pytest.mark.parametrize(
    ("robot", "place", "ago", "fouls"),
    [
        (1, "Blue A L4", 0.5, [("G410", "red", 6)]),
        (0, "Blue A L4", 0.5, []),
        (1, "Blue A L4", 2.0, []),
        (1, "Blue net", 0.5, []),
    ],
    ids=["the other's", "one's own", "long after the touch", "an algae"],
)
def test_g410_also_applies_to_a_coral_knocked_off_the_opponents_reef(play, robot, place, ago, fouls):
    def fall(match):
        match.rules.fouls._touched[3] = robot, match.time - ago
        here = next(one for one in match.game.places if one.name == place)
        match.rules.removed(PlaceEvent(here, 3, -1))

    assert told(play({}, 60.0, act=fall, seconds=0.1)) == fouls


def test_launching_coral_outside_the_robots_own_reef_zone_is_a_foul(play):
    """G412 applies to launched coral; released coral drops where the robot is."""

    def let_go(speed):
        def act(match):
            state = match.pieces.state
            slot = np.nonzero((state.kind == 0) & (state.status == PieceStatus.STAGED))[0][:1]
            match.pieces.hold(slot, 0)
            match.robots[0].storage.pieces.append(int(slot[0]))
            match.tick()
            match.robots[0].storage.pieces.clear()
            x, y, _ = match.robots[0].chassis.pos
            match.pieces.launch(0, (x, y, 0.8), (speed, 0.0, 1.0), slot=int(slot[0]), flying=False)

        return act

    assert told(play({0: OPEN[0]}, 60.0, act=let_go(3.0))) == [("G412", "blue", 6)]
    assert told(play({0: OPEN[0]}, 60.0, act=let_go(0.5))) == []
    assert told(play({0: AT_REEF}, 60.0, act=let_go(3.0))) == []


def test_placing_algae_on_the_opponents_reef_is_a_foul(play):
    """G411 applies once the algae is at rest; algae next to the reef is no foul."""

    def lay(number, where):
        def act(match):
            state = match.pieces.state
            slot = match.pieces.on_field("Algae")[:1]
            match.pieces.hold(slot, number)
            match.robots[number].storage.pieces.append(int(slot[0]))
            match.tick()
            match.robots[number].storage.pieces.clear()
            match.pieces.launch(number, where, (0.0, 0.0, 0.0), slot=int(slot[0]), flying=False)
            assert state.status[slot[0]] == PieceStatus.AWAKE

        return act

    (x, y), top = dim.REEF_CENTER, dim.TROUGH_WALL_HEIGHT + 0.5 * dim.ALGAE_DIAMETER
    assert told(play({}, 60.0, act=lay(1, (x, y, top + 0.02)), seconds=2.0)) == [("G411", "red", 6)]
    assert told(play({}, 60.0, act=lay(1, (x + 2.0, y - 1.0, 0.21)), seconds=2.0)) == []
    beside = dim.REEF_APOTHEM + 0.5 * dim.ALGAE_DIAMETER + 0.02
    assert told(play({}, 60.0, act=lay(1, (x + beside, y, 0.21)), seconds=0.6)) == [], "on the carpet of its zone"


def test_a_second_robot_beyond_the_barge_commits_a_foul_every_three_seconds(play):
    """G421 gives a minor foul, then a major foul every three seconds."""
    poses = {0: (11.0, 7.0, 0.0), 2: (11.0, 1.0, 0.0)}
    match = play(poses, 60.0, seconds=6.1)
    assert told(match) == [("G421", "blue", 2), ("G421", "blue", 6), ("G421", "blue", 6)]
    assert told(play({0: poses[0]}, 60.0)) == []
