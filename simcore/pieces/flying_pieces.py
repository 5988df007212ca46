"""Pieces that fly: ours, not the engine's, until they come to lie on something.

A FLYING piece moves by gravity, drag and spin lift, to second order whatever the length of a part of the tick, so that
a shot needs no steps of the engine and changes nobody else's. Balls have their impacts at their instant, by
`impact_events`; they are handed to the engine (IN CONTACT) at the end of the tick in which they no longer leave what
they hit. Other shapes are handed over as soon as they may reach anything within a tick, and play their impacts there.
What the engine throws up is taken over when it falls freely.

Balls in contact that are much faster than the engine's steps have their impacts on other balls here, too: a knock goes
along a row of balls in the order of its impacts.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from simcore.geometry.rotation import Vector, matrix, multiply
from simcore.physics.mass_properties import mass_properties
from simcore.physics.world import PhysicsWorld
from simcore.pieces.aerodynamics import AirRows, drag_acceleration
from simcore.pieces.flight import advance
from simcore.pieces.impact_events import LEAST_BOUNCE, Arc, BallRows, ImpactEvents
from simcore.pieces.pool import PiecePool, PieceStatus
from simcore.pieces.touching import TOUCH, close_pairs, lengths, touching_chain
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["FlyingPieces"]

_IN_FLIGHT, _AWAKE = int(PieceStatus.IN_FLIGHT), int(PieceStatus.AWAKE)
_FALL_ERROR = 0.2  # share of gravity that drag and lift may be
_TAKE_OVER = 1.0  # [m/s]; pieces that are thrown up more gently, by 5 cm, stay the engine's
_SKIN = 0.002  # [m]
_OVERLAP = 0.0005  # [m]; a flying ball that is deeper in another piece lies on it
_DEEP = 0.01  # [m]; one that is deeper in the floor is the engine's, which pushes it out
_MARGIN = 0.01  # [m]; between other shapes that fly and all else
_FAST, _SLOW = 6.0, 3.0  # [m/s]; faster balls in contact have their impacts on others here; once they were hit, these
_STANDS = 0.05  # [m/s]; slower balls are where they were at the start of the tick, until they are hit
_KNOCK_REACH, _KNOCK_WAYS = 0.3, 4.0  # [m] and ways of a tick, as far as a knock may get from a fast ball in a tick
_KNOCK_LENGTH = 20  # balls of a row, each of which takes a third of the knock
_SLOW_WAY = 0.5  # of a radius, in a part of a tick
_LEAST_SPIN = 1e-6  # [rad/s]


class FlyingPieces:
    """The pieces that fly, in arrays, and what they hit.

    Args:
        world: Where the bodies of the others live.
        pool: The pieces.
        wake: Lets a sleeping piece move: called with its slot.
        changed: Called when a piece comes to fly, or no longer does.
    """

    def __init__(
        self, world: PhysicsWorld, pool: PiecePool, wake: Callable[[int], None], changed: Callable[[], None]
    ) -> None:
        self._world = world
        self._pool = pool
        self._wake = wake
        self._changed = changed
        self._events = ImpactEvents(world, pool)
        n, kinds = len(pool.rows), pool.state.kind
        self._pos, self._vel, self._spin = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3))
        self._quat = np.tile((0.0, 0.0, 0.0, 1.0), (n, 1))
        self._lift = np.array([air.lift for air in pool.air])[kinds] * pool.lift_share
        self._saturation = np.array([air.lift_saturation for air in pool.air])[kinds]
        self._aero_speed = np.array([kind.aero_speed for kind in pool.types])[kinds]
        self._inertia = [mass_properties(kind.shape).inertia for kind in pool.types]
        self._has_others = not bool(pool.is_ball.all())
        self.is_flying: BoolArray = np.zeros(n, dtype=bool)
        """Which slots fly, shape (slots,)."""
        self.is_untouched: BoolArray = np.zeros(n, dtype=bool)
        """Which of them were shot and have touched nothing since, shape (slots,)."""
        self._is_landing = np.zeros(n, dtype=bool)
        self._was_hit = np.zeros(n, dtype=bool)
        self._slots: IntArray = np.zeros(0, dtype=np.int64)  # of those that fly
        self._near: IntArray = np.zeros(0, dtype=np.int64)  # balls that may be hit in this tick
        self._moves: BoolArray = np.zeros(0, dtype=bool)  # of those
        self._has_movers = False
        self._pending: dict[int, tuple[Vector, Vector]] = {}
        self._blown: IntArray = np.zeros(0, dtype=np.int64)  # in contact, and fast enough for drag

    # --- into and out of the air ----------------------------------------------------------------------------------

    def start(self, slot: int, vel: Vector, spin: Vector, *, untouched: bool = False) -> None:
        """Let a piece fly from where its body is.

        Args:
            slot: Which piece.
            vel: [m/s]
            spin: [rad/s]
            untouched: It was shot just now.
        """
        pos, quat = self._world.engine.pose(self._pool.rows[slot])
        self._start(slot, pos, vel, spin)
        self._quat[slot] = quat
        self.is_untouched[slot] = untouched

    def push(self, slot: int, vel: Vector, *, untouched: bool) -> None:
        """Give a piece that flies a velocity [m/s], or let one fly with it; it has no spin."""
        if self.is_flying[slot]:
            self._vel[slot], self._spin[slot] = vel, 0.0
            self.is_untouched[slot] = untouched
        else:
            self.start(slot, vel, (0.0, 0.0, 0.0), untouched=untouched)

    def _start(self, slot: int, pos: Vector, vel: Vector, spin: Vector) -> None:
        self._pending.pop(slot, None)
        self._pos[slot], self._vel[slot], self._spin[slot] = pos, vel, spin
        self.is_flying[slot] = True
        self._pool.state.status[slot] = _IN_FLIGHT
        self._pool.set_touchable(slot, False)
        self._world.engine.fix(self._pool.rows[slot])
        self._renew()

    def forget(self, slot: int) -> None:
        """A piece was put elsewhere: what it was about to do is of no use."""
        self._pending.pop(slot, None)
        if self.is_flying[slot]:
            self.is_flying[slot] = self.is_untouched[slot] = self._is_landing[slot] = False
            self._renew()

    def _land(self, slots: IntArray) -> None:
        """Hand pieces over to the engine as they are."""
        world, state = self._world, self._pool.state
        for slot in slots.tolist():
            row = self._pool.rows[slot]
            world.set_pose(row, self._pos[slot].tolist(), tuple(self._quat[slot].tolist()))
            world.set_velocity(row, self._vel[slot].tolist(), self._spin[slot].tolist())
            self.forget(slot)
            state.status[slot] = _AWAKE
            self._pool.set_touchable(slot, True)

    def _renew(self) -> None:
        self._slots = self.is_flying.nonzero()[0]
        self._changed()

    def quats(self, slots: IntArray) -> FloatArray:
        """Attitudes of pieces that fly, x, y, z, w, shape (n, 4)."""
        return self._quat[slots]

    def is_clear(self, slot: int, pos: Vector) -> bool:
        """Whether a piece at a place touches nothing, so that it can fly from there."""
        place, reach = np.array([pos]), np.array([float(self._pool.radius[slot]) + TOUCH])
        return not bool(self._is_close(np.array([slot]), place, reach)[0])

    # --- once a tick ----------------------------------------------------------------------------------------------

    def land_early(self, dt: float) -> None:
        """Before a tick: hand over those whose impacts the engine plays, if they may reach anything within it [s]."""
        slots = self._slots
        if not len(slots):
            return
        is_ball = self._pool.is_ball[slots]
        reach = self._pool.radius[slots] + lengths(self._vel[slots]) * dt + self._world.gravity * dt * dt + _MARGIN
        close = self._world.near_hanging(self._pos[slots], reach)
        close |= self._pos[slots, 2] < self._pool.radius[slots] * is_ball - _DEEP
        if self._has_others:
            others = (~is_ball).nonzero()[0]
            close[others] |= self._is_close(slots[others], self._pos[slots[others]], reach[others])
            shapes = (self._pool.is_on_field & ~self._pool.is_ball).nonzero()[0]
            i, _, _ = self._within(slots, self._pos[slots], reach + self._speeds(shapes) * dt, shapes)
            close[i] = True
        self._land(slots[close])

    def _speeds(self, slots: IntArray) -> float:
        """Fastest of some pieces [m/s]."""
        return float(lengths(self._pool.state.vel[slots]).max(initial=0.0))

    def _is_close(self, slots: IntArray, pos: FloatArray, reach: FloatArray) -> BoolArray:
        """Which places of pieces have the floor, the field, a robot or another piece within reach, shape (n,)."""
        close = self._world.near_field(pos, reach)
        if self._world.floor is not None:
            close |= pos[:, 2] < reach
        for row, body in self._world.robot_bodies.items():
            away = pos - np.array(self._world.engine.pose(row)[0])
            close |= lengths(away) < reach + body.reach
        i, _, _ = self._within(slots, pos, reach, self._pool.is_on_field.nonzero()[0])
        close[i] = True
        return close

    def _within(
        self, slots: IntArray, pos: FloatArray, reach: FloatArray, others: IntArray
    ) -> tuple[IntArray, IntArray, FloatArray]:
        """Rows of places of pieces and of other pieces within reach of each other's surface, and how near [m]."""
        there, radius = self._pool.state.pos[others], self._pool.radius
        i, j, away2 = close_pairs(pos, there, reach + radius[others].max(initial=0.0))
        gap = np.sqrt(np.maximum(away2, 0.0)) - radius[others[j]] - reach[i]
        near = (gap < 0.0) & (slots[i] != others[j])
        return i[near], j[near], gap[near]

    def begin_tick(self, awake: IntArray, speed: FloatArray, busy: BoolArray, dt: float) -> None:
        """Find the balls that may be hit fast within a tick.

        Args:
            awake: Slots that the engine moves, shape (n,).
            speed: Of each [m/s], shape (n,).
            busy: Which slots are within reach of a robot: the engine plays their impacts on others, shape (slots,).
            dt: Length of the tick [s].
        """
        state, radius, is_ball = self._pool.state, self._pool.radius, self._pool.is_ball
        self._blown = awake[speed > self._aero_speed[awake]]
        is_fast = speed > _FAST
        is_fast |= (speed > _SLOW) & self._was_hit[awake]
        rolling = awake[is_fast & is_ball[awake] & ~busy[awake]]
        flying = self._slots[is_ball[self._slots]]
        fast = np.concatenate((rolling, flying))
        self._was_hit[:] = False
        self._near, self._has_movers = self._near[:0], False
        if not len(fast):
            return
        pos, way = state.pos[fast], np.concatenate((state.vel[rolling], self._vel[flying])) * dt
        pos[len(rolling) :] = self._pos[flying]
        length = lengths(way)
        reach = (_KNOCK_REACH + _KNOCK_WAYS * length)[:, None]
        others = (self._pool.is_on_field & is_ball & ~self.is_flying).nonzero()[0]
        there = state.pos[others]
        others = others[((there > (pos - reach).min(axis=0)) & (there < (pos + reach).max(axis=0))).all(axis=1)]
        away = state.pos[others][None, :, :] - pos[:, None, :]
        along = np.clip(np.einsum("ijk,ik->ij", away, way) / np.maximum(length * length, 1e-12)[:, None], 0.0, 1.0)
        aside = away - along[:, :, None] * way[:, None, :]
        moves = lengths(state.vel[others]) * dt
        touch = radius[fast][:, None] + (radius[others] + moves)[None, :] + TOUCH + self._world.gravity * dt * dt
        meets = (np.einsum("ijk,ijk->ij", aside, aside) < touch * touch) & (fast[:, None] != others[None, :])
        if meets.any():
            # the engine plays gentler impacts along a row, within the tick
            reached = touching_chain(state.pos[others], radius[others], meets.any(axis=0), _KNOCK_LENGTH)
            for slot in others[reached & self._pool.is_frozen[others]].tolist():
                self._wake(slot)
            within = np.unique(close_pairs(pos, state.pos[others], reach[:, 0])[1])
            self._near, self._moves = others[within], moves[within] > _STANDS * dt
            self._has_movers = bool(meets[: len(rolling)].any())

    def end_tick(self, dt: float) -> None:
        """After a tick: balls that came to lie on something are the engine's from now on."""
        self._finish()
        slots = self._slots
        if not len(slots):
            return
        self._turn(slots, dt)
        landing = self._is_landing[slots] & (self._pool.is_ball[slots])
        if len(self._near):
            left = self._near[~self.is_flying[self._near]]
            i, _, gap = self._within(slots, self._pos[slots], self._pool.radius[slots], left)
            landing[i[gap < -_OVERLAP]] = True
        self._land(slots[landing])

    def positions(self, slots: IntArray) -> FloatArray:
        """Where pieces that fly are [m], shape (n, 3)."""
        return self._pos[slots]

    def take_over(self, awake: IntArray, speed: FloatArray, before: FloatArray, dt: float) -> None:
        """Let pieces fly that fall freely: gravity and nothing else changed their mean velocity from tick to tick.

        Args:
            awake: Slots that the engine moves, shape (n,).
            speed: Mean vertical velocity of each in this tick [m/s], shape (n,).
            before: The same in the tick before.
            dt: Length of a tick [s].
        """
        fall = self._world.gravity * dt
        is_free = (np.abs(speed - before + fall) < _FALL_ERROR * fall) & (np.abs(speed) > _TAKE_OVER)
        engine = self._world.engine
        for slot in awake[is_free].tolist():
            row, radius = self._pool.rows[slot], float(self._pool.radius[slot])
            reach = radius + 2.0 * (float(lengths(self._pool.state.vel[slot][None])[0]) * dt + _MARGIN)
            place = self._pool.state.pos[slot][None]
            if self._pool.is_ball[slot]:
                is_close = bool(engine.touching(row)) or bool(self._world.near_hanging(place, np.array([reach]))[0])
            else:
                is_close = bool(self._is_close(np.array([slot]), place, np.array([reach]))[0])
            if not is_close:
                self.start(slot, *engine.velocity(row))

    # --- once a part of a tick ------------------------------------------------------------------------------------

    def fly(self, h: float) -> None:
        """Move on by h [s], before the engine does."""
        self._finish()
        self._blow()
        slow = lengths(self._vel[self._slots]) * h < _SLOW_WAY * self._pool.radius[self._slots]
        self._land(
            self._slots[slow & self._is_landing[self._slots]]
        )  # faster ones wait for a tick with steps short enough
        slots = self._slots
        if not (len(slots) or self._has_movers):
            return
        pos, vel, spin = self._pos[slots], self._vel[slots], self._spin[slots]
        air = AirRows(drag=self._pool.drag[slots], lift=self._lift[slots], lift_saturation=self._saturation[slots])
        end, after = advance(pos, vel, spin, air, h, gravity=self._world.gravity)
        self._pos[slots], self._vel[slots] = end, after
        self._play(h, slots, pos, vel, end, (after - vel) / h)

    def _blow(self) -> None:
        """Drag on fast pieces in contact, for the part to come."""
        if len(self._blown):
            slots = self._blown[self._pool.state.status[self._blown] == _AWAKE]
            rows = self._pool.rows_of(slots)
            drag = drag_acceleration(self._world.engine.velocities(rows)[:, :3], self._pool.drag[slots])
            self._world.engine.apply_forces(rows, self._pool.mass[slots][:, None] * drag)

    def _play(
        self, h: float, slots: IntArray, pos: FloatArray, vel: FloatArray, end: FloatArray, acc: FloatArray
    ) -> None:
        """Play the impacts of the part to come; who has none is at its end already."""
        radius = self._pool.radius[slots]
        way = lengths(end - pos)
        near_field = self._world.near_field(pos, radius + way + _SKIN)
        meets = near_field.copy()
        if self._world.floor is not None:
            meets |= (end[:, 2] < radius) | (pos[:, 2] < radius)
        robots = []
        for row, body in self._world.robot_bodies.items():
            if len(slots):
                speed = math.hypot(*self._world.engine.velocity(row)[0])
                away = pos - np.array(self._world.engine.pose(row)[0])
                close = lengths(away) < body.reach + radius + way + speed * h + _SKIN
                if np.count_nonzero(close):
                    robots.append(row)
                    meets |= close
        near = self._near[~self.is_flying[self._near]]
        moves = self._moves[~self.is_flying[self._near]] | self._was_hit[near]
        if len(near) and len(slots):
            room = radius + way + _SKIN + _KNOCK_REACH * self._has_movers + self._speeds(near) * h
            i, _, _ = self._within(slots, pos, room, near)
            meets[i] = True
            if not (len(i) or self._has_movers):
                near = near[:0]
        if len(slots) > 1:
            i, j, away2 = close_pairs(pos, pos, 2.0 * (radius + way + _SKIN))
            i, j, away2 = i[i < j], j[i < j], away2[i < j]
            room = radius[i] + radius[j] + lengths(((vel[i] - vel[j]) + 0.5 * h * (acc[i] - acc[j])) * h) + _SKIN
            i, j = i[away2 < room * room], j[away2 < room * room]
            meets[i] = meets[j] = True
        meets &= self._pool.is_ball[slots]
        if not (np.count_nonzero(meets) or (len(near) and self._has_movers)):
            return
        there, twists = self._lying(near, moves[: len(near)])
        mine = slots[meets]
        balls = BallRows(
            slots=np.concatenate((mine, near)),
            pos=np.concatenate((pos[meets], there)),
            vel=np.concatenate((vel[meets], twists[:, :3])),
            spin=np.concatenate((self._spin[mine], twists[:, 3:])),
            acc=acc[meets],
            is_landing=self._is_landing[mine].tolist(),
            near_field=near_field[meets].tolist(),
        )
        for arc in self._events.play(h, balls, robots):
            self._go_on(arc, h)

    def _lying(self, near: IntArray, moves: BoolArray) -> tuple[FloatArray, FloatArray]:
        """Where balls in contact are that may be hit [m], shape (n, 3), and their velocities, shape (n, 6)."""
        pos, twists = self._pool.state.pos[near], np.zeros((len(near), 6))
        rows = self._pool.rows_of(near[moves])
        if rows:
            pos[moves], twists[moves] = self._world.engine.centers(rows), self._world.engine.velocities(rows)
        return pos, twists

    def _go_on(self, arc: Arc, h: float) -> None:
        """Keep how a ball goes on after its impacts."""
        slot, end, vel = arc.slot, arc.at(h), arc.velocity(h)
        self._was_hit[slot] = True
        if arc.is_flying:
            self._pos[slot], self._vel[slot], self._spin[slot] = end, vel, arc.spin
            self.is_untouched[slot] = False
            self._is_landing[slot] = arc.is_landing
            return
        self._wake(slot)
        engine, row = self._world.engine, self._pool.rows[slot]
        if vel[2] > LEAST_BOUNCE:
            quat = engine.pose(row)[1]
            self._start(slot, end, vel, arc.spin)
            self._quat[slot] = quat
            return
        # it goes straight to where it is at the end, and then has the velocity that it has there
        line = [(b - a) / h for a, b in zip(engine.pose(row)[0], end, strict=True)]
        engine.set_velocity(row, line, arc.spin)
        self._has_movers = True
        self._pending[slot] = (vel[0] - line[0], vel[1] - line[1], vel[2] - line[2]), arc.spin

    def _finish(self) -> None:
        """Give the lying balls that were hit in the last part the velocities that they have after it.

        Pushes from elsewhere in that part add to them.
        """
        engine, rows = self._world.engine, self._pool.rows
        for slot, (change, spin) in self._pending.items():
            vel, _ = engine.velocity(rows[slot])
            engine.set_velocity(rows[slot], (vel[0] + change[0], vel[1] + change[1], vel[2] + change[2]), spin)
        self._pending.clear()

    def _turn(self, slots: IntArray, dt: float) -> None:
        """Attitudes after a tick of free rotation: balls keep their spin, others their angular momentum."""
        turning = slots[lengths(self._spin[slots]) > _LEAST_SPIN]
        for slot in turning[~self._pool.is_ball[turning]].tolist():
            inertia = self._inertia[self._pool.state.kind[slot]]
            q, spin = tuple(self._quat[slot].tolist()), self._spin[slot]
            axes = matrix(q)
            momentum = axes @ inertia @ axes.T @ spin
            for share in (0.5, 1.0):  # the spin of the middle of the tick
                now = multiply(_turned(spin * (share * dt)), q)
                axes = matrix(now)
                spin = axes @ np.linalg.solve(inertia, axes.T @ momentum)
            self._quat[slot], self._spin[slot] = now, spin
        for slot in turning[self._pool.is_ball[turning]].tolist():
            self._quat[slot] = multiply(_turned(self._spin[slot] * dt), self._quat[slot].tolist())


def _turned(angle: FloatArray) -> tuple[float, float, float, float]:
    """The rotation by a vector [rad], as a unit quaternion x, y, z, w."""
    size = max(math.sqrt(float(angle @ angle)), 1e-300)
    x, y, z = (math.sin(0.5 * size) / size * angle).tolist()
    return x, y, z, math.cos(0.5 * size)
