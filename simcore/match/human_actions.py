"""What human players can do with the pieces they have, by a game's own policy or because a person asks for it.

A game lists its actions. Its policy decides when to `take` one; where a person has taken over, `carry_out` does what
the person has asked for. Both go through the same action, so the same limits, times and errors hold.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.clock import Mode
from simcore.match.feeder import Feeder
from simcore.match.scoring import Alliance
from simcore.units import TICK

if TYPE_CHECKING:
    from simcore.match.game import PlayedMatch

__all__ = ["ALLIANCES", "HumanAction", "ask", "carry_out", "take_over"]

ALLIANCES: dict[str, Alliance] = {"blue": "blue", "red": "red"}


@dataclass(frozen=True, slots=True, kw_only=True)
class HumanAction:
    """Something that the human player of either alliance does with the next piece."""

    name: str
    """As its topic has it, e.g. `OpenDoor`."""
    summary: str
    """As a button has it."""
    feeders: Mapping[Alliance, Feeder]
    """Who has the pieces."""
    act: Callable[[Alliance], object]
    """Puts the next piece on the field."""
    period: float
    """From one piece to the next [s]."""
    lasts: float = 0.0
    """How long it goes on, piece after piece, once a person has asked for it [s]; 0: for one piece."""
    modes: tuple[Mode, ...] = ("auto", "teleop")
    """When the game allows it."""

    def refusal(self, match: PlayedMatch, alliance: Alliance) -> str:
        """Why it cannot be done now, however fast the hands are; empty if it can."""
        if not self.feeders[alliance].stock:
            return "no piece is left for it"
        if not match.timer.is_enabled:
            return "human players wait until robots are enabled"
        if match.timer.phase.mode not in self.modes:
            return f"the rules allow it in {' and '.join(self.modes)}, now it is {match.timer.phase.name}"
        return ""

    def take(self, match: PlayedMatch, alliance: Alliance) -> bool:
        """Do it, if that can be and the last time is long enough ago; returns whether it was done."""
        feeder = self.feeders[alliance]
        if not feeder.is_due(self.period, self.name) or self.refusal(match, alliance):
            return False
        self.act(alliance)
        feeder.note(self.name)
        return True


def ask(match: PlayedMatch, alliance: str, name: str) -> str:
    """Let a person, who plays that human player from now on, have something done; returns it in words.

    Raises:
        UnknownNameError: There is no such alliance or action.
        ConfigError: It cannot be done now; nothing has changed.
    """
    actions, whose = _actions(match, alliance)
    if name not in actions:
        raise UnknownNameError("action of a human player", name, actions)
    action = actions[name]
    why = action.refusal(match, whose)
    if not action.lasts and name in match.persons.get(whose, ()):
        why = why or f"the one before is still to come, one takes {action.period:g} s"
    if why:
        raise ConfigError(f"{whose}'s human player cannot {action.summary}: {why}")
    match.persons.setdefault(whose, {})[name] = match.time + action.lasts
    return f"{whose}'s human player: {action.summary}, {action.feeders[whose].stock} stood ready"


def take_over(match: PlayedMatch, alliance: str, by_person: bool) -> str:
    """Have a person or the game's policy play a human player; returns that in words, or raises as `ask` does."""
    _, whose = _actions(match, alliance)
    if by_person:
        match.persons.setdefault(whose, {})
    else:
        match.persons.pop(whose, None)
    return f"{'a person plays' if by_person else 'the game itself plays'} {whose}'s human player"


def carry_out(match: PlayedMatch) -> None:
    """Do what persons have asked for, as far as the hands are ready; once a tick."""
    for alliance, wanted in match.persons.items():
        actions, _ = _actions(match, alliance)
        for name, until in list(wanted.items()):
            is_done = actions[name].take(match, alliance)
            if actions[name].lasts:
                is_done = match.time > until - 0.5 * TICK
            if is_done or actions[name].refusal(match, alliance):
                del wanted[name]


def _actions(match: PlayedMatch, alliance: str) -> tuple[dict[str, HumanAction], Alliance]:
    actions = {action.name: action for action in match.rules.human_actions()}
    if not actions:
        raise ConfigError(f"this run of {match.game.name} has no human players; whole matches may have")
    if alliance not in ALLIANCES:
        raise UnknownNameError("alliance", alliance, ALLIANCES)
    return actions, ALLIANCES[alliance]
