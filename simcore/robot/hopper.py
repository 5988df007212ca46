"""Hopper: simulation of balls that fall, roll and jam in a box inside a robot.

The loop (`simcore.loop`) moves the balls of a hopper in a frame that translates with the robot's origin and does not
rotate. In this frame, apparent gravity (gravity minus the robot's acceleration) points down. The box rotates in the
frame, so centrifugal, Coriolis and Euler accelerations need no formula. Each tick uses a new frame; between two ticks,
positions and velocities are in the robot frame. The floor is a second body with the pose of the box and the velocity of
the belt, so floor friction drives the balls. Feed rate, fill and jams result from the foam and friction of the balls.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from scipy.sparse.csgraph import connected_components

from simcore.errors import ConfigError
from simcore.loop.robot_state import BODY, STEP, no_robots, records
from simcore.loop.state import AWAKE, JUST_PUT, Balls, Floor, make_balls, make_memory
from simcore.loop.step import advance
from simcore.quantities import FRICTION, RATIO, ROBOT_LENGTH, ROBOT_PLACE, Quantity, require_fields
from simcore.typing import FloatArray
from simcore.units import TICK
from simcore.world.contact_law import FOAM, WALL, pair_friction
from simcore.world.rotation import IDENTITY, Vector, matrix
from simcore.world.shapes import Hull
from simcore.world.solids_builder import SolidsBuilder

__all__ = ["FACES", "Hopper", "HopperConfig"]

Side: TypeAlias = Literal["front", "back", "left", "right", "bottom"]
FACES: dict[str, tuple[int, int]] = {
    "front": (0, 1), "back": (0, -1), "left": (1, 1), "right": (1, -1), "bottom": (2, -1)
}  # fmt: skip
"""Axis (0 for x, 1 for y, 2 for z) and sign of the outward normal of each side."""
OPPOSITE: dict[str, Side] = {"front": "back", "back": "front", "left": "right", "right": "left", "bottom": "back"}
_LEAN = Quantity("rad", 0.0, 1.2)
_ENTRY = 1.0  # [m/s]; speed at which intakes feed pieces in, away from the wall. Estimate, within a factor of two
_ASIDE = 0.04  # [-] of a radius; offset of a new ball, which depends on the slot, so no ball is exactly above another
_FREE = 0.9  # [-] of two radii; a position is free if a new ball would overlap other balls by at most a tenth
_THICK = 0.5  # [m]; thickness of walls, and of the feeder behind the outlet
_EDGE = 0.001  # [m]; smallest width of a wall next to the outlet, and depth of an outlet's edge below a moving floor
_TREAD = 0.01  # [m]; rolling lever arm on a belt: balls sink between cords, treads or fingers. Estimate, factor of two
_STRIP = 0.02  # [m]; part of the floor around an outlet in the bottom that does not move
_HEAVY, _REACH = 1e30, 10.0  # [kg, kg m^2], [m]; the large mass keeps forces of the balls from moving the box
_MOST = np.array((500.0,) * 3 + (50.0,) * 3 + (2000.0,) * 3 + (10.0,))  # limits of pull, spin, turn and belt speed
_STILL = 0.5  # [s]; after this time without motion, balls rest until the motion of the robot or the belt changes
_SAME = np.array((0.1,) * 3 + (0.02,) * 3 + (0.5,) * 3 + (0.005,))  # change of motion above which resting balls wake
_BLOCKED = 2.0  # [-]; travel of a free ball, in diameters, after which a blocked outlet counts as jammed
_STEPS = round(TICK / STEP)  # steps of the loop in a tick
_NO_ROBOTS = no_robots()


@dataclass(frozen=True, slots=True, kw_only=True)
class HopperConfig:
    """Config of a hopper: outlet, inlet, belt and friction; `StorageConfig` defines the box."""

    outlet: Side = "front"
    """Side of the box with the opening through which balls leave."""
    outlet_width: float
    """Width of the outlet along y, or along x in the left or right side [m]. Two balls can bridge an outlet narrower
    than two diameters; a pile of balls can bridge an outlet narrower than three diameters."""
    outlet_height: float | None = None
    """Height of an outlet in a wall, or size along x of an outlet in the bottom [m]; None if equal to the width."""
    outlet_place: tuple[float, float] | None = None
    """Center of the outlet, robot frame [m]: horizontal coordinate and height in a wall, or y and x in the bottom. None
    for the middle of the wall at floor height, or the middle of the bottom."""
    inlet: Side | None = None
    """Wall through which intakes feed balls, at the top; None for the wall opposite the outlet, or for the back if the
    outlet is in the bottom."""
    belt: str | None = None
    """Name of the mechanism that moves balls on the floor toward the outlet, or away from the inlet if the outlet is in
    the bottom; None for a hopper without a belt."""
    belt_travel: float = 0.025
    """Travel of a ball per radian of `belt` [m]: the radius of the belt roller, or half this radius if the balls roll
    between belt and fixed ceiling. The value is negative if the mechanism turns backward to feed."""
    funnel: float = 0.0
    """Tilt of the walls next to the outlet toward the outlet [rad]; at 0, balls stay in the corners next to the
    outlet."""
    slope: float = 0.0
    """Downward slope of the floor toward an outlet in a wall [rad]; must be 0 for an outlet in the bottom."""
    friction: float = pair_friction(FOAM.friction, WALL.friction)
    """Coefficient of friction of foam balls on walls, floor and belt [-]; the default of 0.4 is an estimate for foam on
    a wall. The coefficient of other balls is larger or smaller in proportion to the friction factor of the ball."""

    def __post_init__(self) -> None:
        require_fields(
            self, outlet_width=ROBOT_LENGTH, outlet_height=ROBOT_LENGTH, outlet_place=(ROBOT_PLACE,) * 2,
            belt_travel=RATIO, funnel=_LEAN, slope=_LEAN, friction=FRICTION,
        )  # fmt: skip
        if self.inlet == "bottom":
            raise ConfigError("HopperConfig: inlet must not be the bottom, got 'bottom'")
        if self.slope and self.outlet == "bottom":
            raise ConfigError("HopperConfig: a floor with a slope needs an outlet in a wall, got 'bottom'")


class Hopper:
    """Simulation of the balls in a robot's hopper.

    Args:
        config: Config of the hopper.
        low: Corner of the box with the smallest coordinates, robot frame [m].
        high: Corner of the box with the largest coordinates, robot frame [m].
        kinds: Function that returns the records of all balls of the match, by slot, with mass, foam and
            surface; None for a hopper that stays empty.
    """

    def __init__(self, config: HopperConfig, low: Vector, high: Vector, kinds: Callable[[], Balls] | None) -> None:
        self.config = config
        self.slots: list[int] = []
        """Slots of the balls in the hopper."""
        self.pos: FloatArray = np.zeros((0, 3))
        """Centers of the balls, robot frame [m], shape (n, 3)."""
        self.vel: FloatArray = np.zeros((0, 3))
        """Velocities of the balls relative to the robot, robot frame [m/s], shape (n, 3)."""
        self.radius: FloatArray = np.zeros(0)
        """Radii of the balls [m], shape (n,)."""
        self.is_jammed = False
        """Whether balls block the outlet.

        A jam begins when a chain of touching balls has connected both sides of the outlet for a minimum time, and no
        ball has passed. The minimum time is the time in which a free ball would move two diameters from rest: 0.6 s on
        a belt at 0.6 m/s. Friction accelerates the free ball to the belt speed; a slope and an acceleration of the
        robot also change the speed. The jam ends when the chain breaks or a ball passes.
        """
        self._kinds, self._low, self._high = kinds, np.array(low), np.array(high)
        self._axis, self._sign = FACES[config.outlet]
        self._plane = self._sign * (high if self._sign > 0 else low)[self._axis]
        inlet = config.inlet or OPPOSITE[config.outlet]
        self._inlet = FACES[inlet]
        axis, sign = FACES[OPPOSITE[inlet] if config.outlet == "bottom" else config.outlet]
        self._belt = np.array((0.0, 0.0, -math.sin(config.slope)))  # direction of the belt
        self._belt[axis] = sign * math.cos(config.slope)
        self._out = np.array((0.0, 0.0, -1.0)) if config.outlet == "bottom" else self._belt
        self._free_speed = self._free_way = 0.0  # speed and travel of a free ball since the outlet was blocked [m/s, m]
        self._size = 0.0  # largest radius so far [m]
        self._balls, self._memory = make_balls(np.zeros(0, np.uint8), self.pos, self.vel), make_memory(0)
        self._solids, self._sides = SolidsBuilder().solids, [0, 0]
        self._resting: FloatArray | None = None  # pull, spin, turn and belt speed when the balls came to rest
        self._bodies = records(BODY, 2)  # box and belt
        self._bodies["is_active"] = 1
        model = self._bodies["model"]
        for name, value in {"mass": _HEAVY, "inertia": _HEAVY, "reach": _REACH}.items():
            model[name] = value
        model["principal"] = np.eye(3)

    # --- contents ---------------------------------------------------------------------------------------------------

    def follow(self, slots: Sequence[int], radii: Sequence[float], places: Sequence[Vector]) -> None:
        """Set the contents: keep the balls whose slots remain, remove the others, and add new balls.

        A new ball starts at the first free position of the inlet, or of `places` if the inlet is occupied. If no
        position is free, the ball starts where the overlap is least.

        Args:
            slots: Slots of all balls in the hopper.
            radii: Radii of all balls in the hopper [m].
            places: Positions to try if the inlet is occupied, robot frame [m].
        """
        sizes = np.array(radii)
        if slots == self.slots and np.array_equal(sizes, self.radius):
            return
        rows = {slot: row for row, slot in enumerate(self.slots)}
        placed = [number for number, slot in enumerate(slots) if slot in rows]
        kept = [rows[slots[number]] for number in placed]
        self.is_jammed = self.is_jammed and len(kept) > 1
        pos, vel = np.zeros((len(slots), 3)), np.zeros((len(slots), 3))
        pos[placed], vel[placed] = self.pos[kept], self.vel[kept]
        self._set_balls(sizes, list(slots), placed, kept)
        for number, slot in enumerate(slots):
            if slot in rows:
                continue
            size = float(sizes[number])
            inlets = self._inlets(size)
            candidates = np.vstack((inlets, *places))
            clearances = _clearances(candidates, size, pos[placed], sizes[placed])
            free = np.nonzero(clearances >= 0.0)[0]
            chosen = int(free[0]) if len(free) else int(np.argmax(clearances))
            aside = (math.fmod(0.618 * slot, 1.0) - 0.5, math.fmod(0.755 * slot, 1.0) - 0.5, 0.0)
            pos[number] = candidates[chosen] + _ASIDE * size * np.array(aside)
            if chosen < len(inlets):
                vel[number, self._inlet[0]] = -_ENTRY * self._inlet[1]
            placed.append(number)
        self.slots, self.pos, self.vel, self.radius = list(slots), pos, vel, sizes
        if len(slots) and sizes.max() > self._size:
            self._size = float(sizes.max())
            self._build()

    def room_at_inlet(self, size: float) -> int:
        """Return the number of balls of radius `size` [m] that can enter side by side at the inlet now."""
        candidates = self._inlets(size)
        count, last = 0, -math.inf
        for place in candidates[
            _clearances(candidates, size, self.pos, self.radius) >= 0.0, 1 - self._inlet[0]
        ].tolist():
            if place - last >= 2.0 * _FREE * size:
                count, last = count + 1, place
        return count

    def at_outlet(self) -> list[int]:
        """Return the slots of the balls whose centers are past the plane of the outlet, farthest first."""
        ahead = self._sign * self.pos[:, self._axis] - self._plane
        rows = np.argsort(-ahead, kind="stable")
        return [self.slots[row] for row in rows.tolist() if ahead[row] >= 0.0]

    def _inlets(self, size: float) -> FloatArray:
        """Return entry positions of a ball of radius `size` [m] at the inlet, robot frame [m], shape (m, 3).

        The positions are in a row along the top of the inlet wall, less than a radius apart.
        """
        axis, sign = self._inlet
        low, high = self._low + size, self._high - size
        places = np.tile(high if sign > 0 else low, (1 + max(0, math.floor((high - low)[1 - axis] / (0.5 * size))), 1))
        places[:, 1 - axis] = np.linspace(low[1 - axis], high[1 - axis], len(places))
        places[:, 2] = high[2]
        return places

    def _set_balls(self, sizes: FloatArray, slots: list[int], placed: list[int], kept: list[int]) -> None:
        """Create the arrays of the loop for the balls in the hopper, and copy the state of the remaining balls.

        Args:
            sizes: Radii of the balls [m].
            slots: Slots of the balls.
            placed: New rows of the remaining balls.
            kept: Old rows of the remaining balls.
        """
        n, old, known = len(slots), self._balls, self._memory
        balls = make_balls(np.full(n, AWAKE, np.uint8), np.zeros((n, 3)), np.zeros((n, 3)))
        memory = make_memory(n)._replace(clock=known.clock)
        balls.is_ball[:], balls.radius[:], balls.is_put[:] = 1, sizes, JUST_PUT
        if n:
            assert self._kinds is not None, "a hopper needs the balls of the match"
            kinds = self._kinds()
            balls.mass[:], balls.foam[:], balls.surface[:] = kinds.mass[slots], kinds.foam[slots], kinds.surface[slots]
        balls.spin[placed], balls.is_put[placed] = old.spin[kept], JUST_PUT * old.is_put[kept]
        # Contacts with the box continue. Contacts between balls start again, because the contact keys contain the rows.
        memory.key[placed], memory.spring[placed] = known.key[kept], known.spring[kept]
        memory.stamp[placed] = np.where(known.key[kept] >= 0, known.stamp[kept], -2)
        self._balls, self._memory, self._resting = balls, memory, None

    # --- box --------------------------------------------------------------------------------------------------------

    def _build(self) -> None:
        """Build the solids of box and belt for balls up to the largest radius so far."""
        config, axis, builder = self.config, self._axis, SolidsBuilder()
        across, up = 0 if axis == 1 else 1, 0 if axis == 2 else 2
        middle = 0.5 * (self._low + self._high)  # a box narrower than a ball is widened until a ball fits
        low, high = np.minimum(self._low, middle - self._size), np.maximum(self._high, middle + self._size)
        if axis < 2:
            rise = math.tan(config.slope) * (high[axis] - low[axis])
            high[2] = max(high[2], low[2] + rise + 2.0 * self._size / math.cos(config.slope))
        deep = 2.0 * self._size + _THICK
        least, most = low - deep, high + deep
        half = 0.5 * config.outlet_width, 0.5 * (config.outlet_height or config.outlet_width)
        place = config.outlet_place or (middle[across], low[2] + half[1] if up == 2 else middle[0])
        plane = self._plane + (_EDGE if axis == 2 else 0.0)

        def put(body: int, points: FloatArray) -> int:
            rolling = _TREAD if body == 1 and config.belt is not None else WALL.rolling
            surface = config.friction / FOAM.friction, WALL.restitution, rolling
            return builder.add(Hull(points=points), (0.0, 0.0, 0.0), IDENTITY, surface, body=body)

        def block(body: int, *bounds: tuple[int, int, float]) -> None:
            """Add a block with the outer bounds, except for the given bounds.

            Args:
                body: Index of the body: 0 for the box, 1 for the belt.
                bounds: Axis, 1 for a lower or -1 for an upper bound, and coordinate [m] of each given bound.
            """
            ends = least.copy(), most.copy()
            for k, sign, end in bounds:
                ends[sign < 0][k] = end
            points = np.array(np.meshgrid(*zip(*ends, strict=True))).reshape(3, -1).T
            if body == 1:
                points[:, 2] += math.tan(config.slope) * (self._plane - self._sign * points[:, axis])
            if (ends[0] < ends[1]).all():
                put(body, points)

        for k, sign in (*FACES.values(), (2, 1)):
            if (k, sign) not in ((axis, self._sign), FACES["bottom"]):
                block(0, (k, sign, (high if sign > 0 else low)[k]))
        self._sides = []
        for sign, end in ((1, high[across]), (-1, low[across])):
            edge = place[0] + sign * half[0]
            wide = max(sign * (end - edge), 0.0) + _EDGE
            corners = np.zeros((2, 4, 3))
            corners[:, :, axis] = self._sign * (plane + np.array((0.0, -math.tan(config.funnel) * wide, deep, deep)))
            corners[:, :, across] = edge + sign * wide * np.array((0.0, 1.0, 1.0, 0.0))
            corners[0, :, up], corners[1, :, up] = least[up], most[up]
            self._sides.append(put(0, corners.reshape(-1, 3)))
        block(0, (axis, self._sign, self._sign * (plane + 2.0 * self._size)))  # the feeder
        for sign in (1, -1) if up == 0 or place[1] - half[1] > low[2] + _EDGE else (1,):
            block(0, (axis, self._sign, self._sign * plane), (up, sign, place[1] + sign * half[1]))
        on_box = builder.count
        floor = (2, -1, low[2])
        if axis < 2:
            block(1, floor)
        else:  # around the outlet
            for k, edge, wide in ((across, place[0], half[0] + _STRIP), (up, place[1], half[1] + _STRIP)):
                block(1, floor, (k, 1, edge + wide))
                block(1, floor, (k, -1, edge - wide))
        self._solids = builder.solids
        model = self._bodies["model"]
        model["first_solid"], model["last_solid"] = (0, on_box), (on_box, builder.count)

    # --- motion -----------------------------------------------------------------------------------------------------

    def advance(self, pull: Vector, spin: Vector, turn: Vector, belt_speed: float) -> bool:
        """Advance the balls by one tick, and update `is_jammed`.

        The method does nothing if the hopper is empty or an argument is not finite.

        Args:
            pull: Gravity minus the acceleration of the robot's origin, robot frame [m/s^2].
            spin: Angular velocity of the robot at the end of the tick, robot frame [rad/s].
            turn: Angular acceleration of the robot, robot frame [rad/s^2].
            belt_speed: Speed of the belt, positive toward the outlet [m/s].

        Returns:
            Whether a jam began in this tick.
        """
        if not self.slots or not np.isfinite(motion := np.array((*pull, *spin, *turn, belt_speed))).all():
            return False
        motion = np.minimum(np.maximum(motion, -_MOST), _MOST)
        if self._resting is None or (np.abs(motion - self._resting) > _SAME).any():
            self._resting = None
            self._move(motion[:3], motion[3:6], motion[6:9], float(motion[9]))
            if self._balls.still.min() > _STILL:
                self.vel[:], self._resting = 0.0, motion
        was_jammed, self.is_jammed = self.is_jammed, self._observe(motion[:3], float(motion[9]))
        return self.is_jammed and not was_jammed

    def _move(self, pull: FloatArray, spin: FloatArray, turn: FloatArray, belt_speed: float) -> None:
        """Advance the balls in the loop by one tick; the arguments are those of `advance`, clamped to `_MOST`."""
        balls, springs, bodies = self._balls, self._memory.spring[:, :, :3], self._bodies
        gravity = math.sqrt(float((pull * pull).sum()))
        x, y, z = (-pull / max(gravity, 1e-9)).tolist()
        quat = np.array((y, -x, 0.0, 1.0 + z) if z > -1.0 + 1e-9 else (1.0, 0.0, 0.0, 0.0))  # rotates pull to -z
        quat /= math.sqrt(float((quat * quat).sum()))
        axes, spin = matrix(quat), spin - TICK * turn
        balls.pos[:], balls.vel[:] = _turned(axes, self.pos), _turned(axes, self.vel + np.cross(spin, self.pos))
        balls.spin[:], springs[:] = _turned(axes, balls.spin), _turned(axes, springs)
        bodies["pos"], bodies["vel"], bodies["quat"] = 0.0, 0.0, quat
        bodies["rate"], bodies["turn"] = _turned(axes, spin), _turned(axes, turn)
        bodies["vel"][1] = _turned(axes, belt_speed * self._belt)
        bodies["pos"][1] = -0.5 * TICK * bodies["vel"][1]
        advance(_NO_ROBOTS, bodies, balls, self._memory, self._solids, Floor(gravity, False, 0.0, 0.0, 0.0, True), TICK)
        axes = bodies["axes"][0].T
        self.pos = _turned(axes, balls.pos)
        self.vel = _turned(axes, balls.vel) - np.cross(_turned(axes, bodies["rate"][0]), self.pos)
        balls.spin[:], springs[:] = _turned(axes, balls.spin), _turned(axes, springs)

    def _observe(self, pull: FloatArray, belt_speed: float) -> bool:
        """Advance the travel of the free ball, and return whether the outlet is jammed."""
        if not self._is_bridged():
            self._free_speed = self._free_way = 0.0
            return False
        grip = self.config.friction * max(0.0, -float(pull[2])) if belt_speed else 0.0
        pulled = TICK * float((pull * self._out).sum())
        driven = min(max(belt_speed - self._free_speed, -TICK * grip), TICK * grip)
        self._free_speed = max(0.0, self._free_speed + pulled + driven)
        self._free_way += TICK * self._free_speed
        return self.is_jammed or self._free_way > 2.0 * _BLOCKED * self._size

    def _is_bridged(self) -> bool:
        """Return whether touching balls connect both sides of the outlet, and no ball is past the outlet."""
        key, is_now = self._memory.key, self._memory.stamp > self._memory.clock[0] - _STEPS
        left, right = (((key == side) & is_now).any(axis=1) for side in self._sides)
        if not (left.any() and right.any()) or self.at_outlet():
            return False
        between = self.pos[:, None] - self.pos[None]
        touch = np.einsum("ijk,ijk->ij", between, between) < (self.radius[:, None] + self.radius[None] + _EDGE) ** 2
        chain = connected_components(touch)[1]
        return bool(np.isin(chain[left], chain[right]).any())


def _turned(axes: FloatArray, vectors: FloatArray) -> FloatArray:
    """Rotate vectors of shape (..., 3) by the rotation matrix `axes`."""
    turned: FloatArray = np.einsum("ij,...j->...i", axes, vectors)
    return turned


def _clearances(candidates: FloatArray, size: float, pos: FloatArray, radius: FloatArray) -> FloatArray:
    """Return the smallest clearance between a new ball at each candidate position and existing balls [m], shape (m,).

    A clearance is zero at an overlap of a tenth of the sum of the radii, and 1 m without existing balls.

    Args:
        candidates: Positions of the new ball [m], shape (m, 3).
        size: Radius of the new ball [m].
        pos: Centers of the existing balls [m], shape (n, 3).
        radius: Radii of the existing balls [m], shape (n,).
    """
    if not len(pos):
        return np.ones(len(candidates))
    between = candidates[:, None] - pos[None]
    clearances = np.sqrt(np.einsum("ijk,ijk->ij", between, between)) - _FREE * (size + radius)[None]
    nearest: FloatArray = clearances.min(axis=1)
    return nearest
