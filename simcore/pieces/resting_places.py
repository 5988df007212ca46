"""Resting places: places on the field where game pieces stay and count, such as a pipe, a trough or a shelf.

A piece counts as placed when the piece rests in a place, supported and without contact with a robot. A placed piece
sleeps and wakes like any other piece. The piece counts until the piece leaves the place or a robot takes the piece.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from simcore.errors import ConfigError, UnknownNameError
from simcore.pieces.pool import PiecePool, PieceStatus
from simcore.quantities import Quantity, require_fields
from simcore.typing import Alliance, IntArray
from simcore.world.rotation import Vector, rotate
from simcore.world.zones import Zone

__all__ = ["PlaceEvent", "RestingPlace", "RestingPlaces"]

_AWAKE, _PLACED = int(PieceStatus.AWAKE), int(PieceStatus.PLACED)

_CAPACITY = Quantity("", 1, 10_000, is_whole=True)
_SHARE = Quantity("", -1.0, 1.0)
_TILT = Quantity("rad", 0.0, 0.5 * math.pi, is_open=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class RestingPlace:
    """Place on the field where pieces stay and count, with the conditions for pieces that count."""

    name: str
    level: str = ""
    """Name of a group of places with a common count, for example all places of one height. Telemetry publishes a level
    with a name that begins with `Blue` or `Red`, such as `BlueL4`, for this alliance."""
    alliance: Alliance | None = None
    """Alliance of the place; None for a neutral place."""
    zone: Zone
    """Zone that contains the center of a piece that counts."""
    capacity: int | None = None
    """Largest number of pieces that count; None for no limit."""
    kinds: tuple[str, ...] = ()
    """Kinds of pieces that count; empty for all kinds."""
    axis: Vector | None = None
    """Required direction of the z axis of a piece's shape, unit vector in the field frame; the opposite direction is
    also valid. None for any attitude."""
    max_tilt: float = math.radians(30.0)
    """Largest angle between the z axis of a piece's shape and `axis` [rad]."""

    def __post_init__(self) -> None:
        owner = f"RestingPlace {self.name!r}"
        require_fields(self, owner, capacity=_CAPACITY, axis=(_SHARE,) * 3, max_tilt=_TILT)
        if not self.name:
            raise ConfigError("RestingPlace: name must not be empty")
        if self.axis is not None and not math.isclose(math.hypot(*self.axis), 1.0, abs_tol=1e-6):
            raise ConfigError(f"{owner}: axis must be a unit vector, got {self.axis}")


@dataclass(frozen=True, slots=True)
class PlaceEvent:
    """Arrival of a piece in a resting place, or departure of a piece from the place."""

    place: RestingPlace
    slot: int
    """Slot of the piece."""
    holder: int
    """Number of the robot that took the piece; -1 for an arrival, and if no robot took the piece."""


class RestingPlaces:
    """Assignment of pieces to resting places.

    Args:
        places: Resting places with unique names; a piece in several overlapping places counts in the first place.
        pool: Pool of the pieces to assign.

    Raises:
        ConfigError: If two places have the same name or a kind of piece does not exist.
    """

    def __init__(self, places: Iterable[RestingPlace], pool: PiecePool) -> None:
        self.places = tuple(places)
        names = [place.name for place in self.places]
        if len(set(names)) != len(names):
            raise ConfigError(f"names of resting places must differ, got {names}")
        known = [kind.name for kind in pool.types]
        for place in self.places:
            if unknown := sorted(set(place.kinds) - set(known)):
                raise ConfigError(f"RestingPlace {place.name!r}: no piece of kind {unknown}, there are {known}")
        self._takes = [[not place.kinds or kind.name in place.kinds for kind in pool.types] for place in self.places]
        self._pool = pool
        self._place: IntArray = np.full(len(pool.rows), -1, dtype=np.int64)
        self._placed: list[PlaceEvent] = []
        self._counts: dict[str, IntArray] = {}  # by level; empty after an arrival or departure
        self._totals: dict[str, int] = {}
        self._numbers = {name: number for number, name in enumerate(names)}
        self._levels: dict[str, list[int]] = {}
        for number, place in enumerate(self.places):
            if place.level:
                self._levels.setdefault(place.level, []).append(number)

    def judge(self, slot: int, quat: tuple[float, float, float, float], touches_robot: bool) -> None:
        """Assign a piece that has just fallen asleep to the resting place around the piece, and set the status PLACED.

        Nothing changes if no place accepts the piece.

        Args:
            slot: Slot of the piece.
            quat: Attitude of the piece, x, y, z, w.
            touches_robot: Whether the piece touches a robot; if so, the piece does not count, and nothing changes.
        """
        state = self._pool.state
        if touches_robot:
            return
        if self._place[slot] < 0:
            number = self._place_of(slot, quat)
            if number >= 0:
                self._place[slot] = number
                self._counts = {}
                self._placed.append(PlaceEvent(self.places[number], slot, -1))
        number = int(self._place[slot])
        if number >= 0 and self.places[number].zone.contains(state.pos[slot][None])[0]:
            state.status[slot] = _PLACED

    def update(self) -> tuple[list[PlaceEvent], list[PlaceEvent]]:
        """Remove pieces that have left a place, and return the arrivals and the departures since the last call."""
        state = self._pool.state
        removed = []
        for slot in np.nonzero((self._place >= 0) & (state.status != _PLACED))[0].tolist():
            place = self.places[self._place[slot]]
            is_still_there = state.status[slot] == _AWAKE and place.zone.contains(state.pos[slot][None])[0]
            if not is_still_there:
                self._place[slot] = -1
                self._counts = {}
                removed.append(PlaceEvent(place, slot, int(state.holder[slot])))
        placed, self._placed = self._placed, []
        return placed, removed

    @property
    def woken(self) -> IntArray:
        """Slots of the awake pieces that count in a place."""
        return np.nonzero((self._place >= 0) & (self._pool.state.status == _AWAKE))[0]

    def slots(self, name: str | None = None, *, level: str | None = None) -> IntArray:
        """Return the slots of the pieces in a place, in all places of a level, or in all places.

        Raises:
            UnknownNameError: If no place has this name.
        """
        if name is not None and name not in self._numbers:
            raise UnknownNameError("resting place", name, self._numbers)
        wanted = [
            number
            for number, place in enumerate(self.places)
            if (name is None or place.name == name) and (level is None or place.level == level)
        ]
        return np.nonzero(np.isin(self._place, wanted))[0]

    def count(self, name: str | None = None, *, level: str | None = None) -> int:
        """Count the pieces in a place, in all places of a level, or in all places."""
        return len(self.slots(name, level=level))

    def counts(self) -> Mapping[str, IntArray]:
        """Return the number of pieces in each place of each level, as one read-only array per level.

        The elements of an array are in the order of the places.
        """
        if not self._counts:
            self._count_levels()
        return self._counts

    def totals(self) -> Mapping[str, int]:
        """Return the total number of pieces in the places of each level."""
        if not self._counts:
            self._count_levels()
        return self._totals

    def _count_levels(self) -> None:
        found = np.bincount(self._place[self._place >= 0], minlength=len(self.places))
        self._counts = {level: found[numbers] for level, numbers in self._levels.items()}
        self._totals = {level: int(counts.sum()) for level, counts in self._counts.items()}
        for counts in self._counts.values():
            counts.setflags(write=False)

    def _place_of(self, slot: int, quat: tuple[float, float, float, float]) -> int:
        """Return the index of the first place that accepts a piece at its present pose; -1 without such a place."""
        state = self._pool.state
        kind, here = state.kind[slot], state.pos[slot][None]
        for number, place in enumerate(self.places):
            if not (self._takes[number][kind] and place.zone.contains(here)[0]):
                continue
            if place.axis is not None:
                x, y, z = rotate(quat, (0.0, 0.0, 1.0))
                along = abs(x * place.axis[0] + y * place.axis[1] + z * place.axis[2])
                if along < math.cos(place.max_tilt):
                    continue
            if place.capacity is None or np.count_nonzero(self._place == number) < place.capacity:
                return number
        return -1
