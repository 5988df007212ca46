"""Who sleeps; finds the contacts that bodies can come to within a step, and wakes who is touched.

A body that sleeps is no wall, unless it is fixed: what a knock reaches takes part in the same step with its mass,
together with those that it comes to in turn, as far as the knock carries (each passes on some two thirds of it).
"""

from __future__ import annotations

import numpy as np

from simcore.physics.mujoco_model import CompiledModel
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["ContactSearch", "SleepLists", "cross", "spins"]

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
        speed[turning] += cross(spins(self._qpos[which], self._qvel[which]), at[turning] - self._qpos[which, :3])
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
            moves = cross(spins(self._qpos[which], self._qvel[which]), at[turning] - self._qpos[which, :3])
            speed[turning] += np.einsum("ij,ij->i", normal[turning], moves)
        return speed


def spins(qpos: FloatArray, qvel: FloatArray) -> FloatArray:
    """Angular velocities in the field frame [rad/s], shape (n, 3), of states of free joints, (n, 7) and (n, 6)."""
    spin, quat = qvel[:, 3:], qpos[:, 3:]
    across = 2.0 * cross(quat[:, 1:], spin)
    turned: FloatArray = spin + quat[:, :1] * across + cross(quat[:, 1:], across)
    return turned


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products of rows, shape (n, 3); a tenth of the time of numpy's for a few rows."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    product = np.empty_like(a)
    product[:, 0] = ay * bz - az * by
    product[:, 1] = az * bx - ax * bz
    product[:, 2] = ax * by - ay * bx
    return product
