"""Builds a MuJoCo model from bodies, and knows where each row of the engine is in it.

The body frame of a moving body lies in its center of mass, along its principal axes: then MuJoCo's velocity of a
free joint is that of the center of mass, and the mass matrix is diagonal.
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
from simcore.physics.shapes import Box, Cylinder, HalfSpace, Hull, Mesh, Shape, Sphere, parts_of
from simcore.typing import FloatArray, IntArray

__all__ = ["CompiledModel", "build_model", "move_mass"]

_TRIANGLE_THICKNESS = 0.001  # [m]; MuJoCo takes the convex hull of a mesh, so each triangle becomes a thin prism
_SMALLEST_AREA = 1e-10  # [m^2]
_ITERATIONS, _TOLERANCE = 50, 1e-8  # of Newton's method
_MEMORY = 48_000_000  # [bytes] for contacts; a system gives it page by page, when it is touched
_MEMORY_PER_BODY = 250_000  # [bytes]: in a heap a ball has 6 contacts of 3 rows


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
    option.iterations, option.tolerance = _ITERATIONS, _TOLERANCE
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


def _half_size(shape: Sphere | Cylinder | Box) -> Vector:
    if isinstance(shape, Sphere):
        return (shape.radius, shape.radius, shape.radius)
    if isinstance(shape, Cylinder):
        return (shape.radius, shape.radius, shape.height / 2.0)
    x, y, z = shape.size
    return (x / 2.0, y / 2.0, z / 2.0)


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
                self._add_one(body, self._types.mjGEOM_BOX, _half_size(member), at, attitude)
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
