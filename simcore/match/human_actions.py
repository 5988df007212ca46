"""Human players: the pieces in their hands, and what they do with them, by a game's policy or because a person asks.

A game lists its actions. Its policy decides when to `take` one; where a person has taken over, `FieldControl` does what
the person has asked for. Both go through the same action, so the same limits, times and errors hold.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from simcore.match.clock import MatchTimer, Mode
from simcore.match.run_record import RunRecord
from simcore.match.scoring import Alliance
from simcore.pieces.piece_manager import GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.pieces.shot_solver import solve_shot
from simcore.quantities import DELAY, DURATION, require_fields
from simcore.typing import FloatArray
from simcore.units import TICK
from simcore.world.rotation import Vector
from simcore.world.symmetry import FieldSymmetry

__all__ = ["Feeder", "HumanAction"]

_STAGED = int(PieceStatus.STAGED)


class FedMatch(Protocol):
    """Match as those see it who feed pieces into it."""

    pieces: GamePieceManager
    record: RunRecord
    time: float
    rules_rng: np.random.Generator


class Feeder:
    """The pieces of one human player, oldest first, and when each hand put the last one on the field.

    Args:
        match: In which.
        slots: Pieces that they have at the start; they wait off the field.
        clumsiness: Factor of times and errors [-].
        rng: For what they leave to chance; None: that of the match's rules.
    """

    def __init__(
        self,
        match: FedMatch,
        slots: Iterable[int] = (),
        *,
        clumsiness: float = 1.0,
        rng: np.random.Generator | None = None,
    ) -> None:
        self._match = match
        self._rng = rng or match.rules_rng
        self._slots = list(slots)
        self.clumsiness = clumsiness
        self._last: dict[str, float] = {}

    @property
    def stock(self) -> int:
        """How many pieces they have; those that somebody else has put on the field meanwhile are not theirs."""
        status = self._match.pieces.state.status[self._slots].tolist() if self._slots else []
        self._slots[:] = [slot for slot, now in zip(self._slots, status, strict=True) if now == _STAGED]
        return len(self._slots)

    def keep(self, slot: int) -> None:
        """Take a piece that has scored."""
        self._match.pieces.set_aside(np.array([slot]))
        self._slots.append(slot)

    def take_off(self, slots: Iterable[int]) -> None:
        """Take pieces off the field that have come within reach."""
        for slot in slots:
            self._match.pieces.score(np.array([slot]))
            self.keep(slot)

    def is_due(self, period: float, hand: str = "") -> bool:
        """Whether a hand has had as long as it needs from one piece to the next [s]."""
        since = self._match.time - self._last.get(hand, -math.inf)
        return since >= self.clumsiness * period - 0.5 * TICK

    def errors(self, count: int) -> FloatArray:
        """Standard normal numbers times the clumsiness, shape (count,)."""
        drawn: FloatArray = self.clumsiness * self._rng.standard_normal(count)
        return drawn

    def note(self, hand: str) -> None:
        """A hand has put a piece on the field now."""
        self._last[hand] = self._match.time

    def put(self, place: FloatArray, attitude: FloatArray | None = None, velocity: FloatArray | None = None) -> int:
        """Put the next piece on the field; returns its slot.

        Args:
            place: Of its center, field frame [m], shape (3,).
            attitude: Unit quaternion x, y, z, w; None: upright.
            velocity: Of one that is thrown, field frame [m/s], shape (3,); None: it is at rest.
        """
        slot = np.array([self._slots.pop(0)])
        self._match.pieces.release(slot, place[None], None if attitude is None else attitude[None])
        if velocity is not None:
            self._match.pieces.push(slot, velocity[None], flying=True)
        self.note("")
        return int(slot[0])

    def throw(
        self, start: Vector, target: Vector, *, elevation: float, error: float, flip: FieldSymmetry | None
    ) -> int:
        """Throw the next piece, as well as people do; returns its slot.

        Args:
            start: Where it leaves the hand, field frame [m].
            target: To fall through [m].
            elevation: Over the horizontal [rad].
            error: Standard deviation of the direction [rad], and of the speed as a share of it.
            flip: Brings places to the other side, where they are those of the other alliance; None: they are not.
        """
        air = self._match.pieces.air_of(self._slots[0])
        shot = solve_shot(start, target, elevation=elevation, drag=air.drag)
        turn, more = (error * self.errors(2)).tolist()
        yaw, speed = shot.yaw + turn, shot.speed * (1.0 + more)
        level = speed * math.cos(elevation)
        pos = np.array([start])
        vel = np.array([[level * math.cos(yaw), level * math.sin(yaw), speed * math.sin(elevation)]])
        if flip is not None:
            pos, vel = flip.flip_points(pos), flip.flip_vectors(vel)
        slot = self.put(pos[0], velocity=vel[0])
        self._match.record.note_thrown(slot)
        return slot


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
