"""Hopper: simulation of balls that fall, roll and jam in a box inside a robot, in the robot frame.

The method is position-based dynamics (Macklin and Mueller, "Small steps in physics simulation", 2019): in each of a few
sub-steps, gravity, the robot's acceleration and the belt move the balls; contacts then push balls out of walls and
apart. Feed rates, fill and jams follow from the geometry, without random numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from simcore.errors import ConfigError
from simcore.quantities import FRICTION, RATIO, ROBOT_LENGTH, ROBOT_PLACE, Quantity, require_fields
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import TICK
from simcore.world.contact_law import FOAM, WALL, pair_friction, pair_rolling
from simcore.world.rotation import Vector

__all__ = ["FACES", "Hopper", "HopperConfig", "arch_holds"]

Side: TypeAlias = Literal["front", "back", "left", "right", "bottom"]
FACES: dict[str, tuple[int, int]] = {
    "front": (0, 1), "back": (0, -1), "left": (1, 1), "right": (1, -1), "bottom": (2, -1)
}  # fmt: skip
"""Axis and sign of the outward normal of each side."""
OPPOSITE: dict[str, Side] = {"front": "back", "back": "front", "left": "right", "right": "left", "bottom": "back"}
_LEAN = Quantity("rad", 0.0, 1.2)
_STEPS = 5  # per tick; 50 balls take 0.9 ms
_SHARE = 0.5
"""Fraction of an overlap that a contact corrects in a step [-]; with larger values, balls with six neighbors tremble.

A ball with k balls on top therefore overlaps by 2 k g (TICK / _STEPS)^2 / _SHARE = 0.6 mm times k.
"""
_LEVER = pair_rolling(FOAM.rolling, FOAM.friction, WALL.rolling, WALL.friction)  # [m]; rolling resistance in the box
_STANDS = 0.01  # [m/s]; balls roll on a slower belt and move with a faster belt
_ENTRY = 1.0  # [m/s]; speed at which intakes feed pieces in, away from the wall. Estimate, within a factor of two
_RUBBING = 6.0  # [1/s]; rate at which friction equalizes the velocities of touching balls. Estimate, factor of two
_FASTEST = 5.0  # [m/s]; speed limit relative to the robot: a third of a ball's radius per step
_TOUCH = 0.03  # [-] of a radius; largest gap at which balls touch, as foam is soft
_ASIDE = 0.04
"""Offset of an entering ball from the chosen position, as a fraction of the radius [-].

The offset depends on the ball's slot, so that no ball is exactly above another.
"""
_FREE = 0.9  # [-] of two radii; a position is free if a ball there overlaps others by at most a tenth


@dataclass(frozen=True, slots=True, kw_only=True)
class HopperConfig:
    """Config of a hopper: outlet, inlet, belt and friction; `StorageConfig` defines the box."""

    outlet: Side = "front"
    """Side with the opening to the shooter."""
    outlet_width: float
    """Width of the outlet along y, or along x in the left or right side [m]; two balls can bridge an outlet narrower
    than two diameters."""
    outlet_height: float | None = None
    """Height of the outlet, or length along x of an outlet in the bottom [m]; None if equal to the width."""
    outlet_place: tuple[float, float] | None = None
    """Center of the outlet, across and up (along y and x in the bottom), robot frame [m]; None for the middle of the
    side, at the floor."""
    inlet: Side | None = None
    """Wall where intakes feed pieces in, at the top; None for the wall opposite the outlet."""
    belt: str | None = None
    """Mechanism that moves pieces on the floor toward the outlet, or away from the inlet if the outlet is in the
    bottom; None without a belt."""
    belt_travel: float = 0.025
    """Travel of a piece per radian of `belt` [m]: the radius of the roller, or half the radius if pieces roll along a
    fixed ceiling; negative if the mechanism turns backward to feed."""
    funnel: float = 0.0
    """Angle by which the walls next to the outlet are tilted toward the outlet [rad]; at 0, pieces in the dead corners
    stay there."""
    slope: float = 0.0
    """Slope of the floor, down to an outlet in a wall [rad]."""
    friction: float = pair_friction(FOAM.friction, WALL.friction)
    """Coefficient of friction of pieces on the belt, and of the contacts in an arch [-]. The default is an estimate of
    0.4, for foam on a wall; foam on foam may have 0.6."""

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
    """State of the balls in a robot's hopper.

    Args:
        config: Config of the hopper.
        low: Corner of the box with the smallest coordinates, robot frame [m].
        high: Corner of the box with the largest coordinates, robot frame [m].
    """

    def __init__(self, config: HopperConfig, low: Vector, high: Vector) -> None:
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
        """Whether two balls bridge the outlet."""
        self._low, self._high = np.array(low), np.array(high)
        self._axis, self._sign = FACES[config.outlet]
        self._plane = self._sign * (high if self._sign > 0 else low)[self._axis]
        self._across = 0 if self._axis == 1 else 1
        self._up = 0 if self._axis == 2 else 2
        height = config.outlet_height or config.outlet_width
        self._half = 0.5 * config.outlet_width, 0.5 * height
        middle = 0.5 * (self._low + self._high)
        floor = low[2] + 0.5 * height if self._up == 2 else float(middle[0])
        self._middle = config.outlet_place or (float(middle[self._across]), floor)
        inlet = config.inlet or OPPOSITE[config.outlet]
        self._inlet = FACES[inlet]
        axis, sign = FACES[OPPOSITE[inlet] if config.outlet == "bottom" else config.outlet]
        self._belt = np.zeros(3)
        self._belt[axis] = sign
        # position of the start of the funnel, as (negative) distance through the outlet
        self._fore = -math.tan(config.funnel) * float(self._high[self._across] - self._low[self._across])
        self._limits = self.pos, self.pos  # lower and upper limits of the balls' centers
        self._innermost = self.radius

    # --- contents ---------------------------------------------------------------------------------------------------

    def follow(self, slots: Sequence[int], radii: Sequence[float], places: Sequence[Vector]) -> None:
        """Update the contents; new balls enter at the inlet, or elsewhere in the box if the inlet is occupied.

        Args:
            slots: Slots of all pieces in the hopper.
            radii: Radii of all pieces in the hopper [m].
            places: Positions to try if the inlet is occupied, robot frame [m].
        """
        sizes = np.array(radii)
        if slots == self.slots and np.array_equal(sizes, self.radius):
            return
        rows = {slot: row for row, slot in enumerate(self.slots)}
        placed = [number for number, slot in enumerate(slots) if slot in rows]
        kept = [rows[slots[number]] for number in placed]
        pos, vel = np.zeros((len(slots), 3)), np.zeros((len(slots), 3))
        pos[placed], vel[placed] = self.pos[kept], self.vel[kept]
        self.is_jammed = self.is_jammed and len(kept) > 1
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
        center = 0.5 * (self._low + self._high)
        low, high = np.minimum(self._low + sizes[:, None], center), np.maximum(self._high - sizes[:, None], center)
        self._limits = low, high
        self._innermost = np.minimum(self._sign * low[:, self._axis], self._sign * high[:, self._axis])

    def room_at_inlet(self, size: float) -> int:
        """Return the number of balls of a given radius [m] that can enter side by side now."""
        candidates = self._inlets(size)
        count, last = 0, -math.inf
        for place in candidates[
            _clearances(candidates, size, self.pos, self.radius) >= 0.0, 1 - self._inlet[0]
        ].tolist():
            if place - last >= 2.0 * _FREE * size:
                count, last = count + 1, place
        return count

    def at_outlet(self) -> list[int]:
        """Return the slots of the balls whose centers are past the outlet, foremost first."""
        ahead = self._sign * self.pos[:, self._axis] - self._plane
        rows = np.argsort(-ahead, kind="stable")
        return [self.slots[row] for row in rows.tolist() if ahead[row] >= 0.0]

    def _inlets(self, size: float) -> FloatArray:
        """Return positions along the top of the inlet's wall, less than a diameter apart [m], shape (m, 3)."""
        axis, sign = self._inlet
        low, high = self._low + size, self._high - size
        places = np.tile(high if sign > 0 else low, (1 + max(0, math.floor((high - low)[1 - axis] / (0.5 * size))), 1))
        places[:, 1 - axis] = np.linspace(low[1 - axis], high[1 - axis], len(places))
        places[:, 2] = high[2]
        return places

    # --- motion -----------------------------------------------------------------------------------------------------

    def advance(self, pull: Vector, spin: Vector, turn: Vector, belt_speed: float) -> bool:
        """Advance the balls by one tick.

        Args:
            pull: Gravity minus the acceleration of the robot's origin, robot frame [m/s^2].
            spin: Angular velocity of the robot, robot frame [rad/s].
            turn: Angular acceleration of the robot, robot frame [rad/s^2].
            belt_speed: Speed of the belt, positive toward the outlet [m/s].

        Returns:
            Whether the outlet has just jammed.
        """
        if not self.slots or not all(map(math.isfinite, (*pull, *spin, *turn, belt_speed))):
            return False
        s, a = (np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0))) for x, y, z in (spin, turn))
        fields = np.array(pull) - np.einsum("ij,kj->ik", self.pos, np.einsum("ij,jk->ik", s, s) + a)
        fields -= 2.0 * np.einsum("ij,kj->ik", self.vel, s)
        was_jammed, self.is_jammed = self.is_jammed, self._step(fields, belt_speed)
        return self.is_jammed and not was_jammed

    def _step(self, pull: FloatArray, belt_speed: float) -> bool:
        """Advance by one tick under accelerations (n, 3) [m/s^2]; return whether the outlet is jammed."""
        h, grip = TICK / _STEPS, self.config.friction if abs(belt_speed) > _STANDS else _LEVER / (1.4 * self.radius)
        drag = grip * np.maximum(0.0, -pull[:, 2])  # [m/s^2]; friction of balls on the floor
        belt = belt_speed * self._belt
        jammed = np.zeros(len(self.slots), dtype=np.bool_)
        n, (i, j) = len(self.slots), self._pairs(pull)
        ends, others, touch = np.concatenate((i, j)), np.concatenate((j, i)), self.radius[i] + self.radius[j]
        for _ in range(_STEPS):
            held = np.where(self._floor_depth(self.pos) > -_TOUCH * self.radius, drag, 0.0)
            jammed = self._bridging(pull, held * np.sign(belt_speed))
            vel = self.vel + h * pull
            slip = belt - vel
            slip[:, 2] = 0.0
            size = np.sqrt(np.einsum("ij,ij->i", slip, slip))
            vel += slip * np.minimum(1.0, h * held / np.maximum(size, 1e-9))[:, None]
            np.maximum(np.minimum(vel, _FASTEST, out=vel), -_FASTEST, out=vel)
            vel[jammed] = 0.0
            pos = self.pos + h * vel
            between = pos[i] - pos[j]
            gap = np.sqrt(np.einsum("ij,ij->i", between, between))
            deep = _SHARE * np.maximum(0.0, touch / np.maximum(gap, 1e-6) - 1.0)
            away = deep[:, None] * between
            gives = np.where(jammed[ends], 0.0, np.where(jammed[others], 1.0, 0.5))  # a jammed ball does not move
            pos += _sums(ends, gives[:, None] * np.concatenate((away, -away)), n)
            self._keep_inside(pos)
            pos[jammed] = self.pos[jammed]
            vel = (pos - self.pos) / h
            rubs = np.where(deep > 0.0, _RUBBING * h, 0.0)[:, None] * (vel[j] - vel[i])
            self.vel = vel + _sums(ends, np.concatenate((rubs, -rubs)), n)
            self.pos = pos
        return bool(jammed.any())

    def _pairs(self, pull: FloatArray) -> tuple[IntArray, IntArray]:
        """Return the rows of all pairs of balls that could touch within a tick."""
        between = self.pos[:, None] - self.pos[None]
        gap = np.sqrt(np.einsum("ijk,ijk->ij", between, between))
        fastest = min(_FASTEST, float(np.abs(self.vel).max()) + TICK * float(np.abs(pull).max()))
        reach = self.radius[:, None] + self.radius[None] + 2.0 * TICK * fastest
        i, j = np.nonzero(np.triu(gap < reach, 1))
        return i, j

    def _keep_inside(self, pos: FloatArray) -> None:
        """Move balls out of the outlet's edges, the floor and the walls."""
        axis, sign = self._axis, self._sign
        ahead, across, up, window = self._at_opening(pos)
        rows = np.nonzero(ahead > self._fore - 2.0 * self.radius)[0]
        if len(rows):
            r, through = self.radius[rows], window[rows] & (ahead[rows] > -self.radius[rows])
            for side in (1.0, -1.0):
                normal, away = self._beside_outlet(ahead[rows], side * across[rows])
                deep = np.maximum(0.0, r - away)
                pos[rows, axis] += sign * deep * normal[0]
                pos[rows, self._across] += side * deep * normal[1]
                over = self._half[1] - side * up[rows]
                away = np.hypot(ahead[rows], over)
                deep = np.where(through, np.maximum(0.0, r / np.maximum(away, 1e-9) - 1.0), 0.0)
                pos[rows, axis] += sign * deep * ahead[rows]
                pos[rows, self._up] -= side * deep * over
            for half, middle, along in zip(self._half, self._middle, (self._across, self._up), strict=True):
                most = np.where(through & (ahead[rows] > 0.0), np.maximum(0.0, half - r), np.inf)  # inside the outlet
                pos[rows, along] = np.minimum(np.maximum(pos[rows, along], middle - most), middle + most)
        if axis != 2:
            floor = np.maximum(0.0, self._floor_depth(pos))
            pos[:, 2] += floor * math.cos(self.config.slope)
            pos[:, axis] += sign * math.sin(self.config.slope) * floor
        low, high = self._limits
        outermost = np.where(window, self._plane + self.radius, self._plane - self.radius)  # stop at the feeder or wall
        ahead = np.minimum(sign * pos[:, axis], np.maximum(outermost, self._innermost))
        np.minimum(np.maximum(pos, low, out=pos), high, out=pos)
        pos[:, axis] = sign * np.maximum(ahead, self._innermost)

    def _beside_outlet(self, ahead: FloatArray, across: FloatArray) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
        """Return the normal and distance [m] of the nearest wall, funnel or edge on one side of the outlet.

        Args:
            ahead: Distance of each ball through the outlet [m], shape (n,).
            across: Distance of each ball from the outlet's center toward this side [m], shape (n,).
        """
        c, s = math.cos(self.config.funnel), math.sin(self.config.funnel)
        out = across - self._half[0]
        at_edge = out * c < ahead * s  # whether the edge is nearer than the wall
        away = np.where(at_edge, np.hypot(ahead, out), -ahead * c - out * s)
        size = np.maximum(away, 1e-9)
        return (np.where(at_edge, ahead / size, -c), np.where(at_edge, out / size, -s)), away

    def _at_opening(self, pos: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
        """Return the distances of balls through, across and up from the outlet's center [m], and whether they align."""
        ahead = self._sign * pos[:, self._axis] - self._plane
        across, up = pos[:, self._across] - self._middle[0], pos[:, self._up] - self._middle[1]
        window: BoolArray = (np.abs(across) < self._half[0]) & (np.abs(up) < self._half[1])
        return ahead, across, up, window

    def _floor_depth(self, pos: FloatArray) -> FloatArray:
        """Return the overlap of balls with the floor [m]; negative for balls above the floor."""
        slope = self.config.slope
        height = pos[:, 2] - self._low[2]
        if slope:
            height = height - math.tan(slope) * np.maximum(0.0, self._plane - self._sign * pos[:, self._axis])
        depth: FloatArray = self.radius - height * math.cos(slope)
        return depth

    def _bridging(self, pull: FloatArray, drag: FloatArray) -> BoolArray:
        """Return whether each ball is part of an arch that blocks the outlet, shape (n,).

        Args:
            pull: Gravity minus the acceleration of the robot at each ball [m/s^2], shape (n, 3).
            drag: Acceleration of each ball by the belt, positive in the belt's direction [m/s^2], shape (n,).
        """
        held = np.zeros(len(self.slots), dtype=np.bool_)
        ahead, across, up, _ = self._at_opening(self.pos)
        rows = np.nonzero((ahead < 0.0) & (ahead > self._fore - 2.0 * self.radius) & (np.abs(up) < self._half[1]))[0]
        if len(rows) < 2:
            return held
        reach = self.radius[rows] * (1.0 + _TOUCH)
        ends = [self._beside_outlet(ahead[rows], side * across[rows]) for side in (1.0, -1.0)]
        at_left, at_right = (np.nonzero(away < reach)[0].tolist() for _, away in ends)
        for left in at_left:
            for right in at_right:
                i, j = int(rows[left]), int(rows[right])
                apart, touch = self.pos[i] - self.pos[j], self.radius[i] + self.radius[j]
                if i == j or abs(apart[self._up]) > 0.25 * touch or apart @ apart > ((1.0 + _TOUCH) * touch) ** 2:
                    continue
                between = (-self._sign * float(apart[self._axis]), -float(apart[self._across]))
                driven = pull + drag[:, None] * self._belt
                pulls = [(self._sign * float(driven[r, self._axis]), float(driven[r, self._across])) for r in (i, j)]
                normals = [
                    (float(n[row]), side * float(m[row]))
                    for ((n, m), _), row, side in zip(ends, (left, right), (1.0, -1.0), strict=True)
                ]
                if arch_holds(normals, between, pulls, self.config.friction):
                    held[[i, j]] = True
        return held


def arch_holds(
    normals: Sequence[tuple[float, float]],
    between: tuple[float, float],
    pulls: Sequence[tuple[float, float]],
    friction: float,
) -> bool:
    """Return whether an arch of two balls holds: the balls touch each other, and each touches a wall or an edge.

    Each ball, of equal mass, has two contacts. By torque balance, both contacts have the same friction force T; the
    force balance of two balls in two directions gives T and the three normal forces. The arch holds if all normal
    forces are positive and T <= mu N at each contact.

    Args:
        normals: Unit normal from the wall or edge to each ball, in the plane through and across the outlet.
        between: Vector from the first ball to the second ball [m].
        pulls: External force per mass on each ball [m/s^2].
        friction: Coefficient of friction mu [-].

    Example: Two balls side by side at an opening of 1.5 diameters, pulled through the opening and away from it.

    >>> edges = ((-0.866, -0.5), (-0.866, 0.5))
    >>> [arch_holds(edges, (0.0, -2.0), (pull, pull), 0.5) for pull in ((1.0, 0.0), (-1.0, 0.0))]
    [True, False]
    """
    length = math.hypot(*between)
    if length < 1e-9:
        return False
    bx, by = between[0] / length, between[1] / length
    (px, py), (qx, qy) = normals
    # columns: normal forces at both ends and between the balls, friction
    rows = np.array((
        (px, 0.0, -bx, py + by), (py, 0.0, -by, -px - bx), (0.0, qx, bx, qy - by), (0.0, qy, by, -qx + bx)
    ))  # fmt: skip
    if abs(float(np.linalg.det(rows))) < 1e-6:
        return False
    *presses, rubs = np.linalg.solve(rows, -np.array(pulls).ravel()).tolist()
    return bool(min(presses) > 0.0 and abs(rubs) <= friction * min(presses))


def _sums(rows: IntArray, vectors: FloatArray, n: int) -> FloatArray:
    """Sum vectors by their row numbers, from 0 to n - 1; return the sums, shape (n, 3)."""
    return np.stack([np.bincount(rows, vectors[:, axis], n) for axis in range(3)], axis=1)


def _clearances(candidates: FloatArray, size: float, pos: FloatArray, radius: FloatArray) -> FloatArray:
    """Return the smallest clearance between a new ball at each candidate position and existing balls [m], shape (m,).

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
