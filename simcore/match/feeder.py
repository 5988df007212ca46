"""Pieces in the hands of a human player: what they have, how fast they put it on the field, how well they throw."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from simcore.pieces.pool import PieceStatus
from simcore.pieces.shot_solver import solve_shot
from simcore.typing import FloatArray
from simcore.units import TICK

if TYPE_CHECKING:
    from simcore.geometry.rotation import Vector
    from simcore.match.game import PlayedMatch

__all__ = ["Feeder"]

_STAGED = int(PieceStatus.STAGED)


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
        match: PlayedMatch,
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
        status = self._match.pieces.state.status
        self._slots[:] = [slot for slot in self._slots if status[slot] == _STAGED]
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

    def throw(self, start: Vector, target: Vector, *, elevation: float, error: float, flipped: bool) -> int:
        """Throw the next piece, as well as people do; returns its slot.

        Args:
            start: Where it leaves the hand, field frame [m].
            target: To fall through [m].
            elevation: Over the horizontal [rad].
            error: Standard deviation of the direction [rad], and of the speed as a share of it.
            flipped: Whether places are those of the other alliance.
        """
        air = self._match.pieces.air_of(self._slots[0])
        shot = solve_shot(start, target, elevation=elevation, drag=air.drag)
        turn, more = (error * self.errors(2)).tolist()
        yaw, speed = shot.yaw + turn, shot.speed * (1.0 + more)
        level = speed * math.cos(elevation)
        pos = np.array([start])
        vel = np.array([[level * math.cos(yaw), level * math.sin(yaw), speed * math.sin(elevation)]])
        if flipped:
            symmetry = self._match.game.field.symmetry
            pos, vel = symmetry.flip_points(pos), symmetry.flip_vectors(vel)
        return self.put(pos[0], velocity=vel[0])
