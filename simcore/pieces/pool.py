"""State of all game pieces, allocated once, and engine bodies for pieces that are not balls.

The loop moves balls (`simcore.loop.balls`). Other pieces are bodies of the engine. Pieces in robots, scored pieces and
pieces that are not yet on the field are parked and do not move.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from simcore.errors import CapacityError, ConfigError, NonFiniteError
from simcore.loop.state import JUST_PUT, make_balls
from simcore.pieces.aerodynamics import AirFactors
from simcore.pieces.kinds import GamePieceConfig, PieceVariation
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.world.rotation import IDENTITY, Quaternion
from simcore.world.shapes import Sphere
from simcore.world.world import PhysicsWorld

__all__ = ["ON_FIELD", "PiecePool", "PieceState", "PieceStatus", "ShownPieces"]

_PARKING_HEIGHT = 50.0  # [m], above everything; spaced by 1 m, as pieces parked on one spot take seconds per step


class PieceStatus(IntEnum):
    """Status of a game piece."""

    FREE = 0
    """Slot without a piece in the match."""
    STAGED = 1
    """In the match but not on the field, for example in an outpost's chute."""
    ASLEEP = 2
    """On the field, at rest and frozen."""
    AWAKE = 3
    """On the field and free to move."""
    HELD = 4
    """Held by a robot."""
    IN_FLIGHT = 5
    """In the air without contact."""
    SCORED = 6
    """Scored and removed from the field."""
    PLACED = 7
    """At rest and frozen in a resting place, where the piece counts."""


ON_FIELD = (PieceStatus.ASLEEP, PieceStatus.AWAKE, PieceStatus.IN_FLIGHT, PieceStatus.PLACED)
"""Statuses of pieces on the field or in the air."""
_IS_ON_FIELD: BoolArray = np.isin([int(status) for status in PieceStatus], ON_FIELD)
"""Whether pieces with each status are on the field or in the air, indexed by status."""
_IS_FROZEN: BoolArray = np.isin([int(status) for status in PieceStatus], (PieceStatus.ASLEEP, PieceStatus.PLACED))
"""Whether pieces with each status are at rest and frozen, indexed by status."""


@dataclass(slots=True)
class PieceState:
    """State of all pieces, one row per slot; `n` is the capacity of the pool."""

    pos: FloatArray
    """Center, field frame [m], shape (n, 3); the last position on the field for parked pieces."""
    before: FloatArray
    """Center at the start of the tick, field frame [m], shape (n, 3)."""
    vel: FloatArray
    """Velocity, field frame [m/s], shape (n, 3); the mean over the last tick for pieces that are not balls."""
    status: npt.NDArray[np.uint8]
    """`PieceStatus` of each slot, shape (n,)."""
    kind: npt.NDArray[np.uint8]
    """Index of the kind of each slot's piece, shape (n,)."""
    holder: IntArray
    """Number of the robot that holds each piece, -1 for a piece that no robot holds, shape (n,)."""


class PiecePool:
    """State and bodies of all pieces of a world; slots of the same kind are contiguous."""

    def __init__(
        self,
        world: PhysicsWorld,
        types: list[tuple[GamePieceConfig, int]],
        variation: PieceVariation | None = None,
    ) -> None:
        """Allocate the state of all pieces, and create the bodies of pieces that are not balls.

        Args:
            world: World that contains the pieces.
            types: Kinds of pieces, each with the largest number of pieces of the kind.
            variation: Variation of single pieces; None for pieces without variation.
        """
        self._world = world
        self.types = [config for config, _ in types]
        n = sum([count for _, count in types])
        self.state = PieceState(
            pos=np.zeros((n, 3)),
            before=np.zeros((n, 3)),
            vel=np.zeros((n, 3)),
            status=np.zeros(n, dtype=np.uint8),
            kind=np.zeros(n, dtype=np.uint8),
            holder=np.full(n, -1, dtype=np.int64),
        )
        self.rows: list[int] = []
        """Engine row of each slot, -1 for a ball."""
        self.changes = 0
        """Counter of changes, which increases when a piece may have been added, removed or moved."""
        self.size = np.ones(n) if variation is None else variation.diameter
        """Ratio of each piece's diameter to the diameter of the kind, by slot [-], shape (n,)."""
        self.balls = make_balls(self.state.status, self.state.pos, self.state.vel)
        """Arrays for the loop, one row per slot; the loop skips rows of pieces that are not balls."""
        self.radius, self.mass = self.balls.radius, self.balls.mass
        """Bounding radius [m] and mass [kg] of each slot's piece, shape (n,)."""
        self.drag = self.balls.air[:, 0]
        """Drag factor of each slot's piece [1/m], shape (n,); see `AirFactors`."""
        slot = 0
        for kind, (config, count) in enumerate(types):
            mine, balls = slice(slot, slot + count), self.balls
            self.state.kind[mine] = kind
            balls.is_ball[mine] = is_ball = isinstance(config.shape, Sphere)
            balls.radius[mine], balls.mass[mine] = config.bounding_radius, config.mass
            balls.foam[mine], balls.surface[mine] = config.foam, (config.friction, config.restitution, config.rolling)
            balls.air[mine] = config.air
            if variation is not None:
                balls.mass[mine] *= variation.mass[mine]
                balls.air[mine, 0] *= variation.drag[mine] * variation.diameter[mine] ** 2 / variation.mass[mine]
                balls.air[mine, 1] *= variation.diameter[mine] ** 3 / variation.mass[mine]
                balls.surface[mine, 1] = np.minimum(1.0, config.restitution * variation.restitution[mine])
            if is_ball:
                self.rows += [-1] * count
            else:
                self._make_bodies(slot, config, balls.surface[mine, 1])
            slot += count
        self.is_ball = self.balls.is_ball.astype(bool)
        """Whether the piece of each slot is a ball, shape (n,)."""
        world.balls.set_balls(self.balls)

    def _make_bodies(self, slot: int, config: GamePieceConfig, restitution: FloatArray) -> None:
        for number, bounce in enumerate(restitution.tolist()):
            row = self._world.add_piece_body(
                config.name,
                config.shape,
                mass=float(self.mass[slot + number]),
                surface=replace(config.surface, restitution=bounce),
                pos=self._parking(slot + number),
            )
            self._world.set_piece_touchable(row, False)
            self._world.engine.fix(row)
            self.rows.append(row)

    @property
    def is_on_field(self) -> BoolArray:
        """Whether the piece of each slot is on the field or in the air, shape (n,)."""
        here: BoolArray = _IS_ON_FIELD.take(self.state.status)  # takes 1.3 us; three comparisons take 4 us
        return here

    @property
    def is_frozen(self) -> BoolArray:
        """Whether the piece of each slot is asleep or placed, shape (n,)."""
        frozen: BoolArray = _IS_FROZEN.take(self.state.status)
        return frozen

    def air_of(self, slot: int) -> AirFactors:
        """Return the aerodynamic factors of the piece in a slot."""
        drag, lift, saturation, spin_drag = self.balls.air[slot].tolist()
        return AirFactors(drag, lift, saturation, spin_drag)

    def take(self, kind: int, count: int) -> IntArray:
        """Return free slots of a kind; the caller must set the status.

        Raises:
            CapacityError: If too few slots are free.
            ConfigError: If the count is negative.
        """
        if count < 0:
            raise ConfigError(f"{self.types[kind].name}: number of pieces must be >= 0, got {count}")
        free = np.nonzero((self.state.kind == kind) & (self.state.status == PieceStatus.FREE))[0]
        if len(free) < count:
            have = int((self.state.kind == kind).sum())
            raise CapacityError(
                f"{self.types[kind].name}: {count} more wanted, but {have - len(free)} of {have} are in play; for "
                f"more, raise the number in the game's PieceSupply({self.types[kind].name.upper()}, {have})"
            )
        return free[:count]

    def place(self, slot: int, pos: tuple[float, float, float], quat: Quaternion = IDENTITY) -> None:
        """Place a piece at rest at a pose on the field; the caller sets the status.

        Raises:
            NonFiniteError: If a value is NaN or infinite; the piece does not move.
        """
        if not all(map(math.isfinite, (*pos, *quat))):
            name = self.types[self.state.kind[slot]].name
            raise NonFiniteError(f"{name}: position and attitude must be finite numbers, got {pos}, {quat}")
        self.changes += 1
        self.state.pos[slot] = self.state.before[slot] = pos
        self.state.vel[slot] = 0.0
        balls, row = self.balls, self.rows[slot]
        balls.quat[slot], balls.spin[slot] = quat, 0.0
        balls.still[slot] = balls.load[slot] = balls.press[slot] = balls.hold[slot] = 0.0
        balls.is_touched[slot], balls.is_put[slot], balls.leaves[slot] = 0, JUST_PUT, -1
        if row >= 0:
            self._world.set_pose(row, pos, quat)
            self._world.set_piece_touchable(row, True)

    def park(self, slot: int) -> None:
        """Remove a piece from the field; the caller sets the status.

        `PieceState.pos` keeps the last position on the field.
        """
        self.changes += 1
        self.state.vel[slot] = 0.0
        row = self.rows[slot]
        if row >= 0:
            self._world.set_piece_touchable(row, False)
            self._world.engine.set_pose(row, self._parking(slot), IDENTITY)
            self._world.engine.fix(row)

    def rows_of(self, slots: IntArray) -> list[int]:
        """Return the engine row of each slot, -1 for a ball."""
        rows = self.rows
        return [rows[slot] for slot in slots.tolist()]

    @staticmethod
    def _parking(slot: int) -> tuple[float, float, float]:
        return (float(slot % 32), float(slot // 32), _PARKING_HEIGHT)


class ShownPieces:
    """Slots and poses of the pieces on the field by kind, for displays.

    The arrays are read-only. The methods return the same array objects until the pool changes.

    Args:
        pool: Pool of the pieces.
        attitudes: Function that returns the attitudes w, x, y, z of the pieces in given slots, shape (n, 4).
    """

    def __init__(self, pool: PiecePool, attitudes: Callable[[IntArray], FloatArray]) -> None:
        self._pool = pool
        self._attitudes = attitudes
        self._changes = -1
        self._kept: dict[int, tuple[IntArray, FloatArray]] = {}

    def of(self, kind: int) -> tuple[IntArray, FloatArray]:
        """Return the slots and poses of the pieces of a kind on the field or in the air.

        Args:
            kind: Index of the kind.

        Returns:
            Slots in ascending order, shape (n,), and pose rows x, y, z, qw, qx, qy, qz, shape (n, 7).
        """
        pool = self._pool
        if pool.changes != self._changes:
            self._changes = pool.changes
            self._kept.clear()
        if kind not in self._kept:
            slots = np.array((pool.is_on_field & (pool.state.kind == kind)).nonzero()[0])
            rows = np.empty((len(slots), 7))
            rows[:, :3] = pool.state.pos.take(slots, axis=0)  # takes 1 us for 400 pieces; pos[slots] takes 14 us
            rows[:, 3:] = self._attitudes(slots)
            slots.setflags(write=False)
            rows.setflags(write=False)
            self._kept[kind] = slots, rows
        return self._kept[kind]
