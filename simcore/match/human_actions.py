"""Human players: the pieces that they hold and what they do with them, by a game's policy or at a person's request.

A game lists its actions. Its policy decides when to `take` one; where a person plays, `FieldControl` does what the
person has requested. Both use the same action, so limits, times and errors are equal.
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
    """Parts of a match that human players use."""

    pieces: GamePieceManager
    record: RunRecord
    time: float
    rules_rng: np.random.Generator


class Feeder:
    """Pieces of one human player, oldest first, with the time of each hand's last piece.

    Args:
        match: Match that it feeds.
        slots: Pieces at the start; they wait off the field.
        clumsiness: Factor on times and errors [-].
        rng: Generator for random errors; None: that of the match's rules.
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
        """Number of pieces left; pieces that another command has put on the field are not counted."""
        status = self._match.pieces.state.status[self._slots].tolist() if self._slots else []
        self._slots[:] = [slot for slot, now in zip(self._slots, status, strict=True) if now == _STAGED]
        return len(self._slots)

    def keep(self, slot: int) -> None:
        """Take in a piece that has scored."""
        self._match.pieces.set_aside(np.array([slot]))
        self._slots.append(slot)

    def take_off(self, slots: Iterable[int]) -> None:
        """Take pieces within reach off the field."""
        for slot in slots:
            self._match.pieces.score(np.array([slot]))
            self.keep(slot)

    def is_due(self, period: float, hand: str = "") -> bool:
        """Return whether a hand has had the time that it needs between two pieces [s]."""
        since = self._match.time - self._last.get(hand, -math.inf)
        return since >= self.clumsiness * period - 0.5 * TICK

    def errors(self, count: int) -> FloatArray:
        """Draw standard normal numbers times the clumsiness, shape (count,)."""
        drawn: FloatArray = self.clumsiness * self._rng.standard_normal(count)
        return drawn

    def note(self, hand: str) -> None:
        """Record that a hand puts a piece on the field now."""
        self._last[hand] = self._match.time

    def put(self, place: FloatArray, attitude: FloatArray | None = None, velocity: FloatArray | None = None) -> int:
        """Put the next piece on the field and return its slot.

        Args:
            place: Center of the piece, field frame [m], shape (3,).
            attitude: Unit quaternion x, y, z, w; None: upright.
            velocity: Velocity of a thrown piece, field frame [m/s], shape (3,); None: at rest.
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
        """Throw the next piece with a person's errors and return its slot.

        Args:
            start: Place where it leaves the hand, field frame [m].
            target: Place through which it should fall [m].
            elevation: Elevation above the horizontal [rad].
            error: Standard deviation of the direction [rad], and of the speed as a fraction.
            flip: Symmetry that maps the places to the other alliance's side; None: they stay.
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
    """Action of either alliance's human player with the next piece."""

    name: str
    """Name in its topic, e.g. `OpenDoor`."""
    summary: str
    """Text of its button."""
    feeders: Mapping[Alliance, Feeder]
    """Holders of the pieces, by alliance."""
    act: Callable[[Alliance], object]
    """Function that puts the next piece on the field."""
    period: float
    """Time from one piece to the next [s]."""
    lasts: float = 0.0
    """Duration of repeating it, piece after piece, at one request of a person [s]; 0: one piece."""
    modes: tuple[Mode, ...] = ("auto", "teleop")
    """Modes in which the game allows it."""

    def __post_init__(self) -> None:
        require_fields(self, f"HumanAction {self.name!r}", period=DURATION, lasts=DELAY)

    def refusal(self, timer: MatchTimer, alliance: Alliance) -> str:
        """Return why it cannot be done now, apart from the pace of the hands; empty if it can."""
        if not self.feeders[alliance].stock:
            return "no piece is left for it"
        if not timer.is_enabled:
            return "human players wait until robots are enabled"
        if timer.phase.mode not in self.modes:
            return f"the rules allow it in {' and '.join(self.modes)}, now it is {timer.phase.name}"
        return ""

    def is_ready(self, timer: MatchTimer, alliance: Alliance) -> bool:
        """Return whether it can be done and the period since the last time is over."""
        return self.feeders[alliance].is_due(self.period, self.name) and not self.refusal(timer, alliance)

    def take(self, timer: MatchTimer, alliance: Alliance) -> bool:
        """Do it if it is ready, and return whether it was done."""
        if not self.is_ready(timer, alliance):
            return False
        self.act(alliance)
        self.feeders[alliance].note(self.name)
        return True
