"""Buttons of the page that act on the field of a run: a piece before the robot, all pieces back, the robot back."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from simcore.match.match import Match

if TYPE_CHECKING:
    import viser

__all__ = ["FieldButtons"]

_AHEAD = 1.2  # [m] from the middle of the robot to a new piece


class FieldButtons:
    """They give commands to the match's `control`, which carries them out before the next tick.

    Args:
        server: Whose page.
        robot: Number of the robot that is meant.
        order: Where on the page.
    """

    def __init__(self, server: viser.ViserServer, robot: Callable[[], int], *, order: float) -> None:
        self._match: Match | None = None
        self._robot = robot
        self.is_pressed = False
        """Whether a command was given; whoever acts on it takes this back."""
        with server.gui.add_folder("field", order=order, expand_by_default=False):
            self._kind = server.gui.add_dropdown("piece", ("",), visible=False)
            commands: dict[str, Callable[[Match], object]] = {
                "put a piece before the robot": self._spawn,
                "put all pieces back": lambda match: match.control.reset_field(),
                "put the robot at its start": lambda match: match.control.place_at_start(self._number(match)),
            }
            for label, command in commands.items():
                button = server.gui.add_button(label, color="gray")
                button.on_click(lambda _, command=command: self._press(command))

    def attach(self, match: Match) -> None:
        """Act on this match from now on."""
        self._match = match
        kinds = tuple(supply.kind.name for supply in match.game.pieces)
        self._kind.options = kinds or ("",)
        self._kind.visible = len(kinds) > 1

    @property
    def result(self) -> str:
        """What became of the last command, in one line; empty before the first."""
        results = () if self._match is None else self._match.control.results
        return f"{'' if results[-1].is_done else 'not done: '}{results[-1].text}" if results else ""

    def _press(self, command: Callable[[Match], object]) -> None:
        if self._match is not None:
            command(self._match)
            self.is_pressed = True

    def _number(self, match: Match) -> int:
        return min(self._robot(), len(match.robots) - 1)

    def _spawn(self, match: Match) -> None:
        x, y, yaw = match.robots[self._number(match)].chassis.pose
        length, width = match.game.field.size
        place = (x + _AHEAD * math.cos(yaw), y + _AHEAD * math.sin(yaw))
        match.control.spawn(self._kind.value, [(min(max(place[0], 0.0), length), min(max(place[1], 0.0), width))])
