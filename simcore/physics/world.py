"""The world: floor, statics, robots and pieces, and the step that moves them.

Who touches whom is decided by groups. Every static stands in the world twice: once with its own surface for the
pieces, once without friction for the robots. All grip on what they drive over (the floor, and the elements named
`drivable`) is their tires'; bumpers meet walls and each other by `robot_dynamics`, and the engine keeps out of walls
robots that lie.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore.errors import ConfigError, NonFiniteError, UnknownNameError
from simcore.geometry.footprints import corners, overlaps
from simcore.geometry.rotation import IDENTITY, Quaternion, Vector, matrix
from simcore.loop.robots import prepare as prepare_robots
from simcore.physics.ball_dynamics import BallDynamics
from simcore.physics.ball_dynamics import prepare as prepare_balls
from simcore.physics.contact_law import CARPET, FRICTIONLESS, TerrainSurface
from simcore.physics.engine import BodyDefinition, Engine, RayHits
from simcore.physics.engine_choice import make_engine
from simcore.physics.nearness import PlanOutlines, StaticBoxes
from simcore.physics.robot_dynamics import BumperPart, RobotDynamics, is_met_in_plan
from simcore.physics.shapes import (
    Box,
    Cylinder,
    Shape,
    Sphere,
    bounding_box,
    bounding_radius,
    mass_properties,
    principal_axes,
)
from simcore.quantities import MASS, require
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import GRAVITY, plain_sum

if TYPE_CHECKING:
    from simcore.physics.field import FieldElement

__all__ = ["CollisionGroup", "PhysicsWorld", "prepare_loop"]

_STEP = 0.005  # [s], of a world in which nothing is driven
_MOST_PARTS = 8  # of a robot's own body that a line of sight passes
_FLOOR_THICKNESS = 1.0  # [m]; under robots: a plane gives one contact a tick and driven boxes sink into it
_FLOOR_LENGTH = 2_000.0  # [m]; nothing gets to its end. From 4 km on, cylinders wobble on it for longer


def prepare_loop() -> None:
    """Compile the loop of balls and robots for this computer, or load what was compiled before."""
    prepare_robots()
    prepare_balls()


class CollisionGroup:
    """Collision groups, one bit each."""

    STATIC = 1
    """The field; also the group that the engine gives to rays, so it must be in the mask of all that rays may hit."""
    PIECE = 2
    """Pieces that are no balls; balls are not in the engine."""
    ROBOT = 4
    DRIVABLE = 8
    """What robots drive over: the frictionless copies of floor and ramps that only robots touch."""
    SOLID = 16
    """What the bumpers of robots meet in plan: frictionless copies that only robots touch that do not stand."""


_ROBOT_MASK = CollisionGroup.STATIC | CollisionGroup.PIECE | CollisionGroup.DRIVABLE
_HINGED = 1e4  # times its largest moment of inertia that a hinged body has about what is not its hinge
_PIECE_MASK = CollisionGroup.STATIC | CollisionGroup.PIECE | CollisionGroup.ROBOT
_SWINGS = 0.03  # [m]; what hangs as near as this is hit, and a robot is thrown by what it is put into


class PhysicsWorld:
    """A rigid-body world with gravity. Use as a context manager, or call `close`.

    Args:
        engine: The engine, or the name of one, `bullet` or `mujoco`; None: see `engine_choice`.
        floor: Surface of the floor at z = 0, which has no end, or None for no floor.
        gravity: Along -z [m/s^2]; None: the engine's, by default standard gravity.
    """

    def __init__(
        self,
        *,
        engine: Engine | str | None = None,
        floor: TerrainSurface | None = CARPET,
        gravity: float | None = None,
    ) -> None:
        if engine is None or isinstance(engine, str):
            engine = make_engine(engine, gravity=GRAVITY if gravity is None else gravity)
        elif gravity is not None and gravity != engine.gravity:
            raise ConfigError(f"PhysicsWorld: this engine has a gravity of {engine.gravity} m/s^2, got {gravity}")
        self.engine = engine
        self.gravity = engine.gravity
        self.floor = floor
        """Material of the floor at z = 0, None where there is none."""
        self._begin()

    def _begin(self) -> None:
        """The floor alone."""
        self._names: dict[int, str] = {}  # by row
        self._field: set[int] = set()  # rows of what stands on it, as pieces meet it
        self._carriers: set[int] = set()
        self._hanging: dict[int, FloatArray] = {}  # half extents along its own axes [m]
        self.robot_rows: list[int] = []
        """Engine rows of the robots."""
        self.balls = BallDynamics(self.engine, self.floor)
        """The pieces that are balls, and what moves them."""
        self.hanging: list[tuple[int, Vector, float]] = []
        """Of what hangs: engine row, pivot [m], and how far from there it reaches [m]."""
        self._boxes, self._ramp_boxes = StaticBoxes(), StaticBoxes()
        self._outlines = PlanOutlines()
        self.near_field = self._boxes.are_near
        """Which places are near an element of the field, the floor left out; see `StaticBoxes.are_near`."""
        robot = CollisionGroup.ROBOT
        lying = _ROBOT_MASK | CollisionGroup.SOLID | robot
        self.robots = RobotDynamics(self.engine, ((robot, _ROBOT_MASK), (robot, lying)))
        """What moves the robots, by their motors, tires and bumpers."""
        self._is_ramp: BoolArray = np.zeros(0, dtype=bool)  # of the outlines
        floor = self.floor
        if floor is not None:
            box = Box((_FLOOR_LENGTH, _FLOOR_LENGTH, _FLOOR_THICKNESS))
            center = (0.0, 0.0, -_FLOOR_THICKNESS / 2)
            self._add_part("floor", box, center, IDENTITY, floor, CollisionGroup.STATIC, CollisionGroup.PIECE)
            self._add_part("floor", box, center, IDENTITY, FRICTIONLESS, CollisionGroup.DRIVABLE, CollisionGroup.ROBOT)

    def __enter__(self) -> PhysicsWorld:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def reset(self) -> None:
        """Remove everything but the floor."""
        self.engine.reset()
        self._begin()

    def close(self) -> None:
        """Free the engine; may be called twice."""
        self.engine.close()

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
        """Add something that never moves; returns its engine row.

        Args:
            name: For messages.
            shape: Collision shape.
            pos: Origin of the shape, field frame [m].
            surface: Its material.
            quat: Its attitude.
            drivable: Whether robots drive on it; then it has no friction for them.
        """
        at = _checked_pos(name, pos)
        row = self._add_part(name, shape, at, quat, surface, CollisionGroup.STATIC, CollisionGroup.PIECE)
        self._boxes.add(shape, at, quat)
        self.balls.add_static(shape, at, quat, surface)
        self._outlines.add(shape, at, quat)
        self._is_ramp = np.append(self._is_ramp, drivable)
        self._field.add(row)
        if drivable:
            self._ramp_boxes.add(shape, at, quat)
            self._add_part(name, shape, at, quat, FRICTIONLESS, CollisionGroup.DRIVABLE, CollisionGroup.ROBOT)
        else:
            is_met = is_met_in_plan(shape, at, quat)
            group = CollisionGroup.SOLID if is_met else CollisionGroup.STATIC
            self._add_part(name, shape, at, quat, FRICTIONLESS, group, CollisionGroup.ROBOT)
            if is_met:
                self.robots.add_static(row, shape, at, quat, surface)
        return row

    def _add_part(
        self,
        name: str,
        shape: Shape,
        pos: Vector,
        quat: Quaternion,
        surface: TerrainSurface,
        group: int,
        touchers: int,
    ) -> int:
        """One static body that some groups touch, and rays."""
        row = self._add(name, shape, pos, surface, quat=quat, group=group, mask=CollisionGroup.STATIC | touchers)
        if group == CollisionGroup.DRIVABLE:
            self._carriers.add(row)
        return row

    def _add(
        self, name: str, shape: Shape, pos: Sequence[float] | FloatArray, surface: TerrainSurface, **definition: Any
    ) -> int:
        """A body of a name, with further fields of its `BodyDefinition`."""
        at = _checked_pos(name, pos)
        row = self.engine.add_body(BodyDefinition(shape=shape, surface=surface, pos=at, **definition))
        self._names[row] = name
        return row

    def add_field(self, elements: Iterable[FieldElement], *, drivable: Sequence[str] = ()) -> None:
        """Add all elements of a field.

        Args:
            elements: For example `FieldGeometry.elements`.
            drivable: Name patterns (`*`, `?`) of what robots drive on.

        Raises:
            UnknownNameError: A pattern matches no element.
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
        """Add the body of a robot; returns its engine row. Without bumpers it meets neither walls nor robots."""
        require(name, "mass", mass, MASS)
        row = self._add(
            *(name, shape, pos, surface),
            mass=mass,
            center_of_mass=center_of_mass,
            inertia=inertia,
            keeps_spin=False,
            quat=quat,
            group=CollisionGroup.ROBOT,
            mask=_ROBOT_MASK,
        )
        self.robot_rows.append(row)
        self.robots.add_robot(row, bumpers)
        self.balls.add_body(row, shape, surface, mass, inertia, center=center_of_mass, is_robot=True)
        return row

    def add_piece_body(
        self, name: str, shape: Shape, *, mass: float, surface: TerrainSurface, pos: Sequence[float]
    ) -> int:
        """Add the body of a game piece that is no ball, awake and touchable; returns its engine row.

        Its mass is spread evenly; the origin of its shape must be its center of mass.
        """
        require(name, "mass", mass, MASS)
        moments, axes = principal_axes(mass * mass_properties(shape).inertia)
        row = self._add(
            *(name, shape, pos, surface), mass=mass, inertia=moments, inertia_axes=axes, group=CollisionGroup.PIECE,
            mask=_PIECE_MASK,
        )  # fmt: skip
        self.balls.add_body(row, shape, surface, mass, moments, inertia_axes=axes)
        return row

    def add_hanging_body(
        self,
        name: str,
        shape: Box | Cylinder | Sphere,
        *,
        mass: float,
        surface: TerrainSurface,
        pos: Sequence[float],
        pivot: Vector,
        hinge: str | None = None,
        drivable: bool = False,
    ) -> int:
        """Add a body that swings about a place of the field, or turns about a line there; returns its engine row.

        Lines of sight pass it.

        Args:
            name: For messages.
            shape: Its origin is the center of mass.
            mass: [kg]
            surface: Its material.
            pos: Center of mass at rest, field frame [m].
            pivot: The place that stays [m].
            hinge: `x` or `y`, the axis that it turns about; None: any.
            drivable: Whether robots drive on it; then it has no friction for bodies.
        """
        moments = [mass * float(moment) for moment in np.diag(mass_properties(shape).inertia)]
        if hinge is not None:
            stiff = _HINGED * max(moments)
            moments = [moment if axis == hinge else stiff for axis, moment in zip("xyz", moments, strict=True)]
        ix, iy, iz = moments
        row = self._add(
            *(name, shape, pos, FRICTIONLESS if drivable else surface),
            mass=mass,
            inertia=(ix, iy, iz) if hinge else None,
            pivot=pivot,
            group=CollisionGroup.PIECE | (CollisionGroup.DRIVABLE if drivable else 0),
            mask=_PIECE_MASK,
        )
        far = math.dist(pos, pivot) + bounding_radius(shape)
        if drivable:
            self._carriers.add(row)
            self._ramp_boxes.add(Box((2.0 * far,) * 3), pivot, IDENTITY)
        else:
            self._hanging[row] = bounding_box(shape)[1]
        swing = mass * math.dist(pos, pivot) ** 2
        self.balls.add_body(row, shape, surface, mass, (ix + swing, iy + swing, iz), pivot=pivot)
        self.hanging.append((row, pivot, far))
        reach = 2.0 * far
        self._boxes.add(Box((reach, reach, reach)), pivot, IDENTITY)
        return row

    def set_piece_touchable(self, row: int, touchable: bool, *, robots: bool = True) -> None:
        """Put a piece into the world of contacts, with robots or without, or take it out of it."""
        mask = _PIECE_MASK if robots else _PIECE_MASK & ~CollisionGroup.ROBOT
        self.engine.set_collision(row, CollisionGroup.PIECE if touchable else 0, mask if touchable else 0)

    def set_pose(self, row: int, pos: Sequence[float], quat: Quaternion = IDENTITY) -> None:
        """Put a body somewhere, at rest and awake.

        Raises:
            NonFiniteError: A NaN or an infinity; nothing is moved.
        """
        at = _checked_pos(self._names[row], pos)
        norm = math.sqrt(plain_sum(c * c for c in quat))
        if not math.isfinite(norm) or norm < 1e-9:
            raise NonFiniteError(f"{self._names[row]}: attitude must be a finite quaternion, got {quat}")
        self.engine.set_pose(row, at, tuple(c / norm for c in quat))
        self.engine.wake(row)

    def set_velocity(self, row: int, linear: Sequence[float], angular: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Give a body a velocity [m/s, rad/s], field frame, and wake it.

        Raises:
            NonFiniteError: A NaN or an infinity; nothing is changed.
        """
        if not all(map(math.isfinite, (*linear, *angular))):
            raise NonFiniteError(
                f"{self._names[row]}: velocity must be finite [m/s, rad/s], got {tuple(linear)}, {tuple(angular)}"
            )
        self.engine.wake(row)
        self.engine.set_velocity(row, linear, angular)

    def obstacles(
        self, row: int, x: float, y: float, yaw: float, half_length: float, half_width: float, bottom: float, top: float
    ) -> tuple[bool, bool]:
        """Whether a wall, what hangs or another robot than `row` reaches into an upright box, and whether a ramp does.

        Args:
            row: Of the robot.
            x: Middle of the box, field frame [m].
            y: The same [m].
            yaw: Of its length [rad].
            half_length: [m]
            half_width: [m]
            bottom: Lowest height [m].
            top: Highest [m].
        """
        reach = math.hypot(half_length, half_width)
        met = self._outlines.met(x, y, yaw, half_length, half_width, bottom, top)
        is_solid, is_ramp = bool((met & ~self._is_ramp).any()), bool((met & self._is_ramp).any())
        others = self.engine.overlapping((x - reach, y - reach, bottom), (x + reach, y + reach, top))
        is_met = any(other in self._hanging or (other != row and other in self.robot_rows) for other in others)
        return is_solid or is_met, is_ramp

    def is_in_solid(
        self, x: float, y: float, yaw: float, half_length: float, half_width: float, bottom: float, top: float
    ) -> bool:
        """Whether an upright box meets what stands or hangs on the field and is not driven over.

        The arguments are those of `obstacles`.
        """
        reach = math.hypot(half_length, half_width)
        if self._boxes.is_clear(x, y, reach):
            return False
        low, high = (x - reach, y - reach, bottom), (x + reach, y + reach, top)
        outline = corners(x, y, yaw, 2.0 * half_length, 2.0 * half_width)
        for row in self._hanging.keys() & self.engine.overlapping(low, high) if self._hanging else ():
            (hx, hy, _), quat = self.engine.pose(row)
            dx, dy, _ = (np.abs(matrix(quat)) @ self._hanging[row]).tolist()
            if overlaps(outline, corners(hx, hy, 0.0, 2.0 * (dx + _SWINGS), 2.0 * (dy + _SWINGS))):
                return True
        return bool((self._outlines.met(x, y, yaw, half_length, half_width, bottom, top) & ~self._is_ramp).any())

    def is_flat(self, x: float, y: float, reach: float) -> bool:
        """Whether robots drive on nothing but the floor within reach of a place of the field [m].

        By the bounding boxes of what they drive over, to the last bit, so that it is the same for red and blue.
        """
        if self.floor is None:
            return False
        return not self._ramp_boxes.are_near(np.array([[x, y, 0.0]]), np.array([reach]))[0]

    def is_free(self, low: Sequence[float], high: Sequence[float]) -> bool:
        """Whether no bounding box of the field, the floor left out, reaches into this box [m]."""
        return not self.field_in(low, high)

    def field_in(self, low: Sequence[float], high: Sequence[float]) -> list[int]:
        """Engine rows of what stands on the field, the floor left out, whose bounding box reaches into this box [m]."""
        return [row for row in self.engine.overlapping(low, high) if row in self._field]

    def ground_rays(self, start: FloatArray, end: FloatArray) -> RayHits:
        """First hits of segments (n, 3) [m] on what robots drive over; walls and pieces are left out."""
        return self.engine.rays(start, end, CollisionGroup.DRIVABLE)

    def ground_contacts(self, row: int) -> FloatArray:
        """Where a robot touched what carries robots in the last step, field frame [m], shape (n, 3)."""
        others, places = self.engine.contact_points(row)
        return places[[other in self._carriers for other in others]]

    def solid_rays(self, start: FloatArray, end: FloatArray, *, robots: bool = False) -> RayHits:
        """First hits of segments (n, 3) [m] on the field, and if asked on robots."""
        mask = CollisionGroup.STATIC | (CollisionGroup.ROBOT if robots else 0)
        return self.engine.rays(start, end, mask)

    def blocked(self, start: Vector, ends: Sequence[Sequence[float]], *, ignore: int = -1) -> list[bool]:
        """Which straight lines from `start` to n `ends` meet the field or a robot.

        Args:
            start: Field frame [m].
            ends: Field frame [m].
            ignore: Row of a robot that is transparent: the one that carries the camera.
        """
        there = np.array(ends).reshape(-1, 3)
        here = np.repeat(np.array([start]), len(there), axis=0)
        if len(self.robot_rows) <= (ignore >= 0):  # its own body is the only one
            return [row >= 0 for row in self.solid_rays(here, there).row.tolist()]
        return [row >= 0 for row in self.first_obstacles(here, there, ignore=ignore)[1].tolist()]

    def first_obstacles(self, start: FloatArray, end: FloatArray, *, ignore: int = -1) -> tuple[FloatArray, IntArray]:
        """What segments, (n, 3) each [m], meet first of the field and of robots.

        Args:
            start: Field frame [m]; what it is inside of is not met.
            end: Field frame [m].
            ignore: Row of a robot that is transparent.

        Returns:
            Part of each segment before the hit, 1.0 where nothing is met, shape (n,), and the row of what it meets,
            -1 for nothing, shape (n,).
        """
        way = end - start
        fraction, rows = np.ones(len(start)), np.full(len(start), -1, dtype=np.int64)
        passed, left = np.zeros(len(start)), np.arange(len(start))
        for _ in range(_MOST_PARTS):
            hits = self.solid_rays(start[left] + way[left] * passed[left, None], end[left], robots=True)
            at = passed[left] + (1.0 - passed[left]) * hits.fraction
            own = (hits.row == ignore) & (ignore >= 0)
            fraction[left[~own]], rows[left[~own]] = at[~own], hits.row[~own]
            if not own.any():
                break
            left = left[own]  # go on 1 mm behind the hit: rays that start inside of a body do not meet it
            reach = np.maximum(np.linalg.norm(way[left], axis=1), 1e-9)
            passed[left] = np.minimum(1.0, at[own] + 1e-3 / reach)
        return fraction, rows

    def touching(self, row: int) -> set[int]:
        """Rows of the bodies that a robot was in contact with in the last step, walls and robots among them."""
        return {*self.engine.touching(row), *self.robots.touching(row)}

    def body_name(self, row: int) -> str:
        """Name of a body, as it was added."""
        return self._names[row]

    def step(self, dt: float, *, substeps: int | None = None) -> None:
        """Advance a world in which nothing is driven, as `Motion` advances one with robots and pieces.

        Args:
            dt: Time to advance [s].
            substeps: How many steps of the engine; None: of 5 ms or less.

        Raises:
            ConfigError: dt is not a positive finite number, or there are no steps.
        """
        if not (math.isfinite(dt) and dt > 0.0):
            raise ConfigError(f"PhysicsWorld: dt must be finite and > 0 s, got {dt}")
        n = math.ceil(dt / _STEP - 1e-9) if substeps is None else substeps
        if n < 1:
            raise ConfigError(f"PhysicsWorld: substeps must be at least 1, got {n}")
        for _ in range(n):
            self.balls.advance(dt / n)
            self.engine.step(dt / n)


def _checked_pos(name: str, pos: Sequence[float] | FloatArray) -> Vector:
    if len(pos) != 3 or not all(map(math.isfinite, pos)):
        raise NonFiniteError(f"{name}: position must be three finite numbers [m], got {tuple(pos)}")
    return (float(pos[0]), float(pos[1]), float(pos[2]))
