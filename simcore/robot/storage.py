"""Storage of a robot: positions of stored pieces and the order in which pieces leave."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from simcore.errors import CapacityError, ConfigError
from simcore.loop.state import Balls
from simcore.quantities import ATTITUDE, COUNT, ROBOT_PLACE, require_fields
from simcore.robot.hopper import FACES, Hopper, HopperConfig
from simcore.typing import FloatArray
from simcore.world.rotation import IDENTITY, Quaternion, Vector

__all__ = ["Storage", "StorageConfig"]

_Row = tuple[int, float]
"""Number of balls in a row, and offset of the row's center from the storage's center [m]."""
_Layer = tuple[_Row, _Row]
"""Row along x and row along y in a layer."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StorageConfig:
    """Config of a storage: the space in a robot that holds game pieces."""

    name: str = ""
    """Name by which intakes, shooters and placers refer to this storage; only a robot's first storage may have an empty
    name."""
    capacity: int = 1
    """Maximum number of pieces."""
    order: Literal["fifo", "lifo"] = "fifo"
    """Order in which pieces leave: first in, first out, or last in, first out."""
    low: Vector = (-0.25, -0.25, 0.25)
    """Corner with the smallest x, y and z, robot frame [m]."""
    high: Vector = (0.15, 0.25, 0.50)
    """Corner with the largest x, y and z, robot frame [m]."""
    attitude: Quaternion = IDENTITY
    """Attitude of stored pieces in the robot frame, quaternion x, y, z, w. At a shot, the attitude of the piece is that
    of the muzzle. A tube stored along x therefore leaves lengthwise, and a ring stored flat leaves edge-on."""
    hopper: HopperConfig | None = None
    """Config of a hopper, where the pieces are balls that fall, roll and jam; None for a plain queue. The balls leave a
    hopper in the order in which the balls reach the outlet. An intake can add a ball only if the inlet is free."""

    def __post_init__(self) -> None:
        corner = (ROBOT_PLACE,) * 3
        require_fields(self, capacity=COUNT, low=corner, high=corner, attitude=ATTITUDE)
        if self.hopper is not None and self.order != "fifo":
            raise ConfigError(
                "StorageConfig: order must be 'fifo' with a hopper, which releases what is at its outlet, got "
                f"{self.order!r}"
            )
        for low, high in zip(self.low, self.high, strict=True):
            if not low < high:
                raise ConfigError(f"StorageConfig: low must be below high on every axis, got {self.low}, {self.high}")
        if self.hopper is not None and self.hopper.outlet_place is not None:
            normal = FACES[self.hopper.outlet][0]
            for axis, place in zip((1, 0) if normal == 2 else (1 - normal, 2), self.hopper.outlet_place, strict=True):
                if not self.low[axis] <= place <= self.high[axis]:
                    ends = f"from {self.low[axis]:g} to {self.high[axis]:g} m"
                    raise ConfigError(f"StorageConfig: {'xyz'[axis]} of outlet_place must be {ends}, got {place:g}")

    def position(self, number: int, radius: float) -> Vector:
        """Return the position of a stored piece in a packing of layers, robot frame [m].

        Storages without a hopper use these positions. Each layer rests in the hollows of the layer below. The layers
        overlap if the pieces would exceed the height of the storage. In a storage lower than one piece, all pieces are
        at the same height.

        Args:
            number: Index of the piece in the order of arrival, from 0; pieces beyond the capacity share the last
                position.
            radius: Bounding radius of the pieces [m].
        """
        places = _places(self, radius)
        return places[min(number, len(places) - 1)]

    def balls_that_fit(self, radius: float) -> int:
        """Return the number of balls of a given radius [m] that fit in the packing of `position` without overlap.

        The capacity does not limit this number.
        """
        layers, rise = _layers(self, radius)
        count = 1 + math.floor(max(0.0, self.high[2] - self.low[2] - 2.0 * radius) / rise + 1e-9)
        lower, upper = (columns * rows for (columns, _), (rows, _) in layers)
        return (count + 1) // 2 * lower + count // 2 * upper


@functools.lru_cache(maxsize=64)
def _places(config: StorageConfig, radius: float) -> list[Vector]:
    """Return the positions of all pieces in a full storage, for pieces of a given radius [m], robot frame [m]."""
    layers, rise = _layers(config, radius)
    (x0, y0, z0), (x1, y1, z1) = config.low, config.high
    cells: list[tuple[int, float, float]] = []  # index of the layer, x and y
    layer = 0
    while len(cells) < config.capacity:
        (columns, shift_x), (rows, shift_y) = layers[layer % 2]
        cells += [
            (layer, 0.5 * (x0 + x1) + shift_x + (2 * i - columns + 1) * radius,
             0.5 * (y0 + y1) + shift_y + (2 * j - rows + 1) * radius)
            for i in range(columns) for j in range(rows)
        ]  # fmt: skip
        layer += 1
    cells = cells[: config.capacity]
    rise = min(rise, max(0.0, z1 - z0 - 2.0 * radius) / max(1, layer - 1))
    return [(x, y, z0 + radius + number * rise) for number, x, y in cells]


def _layers(config: StorageConfig, radius: float) -> tuple[tuple[_Layer, _Layer], float]:
    """Return the two layers that alternate in the packing, lowest layer first, and the height of each step up [m]."""
    sides = [_staggered_rows(high - low, radius) for low, high in zip(config.low[:2], config.high[:2], strict=True)]
    staggered = sum(lower != upper for lower, upper in sides)
    return ((sides[0][0], sides[1][0]), (sides[0][1], sides[1][1])), radius * math.sqrt(4.0 - staggered)


def _staggered_rows(length: float, radius: float) -> tuple[_Row, _Row]:
    """Return the rows along one axis in two successive layers, offset against each other by one radius.

    If the side is too short for the offset, the second row has one ball fewer, but at least one ball.

    Args:
        length: Length of the storage along the axis [m].
        radius: Radius of the balls [m].
    """
    count = max(1, math.floor(0.5 * length / radius + 1e-9))
    if length - 2.0 * count * radius >= radius - 1e-9:
        return (count, -0.5 * radius), (count, 0.5 * radius)
    return (count, 0.0), (max(1, count - 1), 0.0)


class Storage:
    """Storage of a robot, with the slots of the stored pieces.

    Args:
        config: Config of the storage.
        balls: Function that returns the records of all balls of the match, by slot; None for a storage without a
            hopper.

    >>> storage = Storage(StorageConfig(capacity=2))
    >>> storage.add([7, 8])
    >>> storage.take(), storage.room
    (7, 1)
    """

    def __init__(self, config: StorageConfig, balls: Callable[[], Balls] | None = None) -> None:
        self.config = config
        self.pieces: list[int] = []
        """Slots of the pieces in order of arrival."""
        self.hopper = None if config.hopper is None else Hopper(config.hopper, config.low, config.high, balls)
        """Simulation of the hopper; None for a storage that is a plain queue."""
        self._radii: list[float] = []  # radii of the pieces for which `_places` was computed
        self._places: FloatArray = np.empty((0, 3))

    @property
    def room(self) -> int:
        """Number of pieces that can still be added."""
        return self.config.capacity - len(self.pieces)

    def room_for(self, radius: float) -> int:
        """Return the number of pieces of a given radius [m] that can enter now.

        The capacity and the free space at the inlet of a hopper limit this number.
        """
        if self.hopper is None:
            return self.room
        waiting = len(set(self.pieces).difference(self.hopper.slots))  # added by another intake in this tick
        return min(self.room, max(0, self.hopper.room_at_inlet(radius) - waiting))

    def places(self, radii: FloatArray) -> FloatArray:
        """Return the positions of the pieces in the order of `pieces`, robot frame [m], shape (n, 3).

        Args:
            radii: Bounding radii of all pieces, by slot [m].
        """
        mine = radii[self.pieces].tolist()
        if self.hopper is None:
            if mine != self._radii:
                places = [self.config.position(number, radius) for number, radius in enumerate(mine)]
                self._radii, self._places = mine, np.array(places).reshape(-1, 3)
            return self._places
        if self.hopper.slots != self.pieces:
            self.follow(mine)
        return self.hopper.pos

    def follow(self, radii: Sequence[float]) -> None:
        """Update the balls in the hopper, if any, after a change of `pieces`.

        Args:
            radii: Radii of the pieces, in the order of `pieces` [m].
        """
        if self.hopper is not None:
            self.hopper.follow(self.pieces, radii, _places(self.config, max(radii, default=1.0)))

    def add(self, slots: list[int]) -> None:
        """Add the pieces with the given slots.

        Raises:
            CapacityError: If there is no room for all of the pieces; no piece is then added.
        """
        if len(slots) > self.room:
            raise CapacityError(f"a storage of {self.config.capacity} has room for {self.room} more, got {len(slots)}")
        self.pieces += slots

    @property
    def in_turn(self) -> list[int]:
        """Slots of the pieces in the order of leaving; for a hopper, only of the pieces past the outlet."""
        if self.hopper is not None:
            return [slot for slot in self.hopper.at_outlet() if slot in self.pieces]
        return self.pieces if self.config.order == "fifo" else self.pieces[::-1]

    def take(self) -> int:
        """Remove the first piece of `in_turn` from the storage, and return the slot of the piece.

        Raises:
            CapacityError: If no piece can leave now.
        """
        if not self.pieces:
            raise CapacityError("the storage is empty")
        if self.hopper is not None:
            if not (ready := self.in_turn):
                raise CapacityError(f"none of the {len(self.pieces)} pieces is at the outlet of the hopper")
            self.pieces.remove(ready[0])
            return ready[0]
        return self.pieces.pop(0 if self.config.order == "fifo" else -1)

    def clear(self) -> None:
        """Remove all pieces."""
        self.pieces.clear()
        self.follow([])

    def discard(self, slot: int) -> None:
        """Remove a piece from `pieces`, for a piece that left by other means than `take`; ignore an unknown slot."""
        self.pieces = [piece for piece in self.pieces if piece != slot]
