"""Physics world: floor, statics, robots and game pieces, and the step that moves them.

The compiled loop moves robots, swinging bodies and balls. The engine moves all other bodies. The engine starts when the
first of these other bodies is added, and then gets copies of the static field, of robots and of swinging bodies. The
copies collide only with the engine's other bodies.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError, NonFiniteError, UnknownNameError
from simcore.loop.compiled import compiled
from simcore.loop.solids import FIELD, Solids, find_in_box, first_hits
from simcore.loop.step import advance, prepare
from simcore.quantities import MASS, require
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import GRAVITY, plain_sum
from simcore.world.ball_dynamics import BallDynamics, factors
from simcore.world.bodies import Bodies, Pivot
from simcore.world.contact_law import CARPET, TerrainSurface
from simcore.world.engine import BodyDefinition, Engine
from simcore.world.engine_choice import VARIABLE, make_engine, require_known
from simcore.world.footprints import corners, overlaps
from simcore.world.robot_dynamics import BumperPart, RobotDynamics, is_met_in_plan
from simcore.world.rotation import IDENTITY, Quaternion, Vector, from_yaw, matrix
from simcore.world.shapes import (
    Box,
    Cylinder,
    Shape,
    Sphere,
    mass_properties,
    principal_axes,
)
from simcore.world.solids_builder import SolidsBuilder

if TYPE_CHECKING:
    from simcore.world.field import FieldElement

__all__ = ["CollisionGroup", "PhysicsWorld"]

_STEP = 0.005  # [s], engine step of a world outside a match
_FLOOR_THICKNESS = 1.0  # [m]; a plane would make one contact per tick, and driven boxes would sink into it
_FLOOR_LENGTH = 2_000.0  # [m]; nothing reaches the edge. On a floor of 4 km and more, cylinders wobble longer


class CollisionGroup:
    """Collision groups of the engine's bodies, one bit each."""

    STATIC = 1
    """Floor and static field."""
    PIECE = 2
    """Game pieces that are not balls; the engine has no balls."""
    ROBOT = 4
    """Robots, which the loop moves."""
    SWINGING = 8
    """Bodies on a pivot, which the loop moves."""


_PIECE_MASK = CollisionGroup.STATIC | CollisionGroup.PIECE | CollisionGroup.ROBOT | CollisionGroup.SWINGING
_SWINGS = 0.03  # [m]; smallest distance of a placed robot from a swinging body


class PhysicsWorld:
    """Rigid-body world with gravity. Use as a context manager, or call `close`.

    Args:
        engine: Engine, or the name of an engine (`bullet` or `mujoco`); None for the default of `engine_choice`.
        floor: Surface of the endless floor at z = 0, or None for no floor.
        gravity: Gravitational acceleration, downward [m/s^2]; None for the value of `engine`, or for standard gravity
            if `engine` is a name or None.

    Raises:
        UnknownNameError: If no engine has this name.
        ConfigError: If `gravity` differs from the gravity of `engine`.
    """

    def __init__(
        self,
        *,
        engine: Engine | str | None = None,
        floor: TerrainSurface | None = CARPET,
        gravity: float | None = None,
    ) -> None:
        self._engine: Engine | None = None
        self._engine_name: str | None = None
        if engine is None or isinstance(engine, str):
            self._engine_name = engine or os.environ.get(VARIABLE) or None
            if self._engine_name is not None:
                require_known(self._engine_name)
        elif gravity is not None and gravity != engine.gravity:
            raise ConfigError(f"PhysicsWorld: this engine has a gravity of {engine.gravity} m/s^2, got {gravity}")
        else:
            self._engine, gravity = engine, engine.gravity
        self.gravity: float = GRAVITY if gravity is None else gravity
        self.floor = floor
        """Surface of the floor at z = 0; None if the world has no floor."""
        self._begin()

    def _begin(self) -> None:
        """Start a world that contains only the floor."""
        self._names: list[str] = []  # by row
        self._definitions: list[BodyDefinition] = []  # by row
        self.has_engine = False
        """Whether the engine has started; the engine starts at the first use, for example when a piece other than a
        ball is added."""
        self._ramps_of: tuple[Solids | None, FloatArray] = (None, np.zeros((0, 6)))
        self.robot_rows: list[int] = []
        """Row of each robot's body, in the order in which the robots were added."""
        self._builder = SolidsBuilder()
        self.bodies = Bodies(self._builder)
        """Robots, swinging bodies, and the engine's bodies that balls can touch."""
        self.balls = BallDynamics(self.bodies, self._builder, self.floor, self.gravity)
        """Balls of the world, with state and contact memory."""
        self.robots = RobotDynamics(self.bodies)
        """Robots of the world, and the outlines of the field that bumpers can touch."""
        if self.floor is not None:
            box = Box((_FLOOR_LENGTH, _FLOOR_LENGTH, _FLOOR_THICKNESS))
            self._add("floor", box, (0.0, 0.0, -_FLOOR_THICKNESS / 2), self.floor, mask=CollisionGroup.PIECE)

    @property
    def engine(self) -> Engine:
        """Engine of the world; the first access starts the engine.

        Raises:
            EngineError: If the engine is not installed.
        """
        if not self.has_engine:
            if self._engine is None:
                self._engine = make_engine(self._engine_name, gravity=self.gravity)
            self.has_engine = True
            for row, definition in enumerate(self._definitions):
                assert self._engine.add_body(definition) == row
            for number in (*self.bodies.robots, *self.bodies.swinging):
                body = self.bodies.records[number]
                self._engine.set_pose(self.bodies.rows[number], body["pos"].tolist(), body["quat"].tolist())
        assert self._engine is not None
        return self._engine

    @property
    def engine_name(self) -> str:
        """Name of the engine, or `none` before the engine has started."""
        return self.engine.name if self.has_engine else "none"

    @property
    def solids(self) -> Solids:
        """Solids of the field and of bodies."""
        return self._builder.solids

    def __enter__(self) -> PhysicsWorld:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def reset(self) -> None:
        """Remove all bodies and field elements; the floor stays."""
        if self._engine is not None:
            self._engine.reset()
        self._begin()

    def close(self) -> None:
        """Free the engine, if the engine has started; a second call has no effect."""
        if self._engine is not None:
            self._engine.close()

    def add_static(
        self,
        name: str,
        shape: Shape,
        pos: Sequence[float] | FloatArray,
        *,
        surface: TerrainSurface,
        quat: Quaternion = IDENTITY,
        drivable: bool = False,
    ) -> int:
        """Add a static body and return the row of the body.

        Args:
            name: Name, for messages.
            shape: Collision shape.
            pos: Origin of the shape, field frame [m].
            surface: Surface of the static.
            quat: Attitude of the static, field frame.
            drivable: Whether robots drive on the static; bumpers then collide with the solids of the static, not with
                the plan-view outline.
        """
        at = _checked_pos(name, pos)
        row = self._add(name, shape, at, surface, quat=quat, mask=CollisionGroup.PIECE)
        in_plan = not drivable and is_met_in_plan(shape, at, quat)
        self._builder.add(shape, at, quat, factors(surface), row=row, drivable=drivable, in_plan=in_plan)
        if in_plan:
            self.robots.add_static(row, shape, at, quat, surface)
        return row

    def _add(
        self, name: str, shape: Shape, pos: Sequence[float] | FloatArray, surface: TerrainSurface, **definition: Any
    ) -> int:
        """Add a body and return the row of the body; extra keywords are fields of `BodyDefinition`."""
        at = _checked_pos(name, pos)
        row = len(self._definitions)
        self._definitions.append(BodyDefinition(shape=shape, surface=surface, pos=at, **definition))
        self._names.append(name)
        if self.has_engine:
            assert self.engine.add_body(self._definitions[-1]) == row
        return row

    def add_field(self, elements: Iterable[FieldElement], *, drivable: Sequence[str] = ()) -> None:
        """Add all elements of a field as statics.

        Args:
            elements: Field elements, for example `FieldGeometry.elements`.
            drivable: Name patterns (`*`, `?`) of the elements that robots drive on.

        Raises:
            UnknownNameError: If a pattern matches no element.
        """
        elements = list(elements)
        names = [element.name for element in elements]
        for pattern in drivable:
            if not any(fnmatchcase(name, pattern) for name in names):
                raise UnknownNameError("field element", pattern, names)
        for element in elements:
            self.add_static(
                element.name,
                element.shape,
                element.position,
                surface=element.surface,
                drivable=any(fnmatchcase(element.name, pattern) for pattern in drivable),
            )

    def add_robot_body(
        self,
        name: str,
        shape: Shape,
        *,
        mass: float,
        surface: TerrainSurface,
        center_of_mass: Vector,
        inertia: Vector,
        pos: Sequence[float],
        quat: Quaternion = IDENTITY,
        bumpers: Sequence[BumperPart] = (),
    ) -> int:
        """Add the body of a robot and return the row of the body.

        A robot without bumper parts passes through walls and robots.
        """
        require(name, "mass", mass, MASS)
        row = self._add(
            *(name, shape, pos, surface),
            mass=mass,
            center_of_mass=center_of_mass,
            inertia=inertia,
            keeps_spin=False,
            quat=quat,
            group=CollisionGroup.ROBOT,
            mask=CollisionGroup.PIECE,
        )
        self.robot_rows.append(row)
        body = self.bodies.add(row, shape, factors(surface), mass, inertia, center=center_of_mass, is_robot=True)
        self.robots.add_robot(row, body, bumpers)
        self.robots.put(row, pos, quat)
        return row

    def add_piece_body(
        self, name: str, shape: Shape, *, mass: float, surface: TerrainSurface, pos: Sequence[float]
    ) -> int:
        """Add an awake body with collisions for a game piece that is not a ball, and return the row of the body.

        The body has uniform density. The origin of the shape must be the center of mass.
        """
        require(name, "mass", mass, MASS)
        moments, axes = principal_axes(mass * mass_properties(shape).inertia)
        row = self._add(
            *(name, shape, pos, surface), mass=mass, inertia=moments, inertia_axes=axes, group=CollisionGroup.PIECE,
            mask=_PIECE_MASK,
        )  # fmt: skip
        self.bodies.add(row, shape, factors(surface), mass, moments, inertia_axes=axes, pos=_checked_pos(name, pos))
        self.engine.wake(row)
        return row

    def add_hanging_body(
        self,
        name: str,
        shape: Box | Cylinder | Sphere,
        *,
        mass: float,
        surface: TerrainSurface,
        pos: Sequence[float],
        pivot: Pivot,
        drivable: bool = False,
    ) -> int:
        """Add a sleeping body that swings about a fixed point or a hinge, and return the row of the body.

        Hanging bodies do not block lines of sight.

        Args:
            name: Name, for messages.
            shape: Collision shape with the center of mass at the origin.
            mass: Mass [kg].
            surface: Surface of the body.
            pos: Center of mass at rest, field frame [m], above or below the pivot.
            pivot: Fixed point or hinge.
            drivable: Whether robots drive on the body.
        """
        prepare()
        ix, iy, iz = (mass * np.diag(mass_properties(shape).inertia)).tolist()
        row = self._add(
            *(name, shape, pos, surface), mass=mass, inertia=(ix, iy, iz), keeps_spin=False,
            group=CollisionGroup.SWINGING, mask=CollisionGroup.PIECE,
        )  # fmt: skip
        self.bodies.add(
            row, shape, factors(surface), mass, (ix, iy, iz), pivot=pivot, pos=_checked_pos(name, pos),
            drivable=drivable,
        )  # fmt: skip
        return row

    def set_piece_touchable(self, row: int, touchable: bool, *, robots: bool = True) -> None:
        """Enable or disable the contacts of a game piece; `robots` False disables contacts with robots in any case."""
        mask = _PIECE_MASK if robots else _PIECE_MASK & ~CollisionGroup.ROBOT
        self.engine.set_collision(row, CollisionGroup.PIECE if touchable else 0, mask if touchable else 0)

    def set_pose(self, row: int, pos: Sequence[float], quat: Quaternion = IDENTITY) -> None:
        """Place a body at rest at a position [m] and attitude, field frame, and wake the body.

        The pivot sets the position of a swinging body, whatever `pos` is.

        Raises:
            NonFiniteError: If a value is not finite or the quaternion is zero; the pose then does not change.
        """
        at = _checked_pos(self._names[row], pos)
        norm = math.sqrt(plain_sum(c * c for c in quat))
        if not math.isfinite(norm) or norm < 1e-9:
            raise NonFiniteError(f"{self._names[row]}: attitude must be a finite quaternion, got {quat}")
        a, b, c, d = quat
        if row in self.robot_rows:
            self.robots.put(row, at, (a / norm, b / norm, c / norm, d / norm))
            return
        if self.bodies.is_moved_by_loop(row):
            self.bodies.turn(row, (a / norm, b / norm, c / norm, d / norm))
            return
        self.engine.set_pose(row, at, (a / norm, b / norm, c / norm, d / norm))
        self.engine.wake(row)

    def set_velocity(self, row: int, linear: Sequence[float], angular: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Set the velocity [m/s] and angular velocity [rad/s] of a body, field frame, and wake a body of the engine.

        Raises:
            NonFiniteError: If a value is not finite; the velocity then does not change.
        """
        if not all(map(math.isfinite, (*linear, *angular))):
            raise NonFiniteError(
                f"{self._names[row]}: velocity must be finite [m/s, rad/s], got {tuple(linear)}, {tuple(angular)}"
            )
        if self.bodies.is_moved_by_loop(row):
            self.bodies.set_velocity(row, linear, angular)
            return
        self.engine.wake(row)
        self.engine.set_velocity(row, linear, angular)

    def obstacles(
        self, row: int, x: float, y: float, yaw: float, half_length: float, half_width: float, bottom: float, top: float
    ) -> tuple[bool, bool]:
        """Return whether a solid obstacle overlaps an upright box, and whether a drivable static overlaps the box.

        Solid obstacles are statics that robots do not drive on, hanging bodies and other robots.

        Args:
            row: Row of the robot that the box represents; this robot is not an obstacle.
            x: x coordinate of the center of the box, field frame [m].
            y: y coordinate of the center of the box, field frame [m].
            yaw: Yaw of the box's length axis, field frame [rad].
            half_length: Half of the length [m].
            half_width: Half of the width [m].
            bottom: Height of the bottom of the box [m].
            top: Height of the top of the box [m].
        """
        is_solid, is_ramp = self._overlaps_static(x, y, yaw, half_length, half_width, bottom, top)
        if is_solid:
            return True, is_ramp
        reach = math.hypot(half_length, half_width)
        low, high = np.array((x - reach, y - reach, bottom)), np.array((x + reach, y + reach, top))
        for number in (*self.bodies.robots, *self._cages):
            body = self.bodies.records[number]
            if self.bodies.rows[number] != row and _is_near(low, high, body["pos"], float(body["model"]["reach"])):
                corner_a, corner_b = self._extent(number)
                if (corner_a < high).all() and (corner_b > low).all():
                    return True, is_ramp
        return False, is_ramp

    @property
    def _cages(self) -> list[int]:
        """Numbers of the swinging bodies that robots do not drive on."""
        return [number for number in self.bodies.swinging if not self.bodies.records["model"]["carries"][number]]

    @property
    def _plates(self) -> list[int]:
        """Numbers of the bodies that robots drive on."""
        return np.nonzero(self.bodies.records["model"]["carries"])[0].tolist()

    def _extent(self, number: int) -> tuple[FloatArray, FloatArray]:
        """Return the low and high corners of the bounding box of a robot or swinging body, field frame [m]."""
        body, solids = self.bodies.records[number], self.solids
        boxes = solids.box[int(body["model"]["first_solid"]) : int(body["model"]["last_solid"])]
        low, high = boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)
        axes = matrix(tuple(body["quat"].tolist()))
        middle, half = body["pos"] + axes @ (0.5 * (low + high)), np.abs(axes) @ (0.5 * (high - low))
        return middle - half, middle + half

    def _overlaps_static(
        self, x: float, y: float, yaw: float, half_length: float, half_width: float, bottom: float, top: float
    ) -> tuple[bool, bool]:
        """Return whether solid statics overlap an upright box, and whether drivable statics overlap the box."""
        solids = self.solids
        met = np.zeros(len(solids.body), np.uint8)
        find_in_box(solids, x, y, yaw, half_length, half_width, bottom, top, met)
        is_ramp = solids.is_drivable.astype(bool)
        is_met = met.astype(bool)
        return bool((is_met & ~is_ramp).any()), bool((is_met & is_ramp).any())

    def is_in_solid(
        self, x: float, y: float, yaw: float, half_length: float, half_width: float, bottom: float, top: float
    ) -> bool:
        """Return whether an upright box overlaps a static or hanging body that robots do not drive on.

        Hanging bodies have a margin of 30 mm in plan view. The arguments are the same as for `obstacles`, without
        `row`.
        """
        outline = corners(x, y, yaw, 2.0 * half_length, 2.0 * half_width)
        for number in self._cages:
            (ax, ay, az), (bx, by, bz) = (corner.tolist() for corner in self._extent(number))
            around = corners(0.5 * (ax + bx), 0.5 * (ay + by), 0.0, bx - ax + 2.0 * _SWINGS, by - ay + 2.0 * _SWINGS)
            if az < top and bz > bottom and overlaps(outline, around):
                return True
        return self._overlaps_static(x, y, yaw, half_length, half_width, bottom, top)[0]

    def is_flat(self, x: float, y: float, reach: float) -> bool:
        """Return whether the floor is the only drivable surface within `reach` [m] of a point of the field [m].

        The test uses the bounding boxes of drivable elements without a tolerance, so that the results for red and blue
        agree. The result is False in a world without a floor.
        """
        return bool(self.are_flat(np.array([(x, y)]), np.array([reach]))[0])

    @property
    def _ramps(self) -> FloatArray:
        """Low and high corners of the bounding box of each drivable solid of the field [m], shape (n, 6)."""
        solids = self.solids
        if self._ramps_of[0] is not solids:
            self._ramps_of = solids, solids.box[(solids.is_drivable == 1) & (solids.body == FIELD)]
        return self._ramps_of[1]

    def are_flat(self, places: FloatArray, reach: FloatArray) -> BoolArray:
        """Return whether the floor is the only drivable surface within reach of each point, shape (n,); see `is_flat`.

        Args:
            places: x and y of the points, field frame [m], shape (n, 2).
            reach: Radius around each point [m], shape (n,).
        """
        if self.floor is None:
            return np.zeros(len(places), dtype=bool)
        flat: BoolArray = np.ones(len(places), dtype=bool)
        _find_ramps(self._ramps, places, reach, flat)
        for body in self.bodies.records[self._plates]:
            far = float(body["model"]["reach"] + np.linalg.norm(body["pos"] - body["com"]))
            flat &= ~(np.hypot(*(places - body["com"][:2]).T) < reach + far)
        return flat

    def near_field(self, pos: FloatArray, reach: FloatArray) -> BoolArray:
        """Return whether each point is near the bounding box of a static element, shape (n,).

        Args:
            pos: Points, field frame [m], shape (n, 3).
            reach: Distance that counts as near, for each point [m], shape (n,).
        """
        boxes = self.solids.box[self.solids.body == FIELD]
        place = pos[:, None, :]
        away = np.maximum(np.maximum(boxes[:, :3] - place, place - boxes[:, 3:]), 0.0)
        near: BoolArray = (np.einsum("ijk,ijk->ij", away, away) < np.square(reach)[:, None]).any(axis=1)
        return near

    def is_free(self, low: Sequence[float], high: Sequence[float]) -> bool:
        """Return whether a box [m] overlaps no bounding box of a field element other than the floor."""
        return not self.field_in(low, high)

    def field_in(self, low: Sequence[float], high: Sequence[float]) -> list[int]:
        """Return the rows of the field elements, except the floor, whose bounding boxes overlap a box [m]."""
        solids = self.solids
        is_in = (solids.box[:, :3] <= high).all(axis=1) & (solids.box[:, 3:] >= low).all(axis=1)
        rows: list[int] = np.unique(solids.row[is_in & (solids.body == FIELD)]).tolist()
        return rows

    def ground_under(self, places: FloatArray, depth: float) -> FloatArray:
        """Return the height of the drivable ground under each point [m], shape (n,).

        Args:
            places: Points, field frame [m], shape (n, 3).
            depth: Largest distance below a point [m]; without ground within this distance, the height is `depth` below
                the point.
        """
        end = places - (0.0, 0.0, depth)
        fraction, row = np.ones(len(places)), np.empty(len(places), np.int64)
        has_floor = self.floor is not None
        first_hits(self.solids, self.bodies.records, has_floor, places, end, False, -1, True, fraction, row)
        ground: FloatArray = places[:, 2] - depth * fraction
        return ground

    def blocked(self, start: Vector, ends: Sequence[Sequence[float]], *, ignore: int = -1) -> list[bool]:
        """Return whether the field or a robot blocks the straight line from `start` to each of n `ends`.

        Args:
            start: Start of all lines, field frame [m].
            ends: Ends of the lines, field frame [m].
            ignore: Row of a robot that blocks no line, usually the robot that carries the camera; -1 to ignore no
                robot.
        """
        there = np.array(ends).reshape(-1, 3)
        here = np.repeat(np.array([start]), len(there), axis=0)
        return [row >= 0 for row in self.first_obstacles(here, there, ignore=ignore)[1].tolist()]

    def first_obstacles(self, start: FloatArray, end: FloatArray, *, ignore: int = -1) -> tuple[FloatArray, IntArray]:
        """Find the first hit of each segment on the field or a robot.

        Args:
            start: Starts of the segments, field frame [m], shape (n, 3); a solid that contains a start is not hit.
            end: Ends of the segments, field frame [m], shape (n, 3).
            ignore: Row of a robot that segments do not hit; -1 to ignore no robot.

        Returns:
            Fraction of each segment before the hit, 1.0 without a hit, shape (n,), and row of the element or body that
                is hit, -1 without a hit, shape (n,).
        """
        fraction, row = np.ones(len(start)), np.empty(len(start), np.int64)
        has_floor = self.floor is not None
        first_hits(self.solids, self.bodies.records, has_floor, start, end, True, ignore, False, fraction, row)
        return fraction, row

    def standing(self, number: int, pose: Vector) -> tuple[Vector, Quaternion]:
        """Return the position of the origin and the attitude of a robot that stands at a planar pose.

        Args:
            number: Number of the robot.
            pose: Planar pose, field frame [m, m, rad].
        """
        x, y, _ = pose
        reach = float(self.robots.robots["model"]["reach"][number])
        if self.is_flat(x, y, reach):
            return (x, y, 0.0), from_yaw(pose[2])
        ramps = self._ramps
        place = np.array((x, y))
        is_near = (ramps[:, :2] < place + reach).all(axis=1) & (ramps[:, 3:5] > place - reach).all(axis=1)
        height = float(ramps[is_near, 5].max(initial=0.0))
        for plate in self._plates:
            body = self.bodies.records[plate]
            extent = float(body["model"]["reach"])
            if math.dist((x, y), body["pos"][:2].tolist()) < reach + extent:
                height = max(height, float(body["pos"][2]) + extent)
        return self.robots.standing(number, pose, self.solids, self.floor is not None, self.gravity, height)

    def touching(self, row: int) -> set[int]:
        """Return the rows of the bodies and field elements that a robot touched in the last step of loop and engine."""
        others = self.engine.touching(row) if self.has_engine else ()
        return {*others, *self.robots.touching(row)}

    def body_name(self, row: int) -> str:
        """Return the name of the body or static with a given row."""
        return self._names[row]

    def step(self, dt: float, *, substeps: int | None = None) -> None:
        """Advance a world outside a match; in a match, `Motion` advances the world.

        Args:
            dt: Time to advance [s].
            substeps: Number of engine steps; None for steps of at most 5 ms.

        Raises:
            ConfigError: If dt is not finite and positive, or `substeps` is below 1.
        """
        if not (math.isfinite(dt) and dt > 0.0):
            raise ConfigError(f"PhysicsWorld: dt must be finite and > 0 s, got {dt}")
        n = math.ceil(dt / _STEP - 1e-9) if substeps is None else substeps
        if n < 1:
            raise ConfigError(f"PhysicsWorld: substeps must be at least 1, got {n}")
        for _ in range(n):
            self.advance(dt / n)
            if self.has_engine:
                self.begin_engine(dt / n)
                self.step_engine(dt / n)
                self.end_engine(dt / n)

    def advance(self, h: float) -> None:
        """Advance robots, swinging bodies and balls by h [s], before the engine's steps over the same time.

        Raises:
            EngineError: If the state of a robot is not finite.
        """
        bodies = self.bodies
        if self.has_engine:
            self.balls.read_bodies(self.engine)
            self._before = np.hstack((bodies.records["pos"], bodies.records["quat"]))
        self.robots.choose_outlines()
        lost = advance(
            self.robots.fleet, bodies.records, self.balls.balls, self.balls.memory, self.solids, self.balls.floor, h
        )
        if lost >= 0:
            self.robots.fail(lost)
        self.robots.report_brownouts()

    def begin_engine(self, h: float) -> None:
        """Pass the motion of the loop's bodies and the impulses of balls over h [s] to the engine, before its steps."""
        self.balls.push_bodies(self.engine)
        self.bodies.show_to(self.engine, self._before, h, self.gravity)

    def step_engine(self, h: float) -> None:
        """Advance the engine by one step of h [s]."""
        self.engine.step(h)
        self.bodies.note_touched(self.engine)

    def end_engine(self, h: float) -> None:
        """Apply the impulses of the engine's other bodies to the loop's bodies, after the engine's steps over h [s]."""
        self.bodies.take_from(self.engine, self._before, h)


def _is_near(low: FloatArray, high: FloatArray, pos: FloatArray, reach: float) -> bool:
    """Return whether a sphere of radius `reach` around `pos` overlaps a box [m]."""
    away = np.maximum(np.maximum(low - pos, pos - high), 0.0)
    return bool(away @ away < reach * reach)


def _checked_pos(name: str, pos: Sequence[float] | FloatArray) -> Vector:
    if len(pos) != 3 or not all(map(math.isfinite, pos)):
        raise NonFiniteError(f"{name}: position must be three finite numbers [m], got {tuple(pos)}")
    return (float(pos[0]), float(pos[1]), float(pos[2]))


@compiled
def _find_ramps(ramps: FloatArray, places: FloatArray, reach: FloatArray, flat: BoolArray) -> None:
    """Set `flat` to False for each point with a ramp within `reach`; see `PhysicsWorld.are_flat`."""
    for k in range(len(places)):
        x, y = places[k, 0], places[k, 1]
        for i in range(len(ramps)):
            dx = max(ramps[i, 0] - x, x - ramps[i, 3], 0.0)
            dy = max(ramps[i, 1] - y, y - ramps[i, 4], 0.0)
            if dx * dx + dy * dy < reach[k] * reach[k]:
                flat[k] = False
                break
