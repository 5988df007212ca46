"""The life of the pieces: staged, put on the field, held, launched, scored.

How they move, sleep and wake is in `moving_pieces`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from simcore.errors import CapacityError, ConfigError, NonFiniteError
from simcore.geometry.rotation import IDENTITY, Quaternion, Vector
from simcore.pieces.aerodynamics import AirFactors
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.moving_pieces import MovingPieces
from simcore.pieces.pool import ON_FIELD, PieceStatus
from simcore.pieces.reach import Footprint
from simcore.quantities import FORCE, require, shown
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["GamePieceManager"]

_ROBOT_HEIGHT = 0.6  # [m]; pieces above it fly over a robot
_BESIDE = 0.02  # [m]; what is within this of a piece may carry it
_SOFT, _HARD = 0.1, 0.003  # how deep a piece may be in a wall as it is let go: of a ball's radius, [m] of others
_FREE, _STAGED, _ASLEEP, _AWAKE, _HELD, _IN_FLIGHT, _SCORED, _PLACED = (int(status) for status in PieceStatus)
_ZERO = (0.0, 0.0, 0.0)
_LOOSE = (_STAGED, *ON_FIELD, _SCORED)  # in no robot
_ALL = (*_LOOSE, _HELD)


class Holder(Protocol):
    """A robot, as the pieces see it."""

    def forget_piece(self, slot: int) -> None:
        """Have a piece no more."""
        ...


class GamePieceManager(MovingPieces):
    """Owns all pieces of a world; arguments as `MovingPieces`.

    Which call takes a piece from which status, and to which; any other is refused:

    | call | from | to |
    |---|---|---|
    | `stage` | FREE | STAGED |
    | `release` | STAGED, on the field, HELD, SCORED | AWAKE |
    | `put_down` | STAGED, on the field, SCORED | AWAKE |
    | `hold` | STAGED, on the field, SCORED | HELD |
    | `launch` | HELD | IN_FLIGHT, AWAKE |
    | `score` | on the field | SCORED |
    | `set_aside` | SCORED | STAGED |
    """

    holders: Sequence[Holder] = ()
    """The robots by number, which are told when a piece is taken from them."""

    # --- life -----------------------------------------------------------------------------------------------------

    def stage(self, name: str, count: int) -> IntArray:
        """Count pieces in that are not on the field yet; returns their slots.

        Raises:
            UnknownNameError: No such type.
            CapacityError: The pool is too small.
        """
        slots = self._pool.take(self._kind(name), count)
        self.state.status[slots] = _STAGED
        self.total += len(slots)
        return slots

    def spawn(
        self,
        name: str,
        positions: FloatArray,
        attitudes: FloatArray | None = None,
        *,
        resting: bool = False,
        lodged: float | None = None,
    ) -> IntArray:
        """Put new pieces on the field; those that stand on the carpet sleep at once. Returns their slots.

        Args:
            name: Of their kind.
            positions: Centers, field frame [m], shape (n, 3).
            attitudes: Unit quaternions x, y, z, w, shape (n, 4); None: upright, as the shape of the kind is.
            resting: Whether they sleep at once where they are, because they lie on other pieces or on the field.
            lodged: Force at which they come free, because they are wedged in there [N]; None: they are not.

        Raises:
            UnknownNameError: No such type.
            CapacityError: The pool is too small.
            ConfigError: An attitude is no unit quaternion, nothing is there to rest on, or the force is not above 0.
            NonFiniteError: A place is not finite. In each case nothing is spawned.
        """
        positions = np.asarray(positions, dtype=float).reshape(-1, 3)
        if not np.isfinite(positions).all():
            raise NonFiniteError(f"{name}: spawn positions must be finite [m]")
        quats = _quaternions(name, attitudes, len(positions))
        if lodged is not None:
            require(name, "force that lodged pieces come free at", lodged, FORCE)
        if resting:
            self._require_support(name, positions)
        slots = self.stage(name, len(positions))
        self._release(slots, positions, quats, resting=resting or lodged is not None)
        if lodged is not None:
            for slot in slots.tolist():
                self._wedged.wedge(slot, lodged)
        return slots

    def release(self, slots: IntArray, positions: FloatArray, attitudes: FloatArray | None = None) -> None:
        """Put pieces on the field, at rest, wherever they are now.

        Args:
            slots: Which ones.
            positions: Centers, field frame [m], shape (n, 3).
            attitudes: Unit quaternions x, y, z, w, shape (n, 4); None: upright.

        Raises:
            ConfigError: A slot holds no piece, or an attitude is no quaternion.
            NonFiniteError: A place is not finite. Either way nothing has changed.
        """
        self._require("release", slots, _ALL, positions)
        quats = _quaternions("release", attitudes, len(slots))
        for slot in slots[self.state.status[slots] == _HELD].tolist():
            if self.state.holder[slot] < len(self.holders):
                self.holders[self.state.holder[slot]].forget_piece(slot)
        self._release(slots, positions, quats)

    def hold(self, slots: IntArray, holder: int) -> None:
        """Take pieces into a robot: off the field, and what leaned on them wakes.

        Raises:
            ConfigError: A slot holds no piece, a robot has it, or there is no such robot; nothing has changed.
        """
        self._require("hold", slots, _LOOSE)
        if holder < 0 or (self.holders and holder >= len(self.holders)):
            raise ConfigError(f"hold: there are robots 0 to {len(self.holders) - 1}, got {holder}")
        self._wedged.free(slots)
        for slot in slots.tolist():
            self._wake_leaning(slot)
            self._flying.forget(slot)
            self._pool.park(slot)
            self.state.status[slot] = _HELD
            self.state.holder[slot] = holder
        self._awake_stale = True

    def launch(
        self,
        holder: int,
        pos: Sequence[float],
        vel: Sequence[float],
        spin: Sequence[float] = (0.0, 0.0, 0.0),
        *,
        slot: int | None = None,
        quat: Quaternion = IDENTITY,
        flying: bool = True,
    ) -> int:
        """Let one held piece go with a velocity; returns its slot.

        Args:
            holder: The robot that holds it.
            pos: Center of the piece at the muzzle, field frame [m].
            vel: Its velocity [m/s].
            spin: Its angular velocity [rad/s].
            slot: Which piece; None: that of the lowest slot.
            quat: Its attitude.
            flying: Whether it is shot into the air; otherwise it is put down.

        Raises:
            CapacityError: The robot holds none, or not this one.
            NonFiniteError: A value is not finite; the piece stays held.
        """
        held = self.held(holder)
        if len(held) == 0:
            raise CapacityError(f"robot {holder} has no piece to launch")
        if slot is None:
            slot = int(held[0])
        elif slot not in held:
            raise CapacityError(f"robot {holder} holds pieces {held.tolist()}, got {slot}")
        if not (len(pos) == len(vel) == len(spin) == 3 and all(map(math.isfinite, (*pos, *vel, *spin)))):
            raise NonFiniteError(
                f"launch: position, velocity and spin must be three finite numbers each, got {pos}, {vel}, {spin}"
            )
        self._pool.place(slot, (float(pos[0]), float(pos[1]), float(pos[2])), touchable=True, quat=quat)
        self._world.set_velocity(self._pool.rows[slot], vel, spin)
        self.state.vel[slot] = vel
        self.state.status[slot] = _AWAKE
        self.state.holder[slot] = -1
        self._sleeping.disturb(slot)
        if flying:
            self._flying.start(slot, _vector(vel), _vector(spin), untouched=True)
        self._awake_stale = True
        return slot

    def depth(self, slot: int, pos: Vector, quat: Quaternion) -> float:
        """How deep a held piece would be in what stands on the field [m].

        Args:
            slot: Which piece.
            pos: Center, field frame [m].
            quat: Attitude.
        """
        self._pool.place(slot, pos, touchable=True, quat=quat)
        depth: float = self._world.engine.depth(self._pool.rows[slot])
        self._pool.park(slot)
        return depth

    def is_free(self, slot: int, depth: float) -> bool:
        """Whether a piece that is so deep in what stands on the field [m] can be let go there."""
        return depth < (_SOFT * float(self._pool.radius[slot]) if self._pool.is_ball[slot] else _HARD)

    def score(self, slots: IntArray) -> None:
        """Take scored pieces off the field; what leaned on them wakes.

        Raises:
            ConfigError: A piece is not on the field; nothing has changed.
        """
        self._require("score", slots, ON_FIELD)
        self._wedged.free(slots)
        for slot in slots.tolist():
            self._wake_leaning(slot)
            self._flying.forget(slot)
            self._pool.park(slot)
            self.state.status[slot] = _SCORED
        self._awake_stale = True

    def set_aside(self, slots: IntArray) -> None:
        """Let people keep scored pieces, who will put them on the field again.

        Raises:
            ConfigError: A piece has not scored; nothing has changed.
        """
        self._require("set_aside", slots, (_SCORED,))
        self.state.status[slots] = _STAGED

    def push(self, slots: IntArray, velocities: FloatArray, *, flying: bool = False) -> None:
        """Give pieces on the field a velocity, and wake them.

        Args:
            slots: Which ones.
            velocities: Field frame [m/s], shape (n, 3).
            flying: They are in the air and touch nothing, as after a launch.

        Raises:
            ConfigError: A piece is not on the field.
            NonFiniteError: A velocity is not finite. Either way nothing has changed.
        """
        self._require("push", slots, ON_FIELD, velocities)
        for slot, velocity in zip(slots.tolist(), velocities.tolist(), strict=True):
            self._wake(slot)
            self.state.vel[slot] = velocity
            if flying or self._flying.is_flying[slot]:
                self._flying.push(slot, _vector(velocity), untouched=flying)
            else:
                self._flying.forget(slot)
                self._world.set_velocity(self._pool.rows[slot], velocity)

    def clear(self) -> None:
        """Take all pieces out of the match; none is counted any more."""
        slots = np.nonzero(self.state.status != _FREE)[0]
        for slot in slots.tolist():
            self._flying.forget(slot)
            self._pool.park(slot)
        self.state.status[slots] = _FREE
        self.state.holder[slots] = -1
        self.total = 0
        self._awake_stale = True

    def spare(self, name: str, count: int) -> IntArray:
        """Pieces that could be put on the field; returns their slots.

        Those that have not come into the match yet are staged by it; after them come those that wait off the field, and
        then those that have scored.

        Raises:
            UnknownNameError: No such type.
            CapacityError: Fewer are off the field and in no robot; nothing has changed.
        """
        mine = self.state.kind == self._kind(name)
        slots = np.concatenate([np.nonzero(mine & (self.state.status == s))[0] for s in (_FREE, _STAGED, _SCORED)])
        if len(slots) < count:
            raise CapacityError(
                f"{len(slots)} of the game's {int(mine.sum())} {name} are neither on the field nor in a robot, "
                f"got {count} to put down; resetting the field takes them all back"
            )
        slots = slots[:count]
        self.stage(name, int((self.state.status[slots] == _FREE).sum()))
        return slots

    def put_down(self, slots: IntArray, places: FloatArray) -> None:
        """Put pieces on the carpet, at rest, each at the free place nearest to one that is given.

        Args:
            slots: Which ones.
            places: Field frame [m], shape (n, 2).

        Raises:
            ConfigError: A slot holds no piece; nothing has changed.
        """
        self._require("put_down", slots, _LOOSE)
        for slot, (x, y) in zip(slots.tolist(), places.tolist(), strict=True):
            self._move_to_free_place(slot, (x, y))

    def make_room(self, robots: Sequence[Footprint]) -> None:
        """Move the pieces that stand where a robot has just been put, to the nearest free places beside it.

        Args:
            robots: All of them, where they are now.
        """
        self._robots, self._still = list(robots), 0
        here = self.on_field()
        here = here[self.state.pos[here, 2] < _ROBOT_HEIGHT]
        inside = [robot.gap(self.state.pos[here]) < self._pool.radius[here] for robot in robots]
        for slot in here[np.any(inside, axis=0)].tolist():
            x, y, _ = self.state.pos[slot].tolist()
            self._move_to_free_place(slot, (x, y))

    # --- questions ------------------------------------------------------------------------------------------------

    @property
    def is_untouched(self) -> BoolArray:
        """Which slots were shot and have touched nothing since, shape (n,)."""
        return self._flying.is_untouched

    @property
    def types(self) -> list[GamePieceConfig]:
        """The types, in the order of `PieceState.kind`."""
        return self._pool.types

    def kind_name(self, slot: int) -> str:
        """Name of the kind of a slot's piece."""
        return str(self._pool.types[self.state.kind[slot]].name)

    def row(self, slot: int) -> int:
        """Engine row of a slot's body."""
        return self._pool.rows[slot]

    @property
    def radius(self) -> FloatArray:
        """Bounding radius of each slot's piece [m], shape (n,)."""
        return self._pool.radius

    @property
    def mass(self) -> FloatArray:
        """Of each slot's piece [kg], shape (n,)."""
        return self._pool.mass

    @property
    def size(self) -> FloatArray:
        """Diameter of each slot's piece over that of its kind [-], shape (n,)."""
        return self._pool.size

    def air_of(self, slot: int) -> AirFactors:
        """What the air does to one piece."""
        return self._pool.air_of(slot)

    def held(self, holder: int) -> IntArray:
        """Slots that a robot holds."""
        return np.nonzero((self.state.status == _HELD) & (self.state.holder == holder))[0]

    def count(self, status: PieceStatus, name: str | None = None) -> int:
        """How many pieces are in a status."""
        mask: BoolArray = self.state.status == status
        if name is not None:
            mask &= self.state.kind == self._kind(name)
        return int(mask.sum())

    # --- inside ---------------------------------------------------------------------------------------------------

    def _require(self, what: str, slots: IntArray, allowed: Sequence[int], rows: FloatArray | None = None) -> None:
        """Check a whole request before the first change."""
        count = len(self.state.status)
        if not (isinstance(slots, np.ndarray) and slots.ndim == 1 and np.issubdtype(slots.dtype, np.integer)):
            raise ConfigError(f"{what}: pieces must be an array of whole numbers, shape (n,), got {shown(slots)}")
        if ((slots < 0) | (slots >= count)).any() or len(np.unique(slots)) < len(slots):
            raise ConfigError(f"{what}: pieces must be different numbers from 0 to {count - 1}, got {shown(slots)}")
        wrong = slots[~np.isin(self.state.status[slots], allowed)]
        if len(wrong):
            status = PieceStatus(int(self.state.status[wrong[0]])).name
            names = [PieceStatus(value).name for value in allowed]
            raise ConfigError(f"{what}: piece {int(wrong[0])} is {status}, it must be one of {names}")
        if rows is not None and not (np.shape(rows) == (len(slots), 3) and np.isfinite(rows).all()):
            raise NonFiniteError(f"{what}: {len(slots)} rows of three finite numbers are needed, got {rows}")

    def _require_support(self, name: str, positions: FloatArray) -> None:
        """Check that there is something that new pieces of a kind can lie on."""
        reach = self._pool.types[self._kind(name)].bounding_radius + _BESIDE
        others = self.on_field()
        is_near = self._world.near_field(positions, np.full(len(positions), reach)) | (positions[:, 2] < reach)
        for place, near in zip(positions, is_near.tolist(), strict=True):
            away = np.linalg.norm(self.state.pos[others] - place, axis=1)
            if not (near or (away < reach + self._pool.radius[others]).any()):
                raise ConfigError(
                    f"{name}: a piece at {place.tolist()} m has nothing to rest on; stage what is below it before it, "
                    "or let it fall"
                )


def _vector(row: Sequence[float]) -> Vector:
    return float(row[0]), float(row[1]), float(row[2])


def _quaternions(what: str, attitudes: FloatArray | None, count: int) -> list[Quaternion]:
    """Unit quaternions x, y, z, w of some pieces, checked."""
    if attitudes is None:
        return [IDENTITY] * count
    rows = np.asarray(attitudes, dtype=float)
    if rows.shape != (count, 4) or not np.allclose(np.linalg.norm(rows, axis=-1), 1.0, atol=1e-6):
        raise ConfigError(f"{what}: {count} unit quaternions x, y, z, w are needed as attitudes, got {attitudes}")
    return [(x, y, z, w) for x, y, z, w in rows.tolist()]
