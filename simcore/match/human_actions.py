"""Human players: stocks of pieces, and actions that the game's policy or a user starts.

A game defines the actions. The game's policy performs an action with `take`. If a person controls the human player,
`FieldControl` performs the actions that the person has requested instead. Limits, times and errors are the same in both
cases.
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
    """Match interface that `Feeder` uses."""

    pieces: GamePieceManager
    record: RunRecord
    time: float
    rules_rng: np.random.Generator


class Feeder:
    """Stock of pieces of one human player, and times at which the human player last put pieces on the field.

    Args:
        match: Match that receives the pieces.
        slots: Slots of the pieces in the stock at the start, next piece first; all pieces are off the field.
        clumsiness: Factor on the periods between pieces and on the errors of throws [-].
        rng: Random generator for errors; None for the generator of the match's rules.
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
        """Number of pieces in the stock; pieces that other commands have put on the field leave the stock."""
        status = self._match.pieces.state.status[self._slots].tolist() if self._slots else []
        self._slots[:] = [slot for slot, now in zip(self._slots, status, strict=True) if now == _STAGED]
        return len(self._slots)

    def keep(self, slot: int) -> None:
        """Set a scored piece aside, off the field, and add the piece to the end of the stock."""
        self._match.pieces.set_aside(np.array([slot]))
        self._slots.append(slot)

    def take_off(self, slots: Iterable[int]) -> None:
        """Remove pieces from the field and add the pieces to the end of the stock."""
        for slot in slots:
            self._match.pieces.score(np.array([slot]))
            self.keep(slot)

    def is_due(self, period: float, hand: str = "") -> bool:
        """Return whether a period has passed since a hand last put a piece on the field.

        Args:
            period: Period between pieces, before multiplication with the clumsiness [s].
            hand: Name of the hand or action for which times are kept separately; empty for any piece of `put`.
        """
        since = self._match.time - self._last.get(hand, -math.inf)
        return since >= self.clumsiness * period - 0.5 * TICK

    def errors(self, count: int) -> FloatArray:
        """Draw normally distributed errors with the clumsiness as standard deviation [-], shape (count,)."""
        drawn: FloatArray = self.clumsiness * self._rng.standard_normal(count)
        return drawn

    def note(self, hand: str) -> None:
        """Record the current time as the time of a hand's last piece, for `is_due`."""
        self._last[hand] = self._match.time

    def put(self, place: FloatArray, attitude: FloatArray | None = None, velocity: FloatArray | None = None) -> int:
        """Remove the next piece from the stock, put the piece on the field and return the slot of the piece.

        Args:
            place: Center of the piece, field frame [m], shape (3,).
            attitude: Attitude of the piece, unit quaternion x, y, z, w, shape (4,); None for an upright piece.
            velocity: Velocity of a thrown piece, field frame [m/s], shape (3,); None for a piece at rest.
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
        """Throw the next piece of the stock with random errors, record the throw and return the slot of the piece.

        Args:
            start: Position where the piece leaves the hand, field frame [m].
            target: Point through which the falling piece passes without errors, field frame [m].
            elevation: Launch angle above the horizontal [rad].
            error: Standard deviation of the direction [rad] and of the relative speed error [-], before multiplication
                with the clumsiness.
            flip: Symmetry that flips the throw to the other alliance's side of the field; None for no flip.
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
    """Action with which a human player puts the next piece on the field, for both alliances."""

    name: str
    """Name of the action in NetworkTables, e.g. `OpenDoor`."""
    summary: str
    """Text on the action's button."""
    feeders: Mapping[Alliance, Feeder]
    """Stock of each alliance's human player, by alliance."""
    act: Callable[[Alliance], object]
    """Function that puts the next piece on the field, called with the alliance."""
    period: float
    """Time between two pieces, before multiplication with the clumsiness [s]."""
    lasts: float = 0.0
    """Time for which the action is repeated after one request of a person [s]; 0 for a single piece."""
    modes: tuple[Mode, ...] = ("auto", "teleop")
    """Modes in which the game allows the action."""

    def __post_init__(self) -> None:
        require_fields(self, f"HumanAction {self.name!r}", period=DURATION, lasts=DELAY)

    def refusal(self, timer: MatchTimer, alliance: Alliance) -> str:
        """Return the reason why the action is impossible now, or an empty string; ignore the period between pieces."""
        if not self.feeders[alliance].stock:
            return "no piece is left for it"
        if not timer.is_enabled:
            return "human players wait until robots are enabled"
        if timer.phase.mode not in self.modes:
            return f"the rules allow it in {' and '.join(self.modes)}, now it is {timer.phase.name}"
        return ""

    def is_ready(self, timer: MatchTimer, alliance: Alliance) -> bool:
        """Return whether the action is possible and the period since the alliance's last such action has passed."""
        return self.feeders[alliance].is_due(self.period, self.name) and not self.refusal(timer, alliance)

    def take(self, timer: MatchTimer, alliance: Alliance) -> bool:
        """Perform the action and record the time if the action is ready; return whether the action was performed."""
        if not self.is_ready(timer, alliance):
            return False
        self.act(alliance)
        self.feeders[alliance].note(self.name)
        return True
