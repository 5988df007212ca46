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

import itertools
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from simcore.errors import EngineError
from simcore.geometry.rotation import IDENTITY, Quaternion, Vector, multiply, rotate, rotate_back
from simcore.physics.collision_classes import CollisionClasses, RayGroups
from simcore.physics.contact_law import ContactLaw
from simcore.physics.contact_search import ContactSearch, spins
from simcore.physics.engine import BodyDefinition, Contacts, RayHits
from simcore.physics.mujoco_model import ModelLayout, build_model, move_mass
from simcore.physics.mujoco_queries import ModelQueries
from simcore.physics.shape_extent import bounding_radius
from simcore.physics.shapes import Sphere, bounding_box
from simcore.physics.sleep_lists import SleepLists
from simcore.typing import FloatArray, IntArray
from simcore.units import GRAVITY

__all__ = ["MuJoCoEngine"]

_SLIGHT = 1.0  # [N]; contacts with less are not told: half of the weight of a foam ball
_TOUCHING = 0.001  # [m]; bodies this near count as in contact
_NEGLECTED = 0.002  # [m]; a body that moves less in a step gets no deeper into anything than this
_SKIN = 2e-5  # [m]; a body that is held back stops so far before what it meets


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


class MuJoCoEngine:
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
        self._groups = RayGroups()
        self._qpos: FloatArray = np.zeros((0, 7))
        self._qvel: FloatArray = np.zeros((0, 6))
        self._warm: FloatArray = np.zeros((0, 6))
        self._layout = ModelLayout(*(np.zeros(0, dtype=np.int64) for _ in range(4)))

    def __enter__(self) -> MuJoCoEngine:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def reset(self) -> None:
        """Remove everything from the world, so that it can be built anew."""
        self._require_open()
        self._begin()

    def close(self) -> None:
        """Free the world; may be called twice."""
        if self._is_open:
            self._begin()
            self._is_open = False

    # --- bodies -------------------------------------------------------------------------------------------------

    def add_body(self, definition: BodyDefinition) -> int:
        """Make a body or a static; returns its row."""
        self._require_open()
        row = len(self._definitions)
        self._groups.require(definition.group)
        self._definitions.append(definition)
        self._collision.append((definition.group, definition.mask))
        self._is_built = False
        if definition.mass > 0.0:
            turned = multiply(definition.quat, definition.inertia_axes)
            self._starts[row] = _Start(_center(definition, definition.pos, definition.quat), turned)
        return row

    def set_pose(self, row: int, pos: Sequence[float], quat: Sequence[float]) -> None:
        """Put the origin of a body somewhere [m]; its velocity becomes zero."""
        self._require_open()
        definition = self._definitions[row]
        if definition.mass == 0.0:
            raise EngineError("MuJoCo: a static cannot be moved; make the world anew")
        x, y, z, w = quat
        center = _center(definition, pos, (x, y, z, w))
        if definition.inertia_axes != IDENTITY:
            x, y, z, w = multiply(quat, definition.inertia_axes)
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
        """Velocity of the center of mass [m/s] and angular velocity [rad/s], field frame."""
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
        """Change mass [kg], center of mass [m] and principal moments [kg m^2]; the numbers of the velocity stay."""
        (pos, quat), old = self.pose(row), self._definitions[row]
        new = self._definitions[row] = replace(old, mass=mass, center_of_mass=center_of_mass, inertia=inertia)
        center = _center(new, pos, quat)
        if row in self._starts:
            self._starts[row].pos = center
            return
        number = self._body[row]
        self._qpos[number, :3] = center
        away = np.subtract(center_of_mass, old.center_of_mass).tolist()
        move_mass(self._m, number, mass, inertia, rotate_back(old.inertia_axes, away))
        self._law.set_mass(number, mass, inertia)
        self._moved.add(number)
        self._is_stale = True

    def pose(self, row: int) -> tuple[Vector, Quaternion]:
        """Origin [m] and attitude of one body, field frame."""
        self._require_open()
        definition = self._definitions[row]
        if definition.mass == 0.0:
            return definition.pos, definition.quat
        if row in self._starts:
            (cx, cy, cz), quat = self._starts[row].pos, self._starts[row].quat
        else:
            cx, cy, cz, w, x, y, z = self._qpos[self._body[row]].tolist()
            quat = (x, y, z, w)
        if definition.inertia_axes != IDENTITY:
            x, y, z, w = definition.inertia_axes
            quat = multiply(quat, (-x, -y, -z, w))
        if definition.center_of_mass == (0.0, 0.0, 0.0):
            return (cx, cy, cz), quat
        ox, oy, oz = rotate(quat, definition.center_of_mass)
        return (cx - ox, cy - oy, cz - oz), quat

    def velocity(self, row: int) -> tuple[Vector, Vector]:
        """Velocity of the center of mass [m/s] and angular velocity [rad/s] of one body, field frame."""
        twist = self.velocities([row])[0].tolist()
        return (twist[0], twist[1], twist[2]), (twist[3], twist[4], twist[5])

    def centers(self, rows: Sequence[int]) -> FloatArray:
        """Centers of mass, field frame [m], shape (n, 3)."""
        self._build()
        centers: FloatArray = self._qpos[self._body_index[rows], :3]
        return centers

    def velocities(self, rows: Sequence[int]) -> FloatArray:
        """Linear and angular velocities, field frame [m/s, rad/s], shape (n, 6)."""
        self._build()
        bodies = self._body_index[rows]
        twist: FloatArray = self._qvel[bodies]
        twist[bodies < 0] = 0.0
        turning = np.nonzero(twist[:, 3:].any(axis=1))[0]
        if len(turning):
            twist[turning, 3:] = spins(self._qpos[bodies[turning]], twist[turning])
        return twist

    def set_velocities(self, rows: Sequence[int], twists: FloatArray) -> None:
        """`set_velocity` of several bodies, linear and angular, shape (n, 6)."""
        for row, twist in zip(rows, twists.tolist(), strict=True):
            self.set_velocity(row, twist[:3], twist[3:])

    def apply_forces(self, rows: Sequence[int], forces: FloatArray, centers: FloatArray | None = None) -> None:
        """Forces at the centers of mass [N], shape (n, 3), field frame, for the next `step` only."""
        self._require_open()
        self._forces.append((np.asarray(rows, dtype=np.int64), np.array(forces, dtype=np.float64).reshape(-1, 3)))

    # --- sleep --------------------------------------------------------------------------------------------------

    def wake(self, row: int) -> None:
        """Let a body move again."""
        self._require_open()
        if row in self._starts:
            self._starts[row].is_asleep = self._starts[row].is_fixed = False
        elif (body := self._body[row]) >= 0 and self._sleep.asleep[body]:
            self._sleep.asleep[body] = self._sleep.fixed[body] = False
            self._sleep.mark()

    def sleep(self, row: int) -> None:
        """Freeze a body until it is touched by a moving one or woken; its velocity becomes zero."""
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
        """Freeze a body until it is woken, or put to sleep; what touches it meets a static."""
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
        """Forces between a body, or any, and others in the last step."""
        self._refresh()
        contact = self._d.contact
        rows = self._layout.row_of_geom[contact.geom]
        mine = contact.efc_address >= 0
        if row is not None:
            mine &= (rows == row).any(axis=1)
        size = self._d.efc_force[contact.efc_address[mine]]
        pressed = size > _SLIGHT
        mine, size = np.nonzero(mine)[0][pressed], size[pressed]
        return Contacts(rows=rows[mine], force=-size[:, None] * contact.frame[mine, :3])  # its normals are the second's

    def overlap(self, row: int) -> float:
        """How deep the body is in others, at its deepest contact [m]; 0 for none."""
        self._refresh()
        contact = self._d.contact
        mine = (self._layout.row_of_geom[contact.geom] == row).any(axis=1)
        return max(0.0, -float(contact.dist[mine].min(initial=0.0)))

    def depth(self, row: int) -> float:
        """How deep a body is in statics where it is now, whether it has been in a step there or not [m]; 0 for none."""
        self._refresh()
        return self._queries.depth(row)

    def touching(self, row: int) -> list[int]:
        """Rows of the bodies that a body was in contact with in the last step."""
        return sorted(set(self.contact_points(row)[0]))

    def contact_points(self, row: int) -> tuple[list[int], FloatArray]:
        """Where a body was in contact in the last step."""
        self._refresh()
        contact = self._d.contact
        touch = contact.dist < _TOUCHING
        solved = np.nonzero(contact.efc_address >= 0)[0]
        touch[solved] |= self._d.efc_force[contact.efc_address[solved]] > 0.0  # met within the step
        rows = self._layout.row_of_geom[contact.geom[touch]].reshape(-1, 2)
        mine = (rows == row).any(axis=1)
        return (rows[mine, 0] + rows[mine, 1] - row).tolist(), contact.pos[touch][mine]

    def free_share(self, row: int, h: float) -> float:
        """Share of a step of h [s] in which a body goes on without touching a static; 1 if it meets none."""
        self._build()
        body, fall = self._body[row], self.gravity * h
        vx, vy, vz, wx, wy, wz = self.velocities([row])[0].tolist()
        reach = (math.hypot(vx, vy, vz - fall) + self._reach[body] * math.hypot(wx, wy, wz)) * h
        if reach < _NEGLECTED:
            return 1.0
        self._refresh()
        share, (x, y, z) = 1.0, self._qpos[body, :3].tolist()
        for gap, (nx, ny, nz), at in self._queries.near_statics(row, reach):
            ax, ay, az = at[0] - x, at[1] - y, at[2] - z
            closing = -(
                nx * (vx + wy * az - wz * ay) + ny * (vy + wz * ax - wx * az) + nz * (vz - fall + wx * ay - wy * ax)
            )
            if closing * h <= gap + _NEGLECTED:
                continue
            if gap <= 2.0 * _SKIN:
                return 1.0  # an impact is played with all of its velocity
            share = min(share, (gap - _SKIN) / (closing * h))
        return share

    def set_stiffness(self, row: int, stiffness: float) -> None:
        """Give a body that is soft another stiffness [N/m]."""
        self._build()
        self._law.set_stiffness(self._geoms[row], stiffness)

    def set_collision(self, row: int, group: int, mask: int) -> None:
        """Change with what a body collides; 0, 0 takes it out of the world."""
        self._require_open()
        self._groups.require(group)
        self._collision[row] = (group, mask)
        if self._is_built:
            self._classes.write(row, group, mask)

    # --- the model ----------------------------------------------------------------------------------------------

    def _build(self) -> None:
        """Compile what was added; what was there keeps its state."""
        self._require_open()
        if self._is_built:
            return
        if has_old := self._m is not None:
            old = (self._qpos.copy(), self._qvel.copy(), self._warm.copy(), self._sleep.asleep, self._sleep.fixed)
        old_rows = self._layout.row_of_body
        self._m, self._layout = build_model(self._mj, self._definitions, self.gravity)
        m = self._m
        d = self._d = self._mj.MjData(m)
        layout = self._layout
        self._body: list[int] = layout.body_of_row.tolist()
        self._body_index = layout.body_of_row
        n = len(layout.row_of_body)
        self._qpos, self._qvel = d.qpos.reshape(n, 7), d.qvel.reshape(n, 6)
        self._warm, self._push = d.qacc_warmstart.reshape(n, 6), d.xfrc_applied[1:]
        sleep = SleepLists(d, n)
        self._sleep = sleep
        order = np.argsort(layout.row_of_geom, kind="stable")
        rows = np.arange(len(self._definitions) + 1)
        first: Any = np.searchsorted(layout.row_of_geom[order], rows)
        self._geoms = [order[a:b] for a, b in itertools.pairwise(first.tolist())]
        if has_old:
            now = (self._qpos, self._qvel, self._warm, sleep.asleep, sleep.fixed)
            for array, before in zip(now, old, strict=True):
                array[layout.body_of_row[old_rows]] = before
        for row, start in self._starts.items():
            body = self._body[row]
            x, y, z, w = start.quat
            self._qpos[body] = (*start.pos, w, x, y, z)
            self._qvel[body, :3] = start.linear
            angular = start.angular
            self._qvel[body, 3:] = rotate_back(start.quat, (angular[0], angular[1], angular[2]))
            sleep.asleep[body], sleep.fixed[body] = start.is_asleep, start.is_fixed
        self._starts.clear()
        self._classes = CollisionClasses(m, layout, self._geoms, self._groups)
        for row, (group, mask) in enumerate(self._collision):
            self._classes.write(row, group, mask)
        moving = [self._definitions[row] for row in layout.row_of_body]
        self._reach = np.array([_reach(one) for one in moving])
        radius = np.array([bounding_radius(one.shape) for one in moving])
        self._search = ContactSearch(self._mj, m, d, layout, self._reach, radius, sleep, self.gravity)
        self._law = ContactLaw(self._mj, m, d, layout, self._definitions)
        self._moved: set[int] = set(range(n))
        self._is_stale = self._is_built = True
        self._kinematics()  # of the statics, too
        self._queries = ModelQueries(self._mj, m, d, layout)

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
            self._law.set_friction()
        m.opt.timestep = h
        mj.mj_makeConstraint(m, d)
        if d.nefc and self._sleep.fixed.any():
            d.efc_J[np.repeat(self._sleep.fixed, 6)[d.efc_J_colind]] = 0.0  # a static to those that touch it
        mj.mj_fwdVelocity(m, d)
        mj.mj_fwdAcceleration(m, d)
        if d.nefc:
            self._law.solve(h)
        else:
            mj.mj_fwdConstraint(m, d)
        mj.mj_Euler(m, d)
        self._is_stale = True
        if self._forces:
            self._forces.clear()
            self._push[:] = 0.0
        if not np.isfinite(d.qvel).all():
            bad = int(np.nonzero(~np.isfinite(self._qvel).all(axis=1))[0][0])
            raise EngineError(f"MuJoCo lost body {self._layout.row_of_body[bad]}: its velocity is not finite")

    # --- questions ----------------------------------------------------------------------------------------------

    def rays(self, start: FloatArray, end: FloatArray, mask: int) -> RayHits:
        """First hits of segments, (n, 3) each [m], on bodies whose group is in `mask`."""
        self._refresh()
        groups = self._groups.flags(mask)
        start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
        found = [self._queries.cast(a, b, groups) for a, b in zip(start, end, strict=True)]
        return RayHits(
            fraction=np.array([hit[0] for hit in found]),
            row=np.array([hit[1] for hit in found], dtype=np.int64),
            normal=np.array([hit[2] for hit in found]).reshape(-1, 3),
        )

    def first_hits(self, start: Sequence[float], ends: Sequence[Sequence[float]], mask: int) -> list[int]:
        """Row of what each segment from one place to n ends [m] meets first, -1 for nothing."""
        self._refresh()
        groups = self._groups.flags(mask)
        here = np.array(start, dtype=float)
        return [self._queries.cast(here, np.array(end, dtype=float), groups)[1] for end in ends]

    def overlapping(self, low: Sequence[float], high: Sequence[float]) -> list[int]:
        """Rows of the bodies whose bounding boxes overlap a box [m]."""
        self._refresh()
        return self._queries.overlapping(low, high)

    def _require_open(self) -> None:
        if not self._is_open:
            raise EngineError("the physics world is closed; make a new one")


def _center(definition: BodyDefinition, pos: Sequence[float], quat: Quaternion) -> Vector:
    """Center of mass of a body whose origin is at a place [m]."""
    x, y, z = rotate(quat, definition.center_of_mass)
    return (pos[0] + x, pos[1] + y, pos[2] + z)


def _reach(definition: BodyDefinition) -> float:
    """Farthest that a body has from its center of mass [m]; 0 for balls, whose spin moves nothing."""
    if isinstance(definition.shape, Sphere):
        return 0.0
    low, high = bounding_box(definition.shape)
    corner = np.maximum(np.abs(low - definition.center_of_mass), np.abs(high - definition.center_of_mass))
    return float(np.linalg.norm(corner))
