"""A person drives a robot from the page: what its keys and gamepad say, by way of a script and a socket of our own.

The page has the script only where there is a robot to drive. The socket is under the same guard as the page itself.
"""

from __future__ import annotations

import asyncio
import json
import math
import time
from collections.abc import Callable, Sequence
from importlib.resources import files
from typing import Any

from simcore.errors import ConfigError
from simcore.players.driven_robot import DriverInput
from simcore.quantities import shown

__all__ = ["KEYS", "LONGEST", "SUBPROTOCOL", "ViewDriving", "read_input"]

SUBPROTOCOL = "simcore-driving"
"""Of the socket."""
LONGEST = 1000
"""Characters of a message at most."""
_PATIENCE = 0.25  # [s] without a message after which nobody drives
_SILENCE = 2.0  # [s] without a message after which a socket is closed
_DEAD_BAND = 0.1  # of a stick that was let go
_KEY_TURN, _SLOWLY = 0.5, 0.35  # shares of full speed: of the keys that turn, and of all keys with Shift
_AHEAD, _LEFT, _TURN = "ahead", "left", "turn"
_STICKS = {
    **dict.fromkeys(("KeyW", "ArrowUp"), (_AHEAD, 1.0)),
    **dict.fromkeys(("KeyS", "ArrowDown"), (_AHEAD, -1.0)),
    **dict.fromkeys(("KeyA", "ArrowLeft"), (_LEFT, 1.0)),
    **dict.fromkeys(("KeyD", "ArrowRight"), (_LEFT, -1.0)),
    "KeyQ": (_TURN, _KEY_TURN),
    "KeyE": (_TURN, -_KEY_TURN),
}
_INTAKE, _SHIFT = "KeyF", ("ShiftLeft", "ShiftRight")
_ACTIONS = {"Space": 0, "Digit1": 0, "Digit2": 1, "Digit3": 2, "Digit4": 3}
KEYS = frozenset((*_STICKS, _INTAKE, *_SHIFT, *_ACTIONS))
"""What counts, by `KeyboardEvent.code`: by place, so W A S D is Z Q S D on a French keyboard."""
# Buttons of a gamepad of the standard mapping (W3C): A, B, X and Y; bumper and trigger of each hand.
_FACES, _LEFT_HAND, _RIGHT_HAND = (0, 1, 2, 3), (4, 6), (5, 7)
_PRESSED = 0.5  # of a trigger


def read_input(text: str | bytes) -> DriverInput:
    """What a message of the page asks for.

    Args:
        text: JSON with `keys`, the codes of those that are down; with a gamepad also its `axes` and `buttons`, -1 to 1.

    Raises:
        ConfigError: It is no such message.

    >>> read_input('{"keys": ["KeyW", "ShiftLeft"]}').ahead
    0.35
    >>> read_input('{"keys": [], "axes": [0.0, -1.0, 0.05, 0.0], "buttons": []}').ahead
    1.0
    """
    if not isinstance(text, str) or len(text) > LONGEST:
        raise ConfigError(f"driving: a message must be text of at most {LONGEST} characters, got {shown(text[:40])}")
    try:
        message = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"driving: a message must be JSON, got {shown(text[:40])}") from error
    if not isinstance(message, dict) or not {"keys"} <= message.keys() <= {"keys", "axes", "buttons"}:
        raise ConfigError(f"driving: a message must have keys, and may have axes and buttons, got {shown(message)}")
    keys = message["keys"]
    if not isinstance(keys, list) or not all(isinstance(key, str) and key in KEYS for key in keys):
        raise ConfigError(f"driving: keys must be some of {', '.join(sorted(KEYS))}, got {shown(keys)}")
    has_pad = "axes" in message or "buttons" in message
    axes, buttons = (_numbers(name, message.get(name, [])) for name in ("axes", "buttons"))
    pressed = {number for number, value in enumerate(buttons) if value > _PRESSED}
    x, y, turn = (*axes, *[0.0] * 3)[:3]
    ahead, left = _beyond_dead_band(-y, -x)
    way = {_AHEAD: ahead, _LEFT: left, _TURN: _beyond_dead_band(-turn)[0]}
    share = _SLOWLY if not {*_SHIFT}.isdisjoint(keys) else 1.0
    for name, value in {_STICKS[key] for key in keys if key in _STICKS}:
        way[name] += share * value
    size = max(1.0, math.hypot(way[_AHEAD], way[_LEFT]))
    actions = [_ACTIONS[key] for key in keys if key in _ACTIONS] + [n for n in _FACES if n in pressed]
    actions += [] if pressed.isdisjoint(_RIGHT_HAND) else [0]
    return DriverInput(
        ahead=way[_AHEAD] / size,
        left=way[_LEFT] / size,
        turn=max(-1.0, min(1.0, way[_TURN])),
        intake=_INTAKE in keys or not pressed.isdisjoint(_LEFT_HAND),
        action=actions[0] if actions else None,
        device="keyboard and gamepad" if has_pad else "keyboard",
    )


def _numbers(name: str, values: object) -> list[float]:
    if isinstance(values, list) and len(values) <= 32:
        if all(type(value) in (int, float) and -1.0 <= value <= 1.0 for value in values):
            return [float(value) for value in values]
    raise ConfigError(f"driving: {name} must be at most 32 numbers from -1 to 1, got {shown(values)}")


def _beyond_dead_band(*stick: float) -> tuple[float, ...]:
    """A stick's way beyond its dead band, so that it begins at 0 there and is 1 at its end."""
    size = math.hypot(*stick)
    share = max(0.0, min(1.0, size) - _DEAD_BAND) / (1.0 - _DEAD_BAND) / max(size, 1e-9)
    return tuple(share * value for value in stick)


class ViewDriving:
    """The person at the page who drives; one page at a time.

    Args:
        actions: What people call the actions of the robot, in the order of their buttons.
        clock: Says the time [s].
    """

    def __init__(self, actions: Sequence[str] = (), *, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._driver: Any = None  # the socket of the page that drives
        self._latest: tuple[float, DriverInput] | None = None
        words = ["W A S D or arrows drive", "Q E turn", "Shift slowly", "F intake"]
        words += [f"{number}{' or Space' if number == 1 else ''} {name}" for number, name in enumerate(actions, 1)]
        script = files(__package__).joinpath("view_driving.js").read_text(encoding="utf-8")
        for name, value in (("KEYS", sorted(KEYS)), ("HELP", ", ".join(words)), ("SUBPROTOCOL", SUBPROTOCOL)):
            script = script.replace(f'"${name}"', json.dumps(value).replace("</", "<\\/"))
        self.script = script
        """Of the page."""

    def input(self) -> DriverInput | None:
        """What the person wants now; None while nobody drives, and when the last message is too old."""
        latest = self._latest
        return None if latest is None or self._clock() > latest[0] + _PATIENCE else latest[1]

    async def serve(self, socket: Any) -> None:
        """Listen to a page until it lets go, says nothing, or says nonsense."""
        from websockets.exceptions import ConnectionClosed

        if self._driver is not None:
            await socket.close(1013, "another page drives")
            return
        self._driver = socket
        try:
            while True:
                wants = read_input(await asyncio.wait_for(socket.recv(), _SILENCE))
                self._latest = self._clock(), wants
        except ConfigError as error:
            self._latest = None
            await socket.close(1007, str(error).encode("ascii", "replace")[:120].decode())
        except asyncio.TimeoutError:
            await socket.close(1008, "the page says nothing")
        except ConnectionClosed:
            pass
        finally:
            self._driver = self._latest = None
