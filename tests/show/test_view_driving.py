"""Inputs from keys and gamepads, refused messages, and the time after which a lost page stops driving."""

import math

import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.show.view_driving import KEYS, ViewDriving, read_input


def asked(*keys, **pad):
    return read_input({"keys": list(keys), **pad})[1]


def pad(x=0.0, y=0.0, turn=0.0, pressed=()):
    return {"axes": [x, y, turn, 0.0], "buttons": [1.0 * (number in pressed) for number in range(17)]}


@each(
    ("keys", "ahead", "left", "turn"),
    [
        ((), 0.0, 0.0, 0.0),
        (("KeyW",), 1.0, 0.0, 0.0),
        (("ArrowUp", "KeyW"), 1.0, 0.0, 0.0),
        (("KeyW", "KeyS"), 0.0, 0.0, 0.0),
        (("ArrowDown",), -1.0, 0.0, 0.0),
        (("KeyA",), 0.0, 1.0, 0.0),
        (("ArrowRight", "KeyQ"), 0.0, -1.0, 0.5),
        (("KeyE",), 0.0, 0.0, -0.5),
        (("KeyW", "KeyD"), math.sqrt(0.5), -math.sqrt(0.5), 0.0),
        (("KeyS", "ShiftLeft"), -0.35, 0.0, 0.0),
    ],
)
def test_pressed_keys_command_velocities(keys, ahead, left, turn):
    wants = asked(*keys)
    assert (wants.ahead, wants.left, wants.turn) == pytest.approx((ahead, left, turn))
    assert not wants.intake and wants.action is None and wants.device == "keyboard"


def test_keys_and_gamepad_buttons_start_the_same_actions():
    assert asked("KeyF").intake and asked(**pad(pressed=[4])).intake and asked(**pad(pressed=[6])).intake
    for action, (key, button) in enumerate(zip(("Digit1", "Digit2", "Digit3", "Digit4"), range(4), strict=True)):
        assert asked(key).action == asked(**pad(pressed=[button])).action == action
    assert asked("Space").action == asked(**pad(pressed=[5])).action == asked(**pad(pressed=[7])).action == 0
    assert asked(axes=[0.0] * 4, buttons=[0.4] * 8).action is None, "a trigger that is pulled a little"
    assert asked(**pad()).device == "keyboard and gamepad"


def test_a_stick_has_a_round_dead_band_and_no_step_at_its_edge():
    assert asked(**pad(x=0.07, y=0.07, turn=-0.09)) == asked(**pad())
    assert asked(**pad(y=-0.1001)).ahead == pytest.approx(0.0, abs=1e-3)
    right = asked(**pad(x=1.0, y=-1.0, turn=1.0))
    assert (right.ahead, right.left, right.turn) == pytest.approx((math.sqrt(0.5), -math.sqrt(0.5), -1.0))
    assert asked(**pad(x=-0.55)).left == pytest.approx(0.5)
    both = asked("KeyW", "KeyQ", **pad(y=-1.0, turn=-1.0))
    assert both.ahead == 1.0 and both.turn == 1.0


@each(
    ("message", "problem"),
    [
        ([], "must have keys"),
        ({}, "must have keys"),
        ({"keys": [], "else": 3}, "must have keys"),
        ({"keys": "KeyW"}, "keys must be some of"),
        ({"keys": ["KeyP"]}, "keys must be some of"),
        ({"keys": [["KeyW"]]}, "keys must be some of"),
        ({"keys": [], "axes": [math.nan]}, "axes must be at most 32 numbers from -1 to 1"),
        ({"keys": [], "axes": [math.inf]}, "axes must be"),
        ({"keys": [], "axes": [1e300]}, "axes must be"),
        ({"keys": [], "axes": [True]}, "axes must be"),
        ({"keys": [], "axes": ["1"]}, "axes must be"),
        ({"keys": [], "buttons": {}}, "buttons must be"),
        ({"keys": [], "buttons": [0] * 33}, "buttons must be"),
    ],
)
def test_invalid_messages_are_refused(message, problem):
    with pytest.raises(ConfigError, match=problem):
        read_input(message)


def test_driving_ends_a_quarter_of_a_second_after_the_last_message():
    now = 10.0
    driving = ViewDriving(clock=lambda: now)
    assert driving.input() is None
    driving.take(1, {"keys": ["KeyW"]})
    assert driving.input().ahead == 1.0
    now = 10.249
    assert driving.input().ahead == 1.0
    driving.take(2, {"keys": ["KeyS"]})
    assert driving.input().ahead == 1.0, "another page drives"
    now = 10.251
    assert driving.input() is None
    driving.take(2, {"keys": ["KeyS"]})
    driving.take(1, None)
    assert driving.input().ahead == -1.0, "the place was free"
    driving.take(2, None)
    assert driving.input() is None, "at once"


def test_each_page_drives_its_own_robot():
    driving = ViewDriving(("shoot",), robots=2, at_once=True, clock=lambda: 0.0)
    driving.take(1, {"keys": ["KeyW"]})
    driving.take(2, {"keys": ["KeyS"], "robot": 1})
    assert (driving.input(0).ahead, driving.input(1).ahead) == (1.0, -1.0)
    for wrong in (2, -1, True, "0"):
        with pytest.raises(ConfigError, match="robot must be"):
            driving.take(1, {"keys": [], "robot": wrong})
    assert driving.data["robots"] == [0, 1] and driving.data["at_once"] and set(driving.data["keys"]) == KEYS
    assert "1 or Space shoot" in driving.data["help"]
