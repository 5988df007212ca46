"""What human players can do with the pieces they have, by a game's own policy or because a person asks for it.

A game lists its actions. Its policy decides when to `take` one; where a person has taken over, `carry_out` does what
the person has asked for. Both go through the same action, so the same limits, times and errors hold.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from simcore.match.clock import MatchTimer, Mode
from simcore.match.scoring import Alliance
from simcore.quantities import DELAY, DURATION, require_fields

__all__ = ["Hands", "HumanAction"]


class Hands(Protocol):
    """Who has the pieces of a human player: a `simcore.match.feeder.Feeder`."""

    @property
    def stock(self) -> int:
        """How many pieces stand ready."""

    def is_due(self, period: float, hand: str = "") -> bool:
        """Whether a hand's last piece is at least a period [s] ago."""

    def note(self, hand: str) -> None:
        """A hand has put a piece on the field now."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HumanAction:
    """Something that the human player of either alliance does with the next piece."""

    name: str
    """As its topic has it, e.g. `OpenDoor`."""
    summary: str
    """As a button has it."""
    feeders: Mapping[Alliance, Hands]
    """Who has the pieces."""
    act: Callable[[Alliance], object]
    """Puts the next piece on the field."""
    period: float
    """From one piece to the next [s]."""
    lasts: float = 0.0
    """How long it goes on, piece after piece, once a person has asked for it [s]; 0: for one piece."""
    modes: tuple[Mode, ...] = ("auto", "teleop")
    """When the game allows it."""

    def __post_init__(self) -> None:
        require_fields(self, f"HumanAction {self.name!r}", period=DURATION, lasts=DELAY)

    def refusal(self, timer: MatchTimer, alliance: Alliance) -> str:
        """Why it cannot be done now, however fast the hands are; empty if it can."""
        if not self.feeders[alliance].stock:
            return "no piece is left for it"
        if not timer.is_enabled:
            return "human players wait until robots are enabled"
        if timer.phase.mode not in self.modes:
            return f"the rules allow it in {' and '.join(self.modes)}, now it is {timer.phase.name}"
        return ""

    def is_ready(self, timer: MatchTimer, alliance: Alliance) -> bool:
        """Whether it can be done, and the last time is long enough ago."""
        return self.feeders[alliance].is_due(self.period, self.name) and not self.refusal(timer, alliance)

    def take(self, timer: MatchTimer, alliance: Alliance) -> bool:
        """Do it, if it is ready; returns whether it was done."""
        if not self.is_ready(timer, alliance):
            return False
        self.act(alliance)
        self.feeders[alliance].note(self.name)
        return True
