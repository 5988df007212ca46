"""Which pieces robots let go: seen from outside, whatever held them, shot them or put them down."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.match.game import PlayedMatch
from simcore.pieces.pool import ON_FIELD

__all__ = ["PieceRelease", "Releases"]


@dataclass(frozen=True, slots=True)
class PieceRelease:
    """A piece that a robot has let go."""

    slot: int
    """The piece."""
    robot: int
    speed: float
    """Away from the robot along the carpet, in the tick in which it left [m/s]."""


class Releases:
    """Follows who holds what.

    Args:
        match: Of which.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        self._holders: dict[int, int] = {}

    def update(self) -> list[PieceRelease]:
        """Pieces that have come out of a robot and onto the field since the last call; call it once a tick."""
        match, state = self._match, self._match.pieces.state
        now = {slot: robot.number for robot in match.robots for slot in robot.held}
        found = []
        for slot, number in self._holders.items():
            if slot not in now and state.status[slot] in ON_FIELD:
                vx, vy, _ = match.robots[number].chassis.origin_velocity
                speed = math.hypot(state.vel[slot, 0] - vx, state.vel[slot, 1] - vy)
                found.append(PieceRelease(slot, number, speed))
        self._holders = now
        return found
