"""Driving from a page: conversion of pressed keys, gamepads and on-screen sticks to the input of a driver."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

from simcore.errors import ConfigError
from simcore.match.players.driven_robot import DriverInput
from simcore.quantities import shown

__all__ = ["KEYS", "ViewDriving", "read_input"]

_PATIENCE = 0.25  # [s]; after this time without a message, the robot has no driver
_DEAD_BAND = 0.1  # fraction of full deflection that counts as a stick at rest
_KEY_TURN, _SLOWLY = 0.5, 0.35  # fractions of full speed for the turn keys, and for all keys with Shift
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
"""Codes of the keys for driving, as in `KeyboardEvent.code`.

A code is a position on the keyboard: W A S D are the keys Z Q S D on a French keyboard.
"""
# Buttons of a gamepad with the W3C standard mapping: A, B, X and Y; bumper and trigger of each hand.
_FACES, _LEFT_HAND, _RIGHT_HAND = (0, 1, 2, 3), (4, 6), (5, 7)
_PRESSED = 0.5  # fraction of full travel from which a button or trigger counts as pressed


def read_input(message: object) -> tuple[int, DriverInput]:
    """Convert a page's message to the number of the driven robot and the driver's input.

    Args:
        message: Object with the codes of the pressed keys as `keys`. A page with a gamepad or on-screen sticks adds
            `axes` and `buttons`, both from -1 to 1. The number of the driven robot is `robot`, by default 0.

    Raises:
        ConfigError: If the message is invalid.

    >>> read_input({"keys": ["KeyW", "ShiftLeft"]})[1].ahead
    0.35
    >>> read_input({"keys": [], "axes": [0.0, -1.0, 0.05, 0.0], "buttons": []})[1].ahead
    1.0
    """
    if not isinstance(message, dict) or not {"keys"} <= message.keys() <= {"keys", "axes", "buttons", "robot"}:
        raise ConfigError(
            f"driving: a message must have keys, and may have axes, buttons and robot, got {shown(message)}"
        )
    robot = message.get("robot", 0)
    if type(robot) is not int:
        raise ConfigError(f"driving: robot must be a number, got {shown(robot)}")
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
    return robot, DriverInput(
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
    """Apply a radial deadband to the axes of a stick, and scale the deflection beyond the deadband to 0 to 1."""
    size = math.hypot(*stick)
    share = max(0.0, min(1.0, size) - _DEAD_BAND) / (1.0 - _DEAD_BAND) / max(size, 1e-9)
    return tuple(share * value for value in stick)


class ViewDriving:
    """Current input of the drivers at the pages, from at most one page per robot.

    Args:
        actions: Names of the robots' actions, in the order of the buttons.
        robots: Number of robots that can be driven.
        at_once: Whether a page starts driving as soon as the page is open.
        is_free: Whether a person drives without a match. The page then shows no clock, and the camera follows the
            robot.
        clock: Function that returns a monotonic time [s].
    """

    def __init__(
        self,
        actions: Sequence[str] = (),
        *,
        robots: int = 1,
        at_once: bool = False,
        is_free: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._clock, self._robots = clock, robots
        self._drivers: dict[int, tuple[int, float, DriverInput]] = {}  # by robot: page, time and input
        words = ["W A S D or arrows drive", "Q E turn", "Shift slowly", "F intake"]
        words += [f"{number}{' or Space' if number == 1 else ''} {name}" for number, name in enumerate(actions, 1)]
        self.data = {
            "robots": list(range(robots)), "at_once": at_once, "keys": sorted(KEYS), "actions": list(actions),
            "free": is_free, "help": ", ".join(words),
        }  # fmt: skip
        """Settings for driving that the view sends to the pages."""

    def input(self, robot: int = 0) -> DriverInput | None:
        """Return the current input for a robot; None without a message from a driver in the last 0.25 s."""
        _, at, wants = self._drivers.get(robot, (0, -math.inf, None))
        return None if self._clock() > at + _PATIENCE else wants

    def take(self, page: int, message: object) -> None:
        """Store the input of a page for a robot, unless another page drives the robot.

        A message of None ends driving by the page.

        Raises:
            ConfigError: If the message is invalid.
        """
        if message is None:
            self._drivers = {robot: entry for robot, entry in self._drivers.items() if entry[0] != page}
            return
        robot, wants = read_input(message)
        if robot not in range(self._robots):
            raise ConfigError(f"driving: robot must be 0 to {self._robots - 1}, got {shown(robot)}")
        if self.input(robot) is None or self._drivers[robot][0] == page:
            self._drivers[robot] = page, self._clock(), wants
