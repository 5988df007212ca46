"""Robots of a world: records for the compiled loop, mass properties, and the field outlines that bumpers can touch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NoReturn, Protocol

import numpy as np
import numpy.typing as npt

from simcore.errors import ConfigError, EngineError
from simcore.loop.robot_state import (
    BATTERY,
    OUTLINE,
    PART,
    POINT,
    ROBOT,
    SHAFT,
    SPRING,
    SPRINGS,
    STEP,
    WHEEL,
    Fleet,
    Records,
    join,
    records,
)
from simcore.loop.robots import settle
from simcore.loop.solids import Solids
from simcore.loop.step import prepare
from simcore.typing import FloatArray
from simcore.units import GRAVITY
from simcore.world.bodies import Bodies
from simcore.world.contact_law import TerrainSurface
from simcore.world.rotation import Quaternion, Vector, from_yaw, matrix
from simcore.world.shapes import Compound, Mesh, Part, Shape, outline, outline_points

__all__ = ["BumperPart", "RecordRows", "RobotDynamics", "is_met_in_plan", "slice_between"]

_BAND = 0.02  # [m]; outlines are computed at multiples of this height, slightly below the requested height
_LOW = 0.1  # [m]; elements below this height touch only wheels and frames
_LIFT = 0.003  # [m]; change of a robot's height below which the outlines are kept
_THIN = 1e-5  # [m^2]; smallest area of an outline that bumpers can touch
_COVERED = 1e-3  # [m]; distance outside a side at which `_covered` tests for other outlines
_SINK = 0.0003  # [m]; compression of the wheels under the robot's weight
_DAMPING_RATIO = 0.9  # of wheels, bumpers and frame on the ground; estimate
_STIFFER = 3.0  # ratio of the stiffness of bumpers and frame to the stiffness of wheels
_POINT_RADIUS = 0.01  # [m]
_ROOM = 64  # largest number of robots in a world
_ABOVE = 0.002  # [m]; height above the ground from which a placed robot settles


@dataclass(frozen=True, slots=True, kw_only=True)
class BumperPart:
    """Rectangular box that collides with walls and robots: the bumpers, or the frame above the bumpers."""

    x: float
    """x coordinate of the center, robot frame [m]."""
    y: float
    """y coordinate of the center, robot frame [m]."""
    half_length: float
    """Half of the length [m]."""
    half_width: float
    """Half of the width [m]."""
    bottom: float
    """Height of the lower edge above the carpet [m]."""
    top: float
    """Height of the upper edge above the carpet [m]."""
    friction: float
    """Friction factor [-]; the coefficient of friction of a pair is the product of the two factors."""
    restitution: float
    """Restitution factor [-]; the coefficient of restitution of a pair is the product of the two factors."""
    stiffness: float
    """Contact force per meter of penetration and per meter of the touching side [N/m^2]."""


class RecordRows:
    """Preallocated array of records of one type; rows in use never change their address in memory.

    Args:
        what: Name of the records, for messages.
        dtype: Type of the records.
        room: Largest number of rows; unused rows take no memory.
    """

    def __init__(self, what: str, dtype: np.dtype[Any], room: int) -> None:
        self._what, self._made, self.count = what, records(dtype, room), 0

    @property
    def taken(self) -> Records:
        """Records in use, a view of the array."""
        return self._made[: self.count]

    def take(self, new: Records) -> Records:
        """Copy new records into the next free rows, and return a view of these rows.

        Raises:
            ConfigError: If too few rows are free.
        """
        first, self.count = self.count, self.count + len(new)
        if self.count > len(self._made):
            raise ConfigError(f"a world has room for {len(self._made)} {self._what}, its robots have {self.count}")
        rows = self._made[first : self.count]
        rows[:] = new
        return rows


class _Wheels(Protocol):
    """Drivetrain with records that `RobotDynamics.bind` replaces by rows of the world's arrays."""

    robot_record: Records
    shafts: Records
    wheel_records: Records
    battery: Any


class _Shaft(Protocol):
    """Mechanism with a record that `RobotDynamics.bind` replaces by a row of the world's array."""

    record: Records


def is_met_in_plan(shape: Shape, pos: Vector, quat: Quaternion) -> bool:
    """Return whether bumpers collide with the plan-view outline of a static, and not with the solids of the static.

    Bumpers collide with the solids of triangle meshes, and of statics with a height of at most 0.1 m, which only wheels
    and the bottom of the frame can touch.
    """
    if isinstance(shape, Mesh):
        return False
    return bool((outline_points(shape) @ matrix(quat).T)[:, 2].max() + pos[2] > _LOW)


class RobotDynamics:
    """Dynamics of all robots of a world.

    Args:
        bodies: All bodies of the world, including the robots.
    """

    def __init__(self, bodies: Bodies) -> None:
        self._bodies = bodies
        self._drives: list[_Wheels | None] = []
        self._robots = RecordRows("robots", ROBOT, _ROOM)
        self._batteries = RecordRows("batteries", BATTERY, _ROOM)
        self._shafts = RecordRows("motors", SHAFT, 64 * _ROOM)
        self._wheels = RecordRows("wheels", WHEEL, 32 * _ROOM)
        self._points = RecordRows("points of contact", POINT, 256 * _ROOM)
        self._parts = RecordRows("parts of bumpers", PART, 16 * _ROOM)
        self._springs = RecordRows("contacts", SPRING, SPRINGS * _ROOM)
        self._clock = np.zeros(1, np.int64)
        self._reported = 0  # number of brownouts and resets reported so far
        self._number_of: dict[int, int] = {}  # robot number by row
        self._statics: list[tuple[int, tuple[FloatArray, ...], TerrainSurface]] = []
        self._slices: dict[tuple[int, int], tuple[int, int]] = {}
        self._fleet: Fleet | None = None
        self._forget_outlines()

    def _forget_outlines(self) -> None:
        self._outlines, self._hidden = records(OUTLINE, 0), np.zeros(0, np.uint8)
        self._corners, self._normals = np.zeros((0, 2)), np.zeros((0, 2))
        self._slices.clear()
        self._heights: list[float] = []  # height of each robot at the last choice of outlines [m]

    @property
    def robots(self) -> Records:
        """Records of the robots, in the order in which they were added."""
        return self._robots.taken

    @property
    def fleet(self) -> Fleet:
        """Records of all robots and field outlines, as an argument for the compiled loop."""
        if self._fleet is None:
            self._fleet = Fleet(
                self.robots, self._shafts.taken, self._wheels.taken, self._batteries.taken, self._parts.taken,
                self._points.taken, self._springs.taken.reshape(-1, SPRINGS), self._outlines, self._corners,
                self._normals, self._hidden, self._clock,
            )  # fmt: skip
        return self._fleet

    # --- building -------------------------------------------------------------------------------------------------

    def add_static(self, row: int, shape: Shape, pos: Vector, quat: Quaternion, surface: TerrainSurface) -> None:
        """Add a static whose outline bumpers can touch; `pos` is the origin of the static, field frame [m]."""
        turn = matrix(quat).T
        assert not isinstance(shape, Mesh)
        members = shape.parts if isinstance(shape, Compound) else (Part(shape),)
        corners = [outline_points(p.shape) @ matrix(p.quat).T + np.array(p.offset) for p in members]
        self._statics.append((row, tuple(points @ turn + np.array(pos) for points in corners), surface))
        self._forget_outlines()

    def add_robot(self, row: int, body: int, parts: Sequence[BumperPart]) -> int:
        """Add a robot and return the number of the robot.

        Args:
            row: Row of the robot's body in the world.
            body: Number of the robot's body in `Bodies`.
            parts: Boxes of bumpers and frame that collide with walls and robots.
        """
        prepare()
        number = len(self._drives)
        self._number_of[row] = number
        self._drives.append(None)
        robot = self._robots.take(records(ROBOT))
        self._batteries.take(records(BATTERY))
        self._springs.take(records(SPRING, SPRINGS))["stamp"] = -2
        robot["request"]["is_enabled"], robot["is_put"], model = 1, 1, robot["model"]
        model["body"] = body
        model["first_part"], model["last_part"] = self._parts.count, self._parts.count + len(parts)
        made = records(PART, len(parts))
        for one, part in zip(range(len(parts)), parts, strict=True):
            made["model"]["robot"][one] = number
            for name in BumperPart.__slots__:
                made["model"][name][one] = getattr(part, name)
        if parts:
            model["reach"] = max(math.hypot(abs(p.x) + p.half_length, abs(p.y) + p.half_width) for p in parts)
            model["low"], model["high"] = min(p.bottom for p in parts), max(p.top for p in parts)
        self._parts.take(made)
        self._forget_outlines()
        return number

    def bind(self, number: int, drive: _Wheels | None = None, mechanisms: Sequence[_Shaft] = ()) -> None:
        """Copy the records of a robot's drivetrain and mechanisms into the arrays of the world.

        Drivetrain and mechanisms then use the rows of these arrays.
        """
        robot = self.robots[number : number + 1]
        model = robot["model"]
        model["first_shaft"], model["first_wheel"] = self._shafts.count, self._wheels.count
        if drive is not None:
            model["drive_shafts"] = drive.robot_record["model"]["drive_shafts"]
            for name in ("request", "bus", "time"):
                robot[name] = drive.robot_record[name]
            battery = self._batteries.taken[number : number + 1]
            battery[:] = drive.battery.records
            drive.robot_record, drive.battery.records = robot, battery
            drive.shafts, drive.wheel_records = self._shafts.take(drive.shafts), self._wheels.take(drive.wheel_records)
        for mechanism in mechanisms:
            mechanism.record = self._shafts.take(mechanism.record)
        model["last_shaft"], model["last_wheel"] = self._shafts.count, self._wheels.count
        self._drives[number], self._fleet = drive, None

    def set_points(self, number: int, wheels: Sequence[Vector], points: Sequence[Vector], radius: float) -> None:
        """Set the contact points of a robot.

        Args:
            number: Number of the robot.
            wheels: Centers of the wheels, robot frame [m].
            points: Contact points of bumpers and frame, centers of spheres of 10 mm radius, robot frame [m].
            radius: Radius of the wheels [m].
        """
        robot, m = self.robots[number]["model"], len(wheels)
        made = records(POINT, m + len(points))
        model = made["model"]
        model["x"], model["y"], model["z"] = zip(*wheels, *points, strict=True)
        model["is_wheel"][:m] = 1
        model["radius"][:m], model["radius"][m:] = radius, _POINT_RADIUS
        robot["first_point"], robot["last_point"] = self._points.count, self._points.count + len(made)
        robot["reach"] = max(float(robot["reach"]), *(math.hypot(x, y) for x, y, _ in (*wheels, *points)))
        self._points.take(made)
        self._fleet = None

    def set_mass(
        self, number: int, mass: float, center: Vector, inertia: Vector, radius: float, loads: Sequence[float]
    ) -> None:
        """Set mass, center of mass and moments of inertia of a robot; the pose of the robot does not change.

        Args:
            number: Number of the robot.
            mass: Mass [kg].
            center: Center of mass, robot frame [m].
            inertia: Moments of inertia about the center of mass [kg m^2].
            radius: Radius of the wheels [m].
            loads: Wheel loads on level ground [N]; the function enlarges the contact radius of each wheel by the
                compression under this load, so that the robot stands at z = 0.
        """
        robot, m = self.robots[number]["model"], len(loads)
        body = self._bodies.records[int(robot["body"])]["model"]
        body["mass"], body["center"], body["inertia"] = mass, center, inertia
        points = self._points.taken["model"][int(robot["first_point"]) : int(robot["last_point"])]
        stiffness = mass * GRAVITY / (m * _SINK)
        damping = 2.0 * _DAMPING_RATIO * math.sqrt(stiffness * mass / m)
        stiffer = math.sqrt(_STIFFER)
        points["radius"][:m] = radius + np.array(loads) / stiffness
        points["stiffness"][:m], points["stiffness"][m:] = stiffness, _STIFFER * stiffness
        points["damping"][:m], points["damping"][m:] = damping, stiffer * damping
        parts = self._parts.taken["model"][int(robot["first_part"]) : int(robot["last_part"])]
        parts["edge_stiffness"], parts["edge_damping"] = _STIFFER * stiffness, stiffer * damping

    # --- queries --------------------------------------------------------------------------------------------------

    def touching(self, row: int) -> list[int]:
        """Return the rows of the field elements and bodies that a robot touched in the last call of the loop."""
        if row not in self._number_of:
            return []
        robot = self.robots[self._number_of[row]]
        touched: list[int] = robot["touches"][: robot["touched"]].tolist()
        return touched

    def containing(self, place: Sequence[float]) -> int:
        """Return the row of a robot whose bumpers or frame contain a point, field frame [m]; -1 for no robot."""
        model = self._parts.taken["model"]
        for row, number in self._number_of.items():
            body = self._bodies.of(row)[0]
            x, y, z = body["axes"].T @ (np.asarray(place) - body["pos"])
            inside = (model["robot"] == number) & (model["bottom"] < z) & (z < model["top"])
            inside &= np.abs(x - model["x"]) < model["half_length"]
            if (inside & (np.abs(y - model["y"]) < model["half_width"])).any():
                return row
        return -1

    def wheel_gaps(self, number: int, count: int) -> list[float]:
        """Return the gap between each wheel of a robot and floor or field in the last step, negative in contact [m]."""
        first = int(self.robots["model"]["first_point"][number])
        gaps: list[float] = self._points.taken["gap"][first : first + count].tolist()
        return gaps

    def standing(
        self, number: int, pose: Vector, solids: Solids, has_floor: bool, gravity: float, height: float
    ) -> tuple[Vector, Quaternion]:
        """Return the position of the origin and the attitude of a robot that stands at a planar pose.

        Args:
            number: Number of the robot.
            pose: Planar pose, field frame [m, m, rad].
            solids: Solids of the world.
            has_floor: Whether the world has a floor at z = 0.
            gravity: Gravitational acceleration, downward [m/s^2].
            height: Height of the robot's origin at which the robot overlaps nothing; the robot settles from there [m].
        """
        kept = self._bodies.records.copy()
        body = self._bodies.records[int(self.robots["model"]["body"][number])]
        body["pos"], body["quat"] = (pose[0], pose[1], height + _ABOVE), from_yaw(pose[2])
        body["vel"] = body["rate"] = 0.0
        settle(self.fleet, number, self._bodies.records, solids, has_floor, gravity, STEP)
        x, y, z = body["pos"].tolist()
        a, b, c, d = body["quat"].tolist()
        self._bodies.records[:] = kept
        return (x, y, z), (a, b, c, d)

    # --- motion ---------------------------------------------------------------------------------------------------

    def put(self, row: int, pos: Sequence[float], quat: Quaternion) -> None:
        """Place a robot at rest; the loop then resolves new overlaps by displacement, without force.

        Args:
            row: Row of the robot's body in the world.
            pos: Origin of the robot, field frame [m].
            quat: Attitude of the robot, field frame.
        """
        robot = self.robots[self._number_of[row]]
        model = robot["model"]
        body = self._bodies.records[int(model["body"])]
        body["pos"], body["quat"], body["vel"], body["rate"] = pos, quat, 0.0, 0.0
        body["axes"] = axes = matrix(quat)
        body["com"] = pos + axes @ body["model"]["center"]
        points = self._points.taken[int(model["first_point"]) : int(model["last_point"])]
        points["load"], points["gap"] = 0.0, 0.0
        robot["is_put"] = 1

    def choose_outlines(self) -> None:
        """Select the field outlines that bumpers can touch.

        The function keeps the last selection while no robot's height has changed by over 3 mm since this selection.
        """
        heights: list[float] = self._bodies.records["pos"][self.robots["model"]["body"], 2].tolist()
        is_same = len(heights) == len(self._heights)
        if not (is_same and all(abs(new - old) <= _LIFT for new, old in zip(heights, self._heights, strict=True))):
            self._heights = heights
            self._slice_field()

    def report_brownouts(self) -> None:
        """Call `report` of all batteries if a brownout or reset has begun since the last call."""
        batteries = self._batteries.taken
        begun = sum(batteries["brownouts"].tolist()) + sum(batteries["resets"].tolist())
        if begun != self._reported:
            self._reported = begun
            for drive in self._drives:
                if drive is not None:
                    drive.battery.report()

    def fail(self, number: int) -> NoReturn:
        """Raise an error that contains position and velocity of a robot whose state is not finite.

        Raises:
            EngineError: Always.
        """
        body = self._bodies.records[int(self.robots["model"]["body"][number])]
        raise EngineError(
            f"robot {number}: its pose or velocity is not finite: {body['pos'].tolist()}, {body['vel'].tolist()}"
        )

    def _slice_field(self) -> None:
        """Select the field outlines at the current heights of all parts."""
        parts = self._parts.taken
        for number, robot in enumerate(parts["model"]["robot"].tolist()):
            height = self._heights[robot]
            low = float(parts["model"]["bottom"][number]) + height
            high = float(parts["model"]["top"][number]) + height
            parts["first_outline"][number], parts["last_outline"][number] = self._slice(
                math.floor(low / _BAND + 0.25), math.floor(high / _BAND + 0.25)
            )
        self._fleet = None

    def _slice(self, low: int, high: int) -> tuple[int, int]:
        """Return the index of the first outline, and the index after the last outline, between two heights.

        The heights are in units of `_BAND`. The function computes outlines that do not exist yet.
        """
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
    """Compute the outward unit normal of the side after each corner of a convex outline, shape (n, 2)."""
    along = np.roll(corners, -1, axis=0) - corners
    normals: FloatArray = np.column_stack((along[:, 1], -along[:, 0])) / np.linalg.norm(along, axis=1)[:, None]
    return normals


def _covered(
    number: int, polygons: Sequence[FloatArray], normals: Sequence[FloatArray], boxes: FloatArray
) -> npt.NDArray[np.uint8]:
    """Return whether other outlines cover each side of an outline from end to end, so that nothing can touch the side.

    Args:
        number: Number of the outline.
        polygons: Corners of all outlines [m].
        normals: Outward unit normals of the sides of all outlines.
        boxes: Bounds of each outline: low x, low y, high x, high y [m], shape (m, 4).

    Returns:
        1 for each covered side, otherwise 0, shape (n,); all 0 if all sides are covered.
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
    """Compute the plan-view outline of a convex shape between two heights.

    Args:
        points: Corners of the shape [m], shape (n, 3).
        low: Lower height [m].
        high: Upper height [m].

    Returns:
        Corners, counter-clockwise [m], shape (m, 2); empty if the outline between the heights has no area.
    """
    z = points[:, 2]
    found = [points[(z >= low) & (z <= high), :2]]
    for level in (low, high):
        below, above = points[z < level], points[z > level]
        if len(below) and len(above):  # lines between such points are in the shape and include the edges
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
