"""The engine on MuJoCo: the one module that imports it.

How it is set up, and why:

- Contact is MuJoCo's own, with one set of numbers a shape (`mujoco_model`). What robots drive over and into has neither
  friction nor bounce, and the spring that a step allows. While anything else is awake, a step of the caller is cut into
  parts of 0.5 ms at most: a bounce takes 8 ms, and a tube that tumbles gains 1.2 % of its energy in 1.5 s.
- A step is semi-implicit Euler, x += h v with the v of its end, as PyBullet's is.
- What `sleep` names sleeps as MuJoCo has it: it is skipped, and wakes when something that is awake touches it. What
  `fix` names sleeps, too, and is so heavy that what touches it meets a wall; after each step it is where it was.
- The model is compiled when it is first needed after a body was added; what moves keeps its state.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from simcore.errors import EngineError
from simcore.geometry.rotation import Quaternion, Vector, frame_pose, outer_pose, rotate, rotate_back
from simcore.physics.contact_law import contact_spring
from simcore.physics.engine import BodyDefinition, Engine, RayHits
from simcore.physics.mujoco_model import (
    TOUCHING,
    ModelQueries,
    build_model,
    ray_flags,
    require_group,
    set_mass,
    write_masks,
)
from simcore.typing import BoolArray, FloatArray
from simcore.units import GRAVITY

__all__ = ["MuJoCoEngine"]

_SMOOTH, _LONGEST = (
    0.02,
    0.0005,
)  # [s], steps at most: of what meets only statics without friction and bounce, and others
_FIXED = 1e6  # times its mass has a body while it is fixed
_AWAKE = -11  # MuJoCo's value of a body that is fully awake


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


class MuJoCoEngine(Engine):
    """One MuJoCo world. Use as a context manager, or call `close`."""

    name = "mujoco"

    def __init__(self, *, gravity: float = GRAVITY) -> None:
        self.gravity = gravity
        self._mj = _load_mujoco()
        self._is_open = True
        self._begin()

    def _begin(self) -> None:
        """An empty world. Moving bodies are counted in their order; their state is here until the model is compiled."""
        self._definitions: list[BodyDefinition] = []
        self._collision: list[tuple[int, int]] = []
        self._body: list[int] = []  # number of the moving body, -1 for statics, by row
        self._is_built = self._is_stale = self._is_listed = self._is_masked = False
        self._m: Any = None
        self._d: Any = None
        self._qpos: FloatArray = np.zeros((0, 7))  # center of mass, and attitude w, x, y, z
        self._qvel: FloatArray = np.zeros((0, 6))  # in the field frame, angular in the body frame
        self._push: FloatArray = np.zeros((0, 6))  # force and torque of the next step, field frame
        self._asleep: BoolArray = np.zeros(0, dtype=bool)
        self._fixed: BoolArray = np.zeros(0, dtype=bool)  # which of those asleep
        self._moved: BoolArray = np.zeros(0, dtype=bool)  # which are not where MuJoCo has last computed them to be

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
        require_group(definition.group)
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
            raise EngineError("MuJoCo: a static cannot be moved; make the world anew")
        center, (x, y, z, w) = frame_pose(pos, quat, d.center_of_mass, d.inertia_axes)
        self._qpos[body] = (*center, w, x, y, z)
        self._qvel[body] = 0.0
        self._moved[body] = self._is_stale = True

    def set_velocity(self, row: int, linear: Sequence[float], angular: Sequence[float]) -> None:
        self._require_open()
        body = self._body[row]
        self._qvel[body, :3] = linear
        self._qvel[body, 3:] = rotate_back(self._attitude(body), (angular[0], angular[1], angular[2]))

    def set_mass(self, row: int, mass: float, center_of_mass: Vector, inertia: Vector) -> None:
        (pos, quat), old, body = self.pose(row), self._definitions[row], self._body[row]
        new = self._definitions[row] = replace(old, mass=mass, center_of_mass=center_of_mass, inertia=inertia)
        self._qpos[body, :3], _ = frame_pose(pos, quat, new.center_of_mass, new.inertia_axes)
        if self._is_built:
            away = np.subtract(center_of_mass, old.center_of_mass).tolist()
            set_mass(self._m, body, mass, inertia, rotate_back(old.inertia_axes, away))
            self._own_mass[body] = mass, *inertia
        self._moved[body] = self._is_stale = True

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

    def centers(self, rows: Sequence[int]) -> FloatArray:
        self._require_open()
        centers: FloatArray = self._qpos[[self._body[row] for row in rows], :3]
        return centers

    def velocities(self, rows: Sequence[int]) -> FloatArray:
        return np.array([(*linear, *angular) for linear, angular in map(self.velocity, rows)]).reshape(-1, 6)

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
            self._loosen(row)

    def sleep(self, row: int) -> None:
        self._require_open()
        if (body := self._body[row]) >= 0:
            self._qvel[body] = 0.0
            self._asleep[body], self._is_listed = True, False
            self._loosen(row)

    def fix(self, row: int) -> None:
        self._require_open()
        if (body := self._body[row]) >= 0 and not self._fixed[body]:
            self._qvel[body] = 0.0
            self._asleep[body], self._fixed[body], self._is_listed = True, True, False
            self._weigh(row, _FIXED)

    def _loosen(self, row: int) -> None:
        """Give a body its own mass back."""
        if self._fixed[self._body[row]]:
            self._fixed[self._body[row]] = False
            self._weigh(row, 1.0)

    def _weigh(self, row: int, factor: float) -> None:
        body = self._body[row]
        if self._is_built:
            mass, *inertia = (factor * self._own_mass[body]).tolist()
            set_mass(self._m, body, mass, inertia)
            self._moved[body] = self._is_stale = True

    def _list_awake(self, awake: BoolArray) -> None:
        """Tell MuJoCo who is awake, in all of its lists; each body is a tree of its own."""
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
        """Bring the poses of all shapes up to date, also of sleepers that were put elsewhere."""
        self._build()
        if self._is_stale:
            if (self._moved & self._asleep).any():  # MuJoCo would wake them
                self._list_awake(~self._asleep | self._moved)
            self._kinematics()
            self._moved[:] = self._is_stale = False
        if not self._is_listed:
            self._list_awake(~self._asleep)
            self._is_listed = True
        if not self._is_masked:
            write_masks(self._model, self._collision)
            self._is_masked = True

    def _kinematics(self) -> None:
        self._mj.mj_fwdKinematics(self._m, self._d)
        self._mj.mj_makeM(self._m, self._d)
        self._mj.mj_factorM(self._m, self._d)

    # --- who touches whom ---------------------------------------------------------------------------------------

    def overlap(self, row: int) -> float:
        self._refresh()
        contact = self._d.contact
        mine = (self._row_of_geom[contact.geom] == row).any(axis=1)
        return max(0.0, -float(contact.dist[mine].min(initial=0.0)))

    def depth(self, row: int) -> float:
        self._refresh()
        return self._queries.depth(row)

    def contact_points(self, row: int) -> tuple[list[int], FloatArray]:
        self._build()
        contact = self._d.contact
        rows = self._row_of_geom[contact.geom].reshape(-1, 2)
        mine = (rows == row).any(axis=1) & (contact.dist < TOUCHING)
        return (rows[mine].sum(axis=1) - row).tolist(), contact.pos[mine]

    def set_collision(self, row: int, group: int, mask: int) -> None:
        self._require_open()
        require_group(group)
        self._collision[row], self._is_masked = (group, mask), False

    # --- the model ----------------------------------------------------------------------------------------------

    def _build(self) -> None:
        """Compile what was added; what was there keeps its state."""
        self._require_open()
        if self._is_built:
            return
        model = self._model = build_model(self._mj, self._definitions, self.gravity, _LONGEST)
        m, d = self._m, self._d = model.m, model.d
        self._row_of_body, self._row_of_geom = model.row_of_body, model.row_of_geom
        now = d.qpos.reshape(-1, 7), d.qvel.reshape(-1, 6), d.xfrc_applied[1:]
        for array, before in zip(now, (self._qpos, self._qvel, self._push), strict=True):
            array[:] = before
        self._qpos, self._qvel, self._push = now
        self._own_mass: FloatArray = np.column_stack((m.body_mass[1:], m.body_inertia[1:]))
        self._is_smooth, self._is_rigid = model.is_smooth, model.is_rigid
        m.opt.timestep = 0.0  # not known yet
        self._is_built, self._is_stale, self._is_listed, self._is_masked = True, True, False, False
        for row in model.row_of_body[self._fixed].tolist():
            self._weigh(row, _FIXED)
        self._moved[:] = True
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
        if (awake == asleep).any():  # it has woken those that were touched, or put to sleep who stands still
            woken = fixed[awake[fixed]]
            self._qpos[fixed], self._qvel[fixed], self._moved[woken] = before, 0.0, True
            asleep &= self._fixed | ~awake
            self._is_listed = False

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
