"""Lineups as typed by users: players, alliances and refusals."""

from dataclasses import replace
from types import SimpleNamespace
from unittest.mock import Mock

import pytest
from each_case import each

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.game import Game, Role
from simcore.match.match import Match
from simcore.match.players.lineup import Seat, WhileEnabled, entries, lineup, match_seconds, read_player, take_seats
from simcore.units import TICK


def stand(robot, time):
    robot.drive.set_chassis_speeds(0.0, 0.0, 0.0)


def drive(robot, time):
    robot.drive.set_chassis_speeds(1.0, 0.0, 0.0)


GAME = replace(
    Game.bare(),
    starts=((2.0, 2.0, 0.0), (2.0, 4.0, 0.0)),
    assessment=3.0,
    roles={
        name: Role(name=name, summary="", controller=lambda match, alliance, level: drive if level > 2 else stand)
        for name in ("taker", "waiter")
    },
)


def test_a_line_up_lists_me_first_and_otherwise_blue_before_red():
    assert lineup(GAME, red="taker:4, waiter", blue="taker") == (
        Seat("blue", "taker", 2),
        Seat("red", "taker", 4),
        Seat("red", "waiter", 2),
    )
    mine = lineup(GAME, red="taker+me", blue="waiter:1")
    assert [str(seat) for seat in mine] == ["me", "taker:2", "waiter:1"]
    assert [seat.alliance for seat in mine] == ["red", "red", "blue"]
    assert [entry.alliance for entry in entries(GAME, mine)] == ["red", "red", "blue"]


@each(
    ("red", "blue", "problem"),
    [
        ("takre", "", "no role of bare named 'takre'. Did you mean 'taker'"),
        ("taker:5", "", "level must be one of 1, 2, 3, 4, got '5'"),
        ("taker:fast", "", "got 'fast'"),
        ("taker:", "", "got ''"),
        ("taker,taker,taker", "", "at most 2 robots, got 3 in --red taker,taker,taker"),
        ("me", "me", "can be 'me', got 2"),
        ("", " ", "nobody plays"),
        ("taker,", "", "no role of bare named ''"),
    ],
)
def test_the_error_for_an_invalid_line_up_names_the_mistake(red, blue, problem):
    with pytest.raises(ConfigError if "role" not in problem else UnknownNameError) as caught:
        lineup(GAME, red=red, blue=blue)
    assert problem in str(caught.value)


def test_scripted_players_of_a_game_without_roles_are_refused():
    with pytest.raises(ConfigError, match="bare has no scripted players"):
        read_player(Game.bare(), "taker")


def test_players_drive_while_robots_may_move_and_a_match_includes_its_assessment():
    clock = GAME.clock
    assert match_seconds(GAME) == pytest.approx(clock.duration + 3.0 + 2 * TICK)
    seats = lineup(GAME, blue="me,taker:3", red="taker:2")
    with Match(GAME, robots=entries(GAME, seats)) as match:
        take_seats(match, seats)
        starts = [robot.chassis.pose[0] for robot in match.robots]
        match.play(1.0)
        ways = [robot.chassis.pose[0] - start for robot, start in zip(match.robots, starts, strict=True)]
        assert ways[1] > 0.5 and max(abs(ways[0]), abs(ways[2])) < 0.02
        match.timer.follow_driver_station()
        match.play(1.5)
        assert match.robots[1].chassis.speed < 0.05, "disabled"


def test_a_player_restarts_with_each_auto_and_coasts_while_disabled():
    """The player does not restart with teleop, nor when robots are enabled again during a mode."""
    timer = SimpleNamespace(is_enabled=False, phase=SimpleNamespace(mode="auto"))
    make, robot = Mock(side_effect=Mock), SimpleNamespace(drive=Mock(), mechanisms={"roller": Mock()})
    player = WhileEnabled(SimpleNamespace(timer=timer), make)
    begun = []
    for is_enabled, mode in (
        (True, "auto"), (True, "auto"), (False, "disabled"), (True, "teleop"), (False, "teleop"), (True, "teleop"),
        (False, "auto"), (True, "auto"), (True, "auto"),
    ):  # fmt: skip
        timer.is_enabled, timer.phase.mode = is_enabled, mode
        player(robot, 0.0)
        begun.append(make.call_count)
    assert begun == [1, 1, 1, 1, 1, 1, 1, 2, 2]
    assert robot.drive.stop.call_count == robot.mechanisms["roller"].coast.call_count == 3
