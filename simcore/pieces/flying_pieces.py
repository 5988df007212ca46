"""Pieces that fly: ours, not the engine's, until they come to lie on something.

A FLYING piece moves by gravity, drag and spin lift, to second order whatever the length of a part of the tick, so that
a shot needs no steps of the engine and changes nobody else's. Balls have their impacts at their instant, by
`impact_events`; they are handed to the engine (IN CONTACT) at the end of the tick in which they no longer leave what
they hit. Other shapes are handed over as soon as they may reach anything within a tick, and play their impacts there.
What the engine throws up is taken over when it falls freely.

Balls in contact have their impacts here, too: on each other, on the field and on robots, at their instant and in their
order, so that a knock goes along a row of balls. What closes more gently is the engine's, which lets no ball bounce.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from simcore.geometry.rotation import Vector, matrix, multiply
from simcore.physics.contact_law import ENGINE_SPEED, LANDING_SPEED
from simcore.physics.mass_properties import mass_properties
from simcore.physics.world import HitBody, PhysicsWorld
from simcore.pieces.aerodynamics import AirFactors, drag_acceleration
from simcore.pieces.ball_rows import Arc, BallRows
from simcore.pieces.flight import advance
from simcore.pieces.impact_events import ImpactEvents, is_caught
from simcore.pieces.pool import PiecePool, PieceStatus
from simcore.pieces.reach import TOUCH, close_pairs, lengths
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["FlyingPieces"]

_IN_FLIGHT, _AWAKE = int(PieceStatus.IN_FLIGHT), int(PieceStatus.AWAKE)
_FALL_ERROR = 0.2  # share of gravity that drag and lift may be
_TAKE_OVER = 1.0  # [m/s]; pieces that are thrown up more gently, by 5 cm, stay the engine's
_OVERLAP = 0.0005  # [m]; a flying ball that is deeper in another piece lies on it
_DEEP = 0.01  # [m]; one that is deeper in the floor is the engine's, which pushes it out
_MARGIN = 0.01  # [m]; between other shapes that fly and all else
_MOVES = 0.5 * ENGINE_SPEED  # [m/s]; of two balls that meet, one is faster
_SLOW_WAY = 0.5  # of a radius, in a part of a tick
_LEAST_SPIN = 1e-6  # [rad/s]
_MOST_TURN = 0.2  # [rad], of a piece that is no ball in a step of its free rotation: its energy stays within 0.1 %


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
        self._slots: IntArray = np.zeros(0, dtype=np.int64)  # of those that fly
        self._balls: BallRows | None = None
        self._pending: dict[int, tuple[Vector, Vector]] = {}
        self._blown: IntArray = np.zeros(0, dtype=np.int64)  # in contact, and fast enough for drag
        self._busy: BoolArray = np.zeros(len(pool.rows), dtype=bool)  # within reach of a robot that moves
        self._tick, self._is_due = 0.0, False  # what is left of the tick [s], and whether impacts are to be looked for

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
        close: BoolArray = self._pos[slots, 2] < self._pool.radius[slots] * is_ball - _DEEP
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
        for row, body in self._world.hit_bodies.items():
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

    def begin_tick(self, busy: BoolArray, dt: float) -> None:
        """Begin a tick: impacts are looked for at its first step, when robots have taken in what they hold then.

        Args:
            busy: Which slots are within reach of a robot that moves, shape (slots,).
            dt: Length of the tick [s].
        """
        self._busy, self._tick, self._is_due = busy, dt, True

    def _look(self) -> None:
        """Find the balls that may have impacts within the tick."""
        self._is_due = False
        busy, dt = self._busy, self._tick
        pool, state = self._pool, self._pool.state
        awake = (state.status == _AWAKE).nonzero()[0]
        speed = lengths(state.vel[awake])
        self._blown = awake[speed > self._aero_speed[awake]]
        movers = awake[pool.is_ball[awake] & ((speed > _MOVES) | busy[awake])]
        flying = self._slots[pool.is_ball[self._slots]]
        self._balls = None
        if not (len(movers) or len(flying)):
            return
        slots = (pool.is_on_field & pool.is_ball).nonzero()[0]
        pos, vel = state.pos[slots], np.where(pool.is_frozen[slots, None], 0.0, state.vel[slots])
        is_flying = self.is_flying[slots]
        pos[is_flying], vel[is_flying] = self._pos[flying], self._vel[flying]
        balls = self._balls = BallRows(self._world, pool, slots, self.is_flying, pos, vel, dt)
        movers = balls.number[movers]
        there, reach = balls.pos[movers], balls.reach[movers]
        beside = self._world.near_field(there, reach)
        for row, body in self._world.hit_bodies.items():
            beside |= _near_body(self._world, row, body, there, reach, dt)
        beside |= balls.vel[movers, 2] < -ENGINE_SPEED
        balls.is_beside[movers] = beside

    def end_tick(self, dt: float) -> None:
        """After a tick: balls that came to lie on something are the engine's from now on."""
        self._finish()
        slots = self._slots
        if not len(slots):
            return
        self._turn(slots, dt)
        landing = self._is_landing[slots] & (self._pool.is_ball[slots])
        if self._balls is not None:
            left = self._balls.slots[~self.is_flying[self._balls.slots]]
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
                is_close = bool(engine.touching(row))
            else:
                is_close = bool(self._is_close(np.array([slot]), place, np.array([reach]))[0])
            if not is_close:
                self.start(slot, *engine.velocity(row))

    # --- once a part of a tick ------------------------------------------------------------------------------------

    def fly(self, h: float) -> None:
        """Move on by h [s], before the engine does."""
        self._finish()
        if self._is_due:
            self._look()
        self._blow()
        slow = lengths(self._vel[self._slots]) * h < _SLOW_WAY * self._pool.radius[self._slots]
        self._land(
            self._slots[slow & self._is_landing[self._slots]]
        )  # faster ones wait for a tick with steps short enough
        slots = self._slots
        if not (len(slots) or self._balls is not None):
            return
        pos, vel, spin = self._pos[slots], self._vel[slots], self._spin[slots]
        air = AirFactors(self._pool.drag[slots], self._lift[slots], self._saturation[slots])
        end, after = advance(pos, vel, spin, air, h, gravity=self._world.gravity)
        self._pos[slots], self._vel[slots] = end, after
        self._tick = max(self._tick, h)
        self._play(h, slots, pos, vel, (after - vel) / h)
        self._tick -= h

    def _blow(self) -> None:
        """Drag on fast pieces in contact, for the part to come."""
        if len(self._blown):
            slots = self._blown[self._pool.state.status[self._blown] == _AWAKE]
            rows = self._pool.rows_of(slots)
            drag = drag_acceleration(self._world.engine.velocities(rows)[:, :3], self._pool.drag[slots])
            self._world.engine.apply_forces(rows, self._pool.mass[slots][:, None] * drag)

    def _play(self, h: float, slots: IntArray, pos: FloatArray, vel: FloatArray, acc: FloatArray) -> None:
        """Play the impacts of the part to come; who has none is at its end already."""
        flies = self._pool.is_ball[slots]
        slots, pos, vel, acc = slots[flies], pos[flies], vel[flies], acc[flies]
        balls = self._balls
        if balls is None or (balls.number[slots] < 0).any():
            self._look()
            balls = self._balls
        if balls is None:
            return
        numbers = balls.number[slots]
        balls.begin_part(h, numbers, pos, vel, self._spin[slots], acc)
        for arc in self._events.play(h, balls, numbers):
            self._go_on(arc, h)
        for slot in self._events.pressed:
            self._wake(slot)

    def _go_on(self, arc: Arc, h: float) -> None:
        """Keep how a ball goes on after its impacts."""
        slot, end, vel = arc.slot, arc.at(h), arc.velocity(h)
        if arc.is_flying:
            self._pos[slot], self._vel[slot], self._spin[slot] = end, vel, arc.spin
            self.is_untouched[slot] = False
            self._is_landing[slot] = arc.is_landing
            return
        self._wake(slot)
        engine, row = self._world.engine, self._pool.rows[slot]
        if is_caught(arc):  # the engine carries it from here, with what holds it
            engine.set_velocity(row, vel, arc.spin)
            return
        if vel[2] > LANDING_SPEED:
            quat = engine.pose(row)[1]
            self._start(slot, end, vel, arc.spin)
            self._quat[slot] = quat
            return
        # it goes straight to where it is at the end, and then has the velocity that it has there
        line = [(b - a) / h for a, b in zip(engine.pose(row)[0], end, strict=True)]
        engine.set_velocity(row, line, arc.spin)
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
            parts = math.ceil(float(lengths(spin[None])[0]) * dt / _MOST_TURN)
            for share in (0.5, 1.0) * parts:  # with the spin of the middle of each part
                now = multiply(_turned(spin * (share * dt / parts)), q)
                axes = matrix(now)
                spin = axes @ np.linalg.solve(inertia, axes.T @ momentum)
                q = now if share == 1.0 else q
            self._quat[slot], self._spin[slot] = q, spin
        for slot in turning[self._pool.is_ball[turning]].tolist():
            self._quat[slot] = multiply(_turned(self._spin[slot] * dt), self._quat[slot].tolist())


def _near_body(
    world: PhysicsWorld, row: int, body: HitBody, pos: FloatArray, reach: FloatArray, dt: float
) -> BoolArray:
    """Which balls may meet the bounding box of a robot within dt [s], shape (n,).

    Args:
        world: Where it is.
        row: Of the robot.
        body: Its surfaces.
        pos: Where the balls are [m], shape (n, 3).
        reach: How far from there any point of each may get [m], shape (n,).
        dt: Length of the time [s].
    """
    (origin, quat), (vel, rate) = world.engine.pose(row), world.engine.velocity(row)
    local: FloatArray = (pos - np.array(origin)) @ matrix(quat)
    low, high = body.surfaces.bounds
    room: FloatArray = (reach + dt * (math.hypot(*vel) + body.reach * math.hypot(*rate)))[:, None]
    inside = np.greater(local, low - room) & np.less(local, high + room)
    near: BoolArray = np.asarray(inside.all(axis=1))
    return near


def _turned(angle: FloatArray) -> tuple[float, float, float, float]:
    """The rotation by a vector [rad], as a unit quaternion x, y, z, w."""
    size = max(math.sqrt(float(angle @ angle)), 1e-300)
    x, y, z = (math.sin(0.5 * size) / size * angle).tolist()
    return x, y, z, math.cos(0.5 * size)
