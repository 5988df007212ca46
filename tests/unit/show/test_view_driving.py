"""What keys and gamepads ask for, which messages are refused, and how soon a page that is gone drives no more."""

from __future__ import annotations

import asyncio
import json
import math
from types import SimpleNamespace

import pytest
from simcore.show.view_guard import ViewGuard

from simcore.errors import ConfigError
from simcore.show.view_driving import KEYS, LONGEST, SUBPROTOCOL, ViewDriving, read_input


def asked(*keys, **pad):
    return read_input(json.dumps({"keys": keys, **pad}))


def pad(x=0.0, y=0.0, turn=0.0, pressed=()):
    return {"axes": [x, y, turn, 0.0], "buttons": [1.0 * (number in pressed) for number in range(17)]}


@pytest.mark.parametrize(
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
def test_keys(keys, ahead, left, turn):
    wants = asked(*keys)
    assert (wants.ahead, wants.left, wants.turn) == pytest.approx((ahead, left, turn))
    assert not wants.intake and wants.action is None and wants.device == "keyboard"


def test_buttons_are_the_same_on_keyboard_and_gamepad():
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


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        (b'{"keys": []}', "must be text"),
        ("x" * (LONGEST + 1), "at most 1000 characters"),
        ("KeyW", "must be JSON"),
        ("[" * 999, "must be JSON"),
        ("[]", "must have keys"),
        ("{}", "must have keys"),
        ('{"keys": [], "robot": 3}', "must have keys"),
        ('{"keys": "KeyW"}', "keys must be some of"),
        ('{"keys": ["KeyP"]}', "keys must be some of"),
        ('{"keys": [["KeyW"]]}', "keys must be some of"),
        ('{"keys": [], "axes": [NaN]}', "axes must be at most 32 numbers from -1 to 1"),
        ('{"keys": [], "axes": [Infinity]}', "axes must be"),
        ('{"keys": [], "axes": [1e300]}', "axes must be"),
        ('{"keys": [], "axes": [true]}', "axes must be"),
        ('{"keys": [], "axes": ["1"]}', "axes must be"),
        ('{"keys": [], "buttons": {}}', "buttons must be"),
        (json.dumps({"keys": [], "buttons": [0] * 33}), "buttons must be"),
    ],
)
def test_nonsense_is_refused(message, problem):
    with pytest.raises(ConfigError, match=problem):
        read_input(message)


class Socket:
    """A page that sends what a test gives it."""

    def __init__(self):
        self.messages, self.closed = asyncio.Queue(), None

    async def recv(self):
        return await self.messages.get()

    async def close(self, code, reason):
        self.closed = (code, reason)


def test_nobody_drives_a_quarter_of_a_second_after_the_last_message():
    pytest.importorskip("websockets", reason="the extra 'view' is not installed")
    now = 10.0

    async def heard(page):
        while not page.messages.empty():
            await asyncio.sleep(0.01)
        await asyncio.sleep(0.05)

    async def play():
        nonlocal now
        driving, page, other = ViewDriving(clock=lambda: now), Socket(), Socket()
        assert driving.input() is None
        listening = asyncio.create_task(driving.serve(page))
        page.messages.put_nowait('{"keys": ["KeyW"]}')
        await heard(page)
        assert driving.input().ahead == 1.0
        now = 10.249
        assert driving.input().ahead == 1.0
        now = 10.251
        assert driving.input() is None
        await driving.serve(other)
        assert other.closed == (1013, "another page drives") and page.closed is None
        now = 20.0
        page.messages.put_nowait('{"keys": ["KeyA"]}')
        await heard(page)
        assert driving.input().left == 1.0
        page.messages.put_nowait('{"keys": ["KeyA"], "axes": [NaN]}')
        await listening
        assert driving.input() is None, "at once"
        code, reason = page.closed
        assert code == 1007 and "axes must be" in reason and len(reason) <= 120
        again = asyncio.create_task(driving.serve(Socket()))
        await asyncio.sleep(0.01)
        assert not again.done(), "the place is free"
        again.cancel()

    asyncio.run(play())


def test_the_script_knows_the_keys_and_the_actions():
    driving, body = ViewDriving(("shoot", "</script>")), b"<html><body>x</body></html>"
    answer = SimpleNamespace(headers={"Content-Type": "text/html; charset=utf-8", "Content-Length": "27"}, body=body)
    guard = ViewGuard("127.0.0.1", driving)
    guard.add_scripts(answer)
    page = answer.body.decode()
    assert answer.headers["Content-Length"] == str(len(answer.body))
    picture = SimpleNamespace(headers={"Content-Type": "image/png"}, body=b"</body>")
    guard.add_scripts(picture)
    assert picture.body == b"</body>"
    assert page.startswith("<html><body>x<script>") and page.endswith("</script></body></html>")
    assert all(f'"{key}"' in page for key in KEYS) and SUBPROTOCOL in page and "$" not in page.replace("${", "")
    assert "1 or Space shoot, 2 <\\/script>" in page and page.count("</script>") == page.count("<script>") == 3
