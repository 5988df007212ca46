"""Air on fast pieces, and flights that do not depend on the number of sub-steps."""

from __future__ import annotations

import numpy as np

from simcore.physics.world import PhysicsWorld
from simcore.pieces.aerodynamics import drag_acceleration, lift_acceleration
from simcore.pieces.impacts import Impacts
from simcore.pieces.pool import PiecePool, PieceStatus
from simcore.pieces.touching import lengths
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["FlightForces"]

_FALL_ERROR = 0.2  # share of gravity that drag and lift may be
_HOP_SPEED = 1.0  # [m/s]; pieces that others throw up more gently, by 5 cm, are left to the engine
_LEAST_JUMP = 0.15  # [m/s] in a tick: a floor takes 0.2 of what gravity gives, the first tick's mean lags by 0.1
_IN_FLIGHT = int(PieceStatus.IN_FLIGHT)


class FlightForces:
    """Drag and spin lift as forces before each sub-step, with a correction of the engine's integrator.

    An engine that does not integrate exactly takes x += h v with v already moved to the end of the step (semi-implicit
    Euler), so its v is really the mean of a step (leapfrog) and lags by half a step of acceleration at the launch and
    wherever h changes. A force m a (h_before - h) / (2 h), with h_before = 0 at the launch, makes up for it: then range
    and apex are those of the differential equation to second order at any h, and do not change when another ball forces
    more sub-steps.
    """

    def __init__(self, world: PhysicsWorld, pool: PiecePool, impacts: Impacts) -> None:
        self._world = world
        self._pool = pool
        self._impacts = impacts
        n = len(pool.rows)
        kinds = pool.state.kind
        self._mass = pool.mass
        self._drag = pool.drag
        self._lifting = [kind for kind, air in enumerate(pool.air) if air.lift > 0.0]
        self._aero_speed = np.array([c.aero_speed for c in pool.types])[kinds]
        self._h_before = np.full(n, np.nan)
        self._is_flying = np.zeros(n, dtype=bool)
        self._is_falling = np.zeros(n, dtype=bool)
        self._has_turned = np.zeros(n, dtype=bool)  # bounced or was let go in the last tick
        self._slots: IntArray = np.zeros(0, dtype=np.int64)
        self._rows: list[int] = []
        self._gravity = np.array([0.0, 0.0, -world.gravity])
        self._is_exact = world.engine.is_exact

    def start(self, slot: int) -> None:
        """A piece is in the air: its velocity is exact now, not the mean of a step."""
        self._h_before[slot] = 0.0
        self._is_falling[slot] = self._has_turned[slot] = True
        self._impacts.forget(slot)

    def forget(self, slot: int) -> None:
        """A piece was put somewhere, at rest."""
        self._is_falling[slot] = self._has_turned[slot] = False
        self._impacts.forget(slot)

    def begin_tick(self, awake: IntArray, speed: FloatArray) -> None:
        """Choose the pieces that fly in this tick: the launched ones, and all that are fast.

        Args:
            awake: Slots that the engine moves, shape (n,).
            speed: Of each [m/s], shape (n,).
        """
        is_flying = (speed > self._aero_speed[awake]) | (self._pool.state.status[awake] == _IN_FLIGHT)
        flying = awake[is_flying | self._is_falling[awake]]
        if len(flying) != len(self._slots) or np.count_nonzero(flying != self._slots):
            joined = flying[~self._is_flying[flying]]
            self._h_before[joined[self._h_before[joined] != 0.0]] = np.nan  # all but the ones launched just now
            self._is_flying[self._slots] = False
            self._is_flying[flying] = True
            self._slots, self._rows = flying, self._pool.rows_of(flying)

    def push(self, h: float) -> None:
        """Apply the forces of the next sub-step of h [s]."""
        self._impacts.finish()
        slots = self._slots
        if not (len(slots) or self._impacts.is_due):
            return
        twist = self._world.engine.velocities(self._rows)
        h_before = self._h_before[slots]
        h_before = np.zeros((len(slots), 1)) if self._is_exact else np.where(np.isnan(h_before), h, h_before)[:, None]
        middle = twist[:, :3] + self._gravity * (0.5 * (h_before + h))  # velocity in the middle of the step to come
        air = drag_acceleration(middle, self._drag[slots])
        for kind in self._lifting:
            mine = self._pool.state.kind[slots] == kind
            lift = lift_acceleration(middle[mine], twist[mine, 3:], self._pool.air[kind])
            air[mine] += self._pool.lift_share[slots[mine]][:, None] * lift
        centers = self._world.engine.centers(self._rows)
        taken = self._impacts.play(h, slots, centers, middle, twist[:, 3:])
        acceleration = air if self._is_exact else air + (air + self._gravity) * ((h_before - h) / (2.0 * h))
        if np.count_nonzero(taken):
            self._h_before[slots[taken]] = 0.0
            slots, acceleration, centers = slots[~taken], acceleration[~taken], centers[~taken]
        self._world.engine.apply_forces(self._pool.rows_of(slots), self._mass[slots][:, None] * acceleration, centers)
        self._h_before[slots] = h

    def note_falls(self, awake: IntArray, speed: FloatArray, before: FloatArray, dt: float) -> None:
        """Which pieces fall freely: gravity and nothing else changed their mean velocity from tick to tick.

        Args:
            awake: Slots that the engine moves, shape (n,).
            speed: Mean vertical velocity of each in this tick [m/s], shape (n,).
            before: The same in the tick before.
            dt: Length of a tick [s].
        """
        fall = self._world.gravity * dt
        is_free = np.abs(speed - before + fall) < _FALL_ERROR * fall
        is_free &= self._is_falling[awake] | (np.abs(speed) > _HOP_SPEED)
        bounced = self._impacts.bounced[awake]
        self._is_falling[awake] = is_free | bounced | self._has_turned[awake]  # the change since that tick is not g dt
        self._has_turned[awake] = bounced
        self._impacts.bounced[awake] = False

    def has_touched(self, awake: IntArray, vel: FloatArray, dt: float) -> BoolArray:
        """Which launched pieces changed their velocity by more than gravity and air can: they hit something."""
        state = self._pool.state
        flying: BoolArray = state.status[awake] == _IN_FLIGHT
        if not np.count_nonzero(flying):
            return flying
        change = vel - state.vel.take(awake, axis=0) - self._gravity * dt
        # air takes at most k v^2; within the first tick after a launch the mean of the tick lags by half of it
        air = self._drag[awake] * np.einsum("ij,ij->i", vel, vel) * dt
        jump = lengths(change)
        touched: BoolArray = flying & (jump > 2.0 * air + _LEAST_JUMP)
        return touched
