"""Engine on MuJoCo. No other module imports `mujoco`.

Settings and their reasons:

- MuJoCo computes the contacts, with one set of parameters per shape (`_Contacts`). Shapes that robots drive on or into
  have no friction, no restitution, and the stiffest spring that the step allows. While any other body is awake, the
  engine splits steps into sub-steps of at most 0.5 ms, because a bounce takes only 8 ms. In these sub-steps a tumbling
  tube gains 1.2 % of the tube's energy in 1.5 s.
- Integration is semi-implicit Euler, x += h v with v at the end of the step, as in PyBullet.
- `sleep` uses MuJoCo's sleep: MuJoCo skips a sleeping body until an awake body touches the sleeping body. `fix` also
  puts the body to sleep, multiplies the mass so that the body acts as a wall, and restores the pose after each step.
- The engine compiles the model at the first use after a body was added. Moving bodies keep their state.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simcore.errors import EngineError
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import GRAVITY, plain_sum
from simcore.world.contact_law import (
    TerrainSurface,
    contact_spring,
    pair_friction,
    pair_restitution,
    pair_rolling,
)
from simcore.world.engine import BodyDefinition, Engine, RayHits
from simcore.world.rotation import Quaternion, Vector, frame_pose, multiply, outer_pose, rotate, rotate_back
from simcore.world.shapes import Cylinder, Hull, Mesh, Shape, Sphere, mass_properties, parts_of

__all__ = ["MuJoCoEngine"]

# [s], longest steps: for bodies that touch only statics without friction and restitution, and for all others
_SMOOTH, _LONGEST = 0.02, 0.0005
_FIXED = 1e6  # factor on the mass of a fixed body
_AWAKE = -11  # MuJoCo's value for a body that is fully awake


def _load_mujoco() -> Any:
    """Import and return the package `mujoco`; raise `EngineError` if the package is not installed."""
    try:
        import mujoco
    except ImportError as error:
        raise EngineError(
            "MuJoCo is not installed: `python -m pip install mujoco`. It has wheels for Windows x64, macOS and Linux "
            f"on Python 3.10 and newer; this is Python {sys.version_info[0]}.{sys.version_info[1]} on {sys.platform}."
        ) from error
    return mujoco


class MuJoCoEngine(Engine):
    """Physics engine on MuJoCo. Use as a context manager, or call `close`."""

    name = "mujoco"

    def __init__(self, *, gravity: float = GRAVITY) -> None:
        self.gravity = gravity
        self._mj = _load_mujoco()
        self._is_open = True
        self._begin()

    def _begin(self) -> None:
        """Start an empty world.

        Before the first compilation of the model, arrays with one row per moving body contain the state.
        """
        self._definitions: list[BodyDefinition] = []
        self._collision: list[tuple[int, int]] = []
        self._body: list[int] = []  # by row: number of the moving body, -1 for statics
        self._is_built = self._is_stale = self._is_listed = self._is_masked = False
        self._m: Any = None
        self._d: Any = None
        self._qpos: FloatArray = np.zeros((0, 7))  # center of mass, then attitude w, x, y, z
        self._qvel: FloatArray = np.zeros((0, 6))  # linear velocity in the field frame, angular in the body frame
        self._push: FloatArray = np.zeros((0, 6))  # force and torque for the next step, field frame
        self._asleep: BoolArray = np.zeros(0, dtype=bool)
        self._fixed: BoolArray = np.zeros(0, dtype=bool)  # fixed bodies are also asleep
        self._moved: BoolArray = np.zeros(0, dtype=bool)  # bodies moved since MuJoCo last computed poses

    def reset(self) -> None:
        self._require_open()
        self._begin()

    def close(self) -> None:
        if self._is_open:
            self._begin()
            self._is_open = False

    # --- bodies -------------------------------------------------------------------------------------------------

    def add_body(self, definition: BodyDefinition) -> int:
        self._require_open()
        _require_group(definition.group)
        row, is_moving = len(self._definitions), definition.mass > 0.0
        self._definitions.append(definition)
        self._collision.append((definition.group, definition.mask))
        self._body.append(len(self._qpos) if is_moving else -1)
        self._is_built = False
        if is_moving:
            zeros, no = np.zeros((1, 6)), np.zeros(1, dtype=bool)
            self._qpos = np.vstack((self._qpos, np.zeros((1, 7))))
            self._qvel, self._push = np.vstack((self._qvel, zeros)), np.vstack((self._push, zeros))
            self._asleep, self._fixed = np.append(self._asleep, no), np.append(self._fixed, no)
            self._moved = np.append(self._moved, no)
            self.set_pose(row, definition.pos, definition.quat)
        return row

    def set_pose(self, row: int, pos: Sequence[float], quat: Sequence[float]) -> None:
        self._require_open()
        body, d = self._body[row], self._definitions[row]
        if body < 0:
            raise EngineError("MuJoCo: a static cannot be moved; make a new world")
        center, (x, y, z, w) = frame_pose(pos, quat, d.center_of_mass, d.inertia_axes)
        self._qpos[body] = (*center, w, x, y, z)
        self._qvel[body] = 0.0
        self._moved[body] = self._is_stale = True

    def set_velocity(self, row: int, linear: Sequence[float], angular: Sequence[float]) -> None:
        self._require_open()
        body = self._body[row]
        self._qvel[body, :3] = linear
        self._qvel[body, 3:] = rotate_back(self._attitude(body), (angular[0], angular[1], angular[2]))

    def pose(self, row: int) -> tuple[Vector, Quaternion]:
        self._require_open()
        d, body = self._definitions[row], self._body[row]
        if body < 0:
            return d.pos, d.quat
        cx, cy, cz, w, x, y, z = self._qpos[body].tolist()
        return outer_pose((cx, cy, cz), (x, y, z, w), d.center_of_mass, d.inertia_axes)

    def state(self, row: int) -> tuple[float, ...]:
        self._require_open()
        body = self._body[row]
        cx, cy, cz, w, x, y, z = self._qpos[body].tolist()
        vx, vy, vz, *spin = self._qvel[body].tolist()
        wx, wy, wz = rotate((x, y, z, w), (spin[0], spin[1], spin[2]))
        return cx, cy, cz, x, y, z, w, vx, vy, vz, wx, wy, wz

    def velocity(self, row: int) -> tuple[Vector, Vector]:
        self._require_open()
        body = self._body[row]
        if body < 0:
            return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        vx, vy, vz, wx, wy, wz = self._qvel[body].tolist()
        return (vx, vy, vz), rotate(self._attitude(body), (wx, wy, wz))

    def apply_forces(self, rows: Sequence[int], forces: FloatArray) -> None:
        self._require_open()
        for row, force in zip(rows, forces, strict=True):
            self._push[self._body[row], :3] += force

    def _attitude(self, body: int) -> Quaternion:
        w, x, y, z = self._qpos[body, 3:].tolist()
        return x, y, z, w

    # --- sleep --------------------------------------------------------------------------------------------------

    def wake(self, row: int) -> None:
        self._require_open()
        if (body := self._body[row]) >= 0 and self._asleep[body]:
            self._asleep[body] = self._is_listed = False
            self._unfix(row)

    def sleep(self, row: int) -> None:
        self._require_open()
        if (body := self._body[row]) >= 0:
            self._qvel[body] = 0.0
            self._asleep[body], self._is_listed = True, False
            self._unfix(row)

    def fix(self, row: int) -> None:
        self._require_open()
        if (body := self._body[row]) >= 0 and not self._fixed[body]:
            self._qvel[body] = 0.0
            self._asleep[body], self._fixed[body], self._is_listed = True, True, False
            self._scale_mass(row, _FIXED)

    def _unfix(self, row: int) -> None:
        """Restore the mass of a body if it is fixed."""
        if self._fixed[self._body[row]]:
            self._fixed[self._body[row]] = False
            self._scale_mass(row, 1.0)

    def _scale_mass(self, row: int, factor: float) -> None:
        body = self._body[row]
        if self._is_built:
            mass, *inertia = (factor * self._own_mass[body]).tolist()
            _set_mass(self._m, body, mass, inertia)
            self._moved[body] = self._is_stale = True

    def _list_awake(self, awake: BoolArray) -> None:
        """Write the awake bodies into MuJoCo's lists of awake trees, bodies and degrees of freedom.

        Each moving body is a kinematic tree of one body.
        """
        d, numbers, who = self._d, np.arange(len(awake)), np.nonzero(awake)[0]
        d.tree_asleep[:] = np.where(awake, _AWAKE, numbers)
        d.tree_awake[:] = d.body_awake[1:] = awake
        d.body_awake_ind[0], d.body_awake_ind[1 : len(who) + 1] = 0, who + 1
        d.parent_awake_ind[: len(awake)] = numbers + 1  # the parent of each is the world
        d.dof_awake_ind[: 6 * len(who)] = (6 * who[:, None] + np.arange(6)).ravel()
        d.ntree_awake, d.nbody_awake, d.nparent_awake = len(who), len(who) + 1, len(awake)
        d.nv_awake = 6 * len(who)
        self._is_listed = False

    def _refresh(self) -> None:
        """Compile the model if needed, and update shape poses, MuJoCo's lists of awake bodies, and collision masks.

        The poses include the poses of sleeping bodies that a user has moved.
        """
        self._build()
        if self._is_stale:
            if (self._moved & self._asleep).any():  # MuJoCo would wake these bodies
                self._list_awake(~self._asleep | self._moved)
            self._kinematics()
            self._moved[:] = self._is_stale = False
        if not self._is_listed:
            self._list_awake(~self._asleep)
            self._is_listed = True
        if not self._is_masked:
            _write_masks(self._model, self._collision)
            self._is_masked = True

    def _kinematics(self) -> None:
        self._mj.mj_fwdKinematics(self._m, self._d)
        self._mj.mj_makeM(self._m, self._d)
        self._mj.mj_factorM(self._m, self._d)

    # --- contacts -----------------------------------------------------------------------------------------------

    def depth(self, row: int) -> float:
        self._refresh()
        return self._model.depth(row)

    def contact_points(self, row: int) -> tuple[list[int], FloatArray]:
        self._build()
        contact = self._d.contact
        rows = self._row_of_geom[contact.geom].reshape(-1, 2)
        mine = (rows == row).any(axis=1) & (contact.dist < _TOUCHING)
        return (rows[mine].sum(axis=1) - row).tolist(), contact.pos[mine]

    def set_collision(self, row: int, group: int, mask: int) -> None:
        self._require_open()
        _require_group(group)
        self._collision[row], self._is_masked = (group, mask), False

    # --- the model ----------------------------------------------------------------------------------------------

    def _build(self) -> None:
        """Compile the model if bodies were added since the last compilation; existing bodies keep their state."""
        self._require_open()
        if self._is_built:
            return
        model = self._model = _build_model(self._mj, self._definitions, self.gravity, _LONGEST)
        m, d = self._m, self._d = model.m, model.d
        self._row_of_body, self._row_of_geom = model.row_of_body, model.row_of_geom
        now = d.qpos.reshape(-1, 7), d.qvel.reshape(-1, 6), d.xfrc_applied[1:]
        for array, before in zip(now, (self._qpos, self._qvel, self._push), strict=True):
            array[:] = before
        self._qpos, self._qvel, self._push = now
        self._own_mass: FloatArray = np.column_stack((m.body_mass[1:], m.body_inertia[1:]))
        self._is_smooth, self._is_rigid = model.is_smooth, model.is_rigid
        m.opt.timestep = 0.0  # set in the first step
        self._is_built, self._is_stale, self._is_listed, self._is_masked = True, True, False, False
        for row in model.row_of_body[self._fixed].tolist():
            self._scale_mass(row, _FIXED)
        self._moved[:] = True
        self._kinematics()  # also places the statics

    # --- one step -----------------------------------------------------------------------------------------------

    def step(self, h: float) -> None:
        """Advance the world by h [s].

        Raises:
            EngineError: If a position or velocity is not finite.
        """
        self._build()
        if not len(self._qpos):
            return
        mj, m, d, asleep = self._mj, self._m, self._d, self._asleep
        if self._moved.any() or not (self._is_listed and self._is_masked):
            self._refresh()
        count = math.ceil(h / (_SMOOTH if (self._is_smooth | asleep).all() else _LONGEST) - 1e-9)
        if m.opt.timestep != h / count:
            m.opt.timestep = h / count
            m.geom_solref[self._is_rigid] = np.negative(contact_spring(0.0, 0.0, math.inf, 1.0, h / count))
        fixed = np.nonzero(self._fixed)[0]
        before = self._qpos[fixed]
        mj.mj_step(m, d, count)
        self._is_stale = True
        self._push[:] = 0.0
        if not np.isfinite(d.qvel).all():
            bad = int(np.nonzero(~np.isfinite(self._qvel).all(axis=1))[0][0])
            raise EngineError(f"MuJoCo lost body {self._row_of_body[bad]}: its velocity is not finite")
        awake = d.tree_asleep < 0
        if (awake == asleep).any():  # MuJoCo woke touched bodies, or put resting bodies to sleep
            woken = fixed[awake[fixed]]
            self._qpos[fixed], self._qvel[fixed], self._moved[woken] = before, 0.0, True
            asleep &= self._fixed | ~awake
            self._is_listed = False

    # --- queries ------------------------------------------------------------------------------------------------

    def rays(self, start: FloatArray, end: FloatArray, mask: int) -> RayHits:
        self._refresh()
        groups = _ray_flags(mask)
        start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
        found = [self._model.cast(a, b, groups) for a, b in zip(start, end, strict=True)]
        return RayHits(
            fraction=np.array([hit[0] for hit in found]),
            row=np.array([hit[1] for hit in found], dtype=np.int64),
            normal=np.array([hit[2] for hit in found]).reshape(-1, 3),
        )

    def _require_open(self) -> None:
        if not self._is_open:
            raise EngineError("the physics world is closed; make a new one")


# --- the model -------------------------------------------------------------------------------------------------------


_TOUCHING = 0.001
"""Gap below which two bodies count as touching [m]; contact forces start at a gap of 0."""
_TRIANGLE_THICKNESS = 0.001  # [m]; MuJoCo takes the convex hull of a mesh, so each triangle becomes a thin prism
_SMALLEST_AREA = 1e-10  # [m^2]
_ITERATIONS, _TOLERANCE = 50, 1e-8  # of the Newton solver
_IMPEDANCE = 0.99  # fraction of a load that a contact supports without the spring; 55 kg sink by 0.01 mm
_CREEP = 10.0  # ratio of friction stiffness to normal stiffness: reduces the creep of a body on a slope
_TWIST = 1e-3  # [m], lever of the friction about the normal; estimate: 2/3 mu a for a patch of radius a of some mm
_MEMORY = 48_000_000  # [bytes] for contacts; the system allocates pages when they are first touched
_MEMORY_PER_BODY = 250_000  # [bytes]
_MOST_CLASSES = 31  # bits of MuJoCo's masks
_MOST_GROUPS = 5  # MuJoCo has six ray groups; the sixth is for bodies without collisions
_MOST_PASSED = 16  # largest number of surfaces that a ray may leave from the inside


@dataclass(frozen=True, slots=True, eq=False)
class _CompiledModel:
    """Compiled MuJoCo model, state of the model, and the engine's row of each body and shape.

    The numbers of moving bodies count from 0 in the order of the rows. The shapes of moving bodies come after the
    shapes of statics.
    """

    mj: Any
    """Package `mujoco`."""
    m: Any
    """Compiled model, an `MjModel`."""
    d: Any
    """State of the model, an `MjData`."""
    row_of_body: IntArray
    """Row of each moving body, shape (bodies,)."""
    row_of_geom: IntArray
    """Row of the body that owns each geom, shape (geoms,)."""
    statics: int
    """Number of shapes of statics."""
    is_smooth: BoolArray
    """Whether each moving body can touch statics, and no static with friction or restitution, shape (bodies,)."""
    is_rigid: BoolArray
    """Whether each shape is part of a static without friction and restitution, shape (geoms,)."""

    def cast(self, start: FloatArray, end: FloatArray, groups: Any) -> tuple[float, int, Sequence[float]]:
        """Return the fraction, row and unit normal of the first surface that a segment enters.

        Without a hit, the values are 1, -1 and zeros.
        """
        way, passed = end - start, 0.0
        geom, normal = np.zeros(1, dtype=np.int32), np.zeros((3, 1))
        for _ in range(_MOST_PASSED):
            there = self.mj.mj_ray(
                self.m, self.d, (start + passed * way)[:, None], way[:, None], groups, True, -1, geom, normal
            )
            passed += there
            if there < 0.0 or passed > 1.0:
                break
            if float(normal[:, 0] @ way) < 0.0:
                return passed, int(self.row_of_geom[geom[0]]), normal[:, 0].tolist()
            passed += 1e-9  # the ray left a body from the inside
        return 1.0, -1, (0.0, 0.0, 0.0)

    def depth(self, row: int) -> float:
        """Return the largest overlap of a body with statics [m]; see `Engine.depth`."""
        m, mine = self.m, np.nonzero(self.row_of_geom == row)[0]
        low, high = (corner[:, None] for corner in self.boxes(mine))
        lows, highs = self.boxes(np.arange(self.statics))
        near = ((lows <= high) & (highs >= low)).all(axis=2)
        ways = m.geom_contype[mine, None] & m.geom_conaffinity[: self.statics]  # the masks are symmetric
        gaps = [
            float(self.mj.mj_geomDistance(m, self.d, int(mine[one]), other, 0.0, None))
            for one, other in np.argwhere(near & (ways != 0)).tolist()
        ]
        return -min(gaps, default=0.0)

    def boxes(self, geoms: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the low and high corners of the bounding boxes of shapes, field frame [m], shape (n, 3) each."""
        m, d = self.m, self.d
        axes, box = d.geom_xmat[geoms].reshape(-1, 3, 3), m.geom_aabb[geoms]
        center = d.geom_xpos[geoms] + (axes @ box[:, :3, None])[:, :, 0]
        half = (np.abs(axes) @ box[:, 3:, None])[:, :, 0]
        return center - half, center + half


def _build_model(mujoco: Any, definitions: Sequence[BodyDefinition], gravity: float, longest: float) -> _CompiledModel:
    """Compile the MuJoCo model of a list of bodies.

    Args:
        mujoco: Package `mujoco`.
        definitions: Definitions by row.
        gravity: Gravitational acceleration, downward [m/s^2].
        longest: Longest step of contacts with friction or restitution [s].

    Raises:
        EngineError: If MuJoCo rejects a shape; the message includes MuJoCo's message.
    """
    spec = mujoco.MjSpec()
    option = spec.option
    option.gravity = [0.0, 0.0, -gravity]
    option.cone, option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, _CREEP
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.jacobian = mujoco.mjtJacobian.mjJAC_SPARSE
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.iterations, option.tolerance = _ITERATIONS, _TOLERANCE
    option.sleep_tolerance = 0.0
    option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    moving = [row for row, definition in enumerate(definitions) if definition.mass > 0.0]
    spec.memory = _MEMORY + _MEMORY_PER_BODY * len(moving)
    geoms, contacts = _Geoms(mujoco, spec), _Contacts(definitions, longest)
    static_rows: list[int] = []
    moving_rows: list[int] = []
    for row, definition in enumerate(definitions):
        numbers = contacts.numbers(definition)
        if definition.mass == 0.0:
            count = geoms.add(spec.worldbody, definition.shape, definition.pos, definition.quat, numbers)
            static_rows += [row] * count
        else:
            body = spec.worldbody.add_body(mass=definition.mass, ipos=[0.0] * 3, iquat=[1.0, 0.0, 0.0, 0.0])
            body.explicitinertial = True
            body.inertia = list(definition.inertia or _uniform(definition))
            body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_ALLOWED
            body.add_freejoint()
            x, y, z, w = definition.inertia_axes
            cx, cy, cz = rotate_back(definition.inertia_axes, definition.center_of_mass)
            moving_rows += [row] * geoms.add(body, definition.shape, (-cx, -cy, -cz), (-x, -y, -z, w), numbers)
    try:
        model = spec.compile()
    except ValueError as error:
        raise EngineError(f"MuJoCo refuses a body: {error}") from error
    row_of_geom = np.array(static_rows + moving_rows, dtype=np.int64)
    return _CompiledModel(
        *(mujoco, model, mujoco.MjData(model), np.array(moving, dtype=np.int64), row_of_geom, len(static_rows)),
        is_smooth=np.array([contacts.is_smooth(definitions[row]) for row in moving], dtype=bool),
        is_rigid=np.array([_is_rigid(one.surface, one.mass) for one in definitions], dtype=bool)[row_of_geom],
    )


class _Contacts:
    """Contact parameters of all bodies, computed for the most frequent partner that is not heavier.

    Args:
        definitions: Definitions of all bodies.
        longest: Longest step of contacts with friction or restitution [s].
    """

    def __init__(self, definitions: Sequence[BodyDefinition], longest: float) -> None:
        self._kinds = Counter((one.surface, one.mass, one.group, one.mask) for one in definitions)
        self._priority = {mass: number for number, mass in enumerate(sorted({mass for _, mass, _, _ in self._kinds}))}
        self._longest = longest
        self._known: dict[tuple[TerrainSurface, float, int, int], dict[str, Any]] = {}

    def numbers(self, body: BodyDefinition) -> dict[str, Any]:
        """Return the contact parameters of a body's shapes, as keyword arguments of `add_geom`."""
        kind = (body.surface, body.mass, body.group, body.mask)
        if kind not in self._known:
            self._known[kind] = self._pair(body)
        return self._known[kind]

    def is_smooth(self, body: BodyDefinition) -> bool:
        """Return whether a body can touch statics, and no static with friction or restitution."""
        statics = [(surface, mass) for surface, mass, *_ in self._touched(body) if mass == 0.0]
        return bool(statics) and all(_is_rigid(surface, mass) for surface, mass in statics)

    def _touched(self, body: BodyDefinition) -> list[tuple[TerrainSurface, float, int, int]]:
        return [kind for kind in self._kinds if kind[2] & body.mask and kind[3] & body.group]

    def _pair(self, body: BodyDefinition) -> dict[str, Any]:
        own, heaviest = body.surface, body.mass or math.inf
        lighter = [kind for kind in self._touched(body) if 0.0 < kind[1] <= heaviest]
        other, mass, *_ = max(lighter, key=self._kinds.__getitem__, default=(own, body.mass or 1.0))
        friction = pair_friction(own.friction, other.friction)
        restitution = pair_restitution(own.restitution, other.restitution)
        rolling = pair_rolling(own.rolling, own.friction, other.rolling, other.friction)
        give = plain_sum(1.0 / surface.stiffness for surface in (own, other) if surface.stiffness is not None)
        stiffness = 1.0 / give if give else math.inf
        spring, damper = contact_spring(restitution, friction, stiffness, mass, self._longest)
        return {
            "priority": self._priority[body.mass] if body.mass else len(self._priority),
            "condim": 1 if friction == 0.0 else 6 if rolling > 0.0 else 3,
            "friction": [friction, _TWIST, rolling],
            "solref": [-spring, -damper],
            "solimp": [_IMPEDANCE, _IMPEDANCE, 1.0, 0.5, 1.0],
            "margin": 0.0,
            "gap": 0.5 * _TOUCHING,  # the gaps of both shapes add
        }


def _is_rigid(surface: TerrainSurface, mass: float) -> bool:
    """Return whether a body is a static without friction and restitution."""
    return mass == surface.friction == surface.restitution == 0.0


def _set_mass(model: Any, number: int, mass: float, inertia: Sequence[float]) -> None:
    """Set mass and inertia of a moving body in a compiled model, and update all derived values.

    Args:
        model: Compiled model, an `MjModel`.
        number: Number of the moving body, from 0; the world is body 0 of the model.
        mass: Mass [kg].
        inertia: Principal moments of inertia about the center of mass [kg m^2].
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


def _uniform(definition: BodyDefinition) -> Vector:
    """Compute the moments of inertia of a uniform body about the axes of the shape [kg m^2]."""
    x, y, z = np.diag(mass_properties(definition.shape).inertia).tolist()
    return (definition.mass * x, definition.mass * y, definition.mass * z)


class _Geoms:
    """Builder that adds shapes to the bodies of an `MjSpec`; equal hulls share one mesh."""

    def __init__(self, mujoco: Any, spec: Any) -> None:
        self._types = mujoco.mjtGeom
        self._inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        self._spec = spec
        self._meshes: dict[bytes, str] = {}

    def add(self, body: Any, shape: Shape, pos: Vector, quat: Quaternion, numbers: dict[str, Any]) -> int:
        """Add a shape with contact parameters to a body, and return the number of new geoms."""
        if isinstance(shape, Mesh):
            prisms = _prisms(shape)
            for prism in prisms:
                self._add_mesh(body, prism, pos, quat, numbers)
            return len(prisms)
        for part in parts_of(shape):
            at = np.add(pos, rotate(quat, part.offset)).tolist()
            member, attitude = part.shape, multiply(quat, part.quat)
            if isinstance(member, Hull):
                self._add_mesh(body, member.points, at, attitude, numbers)
            elif isinstance(member, Sphere):
                self._add_one(body, self._types.mjGEOM_SPHERE, at, attitude, numbers, size=[member.radius, 0.0, 0.0])
            elif isinstance(member, Cylinder):
                size = [member.radius, member.height / 2.0, 0.0]
                self._add_one(body, self._types.mjGEOM_CYLINDER, at, attitude, numbers, size=size)
            else:
                half = [length / 2.0 for length in member.size]
                self._add_one(body, self._types.mjGEOM_BOX, at, attitude, numbers, size=half)
        return len(parts_of(shape))

    def _add_one(
        self, body: Any, kind: Any, pos: Vector, quat: Quaternion, numbers: dict[str, Any], **more: Any
    ) -> None:
        x, y, z, w = quat
        body.add_geom(type=kind, pos=list(pos), quat=[w, x, y, z], mass=0.0, **numbers, **more)

    def _add_mesh(self, body: Any, points: FloatArray, pos: Vector, quat: Quaternion, numbers: dict[str, Any]) -> None:
        key = np.ascontiguousarray(points, dtype=np.float64).tobytes()
        if key not in self._meshes:
            name = f"hull {len(self._meshes)}"
            self._spec.add_mesh(name=name, uservert=np.frombuffer(key), inertia=self._inertia)
            self._meshes[key] = name
        self._add_one(body, self._types.mjGEOM_MESH, pos, quat, numbers, meshname=self._meshes[key])


def _prisms(mesh: Mesh) -> list[FloatArray]:
    """Return the six corners of a thin prism around each triangle of a mesh [m], without triangles of zero area.

    Raises:
        EngineError: If a corner is not finite.
    """
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.sqrt(np.einsum("ij,ij->i", normal, normal))
    good = area > _SMALLEST_AREA
    step = normal[good] * (0.25 * _TRIANGLE_THICKNESS / area[good])[:, None]
    if not math.isfinite(float(step.sum())):
        raise EngineError("a mesh has corners that are not finite")
    flat = corners[good]
    return list(np.concatenate((flat - step[:, None, :], flat + step[:, None, :]), axis=1))


def _require_group(group: int) -> None:
    """Raise `EngineError` if a collision group has no ray group in MuJoCo."""
    if group >= 1 << _MOST_GROUPS:
        raise EngineError(f"MuJoCo supports {_MOST_GROUPS} collision groups, bits 1 to 16; got {group}")


def _ray_flags(mask: int) -> Any:
    """Convert a ray's collision mask to MuJoCo's array of flags by geom group."""
    return np.array([*(mask >> number & 1 for number in range(_MOST_GROUPS)), 0], dtype=np.uint8)


def _write_masks(model: _CompiledModel, collision: Sequence[tuple[int, int]]) -> None:
    """Write the collision group and mask of each row into a model; 0, 0 removes a body from all collisions.

    Raises:
        EngineError: If there are more different pairs of group and mask than bits in MuJoCo's masks.
    """
    kinds, kind = np.unique([pair if all(pair) else (0, 0) for pair in collision], axis=0, return_inverse=True)
    if len(kinds) > _MOST_CLASSES:
        raise EngineError(f"MuJoCo: more than {_MOST_CLASSES} pairs of group and mask")
    groups, masks = kinds.T
    touch = (groups[:, None] & masks != 0) & (masks[:, None] & groups != 0)
    bits = (groups > 0) * (1 << np.arange(len(kinds)))
    affinity, numbers = touch @ bits, [(int(group).bit_length() or _MOST_GROUPS + 1) - 1 for group in groups]
    m, of_geom, of_body = model.m, kind.reshape(-1)[model.row_of_geom], kind.reshape(-1)[model.row_of_body]
    m.geom_contype[:], m.geom_conaffinity[:] = bits[of_geom], affinity[of_geom]
    m.geom_group[:] = np.array(numbers)[of_geom]
    m.body_contype[1:], m.body_conaffinity[1:] = bits[of_body], affinity[of_body]
    statics = slice(0, model.statics)
    m.body_contype[0] = np.bitwise_or.reduce(m.geom_contype[statics], initial=0)
    m.body_conaffinity[0] = np.bitwise_or.reduce(m.geom_conaffinity[statics], initial=0)
