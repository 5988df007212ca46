"""Commands that the field control refuses; tests/games/test_field_control.py tests the effects of commands."""

import pytest
from each_case import each

from simcore.errors import SimcoreError
from simcore.match.field_control import ACTIONS
from simcore.match.game import PieceSupply
from simcore.match.match import Match
from simcore.pieces.kinds import GamePieceConfig
from simcore.world.shapes import Sphere

BALL = GamePieceConfig(name="Ball", shape=Sphere(0.08), mass=0.2)
UNREADABLE = [
    ("human", {"alliance": [], "name": "x"}, "human: alliance must be a string, got []"),
    ("leave", {"alliance": {}}, "leave: alliance must be a string, got {}"),
    ("leave", {}, "leave: arguments are ['alliance'], got []"),
    ("reset", {"value": 1}, "reset: arguments are [], got ['value']"),
    ("start", {"robot": True}, "start: robot must be a whole number, got True"),
    ("start", {"robot": None}, "start: robot must be a whole number, got None"),
    ("take_over", {"alliance": "blue", "by_person": "no"}, "by_person must be True or False, got 'no'"),
    ("put_down", {"kind": "Ball", "places": 3}, "a place is 2 finite numbers, x, y [m], got 3"),
    ("place", {"pose": {}, "robot": 0}, "a pose is 3 finite numbers"),
    ("dance", {}, "no action named 'dance'"),
    (["x"], {}, "no action named ['x']"),
    (None, {}, "no action named None"),
]
NOT_DONE = [
    ("start", {"robot": 7}, "there are robots 0 to 0, got 7"),
    ("spawn", {"kind": "Bell", "robot": 0}, "Did you mean 'Ball'?"),
    ("spawn", {"kind": "Ball", "robot": -1}, "there are robots 0 to 0, got -1"),
    ("auto", {"name": "x", "robot": 0}, "no auto named 'x'"),
    ("human", {"alliance": "blue", "name": "x"}, "has no human players"),
]


@pytest.fixture
def match():
    with Match.bare(pieces=[PieceSupply(BALL, 2)]) as match:
        yield match


@each(("name", "arguments", "words"), UNREADABLE)
def test_unreadable_arguments_are_refused_at_once(match, name, arguments, words):
    with pytest.raises(SimcoreError) as caught:
        match.control.do(name, arguments)
    assert words in str(caught.value)
    match.tick()
    assert match.control.count == 0


def test_an_impossible_command_is_refused_in_the_next_tick_with_the_reason(match):
    for name, arguments, words in NOT_DONE:
        match.control.do(name, arguments)
        match.tick()
        result = match.control.results[-1]
        assert not result.is_done and words in result.text
    assert {name for name, _, _ in UNREADABLE[:-3] + NOT_DONE} == set(ACTIONS), "each action is tried"


def test_a_piece_is_put_down_in_front_of_a_robot_but_within_the_field(match):
    match.control.do("spawn", {"kind": "Ball", "robot": 0})
    match.tick()
    assert match.control.results[-1].text == "1 Ball put down at (3.20, 2.00) m"
    match.control.place_robot((15.0, 4.0, 0.0))
    match.control.do("spawn", {"kind": "Ball", "robot": 0})
    match.tick()
    assert match.control.results[-1].is_done and match.count.on_field == 2
    assert 15.5 < match.pieces.state.pos[1, 0] < 16.0
