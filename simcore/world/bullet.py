"""Engine on PyBullet. No other module imports `pybullet`.

Settings and their reasons:

- Every body uses maximal coordinates (Bullet's plain rigid bodies). Plain rigid bodies have no velocity clamp and no
  hidden quadratic damping, and are a third faster than Bullet's multibodies.
- Every contact of a game piece has the piece's stiffness and a damper (Bullet's contact stiffness and contact damping).
  Spring and damper carry load only without split impulses. The solver starts from the forces of the previous step.
  Otherwise a robot that presses against a wall would need more iterations.
- Contacts start at a gap of 1 mm, because the default of 20 mm suppresses slow bounces. Continuous collision detection
  is off, because this detection removes the bounce, and because sub-steps are cheaper while few pieces are fast.
- simcore decides which bodies sleep. Bullet's sleep thresholds are 0, so Bullet only wakes sleeping bodies on contact.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from simcore.errors import EngineError
from simcore.typing import FloatArray
from simcore.units import GRAVITY
from simcore.world.contact_law import OVERLAP_TIME, contact_damping
from simcore.world.engine import BodyDefinition, Engine, RayHits
from simcore.world.rotation import (
    IDENTITY,
    Quaternion,
    Vector,
    frame_pose,
    matrix,
    outer_pose,
    rotate,
    rotate_back,
)
from simcore.world.shapes import (
    Box,
    Compound,
    Cylinder,
    Hull,
    Mesh,
    Part,
    Shape,
    Sphere,
    bounding_box,
    bounding_radius,
    free_spin,
    outline_points,
    parts_of,
    smallest_thickness,
)

__all__ = ["BulletEngine", "load_pybullet"]

_SOLVER_ITERATIONS = 32
"""Largest number of solver iterations."""
_RESIDUAL = 1e-9
"""Squared change of velocity per iteration below which the solver stops [m^2/s^2], the square of 0.03 mm/s."""
_WARM_START = 0.95
"""Fraction of the previous step's forces with which the solver starts."""
_CONTACT_DISTANCE = 0.001  # [m]
_SLIGHT_SPIN = 1e-4  # [rad/s], negligible change of spin per step by the gyroscopic torque


def load_pybullet() -> Any:
    """Import and return the module `pybullet`, and suppress the line with the build time that PyBullet prints.

    Raises:
        EngineError: If PyBullet is not installed.
    """
    try:
        with _silent_stdio():  # PyBullet prints its build time with C printf, into the middle of our output
            import pybullet
    except ImportError as error:
        raise EngineError(
            "PyBullet is not installed. There are wheels of 'pybullet-arm64' (it imports as 'pybullet') for Python "
            f"3.10-3.13 on Windows x64, macOS and Linux x86_64; this is Python {sys.version_info[0]}."
            f"{sys.version_info[1]} on {sys.platform}. Elsewhere 'pip install pybullet' compiles it in about 5 minutes "
            "and needs a C++ compiler."
        ) from error
    return pybullet


@contextlib.contextmanager
def _silent_stdio() -> Iterator[None]:
    """Discard the output of C code on stdout and stderr."""
    saved: dict[int, int] = {}
    try:
        sys.stdout.flush()
        sys.stderr.flush()
        saved = {fd: os.dup(fd) for fd in (1, 2)}
    except (OSError, ValueError, AttributeError):  # stdout and stderr are not files (pythonw, some IDEs)
        yield
        return
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        for fd in saved:
            os.dup2(null, fd)
        yield
    finally:
        _flush_c_stdio()  # otherwise a line stays in C's buffer and appears at exit
        for fd, copy in saved.items():
            os.dup2(copy, fd)
            os.close(copy)
        os.close(null)


def _flush_c_stdio() -> None:
    import ctypes

    with contextlib.suppress(OSError, AttributeError):
        libc = ctypes.CDLL("ucrtbase") if sys.platform == "win32" else ctypes.CDLL(None)
        libc.fflush(None)


class BulletEngine(Engine):
    """Physics engine on one PyBullet client. Use as a context manager, or call `close`."""

    name = "bullet"

    def __init__(self, *, gravity: float = GRAVITY) -> None:
        self.gravity = gravity
        p = self._p = load_pybullet()
        client = p.connect(p.DIRECT)
        if client < 0:
            raise EngineError("PyBullet refused a new world; close some of the open ones (each holds about 30 MB)")
        self._client: int | None = client
        self._kw = {"physicsClientId": client}
        self._begin()

    def _begin(self) -> None:
        """Start an empty world: set the engine parameters and clear the lists of bodies."""
        p = self._p
        p.setGravity(0.0, 0.0, -self.gravity, **self._kw)
        p.setPhysicsEngineParameter(
            contactBreakingThreshold=_CONTACT_DISTANCE,  # global to the process, so every client sets it again
            numSolverIterations=_SOLVER_ITERATIONS,
            solverResidualThreshold=_RESIDUAL,
            deterministicOverlappingPairs=1,  # takes 5-8 % of a step
            collisionFilterMode=0,  # both masks must agree
            useSplitImpulse=0,  # with split impulses, springs carry no load
            warmStartingFactor=_WARM_START,
            **self._kw,
        )
        self._h = 0.0
        self._ids: list[int] = []
        self._collision: list[tuple[int, int]] = []
        self._row_of: dict[int, int] = {}
        self._definitions: list[BodyDefinition] = []
        self._fixed: set[int] = set()
        self._tops: list[int] = []  # rows of the free bodies whose principal moments differ
        self._shapes = _BulletShapes(p, self._open())

    def reset(self) -> None:
        self._require_open()
        self._p.resetSimulation(**self._kw)
        self._begin()

    def close(self) -> None:
        if self._client is not None:
            client, self._client = self._client, None
            with contextlib.suppress(self._p.error):  # the server may already be closed
                self._p.disconnect(physicsClientId=client)

    def add_body(self, definition: BodyDefinition) -> int:
        body, row, s = self._make(definition), len(self._ids), definition.surface
        self._ids.append(body)
        self._collision.append((definition.group, definition.mask))
        self._row_of[body] = row
        self._definitions.append(definition)
        is_top = definition.inertia is not None and len(set(definition.inertia)) > 1
        if is_top and definition.keeps_spin:
            self._tops.append(row)
        if s.stiffness is not None and definition.mass > 0.0:
            self._set_stiffness(row, s.stiffness)
        if definition.center_of_mass != (0.0, 0.0, 0.0) or definition.inertia_axes != IDENTITY:
            self.set_pose(row, definition.pos, definition.quat)
        return row

    def _make(self, definition: BodyDefinition) -> int:
        """Create a body in PyBullet, and return the PyBullet id of the body.

        Raises:
            EngineError: If PyBullet cannot create the body.
        """
        self._require_open()
        p, d = self._p, definition
        origin = np.add(d.pos, rotate(d.quat, d.center_of_mass)).tolist()
        body = p.createMultiBody(
            baseMass=d.mass,
            baseCollisionShapeIndex=self._shapes.moving(d.shape) if d.mass > 0.0 else self._shapes.static(d.shape),
            basePosition=d.pos if d.center_of_mass == (0.0, 0.0, 0.0) else origin,
            baseOrientation=d.quat,
            baseInertialFramePosition=d.center_of_mass,
            baseInertialFrameOrientation=d.inertia_axes,
            useMaximalCoordinates=1,
            flags=p.URDF_ENABLE_SLEEPING,
            **self._kw,
        )
        if body < 0:
            raise EngineError(f"PyBullet could not make a body of {type(d.shape).__name__}")
        s = d.surface
        extra = {} if d.inertia is None else {"localInertiaDiagonal": d.inertia}
        p.changeDynamics(
            body,
            -1,
            mass=d.mass,  # required with the inertia: otherwise the mass becomes 0
            lateralFriction=s.friction,
            restitution=s.restitution,
            rollingFriction=s.rolling,
            spinningFriction=0.0,
            linearDamping=0.0,
            angularDamping=0.0,
            sleepThreshold=0.0,
            **extra,
            **self._kw,
        )
        p.setCollisionFilterGroupMask(body, -1, d.group, d.mask, **self._kw)
        return int(body)

    def set_pose(self, row: int, pos: Sequence[float], quat: Sequence[float]) -> None:
        self._unfix(row)  # a moved static would lose its inertia
        d = self._definitions[row]
        center, turned = frame_pose(pos, quat, d.center_of_mass, d.inertia_axes)
        self._p.resetBasePositionAndOrientation(self._ids[row], center, turned, self._open())

    def set_velocity(self, row: int, linear: Sequence[float], angular: Sequence[float]) -> None:
        self._p.resetBaseVelocity(self._ids[row], linear, angular, self._open())

    def pose(self, row: int) -> tuple[Vector, Quaternion]:
        center, turned = self._p.getBasePositionAndOrientation(self._ids[row], self._open())
        d = self._definitions[row]
        return outer_pose(center, turned, d.center_of_mass, d.inertia_axes)

    def state(self, row: int) -> tuple[float, ...]:
        body, client = self._ids[row], self._open()
        center, quat = self._p.getBasePositionAndOrientation(body, client)
        linear, angular = self._p.getBaseVelocity(body, client)
        return *center, *quat, *linear, *angular

    def velocity(self, row: int) -> tuple[Vector, Vector]:
        linear, angular = self._p.getBaseVelocity(self._ids[row], self._open())
        return linear, angular

    def apply_forces(self, rows: Sequence[int], forces: FloatArray) -> None:
        """Apply forces at the centers of mass [N], shape (n, 3), field frame, for the next `step` only.

        PyBullet accepts a force at the center of mass only in body axes. This method therefore applies the force in the
        world frame at the position of the center of mass.
        """
        p, client, ids = self._p, self._open(), self._ids
        for row, force, center in zip(rows, forces.tolist(), self.centers(rows).tolist(), strict=True):
            p.applyExternalForce(ids[row], -1, force, center, p.WORLD_FRAME, client)

    def wake(self, row: int) -> None:
        p = self._p
        if row in self._fixed:
            self._unfix(row, activationState=p.ACTIVATION_STATE_WAKE_UP)
            return
        p.changeDynamics(self._ids[row], -1, activationState=p.ACTIVATION_STATE_WAKE_UP, physicsClientId=self._open())

    def sleep(self, row: int) -> None:
        p, client = self._p, self._open()
        if row in self._fixed:  # a fixed body is at rest
            self._unfix(row, activationState=p.ACTIVATION_STATE_SLEEP)
            return
        p.resetBaseVelocity(self._ids[row], (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), client)
        p.changeDynamics(self._ids[row], -1, activationState=p.ACTIVATION_STATE_SLEEP, physicsClientId=client)

    def fix(self, row: int) -> None:
        """Make a body act as a static until `wake` or `sleep` is called.

        In Bullet, an awake body keeps awake all bodies with direct or indirect contact, except through statics. A
        static also takes only a fifth of a sleeping body's time per step: 18 us for 500 statics, 85 us for 500 bodies.
        """
        if row not in self._fixed:
            p, client, body = self._p, self._open(), self._ids[row]
            p.resetBaseVelocity(body, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), client)
            p.changeDynamics(body, -1, mass=0.0, activationState=p.ACTIVATION_STATE_SLEEP, physicsClientId=client)
            self._fixed.add(row)

    def _unfix(self, row: int, **extra: Any) -> None:
        """Restore mass and inertia of a body if it is fixed."""
        if row in self._fixed:
            self._fixed.remove(row)
            d = self._definitions[row]
            if d.inertia is not None:
                extra["localInertiaDiagonal"] = d.inertia
            self._p.changeDynamics(self._ids[row], -1, mass=d.mass, **extra, **self._kw)

    def _set_stiffness(self, row: int, stiffness: float) -> None:
        self._p.changeDynamics(
            self._ids[row],
            -1,
            contactStiffness=stiffness,
            contactDamping=contact_damping(stiffness, self._definitions[row].mass),
            physicsClientId=self._open(),
        )

    def contact_points(self, row: int) -> tuple[list[int], FloatArray]:
        found = self._p.getContactPoints(self._ids[row], physicsClientId=self._open()) or ()
        contacts = [contact for contact in found if contact[8] < _CONTACT_DISTANCE and contact[2] in self._row_of]
        return [self._row_of[c[2]] for c in contacts], np.array([c[6] for c in contacts]).reshape(-1, 3)

    def depth(self, row: int) -> float:
        p, client, me = self._p, self._open(), self._ids[row]
        center = p.getBasePositionAndOrientation(me, client)[0]
        room = bounding_radius(self._definitions[row].shape) + _CONTACT_DISTANCE
        around = p.getOverlappingObjects([c - room for c in center], [c + room for c in center], client) or ()
        gaps = [0.0]
        for other in {body for body, _ in around}:
            number = self._row_of.get(other, row)
            if self._definitions[number].mass == 0.0 and self._touch(row, number):
                gaps += [point[8] for point in p.getClosestPoints(me, other, 0.0, physicsClientId=client)]
        return -float(min(gaps))

    def _touch(self, row: int, other: int) -> bool:
        """Return whether two bodies can collide according to groups and masks."""
        (group, mask), (other_group, other_mask) = self._collision[row], self._collision[other]
        return bool(group & other_mask and other_group & mask)

    def set_collision(self, row: int, group: int, mask: int) -> None:
        self._p.setCollisionFilterGroupMask(self._ids[row], -1, group, mask, self._open())
        self._collision[row] = group, mask

    def step(self, h: float) -> None:
        client = self._open()
        if h != self._h:
            self._h = h
            self._p.setTimeStep(h, client)
            self._p.setPhysicsEngineParameter(contactERP=h / OVERLAP_TIME, physicsClientId=client)
        lost = [(row, self._precession_lost(row, h)) for row in self._tops if row not in self._fixed]
        self._p.stepSimulation(client)
        for row, spin in lost:
            if spin is not None:
                linear, angular = self.velocity(row)
                self.set_velocity(row, linear, np.add(angular, spin).tolist())

    def _precession_lost(self, row: int, h: float) -> Vector | None:
        """Compute the angular velocity to restore after a step of h [s], field frame [rad/s]; None if negligible.

        Bullet integrates the gyroscopic torque by one implicit Euler step (btRigidBody,
        "computeGyroscopicImpulseImplicit"). A tube that tumbles at 9 rad/s would lose a quarter of the energy in 1.5 s.
        """
        client, body, inertia = self._open(), self._ids[row], self._definitions[row].inertia
        assert inertia is not None
        quat = self._p.getBasePositionAndOrientation(body, client)[1]
        (x, y, z), (a, b, c) = rotate_back(quat, self._p.getBaseVelocity(body, client)[1]), inertia
        turning = y * z * (c - b), z * x * (a - c), x * y * (b - a)
        if max(map(abs, turning)) * h < _SLIGHT_SPIN * min(inertia):
            return None
        p, q, r = a * x, b * y, c * z
        step = (  # moments of inertia, plus h times the derivative of `turning` with respect to the spin
            (a, h * (r - b * z), h * (c * y - q)),
            (h * (a * z - r), b, h * (p - c * x)),
            (h * (q - a * y), h * (b * x - p), c),
        )
        torque = h * turning[0], h * turning[1], h * turning[2]
        taken = np.linalg.solve(np.array(step), np.array(torque)).tolist()
        freely = free_spin((x, y, z), inertia, h)
        return rotate(quat, (freely[0] - x + taken[0], freely[1] - y + taken[1], freely[2] - z + taken[2]))

    def rays(self, start: FloatArray, end: FloatArray, mask: int) -> RayHits:
        # as lists, 20 rays take 23 us; as arrays, 53 us
        hits = self._p.rayTestBatch(
            start.tolist(), end.tolist(), collisionFilterMask=mask, physicsClientId=self._open()
        )
        return RayHits(
            fraction=np.array([hit[2] for hit in hits]),
            row=np.array([self._row_of.get(hit[0], -1) for hit in hits], dtype=np.int64),
            normal=np.array([hit[4] for hit in hits]).reshape(-1, 3),
        )

    def _open(self) -> int:
        if self._client is None:
            raise EngineError("the physics world is closed; make a new one")
        return self._client

    def _require_open(self) -> None:
        self._open()


# --- shapes ----------------------------------------------------------------------------------------------------------


_MOST_SHAPES = 16
_HULL_MARGIN = 0.001  # [m], margin that PyBullet adds around hulls


class _BulletShapes:
    """Collision shapes of one PyBullet client; equal shapes share an id where possible.

    Args:
        pybullet: Module `pybullet`.
        client: Number of the client.
    """

    def __init__(self, pybullet: Any, client: int) -> None:
        self._p = pybullet
        self._kw = {"physicsClientId": client}
        self._shapes: dict[tuple[object, ...], int] = {}
        self._compounds: dict[Shape, int] = {}

    def moving(self, shape: Shape) -> int:
        """Return the id of a collision shape for moving bodies; bodies of the same shape share one id.

        Hulls have the given size, including PyBullet's margin. A box becomes a compound of eight boxes, because each
        box has only one contact with a hull. A single box would rock, sink in (by 84 mm on a slope) and have too much
        friction (14 % on a slope).
        """
        if isinstance(shape, Sphere | Cylinder):
            return self.static(shape)
        if shape not in self._compounds:
            parts = [_plain(part) for part in parts_of(shape)]
            if len(parts) == 1 and isinstance(parts[0].shape, Box):
                parts = _octants(parts[0])
            self._compounds[shape] = self._compound(Compound(tuple(parts)))
        return self._compounds[shape]

    def static(self, shape: Shape) -> int:
        """Return the id of a collision shape for statics; equal spheres, boxes and cylinders share one id."""
        p, kw = self._p, self._kw
        if isinstance(shape, Compound):
            return self._compound(shape)
        if isinstance(shape, Hull):
            return int(
                p.createCollisionShape(
                    p.GEOM_MESH, vertices=_corners(np.asarray(shape.points, dtype=np.float64).tobytes()), **kw
                )
            )
        if isinstance(shape, Mesh):
            return int(
                p.createCollisionShape(
                    p.GEOM_MESH,
                    vertices=shape.vertices.tolist(),
                    indices=shape.faces.ravel().tolist(),
                    flags=p.GEOM_FORCE_CONCAVE_TRIMESH,
                    **kw,
                )
            )
        key = (type(shape), shape)
        if key not in self._shapes:
            if isinstance(shape, Sphere):
                made = p.createCollisionShape(p.GEOM_SPHERE, radius=shape.radius, **kw)
            elif isinstance(shape, Cylinder):
                made = p.createCollisionShape(p.GEOM_CYLINDER, radius=shape.radius, height=shape.height, **kw)
            else:
                made = p.createCollisionShape(p.GEOM_BOX, halfExtents=[s / 2 for s in shape.size], **kw)
            self._shapes[key] = int(made)
        return self._shapes[key]

    def _compound(self, compound: Compound) -> int:
        """Create a compound shape and return the id of the shape; PyBullet reads the hulls from a temporary file.

        PyBullet accepts at most 16 shapes, and silently drops any further shapes. A file with any number of hulls
        counts as one shape. PyBullet never frees these hulls, so a compound of 24 hulls leaks 0.22 MB per world.

        Raises:
            EngineError: If the compound has too many shapes, or PyBullet cannot create the shape.
        """
        p = self._p
        parts = [_plain(part) for part in compound.parts]
        hulls = [part for part in parts if isinstance(part.shape, Hull)]
        parts = [part for part in parts if not isinstance(part.shape, Hull)]
        n = len(parts) + bool(hulls)
        if n > _MOST_SHAPES:
            raise EngineError(
                f"PyBullet takes at most {_MOST_SHAPES} shapes in a compound, all hulls counted as one, got {n}"
            )
        types, radii, halves, lengths = [p.GEOM_MESH] * n, [0.0] * n, [[0.0] * 3] * n, [0.0] * n
        files = [""] * n
        for i, part in enumerate(parts):
            shape = part.shape
            if isinstance(shape, Sphere):
                types[i], radii[i] = p.GEOM_SPHERE, shape.radius
            elif isinstance(shape, Cylinder):
                types[i], radii[i], lengths[i] = p.GEOM_CYLINDER, shape.radius, shape.height
            elif isinstance(shape, Box):
                types[i], halves[i] = p.GEOM_BOX, [s / 2 for s in shape.size]
        with ExitStack() as stack:
            if hulls:
                folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="simcore_hulls_"))
                files[-1] = _hull_file(Path(folder), hulls)
            made = p.createCollisionShapeArray(
                shapeTypes=types,
                radii=radii,
                halfExtents=halves,
                lengths=lengths,
                collisionFramePositions=[part.offset for part in parts] + [[0, 0, 0]] * bool(hulls),
                collisionFrameOrientations=[part.quat for part in parts] + [IDENTITY] * bool(hulls),
                planeNormals=[[0, 0, 1]] * n,
                fileNames=files,
                meshScales=[[1, 1, 1]] * n,
                **self._kw,
            )
        if made < 0:
            raise EngineError(f"PyBullet could not make a shape of {n} parts")
        return int(made)


def _octants(box: Part) -> list[Part]:
    corners = 0.5 * outline_points(box.shape)
    length, width, height = np.ptp(corners, axis=0).tolist()
    places = np.add(box.offset, corners @ matrix(box.quat).T).tolist()
    return [Part(Box((length, width, height)), (x, y, z), box.quat) for x, y, z in places]


def _plain(part: Part) -> Part:
    """Convert a part whose hull is a box to a part with a `Box`; return any other part unchanged.

    A `Box` can have several contacts with a wall at a time.
    """
    if not isinstance(part.shape, Hull) or len(part.shape.points) != 8:
        return part
    low, high = bounding_box(part.shape)
    middle, size = 0.5 * (low + high), high - low
    if not np.allclose(np.abs(part.shape.points - middle), 0.5 * size, atol=1e-9):
        return part
    x, y, z = np.add(part.offset, rotate(part.quat, middle.tolist())).tolist()
    length, width, height = size.tolist()
    return Part(Box((length, width, height)), (x, y, z), part.quat)


def _hull_file(folder: Path, hulls: Sequence[Part]) -> str:
    """Write hulls, shrunk by PyBullet's margin, to an OBJ file and return the path of the file."""
    lines, first = [], 1
    for number, part in enumerate(hulls):
        assert isinstance(part.shape, Hull)
        points = np.ascontiguousarray(part.shape.points, dtype=np.float64)
        inner = np.array(_without_margin(points.tobytes()))
        faces = ConvexHull(inner).simplices + first
        placed = (inner @ matrix(part.quat).T + part.offset).tolist()
        lines.append(f"o part{number}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in placed] + [f"f {a} {b} {c}" for a, b, c in faces.tolist()]
        first += len(inner)
    content = "\n".join(lines) + "\n"
    path = folder / f"{hashlib.sha256(content.encode()).hexdigest()[:24]}.obj"  # PyBullet caches files by name
    path.write_text(content, encoding="ascii")
    return str(path)


@lru_cache(maxsize=256)
def _without_margin(points: bytes) -> list[list[float]]:
    """Compute the corners of a hull after moving the faces inward by PyBullet's margin.

    Raises:
        EngineError: If the hull is too thin.
    """
    corners = np.frombuffer(points).reshape(-1, 3)
    planes = ConvexHull(corners).equations.copy()
    planes[:, 3] += _HULL_MARGIN
    try:
        inner = HalfspaceIntersection(np.unique(planes.round(12), axis=0), corners.mean(axis=0)).intersections
    except QhullError as error:
        raise EngineError(
            f"PyBullet needs hulls that are thicker than {2e3 * _HULL_MARGIN:.0f} mm, this one is "
            f"{1e3 * smallest_thickness(Hull(corners)):.1f} mm"
        ) from error
    inner = inner[np.sort(ConvexHull(inner).vertices)]
    rows: list[list[float]] = inner.tolist()
    return rows


@lru_cache(maxsize=4096)
def _corners(points: bytes) -> list[list[float]]:
    """Convert the bytes of float64 corners to a list of points.

    Equal hulls share one list because PyBullet never frees the lists.
    """
    rows: list[list[float]] = np.frombuffer(points).reshape(-1, 3).tolist()
    return rows
