"""Contacts on MuJoCo: who sleeps, which contacts bodies can come to within a step, and the rows of the solver for them.

What a contact wants is `contact_law`'s; here it is found, written and solved for. A body that sleeps is no wall, unless
it is fixed: what a knock reaches takes part in the same step with its mass, together with those that it comes to in
turn, as far as the knock carries (each passes on some two thirds of it).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from simcore.physics.contact_law import (
    BARELY,
    SLIP,
    contact_damping,
    normal_rows,
    pair_friction,
    pair_restitution,
    pair_rolling,
    pair_spring,
)
from simcore.physics.engine import BodyDefinition
from simcore.physics.mujoco_model import ITERATIONS, CompiledModel
from simcore.physics.shapes import Sphere
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["ContactRows", "ContactSearch", "SleepLists", "spins"]

_LOOK_AHEAD = 5e-4  # [m]; contacts are looked for this much farther than bodies move
_TOUCHING = 1e-4  # [m]
_KNOCK = 0.05  # [m/s]; slower ones are not passed on
_FAR = 0.001  # [m]; contacts with a wider gap may be of shapes that pass each other
_MISS = 0.05  # of the gap, that is left when it should be gone
_MOST_PASSES = 64  # each but the last wakes somebody
_NEAR = 0.004  # [m]; sleepers this near to each other pass a knock on
_HEAVY = 4.0  # times as heavy as what is hit: it passes no knock on
_PASSED_ON = 0.65  # of a knock, from one body of a row to the next: (1 + e) / 2 with e = 0.3
_AWAKE = -11  # MuJoCo's value of a tree that is fully awake
_STATIC = -1  # its state of a body of the world
_PASSES = 8  # solutions of a step at most
_MANY = 900  # rows; with more, Newton's method takes up to seconds a step, conjugate gradients some 10 ms
_OF_GRADIENTS = 20  # iterations of these in each solution: what is left is for the next, which starts from the last
_LIFT_TOLERANCE, _OF_BALLS = 0.001, 0.05  # [m/s], of what is taken off the normals: a box that slides must not hop
_TIE_REPAIR = 0.2  # of the gap between a body and its pivot, in a step
_TIE_SOFTNESS = 1e-4  # regularization of such a tie, in parts of the inverse mass


class SleepLists:
    """Sleep of all moving bodies of a model, and the lists of the awake that MuJoCo goes through.

    Each body is a tree of its own.
    """

    def __init__(self, model: CompiledModel) -> None:
        count = len(model.row_of_body)
        self.asleep: BoolArray = np.zeros(count, dtype=bool)
        """By body; call `mark` after a change."""
        self.fixed: BoolArray = np.zeros(count, dtype=bool)
        """Which of those asleep are part of the world for now, by body; call `mark` after a change."""
        self.awake: IntArray = np.arange(count)
        """Numbers of the bodies that are awake, in rising order."""
        self._d = model.d
        self._numbers = np.arange(count, dtype=np.int32)
        self._six = np.arange(6, dtype=np.int32)
        self._is_changed = True

    def mark(self) -> None:
        """Say that `asleep` has changed."""
        self._is_changed = True

    def write(self) -> None:
        """Bring the lists up to date, if `asleep` has changed."""
        if not self._is_changed:
            return
        d, asleep, fixed, numbers = self._d, self.asleep, self.asleep & self.fixed, self._numbers
        awake = ~asleep
        self.awake = np.nonzero(awake)[0]
        d.tree_asleep[:] = np.where(asleep & ~fixed, numbers, _AWAKE)
        d.tree_awake[:] = awake
        d.body_awake[1:] = np.where(fixed, _STATIC, awake)  # it refuses contacts with those asleep
        count, n = len(self.awake), len(asleep)
        d.body_awake_ind[0] = 0
        d.body_awake_ind[1 : count + 1] = self.awake + 1
        d.parent_awake_ind[:n] = numbers + 1  # the parent of each is the world
        d.dof_awake_ind[: 6 * count] = (6 * self.awake[:, None] + self._six).ravel()
        d.ntree_awake = count
        d.nbody_awake, d.nparent_awake, d.nv_awake = count + 1, n, 6 * count
        self._is_changed = False

    def keep_awake(self) -> None:
        """Undo MuJoCo's own count of how long each stands still: it would put it to sleep."""
        self._d.tree_asleep[self.awake] = _AWAKE
        self._d.tree_asleep[self.asleep & self.fixed] = _AWAKE


class ContactSearch:
    """The search in one model.

    Args:
        model: With its state.
        reach: Farthest that each moving body has from its center of mass, 0 for balls [m], shape (bodies,).
        radius: Of the smallest ball around each moving body [m], shape (bodies,).
        sleep: Who sleeps.
        gravity: [m/s^2]
    """

    def __init__(
        self, model: CompiledModel, reach: FloatArray, radius: FloatArray, sleep: SleepLists, gravity: float
    ) -> None:
        self._mj, self._m, self._d = model.mj, model.m, model.d
        self._qpos, self._qvel = model.qpos, model.qvel
        self._body_of_geom = model.body_of_geom
        self._first = int((model.body_of_geom < 0).sum())
        self._moving = model.body_of_geom[self._first :]
        self._reach, self._radius, self._sleep, self._gravity = reach, radius, sleep, gravity
        self._can_tip = np.append(reach > 0.0, False)  # -1, the field, is the last
        self._weight = gravity * model.m.body_mass[1:]

    def find(self, h: float) -> None:
        """Put the contacts of a step [s] into the `MjData`, with those of the sleepers that it wakes."""
        knock = np.zeros(len(self._reach))
        for _ in range(_MOST_PASSES):
            self._collide(h, knock)
            if not self._d.ncon or not self._wake(h, knock):
                break
        self._leave_out_misses(h)

    def _collide(self, h: float, knock: FloatArray) -> None:
        """Contacts of all that are awake, as far ahead as they move; `knock` is a speed that each may be given."""
        awake = self._sleep.awake
        v, w = self._qvel[awake, :3], self._qvel[awake, 3:]
        speed = np.sqrt(np.einsum("ij,ij->i", v, v)) + self._reach[awake] * np.sqrt(np.einsum("ij,ij->i", w, w))
        speed = np.maximum(speed, 1.5 * knock[awake])
        margin = self._m.body_margin[1:]
        margin[:] = 0.0
        margin[awake] = (speed + self._gravity * h) * h + _LOOK_AHEAD
        self._m.geom_margin[self._first :] = margin[self._moving]
        self._mj.mj_collision(self._m, self._d)

    def _wake(self, h: float, knock: FloatArray) -> bool:
        """Wake the sleepers that are touched and leave out contacts of all others.

        Returns:
            Whether to search again: somebody woke, or gets a knock that carries it farther than was looked.
        """
        contact, sleep = self._d.contact, self._sleep
        pair = self._body_of_geom[contact.geom]
        asleep = np.append(sleep.asleep, False)[pair]  # -1, the field, is the last
        contact.exclude[(asleep | (pair < 0)).all(axis=1)] = 1
        some = np.nonzero(((pair >= 0).all(axis=1)) & ~asleep.all(axis=1))[0]
        if not len(some):
            return False
        pair, asleep = pair[some], asleep[some]
        normal, at, gap = contact.frame[some, :3], contact.pos[some], contact.dist[some]
        own = np.stack((self._approach(pair[:, 0], normal, at), -self._approach(pair[:, 1], normal, at)), axis=1)
        closing = own.sum(axis=1)
        later = (asleep[:, 1] | (~asleep[:, 0] & (np.abs(own[:, 1]) < np.abs(own[:, 0])))).astype(np.int64)
        one = np.arange(len(some))
        body, sleeps = pair[one, later], asleep[one, later]
        waking = (gap <= np.maximum(closing, 0.0) * h + _TOUCHING) & ~sleep.fixed[body]
        contact.exclude[some[sleeps & ~waking & ~sleep.fixed[body]]] = 1
        waking &= sleeps | (closing > np.maximum(knock[body], _KNOCK))
        if not waking.any():
            return False
        hit = knock.copy()
        np.maximum.at(hit, body[waking], np.maximum(closing[waking], _KNOCK))
        self._spread(hit, h)
        woken = np.nonzero((hit > 0.0) & sleep.asleep)[0]
        farther = 1.5 * hit * h > self._m.body_margin[1:]
        knock[:] = hit
        if len(woken):
            sleep.asleep[woken] = False
            sleep.mark()
            sleep.write()
        return len(woken) > 0 or bool(farther.any())

    def _leave_out_misses(self, h: float) -> None:
        """Leave out contacts that are still apart when their gap, as it closes now, is gone: they pass each other.

        The nearest places of two shapes stay the nearest only as long as they move along the normal: a tube that slides
        over the end of a pipe would be stopped a few millimeters before it.
        """
        m, d, contact = self._m, self._d, self._d.contact
        pair = self._body_of_geom[contact.geom]
        apart = (contact.dist > _FAR) & (contact.exclude == 0) & self._can_tip[pair].any(axis=1)
        some = np.nonzero(apart)[0]
        if not len(some):
            return
        speeds = [self._velocity(pair[some, side], contact.pos[some]) for side in (0, 1)]
        way = speeds[1] - speeds[0]
        closing = -np.einsum("ij,ij->i", contact.frame[some, :3], way)
        gap = contact.dist[some]
        for number, (one, time) in enumerate(zip(some.tolist(), gap / np.maximum(closing, 1e-9), strict=True)):
            if time > h:
                continue
            first, second = contact.geom[one].tolist()
            before = d.geom_xpos[second].copy()
            d.geom_xpos[second] += time * way[number]
            left = self._mj.mj_geomDistance(m, d, first, second, float(gap[number]), None)
            d.geom_xpos[second] = before
            contact.exclude[one] = left > _MISS * gap[number]

    def _velocity(self, body: IntArray, at: FloatArray) -> FloatArray:
        """Velocities of places of bodies, -1 for statics, shape (n, 3) [m/s]."""
        speed = np.where(body[:, None] >= 0, self._qvel[body, :3], 0.0)
        turning = np.nonzero((body >= 0) & (self._reach[body] > 0.0))[0]
        which = body[turning]
        speed[turning] += _cross(spins(self._qpos[which], self._qvel[which]), at[turning] - self._qpos[which, :3])
        return speed

    def _spread(self, knock: FloatArray, h: float) -> None:
        """Pass knocks [m/s] on to all that those who get them come to within a step of h [s], and so on."""
        front = np.nonzero(knock)[0]
        left = (
            (self._m.body_contype[1:] != 0) & ~self._sleep.fixed & (self._weight < _HEAVY * self._weight[front].max())
        )
        left[front] = False
        pos, radius = self._qpos[:, :3], self._radius
        while len(front):
            others = np.nonzero(left)[0]
            if not len(others):
                return
            away = pos[front, None] - pos[others]
            near = np.add.outer(radius[front] + np.maximum(_NEAR, knock[front] * h), radius[others])
            touch = np.einsum("ijk,ijk->ij", away, away) < near * near
            passed_on = (_PASSED_ON * knock[front, None] * touch).max(axis=0)
            reached = passed_on >= _PASSED_ON * _KNOCK
            knock[others[reached]] = passed_on[reached]
            left[others[reached]] = False
            front = others[reached & (passed_on >= _KNOCK)]

    def _approach(self, body: IntArray, normal: FloatArray, at: FloatArray) -> FloatArray:
        """Speed of a place of each body along a direction [m/s], shape (n,)."""
        speed: FloatArray = np.einsum("ij,ij->i", normal, self._qvel[body, :3])
        turning = np.nonzero(self._reach[body])[0]
        if len(turning):
            which = body[turning]
            moves = _cross(spins(self._qpos[which], self._qvel[which]), at[turning] - self._qpos[which, :3])
            speed[turning] += np.einsum("ij,ij->i", normal[turning], moves)
        return speed


class ContactRows:
    """Writes what contacts want into the rows of one model's solver, and solves.

    Friction has rows across the normal that ask for rest at the end of the step, and get what the normal force times
    the friction of the pair can give. So do rows of rolling, with a lever in place of the friction. The cone of the
    solver is convex: what slides at v leaves at friction times v. That much is taken off the reference of the normal:
    first from the speeds before the step, then, if they change, from those that were found. What is left of the error
    shrinks to a third or less with each solution; where it swings, as in rows of balls, half of it is taken.

    Args:
        model: With its state.
        definitions: Of the bodies, by row.
    """

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
        friction = pair_friction(friction_a, friction_b)
        rolling = pair_rolling(self._rolling[a], friction_a, self._rolling[b], friction_b)
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
        is_large = d.nefc > _MANY
        m.opt.solver = mj.mjtSolver.mjSOL_CG if is_large else mj.mjtSolver.mjSOL_NEWTON
        m.opt.iterations = _OF_GRADIENTS if is_large else ITERATIONS
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
        stiffness, damping = pair_spring(
            (self._compliance[a], self._compliance[b]), (self._damping[a], self._damping[b])
        )
        wanted, softness = normal_rows(
            contact.dist[used],
            speed[row] + self._rolling_speed(used),
            free[row],
            inverse[row],
            restitution=pair_restitution(self._restitution[a], self._restitution[b]),
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
        slip = SLIP * mobile
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
            closing = np.einsum("ij,ij->i", _cross(spin, arm), out)
            axis = spin / rate[:, None]
            near = np.einsum("ij,ij->i", arm - np.einsum("ij,ij->i", axis, arm)[:, None] * axis, out)
            lowest = contact.dist[number] + near - np.hypot(closing / rate, near)
            speed[turns] += np.where(lowest > -BARELY, np.maximum(closing, 0.0), 0.0)
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


def spins(qpos: FloatArray, qvel: FloatArray) -> FloatArray:
    """Angular velocities in the field frame [rad/s], shape (n, 3), of states of free joints, (n, 7) and (n, 6)."""
    spin, quat = qvel[:, 3:], qpos[:, 3:]
    across = 2.0 * _cross(quat[:, 1:], spin)
    turned: FloatArray = spin + quat[:, :1] * across + _cross(quat[:, 1:], across)
    return turned


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products of rows, shape (n, 3); a tenth of the time of numpy's for a few rows."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    product = np.empty_like(a)
    product[:, 0] = ay * bz - az * by
    product[:, 1] = az * bx - ax * bz
    product[:, 2] = ax * by - ay * bx
    return product
