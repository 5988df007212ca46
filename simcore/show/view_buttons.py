"""Buttons of the page that act on the field of a run: a piece before the robot, all pieces back, human players."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from simcore.match.human_actions import ALLIANCES
from simcore.match.match import Match

if TYPE_CHECKING:
    import viser

__all__ = ["FieldButtons"]

_AHEAD = 1.2  # [m] from the middle of the robot to a new piece
_KEYS = {"blue": "UIOP", "red": "HJKL"}
"""Of human players' actions, in the order of a game; those that drive a robot are on the left of the keyboard."""


class FieldButtons:
    """They give commands to the match's `control`, which carries them out before the next tick.

    Args:
        server: Whose page.
        robot: Number of the robot that is meant.
        order: Where on the page.
    """

    def __init__(self, server: viser.ViserServer, robot: Callable[[], int], *, order: float) -> None:
        self._match: Match | None = None
        self._server, self._robot, self._order = server, robot, order
        self._has_people = False
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
        if match.rules.human_actions() and not self._has_people:
            self._has_people = True
            self._add_people(match)

    @property
    def result(self) -> str:
        """What became of the last command, in one line; empty before the first."""
        results = () if self._match is None else self._match.control.results
        return f"{'' if results[-1].is_done else 'not done: '}{results[-1].text}" if results else ""

    def _add_people(self, match: Match) -> None:
        """Buttons and keys of what human players can do."""
        gui = self._server.gui
        with gui.add_folder("human players", order=self._order, expand_by_default=False):
            for alliance in ALLIANCES:
                for number, action in enumerate(match.rules.human_actions()):
                    key = _KEYS[alliance][number : number + 1] or None
                    label = f"{alliance}: {action.summary}"

                    def act(_: object, whose: str = alliance, name: str = action.name) -> None:
                        self._press(lambda match: match.control.human_action(whose, name))

                    gui.add_button(f"{label} ({key})" if key else label, color="gray").on_click(act)
                    gui.add_command(label, hotkey=key).on_trigger(act)

                def leave(_: object, whose: str = alliance) -> None:
                    self._press(lambda match: match.control.take_over(whose, by_person=False))

                gui.add_button(f"{alliance}: leave it to the game", color="gray").on_click(leave)

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
