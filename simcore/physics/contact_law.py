"""The one law of contact on MuJoCo, written into rows of its solver: spring, damper, restitution, Coulomb friction.

A solver that takes a reference acceleration `a_ref` and a regularization `R` for each row of a contact finds forces
with `(A + R) f = a_ref - a_0` where the row is active: `A` is its inverse mass, `a_0` what it does without contacts.

- Load. A spring and a damper, taken at the end of the step (implicit Euler): f = k x - c v. No step is too long for it.
  What is still apart may come no nearer than to touch, as softly.
- Restitution. Bodies that meet within the step leave with restitution times their closing speed (Newton's law).
- Friction. Rows across the normal ask for rest at the end of the step, and get what the normal force times the product
  of both frictions can give. So do rows of rolling, with a lever in place of the friction.

The cone of such a solver is convex: what slides at v leaves at friction times v. That much is taken off the reference
of the normal: first from the speeds before the step, then, if they change, from those that were found. What is left
of the error shrinks to a third or less with each solution; where it swings, as in rows of balls, half of it is taken.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from simcore.physics.contact_search import cross, spins
from simcore.physics.engine import BodyDefinition
from simcore.physics.mujoco_model import CompiledModel
from simcore.physics.shapes import Sphere
from simcore.physics.surface import contact_damping
from simcore.typing import FloatArray, IntArray

__all__ = ["ContactLaw", "normal_rows"]

REST_SPEED = 0.1
"""Slower impacts do not bounce [m/s]; such a bounce would rise 0.5 mm."""
RIGID = 5e6
"""Stiffness of a contact between rigid bodies [N/m]: a robot of 55 kg on four corners sinks by 0.007 mm. With a tenth
of it, a robot that slides pitches on the carpet by so much that its path depends on the step (24 mm in 12 m)."""
_PUSHED = 20.0  # [m/s^2]; twice what tires give a robot, which gets the speed of a step at its start
_RELAXATION = 0.02  # [s]; overlaps of rigid bodies go away with this time constant, so that they give no speed
_DEEPEST = 0.01  # [m]; deeper overlaps of rigid bodies push no more: bodies put into each other do not explode
_HARDNESS = 1e-3  # regularization of an impact, in parts of its inverse mass
_BARELY = 0.0015  # [m]; soft bodies that overlap by less can still bounce, what is squeezed is a spring
_SLIP = 2e-4  # regularization of friction, in parts of the inverse mass: what is held creeps by that times h times pull
_PASSES = 8  # solutions of a step at most
_MANY = 900  # rows; with more, Newton's method takes up to seconds a step, conjugate gradients some 10 ms
_LIFT_TOLERANCE, _OF_BALLS = 0.001, 0.05  # [m/s], of what is taken off the normals: a box that slides must not hop
_TIE_REPAIR = 0.2  # of the gap between a body and its pivot, in a step
_TIE_SOFTNESS = 1e-4  # regularization of such a tie, in parts of the inverse mass


def normal_rows(
    gap: FloatArray,
    speed: FloatArray,
    free: FloatArray,
    inverse_mass: FloatArray,
    *,
    restitution: FloatArray,
    stiffness: FloatArray,
    damping: FloatArray,
    h: float,
) -> tuple[FloatArray, FloatArray]:
    """What the normals of n contacts want, shape (n,) each.

    Args:
        gap: Between the surfaces, negative where they overlap [m].
        speed: Rate of the gap [m/s].
        free: Acceleration of the gap without contacts [m/s^2].
        inverse_mass: Of the row [1/kg].
        restitution: Of the pair [-].
        stiffness: Of the pair, `RIGID` for rigid ones [N/m].
        damping: Of the pair [N s/m].
        h: Step [s].

    Returns:
        Reference acceleration [m/s^2] and regularization [1/kg].
    """
    is_rigid = stiffness >= RIGID
    impulse = stiffness * h + damping  # force per speed at the end of the step [N s/m]
    softness = 1.0 / (h * impulse)
    depth = np.where(is_rigid, np.minimum(-gap, _DEEPEST), -gap)
    wanted = np.where(gap > 0.0, -gap / h, stiffness * depth / impulse)  # speed at which it pushes no more
    reference = (wanted - speed) / h
    after = speed + h * free
    slowest = np.where(is_rigid, max(REST_SPEED, _PUSHED * h), REST_SPEED)
    hits = (restitution > 0.0) & (speed < -slowest) & (gap + h * after < 0.0) & (is_rigid | (gap > -_BARELY))
    bounce = free + (-restitution * speed - after) / h * (1.0 + _HARDNESS)
    return np.where(hits, bounce, reference), np.where(hits, _HARDNESS * inverse_mass, softness)


class ContactLaw:
    """The contacts of one model; `definitions` are those of the bodies, by row."""

    def __init__(self, model: CompiledModel, definitions: Sequence[BodyDefinition]) -> None:
        self._mj, self._m, self._d = model.mj, model.m, model.d
        self._qpos, self._qvel = model.qpos, model.qvel
        self._body_of_geom = model.body_of_geom
        self._can_tip = np.ptp(model.m.body_inertia[1:], axis=1) > 0.0  # all bodies but balls
        of_geom = [definitions[row] for row in model.row_of_geom]
        surfaces = [one.surface for one in of_geom]
        self._friction = np.array([s.friction for s in surfaces])
        self._rolling = np.array([s.rolling for s in surfaces])
        self._restitution = np.array([s.restitution for s in surfaces])
        self._compliance = np.zeros(len(surfaces))
        self._damping = np.zeros(len(surfaces))
        self._mass = np.array([one.mass for one in of_geom])
        self._tolerance = np.array([_OF_BALLS if isinstance(one.shape, Sphere) else _LIFT_TOLERANCE for one in of_geom])
        for geom, surface in enumerate(surfaces):
            if surface.stiffness is not None:
                self.set_stiffness(np.array([geom]), surface.stiffness)
        inverse = np.repeat(1.0 / model.m.body_mass[1:, None], 6, axis=1)
        inverse[:, 3:] = 1.0 / model.m.body_inertia[1:]
        self._inverse_inertia = inverse.ravel()

    def set_stiffness(self, geoms: IntArray, stiffness: float) -> None:
        """Give the shapes of a body another stiffness [N/m]."""
        self._compliance[geoms] = 1.0 / stiffness
        self._damping[geoms] = contact_damping("mujoco", stiffness, float(self._mass[geoms[0]]))

    def set_mass(self, body: int, mass: float, inertia: Sequence[float]) -> None:
        """Give a moving body another mass [kg] and other principal moments [kg m^2]."""
        self._inverse_inertia[6 * body : 6 * body + 6] = 1.0 / np.array((mass, mass, mass, *inertia))

    def set_friction(self) -> None:
        """Friction of each contact found, as products of the pair, and how many rows it needs."""
        contact = self._d.contact
        a, b = contact.geom.T
        friction_a, friction_b = self._friction[a], self._friction[b]
        friction = friction_a * friction_b
        rolling = self._rolling[a] * friction_b + self._rolling[b] * friction_a
        limits = contact.friction
        limits[:, :2] = friction[:, None]
        limits[:, 2] = 1e-5
        limits[:, 3:] = np.maximum(rolling, 1e-5)[:, None]
        contact.dim[:] = np.where(friction > 0.0, np.where(rolling > 0.0, 6, 3), 1)

    def solve(self, h: float) -> None:
        """Accelerations and forces of a step of h [s]; speeds and accelerations without contacts are known.

        In each body frame the mass matrix is diagonal, so the inverse mass of a row is the sum of its entries squared.
        """
        mj, m, d = self._mj, self._m, self._d
        m.opt.solver = mj.mjtSolver.mjSOL_CG if d.nefc > _MANY else mj.mjtSolver.mjSOL_NEWTON
        contact, address = d.contact, d.contact.efc_address
        used = np.nonzero(address >= 0)[0]
        row = address[used]
        a, b = contact.geom[used].T
        jacobian, speed, strict = d.efc_J, d.efc_vel, d.efc_R
        inverse = np.add.reduceat(jacobian * jacobian * self._inverse_inertia[d.efc_J_colind], d.efc_J_rowadr)
        free = np.zeros(len(speed))
        mj.mj_mulJacVec(m, d, free, d.qacc_smooth)
        reference = d.efc_aref
        ties = slice(0, d.ne)  # of bodies to their pivots: at the end of the step they are there
        reference[ties] = -(speed[ties] + _TIE_REPAIR * d.efc_pos[ties] / h) / h
        strict[ties] = _TIE_SOFTNESS * inverse[ties]
        stiffness = 1.0 / np.maximum(self._compliance[a] + self._compliance[b], 1.0 / RIGID)
        damping = self._damping[a] + self._damping[b]
        damping[damping == 0.0] = RIGID * _RELAXATION
        wanted, softness = normal_rows(
            contact.dist[used],
            speed[row] + self._rolling_speed(used),
            free[row],
            inverse[row],
            restitution=self._restitution[a] * self._restitution[b],
            stiffness=stiffness,
            damping=damping,
            h=h,
        )
        reference[row], strict[row] = wanted, softness
        dim = contact.dim[used]
        slide = np.nonzero(dim > 1)[0]
        if not len(slide):
            d.efc_D[:] = 1.0 / strict
            self._find_forces()
            return
        number, normal = used[slide], row[slide]
        across = normal[:, None] + np.array([1, 2])
        friction = contact.friction[number, 0]
        mobile = inverse[across].mean(axis=1)
        slip = _SLIP * mobile
        contact.mu[number] = friction * np.sqrt(slip / softness[slide])
        reference[across], strict[across] = speed[across] * (-1.0 / h), slip[:, None]
        rolls = np.nonzero(dim[slide] > 3)[0]
        turn = normal[rolls, None] + np.array([4, 5])
        lever = contact.friction[number[rolls], 3]
        if len(rolls):
            scaled = slip[rolls] * friction[rolls] ** 2
            reference[turn], strict[turn] = speed[turn] * (-1.0 / h), (scaled / lever**2)[:, None]
            strict[normal[rolls] + 3] = scaled / contact.friction[number[rolls], 2] ** 2
        d.efc_D[:] = 1.0 / strict
        wanted = wanted[slide]
        tolerance = np.maximum(self._tolerance[a[slide]], self._tolerance[b[slide]])
        lift = self._lift(speed / h, across, friction, turn, lever, rolls)
        reached, before, rate = np.zeros(len(speed)), np.zeros(len(lift)), np.ones(len(lift))
        for left in reversed(range(_PASSES)):
            reference[normal] = wanted - lift
            self._find_forces()
            if not left:
                return
            mj.mj_mulJacVec(m, d, reached, d.qacc)
            error = self._lift(speed / h + reached, across, friction, turn, lever, rolls) - lift
            touch = (d.efc_force[normal] > 0.0) | (reached[normal] < wanted)
            is_solved = d.solver_niter[: max(d.nisland, 1)].max() < m.opt.iterations  # else balls of a heap of 300 jump
            if is_solved and (np.abs(error[touch]) * h < tolerance[touch]).all():
                return
            rate = np.where(error * before < 0.0, 0.5 * rate, np.minimum(1.2 * rate, 1.0))
            before = error
            lift += rate * error
            d.qacc_warmstart[:] = d.qacc

    def _rolling_speed(self, used: IntArray) -> FloatArray:
        """How fast places of contacts come nearer by turning, where it brings them no deeper than others are [m/s].

        A place goes round on a circle, its velocity along the tangent: a tube that rolls would be thrown up by parts of
        its rim that are still ahead, although what carries it is already found.
        """
        contact, speed = self._d.contact, np.zeros(len(used))
        qpos, qvel = self._qpos, self._qvel
        for side, sign in ((0, 1.0), (1, -1.0)):
            body = self._body_of_geom[contact.geom[used, side]]
            turns = np.nonzero((body >= 0) & self._can_tip[body])[0]
            body, number = body[turns], used[turns]
            out, spin = sign * contact.frame[number, :3], spins(qpos[body], qvel[body])
            arm = contact.pos[number] - qpos[body, :3] - 0.5 * contact.dist[number, None] * out
            rate = np.maximum(np.sqrt(np.einsum("ij,ij->i", spin, spin)), 1e-9)
            closing = np.einsum("ij,ij->i", cross(spin, arm), out)
            axis = spin / rate[:, None]
            near = np.einsum("ij,ij->i", arm - np.einsum("ij,ij->i", axis, arm)[:, None] * axis, out)
            lowest = contact.dist[number] + near - np.hypot(closing / rate, near)
            speed[turns] += np.where(lowest > -_BARELY, np.maximum(closing, 0.0), 0.0)
        return speed

    def _find_forces(self) -> None:
        self._mj.mj_island(self._m, self._d)  # it copies the rows
        self._mj.mj_fwdConstraint(self._m, self._d)

    @staticmethod
    def _lift(
        speed: FloatArray, across: IntArray, friction: FloatArray, turn: IntArray, lever: FloatArray, rolls: IntArray
    ) -> FloatArray:
        """What the convex cone adds to the normals of sliding contacts, in the unit of the speeds of all rows."""
        x, y = speed[across].T
        lift: FloatArray = friction * np.sqrt(x * x + y * y)
        if len(rolls):
            x, y = speed[turn].T
            lift[rolls] = np.hypot(lift[rolls], lever * np.sqrt(x * x + y * y))
        return lift
