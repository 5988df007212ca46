"""The robots of a world: their records, what their bumpers touch, and the step that moves them.

In the plane of the floor the loop moves robots by their tires and bumpers (`simcore.loop.robots`); the engine keeps
their bodies: ramps, what lifts and tips them, and pieces that are no balls. Robots that lie, or stand on another one,
meet walls and robots in the engine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NoReturn, Protocol

import numpy as np
import numpy.typing as npt

from simcore.errors import EngineError
from simcore.geometry.rotation import Quaternion, Vector, matrix
from simcore.loop.robot_state import (
    BATTERY,
    OUTLINE,
    PART,
    ROBOT,
    SHAFT,
    SPRING,
    WHEEL,
    Records,
    join,
    records,
)
from simcore.loop.robots import begin_robots, end_robots, move_robots, prepare
from simcore.physics.contact_law import TerrainSurface
from simcore.physics.engine import Engine
from simcore.physics.shapes import Compound, Mesh, Part, Shape, outline, outline_points
from simcore.typing import FloatArray

__all__ = ["BumperPart", "DrivenRobot", "RobotDynamics", "is_met_in_plan", "slice_between"]

_BAND = 0.02  # [m]; outlines of elements are made for heights of whole multiples, a little below what is asked for
_LOW = 0.1  # [m]; what does not stand higher is for wheels and frames
_LIFT = 0.001  # [m]; a robot that has risen or sunk by less meets the same outlines
_THIN = 1e-5  # [m^2]; what an element has less of at a height is not met there
_SPRINGS = 64  # contacts of a robot whose friction is remembered
_COVERED = 1e-3  # [m]; what is so near outside of a side is looked at, whether another outline covers it


@dataclass(frozen=True, slots=True, kw_only=True)
class BumperPart:
    """A rectangle of what meets walls and robots: bumpers, or the frame above them."""

    x: float
    """Middle, robot frame [m]."""
    y: float
    half_length: float
    """[m]"""
    half_width: float
    bottom: float
    """Lower edge above the carpet [m]."""
    top: float
    """Upper edge [m]."""
    friction: float
    """Factor, as of a surface [-]."""
    restitution: float
    """Factor, as of a surface [-]."""
    stiffness: float
    """Force over depth and length of the side that touches [N/m^2]."""


class DrivenRobot(Protocol):
    """What the loop asks a robot before a step."""

    needs_steps: bool
    """Whether `before_step` is to be called in each step, though it stands level."""

    def before_step(self, h: float, *, is_level: bool) -> None:
        """Note which wheels touch, and what drives a chassis without a drivetrain; pose and velocity are known."""
        ...


class _Wheels(Protocol):
    """A drivetrain with records of its own, which go into those of the world."""

    robot_record: Records
    shafts: Records
    wheel_records: Records
    battery: Any


class _Shaft(Protocol):
    """A mechanism, likewise."""

    record: Records


def is_met_in_plan(shape: Shape, pos: Vector, quat: Quaternion) -> bool:
    """Whether bumpers meet a static of this shape at a place by its outline.

    What is not convex is the engine's, and what is so low that wheels or the frame's lower edge meet it.
    """
    if isinstance(shape, Mesh):
        return False
    return bool((outline_points(shape) @ matrix(quat).T)[:, 2].max() + pos[2] > _LOW)


class RobotDynamics:
    """All robots of a world.

    Args:
        engine: Whose bodies they are.
        collisions: Group and mask of robots that stand, and of those that meet walls and robots in the engine.
    """

    def __init__(self, engine: Engine, collisions: tuple[tuple[int, int], tuple[int, int]]) -> None:
        self._engine, self._collisions = engine, collisions
        self._driven: list[DrivenRobot | None] = []
        self._drives: list[_Wheels | None] = []
        self._mechanisms: list[Sequence[_Shaft]] = []
        self.robots = records(ROBOT, 0)
        """In the order in which they were added."""
        self._parts, self._shafts, self._wheels = records(PART, 0), records(SHAFT, 0), records(WHEEL, 0)
        self._batteries = records(BATTERY, 0)
        self._springs = records(SPRING, 0).reshape(0, _SPRINGS)
        self._clock = np.zeros(1, np.int64)
        self._told = 0  # brown-outs and resets that were told
        self._rows: list[int] = []
        self._number_of: dict[int, int] = {}
        self._statics: list[tuple[int, tuple[FloatArray, ...], TerrainSurface]] = []
        self._slices: dict[tuple[int, int], tuple[int, int]] = {}
        self._heights: list[float] = []  # of the robots when outlines were chosen [m]
        self._seen: FloatArray = self.robots["seen"]
        self._solid: list[bool] = []  # robots that meet others in the engine
        self._was_level: list[int] = []  # of the robots, in the last step
        self._forget_outlines()

    def _forget_outlines(self) -> None:
        self._outlines, self._hidden = records(OUTLINE, 0), np.zeros(0, np.uint8)
        self._corners, self._normals = np.zeros((0, 2)), np.zeros((0, 2))
        self._slices.clear()
        self._heights = []

    # --- building -------------------------------------------------------------------------------------------------

    def add_static(self, row: int, shape: Shape, pos: Vector, quat: Quaternion, surface: TerrainSurface) -> None:
        """Add what bumpers meet, a static whose origin is at a place [m]."""
        turn = matrix(quat).T
        assert not isinstance(shape, Mesh)
        members = shape.parts if isinstance(shape, Compound) else (Part(shape),)
        corners = [outline_points(p.shape) @ matrix(p.quat).T + np.array(p.offset) for p in members]
        self._statics.append((row, tuple(points @ turn + np.array(pos) for points in corners), surface))
        self._forget_outlines()

    def add_robot(self, row: int, parts: Sequence[BumperPart]) -> int:
        """Add a robot, of an engine row; returns its number."""
        prepare()
        number = len(self._rows)
        self._rows.append(row)
        self._number_of[row] = number
        self._driven.append(None)
        self._drives.append(None)
        self._mechanisms.append(())
        self._solid.append(False)
        self._was_level.append(0)
        self.robots = join((self.robots, records(ROBOT)))
        self._batteries = join((self._batteries, records(BATTERY)))
        self._springs = records(SPRING, (number + 1) * _SPRINGS).reshape(number + 1, _SPRINGS)
        self._springs["stamp"] = -2
        robot = self.robots[number : number + 1]
        robot["row"], robot["is_enabled"], robot["is_put"] = row, 1, 1
        robot["first_part"], robot["last_part"] = len(self._parts), len(self._parts) + len(parts)
        made = records(PART, len(parts))
        for one, part in zip(range(len(parts)), parts, strict=True):
            made["robot"][one] = number
            for name in BumperPart.__slots__:
                made[name][one] = getattr(part, name)
        if parts:
            robot["height"] = parts[0].bottom + parts[0].top
            robot["reach"] = max(math.hypot(abs(p.x) + p.half_length, abs(p.y) + p.half_width) for p in parts)
        self._parts = join((self._parts, made))
        self._heights = []
        self._gather()
        return number

    def bind(
        self,
        number: int,
        driven: DrivenRobot,
        drive: _Wheels | None = None,
        mechanisms: Sequence[_Shaft] = (),
    ) -> None:
        """Say who a robot is, and take the records of its drivetrain and mechanisms among those of the world."""
        self._driven[number] = driven
        if drive is not None:
            robot = self.robots[number]
            for name in ("is_enabled", "drive_shafts", "bus", "time", "other_current"):
                robot[name] = drive.robot_record[name][0]
        self._drives[number], self._mechanisms[number] = drive, mechanisms
        self._gather()

    def _gather(self) -> None:
        """Put all records into arrays of the world, and show their owners where they are."""
        self._seen = self.robots["seen"]
        shafts, wheels, batteries = [records(SHAFT, 0)], [records(WHEEL, 0)], [records(BATTERY, 0)]
        for drive, mechanisms in zip(self._drives, self._mechanisms, strict=True):
            shafts += [] if drive is None else [drive.shafts]
            shafts += [mechanism.record for mechanism in mechanisms]
            wheels += [] if drive is None else [drive.wheel_records]
            batteries.append(records(BATTERY) if drive is None else drive.battery.records)
        self._shafts, self._wheels = join(shafts), join(wheels)
        self._batteries = join(batteries)
        shaft, wheel = 0, 0
        for number, (drive, mechanisms) in enumerate(zip(self._drives, self._mechanisms, strict=True)):
            robot = self.robots[number : number + 1]
            robot["first_shaft"], robot["first_wheel"] = shaft, wheel
            if drive is not None:
                n, m = len(drive.shafts), len(drive.wheel_records)
                drive.robot_record = robot
                drive.shafts, drive.wheel_records = self._shafts[shaft : shaft + n], self._wheels[wheel : wheel + m]
                drive.battery.records = self._batteries[number : number + 1]
                shaft, wheel = shaft + n, wheel + m
            for mechanism in mechanisms:
                mechanism.record = self._shafts[shaft : shaft + 1]
                shaft += 1
            robot["last_shaft"], robot["last_wheel"] = shaft, wheel

    # --- questions ------------------------------------------------------------------------------------------------

    def touching(self, row: int) -> list[int]:
        """Engine rows of the walls and robots that pushed a robot in its last step."""
        if row not in self._number_of:
            return []
        robot = self.robots[self._number_of[row]]
        touched: list[int] = robot["touches"][: robot["touched"]].tolist()
        return touched

    # --- motion ---------------------------------------------------------------------------------------------------

    def look(self, number: int) -> None:
        """Take pose and velocity of a robot's body from the engine into its record.

        Raises:
            EngineError: The engine lost the body (a value is not finite).
        """
        seen = self._engine.state(self._rows[number])
        if not all(map(math.isfinite, seen)):
            self._lost(number)
        self._seen[number] = seen

    def _lost(self, number: int) -> NoReturn:
        pos, vel = self.robots["seen"][number, :3].tolist(), self.robots["seen"][number, 7:10].tolist()
        raise EngineError(f"robot {number}: the engine returned a pose or velocity that is not finite: {pos}, {vel}")

    def advance(self, h: float, gravity: float) -> None:
        """Move all robots for h [s], and tell the engine before its steps of as much."""
        if not self._rows:
            return
        robots = self.robots
        for number, row in enumerate(self._rows):
            self._seen[number] = self._engine.state(row)
        lost = begin_robots(robots, self._parts, gravity)
        if lost >= 0:
            self._lost(lost)
        is_level = robots["is_level"].tolist()
        for driven, level, was_level in zip(self._driven, is_level, self._was_level, strict=True):
            if driven is not None and (driven.needs_steps or not (level and was_level)):
                driven.before_step(h, is_level=bool(level))
        self._was_level = is_level
        if not self._heights or np.abs(robots["z"] - self._heights).max() > _LIFT:
            self._choose_outlines()
        move_robots(
            robots, self._shafts, self._wheels, self._batteries, self._parts, self._outlines, self._corners,
            self._normals, self._hidden, self._springs, self._clock, h,
        )  # fmt: skip
        end_robots(robots, h, gravity)
        given, solid = robots["given"].tolist(), robots["is_solid"].tolist()
        for number, row in enumerate(self._rows):
            self._engine.set_velocity(row, given[number][:3], given[number][3:])
            if bool(solid[number]) is not self._solid[number]:
                self._solid[number] = bool(solid[number])
                self._engine.set_collision(row, *self._collisions[self._solid[number]])
        begun = int(self._batteries["brownouts"].sum() + self._batteries["resets"].sum())
        if begun != self._told:
            self._told = begun
            for drive in self._drives:
                if drive is not None:
                    drive.battery.tell()

    def _choose_outlines(self) -> None:
        """Choose the outlines that the field has at the heights of all parts."""
        heights, parts = self.robots["z"].tolist(), self._parts
        self._heights = heights
        for number, (robot, bottom, top) in enumerate(
            zip(parts["robot"].tolist(), parts["bottom"].tolist(), parts["top"].tolist(), strict=True)
        ):
            low, high = bottom + heights[robot], top + heights[robot]
            parts["low"][number], parts["high"][number] = low, high
            parts["first_outline"][number], parts["last_outline"][number] = self._slice(
                math.floor(low / _BAND + 0.25), math.floor(high / _BAND + 0.25)
            )

    def _slice(self, low: int, high: int) -> tuple[int, int]:
        """The outlines of all statics between two heights, in `_BAND`: the first, and the one behind the last."""
        if (low, high) not in self._slices:
            found, polygons = [], []
            for row, members, surface in self._statics:
                for points in members:
                    corners = slice_between(points, low * _BAND, high * _BAND)
                    if len(corners) > 2:
                        polygons.append(corners)
                        found.append((row, float(points[:, 2].min()), float(points[:, 2].max()), surface))
            made = records(OUTLINE, len(found))
            at = len(self._corners)
            for one, (row, bottom, top, surface), corners in zip(range(len(found)), found, polygons, strict=True):
                made["row"][one], made["bottom"][one], made["top"][one] = row, bottom, top
                made["first"][one], made["last"][one] = at, at + len(corners)
                (made["low_x"][one], made["low_y"][one]), (made["high_x"][one], made["high_y"][one]) = (
                    corners.min(axis=0),
                    corners.max(axis=0),
                )
                made["friction"][one], made["restitution"][one] = surface.friction, surface.restitution
                at += len(corners)
            self._slices[low, high] = len(self._outlines), len(self._outlines) + len(made)
            self._outlines = join((self._outlines, made))
            self._corners = np.concatenate((self._corners, *polygons)) if polygons else self._corners
            normals = [_outward(corners) for corners in polygons]
            self._normals = np.concatenate((self._normals, *normals)) if polygons else self._normals
            boxes = np.array([(*corners.min(axis=0), *corners.max(axis=0)) for corners in polygons]).reshape(-1, 4)
            hidden = [_covered(k, polygons, normals, boxes) for k in range(len(polygons))]
            self._hidden = np.concatenate((self._hidden, *hidden)) if polygons else self._hidden
        return self._slices[low, high]


def _outward(corners: FloatArray) -> FloatArray:
    """Unit vectors outward from the sides after each corner of a convex outline, shape (n, 2)."""
    along = np.roll(corners, -1, axis=0) - corners
    normals: FloatArray = np.column_stack((along[:, 1], -along[:, 0])) / np.linalg.norm(along, axis=1)[:, None]
    return normals


def _covered(
    number: int, polygons: Sequence[FloatArray], normals: Sequence[FloatArray], boxes: FloatArray
) -> npt.NDArray[np.uint8]:
    """Which sides of an outline others cover from end to end, shape (n,): nothing can come at them.

    Args:
        number: Of the outline.
        polygons: Corners of all outlines [m].
        normals: Of their sides.
        boxes: Around each outline: low x, low y, high x, high y [m], shape (m, 4).
    """
    corners = polygons[number]
    after = np.roll(corners, -1, axis=0)
    covered = np.zeros(len(corners), np.uint8)
    for k in range(len(corners)):
        shares = np.array([0.02, 0.5, 0.98])[:, None]
        places = corners[k] + shares * (after[k] - corners[k]) + _COVERED * normals[number][k]
        inside = np.zeros(len(places), dtype=bool)
        near = (boxes[:, :2] <= places.max(axis=0)).all(axis=1) & (boxes[:, 2:] >= places.min(axis=0)).all(axis=1)
        for other in np.nonzero(near)[0].tolist():
            if other != number:
                away = ((places[:, None, :] - polygons[other][None]) * normals[other][None]).sum(axis=2)
                inside |= (away < 0.0).all(axis=1)
        covered[k] = inside.all()
    return covered if not covered.all() else np.zeros_like(covered)


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
