"""The balls of a world: their arrays, what they touch, and the bodies of the engine that they push."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache, lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from simcore.geometry.rotation import IDENTITY, Quaternion, Vector, matrix
from simcore.loop.balls import advance, any_moves, depth_at
from simcore.loop.compiled import preparing
from simcore.loop.contact import DAMPING_RATIOS
from simcore.loop.solids import FIELD, Solids
from simcore.loop.state import REMEMBERED, Balls, Bodies, Floor, Memory
from simcore.physics.contact_law import TerrainSurface
from simcore.physics.engine import Engine
from simcore.physics.shapes import Box, Compound, Cylinder, Hull, Mesh, Part, Shape, Sphere, bounding_radius
from simcore.typing import FloatArray, IntArray
from simcore.units import GRAVITY

if TYPE_CHECKING:
    from simcore.physics.field import FieldElement
    from simcore.physics.robot_dynamics import RobotDynamics

__all__ = ["BallDynamics", "SolidsBuilder", "StandingField", "make_balls", "make_memory", "prepare"]

_ROBOTS = 62  # robots that balls tell apart
_REACH = 0.1  # [m]; what is so near to a ball may be touched within a tick, beside its way


def make_balls(status: np.ndarray, pos: FloatArray, vel: FloatArray) -> Balls:
    """Arrays of n balls, of which the first three are given."""
    n = len(status)
    return Balls(
        is_ball=np.zeros(n, np.uint8), status=status, pos=pos, vel=vel, spin=np.zeros((n, 3)),
        quat=np.tile((0.0, 0.0, 0.0, 1.0), (n, 1)), radius=np.full(n, 0.1), mass=np.ones(n), foam=np.ones((n, 4)),
        surface=np.zeros((n, 3)), air=np.zeros((n, 4)), still=np.zeros(n), load=np.zeros(n), press=np.zeros(n),
        hold=np.zeros(n), is_put=np.zeros(n, np.uint8), leaves=np.full(n, -1), contacts=np.zeros(n, np.int64),
        is_touched=np.zeros(n, np.uint8), bodies=np.zeros(n, np.int64),
    )  # fmt: skip


def make_memory(count: int) -> Memory:
    """Of so many balls, that remember nothing."""
    return Memory(
        key=np.full((count, REMEMBERED), np.iinfo(np.int64).min), stamp=np.full((count, REMEMBERED), -2),
        spring=np.zeros((count, REMEMBERED, 4)), clock=np.zeros(1, np.int64),
    )  # fmt: skip


@cache
def prepare() -> None:
    """Compile the loop for this computer, or load what was compiled before.

    Wherever balls are made that will move, so that no tick waits for it.
    """
    with preparing("balls.advance"):
        still = make_balls(np.zeros(1, np.uint8), np.zeros((1, 3)), np.zeros((1, 3)))
        floor = Floor(9.8, True, 1.0, 0.5, 0.0, True)
        any_moves(still.is_ball, still.status, _NO_BODIES.is_active, _NO_BODIES.twist)
        advance(still, make_memory(1), SolidsBuilder().build(), _NO_BODIES, floor, DAMPING_RATIOS, 1e-3)
        depth_at(SolidsBuilder().build(), 0.0, 0.0, 0.0, 0.1)


def factors(surface: TerrainSurface) -> Vector:
    """What contacts of balls need to know of a surface."""
    return surface.friction, surface.restitution, surface.rolling


class StandingField(NamedTuple):
    """What stands on a field, as balls meet that fly past each other and past all that moves."""

    solids: Solids
    floor: Floor

    @classmethod
    def of(cls, elements: Iterable[FieldElement], floor: TerrainSurface) -> StandingField:
        """Of elements, and of the material of the floor at z = 0."""
        prepare()
        builder = SolidsBuilder()
        for element in elements:
            builder.add(element.shape, element.position, IDENTITY, factors(element.surface))
        return cls(builder.build(), Floor(GRAVITY, True, *factors(floor), False))

    def fly(self, balls: Balls, memory: Memory, h: float) -> None:
        """Move balls of their own, which remember their friction, for h [s]."""
        advance(balls, memory, self.solids, _NO_BODIES, self.floor, DAMPING_RATIOS, h)


class BallDynamics:
    """Moves all balls of a world.

    Args:
        engine: With the bodies that balls push.
        floor: Material of the floor at z = 0; None: there is none.
    """

    def __init__(self, engine: Engine, floor: TerrainSurface | None) -> None:
        self._engine = engine
        self._builder = SolidsBuilder()
        self._solids: Solids | None = None
        friction, restitution, rolling = (0.0, 0.0, 0.0) if floor is None else factors(floor)
        self.floor = Floor(
            float(engine.gravity), floor is not None, float(friction), float(restitution), float(rolling), True
        )
        self.rows: list[int] = []
        """Engine rows of the bodies."""
        self._robots: list[int] = []  # their numbers among the bodies
        self._others: list[int] = []  # numbers of what else a ball may touch in this tick
        self._active: list[int] = []  # of both
        self._is_told = False  # whether the robots have said how they move
        self._fixed: set[int] = set()  # numbers of those that sleep
        self._number_of: dict[int, int] = {}
        self._bodies = _make_bodies(0)
        self.balls = make_balls(np.zeros(0, np.uint8), np.zeros((0, 3)), np.zeros((0, 3)))
        """All of them."""
        self._memory = make_memory(0)

    def set_balls(self, balls: Balls) -> None:
        """Say which balls there are."""
        if len(balls.status):
            prepare()
        self.balls, self._memory = balls, make_memory(len(balls.status))

    # --- what they touch ------------------------------------------------------------------------------------------

    def add_static(self, shape: Shape, pos: Vector, quat: Quaternion, surface: TerrainSurface) -> None:
        """Add something that never moves."""
        self._builder.add(shape, pos, quat, factors(surface))
        self._solids = None

    def add_body(
        self,
        row: int,
        shape: Shape,
        surface: TerrainSurface,
        mass: float,
        inertia: Vector,
        *,
        center: Vector = (0.0, 0.0, 0.0),
        inertia_axes: Quaternion = IDENTITY,
        pivot: Vector | None = None,
        is_robot: bool = False,
    ) -> None:
        """Add a body of the engine.

        Args:
            row: Its engine row.
            shape: Of it.
            surface: Its material.
            mass: [kg]
            inertia: Principal moments about the center of mass, or about the pivot [kg m^2].
            center: Center of mass in its frame [m].
            inertia_axes: Attitude of the principal axes in its frame.
            pivot: Place of the field that it swings about [m].
            is_robot: Whether it is a robot, which balls can always touch; others are `activate`d.
        """
        number = len(self.rows)
        self.rows.append(row)
        self._number_of[row] = number
        first = self._builder.add(shape, (0.0, 0.0, 0.0), IDENTITY, factors(surface), number)
        self._solids = None
        old, new = self._bodies, _make_bodies(number + 1)
        for name, before in old._asdict().items():
            getattr(new, name)[:number] = before
        self._bodies = new
        new.swings[number] = pivot is not None
        new.reach[number] = bounding_radius(shape)
        new.solids[number] = first, self._builder.count
        if is_robot:
            new.mark[number] = 1 << min(len(self._robots), _ROBOTS)
            self._robots.append(number)
        new.principal[number] = matrix(inertia_axes)
        self.set_mass(row, mass, center if pivot is None else pivot, inertia)

    def set_mass(self, row: int, mass: float, center: Vector, inertia: Vector) -> None:
        """Change mass, center of mass (or pivot) and principal moments of a body; as of `add_body`."""
        number = self._number_of[row]
        weight = 0.0 if self._bodies.swings[number] else 1.0 / mass
        self._bodies.lightness[number] = weight, *(1.0 / np.array(inertia)).tolist()
        self._bodies.middle[number] = center
        if number in self._robots:
            self._bodies.yielding[number] = weight, 1.0 / inertia[2]

    @property
    def solids(self) -> Solids:
        """All that balls touch, but floor and each other."""
        if self._solids is None:
            self._solids = self._builder.build()
        return self._solids

    def depth(self, pos: Vector, radius: float) -> float:
        """How deep a ball at a place would be in what stands on the field [m]; 0 for not at all."""
        depth = float(depth_at(self.solids, *pos, radius))
        return max(depth, radius - pos[2]) if self.floor.is_there else depth

    # --- motion ---------------------------------------------------------------------------------------------------

    def reach(self, row: int) -> float:
        """How far a body of an engine row reaches from its origin [m]."""
        return float(self._bodies.reach[self._number_of[row]])

    def leave(self, ball: int, row: int) -> None:
        """Let a ball touch a body of an engine row only after it has come out of it."""
        self.balls.leaves[ball] = self._number_of[row]

    def robots_touching(self, ball: int) -> list[int]:
        """Engine rows of the robots that a ball has touched in this tick."""
        marks = int(self.balls.bodies[ball])
        return [self.rows[number] for number in self._robots if marks & int(self._bodies.mark[number])]

    def begin_tick(self, others: list[int], fixed: list[int]) -> None:
        """Before a tick.

        Args:
            others: Engine rows of the bodies that are no robots and that a ball may touch in it.
            fixed: Those of them that sleep.
        """
        self.balls.bodies[:] = 0
        active = self._bodies.is_active
        active[:] = 0
        active[self._robots] = 1
        self._others = [self._number_of[row] for row in others]
        active[self._others] = 1
        self._active = [*self._robots, *self._others]
        self._fixed = {self._number_of[row] for row in fixed}

    def follow(self, robots: RobotDynamics) -> None:
        """Take pose and velocity of the robots for the next `advance` from the loop that moves them."""
        records, numbers, bodies = robots.robots, self._robots, self._bodies
        bodies.pose[numbers, :3], bodies.pose[numbers, 3:] = records["pos"], records["quat"]
        bodies.twist[numbers] = records["given"]
        self._is_told = True

    def advance(self, h: float) -> None:
        """Move all balls for h [s], and give the bodies what balls gave them, before the engine's step of as long."""
        bodies, engine, balls = self._bodies, self._engine, self.balls
        for number in self._others if self._is_told else self._active:
            row = self.rows[number]
            (x, y, z), (a, b, c, d) = engine.pose(row)
            (u, v, w), (p, q, r) = engine.velocity(row)
            bodies.pose[number] = x, y, z, a, b, c, d
            bodies.twist[number] = u, v, w, p, q, r
        self._is_told = False
        if not (len(balls.status) and any_moves(balls.is_ball, balls.status, bodies.is_active, bodies.twist)):
            return
        solids = self._solids or self.solids
        advance(balls, self._memory, solids, bodies, self.floor, DAMPING_RATIOS, h)
        pushed = bodies.is_pushed.nonzero()[0].tolist()
        for number in pushed:
            if number not in self._fixed:
                row, twist = self.rows[number], bodies.twist[number].tolist()
                if number in self._others:
                    engine.wake(row)
                engine.set_velocity(row, twist[:3], twist[3:])

    @property
    def standing(self) -> StandingField:
        """What stands on the field, for balls that are in nobody's way."""
        return StandingField(self.solids, self.floor._replace(with_pairs=False))

    def fly(self, balls: Balls, h: float) -> None:
        """Move balls of their own for h [s], among what stands on the field, past each other and past all bodies."""
        self.standing.fly(balls, make_memory(len(balls.status)), h)


def _make_bodies(n: int) -> Bodies:
    zeros = np.zeros
    return Bodies(
        is_active=zeros(n, np.uint8), pose=zeros((n, 7)), twist=zeros((n, 6)), yielding=zeros((n, 2)),
        middle=zeros((n, 3)), swings=zeros(n, np.uint8), reach=zeros(n),
        solids=zeros((n, 2), np.int64), mark=zeros(n, np.int64), pos=zeros((n, 3)), axes=zeros((n, 3, 3)),
        center=zeros((n, 3)), vel=zeros((n, 3)), rate=zeros((n, 3)), impulse=zeros((n, 6)), lightness=zeros((n, 4)),
        principal=zeros((n, 3, 3)), is_pushed=zeros(n, np.uint8),
    )  # fmt: skip


_NO_BODIES = _make_bodies(0)


# --- shapes as solids ------------------------------------------------------------------------------------------------


_SIDES = 48  # of a cylinder: 0.2 % of its radius off
_POINTS = 162  # of a sphere: 0.5 % of its radius off
_AROUND = 1.0  # [m] around the solids, that cells cover
_CELL, _MOST_CELLS = 0.25, 50_000  # edge of a cell [m], and how many there are at most, of fields that are larger


class SolidsBuilder:
    """Collects shapes and makes `Solids` of them."""

    def __init__(self) -> None:
        self._parts: list[tuple[int, FloatArray, FloatArray, tuple[float, float, float]]] = []
        self.count = 0
        """Solids so far."""

    def add(
        self,
        shape: Shape,
        pos: FloatArray | tuple[float, float, float],
        quat: Quaternion,
        surface: tuple[float, float, float],
        body: int = FIELD,
    ) -> int:
        """Add a shape; returns the number of its first solid.

        Args:
            shape: A mesh counts triangle by triangle.
            pos: Its origin in the frame of the field or the body [m].
            quat: Its attitude there.
            surface: Friction [-], restitution [-] and rolling lever [m].
            body: Whose it is.
        """
        axes, at, first = matrix(quat), np.asarray(pos, dtype=float), self.count
        if isinstance(shape, Mesh):
            for a, b, c in shape.vertices[shape.faces]:
                self._put(body, np.array([[a, b, c], [a, c, b]]) @ axes.T + at, surface)
            return first
        for part in shape.parts if isinstance(shape, Compound) else (Part(shape),):
            triangles = _triangles(part.shape) @ matrix(part.quat).T + np.array(part.offset)
            self._put(body, triangles @ axes.T + at, surface)
        return first

    def _put(self, body: int, triangles: FloatArray, surface: tuple[float, float, float]) -> None:
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        plane = np.column_stack([normal, np.einsum("ij,ij->i", normal, triangles[:, 0])])
        self._parts.append((body, triangles.reshape(-1, 9), plane, surface))
        self.count += 1

    def build(self) -> Solids:
        """Arrays of all that was added."""
        body = np.array([part[0] for part in self._parts], dtype=np.int64)
        sizes = [len(part[1]) for part in self._parts]
        first = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)
        box = np.array(
            [[*p[1].reshape(-1, 3).min(axis=0), *p[1].reshape(-1, 3).max(axis=0)] for p in self._parts]
        ).reshape(-1, 6)
        low, count, cell_first, cell_solid = _cells(box, body)
        return Solids(
            body=body,
            box=box,
            surface=np.array([part[3] for part in self._parts], dtype=float).reshape(-1, 3),
            first=first,
            plane=np.vstack([np.empty((0, 4)), *(part[2] for part in self._parts)]),
            corner=np.vstack([np.empty((0, 9)), *(part[1] for part in self._parts)]),
            cell_first=cell_first,
            cell_solid=cell_solid,
            cell_count=count,
            cell_low=low,
        )


def _cells(box: FloatArray, body: IntArray) -> tuple[FloatArray, IntArray, IntArray, IntArray]:
    """Lowest corner and numbers of the cells of the field, and the solids of each."""
    fixed = np.nonzero(body == FIELD)[0]
    if not len(fixed):
        return np.array([0.0, 0.0, _CELL]), np.zeros(2, np.int64), np.zeros(1, np.int64), np.zeros(0, np.int64)
    low = box[fixed, :2].min(axis=0) - _AROUND
    size = box[fixed, 3:5].max(axis=0) + _AROUND - low
    edge = max(_CELL, math.sqrt(float(size[0] * size[1]) / _MOST_CELLS))
    count = np.ceil(size / edge).astype(np.int64)
    cells: list[list[int]] = [[] for _ in range(int(count[0] * count[1]))]
    for solid in fixed.tolist():
        x0, y0 = ((box[solid, :2] - low) / edge).astype(int)
        x1, y1 = ((box[solid, 3:5] - low) / edge).astype(int)
        for cx in range(x0, x1 + 1):
            for cy in range(y0, y1 + 1):
                cells[cx * int(count[1]) + cy].append(solid)
    first = np.concatenate(([0], np.cumsum([len(cell) for cell in cells]))).astype(np.int64)
    return np.array([*low, edge]), count, first, np.array([solid for cell in cells for solid in cell], dtype=np.int64)


@lru_cache(maxsize=256)
def _triangles(shape: Sphere | Cylinder | Box | Hull) -> FloatArray:
    """Of a convex shape in its own frame, counter-clockwise seen from outside [m], shape (n, 3, 3)."""
    if isinstance(shape, Cylinder):
        turn = np.arange(_SIDES) * math.tau / _SIDES
        ring = shape.radius * np.column_stack([np.cos(turn), np.sin(turn)])
        points = np.vstack(
            [np.column_stack([ring, np.full(_SIDES, z)]) for z in (-0.5 * shape.height, 0.5 * shape.height)]
        )
    elif isinstance(shape, Sphere):
        points = shape.radius * _sphere_points()
    elif isinstance(shape, Box):
        points = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T * np.array(shape.size)
    else:
        points = shape.points
    hull = ConvexHull(points)
    triangles = points[hull.simplices]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inward = np.einsum("ij,ij->i", normal, hull.equations[:, :3]) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    kept: FloatArray = triangles[np.linalg.norm(normal, axis=1) > 1e-12]
    return kept


def _sphere_points() -> FloatArray:
    """Points spread evenly on a unit ball, shape (n, 3)."""
    k = np.arange(_POINTS) + 0.5
    z, turn = 1.0 - 2.0 * k / _POINTS, math.pi * (1.0 + math.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z * z)
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])
