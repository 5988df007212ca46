"""Writes what contacts want into the rows of MuJoCo's solver, and lets it solve for their forces.

The laws are in `contact_law`; here they are put in, solved, and corrected for what the solver's friction cone lifts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from simcore.physics.contact_law import RIGID, NormalLaw, excess, normal_law
from simcore.physics.contact_materials import ContactMaterials
from simcore.physics.contact_memory import ContactMemory
from simcore.physics.mujoco_model import ModelLayout
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["ConstraintRows", "RowsOfStep"]

_ITERATIONS = 5  # of Newton's method, which starts from the last step's forces
_ITERATIONS_OF_HITS = 30  # the same in a step with an impact, whose forces are new
_ITERATIONS_OF_HEAP = 60  # of conjugate gradients, each at a hundredth of the cost of one of Newton's
_TOLERANCE, _TOLERANCE_OF_HEAP = 1e-8, 1e-7
_HEAP = 40  # contacts between bodies from which on a step is one of a heap: some 20 balls
_FEW = 120  # rows up to which a step may be solved in many passes
_PASSES_OF_HEAP, _PASSES, _PASSES_OF_FEW = 2, 5, 20
"""Solutions of a step, each with the sliding that the one before found."""
_STICKS = 0.999  # a contact that uses less than this of its friction does not slide
_RELAXATION = 0.5  # taken whole, a ball that is pushed along between bumper and carpet never converges
_LIFT_TOLERANCE = 0.01  # [m/s] along the normal
_SLIP = 2e-3
"""Regularization of friction, in parts of the inverse mass: what is held creeps by that times h times the pull. A
hundredth of it where the contact resists rolling too, whose rows are softer by (friction / lever)^2.
"""
_SHEAR = 0.1
"""Stiffness across the normal in a heap, in parts of that along it, an estimate: with this a heap of 100 balls stands
4 % higher than at steps of 1.25 ms; with half of it 3 %, but a robot that drives into 60 balls is slowed by a fifth.
"""
_TIE_REPAIR = 0.2  # of the gap between a body and its pivot, in a step
_TIE_SOFTNESS = 1e-4  # regularization of such a tie, in parts of the inverse mass


@dataclass(slots=True, eq=False)
class RowsOfStep:
    """Contacts of a step that have rows, n of them."""

    normals: IntArray
    """Row of the normal of each, shape (n,)."""
    geoms: tuple[IntArray, IntArray]
    """The two shapes of each, shape (n,) each."""
    dim: IntArray
    """1 for a normal alone, 3 with friction, 6 with rolling resistance, shape (n,)."""
    frames: FloatArray
    """Normal and two directions across it, field frame, shape (n, 3, 3)."""
    law: NormalLaw
    reference: FloatArray
    """Reference acceleration of each row [m/s^2 or rad/s^2], shape (rows,)."""
    lift: FloatArray
    """What sliding would lift, as an acceleration [m/s^2], shape (n,)."""
    is_heap: bool
    """Whether many bodies touch each other."""
    known: tuple[BoolArray, FloatArray, FloatArray]
    """Which contacts pushed in the last step, their sliding times friction [m/s], and their friction [N]."""
    resisting: list[tuple[IntArray, IntArray, FloatArray]]
    """Friction, then rolling: which contacts, their two rows, (m, 2), and the factor of the normal force."""


class ConstraintRows:
    """The rows of one model.

    Args:
        mujoco: The package.
        model: The `MjModel`.
        data: The `MjData`.
        layout: Where each row of the engine is in it.
        materials: Of its shapes.
        gravity: [m/s^2]
    """

    def __init__(
        self, mujoco: Any, model: Any, data: Any, layout: ModelLayout, materials: ContactMaterials, gravity: float
    ) -> None:
        self._mj, self._m, self._d = mujoco, model, data
        self._body_of_geom = layout.body_of_geom
        self._materials = materials
        bodies = len(layout.row_of_body)
        self._bodies = bodies
        self._weight = np.zeros((bodies, 6))
        self._weight[:, 2] = -gravity
        self._push = data.xfrc_applied[1:]
        self._memory = ContactMemory(len(layout.body_of_geom))

    def set_friction(self) -> None:
        """Friction of each contact found, as products of the pair, and how many rows it needs."""
        contact, materials = self._d.contact, self._materials
        a, b = contact.geom.T
        friction_a, friction_b = materials.friction[a], materials.friction[b]
        friction = friction_a * friction_b
        rolling = materials.rolling[a] * friction_b + materials.rolling[b] * friction_a
        limits = contact.friction
        limits[:, :2] = friction[:, None]
        limits[:, 2] = 1e-5
        limits[:, 3:] = np.maximum(rolling, 1e-5)[:, None]
        contact.dim[:] = np.where(friction > 0.0, np.where(rolling > 0.0, 6, 3), 1)

    def prepare(self, h: float, is_pushed: bool) -> RowsOfStep:
        """Write what each row of each contact wants, and how strictly.

        Args:
            h: Step [s].
            is_pushed: Whether forces act on bodies in this step.
        """
        mj, m, d, materials = self._mj, self._m, self._d, self._materials
        contact, rows_of_all = d.contact, d.nefc
        used = np.nonzero(contact.efc_address >= 0)[0]
        row, dim = contact.efc_address[used], contact.dim[used]
        a, b = contact.geom[used].T
        jacobian = d.efc_J
        inverse = np.add.reduceat(jacobian * jacobian * materials.inverse_inertia[d.efc_J_colind], d.efc_J_rowadr)
        speed, free = np.zeros(rows_of_all), np.zeros(rows_of_all)
        mj.mj_mulJacVec(m, d, speed, d.qvel)
        mj.mj_mulJacVec(m, d, free, self._free_acceleration(is_pushed))
        stiffness = 1.0 / np.maximum(materials.compliance[a] + materials.compliance[b], 1.0 / RIGID)
        law = normal_law(
            contact.dist[used],
            speed[row],
            free[row],
            inverse[row],
            restitution=materials.restitution[a] * materials.restitution[b],
            stiffness=stiffness,
            give=np.minimum(materials.give[a], materials.give[b]),
            h=h,
        )
        reference = np.zeros(rows_of_all)
        strict = d.efc_R
        reference[row], strict[row] = law.reference, law.regularization
        ties = slice(0, d.ne)  # of bodies to their pivots: at the end of the step they are there
        reference[ties] = -(speed[ties] + _TIE_REPAIR * d.efc_pos[ties] / h) / h
        strict[ties] = _TIE_SOFTNESS * inverse[ties]
        between = np.count_nonzero((self._body_of_geom[a] >= 0) & (self._body_of_geom[b] >= 0))
        rows_of_step = RowsOfStep(
            normals=row,
            geoms=(a, b),
            dim=dim,
            frames=contact.frame[used].reshape(-1, 3, 3),
            law=law,
            reference=reference,
            lift=np.zeros(len(row)),
            is_heap=int(between) >= _HEAP,
            known=self._memory.recall(a, b),
            resisting=[],
        )
        if dim.max(initial=1) > 1:
            shear = _SHEAR * stiffness if rows_of_step.is_heap else None
            self._want_rest(rows_of_step, used, inverse, speed, free, shear, h)
        d.efc_D[:] = 1.0 / strict
        return rows_of_step

    def _want_rest(
        self,
        step: RowsOfStep,
        used: IntArray,
        inverse: FloatArray,
        speed: FloatArray,
        free: FloatArray,
        shear: FloatArray | None,
        h: float,
    ) -> None:
        """Friction and rolling resistance: their rows ask for rest at the end of the step.

        In a heap the friction is that of a spring across the normal, of the stiffness `shear` [N/m]; it starts the step
        with the force that it had, so what it holds stands still.
        """
        contact, row, dim, strict = self._d.contact, step.normals, step.dim, self._d.efc_R
        a, b = step.geoms
        is_known, _, held = step.known
        slip, squared = np.zeros(len(row)), np.zeros(len(row))
        for least, offset, column in ((3, 1, 0), (6, 4, 3)):
            some = np.nonzero(dim >= least)[0]
            if not len(some):
                continue
            rows = row[some][:, None] + np.array([offset, offset + 1])
            factor = contact.friction[used[some], column]
            reach = self._summed(factor * step.law.force[some] * inverse[rows].max(axis=1), a[some], b[some])
            wish = -speed[rows] / h
            step.reference[rows] = wish
            step.lift[some] = np.hypot(step.lift[some], factor * excess(wish, free[rows], reach))
            step.resisting.append((some, rows, factor))
            if least == 3:
                if shear is None:
                    slip[some] = np.where(dim[some] == 6, 0.01 * _SLIP, _SLIP) * inverse[rows].mean(axis=1)
                else:
                    slip[some] = 1.0 / (h * h * shear[some])
                    force = np.einsum("ijk,ik->ij", step.frames[some, 1:], held[some] * is_known[some, None])
                    step.reference[rows] += slip[some, None] * force
                squared[some] = factor * factor
                strict[rows] = slip[some][:, None]
                contact.mu[used[some]] = factor * np.sqrt(slip[some] / step.law.regularization[some])
            else:
                strict[rows] = (slip[some] * squared[some] / factor**2)[:, None]
                strict[row[some] + 3] = slip[some] * squared[some] / contact.friction[used[some], 2] ** 2

    def solve(self, step: RowsOfStep) -> None:
        """Forces of contacts, with what sliding would lift taken off their normals.

        The cone of the solver makes a contact that slides at v leave at friction times v. That much is taken off its
        reference, as guessed from the limits of friction first, and then as found until it does not change any more.
        """
        mj, m, d = self._mj, self._m, self._d
        reference, normals, law = step.reference, step.normals, step.law
        h, rows_of_all = m.opt.timestep, d.nefc
        option = m.opt
        if step.is_heap:
            option.solver, option.iterations = mj.mjtSolver.mjSOL_CG, _ITERATIONS_OF_HEAP
            option.tolerance, passes = _TOLERANCE_OF_HEAP, _PASSES_OF_HEAP
            asked = d.island_nefc[d.efc_island[normals]] <= _FEW  # in the heap itself one pass is enough
        else:
            option.solver, option.iterations = mj.mjtSolver.mjSOL_NEWTON, _ITERATIONS
            if law.hits.any():
                option.iterations = _ITERATIONS_OF_HITS
            option.tolerance, passes = _TOLERANCE, _PASSES if rows_of_all > _FEW else _PASSES_OF_FEW
            asked = np.ones(len(normals), dtype=bool)
        is_known, sliding, _ = step.known
        lift = np.where(is_known & ~law.hits, sliding / h, step.lift)
        for left in reversed(range(passes)):
            d.efc_aref[:] = reference
            d.efc_aref[normals] -= lift
            mj.mj_fwdConstraint(m, d)
            if not step.resisting:
                return
            found, pressed = self._sliding(step)
            is_done = bool((np.abs(found - lift) * h < _LIFT_TOLERANCE)[asked].all())
            lift = lift + _RELAXATION * (found - lift)
            if is_done or not left:
                self._memory.keep(*step.geoms, pressed > 0.0, lift * h, self._friction(step))
                return
            d.qacc_warmstart[:] = d.qacc

    def _sliding(self, step: RowsOfStep) -> tuple[FloatArray, FloatArray]:
        """What the sliding in the solution lifts [m/s^2], and the normal forces [N], shape (n,) each."""
        d, normals = self._d, step.normals
        got = np.zeros(len(step.reference))
        self._mj.mj_mulJacVec(self._m, d, got, d.qacc)
        got -= step.reference
        forces, strict = d.efc_force, d.efc_R
        squared, used = np.zeros(len(normals)), np.zeros(len(normals))
        for some, rows, factor in step.resisting:
            slides, force = got[rows], forces[rows]
            pulled = strict[rows[:, 0]] * np.hypot(force[:, 0], force[:, 1])
            size = np.hypot(slides[:, 0], slides[:, 1]) - pulled
            squared[some] += (factor * np.maximum(size, 0.0)) ** 2
            used[some] += np.einsum("ij,ij->i", force, force) / factor**2
        pressed = forces[normals]
        sticks = (pressed > 0.0) & (used < (_STICKS * pressed) ** 2)
        return np.where(sticks, 0.0, np.sqrt(squared)), pressed

    def _friction(self, step: RowsOfStep) -> FloatArray:
        """Forces across the normals in the solution, field frame [N], shape (n, 3)."""
        some, rows, _ = step.resisting[0]
        friction = np.zeros((len(step.normals), 3))
        friction[some] = np.einsum("ijk,ij->ik", step.frames[some, 1:], self._d.efc_force[rows])
        return friction

    def _summed(self, of_contact: FloatArray, a: IntArray, b: IntArray) -> FloatArray:
        """Sum of a quantity over the contacts of both bodies of each contact, statics left out, shape (n,)."""
        first, second = self._body_of_geom[a], self._body_of_geom[b]
        n = self._bodies + 1
        total = np.bincount(first + 1, of_contact, n) + np.bincount(second + 1, of_contact, n)
        total[0] = 0.0
        return np.asarray(total[first + 1] + total[second + 1])

    def _free_acceleration(self, is_pushed: bool) -> FloatArray:
        """Of all bodies by gravity and forces, without contacts [m/s^2], shape (6 n,); gyroscopic terms left out."""
        if not is_pushed:
            return np.asarray(self._weight.ravel())
        free = self._weight.copy()
        free[:, :3] += self._push[:, :3] / self._m.body_mass[1:, None]
        return np.asarray(free.ravel())
