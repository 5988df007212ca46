"""Pieces in placers that are driven into the field: they come out, as they would of a real claw.

A held piece is no body, nor is what holds it: robots go where their chassis can go. So the way of each held piece
through the field is looked along, and one that gets deeper into a static than claw and piece give comes loose where it
was last free, with the velocity of the claw; what becomes of it is the engine's business.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.geometry.linkage import PartState
from simcore.geometry.rotation import Quaternion, Vector, interpolate
from simcore.physics.world import PhysicsWorld
from simcore.pieces.piece_manager import GamePieceManager
from simcore.pieces.placer import Placer

__all__ = ["HeldContact"]

_LOOK = 0.015  # [m] of its way; the wall of a tube with a give of 10 mm is too deep in a pipe of 42 mm for 28 mm of it
_STANDS = 1e-4  # [m]; one that has moved less since it was looked at is as deep as it was
_CARRIED = 0.25  # [m] in a tick; at 12 m/s it is people who put the robot elsewhere


@dataclass(slots=True)
class _Way:
    """Of one held piece."""

    slot: int
    pos: Vector
    quat: Quaternion
    free: tuple[Vector, Quaternion] | None = None
    """Where it was last in nothing [m]; None: not yet since it was taken, as of a piece that lies in the field."""
    is_free: bool = False
    """Whether it is in nothing now."""


class HeldContact:
    """Follows the pieces in placers through the field.

    Args:
        world: What stands there.
        pieces: All of them.
    """

    def __init__(self, world: PhysicsWorld, pieces: GamePieceManager) -> None:
        self._world = world
        self._pieces = pieces
        self._ways: dict[Placer, _Way] = {}

    def forget(self, placer: Placer) -> None:
        """A placer's piece was let go."""
        self._ways.pop(placer, None)

    def is_free(self, placer: Placer) -> bool:
        """Whether a placer's piece, which has been followed in this tick, is in nothing and can be let go."""
        return self._ways[placer].is_free

    def follow(self, placer: Placer, slot: int, part: PartState) -> PartState | None:
        """Look along the way of a placer's piece since the last tick.

        Args:
            placer: What holds it.
            slot: Which piece.
            part: Its pose and motion, field frame.

        Returns:
            Pose and motion with which the piece comes loose; None: it stays.
        """
        way = self._ways.get(placer)
        reach = float(self._pieces.radius[slot])
        if way is None or way.slot != slot or math.dist(way.pos, part.pos) > _CARRIED:
            way = self._ways[placer] = _Way(slot, part.pos, part.quat)
            moved = _LOOK
        else:
            moved = math.dist(way.pos, part.pos) + reach * _angle(way.quat, part.quat)
        if moved < _STANDS:
            return None
        before, turned, way.pos, way.quat = way.pos, way.quat, part.pos, part.quat
        way.is_free = not self._is_near(part.pos, reach + moved)
        if way.is_free:
            way.free = part.pos, part.quat
            return None
        looks = math.ceil(moved / _LOOK)
        for number in range(1, looks + 1):
            share = number / looks
            x, y, z = (a + share * (b - a) for a, b in zip(before, part.pos, strict=True))
            quat = interpolate(turned, part.quat, share)
            depth = self._pieces.depth(slot, (x, y, z), quat)
            way.is_free = self._pieces.is_free(slot, depth)
            if way.is_free:
                way.free = (x, y, z), quat
            elif way.free is not None and depth > placer.config.give:
                return PartState(*way.free, part.vel, part.rate)
        return None

    def _is_near(self, pos: Vector, reach: float) -> bool:
        low, high = [c - reach for c in pos], [c + reach for c in pos]
        return pos[2] < reach or not self._world.is_free(low, high)


def _angle(a: Quaternion, b: Quaternion) -> float:
    """Between two attitudes, if it is small [rad]."""
    same = abs(math.fsum(p * q for p, q in zip(a, b, strict=True)))  # q and -q are the same attitude
    return 2.0 * math.sqrt(max(0.0, 2.0 - 2.0 * same))
