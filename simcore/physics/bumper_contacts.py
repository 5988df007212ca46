"""Robots against walls and robots: Coulomb contact in the plane of the floor, the same on every engine.

An engine gives two boxes one contact at an edge, whose friction works along and up at once: a robot that slides along a
wall climbs it. Here the bumpers' outline meets the outline that an element has at their height, with contacts at both
ends of the overlap, and friction acts against the sliding. Each robot says before its step how it would move; what the
contacts change of that is given to its body and back to its chassis. The engine keeps floors, ramps and pieces, and
robots that stand too far from upright for an outline in plan.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from simcore.geometry.rotation import Quaternion, Vector, matrix, rotate, rotate_back
from simcore.physics.contact_law import TerrainSurface, pair_friction, pair_restitution
from simcore.physics.engine import Engine
from simcore.physics.nearness import PlanOutlines, StaticBoxes
from simcore.physics.planar_contacts import PlanarBody, PlanarContact, Polygon, manifold, solve_contacts
from simcore.physics.shapes import Compound, HalfSpace, Mesh, Part, Shape, outline, outline_points
from simcore.typing import FloatArray

__all__ = ["BumperContacts", "BumperOutline", "RobotMotion", "slice_between"]

_UPRIGHT = math.cos(math.radians(25.0))  # of the tilt; a bump's 16 degrees with some to spare
_BAND = 0.02  # [m]; outlines of elements are made for heights of whole multiples
_AHEAD = 0.005  # [m]; contacts are looked for this much farther than both move in a step
_THIN = 1e-5  # [m^2]; what an element has less of at a height is not met there


class BumperOutline(NamedTuple):
    """What of a robot meets walls and robots."""

    parts: tuple[tuple[float, float, float, float], ...]
    """Rectangles, robot frame: middle x, y, half length, half width [m]."""
    bottom: float
    """Lower edge above the carpet [m]."""
    top: float
    """Upper edge [m]."""
    friction: float
    """Factor, as of a surface [-]."""
    restitution: float
    """Factor, as of a surface [-]."""


@dataclass(slots=True, kw_only=True, eq=False)
class RobotMotion(PlanarBody):
    """How a robot would move in its next step, and what contacts change of it."""

    row: int
    h: float
    """[s]"""
    pos: Vector
    """Of its origin, field frame [m]."""
    quat: Quaternion
    hold: float = 0.0
    """Angular impulse that its weight takes without a wheel coming off [N m s]."""
    held: tuple[float, float] = (0.0, 0.0)
    """Of that, what it takes of its tires, in roll and pitch, robot axes [N m s]."""
    mean_change: Vector = (0.0, 0.0, 0.0)
    """Of the mean velocity, by contacts."""
    end_change: Vector = (0.0, 0.0, 0.0)
    """Of that at the end."""
    height: float = 0.0
    """Of the contacts above the robot's origin, the mean by impulses [m]."""
    touched: list[int] = field(default_factory=list)
    """Rows of the statics and robots that it was pushed by."""


class BumperContacts:
    """Contacts of all robots of a world.

    Args:
        engine: Whose bodies they move.
        outlines: Of the statics, in the order of `add_static`.
        boxes: Of those that robots do not drive on.
        collisions: Group and mask of robots that pass each other in the engine, and of those that do not.
    """

    def __init__(
        self,
        engine: Engine,
        outlines: PlanOutlines,
        boxes: StaticBoxes,
        collisions: tuple[tuple[int, int], tuple[int, int]],
    ) -> None:
        self._engine, self._outlines, self._boxes = engine, outlines, boxes
        self._collisions = collisions
        self._solid: set[int] = set()  # rows of the robots that meet others in the engine
        self._statics: list[tuple[int, tuple[FloatArray, ...], TerrainSurface]] = []
        self._slices: dict[tuple[int, int, int], list[tuple[Polygon, float]]] = {}
        self._robots: dict[int, BumperOutline] = {}
        self._waiting: dict[int, RobotMotion] = {}
        self._last: dict[int, RobotMotion] = {}

    def add_static(
        self, row: int, shape: Shape, pos: Vector, quat: Quaternion, surface: TerrainSurface, *, is_solid: bool
    ) -> None:
        """Add a static whose origin is at a place [m]; robots pass through one that is not solid."""
        parts: tuple[FloatArray, ...] = ()
        if is_solid and not isinstance(shape, Mesh | HalfSpace):  # what is not convex is the engine's
            turn = matrix(quat).T
            members = shape.parts if isinstance(shape, Compound) else (Part(shape),)
            corners = [outline_points(p.shape) @ matrix(p.quat).T + np.array(p.offset) for p in members]
            parts = tuple(points @ turn + np.array(pos) for points in corners)
        self._statics.append((row, parts, surface))

    def add_robot(self, row: int, bumpers: BumperOutline) -> None:
        """Add a robot."""
        self._robots[row] = bumpers

    def touching(self, row: int) -> list[int]:
        """Rows of the walls and robots that pushed a robot in its last step."""
        return self._last[row].touched if row in self._last else []

    def submit(self, motion: RobotMotion) -> None:
        """Say how a robot would move from now on; before the next step of the engine, `resolve` follows."""
        self._waiting[motion.row] = motion

    def resolve(self) -> None:
        """Let the robots that have begun a step since the last call touch walls and each other."""
        if not self._waiting:
            return
        motions = [self._waiting[row] for row in sorted(self._waiting)]
        self._waiting.clear()
        placed = [_Placed(motion, self._robots[motion.row]) for motion in motions if motion.row in self._robots]
        for one in placed:
            self._last[one.motion.row] = one.motion
            if one.is_upright:
                self._meet_statics(one)
        solid: set[int] = set()
        for number, one in enumerate(placed):
            for other in placed[number + 1 :]:
                if math.hypot(one.x - other.x, one.y - other.y) < one.radius + other.radius + one.reach + other.reach:
                    if one.is_upright and other.is_upright and max(one.low, other.low) < min(one.high, other.high):
                        _meet(one, other)
                    else:
                        solid |= {one.motion.row, other.motion.row}
        for one in placed:
            row = one.motion.row
            if (row in solid) is not (row in self._solid):
                self._engine.set_collision(row, *self._collisions[row in solid])
                self._solid ^= {row}
        left = [one for one in placed if one.contacts]
        while left:  # each group on its own: what touches elsewhere changes no bit of it
            group, found = [left[0]], True
            while found:
                more = [one for one in left if one not in group and any(one in other.partners for other in group)]
                group += more
                found = bool(more)
            left = [one for one in left if one not in group]
            self._solve(group)

    def _meet_statics(self, one: _Placed) -> None:
        x, y, low, high = one.x, one.y, one.low, one.high
        if self._boxes.is_clear(x, y, one.radius + one.reach):
            return
        grown = one.radius + one.reach
        for number in np.nonzero(self._outlines.met(x, y, 0.0, grown, grown, low, high))[0].tolist():
            row, _, surface = self._statics[number]
            for polygon, height in self._slice(number, round(low / _BAND), round(high / _BAND)):
                for mine in one.polygons:
                    for px, py, nx, ny, gap in manifold(mine, polygon, one.reach):
                        contact = PlanarContact(
                            *(one.motion, None, px, py, nx, ny, gap),
                            friction=pair_friction(one.bumpers.friction, surface.friction),
                            restitution=pair_restitution(one.bumpers.restitution, surface.restitution),
                        )
                        one.contacts.append((contact, row, height))

    def _slice(self, number: int, low: int, high: int) -> list[tuple[Polygon, float]]:
        """Outlines of a static between two heights, in `_BAND`, and the middle of the heights where it is met."""
        key = number, low, high
        if key not in self._slices:
            found = []
            for points in self._statics[number][1]:
                corners = slice_between(points, low * _BAND, high * _BAND)
                if len(corners) > 2:
                    bottom, top = max(low * _BAND, points[:, 2].min()), min(high * _BAND, points[:, 2].max())
                    rows: list[tuple[float, float]] = [(x, y) for x, y in corners.tolist()]
                    found.append((Polygon(rows), 0.5 * float(bottom + top)))
            self._slices[key] = found
        return self._slices[key]

    def _solve(self, group: Sequence[_Placed]) -> None:
        contacts: dict[int, PlanarContact] = {}
        for one in group:
            contacts.update((id(contact), contact) for contact, _, _ in one.contacts)
        changes = solve_contacts([one.motion for one in group], list(contacts.values()), group[0].motion.h)
        for one, (mean, end) in zip(group, changes, strict=True):
            motion = one.motion
            motion.mean_change, motion.end_change = mean, end
            pushes = [(contact.normal, row, height) for contact, row, height in one.contacts if contact.normal > 0.0]
            motion.touched = sorted({row for _, row, _ in pushes})
            if pushes:
                total = math.fsum(push for push, _, _ in pushes)
                height = math.fsum(push * height for push, _, height in pushes) / total
                motion.height = height - motion.pos[2]
                self._move(motion, height - motion.center[2])
            elif any(mean):
                self._move(motion, 0.0)

    def _move(self, motion: RobotMotion, lever: float) -> None:
        """Give the change to the body: in the plane, and what of the push over its height is more than it stands."""
        (vx, vy, vz), (wx, wy, wz) = self._engine.velocity(motion.row)
        dx, dy, turn = motion.mean_change
        ex, ey, _ = motion.end_change
        roll, pitch, _ = rotate_back(motion.quat, (-lever * motion.mass * ey, lever * motion.mass * ex, 0.0))
        roll, pitch = roll + motion.held[0], pitch + motion.held[1]
        if math.hypot(roll, pitch) > motion.hold:
            ax, ay, _ = rotate(motion.quat, (roll / motion.inertia[0], pitch / motion.inertia[1], 0.0))
            wx, wy = wx + ax, wy + ay
        self._engine.set_velocity(motion.row, (vx + dx, vy + dy, vz), (wx, wy, wz + turn))


class _Placed:
    """A robot in a step: where its bumpers are, and its contacts."""

    def __init__(self, motion: RobotMotion, bumpers: BumperOutline) -> None:
        self.motion, self.bumpers = motion, bumpers
        (ax, ay, _), (bx, by, _) = rotate(motion.quat, (1.0, 0.0, 0.0)), rotate(motion.quat, (0.0, 1.0, 0.0))
        up = rotate(motion.quat, (0.0, 0.0, 1.0))
        self.is_upright = up[2] > _UPRIGHT
        middle = 0.5 * (bumpers.bottom + bumpers.top)
        self.x, self.y = motion.pos[0] + up[0] * middle, motion.pos[1] + up[1] * middle
        z, half = motion.pos[2] + up[2] * middle, 0.5 * (bumpers.top - bumpers.bottom)
        self.low, self.high = z - half, z + half
        self._axes = (ax, ay), (bx, by)
        self._polygons: list[Polygon] = []
        self.radius = max([math.hypot(abs(x) + length, abs(y) + width) for x, y, length, width in bumpers.parts])
        fastest = max(math.hypot(motion.start[0], motion.start[1]), math.hypot(motion.mean[0], motion.mean[1]))
        turning = max(abs(motion.start[2]), abs(motion.mean[2]))
        self.reach = motion.h * (fastest + turning * self.radius) + _AHEAD
        self.contacts: list[tuple[PlanarContact, int, float]] = []
        """With the row of the other, and the height [m]."""
        self.partners: list[_Placed] = []

    @property
    def polygons(self) -> list[Polygon]:
        """Outlines of its bumpers in plan; most robots are near nothing and need none."""
        if not self._polygons:
            (ax, ay), (bx, by) = self._axes
            self._polygons = [
                Polygon.rectangle(
                    self.x + ax * x + bx * y,
                    self.y + ay * x + by * y,
                    (length * ax, length * ay),
                    (width * bx, width * by),
                )
                for x, y, length, width in self.bumpers.parts
            ]
        return self._polygons


def _meet(one: _Placed, other: _Placed) -> None:
    """Find the contacts of two robots."""
    height, reach = 0.5 * (max(one.low, other.low) + min(one.high, other.high)), one.reach + other.reach
    friction = pair_friction(one.bumpers.friction, other.bumpers.friction)
    restitution = pair_restitution(one.bumpers.restitution, other.bumpers.restitution)
    for mine in one.polygons:
        for theirs in other.polygons:
            for x, y, nx, ny, gap in manifold(mine, theirs, reach):
                contact = PlanarContact(one.motion, other.motion, x, y, nx, ny, gap, friction, restitution)
                one.contacts.append((contact, other.motion.row, height))
                other.contacts.append((contact, one.motion.row, height))
                one.partners.append(other)
                other.partners.append(one)


def slice_between(points: FloatArray, low: float, high: float) -> FloatArray:
    """Outline in plan of what a convex shape has between two heights.

    Args:
        points: Its corners [m], shape (n, 3).
        low: [m]
        high: [m]

    Returns:
        Corners, counter-clockwise [m], shape (m, 2); none where it has nothing there.
    """
    z = points[:, 2]
    found = [points[(z >= low) & (z <= high), :2]]
    for level in (low, high):
        below, above = points[z < level], points[z > level]
        if len(below) and len(above):  # the lines between all of them are in the shape, and its edges among them
            share = (level - below[:, 2])[:, None] / (above[None, :, 2] - below[:, None, 2])
            cut = below[:, None, :2] + share[..., None] * (above[None, :, :2] - below[:, None, :2])
            found.append(cut.reshape(-1, 2))
    corners = np.vstack(found)
    if len(corners) < 3:
        return np.zeros((0, 2))
    corners = outline(np.unique(corners.round(9), axis=0))
    x, y = corners.T
    area = 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    return corners if len(corners) > 2 and area > _THIN else np.zeros((0, 2))
