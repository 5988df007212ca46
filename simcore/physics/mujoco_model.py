"""Builds a MuJoCo model from bodies: where each row of the engine is in it, who collides, rays and bounding boxes.

The body frame of a moving body lies in its center of mass, along its principal axes: then MuJoCo's velocity of a
free joint is that of the center of mass, and the mass matrix is diagonal.

MuJoCo lets two shapes touch if either wants to; here both must have the other's group in their mask. So all bodies with
the same group and mask form a class with a bit of its own, and the affinity of a class is the bits of all it touches.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simcore.errors import EngineError
from simcore.geometry.rotation import Quaternion, Vector, multiply, rotate, rotate_back
from simcore.physics.engine import BodyDefinition
from simcore.physics.mass_properties import mass_properties
from simcore.physics.shapes import Cylinder, HalfSpace, Hull, Mesh, Shape, Sphere, parts_of
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = [
    "CollisionClasses",
    "CompiledModel",
    "ModelQueries",
    "build_model",
    "move_mass",
    "ray_flags",
    "require_group",
]

_TRIANGLE_THICKNESS = 0.001  # [m]; MuJoCo takes the convex hull of a mesh, so each triangle becomes a thin prism
_SMALLEST_AREA = 1e-10  # [m^2]
ITERATIONS, _TOLERANCE = 50, 1e-8  # of Newton's method
_MEMORY = 48_000_000  # [bytes] for contacts; a system gives it page by page, when it is touched
_MEMORY_PER_BODY = 250_000  # [bytes]: in a heap a ball has 6 contacts of 3 rows
_MOST_CLASSES = 31  # bits of MuJoCo's masks
_MOST_GROUPS = 5  # MuJoCo tells six groups apart for rays; the sixth is of what is out of the world
_MOST_PASSED = 16  # surfaces that a ray leaves from the inside before it is given up


@dataclass(frozen=True, slots=True, eq=False)
class CompiledModel:
    """A model with its state, and which row of the engine each part of it is.

    Moving bodies are counted in their order, from 0; their shapes come after those of statics.
    """

    mj: Any
    """The package."""
    m: Any
    """The `MjModel`."""
    d: Any
    """The `MjData`."""
    body_of_row: IntArray
    """Number of the moving body, -1 for statics, shape (rows,)."""
    row_of_body: IntArray
    """Row of each moving body, shape (bodies,)."""
    row_of_geom: IntArray
    """Shape (geoms,)."""
    body_of_geom: IntArray
    """Number of the moving body, -1 for statics, shape (geoms,)."""
    geoms_of_row: list[IntArray]
    qpos: FloatArray
    """Center of mass and attitude w, x, y, z of the moving bodies, shape (bodies, 7)."""
    qvel: FloatArray
    """Velocity in the field frame, angular velocity in the body frame, shape (bodies, 6)."""


def build_model(mujoco: Any, definitions: Sequence[BodyDefinition], gravity: float) -> CompiledModel:
    """Compile a model.

    Args:
        mujoco: The package.
        definitions: By row.
        gravity: Along -z [m/s^2].

    Raises:
        EngineError: MuJoCo refuses a shape; the message is its own.
    """
    spec = mujoco.MjSpec()
    option = spec.option
    option.gravity = [0.0, 0.0, -gravity]
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.iterations, option.tolerance = ITERATIONS, _TOLERANCE
    option.sleep_tolerance = 0.0
    option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    moving = [row for row, definition in enumerate(definitions) if definition.mass > 0.0]
    spec.memory = _MEMORY + _MEMORY_PER_BODY * len(moving)
    geoms = _Geoms(mujoco, spec)
    static_rows: list[int] = []
    moving_rows: list[int] = []
    for row, definition in enumerate(definitions):
        if definition.mass == 0.0:
            count = geoms.add(spec.worldbody, definition.shape, definition.pos, definition.quat)
            static_rows += [row] * count
        else:
            body = spec.worldbody.add_body(mass=definition.mass, ipos=[0.0] * 3, iquat=[1.0, 0.0, 0.0, 0.0])
            body.explicitinertial = True
            body.inertia = list(definition.inertia or _uniform(definition))
            body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_ALLOWED
            body.add_freejoint()
            x, y, z, w = definition.inertia_axes
            cx, cy, cz = rotate_back(definition.inertia_axes, definition.center_of_mass)
            moving_rows += [row] * geoms.add(body, definition.shape, (-cx, -cy, -cz), (-x, -y, -z, w))
            if definition.pivot is not None:
                _hang(mujoco, spec, body, row, definition)
    try:
        model = spec.compile()
    except ValueError as error:
        raise EngineError(f"MuJoCo refuses a body: {error}") from error
    body_of_row = np.full(len(definitions), -1, dtype=np.int64)
    body_of_row[moving] = np.arange(len(moving))
    row_of_geom = np.array(static_rows + moving_rows, dtype=np.int64)
    data, order = mujoco.MjData(model), np.argsort(row_of_geom, kind="stable")
    counts = np.bincount(row_of_geom, minlength=len(definitions))
    return CompiledModel(
        *(mujoco, model, data, body_of_row, np.array(moving, dtype=np.int64), row_of_geom, body_of_row[row_of_geom]),
        geoms_of_row=np.split(order, np.cumsum(counts)[:-1]),
        qpos=data.qpos.reshape(-1, 7),
        qvel=data.qvel.reshape(-1, 6),
    )


def move_mass(model: Any, number: int, mass: float, inertia: Vector, away: Vector) -> None:
    """Give a moving body another mass, inertia and center in a compiled model, and what MuJoCo derives from them.

    Args:
        model: The `MjModel`.
        number: Of the moving body, counted from 0; the world is body 0 of the model.
        mass: [kg]
        inertia: Principal moments about the new center [kg m^2].
        away: From the old center of mass to the new one, body frame [m]: its shapes move the other way.
    """
    body, dofs = number + 1, slice(6 * number, 6 * number + 6)
    change = mass - model.body_mass[body]
    model.body_mass[body] = mass
    model.body_subtreemass[[0, body]] += change
    model.body_inertia[body] = inertia
    light = 1.0 / mass, float(np.mean(1.0 / np.array(inertia)))
    model.body_invweight0[body] = light
    model.dof_invweight0[dofs] = np.repeat(light, 3)
    model.dof_M0[dofs] = [mass] * 3 + list(inertia)
    geoms = slice(model.body_geomadr[body], model.body_geomadr[body] + model.body_geomnum[body])
    model.geom_pos[geoms] -= away
    model.geom_sameframe[geoms] = 0  # mjSAMEFRAME_NONE: else a shape that was in the center would stay there
    boxes = slice(model.body_bvhadr[body], model.body_bvhadr[body] + model.body_bvhnum[body])
    model.bvh_aabb[boxes, :3] -= away


def _hang(mujoco: Any, spec: Any, body: Any, row: int, definition: BodyDefinition) -> None:
    """Tie a body to its pivot. The pose of the model itself is that in which both places of the joint meet."""
    assert definition.pivot is not None
    quat = multiply(definition.quat, definition.inertia_axes)
    center = np.add(definition.pos, rotate(definition.quat, definition.center_of_mass))
    x, y, z, w = quat
    body.name, body.pos, body.quat = f"row {row}", center.tolist(), [w, x, y, z]
    tie = spec.add_equality(type=mujoco.mjtEq.mjEQ_CONNECT, objtype=mujoco.mjtObj.mjOBJ_BODY, name1=body.name)
    tie.data[:3] = rotate_back(quat, np.subtract(definition.pivot, center).tolist())


def _uniform(definition: BodyDefinition) -> Vector:
    """Moments of a uniform solid along the axes of its shape [kg m^2]."""
    x, y, z = np.diag(mass_properties(definition.shape).inertia).tolist()
    return (definition.mass * x, definition.mass * y, definition.mass * z)


class _Geoms:
    """Adds shapes to bodies of a spec; equal hulls share one mesh."""

    def __init__(self, mujoco: Any, spec: Any) -> None:
        self._types = mujoco.mjtGeom
        self._inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        self._spec = spec
        self._meshes: dict[bytes, str] = {}

    def add(self, body: Any, shape: Shape, pos: Vector, quat: Quaternion) -> int:
        """Add a shape; returns the number of its geoms."""
        if isinstance(shape, HalfSpace):
            self._add_one(body, self._types.mjGEOM_PLANE, (0.0, 0.0, 1.0), pos, quat)
            return 1
        if isinstance(shape, Mesh):
            prisms = _prisms(shape)
            for prism in prisms:
                self._add_mesh(body, prism, pos, quat)
            return len(prisms)
        for part in parts_of(shape):
            x, y, z = rotate(quat, part.offset)
            at = (pos[0] + x, pos[1] + y, pos[2] + z)
            member, attitude = part.shape, multiply(quat, part.quat)
            if isinstance(member, Hull):
                self._add_mesh(body, member.points, at, attitude)
            elif isinstance(member, Sphere):
                self._add_one(body, self._types.mjGEOM_SPHERE, (member.radius, 0.0, 0.0), at, attitude)
            elif isinstance(member, Cylinder):
                size = (member.radius, member.height / 2.0, 0.0)
                self._add_one(body, self._types.mjGEOM_CYLINDER, size, at, attitude)
            else:
                x, y, z = member.size
                self._add_one(body, self._types.mjGEOM_BOX, (x / 2.0, y / 2.0, z / 2.0), at, attitude)
        return len(parts_of(shape))

    def _add_one(self, body: Any, kind: Any, size: Vector, pos: Vector, quat: Quaternion, mesh: str = "") -> None:
        x, y, z, w = quat
        more = {"meshname": mesh} if mesh else {"size": list(size)}
        body.add_geom(type=kind, pos=list(pos), quat=[w, x, y, z], mass=0.0, **more)

    def _add_mesh(self, body: Any, points: FloatArray, pos: Vector, quat: Quaternion) -> None:
        key = np.ascontiguousarray(points, dtype=np.float64).tobytes()
        if key not in self._meshes:
            name = f"hull {len(self._meshes)}"
            self._spec.add_mesh(name=name, uservert=np.frombuffer(key), inertia=self._inertia)
            self._meshes[key] = name
        self._add_one(body, self._types.mjGEOM_MESH, (0.0, 0.0, 0.0), pos, quat, self._meshes[key])


def _prisms(mesh: Mesh) -> list[FloatArray]:
    """Each triangle of a mesh as the six corners of a thin prism around it [m]."""
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.sqrt(np.einsum("ij,ij->i", normal, normal))
    good = area > _SMALLEST_AREA
    step = normal[good] * (0.25 * _TRIANGLE_THICKNESS / area[good])[:, None]
    if not math.isfinite(float(step.sum())):
        raise EngineError("a mesh has corners that are not finite")
    flat = corners[good]
    return list(np.concatenate((flat - step[:, None, :], flat + step[:, None, :]), axis=1))


def require_group(group: int) -> None:
    """Raise `EngineError` for a group that MuJoCo's rays cannot tell apart."""
    if group >= 1 << _MOST_GROUPS:
        raise EngineError(f"MuJoCo tells {_MOST_GROUPS} collision groups apart, the bits 1 to 16; got {group}")


def ray_flags(mask: int) -> Any:
    """Which groups a ray meets, as MuJoCo takes it."""
    return np.array([*(mask >> number & 1 for number in range(_MOST_GROUPS)), 0], dtype=np.uint8)


class CollisionClasses:
    """Classes of the bodies of one model."""

    def __init__(self, model: CompiledModel) -> None:
        self._model, self._m = model, model.m
        self._classes: dict[tuple[int, int], int] = {}
        self._affinity = np.zeros(1, dtype=np.int32)  # of each class, and last that of none
        self._class_of_geom = np.full(self._m.ngeom, -1, dtype=np.int64)

    def write(self, row: int, group: int, mask: int) -> None:
        """Put a row into the class of its group and mask; into none if either is 0."""
        if not (group and mask):
            group, number = 0, -1
        elif (group, mask) in self._classes:
            number = self._classes[group, mask]
        else:
            number = self._new_class(group, mask)
        m, geoms, body = self._m, self._model.geoms_of_row[row], self._model.body_of_row[row]
        bit, affinity = 1 << number if number >= 0 else 0, self._affinity[number]
        m.geom_contype[geoms], m.geom_conaffinity[geoms] = bit, affinity
        m.geom_group[geoms] = (group.bit_length() or _MOST_GROUPS + 1) - 1
        self._class_of_geom[geoms] = number
        if body >= 0:
            m.body_contype[body + 1], m.body_conaffinity[body + 1] = bit, affinity
        else:
            self._write_world()

    def _new_class(self, group: int, mask: int) -> int:
        """Number of a class; those touch each other of which each has the other's group in its mask."""
        if len(self._classes) == _MOST_CLASSES:
            raise EngineError(f"MuJoCo: more than {_MOST_CLASSES} pairs of group and mask")
        self._classes[group, mask] = len(self._classes)
        groups, masks = np.array([*self._classes, (0, 0)]).T
        touch = (groups[:, None] & masks != 0) & (masks[:, None] & groups != 0)
        self._affinity = (touch << np.arange(len(groups))).sum(axis=1).astype(np.int32)
        model, m = self._model, self._m
        m.geom_conaffinity[:] = self._affinity[self._class_of_geom]
        bodies = model.body_of_geom >= 0
        m.body_conaffinity[model.body_of_geom[bodies] + 1] = m.geom_conaffinity[bodies]
        self._write_world()
        return self._classes[group, mask]

    def _write_world(self) -> None:
        """What the statics together touch."""
        statics = self._model.body_of_geom < 0
        self._m.body_contype[0] = np.bitwise_or.reduce(self._m.geom_contype[statics], initial=0)
        self._m.body_conaffinity[0] = np.bitwise_or.reduce(self._m.geom_conaffinity[statics], initial=0)


class ModelQueries:
    """Questions to one model; the poses of statics in it are right already."""

    def __init__(self, model: CompiledModel) -> None:
        self._model, self._mj, self._m, self._d = model, model.mj, model.m, model.d
        statics = np.nonzero(model.body_of_geom < 0)[0]
        self._first = len(statics)
        low, high = self.boxes(statics)
        self._static_low, self._static_high = low.T.copy(), high.T.copy()
        box = self._m.geom_aabb[self._first :]
        center = np.sqrt(np.einsum("ij,ij->i", box[:, :3], box[:, :3]))
        self._radius = center + np.sqrt(np.einsum("ij,ij->i", box[:, 3:], box[:, 3:]))

    def cast(self, start: FloatArray, end: FloatArray, groups: Any) -> tuple[float, int, Sequence[float]]:
        """Fraction, row and normal of the first surface that a segment enters."""
        way, passed = end - start, 0.0
        geom, normal = np.zeros(1, dtype=np.int32), np.zeros((3, 1))
        for _ in range(_MOST_PASSED):
            there = self._mj.mj_ray(
                self._m, self._d, (start + passed * way)[:, None], way[:, None], groups, True, -1, geom, normal
            )
            passed += there
            if there < 0.0 or passed > 1.0:
                break
            if float(normal[:, 0] @ way) < 0.0:
                return passed, int(self._model.row_of_geom[geom[0]]), normal[:, 0].tolist()
            passed += 1e-9  # it left a body from the inside
        return 1.0, -1, (0.0, 0.0, 0.0)

    def overlapping(self, low: Sequence[float], high: Sequence[float]) -> list[int]:
        """Rows of the bodies in the world whose bounding boxes overlap a box [m]."""
        first = self._first
        here = np.nonzero(_overlap(self._static_low, self._static_high, low, high))[0]
        pos = self._d.geom_xpos[first:].T
        near = np.nonzero(_overlap(pos - self._radius, pos + self._radius, low, high))[0] + first
        if len(near):
            lows, highs = self.boxes(near)
            near = near[_overlap(lows.T, highs.T, low, high)]
        geoms = np.concatenate((here, near))
        geoms = geoms[self._m.geom_contype[geoms] != 0]
        rows: list[int] = np.unique(self._model.row_of_geom[geoms]).tolist()
        return rows

    def near_statics(self, row: int, reach: float) -> list[tuple[float, Vector, Vector]]:
        """As `Engine.near_statics`, of the shapes of a body in turn."""
        m, mine = self._m, self._model.geoms_of_row[row]
        low, high = (corner.T[:, :, None] for corner in self.boxes(mine))
        near = _overlap(self._static_low[:, None, :], self._static_high[:, None, :], low - reach, high + reach)
        ways = m.geom_contype[mine, None] & m.geom_conaffinity[: self._first]
        back = m.geom_conaffinity[mine, None] & m.geom_contype[: self._first]
        x, y, z = self._model.qpos[self._model.body_of_row[row], :3].tolist()
        found: list[tuple[float, Vector, Vector]] = []
        ends = np.zeros(6)
        for one, other in np.argwhere(near & ((ways | back) != 0)).tolist():
            gap = self._mj.mj_geomDistance(m, self._d, int(mine[one]), other, reach, ends)
            ax, ay, az, bx, by, bz = ends.tolist()
            if gap < reach and gap != 0.0:
                found.append((gap, ((ax - bx) / gap, (ay - by) / gap, (az - bz) / gap), (ax - x, ay - y, az - z)))
        return found

    def boxes(self, geoms: IntArray) -> tuple[FloatArray, FloatArray]:
        """Corners of the bounding boxes of some shapes, field frame [m], shape (n, 3) each."""
        m, d = self._m, self._d
        axes, box = d.geom_xmat[geoms].reshape(-1, 3, 3), m.geom_aabb[geoms]
        center = d.geom_xpos[geoms] + (axes @ box[:, :3, None])[:, :, 0]
        half = (np.abs(axes) @ box[:, 3:, None])[:, :, 0]
        half[m.geom_type[geoms] == self._mj.mjtGeom.mjGEOM_PLANE] = np.inf
        return center - half, center + half


def _overlap(
    lows: FloatArray, highs: FloatArray, low: Sequence[float] | FloatArray, high: Sequence[float] | FloatArray
) -> BoolArray:
    """Whether boxes overlap another, corners of shape (3, n), shape (n,)."""
    found: BoolArray = (lows[0] <= high[0]) & (highs[0] >= low[0])
    for axis in (1, 2):
        found &= (lows[axis] <= high[axis]) & (highs[axis] >= low[axis])
    return found
