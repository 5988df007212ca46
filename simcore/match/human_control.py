"""A person in the place of a human player: what they ask for is done as soon as hands are ready."""

from __future__ import annotations

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.game import PlayedMatch
from simcore.match.human_actions import HumanAction
from simcore.match.scoring import Alliance
from simcore.quantities import shown
from simcore.units import TICK

__all__ = ["ALLIANCES", "ask", "carry_out", "take_over"]

ALLIANCES: dict[str, Alliance] = {"blue": "blue", "red": "red"}


def ask(match: PlayedMatch, alliance: str, name: str) -> str:
    """Let a person, who plays that human player from now on, have something done; returns it in words.

    Raises:
        UnknownNameError: There is no such alliance or action.
        ConfigError: It cannot be done now; nothing has changed.
    """
    actions, whose = _actions(match, alliance)
    if name not in [*actions]:
        raise UnknownNameError("action of a human player", name, actions)
    action = actions[name]
    why = action.refusal(match.timer, whose)
    if not action.lasts and name in match.persons.get(whose, ()):
        why = why or f"the one before is still to come, one takes {action.period:g} s"
    if why:
        raise ConfigError(f"{whose}'s human player cannot {action.summary}: {why}")
    match.persons.setdefault(whose, {})[name] = match.time + action.lasts
    return f"{whose}'s human player: {action.summary}, {action.feeders[whose].stock} stood ready"


def take_over(match: PlayedMatch, alliance: str, by_person: bool) -> str:
    """Have a person or the game's policy play a human player; returns that in words, or raises as `ask` does."""
    _, whose = _actions(match, alliance)
    if not isinstance(by_person, bool):
        raise ConfigError(f"by_person must be True or False, got {shown(by_person)}")
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
            is_done = actions[name].take(match.timer, alliance)
            if actions[name].lasts:
                is_done = match.time > until - 0.5 * TICK
            if is_done or actions[name].refusal(match.timer, alliance):
                del wanted[name]


def _actions(match: PlayedMatch, alliance: str) -> tuple[dict[str, HumanAction], Alliance]:
    actions = {action.name: action for action in match.rules.human_actions()}
    if not actions:
        raise ConfigError(f"this run of {match.game.name} has no human players; whole matches may have")
    if alliance not in [*ALLIANCES]:
        raise UnknownNameError("alliance", alliance, ALLIANCES)
    return actions, ALLIANCES[alliance]
