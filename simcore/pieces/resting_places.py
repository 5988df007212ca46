"""Places on the field where pieces stay and count: on a pipe, in a trough, on a shelf.

Physics decides: a piece that has come to rest in a place, on something, and touches no robot is placed there. It is
frozen like any piece that sleeps, wakes like one, and stays placed until it leaves the place or a robot takes it.
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
    """A place where pieces stay and count."""

    name: str
    level: str = ""
    """What it is counted with, e.g. all places of one height. One that begins with `Blue` or `Red` is shown as that
    alliance's: `BlueL4`."""
    alliance: Alliance | None = None
    """Whose it is; None: nobody's."""
    zone: Zone
    """Where the center of a piece must be."""
    capacity: int | None = None
    """Pieces that count in it; None: any number."""
    kinds: tuple[str, ...] = ()
    """Kinds of pieces that count in it; none named: all."""
    axis: Vector | None = None
    """Where the z axis of a piece's shape must point to or away from, field frame; None: anywhere."""
    max_tilt: float = math.radians(30.0)
    """How far it may be off that axis [rad]."""

    def __post_init__(self) -> None:
        owner = f"RestingPlace {self.name!r}"
        require_fields(self, owner, capacity=_CAPACITY, axis=(_SHARE,) * 3, max_tilt=_TILT)
        if not self.name:
            raise ConfigError("RestingPlace: name must not be empty")
        if self.axis is not None and not math.isclose(math.hypot(*self.axis), 1.0, abs_tol=1e-6):
            raise ConfigError(f"{owner}: axis must be a unit vector, got {self.axis}")


@dataclass(frozen=True, slots=True)
class PlaceEvent:
    """A piece that has come to stay in a place, or has left it."""

    place: RestingPlace
    slot: int
    """The piece."""
    holder: int
    """Robot that took it, -1 for none."""


class RestingPlaces:
    """Which piece is in which place.

    Args:
        places: Names must differ; where two overlap, a piece counts in the first.
        pool: The pieces.

    Raises:
        ConfigError: Two places of one name, or a kind of piece that there is not.
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
        self._counts: dict[str, IntArray] = {}  # by level; none after a piece has come or gone
        self._totals: dict[str, int] = {}
        self._numbers = {name: number for number, name in enumerate(names)}
        self._levels: dict[str, list[int]] = {}
        for number, place in enumerate(self.places):
            if place.level:
                self._levels.setdefault(place.level, []).append(number)

    def judge(self, slot: int, quat: tuple[float, float, float, float], touches_robot: bool) -> None:
        """Place a piece that has just fallen asleep, if it is in a place.

        Args:
            slot: Of the piece.
            quat: Its attitude, x, y, z, w.
            touches_robot: Whether it leans on a robot; then it does not count.
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
        """Pieces that have come to stay since the last call, and those that have left."""
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
        """Slots of the pieces that count in a place, but have been woken there."""
        return np.nonzero((self._place >= 0) & (self._pool.state.status == _AWAKE))[0]

    def slots(self, name: str | None = None, *, level: str | None = None) -> IntArray:
        """Slots of the pieces in a place, in all places of a level, or in all places.

        Raises:
            UnknownNameError: No such place.
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
        """How many pieces are in a place, in all places of a level, or in all places."""
        return len(self.slots(name, level=level))

    def counts(self) -> Mapping[str, IntArray]:
        """How many pieces are in each place of each level, both in the order of the places; read-only."""
        if not self._counts:
            self._count_levels()
        return self._counts

    def totals(self) -> Mapping[str, int]:
        """How many pieces are in the places of each level, in their order."""
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
        """Number of the place that a piece is in and counts in, -1 for none."""
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
