"""Which pieces are pressed or heaped, so that their contacts carry load as springs, and how fine the steps must be.

A piece that flies, rolls or is hit has impacts, with the restitution of the pair. One that is held between a robot and
the field, or lies still, has sustained contacts: springs of its kind's stiffness (see `Engine.set_sustained`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from simcore.physics.world import PhysicsWorld
from simcore.pieces.pool import PiecePool, PieceStatus
from simcore.pieces.touching import TOUCH, distances2, touching_chain
from simcore.pieces.wake_grid import Footprint
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["CHAIN", "Pressing"]

CHAIN = 1.0
"""From a robot's bumpers to the farthest piece that it can press against something [m]."""

_CALM_SPEED = 0.5  # [m/s]; below this an impact is too weak for its restitution to matter: it rises by 13 mm e^2
_LEANING = 0.001  # [m]; pieces this near lean on each other
_ON_TOP = 0.3  # sine of the angle at which a ball is over another that it lies on; 0.26 on a bump of 15 degrees
_PIN_MOVE = 0.011  # [m] a step; at 4.5 m/s with 5 ms the center of a ball comes to the face, with 2.5 ms 13 mm off
_PIN_STEPS = 0.0025, 0.01  # [s], shortest and longest
_HEAP_STEP = 0.005  # [s]; 100 balls, 7 deep: overlaps of 4 mm at 10 ms, 1.4 mm at 5 ms
_LAYER_STEP = 0.01  # [s], for a second layer alone: in a corner where 100 balls roll apart 12 mm at 20 ms
_FEW_ON_TOP = 5  # pieces; so many on others come to rest at 20 ms as well, with overlaps below 2 mm
_LOW = 1.0  # [m]; pieces above this are over the robots
_IN_FLIGHT = int(PieceStatus.IN_FLIGHT)


class Pressing:
    """Chooses the contact law of each awake piece and the longest step of the tick.

    Args:
        world: Where the bodies live.
        pool: The pieces.
    """

    def __init__(self, world: PhysicsWorld, pool: PiecePool) -> None:
        self._world = world
        self._pool = pool
        self.is_sustained = np.zeros(len(pool.rows), dtype=bool)
        """Which slots have sustained contacts, shape (slots,)."""
        self.longest_step = math.inf
        """Longest step that what is pressed or heaped allows [s]."""
        self.is_pinned = False
        """Whether a robot presses something against something."""
        self.stirred: IntArray = np.zeros(0, dtype=np.int64)
        """Sleepers that the engine had moved a little when they were last read."""
        rest_heights = np.array([kind.rest_height for kind in pool.types])
        radii = np.array([kind.bounding_radius for kind in pool.types])
        # No center lies lower on the carpet.
        self._lowest = min((kind.inner_radius for kind in pool.types), default=math.inf)
        self._is_heaped = np.zeros(len(pool.rows), dtype=bool)  # scratch
        self._raised = (rest_heights + 0.5 * radii)[pool.state.kind]
        self._high = (rest_heights + 3.0 * radii)[pool.state.kind]

    def begin_tick(self, awake: IntArray, speed: FloatArray, robots: Sequence[Footprint], dt: float) -> None:
        """Choose for a tick.

        Args:
            awake: Slots that the engine moves, shape (n,).
            speed: Of each [m/s], shape (n,).
            robots: Where robots are.
            dt: Length of the tick [s].
        """
        self.longest_step, self.is_pinned = math.inf, False
        if not len(awake) and not len(self.stirred):
            self._world.engine.set_careful(False)
            return
        is_exact = self._world.engine.is_exact  # then impacts and springs are told apart, and steps chosen, by it
        pressers = () if is_exact else robots
        state = self._pool.state
        calm = awake[(speed < _CALM_SPEED) & (state.status[awake] != _IN_FLIGHT)]
        lying = np.concatenate((calm, self.stirred))
        heap = self._heap(lying)
        heaped = len(heap) > 0
        self._is_heaped[heap] = True
        sustained = self._is_heaped[awake]
        self._is_heaped[heap] = False
        crowded = [robot for robot in pressers if self._is_anything_near(robot, robots)]
        if len(awake) and (crowded or (heaped and pressers)):
            pinned, hit = self._near_robots(awake, speed, robots, crowded, dt)
            sustained &= ~hit
            sustained |= pinned
            self.is_pinned = bool(np.count_nonzero(pinned))
        changed = sustained != self.is_sustained[awake]
        if np.count_nonzero(changed):
            self._set(awake[changed], sustained[changed])
        if is_exact:
            return
        self._world.engine.set_careful(self.is_pinned or heaped)
        if self.is_pinned:
            shortest, longest = _PIN_STEPS
            fastest = max(robot.speed for robot in robots)
            self.longest_step = min(longest, max(shortest, _PIN_MOVE / max(fastest, 1e-6)))
        if heaped:
            height = state.pos[heap, 2]
            if (height > self._high[heap]).any():
                self.longest_step = min(self.longest_step, _HEAP_STEP)
            elif np.count_nonzero(height > self._raised[heap]) > _FEW_ON_TOP:
                self.longest_step = min(self.longest_step, _LAYER_STEP)

    def release(self, slots: IntArray) -> None:
        """Give pieces back their impacts: they fall asleep or leave the field, and may be hit while nobody looks."""
        held = slots[self.is_sustained[slots]]
        self._set(held, np.zeros(len(held), dtype=bool))

    # --- inside -------------------------------------------------------------------------------------------------

    def _set(self, slots: IntArray, sustained: BoolArray) -> None:
        engine, rows = self._world.engine, self._pool.rows
        for slot, one in zip(slots.tolist(), sustained.tolist(), strict=True):
            engine.set_sustained(rows[slot], one)
        self.is_sustained[slots] = sustained

    def _heap(self, lying: IntArray) -> IntArray:
        """Those of the pieces that lie still which are above others, touch one that is, or one that does, and so on.

        None if nothing lies on another: balls on a ramp are high, too, but touch each other at its slope.

        A spring next to a rigid piece would be rigid, too, and hardly repair an overlap: they must be of one kind.
        """
        if len(lying) < 2:
            return lying[:0]
        is_raised = self._pool.state.pos[lying, 2] > self._raised[lying]
        raised = is_raised.nonzero()[0]
        if not len(raised):
            return lying[:0]
        pos, radius, is_ball = self._pool.state.pos.take(lying, axis=0), self._pool.radius[lying], self._pool.is_ball
        high = pos.take(raised, axis=0)
        reach = np.add.outer(radius[raised], radius + _LEANING)
        on_others = distances2(high, pos) < reach * reach
        above = np.subtract.outer(high[:, 2], pos[:, 2]) > _ON_TOP * reach
        above |= ~np.logical_and.outer(is_ball[lying[raised]], is_ball[lying])
        on_others &= above
        on_others[np.arange(len(raised)), raised] = False
        if not np.count_nonzero(on_others):
            return lying[:0]
        members: IntArray = lying[touching_chain(pos, radius, is_raised, gap=_LEANING)]
        return members

    def _near_robots(
        self, awake: IntArray, speed: FloatArray, robots: Sequence[Footprint], crowded: Sequence[Footprint], dt: float
    ) -> tuple[BoolArray, BoolArray]:
        """Which awake pieces are pinned by crowded robots, and which a moving robot can hit, shape (n,) each."""
        state, radius = self._pool.state, self._pool.radius
        pinned, hit = np.zeros(len(awake), dtype=bool), np.zeros(len(awake), dtype=bool)
        pos = state.pos.take(awake, axis=0)
        low = pos[:, 2] < _LOW
        gaps = [robot.gap(pos) - radius[awake] for robot in robots]
        for robot, gap in zip(robots, gaps, strict=True):
            reach = TOUCH + (robot.speed + speed) * dt
            near = low & (gap < reach)
            if robot.speed > _CALM_SPEED:
                hit |= near
            if robot not in crowded or not np.count_nonzero(near):
                continue
            some = np.nonzero(low & (gap < CHAIN))[0]
            move = (robot.speed + speed[some]) * dt
            held = self._are_held(awake[some], pos[some], move)
            if robot.highest_underside > self._lowest:
                held |= near[some] & self._are_under(robot, awake[some], pos[some], move)
            if len(robots) == 1 and not np.count_nonzero(held):
                continue
            touching = touching_chain(pos[some], radius[awake[some]], near[some])
            chain = some[touching]
            if np.count_nonzero(held & touching) or any(
                (other_gap[chain] < TOUCH + (other.speed + speed[chain]) * dt).any()
                for other, other_gap in zip(robots, gaps, strict=True)
                if other is not robot
            ):
                pinned[chain] = True
        return pinned, hit

    def _is_anything_near(self, robot: Footprint, robots: Sequence[Footprint]) -> bool:
        """Whether the field or another robot may be near enough to press pieces against it, or the robot above some."""
        if robot.highest_underside > self._lowest:
            return True
        reach = math.hypot(robot.half_length, robot.half_width) + CHAIN
        if len(robots) > 1:
            for other in robots:
                far = reach + math.hypot(other.half_length, other.half_width)
                if other is not robot and math.hypot(other.x - robot.x, other.y - robot.y) < far:
                    return True
        return not self._world.is_open(robot.x, robot.y, reach)

    def _are_held(self, slots: IntArray, pos: FloatArray, move: FloatArray) -> BoolArray:
        """Which pieces can touch something solid within the tick, shape (n,)."""
        return self._world.near_solid(pos, self._pool.radius[slots] + move + TOUCH)

    def _are_under(self, robot: Footprint, slots: IntArray, pos: FloatArray, move: FloatArray) -> BoolArray:
        """Which pieces can touch both the robot's lower side and what they lie on within the tick, shape (n,)."""
        reach, over = self._pool.radius[slots] + move + TOUCH, robot.over(pos)
        return (over > 0.0) & (over < reach) & ((pos[:, 2] < reach) | self._world.near_field(pos, reach))
