"""The engine on MuJoCo: the one module that imports it.

How it is set up, and why (figures in docs/measurements.md):

- MuJoCo finds contacts and solves for their forces (Newton's method, elliptic cones); what a contact wants is ours
  (`contact_law`), written into its rows between the two halves of a step. So friction and restitution of a pair are
  products here, too, where MuJoCo alone would take the larger, and springs are taken at the end of the step.
- Contacts are looked for as far ahead as bodies move within a step, so nothing passes a wall.
- A step is semi-implicit Euler, x += h v with the v of its end, as PyBullet's is.
- Sleeping is ours: MuJoCo freezes and skips what `sleep` names, and nothing else; what `fix` names is part of the
  world until it is woken.
- The model is compiled when it is first needed after a body was added; what moves keeps its state.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from simcore.errors import EngineError
from simcore.geometry.rotation import (
    Quaternion,
    Vector,
    frame_pose,
    outer_pose,
    rotate_back,
)
from simcore.physics.engine import BodyDefinition, Contacts, Engine, RayHits
from simcore.physics.mass_properties import free_spin
from simcore.physics.mujoco_contacts import ContactRows, ContactSearch, SleepLists, spins
from simcore.physics.mujoco_model import (
    CollisionClasses,
    CompiledModel,
    ModelQueries,
    build_model,
    move_mass,
    ray_flags,
    require_group,
)
from simcore.physics.shapes import Sphere, bounding_box, bounding_radius
from simcore.typing import FloatArray, IntArray
from simcore.units import GRAVITY

__all__ = ["MuJoCoEngine"]

_SLIGHT = 1.0  # [N]; contacts with less are not told: half of the weight of a foam ball
_TOUCHING = 0.001  # [m]; bodies this near count as in contact


def _load_mujoco() -> Any:
    """The package; raises `EngineError` where it is not installed."""
    try:
        import mujoco
    except ImportError as error:
        raise EngineError(
            "MuJoCo is not installed: `python -m pip install mujoco`. It has wheels for Windows x64, macOS and Linux "
            f"on Python 3.10 and newer; this is Python {sys.version_info[0]}.{sys.version_info[1]} on {sys.platform}."
        ) from error
    return mujoco


@dataclass(slots=True)
class _Start:
    """State of a moving body that is not in the compiled model yet: center of mass, field frame."""

    pos: Vector
    quat: Quaternion
    linear: Sequence[float] = (0.0, 0.0, 0.0)
    angular: Sequence[float] = (0.0, 0.0, 0.0)
    is_asleep: bool = False
    is_fixed: bool = False


class MuJoCoEngine(Engine):
    """One MuJoCo world. Use as a context manager, or call `close`."""

    name = "mujoco"

    _sleep: SleepLists

    def __init__(self, *, gravity: float = GRAVITY) -> None:
        self.gravity = gravity
        self._mj = _load_mujoco()
        self._is_open = True
        self._begin()

    def _begin(self) -> None:
        """An empty world."""
        self._definitions: list[BodyDefinition] = []
        self._collision: list[tuple[int, int]] = []
        self._starts: dict[int, _Start] = {}
        self._forces: list[tuple[IntArray, FloatArray]] = []
        self._is_built = False
        self._m: Any = None
        self._d: Any = None
        self._qpos: FloatArray = np.zeros((0, 7))
        self._qvel: FloatArray = np.zeros((0, 6))
        self._warm: FloatArray = np.zeros((0, 6))
        self._row_of_body: IntArray = np.zeros(0, dtype=np.int64)
        self._model: CompiledModel | None = None

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
        row = len(self._definitions)
        require_group(definition.group)
        self._definitions.append(definition)
        self._collision.append((definition.group, definition.mask))
        self._is_built = False
        if definition.mass > 0.0:
            self._starts[row] = _Start(*_body_pose(definition, definition.pos, definition.quat))
        return row

    def set_pose(self, row: int, pos: Sequence[float], quat: Sequence[float]) -> None:
        self._require_open()
        definition = self._definitions[row]
        if definition.mass == 0.0:
            raise EngineError("MuJoCo: a static cannot be moved; make the world anew")
        center, (x, y, z, w) = _body_pose(definition, pos, quat)
        if row in self._starts:
            start = self._starts[row]
            start.pos, start.quat = center, (x, y, z, w)
            start.linear = start.angular = (0.0, 0.0, 0.0)
            return
        body = self._body[row]
        self._qpos[body, :3] = center
        self._qpos[body, 3:] = (w, x, y, z)
        self._qvel[body] = 0.0
        self._warm[body] = 0.0
        self._moved.add(body)
        self._is_stale = True

    def set_velocity(self, row: int, linear: Sequence[float], angular: Sequence[float]) -> None:
        self._require_open()
        if row in self._starts:
            start = self._starts[row]
            start.linear, start.angular = linear, angular
            return
        body = self._body[row]
        w, x, y, z = self._qpos[body, 3:].tolist()
        self._qvel[body, :3] = linear
        self._qvel[body, 3:] = rotate_back((x, y, z, w), (angular[0], angular[1], angular[2]))

    def set_mass(self, row: int, mass: float, center_of_mass: Vector, inertia: Vector) -> None:
        (pos, quat), old = self.pose(row), self._definitions[row]
        new = self._definitions[row] = replace(old, mass=mass, center_of_mass=center_of_mass, inertia=inertia)
        center, _ = _body_pose(new, pos, quat)
        if row in self._starts:
            self._starts[row].pos = center
            return
        number = self._body[row]
        self._qpos[number, :3] = center
        away = np.subtract(center_of_mass, old.center_of_mass).tolist()
        move_mass(self._m, number, mass, inertia, rotate_back(old.inertia_axes, away))
        self._contact_rows.set_mass(number, mass, inertia)
        self._moved.add(number)
        self._is_stale = True

    def pose(self, row: int) -> tuple[Vector, Quaternion]:
        self._require_open()
        definition = self._definitions[row]
        if definition.mass == 0.0:
            return definition.pos, definition.quat
        if row in self._starts:
            (cx, cy, cz), quat = self._starts[row].pos, self._starts[row].quat
        else:
            cx, cy, cz, w, x, y, z = self._qpos[self._body[row]].tolist()
            quat = (x, y, z, w)
        return outer_pose((cx, cy, cz), quat, definition.center_of_mass, definition.inertia_axes)

    def velocity(self, row: int) -> tuple[Vector, Vector]:
        twist = self.velocities([row])[0].tolist()
        return (twist[0], twist[1], twist[2]), (twist[3], twist[4], twist[5])

    def centers(self, rows: Sequence[int]) -> FloatArray:
        self._build()
        centers: FloatArray = self._qpos[self._body_index[rows], :3]
        return centers

    def velocities(self, rows: Sequence[int]) -> FloatArray:
        self._build()
        bodies = self._body_index[rows]
        twist: FloatArray = self._qvel[bodies]
        twist[bodies < 0] = 0.0
        turning = np.nonzero(twist[:, 3:].any(axis=1))[0]
        if len(turning):
            twist[turning, 3:] = spins(self._qpos[bodies[turning]], twist[turning])
        return twist

    def apply_forces(self, rows: Sequence[int], forces: FloatArray, centers: FloatArray | None = None) -> None:
        self._require_open()
        self._forces.append((np.asarray(rows, dtype=np.int64), np.array(forces, dtype=np.float64).reshape(-1, 3)))

    # --- sleep --------------------------------------------------------------------------------------------------

    def wake(self, row: int) -> None:
        self._require_open()
        if row in self._starts:
            self._starts[row].is_asleep = self._starts[row].is_fixed = False
        elif (body := self._body[row]) >= 0 and self._sleep.asleep[body]:
            self._sleep.asleep[body] = self._sleep.fixed[body] = False
            self._sleep.mark()

    def sleep(self, row: int) -> None:
        self._require_open()
        if row in self._starts:
            start = self._starts[row]
            start.is_asleep, start.is_fixed = True, False
            start.linear = start.angular = (0.0, 0.0, 0.0)
        elif (body := self._body[row]) >= 0:
            self._qvel[body] = 0.0
            self._warm[body] = 0.0
            self._sleep.fixed[body] = False
            self._sleep.mark()
            if not self._sleep.asleep[body]:
                self._sleep.asleep[body] = True
                self._moved.add(body)  # MuJoCo wakes what is not where it was last computed to be
                self._is_stale = True

    def fix(self, row: int) -> None:
        self.sleep(row)
        if row in self._starts:
            self._starts[row].is_fixed = True
        elif (body := self._body[row]) >= 0:
            self._sleep.fixed[body] = True
            self._sleep.mark()

    def _refresh(self) -> None:
        """Bring the poses of all shapes up to date, also of sleepers that were put elsewhere."""
        self._build()
        if not self._is_stale:
            return
        sleep = self._sleep
        moved_asleep = [body for body in sorted(self._moved) if sleep.asleep[body]]
        if moved_asleep:
            sleep.asleep[moved_asleep] = False
            sleep.mark()
        sleep.write()
        self._kinematics()
        if moved_asleep:
            sleep.asleep[moved_asleep] = True
            sleep.mark()
            sleep.write()
        self._moved.clear()
        self._is_stale = False

    def _kinematics(self) -> None:
        self._mj.mj_fwdKinematics(self._m, self._d)
        self._mj.mj_makeM(self._m, self._d)
        self._mj.mj_factorM(self._m, self._d)

    # --- who touches whom ---------------------------------------------------------------------------------------

    def renew_contacts(self, row: int) -> None:
        """Nothing: each step finds them anew."""

    def contacts(self, row: int | None = None) -> Contacts:
        self._refresh()
        contact = self._d.contact
        rows = self._row_of_geom[contact.geom]
        mine = contact.efc_address >= 0
        if row is not None:
            mine &= (rows == row).any(axis=1)
        size = self._d.efc_force[contact.efc_address[mine]]
        pressed = size > _SLIGHT
        mine, size = np.nonzero(mine)[0][pressed], size[pressed]
        return Contacts(rows=rows[mine], force=-size[:, None] * contact.frame[mine, :3])  # its normals are the second's

    def overlap(self, row: int) -> float:
        self._refresh()
        contact = self._d.contact
        mine = (self._row_of_geom[contact.geom] == row).any(axis=1)
        return max(0.0, -float(contact.dist[mine].min(initial=0.0)))

    def near_statics(self, row: int, reach: float) -> list[tuple[float, Vector, Vector]]:
        self._refresh()
        return self._queries.near_statics(row, reach)

    def contact_points(self, row: int) -> tuple[list[int], FloatArray]:
        self._refresh()
        contact = self._d.contact
        touch = contact.dist < _TOUCHING
        solved = np.nonzero(contact.efc_address >= 0)[0]
        touch[solved] |= self._d.efc_force[contact.efc_address[solved]] > 0.0  # met within the step
        rows = self._row_of_geom[contact.geom[touch]].reshape(-1, 2)
        mine = (rows == row).any(axis=1)
        return (rows[mine, 0] + rows[mine, 1] - row).tolist(), contact.pos[touch][mine]

    def set_stiffness(self, row: int, stiffness: float) -> None:
        self._build()
        self._contact_rows.set_stiffness(self._geoms[row], stiffness)

    def set_collision(self, row: int, group: int, mask: int) -> None:
        self._require_open()
        require_group(group)
        self._collision[row] = (group, mask)
        if self._is_built:
            self._classes.write(row, group, mask)

    # --- the model ----------------------------------------------------------------------------------------------

    def _build(self) -> None:
        """Compile what was added; what was there keeps its state."""
        self._require_open()
        if self._is_built:
            return
        before, rows = self._model, self._row_of_body
        if before is not None:
            old = (before.qpos.copy(), before.qvel.copy(), self._warm.copy(), self._sleep.asleep, self._sleep.fixed)
        model = self._model = build_model(self._mj, self._definitions, self.gravity)
        m, d = self._m, self._d = model.m, model.d
        self._body: list[int] = model.body_of_row.tolist()
        self._body_index, self._row_of_body = model.body_of_row, model.row_of_body
        self._row_of_geom, self._geoms = model.row_of_geom, model.geoms_of_row
        n = len(model.row_of_body)
        self._qpos, self._qvel = model.qpos, model.qvel
        self._warm, self._push = d.qacc_warmstart.reshape(n, 6), d.xfrc_applied[1:]
        sleep = self._sleep = SleepLists(model)
        if before is not None:
            now = (self._qpos, self._qvel, self._warm, sleep.asleep, sleep.fixed)
            for array, values in zip(now, old, strict=True):
                array[model.body_of_row[rows]] = values
        for row, start in self._starts.items():
            body = self._body[row]
            x, y, z, w = start.quat
            self._qpos[body] = (*start.pos, w, x, y, z)
            self._qvel[body, :3] = start.linear
            angular = start.angular
            self._qvel[body, 3:] = rotate_back(start.quat, (angular[0], angular[1], angular[2]))
            sleep.asleep[body], sleep.fixed[body] = start.is_asleep, start.is_fixed
        self._starts.clear()
        self._classes = CollisionClasses(model)
        for row, (group, mask) in enumerate(self._collision):
            self._classes.write(row, group, mask)
        moving = [self._definitions[row] for row in model.row_of_body]
        self._reach = np.array([_reach(one) for one in moving])
        self._is_top = np.ptp(m.body_inertia[1:], axis=1) > 0.0
        radius = np.array([bounding_radius(one.shape) for one in moving])
        self._search = ContactSearch(model, self._reach, radius, sleep, self.gravity)
        self._contact_rows = ContactRows(model, self._definitions)
        self._moved: set[int] = set(range(n))
        self._is_stale = self._is_built = True
        self._kinematics()  # of the statics, too
        self._queries = ModelQueries(model)

    # --- one step -----------------------------------------------------------------------------------------------

    def step(self, h: float) -> None:
        """Advance by h [s].

        Raises:
            EngineError: A position or velocity is not finite any more.
        """
        self._build()
        if not len(self._qpos):
            return
        mj, m, d = self._mj, self._m, self._d
        for rows, forces in self._forces:
            np.add.at(self._push[:, :3], self._body_index[rows], forces)
        self._refresh()
        self._sleep.write()
        self._sleep.keep_awake()
        self._search.find(h)
        if d.ncon:
            self._contact_rows.set_friction()
        m.opt.timestep = h
        mj.mj_makeConstraint(m, d)
        if d.nefc and self._sleep.fixed.any():
            d.efc_J[np.repeat(self._sleep.fixed, 6)[d.efc_J_colind]] = 0.0  # a static to those that touch it
        mj.mj_fwdVelocity(m, d)
        self._precess(h)
        mj.mj_fwdAcceleration(m, d)
        if d.nefc:
            self._contact_rows.solve(h)
        else:
            mj.mj_fwdConstraint(m, d)
        mj.mj_Euler(m, d)
        self._is_stale = True
        if self._forces:
            self._forces.clear()
            self._push[:] = 0.0
        if not np.isfinite(d.qvel).all():
            bad = int(np.nonzero(~np.isfinite(self._qvel).all(axis=1))[0][0])
            raise EngineError(f"MuJoCo lost body {self._row_of_body[bad]}: its velocity is not finite")

    def _precess(self, h: float) -> None:
        """Put the mean gyroscopic torques of a step [s] in the place of those at its start, which add energy."""
        tops = self._sleep.awake[self._is_top[self._sleep.awake]]
        tops = tops[self._qvel[tops, 3:].any(axis=1)]
        if len(tops):
            spin, moments = self._qvel[tops, 3:], self._m.body_inertia[tops + 1]
            self._d.qfrc_bias.reshape(-1, 6)[tops, 3:] = moments * (spin - free_spin(spin, moments, h)) / h

    # --- questions ----------------------------------------------------------------------------------------------

    def rays(self, start: FloatArray, end: FloatArray, mask: int) -> RayHits:
        self._refresh()
        groups = ray_flags(mask)
        start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
        found = [self._queries.cast(a, b, groups) for a, b in zip(start, end, strict=True)]
        return RayHits(
            fraction=np.array([hit[0] for hit in found]),
            row=np.array([hit[1] for hit in found], dtype=np.int64),
            normal=np.array([hit[2] for hit in found]).reshape(-1, 3),
        )

    def first_hits(self, start: Sequence[float], ends: Sequence[Sequence[float]], mask: int) -> list[int]:
        self._refresh()
        groups = ray_flags(mask)
        here = np.array(start, dtype=float)
        return [self._queries.cast(here, np.array(end, dtype=float), groups)[1] for end in ends]

    def overlapping(self, low: Sequence[float], high: Sequence[float]) -> list[int]:
        self._refresh()
        return self._queries.overlapping(low, high)

    def _require_open(self) -> None:
        if not self._is_open:
            raise EngineError("the physics world is closed; make a new one")


def _body_pose(definition: BodyDefinition, pos: Sequence[float], quat: Sequence[float]) -> tuple[Vector, Quaternion]:
    """Center of mass and principal axes of a body whose origin is at a pose."""
    return frame_pose(pos, quat, definition.center_of_mass, definition.inertia_axes)


def _reach(definition: BodyDefinition) -> float:
    """Farthest that a body has from its center of mass [m]; 0 for balls, whose spin moves nothing."""
    if isinstance(definition.shape, Sphere):
        return 0.0
    low, high = bounding_box(definition.shape)
    corner = np.maximum(np.abs(low - definition.center_of_mass), np.abs(high - definition.center_of_mass))
    return float(np.linalg.norm(corner))
