"""The bodies of all pieces, made once: a piece that is held, scored or not yet on the field is parked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from simcore.errors import CapacityError, ConfigError
from simcore.geometry.rotation import IDENTITY, Quaternion
from simcore.physics.contact_law import TerrainSurface
from simcore.physics.shapes import Sphere
from simcore.physics.world import PhysicsWorld
from simcore.pieces.aerodynamics import AirFactors
from simcore.pieces.kinds import GamePieceConfig, PieceVariation
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["ON_FIELD", "PiecePool", "PieceState", "PieceStatus", "ShownPieces"]

_PARKING_HEIGHT = 50.0  # [m], above everything; 1 m apart: balls parked on one spot take seconds a step


class PieceStatus(IntEnum):
    """Where a piece is in its life."""

    FREE = 0
    """A body that no piece uses."""
    STAGED = 1
    """Counted, but not on the field: e.g. in an outpost's chute."""
    ASLEEP = 2
    """On the field, at rest and frozen."""
    AWAKE = 3
    """On the field, in contact with something or about to be: moved by the engine."""
    HELD = 4
    """In a robot."""
    IN_FLIGHT = 5
    """In the air, moved by `flying_pieces`."""
    SCORED = 6
    """Scored and taken off the field."""
    PLACED = 7
    """At rest and frozen in a place where it counts."""


ON_FIELD = (PieceStatus.ASLEEP, PieceStatus.AWAKE, PieceStatus.IN_FLIGHT, PieceStatus.PLACED)
"""The statuses of pieces on the field or in the air."""
_IS_ON_FIELD: BoolArray = np.isin([int(status) for status in PieceStatus], ON_FIELD)
"""By status."""
_IS_FROZEN: BoolArray = np.isin([int(status) for status in PieceStatus], (PieceStatus.ASLEEP, PieceStatus.PLACED))
"""By status."""


@dataclass(slots=True)
class PieceState:
    """State of all pieces, one row per slot; `n` is the capacity of the pool."""

    pos: FloatArray
    """Center, field frame [m], shape (n, 3); where it last was for pieces that are parked."""
    before: FloatArray
    """Center at the start of the tick [m], shape (n, 3); of use for pieces that are awake."""
    vel: FloatArray
    """Mean velocity over the last tick, field frame [m/s], shape (n, 3)."""
    status: npt.NDArray[np.uint8]
    """A `PieceStatus` per slot, shape (n,)."""
    kind: npt.NDArray[np.uint8]
    """Index of the piece's type, shape (n,)."""
    touchable: BoolArray
    """Whether the engine sees the body, shape (n,)."""
    holder: IntArray
    """Which robot holds the piece, -1 for none, shape (n,)."""


class PiecePool:
    """Bodies and state of all pieces of a world. Slots of one type are contiguous."""

    def __init__(
        self,
        world: PhysicsWorld,
        types: list[tuple[GamePieceConfig, int]],
        variation: PieceVariation | None = None,
    ) -> None:
        """Make all bodies.

        Args:
            world: Where the bodies live.
            types: Each type with the most pieces of it that there can be.
            variation: By which factors pieces differ from their kind; None: not at all.
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
            touchable=np.zeros(n, dtype=bool),
            holder=np.full(n, -1, dtype=np.int64),
        )
        self.rows: list[int] = []
        """Engine row of each slot."""
        self.changes = 0
        """Grows whenever a piece may have come, gone or moved."""
        self.radius = np.zeros(n)
        """Bounding radius of each slot's piece [m], shape (n,)."""
        self.mass = np.zeros(n)
        """Of each slot's piece [kg], shape (n,)."""
        self.size = np.ones(n) if variation is None else variation.diameter
        """Diameter of each slot's piece over that of its kind [-], shape (n,)."""
        self.drag = np.zeros(n)
        """See `AirFactors`; of each slot's piece [1/m], shape (n,)."""
        self.lift_share = np.ones(n) if variation is None else variation.diameter**3 / variation.mass
        """Spin lift of each slot's piece over that of its kind [-], shape (n,)."""
        self.surfaces: list[TerrainSurface] = []
        """Material of each slot's piece."""
        self.air = [config.air for config in self.types]
        """What the air does to pieces of each kind; `drag` and `lift_share` have what single ones differ by."""
        slot = 0
        for kind, (config, count) in enumerate(types):
            mine = slice(slot, slot + count)
            self.mass[mine] = config.mass
            self.drag[mine] = self.air[kind].drag
            surfaces = [config.surface] * count
            if variation is not None:
                self.mass[mine] *= variation.mass[mine]
                self.drag[mine] *= variation.drag[mine] * variation.diameter[mine] ** 2 / variation.mass[mine]
                surfaces = [
                    replace(surface, restitution=min(1.0, surface.restitution * factor))
                    for surface, factor in zip(surfaces, variation.restitution[mine].tolist(), strict=True)
                ]
            self.surfaces += surfaces
            for mass, surface in zip(self.mass[mine].tolist(), surfaces, strict=True):
                if isinstance(
                    config.shape, Sphere
                ):  # its impacts are ours (`impact_events`): in the engine none bounces
                    surface = replace(surface, restitution=0.0)
                row = world.add_piece_body(
                    config.name, config.shape, mass=mass, surface=surface, pos=self._parking(slot)
                )
                world.set_piece_touchable(row, False)
                world.engine.fix(row)
                self.rows.append(row)
                slot += 1
            self.state.kind[slot - count : slot] = kind
            self.radius[slot - count : slot] = config.bounding_radius
        self.is_ball = np.array([isinstance(kind.shape, Sphere) for kind in self.types], dtype=bool)[self.state.kind]
        """Which slots are balls, shape (n,)."""

    @property
    def is_on_field(self) -> BoolArray:
        """Whether each slot is on the field or in the air, shape (n,)."""
        here: BoolArray = _IS_ON_FIELD.take(self.state.status)  # 1.3 us, three comparisons 4
        return here

    @property
    def is_frozen(self) -> BoolArray:
        """Whether each slot is on the field and sleeps, placed or not, shape (n,)."""
        frozen: BoolArray = _IS_FROZEN.take(self.state.status)
        return frozen

    def air_of(self, slot: int) -> AirFactors:
        """What the air does to one piece."""
        air = self.air[self.state.kind[slot]]
        drag, lift = float(self.drag[slot]), air.lift * float(self.lift_share[slot])
        return AirFactors(drag=drag, lift=lift, lift_saturation=air.lift_saturation)

    def take(self, kind: int, count: int) -> IntArray:
        """Reserve free slots of a type; they stay parked.

        Raises:
            CapacityError: Fewer are free.
            ConfigError: A negative count.
        """
        if count < 0:
            raise ConfigError(f"{self.types[kind].name}: how many pieces must be >= 0, got {count}")
        free = np.nonzero((self.state.kind == kind) & (self.state.status == PieceStatus.FREE))[0]
        if len(free) < count:
            have = int((self.state.kind == kind).sum())
            raise CapacityError(
                f"{self.types[kind].name}: {count} more pieces wanted, but only {len(free)} of {have} are free; "
                "make the pool larger or stage fewer"
            )
        return free[:count]

    def place(
        self, slot: int, pos: tuple[float, float, float], *, touchable: bool, quat: Quaternion = IDENTITY
    ) -> None:
        """Take a body out of parking and put it on the field, at rest and awake."""
        world, row = self._world, self.rows[slot]
        self.changes += 1
        world.set_pose(row, pos, quat)
        self.state.pos[slot] = self.state.before[slot] = pos
        self.state.vel[slot] = 0.0
        self.set_touchable(slot, touchable)

    def park(self, slot: int) -> None:
        """Take a body off the field. Its `pos` stays as the place where it was last seen."""
        world, row = self._world, self.rows[slot]
        self.changes += 1
        self.state.touchable[slot] = False
        world.set_piece_touchable(row, False)
        world.engine.set_pose(row, self._parking(slot), IDENTITY)
        world.engine.fix(row)
        self.state.vel[slot] = 0.0

    def set_touchable(self, slot: int, touchable: bool) -> None:
        """Show a body to the engine, or hide it where it is."""
        if bool(self.state.touchable[slot]) != touchable:
            self.state.touchable[slot] = touchable
            self._world.set_piece_touchable(self.rows[slot], touchable)

    def rows_of(self, slots: IntArray) -> list[int]:
        """Engine rows of some slots."""
        rows = self.rows
        return [rows[slot] for slot in slots.tolist()]

    @staticmethod
    def _parking(slot: int) -> tuple[float, float, float]:
        return (float(slot % 32), float(slot // 32), _PARKING_HEIGHT)


class ShownPieces:
    """What pieces on the field look like: slots and poses by kind.

    The arrays are read-only, and the same until the pool says that something has changed.

    Args:
        pool: The pieces.
        attitudes: Of slots, as w, x, y, z, shape (n, 4).
    """

    def __init__(self, pool: PiecePool, attitudes: Callable[[IntArray], FloatArray]) -> None:
        self._pool = pool
        self._attitudes = attitudes
        self._changes = -1
        self._kept: dict[int, tuple[IntArray, FloatArray]] = {}

    def of(self, kind: int) -> tuple[IntArray, FloatArray]:
        """Slots of a kind on the field or in the air, rising, shape (n,), and their rows x, y, z, qw, qx, qy, qz.

        Args:
            kind: Its number.
        """
        pool = self._pool
        if pool.changes != self._changes:
            self._changes = pool.changes
            self._kept.clear()
        if kind not in self._kept:
            slots = np.array((pool.is_on_field & (pool.state.kind == kind)).nonzero()[0])
            rows = np.empty((len(slots), 7))
            rows[:, :3] = pool.state.pos[slots]
            rows[:, 3:] = self._attitudes(slots)
            slots.setflags(write=False)
            rows.setflags(write=False)
            self._kept[kind] = slots, rows
        return self._kept[kind]
