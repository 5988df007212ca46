"""The engine on MuJoCo: the one module that imports it.

How it is set up, and why (figures in docs/physics.md):

- MuJoCo finds contacts and solves for their forces (Newton's method, elliptic cones); what a contact wants is ours
  (`contact_law`), written into its rows between the two halves of a step. So friction and restitution of a pair are
  products here, too, where MuJoCo alone would take the larger, and a bounce is exact at any step.
- A step is cut into parts of at most 10 ms: a heap of 100 balls then settles to an overlap of 1 mm.
- Contacts are looked for as far ahead as bodies move within a part, so nothing passes a wall.
- Free flight is exact for a constant force: v += a h, x += h v + a h^2 / 2.
- Sleeping is ours: MuJoCo freezes and skips what `sleep` names, and nothing else.
- The model is compiled when it is first needed after a body was added; what moves keeps its state.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simcore.errors import EngineError
from simcore.geometry.rotation import Quaternion, Vector, rotate, rotate_back
from simcore.physics.contact_law import RIGID, excess, normal_law
from simcore.physics.engine import BodyDefinition, RayHits
from simcore.physics.mujoco_model import ModelLayout, bounds, build_model
from simcore.physics.shapes import Compound, Hull, Sphere
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import GRAVITY

__all__ = ["MuJoCoEngine"]

_LONGEST_PART = 0.01  # [s]
_ITERATIONS = 5  # of Newton's method, which starts from the last step's forces
_ITERATIONS_OF_HITS = 30  # the same in a step with an impact, whose forces are new
_FEW = 120  # rows up to which a step may be solved in many passes
_PASSES_OF_HEAP, _PASSES, _PASSES_OF_FEW = (
    3,
    5,
    20,
)  # solutions of a step, each with the sliding that the one before found
_HEAP = 400  # rows from which on a step is solved with few passes and iterations: some 60 balls in a heap
_STICKS = 0.999  # a contact that uses less than this of its friction does not slide
_RELAXATION = 0.5  # taken whole, a ball that is pushed along between bumper and carpet never converges
_LIFT_TOLERANCE = 0.01  # [m/s] along the normal
_TOLERANCE = 1e-8
_MOST_CLASSES = 31  # of bodies with the same group and mask: bits of MuJoCo's own masks
_MOST_GROUPS = 5  # MuJoCo tells six groups apart for rays; the sixth is of what is in no group
_HIDDEN = 5
_SLIP, _SLIP_OF_HEAP = 2e-3, 0.2
"""Regularization of friction, in parts of the inverse mass: what is held creeps by that times h times the pull. Heaps
are solved in fewer iterations with the second. A hundredth of it where the contact resists rolling too, whose rows are
softer by (friction / lever)^2.
"""
_LOOK_AHEAD = 5e-4  # [m]; contacts are looked for this much farther than bodies move
_LONGEST_ROW = 64  # bodies through which a knock is followed within a step
_KNOCK = 0.2  # [m/s]; slower hits move what they hit by less than 2 mm within a step
_MOST_PASSED = 16  # surfaces that a ray leaves from the inside before it is given up
_AWAKE = -11  # MuJoCo's value of a tree that is fully awake


def _load_mujoco() -> Any:
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


class MuJoCoEngine:
    """One MuJoCo world. Use as a context manager, or call `close`."""

    name = "mujoco"
    is_exact = True
    """Velocities are those at the end of a step, and a flight under a constant force is its parabola."""

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
        self._groups: dict[int, int] = {}  # ray group of MuJoCo by collision group
        self._classes: dict[tuple[int, int], int] = {}
        self._qpos: FloatArray = np.zeros((0, 7))
        self._qvel: FloatArray = np.zeros((0, 6))
        self._warm: FloatArray = np.zeros((0, 6))
        self._asleep: BoolArray = np.zeros(0, dtype=bool)
        self._affinity: list[int] = []
        self._class_of_geom: IntArray = np.zeros(0, dtype=np.int64)
        self._class_of_body: IntArray = np.zeros(0, dtype=np.int64)
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
        self._require_group(definition.group)
        self._definitions.append(definition)
        self._collision.append((definition.group, definition.mask))
        self._is_built = False
        if definition.mass > 0.0:
            self._starts[row] = _Start(_center(definition, definition.pos, definition.quat), definition.quat)
        return row

    def set_pose(self, row: int, pos: Sequence[float], quat: Sequence[float]) -> None:
        """Put the origin of a body somewhere [m]; its velocity becomes zero."""
        self._require_open()
        definition = self._definitions[row]
        if definition.mass == 0.0:
            raise EngineError("MuJoCo: a static cannot be moved; make the world anew")
        x, y, z, w = quat
        center = _center(definition, pos, (x, y, z, w))
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
        if definition.center_of_mass == (0.0, 0.0, 0.0):
            return (cx, cy, cz), quat
        ox, oy, oz = rotate(quat, definition.center_of_mass)
        return (cx - ox, cy - oy, cz - oz), quat

    def velocity(self, row: int) -> tuple[Vector, Vector]:
        """Velocity of the center of mass [m/s] and angular velocity [rad/s] of one body, field frame."""
        twist = self.velocities([row])[0].tolist()
        return (twist[0], twist[1], twist[2]), (twist[3], twist[4], twist[5])

    def centers(self, rows: Sequence[int]) -> FloatArray:
        """Centers of the bounding boxes, field frame [m], shape (n, 3)."""
        self._build()
        bodies = self._body_index[rows]
        if (self._is_centered[bodies] & (bodies >= 0)).all():
            centers: FloatArray = self._qpos[bodies, :3].copy()
            return centers
        boxes = [self._bounding_box(row) for row in rows]
        return np.array([0.5 * (low + high) for low, high in boxes]).reshape(-1, 3)

    def velocities(self, rows: Sequence[int]) -> FloatArray:
        """Linear and angular velocities, field frame [m/s, rad/s], shape (n, 6)."""
        self._build()
        bodies = self._body_index[rows]
        twist: FloatArray = self._qvel[bodies]
        twist[bodies < 0] = 0.0
        spin = twist[:, 3:]
        if spin.any():
            quat = self._qpos[bodies, 3:]
            across = 2.0 * _cross(quat[:, 1:], spin)
            twist[:, 3:] = spin + quat[:, :1] * across + _cross(quat[:, 1:], across)
        return twist

    def apply_forces(self, rows: Sequence[int], forces: FloatArray) -> None:
        """Forces at the centers of mass [N], shape (n, 3), field frame, for the next `step` only."""
        self._require_open()
        self._forces.append((np.asarray(rows, dtype=np.int64), np.array(forces, dtype=np.float64).reshape(-1, 3)))

    # --- sleep --------------------------------------------------------------------------------------------------

    def wake(self, row: int) -> None:
        """Let a body move again."""
        self._require_open()
        if row in self._starts:
            self._starts[row].is_asleep = False
        elif (body := self._body[row]) >= 0 and self._asleep[body]:
            self._asleep[body] = False
            self._sleep_changed = True

    def sleep(self, row: int) -> None:
        """Freeze a body until it is touched by a moving one or woken; its velocity becomes zero."""
        self._require_open()
        if row in self._starts:
            start = self._starts[row]
            start.is_asleep = True
            start.linear = start.angular = (0.0, 0.0, 0.0)
        elif (body := self._body[row]) >= 0:
            self._qvel[body] = 0.0
            self._warm[body] = 0.0
            if not self._asleep[body]:
                self._asleep[body] = True
                self._moved.add(body)  # MuJoCo wakes what is not where it was last computed to be
                self._is_stale = self._sleep_changed = True

    def _update_sleep(self) -> None:
        """Write who is awake into the lists that MuJoCo goes through."""
        d, asleep = self._d, self._asleep
        awake = ~asleep
        numbers = np.arange(len(asleep), dtype=np.int32)
        d.tree_asleep[:] = np.where(asleep, numbers, _AWAKE)
        d.tree_awake[:] = awake
        d.body_awake[1:] = awake
        bodies = np.concatenate((np.zeros(1, dtype=np.int32), numbers[awake] + 1))
        d.body_awake_ind[: len(bodies)] = bodies
        d.parent_awake_ind[: len(asleep)] = numbers + 1  # the parent of each is the world
        dofs = (6 * numbers[awake][:, None] + np.arange(6, dtype=np.int32)).ravel()
        d.dof_awake_ind[: len(dofs)] = dofs
        d.ntree_awake = int(awake.sum())
        d.nbody_awake, d.nparent_awake, d.nv_awake = len(bodies), len(asleep), len(dofs)
        self._sleep_changed = False

    def _refresh(self) -> None:
        """Bring the poses of all shapes up to date, also of sleepers that were put elsewhere."""
        self._build()
        if not self._is_stale:
            return
        moved_asleep = [body for body in sorted(self._moved) if self._asleep[body]]
        self._asleep[moved_asleep] = False
        self._update_sleep()
        self._kinematics()
        if moved_asleep:
            self._asleep[moved_asleep] = True
            self._update_sleep()
        self._moved.clear()
        self._is_stale = False

    def _kinematics(self) -> None:
        self._mj.mj_fwdKinematics(self._m, self._d)
        self._mj.mj_makeM(self._m, self._d)
        self._mj.mj_factorM(self._m, self._d)

    # --- who touches whom ---------------------------------------------------------------------------------------

    def set_sustained(self, row: int, sustained: bool) -> None:
        """Nothing: a contact is an impact or a spring by how it is loaded."""

    def set_careful(self, careful: bool) -> None:
        """Nothing: each step is solved as it needs."""

    def overlap(self, row: int) -> float:
        """How deep the body is in others, at its deepest contact [m]; 0 for none."""
        self._refresh()
        contact = self._d.contact
        mine = (self._layout.row_of_geom[contact.geom] == row).any(axis=1)
        return max(0.0, -float(contact.dist[mine].min(initial=0.0)))

    def set_collision(self, row: int, group: int, mask: int) -> None:
        """Change with what a body collides; 0, 0 takes it out of the world."""
        self._require_open()
        self._require_group(group)
        self._collision[row] = (group, mask)
        if self._is_built:
            self._write_collision(row)

    def _require_group(self, group: int) -> None:
        if group and group not in self._groups:
            if len(self._groups) == _MOST_GROUPS:
                raise EngineError(f"MuJoCo tells {_MOST_GROUPS} collision groups apart, group {group} is one more")
            self._groups[group] = len(self._groups)

    def _class(self, key: tuple[int, int]) -> int:
        """Number of the class of bodies with a group and mask; a new one learns who touches it."""
        if key not in self._classes:
            if len(self._classes) == _MOST_CLASSES:
                raise EngineError(f"MuJoCo: more than {_MOST_CLASSES} pairs of group and mask")
            self._classes[key] = len(self._classes)
            self._write_affinities()
        return self._classes[key]

    def _write_affinities(self) -> None:
        """Which classes touch which: each must have the other's group in its mask."""
        keys = list(self._classes)
        self._affinity = [0] * len(keys)
        for one, (group, mask) in enumerate(keys):
            for other, (other_group, other_mask) in enumerate(keys):
                if group & other_mask and other_group & mask:
                    self._affinity[one] |= 1 << other
        of_class = np.array([*self._affinity, 0], dtype=np.int32)
        self._m.geom_conaffinity[:] = of_class[self._class_of_geom]
        self._m.body_conaffinity[1:] = of_class[self._class_of_body]
        self._write_world()

    def _write_collision(self, row: int) -> None:
        group, mask = self._collision[row]
        number = self._class((group, mask)) if group and mask else -1
        bit = 1 << number if number >= 0 else 0
        affinity = self._affinity[number] if number >= 0 else 0
        m, geoms, body = self._m, self._geoms[row], self._body[row]
        m.geom_contype[geoms] = bit
        m.geom_conaffinity[geoms] = affinity
        m.geom_group[geoms] = self._groups[group] if group else _HIDDEN
        self._class_of_geom[geoms] = number
        if body >= 0:
            m.body_contype[body + 1] = bit
            m.body_conaffinity[body + 1] = affinity
            self._class_of_body[body] = number
        else:
            self._write_world()

    def _write_world(self) -> None:
        """What the statics together touch."""
        statics = self._layout.body_of_geom < 0
        self._m.body_contype[0] = np.bitwise_or.reduce(self._m.geom_contype[statics], initial=0)
        self._m.body_conaffinity[0] = np.bitwise_or.reduce(self._m.geom_conaffinity[statics], initial=0)

    # --- the model ----------------------------------------------------------------------------------------------

    def _build(self) -> None:
        """Compile what was added; what was there keeps its state."""
        self._require_open()
        if self._is_built:
            return
        old = None if self._m is None else (self._qpos.copy(), self._qvel.copy(), self._warm.copy(), self._asleep)
        old_rows = self._layout.row_of_body
        self._m, self._layout = build_model(self._mj, self._definitions, self.gravity)
        m = self._m
        d = self._d = self._mj.MjData(m)
        m.opt.iterations = _ITERATIONS
        m.opt.tolerance = _TOLERANCE
        layout = self._layout
        self._body: list[int] = layout.body_of_row.tolist()
        self._body_index = layout.body_of_row
        n = len(layout.row_of_body)
        self._qpos, self._qvel = d.qpos.reshape(n, 7), d.qvel.reshape(n, 6)
        self._warm, self._push = d.qacc_warmstart.reshape(n, 6), d.xfrc_applied[1:]
        self._asleep = np.zeros(n, dtype=bool)
        order = np.argsort(layout.row_of_geom, kind="stable")
        first = np.searchsorted(layout.row_of_geom[order], np.arange(len(self._definitions) + 1))
        self._geoms = [order[a:b] for a, b in itertools.pairwise(first)]
        self._fill_materials()
        if old is not None:
            bodies = layout.body_of_row[old_rows]
            self._qpos[bodies], self._qvel[bodies], self._warm[bodies], self._asleep[bodies] = old
        for row, start in self._starts.items():
            body = self._body[row]
            x, y, z, w = start.quat
            self._qpos[body] = (*start.pos, w, x, y, z)
            self._qvel[body, :3] = start.linear
            angular = start.angular
            self._qvel[body, 3:] = rotate_back(start.quat, (angular[0], angular[1], angular[2]))
            self._asleep[body] = start.is_asleep
        self._starts.clear()
        self._class_of_geom = np.full(m.ngeom, -1, dtype=np.int64)
        self._class_of_body = np.full(n, -1, dtype=np.int64)
        self._classes.clear()
        self._affinity = []
        for row in range(len(self._definitions)):
            self._write_collision(row)
        self._moved: set[int] = set(range(n))
        self._memory: tuple[IntArray, FloatArray] = (np.zeros(0, dtype=np.int64), np.zeros(0))
        self._is_stale = self._is_built = True

    def _fill_materials(self) -> None:
        """By geom and by moving body, what contacts are computed from."""
        layout, m = self._layout, self._m
        surfaces = [self._definitions[row].surface for row in layout.row_of_geom]
        self._friction = np.array([s.friction for s in surfaces])
        self._rolling = np.array([s.rolling for s in surfaces])
        self._bounce = np.array([s.restitution for s in surfaces])
        self._compliance = np.array([0.0 if s.stiffness is None else 1.0 / s.stiffness for s in surfaces])
        self._give = np.full(m.ngeom, math.inf)
        moving = [self._definitions[row] for row in layout.row_of_body]
        self._is_centered = np.array([not isinstance(one.shape, Compound | Hull) for one in moving], dtype=bool)
        self._is_centered &= np.array([one.center_of_mass == (0.0, 0.0, 0.0) for one in moving], dtype=bool)
        self._reach = np.zeros(len(moving))
        for body, one in enumerate(moving):
            low, high = bounds(one.shape)
            corner = np.maximum(np.abs(low - one.center_of_mass), np.abs(high - one.center_of_mass))
            self._reach[body] = 0.0 if isinstance(one.shape, Sphere) else np.linalg.norm(corner)
            if one.surface.stiffness is not None:
                self._give[self._geoms[layout.row_of_body[body]]] = 0.25 * float((high - low).min())
        inverse = np.repeat(1.0 / m.body_mass[1:, None], 6, axis=1)
        inverse[:, 3:] = 1.0 / m.body_inertia[1:]
        self._inverse_inertia = inverse.ravel()

    # --- one step -----------------------------------------------------------------------------------------------

    def step(self, h: float) -> None:
        """Advance by h [s], in equal parts of at most 10 ms.

        Raises:
            EngineError: A position or velocity is not finite any more.
        """
        self._build()
        if not len(self._asleep):
            return
        for rows, forces in self._forces:
            np.add.at(self._push[:, :3], self._body_index[rows], forces)
        parts = max(1, math.ceil(h / _LONGEST_PART - 1e-9))
        for _ in range(parts):
            self._advance(h / parts)
        if self._forces:
            self._forces.clear()
            self._push[:] = 0.0
        if not np.isfinite(self._d.qvel).all():
            bad = int(np.nonzero(~np.isfinite(self._qvel).all(axis=1))[0][0])
            raise EngineError(f"MuJoCo lost body {self._layout.row_of_body[bad]}: its velocity is not finite")

    def _advance(self, h: float) -> None:
        mj, m, d = self._mj, self._m, self._d
        m.opt.timestep = h
        self._refresh()
        if self._sleep_changed:
            self._update_sleep()
        d.tree_asleep[~self._asleep] = _AWAKE  # else what happens to stand still would be put to sleep
        self._find_contacts(h)
        if d.ncon:
            self._set_friction()
        mj.mj_makeConstraint(m, d)
        if d.nefc:
            self._prepare_rows(h)
        mj.mj_island(m, d)
        mj.mj_fwdVelocity(m, d)
        mj.mj_fwdAcceleration(m, d)
        if d.nefc:
            self._solve(h)
        else:
            mj.mj_fwdConstraint(m, d)
        shift = self._shift(h)
        mj.mj_Euler(m, d)
        self._qpos[:, :3] += shift
        self._is_stale = True

    def _find_contacts(self, h: float) -> None:
        """Contacts that bodies can reach within a step, and awake all that can be reached.

        A body that is hit may come as fast as what hits it, and so on in a row: looked for until no more are found.
        """
        d = self._d
        v = self._qvel
        own = np.sqrt(np.einsum("ij,ij->i", v[:, :3], v[:, :3]))
        own += self._reach * np.sqrt(np.einsum("ij,ij->i", v[:, 3:], v[:, 3:]))
        knock = np.zeros(len(own))  # speed that a body may be given within the step
        for _ in range(_LONGEST_ROW):
            margin = (own + knock + self.gravity * h) * h + _LOOK_AHEAD
            margin[self._asleep] = 0.0
            self._m.body_margin[1:] = margin
            self._m.geom_margin[:] = np.append(margin, 0.0)[self._layout.body_of_geom]
            self._mj.mj_collision(self._m, d)
            if not d.ncon:
                return
            pair = self._layout.body_of_geom[d.contact.geom]
            some = np.nonzero((pair >= 0).all(axis=1))[0]
            if not len(some):
                return
            contact, pair = d.contact, pair[some]
            normal, at = contact.frame[some, :3], contact.pos[some]
            closing = np.zeros(len(some))
            for side, sign in ((0, -1.0), (1, 1.0)):
                body = pair[:, side]
                twist = self.velocities(self._layout.row_of_body[body])
                moves = twist[:, :3] + _cross(twist[:, 3:], at - self._qpos[body, :3])
                closing += sign * np.einsum("ij,ij->i", normal, moves)
            passed_on = np.maximum(-1.5 * closing, knock[pair].max(axis=1))
            touched = contact.dist[some] <= np.maximum(-closing, passed_on) * h
            sleeps = self._asleep[pair]
            contact.exclude[some[~touched & sleeps.any(axis=1)]] = 1
            before = knock.copy()
            hard = touched & (passed_on > _KNOCK)
            for side in (0, 1):
                np.maximum.at(knock, pair[hard, side], passed_on[hard])
            woken = pair[touched][sleeps[touched]]
            if not len(woken) and (knock <= 1.05 * before + _KNOCK).all():
                return
            if len(woken):
                self._asleep[woken] = False
                self._update_sleep()

    def _set_friction(self) -> None:
        """Friction of each contact, as products of the pair, and how many rows it needs."""
        contact = self._d.contact
        a, b = contact.geom.T
        friction = self._friction[a] * self._friction[b]
        rolling = self._rolling[a] * self._friction[b] + self._rolling[b] * self._friction[a]
        contact.friction[:, :2] = friction[:, None]
        contact.friction[:, 2] = 1e-5
        contact.friction[:, 3:] = np.maximum(rolling, 1e-5)[:, None]
        contact.dim[:] = np.where(friction > 0.0, np.where(rolling > 0.0, 6, 3), 1)

    def _prepare_rows(self, h: float) -> None:
        """What each row of each contact wants, and how strictly."""
        mj, m, d = self._mj, self._m, self._d
        contact = d.contact
        used = np.nonzero(contact.efc_address >= 0)[0]
        row, dim = contact.efc_address[used], contact.dim[used]
        a, b = contact.geom[used].T
        jacobian = d.efc_J
        inverse = np.add.reduceat(jacobian * jacobian * self._inverse_inertia[d.efc_J_colind], d.efc_J_rowadr)
        speed, free = np.zeros(d.nefc), np.zeros(d.nefc)
        mj.mj_mulJacVec(m, d, speed, d.qvel)
        mj.mj_mulJacVec(m, d, free, self._free_acceleration())
        law = normal_law(
            contact.dist[used],
            speed[row],
            free[row],
            inverse[row],
            restitution=self._bounce[a] * self._bounce[b],
            stiffness=1.0 / np.maximum(self._compliance[a] + self._compliance[b], 1.0 / RIGID),
            give=np.minimum(self._give[a], self._give[b]),
            h=h,
        )
        reference = np.zeros(d.nefc)
        strict = d.efc_R
        reference[row], strict[row] = law.reference, law.regularization
        self._resisting: list[tuple[IntArray, IntArray, FloatArray]] = []
        softness = _SLIP_OF_HEAP if d.nefc > _HEAP else _SLIP
        lift = np.zeros(len(row))
        slip, squared = np.zeros(len(row)), np.zeros(len(row))
        for least, offset, column in ((3, 1, 0), (6, 4, 3)):
            some = np.nonzero(dim >= least)[0]
            if not len(some):
                continue
            rows = row[some][:, None] + np.array([offset, offset + 1])
            factor = contact.friction[used[some], column]
            reach = self._summed(factor * law.force[some] * inverse[rows].max(axis=1), a[some], b[some])
            wish = -speed[rows] / h
            reference[rows] = wish
            lift[some] = np.hypot(lift[some], factor * excess(wish, free[rows], reach))
            self._resisting.append((some, rows, factor))
            if least == 3:
                slip[some] = np.where(dim[some] == 6, 0.01 * softness, softness) * inverse[rows].mean(axis=1)
                squared[some] = factor * factor
                strict[rows] = slip[some][:, None]
                contact.mu[used[some]] = factor * np.sqrt(slip[some] / law.regularization[some])
            else:
                strict[rows] = (slip[some] * squared[some] / factor**2)[:, None]
                strict[row[some] + 3] = slip[some] * squared[some] / contact.friction[used[some], 2] ** 2
        d.efc_D[:] = 1.0 / strict
        self._reference, self._lift, self._law, self._rows, self._pairs = reference, lift, law, row, (a, b)

    def _solve(self, h: float) -> None:
        """Forces of contacts, with what sliding would lift taken off their normals.

        The cone of the solver makes a contact that slides at v leave at friction times v. That much is taken off its
        reference, as guessed from the limits of friction first, and then as found until it does not change any more.
        """
        mj, m, d = self._mj, self._m, self._d
        reference, lift, normals = self._reference, self._lift, self._rows
        is_hit = bool(self._law.hits.any())
        m.opt.iterations = _ITERATIONS_OF_HITS if is_hit and d.nefc <= _HEAP else _ITERATIONS
        passes = _PASSES_OF_HEAP if d.nefc > _HEAP else _PASSES if d.nefc > _FEW else _PASSES_OF_FEW
        lift = self._recalled(lift)
        for left in reversed(range(passes)):
            d.efc_aref[:] = reference
            d.efc_aref[normals] -= lift
            mj.mj_fwdConstraint(m, d)
            if not self._resisting:
                return
            got = np.zeros(d.nefc)
            mj.mj_mulJacVec(m, d, got, d.qacc)
            squared, used = np.zeros(len(normals)), np.zeros(len(normals))
            for some, rows, factor in self._resisting:
                slides = got[rows] - reference[rows]
                force = d.efc_force[rows]
                pulled = d.efc_R[rows[:, 0]] * np.hypot(force[:, 0], force[:, 1])
                size = np.hypot(slides[:, 0], slides[:, 1]) - pulled
                squared[some] += (factor * np.maximum(size, 0.0)) ** 2
                used[some] += np.einsum("ij,ij->i", force, force) / factor**2
            pressed = d.efc_force[normals]
            sticks = (pressed > 0.0) & (used < (_STICKS * pressed) ** 2)
            found = np.where(sticks, 0.0, np.sqrt(squared))
            is_done = bool((np.abs(found - lift) * h < _LIFT_TOLERANCE).all())
            lift = lift + _RELAXATION * (found - lift)
            if is_done or not left:
                self._remember(np.where(pressed > 0.0, lift * h, -1.0))
                return
            d.qacc_warmstart[:] = d.qacc

    def _keys(self) -> IntArray:
        """A number for each pair of shapes in contact, shape (n,)."""
        a, b = self._pairs
        keys: IntArray = a.astype(np.int64) * len(self._friction) + b
        return keys

    def _remember(self, speed: FloatArray) -> None:
        """Keep the sliding of contacts that push, times friction [m/s], for the next step."""
        keys = self._keys()[speed >= 0.0]
        order = np.argsort(keys, kind="stable")
        self._memory = keys[order], speed[speed >= 0.0][order]

    def _recalled(self, lift: FloatArray) -> FloatArray:
        """The sliding of contacts that pushed in the last step, as an acceleration; the guess for others."""
        keys, speed = self._memory
        if not len(keys):
            return lift
        mine = self._keys()
        at = np.minimum(np.searchsorted(keys, mine), len(keys) - 1)
        return np.where((keys[at] == mine) & ~self._law.hits, speed[at] / self._m.opt.timestep, lift)

    def _summed(self, of_contact: FloatArray, a: IntArray, b: IntArray) -> FloatArray:
        """Sum of a quantity over the contacts of both bodies of each contact, statics left out, shape (n,)."""
        first, second = self._layout.body_of_geom[a], self._layout.body_of_geom[b]
        n = len(self._asleep) + 1
        total = np.bincount(first + 1, of_contact, n) + np.bincount(second + 1, of_contact, n)
        total[0] = 0.0
        return np.asarray(total[first + 1] + total[second + 1])

    def _free_acceleration(self) -> FloatArray:
        """Of all bodies by gravity and forces, without contacts [m/s^2], shape (6 n,); gyroscopic terms left out."""
        free = np.zeros((len(self._asleep), 6))
        free[:, :3] = self._push[:, :3] / self._m.body_mass[1:, None]
        free[:, 2] -= self.gravity
        return np.asarray(free.ravel())

    def _shift(self, h: float) -> FloatArray:
        """What the positions after a step of semi-implicit Euler lack, shape (n, 3).

        Free flight: -a h^2 / 2. A body that bounces at time t does so then, not at the start: -t times the change of
        its velocity. Under load nothing is added: that keeps contacts stable.
        """
        d = self._d
        n = len(self._asleep)
        smooth = d.qacc_smooth.reshape(n, 6)[:, :3]
        free = ~self._asleep
        late = np.zeros(n)
        if d.nefc:
            law, body = self._law, self._layout.body_of_geom
            pushed = d.efc_force[self._rows] > 0.0
            first = np.full(n + 1, np.inf)
            held = np.zeros(n + 1, dtype=bool)
            for geom in self._pairs:
                held[body[geom[law.loaded | (pushed & ~law.hits)]]] = True
                hits = law.hits & pushed
                np.minimum.at(first, body[geom[hits]], law.hit_time[hits])
            late = np.where(np.isfinite(first[:n]), first[:n], 0.0)
            free &= ~held[:n]
        change = h * (d.qacc.reshape(n, 6)[:, :3] - smooth)
        late[self._asleep] = 0.0
        shift: FloatArray = np.where(free[:, None], -0.5 * h * h * smooth, 0.0) - late[:, None] * change
        return shift

    # --- questions ----------------------------------------------------------------------------------------------

    def rays(self, start: FloatArray, end: FloatArray, mask: int) -> RayHits:
        """First hits of segments, (n, 3) each [m], on bodies whose group is in `mask`."""
        groups = self._ray_groups(mask)
        start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
        found = [self._cast(a, b, groups) for a, b in zip(start, end, strict=True)]
        return RayHits(
            fraction=np.array([hit[0] for hit in found]),
            row=np.array([hit[1] for hit in found], dtype=np.int64),
            normal=np.array([hit[2] for hit in found]).reshape(-1, 3),
        )

    def first_hits(self, start: Sequence[float], ends: Sequence[Sequence[float]], mask: int) -> list[int]:
        """Row of what each segment from one place to n ends [m] meets first, -1 for nothing."""
        groups = self._ray_groups(mask)
        here = np.array(start, dtype=float)
        return [self._cast(here, np.array(end, dtype=float), groups)[1] for end in ends]

    def _ray_groups(self, mask: int) -> Any:
        self._refresh()
        groups = np.zeros(6, dtype=np.uint8)
        for group, number in self._groups.items():
            groups[number] = bool(group & mask)
        return groups

    def _cast(self, start: FloatArray, end: FloatArray, groups: Any) -> tuple[float, int, Sequence[float]]:
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
                return passed, int(self._layout.row_of_geom[geom[0]]), normal[:, 0].tolist()
            passed += 1e-9  # it left a body from the inside
        return 1.0, -1, (0.0, 0.0, 0.0)

    def overlapping(self, low: Sequence[float], high: Sequence[float]) -> list[int]:
        """Rows of the bodies whose bounding boxes overlap a box [m]."""
        self._refresh()
        geoms = np.nonzero(self._m.geom_contype)[0]
        least, most = self._boxes(geoms)
        hit = ((least <= high) & (most >= low)).all(axis=1)
        rows: list[int] = np.unique(self._layout.row_of_geom[geoms[hit]]).tolist()
        return rows

    def _boxes(self, geoms: IntArray) -> tuple[FloatArray, FloatArray]:
        """Corners of the bounding boxes of some geoms, field frame [m], shape (n, 3) each."""
        m, d = self._m, self._d
        axes, box = d.geom_xmat[geoms].reshape(-1, 3, 3), m.geom_aabb[geoms]
        center = d.geom_xpos[geoms] + (axes @ box[:, :3, None])[:, :, 0]
        half = (np.abs(axes) @ box[:, 3:, None])[:, :, 0]
        half[m.geom_type[geoms] == self._mj.mjtGeom.mjGEOM_PLANE] = np.inf
        return center - half, center + half

    def _bounding_box(self, row: int) -> tuple[FloatArray, FloatArray]:
        self._refresh()
        least, most = self._boxes(self._geoms[row])
        return least.min(axis=0), most.max(axis=0)

    def _require_open(self) -> None:
        if not self._is_open:
            raise EngineError("the physics world is closed; make a new one")


def _center(definition: BodyDefinition, pos: Sequence[float], quat: Quaternion) -> Vector:
    """Center of mass of a body whose origin is at a place [m]."""
    x, y, z = rotate(quat, definition.center_of_mass)
    return (pos[0] + x, pos[1] + y, pos[2] + z)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products of rows, shape (n, 3); a tenth of the time of numpy's for a few rows."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx), axis=1)
