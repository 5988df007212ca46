"""The pieces that move: who is awake and who sleeps, and what they do in a tick.

Only what can move is simulated. A piece sleeps when it has been slow for a while: under gravity nothing stays slow in
the air, so a sleeper is always supported. It wakes before anything can reach it: each tick, before the engine moves,
everything that moves wakes the sleepers within its reach, and shows the pieces of whole chunks to the engine. Inside
a tick the engine itself wakes what is touched (a row of touching balls passes a knock on at once).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from simcore.errors import UnknownNameError
from simcore.geometry.rotation import IDENTITY, Quaternion
from simcore.physics.substeps import TickPlan
from simcore.physics.world import PhysicsWorld
from simcore.pieces.approach import Approach
from simcore.pieces.flying_pieces import FlyingPieces
from simcore.pieces.free_places import free_place
from simcore.pieces.kinds import GamePieceConfig, PieceVariation
from simcore.pieces.pool import ON_FIELD, PiecePool, PieceStatus, ShownPieces
from simcore.pieces.reach import ChunkGrid, Footprint, WakeSettings, lengths
from simcore.pieces.resting_places import RestingPlace, RestingPlaces
from simcore.pieces.sleeping import SETTLE_PERIOD, Sleeping, WedgedPieces
from simcore.pieces.squeezing import Squeezing
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["MovingPieces"]

_KNOCK_TICKS = 3.0  # how much farther the field is shown to the engine: a row of balls passes a knock on within a tick
_STANDING = 1e-5  # [m/s]; the engine leaves a robot that stands 1e-8
_SORTED = 15  # ticks after which sleepers that nothing can touch are fixed
_ASLEEP, _AWAKE, _IN_FLIGHT, _PLACED = (
    int(status) for status in (PieceStatus.ASLEEP, PieceStatus.AWAKE, PieceStatus.IN_FLIGHT, PieceStatus.PLACED)
)
_ZERO = (0.0, 0.0, 0.0)


class MovingPieces:
    """The pieces of a world and how they move.

    Args:
        world: Where the bodies live.
        types: Each type with the most pieces of it that there can be.
        field_size: Length and width [m]; pieces that come to rest beyond it, or are 0.5 m beyond it, are brought back.
        wake: When pieces wake and sleep.
        places: Where pieces stay and count.
        variation: By which factors pieces differ from their kind; None: not at all.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        types: Sequence[tuple[GamePieceConfig, int]],
        *,
        field_size: tuple[float, float],
        wake: WakeSettings | None = None,
        places: Sequence[RestingPlace] = (),
        variation: PieceVariation | None = None,
    ) -> None:
        self._world = world
        self._p = wake or WakeSettings()
        self._field_size = field_size
        self._kinds = {config.name: kind for kind, (config, _) in enumerate(types)}
        self._pool = PiecePool(world, list(types), variation)
        self.state = self._pool.state
        n = len(self._pool.rows)
        self._chunks = ChunkGrid(
            (-1.0, -1.0),
            (field_size[0] + 1.0, field_size[1] + 1.0),
            size=self._p.chunk_size,
            linger=self._p.chunk_linger,
        )
        self._chunk = np.zeros(n, dtype=np.int64)
        self._approach = Approach(world, self._pool)
        self._flying = FlyingPieces(world, self._pool, self._wake, self._forget_awake)
        self._squeezing = Squeezing(world, self._pool)
        self._wedged = WedgedPieces(world, self._pool)
        self.places = RestingPlaces(places, self._pool)
        """Where pieces stay and count."""
        self._sleeping = Sleeping(world, self._pool, self._p, self._wake)
        self.shown = ShownPieces(self._pool, self.attitudes)
        """What the pieces on the field look like."""
        self._still = 0  # ticks since something moved
        self._quats = np.tile((1.0, 0.0, 0.0, 0.0), (n, 1))
        self._awake: IntArray = np.zeros(0, dtype=np.int64)
        self._in_contact: IntArray = np.zeros(0, dtype=np.int64)
        self._contact_rows: list[int] = []
        self._awake_stale = True
        self._outer = np.array([(-0.5, -0.5, -0.5), (field_size[0] + 0.5, field_size[1] + 0.5, 30.0)])
        self._robots: list[Footprint] = []
        self.out_of_field: Callable[[int], bool] | None = None
        """Told of each piece that has left the field; False: it is put back at once. True: it has taken the piece."""
        self._tick = 0
        self.total = 0
        """How many pieces have come into the match."""
        self.recovered = 0
        """How many times a piece was brought back from outside the field."""

    # --- questions ------------------------------------------------------------------------------------------------

    @property
    def awake(self) -> IntArray:
        """Slots that move: those that fly and those in contact, which the engine moves."""
        if self._awake_stale:
            status = self.state.status
            self._awake = ((status == _AWAKE) | (status == _IN_FLIGHT)).nonzero()[0]
            self._in_contact = (status == _AWAKE).nonzero()[0]
            self._contact_rows = self._pool.rows_of(self._in_contact)
            self._awake_stale = False
        return self._awake

    @property
    def moving_rows(self) -> list[int]:
        """Engine rows of the pieces `in_contact`."""
        return self._contact_rows if len(self.in_contact) else []

    @property
    def in_contact(self) -> IntArray:
        """Slots that the engine moves."""
        self.awake  # noqa: B018  (brings both up to date)
        return self._in_contact

    @property
    def in_active_chunks(self) -> IntArray:
        """Slots on the field in active chunks and in the air: all that anything that moves could meet."""
        return np.nonzero(self.state.touchable | self._flying.is_flying)[0]

    @property
    def is_on_field(self) -> BoolArray:
        """Whether each slot is on the field or in the air, shape (n,)."""
        return self._pool.is_on_field

    def on_field(self, name: str | None = None) -> IntArray:
        """Slots on the field or in the air, of one type or all."""
        here = self.is_on_field
        if name is not None:
            here &= self.state.kind == self._kind(name)
        return np.nonzero(here)[0]

    def attitudes(self, slots: IntArray) -> FloatArray:
        """Attitudes w, x, y, z, shape (n, 4); of a piece that is off the field, the last it had there."""
        status = self.state.status[slots]
        pose, rows = self._world.engine.pose, self._pool.rows
        for slot in slots[status == _AWAKE].tolist():
            x, y, z, w = pose(rows[slot])[1]
            self._quats[slot] = w, x, y, z
        flying = slots[status == _IN_FLIGHT]
        if len(flying):
            self._quats[flying] = self._flying.quats(flying)[:, [3, 0, 1, 2]]
        return self._quats[slots]

    # --- one tick -------------------------------------------------------------------------------------------------

    def begin_tick(self, robots: Sequence[Footprint], dt: float) -> TickPlan:
        """Before the engine moves: wake what can be reached within dt [s], and say how finely that must be stepped.

        Args:
            robots: All that moves and is no piece.
            dt: Length of the tick [s].
        """
        state, p, chunks = self.state, self._p, self._chunks
        self._robots = list(robots)
        awake = self.awake
        is_moving = len(awake) > 0 or any([robot.speed >= _STANDING for robot in robots])
        self._still = 1 if is_moving else self._still + 1
        if self._is_idle:
            return TickPlan()
        self._flying.land_early(dt)
        awake = self.awake
        speed = lengths(state.vel.take(awake, axis=0))
        fall = self._world.gravity * dt  # what gravity can add within the tick
        reach = (speed + fall) * dt + 2.0 * self._pool.radius[awake] + p.piece_margin
        for robot in robots:
            half_diagonal = math.hypot(robot.half_length, robot.half_width)
            chunks.mark_box(robot.x, robot.y, half_diagonal + robot.speed * dt + 2.0 * p.margin + 0.5)
        if len(awake):
            chunks.mark(state.pos.take(awake, axis=0), reach + _KNOCK_TICKS * dt * speed)
        self._apply_chunks(*chunks.update(), dt)

        touching = state.status[awake] == _AWAKE
        for slot in self._sleeping.choose(awake[touching], speed[touching], reach[touching], robots, dt).tolist():
            self._wake(slot)
        self._flying.begin_tick(self._sleeping.guarded, dt)
        now = self.in_contact
        speed = lengths(state.vel.take(now, axis=0))
        longest = self._squeezing.longest_step(now, robots, dt)
        if self._approach.has_fine:
            longest = min(longest, self._approach.longest_step(now))
        return TickPlan(
            piece_speed=float(speed.max()) + fall if len(speed) else 0.0,
            longest_step=longest,
        )

    def before_substep(self, h: float) -> None:
        """Move the pieces that fly by h [s], and prepare the others for the engine's step of the same length."""
        if self._approach.is_needed:
            self._approach.finish()
        self._flying.fly(h)
        if self._wedged.is_used:
            self._wedged.hold(h, self.awake)
        if self._approach.is_needed:
            self.awake  # noqa: B018  (brings the rows up to date)
            self._approach.begin_step(h, self._contact_rows)

    def gather(self, dt: float) -> None:
        """After the engine moved: read where the awake pieces are, once."""
        if self._approach.is_needed:
            self._approach.finish()
        state = self.state
        awake = self.awake
        if len(awake):
            is_flying = self._flying.is_flying[awake]
            moved, now = self._in_contact, self._world.engine.centers(self._contact_rows)
            if len(moved) < len(awake):
                there, now = now, np.empty((len(awake), 3))
                now[is_flying] = self._flying.positions(awake[is_flying])
                now[~is_flying] = there
            before = state.before[awake] = state.pos.take(awake, axis=0)
            vel = (now - before) / dt
            rise = state.vel[moved, 2]
            state.pos[awake], state.vel[awake] = now, vel
            self._pool.changes += 1
            self._flying.end_tick(dt)
            self._flying.take_over(moved, state.vel[moved, 2], rise, dt)
            self._recover(awake, now)
        self._squeezing.read(awake, dt)
        self._tick += 1
        if not self._is_idle:
            self._sleeping.read(dt)

    def settle(self) -> None:
        """Put to sleep what has been slow for long enough; looks at every second tick, which costs half."""
        state, awake = self.state, self.in_contact
        if self._tick % SETTLE_PERIOD or not len(awake):
            return
        ready = self._sleeping.at_rest(awake)
        if len(ready):
            x, y = state.pos[ready, 0], state.pos[ready, 1]
            out = (x < 0.0) | (x > self._field_size[0]) | (y < 0.0) | (y > self._field_size[1])
            if out.any():  # behind a wall, or on top of it
                self._put_back(ready[out])
                ready = ready[~out]
            self._fall_asleep(ready)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _kind(self, name: str) -> int:
        if name not in self._kinds:
            raise UnknownNameError("game piece type", name, self._kinds)
        return self._kinds[name]

    @property
    def _is_idle(self) -> bool:
        """Whether nothing has moved for so long that nothing needs to be looked for."""
        return self._still > self._p.chunk_linger + _SORTED

    def _forget_awake(self) -> None:
        self._awake_stale = True

    def _apply_chunks(self, woken: BoolArray, quiet: BoolArray, dt: float) -> None:
        """Show the sleepers of woken chunks to the engine and hide those of quiet ones."""
        if not (np.count_nonzero(woken) or np.count_nonzero(quiet)):
            return
        asleep = np.nonzero(self._pool.is_frozen)[0]
        chunk = self._chunk[asleep]
        for slot in asleep[woken[chunk]].tolist():
            self._pool.set_touchable(slot, True)
        hide = asleep[quiet[chunk]]
        for slot in self._sleeping.follow(hide, dt).tolist():  # one that the engine woke would fall through
            self._pool.set_touchable(slot, False)
            self._sleeping.stop(slot)

    def _wake(self, slot: int) -> None:
        if self.state.status[slot] in (_ASLEEP, _PLACED):
            self.state.status[slot] = _AWAKE
            self._pool.set_touchable(slot, True)
            self._awake_stale = True
        self._sleeping.disturb(slot)
        self._world.engine.wake(self._pool.rows[slot])

    def _wake_leaning(self, slot: int) -> None:
        """Wake the sleepers around a piece that leaves its place on the field: they may have leaned on it."""
        state = self.state
        if state.status[slot] not in ON_FIELD:
            return
        asleep = np.nonzero(self._pool.is_frozen)[0]
        away = state.pos[asleep] - state.pos[slot]
        reach = self._pool.radius[asleep] + 1.5 * self._pool.radius[slot]
        for other in asleep[np.einsum("ij,ij->i", away, away) < reach * reach].tolist():
            if other != slot:
                self._wake(other)

    def _fall_asleep(self, slots: IntArray) -> None:
        self.attitudes(slots)  # as it lies now; a sleeper's is not asked for again
        self.state.status[slots] = _ASLEEP
        self.state.vel[slots] = 0.0
        self._chunk[slots] = chunk = self._chunks.index(self.state.pos[slots])
        for slot, shown in zip(slots.tolist(), self._chunks.active[chunk].tolist(), strict=True):
            self._pool.set_touchable(slot, shown)
            self._sleeping.stop(slot)
        if self.places.places:
            for slot in slots.tolist():
                w, x, y, z = self._quats[slot].tolist()
                self.places.judge(slot, (x, y, z, w), self._world.touches_robot(self._pool.rows[slot]))
        self._awake_stale = True

    def _release(
        self, slots: IntArray, positions: FloatArray, quats: list[Quaternion], *, resting: bool = False
    ) -> None:
        self._wedged.free(slots)
        for slot, pos, quat in zip(slots.tolist(), positions.tolist(), quats, strict=True):
            config = self._pool.types[self.state.kind[slot]]
            if quat == IDENTITY:
                standing = abs(pos[2] - config.rest_height) < 0.002
            else:
                standing = abs(pos[2] - config.rest_height_at(quat)) < 0.002
            standing = resting or (standing and (self._pool.is_ball[slot] or config.stands_at(quat)))
            self._wake_leaning(slot)
            self._flying.forget(slot)
            self._pool.place(slot, (pos[0], pos[1], pos[2]), touchable=not standing, quat=quat)
            self.state.status[slot] = _AWAKE
            self.state.holder[slot] = -1
            self._sleeping.disturb(slot)
            if standing:
                self._fall_asleep(np.array([slot]))
            elif self._flying.is_clear(slot, (pos[0], pos[1], pos[2])):
                self._flying.start(slot, _ZERO, _ZERO)
        self._awake_stale = True

    def _recover(self, awake: IntArray, pos: FloatArray) -> None:
        """Bring back what is far out of the field, or what is no number any more."""
        within = (pos > self._outer[0]) & (pos < self._outer[1])  # False for NaN
        if not within.all():
            self._put_back(awake[~within.all(axis=1)])

    def _put_back(self, slots: IntArray) -> None:
        """Put pieces on the carpet inside the field, nearest to where each left it, at rest."""
        for slot in slots.tolist():
            if self.out_of_field is not None and self.out_of_field(slot):
                continue
            x, y, _ = (0.0 if math.isnan(c) else c for c in self.state.pos[slot].tolist())
            self._move_to_free_place(slot, (x, y))
            self.recovered += 1

    def _move_to_free_place(self, slot: int, near: tuple[float, float]) -> None:
        others = self.on_field()
        place = free_place(
            self._world,
            self._pool.types[self.state.kind[slot]],
            near,
            self.state.pos[others[others != slot]],
            robots=self._robots,
            field_size=self._field_size,
        )
        self._release(np.array([slot]), np.array([place]), [IDENTITY])
