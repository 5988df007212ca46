"""Button actions of a human driver: shoot, place on the nearest branch, take and process algae."""

from __future__ import annotations

import pytest

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.players.driven_robot import DrivenRobot, DriverInput


def driven(game, alliance, start):
    """Return a match with a robot whose driver holds the buttons of `wants`."""
    match, wants = Match(game, robots=(RobotEntry(alliance=alliance, start=start),)), {}
    match.set_controller(0, DrivenRobot(game.driving, match, alliance, lambda: DriverInput(**wants)))
    return match, wants


@pytest.mark.parametrize("alliance", ["blue", "red"])
def test_a_robot_shoots_fuel_while_the_button_is_held(alliance):
    match, wants = driven(REBUILT, alliance, (2.5, 5.6, 0.0))
    with match:
        wants.update(ahead=0.3, action=0)
        while len(match.record.shots) < 2:
            match.tick()
            assert match.time < 4.0
        wants.update(ahead=0.0, action=None)
        match.play(0.3)
        shots = len(match.record.shots)
        match.play(2.0)
        assert len(match.record.shots) == shots == match.record.hits and len(match.robots[0].held) == 8 - shots > 2


def test_a_robot_places_coral_on_the_nearest_branch_and_stows_on_button_release():
    match, wants = driven(REEFSCAPE, "red", (6.6, 5.6, -2.1))
    with match:
        arm, elevator = (match.robots[0].mechanisms[name] for name in ("arm", "elevator"))
        wants.update(action=0)
        match.play(1.2)
        assert elevator.position > 10.0
        wants.clear()
        match.play(1.5)
        assert arm.position > 1.4 and elevator.position < 6.0 and match.robots[0].held
        wants.update(action=0)
        match.play(5.0)
        assert match.pieces.places.totals()["RedL4"] == 1
        assert not match.robots[0].held


def test_a_robot_takes_algae_off_the_reef_and_brings_it_to_the_processor():
    match, wants = driven(REEFSCAPE, "blue", (7.2, 4.0, 3.14159))
    with match:
        wants.update(action=3)
        match.play(4.0)
        assert match.robots[0].placers[1].piece is not None
        wants.clear()
        match.play(0.5)
        assert match.robots[0].placers[1].piece is not None, "it is held while nothing is pressed"
        wants.update(action=3)
        match.play(7.0)
        assert match.robots[0].placers[1].piece is None
        assert match.tracker.pieces["BlueProcessor"] == 1
