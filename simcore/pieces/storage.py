"""Where a robot keeps the pieces that it holds, and in which order they leave."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from simcore.errors import CapacityError, ConfigError
from simcore.geometry.rotation import IDENTITY, Quaternion, Vector
from simcore.quantities import COUNT, ROBOT_PLACE, require_attitude, require_fields

__all__ = ["Storage", "StorageConfig"]


@dataclass(frozen=True, slots=True, kw_only=True)
class StorageConfig:
    """Room for pieces inside of a robot."""

    name: str = ""
    """By which intakes and shooters choose it, in a robot with several; empty for the only one."""
    capacity: int = 1
    """Pieces that it holds."""
    order: Literal["fifo", "lifo"] = "fifo"
    """Which piece leaves first: the one that came first, or the one that came last."""
    low: Vector = (-0.25, -0.25, 0.25)
    """Smallest corner of the room, robot frame [m]."""
    high: Vector = (0.15, 0.25, 0.50)
    """Largest corner [m]."""
    attitude: Quaternion = IDENTITY
    """Of the pieces in it, robot frame, x, y, z, w. A shot turns them as the muzzle is turned: a tube that lies along x
    leaves along the muzzle, a ring that lies flat leaves edge on."""

    def __post_init__(self) -> None:
        require_fields(self, capacity=COUNT, low=(ROBOT_PLACE,) * 3, high=(ROBOT_PLACE,) * 3)
        if self.order not in ("fifo", "lifo"):
            raise ConfigError(f"StorageConfig: order must be 'fifo' or 'lifo', got {self.order!r}")
        require_attitude("StorageConfig", "attitude", self.attitude)
        for low, high in zip(self.low, self.high, strict=True):
            if not low < high:
                raise ConfigError(f"StorageConfig: low must be below high on every axis, got {self.low}, {self.high}")

    def position(self, number: int, radius: float) -> Vector:
        """Where the piece of a number, counted from 0, is shown: rows of balls, filled from the floor of the room.

        Pieces in a robot are not simulated one by one. A room that is too small for its capacity is filled beyond its
        top.

        Args:
            number: Place in the order in which pieces came.
            radius: Bounding radius of a piece [m].
        """
        pitch = 2.0 * radius
        (x0, y0, z0), (x1, y1, _) = self.low, self.high
        columns = max(1, math.floor((x1 - x0) / pitch + 1e-9))
        rows = max(1, math.floor((y1 - y0) / pitch + 1e-9))
        layer, rest = divmod(number, columns * rows)
        column, row = divmod(rest, rows)
        middle_x, middle_y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
        return (
            middle_x + (column - 0.5 * (columns - 1)) * pitch,
            middle_y + (row - 0.5 * (rows - 1)) * pitch,
            z0 + radius + layer * pitch,
        )


class Storage:
    """The pieces in a robot's storage.

    >>> storage = Storage(StorageConfig(capacity=2))
    >>> storage.add([7, 8])
    >>> storage.take(), storage.room
    (7, 1)
    """

    def __init__(self, config: StorageConfig) -> None:
        self.config = config
        self.pieces: list[int] = []
        """Slots of the pieces, in the order in which they came."""

    @property
    def room(self) -> int:
        """How many more fit."""
        return self.config.capacity - len(self.pieces)

    def add(self, slots: list[int]) -> None:
        """Put pieces in.

        Raises:
            CapacityError: There is no room for all of them; nothing has changed.
        """
        if len(slots) > self.room:
            raise CapacityError(f"a storage of {self.config.capacity} has room for {self.room} more, got {len(slots)}")
        self.pieces += slots

    @property
    def in_turn(self) -> list[int]:
        """Slots of the pieces, in the order in which they leave."""
        return self.pieces if self.config.order == "fifo" else self.pieces[::-1]

    def take(self) -> int:
        """Take out the piece whose turn it is.

        Raises:
            CapacityError: There is none.
        """
        if not self.pieces:
            raise CapacityError("the storage is empty")
        return self.pieces.pop(0 if self.config.order == "fifo" else -1)

    def discard(self, slot: int) -> None:
        """Forget a piece that left in another way."""
        self.pieces = [piece for piece in self.pieces if piece != slot]
