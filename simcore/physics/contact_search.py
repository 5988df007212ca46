"""Finds the contacts that bodies can come to within a step, and wakes who is touched."""

from __future__ import annotations

from typing import Any

import numpy as np

from simcore.physics.mujoco_model import ModelLayout
from simcore.physics.sleep_lists import SleepLists
from simcore.typing import FloatArray, IntArray

__all__ = ["ContactSearch", "cross", "spins"]

_LOOK_AHEAD = 5e-4  # [m]; contacts are looked for this much farther than bodies move
_LONGEST_ROW = 64  # bodies through which a knock is followed within a step
_PARALLEL = 0.9999  # cosine between normals of one plane
_KNOCK = 0.2  # [m/s]; slower hits move what they hit by less than 2 mm within a step


class ContactSearch:
    """The search in one model.

    Args:
        mujoco: The package.
        model: The `MjModel`.
        data: The `MjData`.
        layout: Where each row is in it.
        reach: Farthest that each moving body has from its center of mass, 0 for balls [m].
        sleep: Who sleeps.
        gravity: [m/s^2]
    """

    def __init__(
        self,
        mujoco: Any,
        model: Any,
        data: Any,
        layout: ModelLayout,
        reach: FloatArray,
        sleep: SleepLists,
        gravity: float,
    ) -> None:
        self._mj, self._m, self._d = mujoco, model, data
        self._body_of_geom = layout.body_of_geom
        n = len(reach)
        self._first = int((layout.body_of_geom < 0).sum())  # shapes of moving bodies come after those of statics
        self._reach, self._sleep, self._gravity = reach, sleep, gravity
        self._qpos, self._qvel = data.qpos.reshape(n, 7), data.qvel.reshape(n, 6)

    def find(self, h: float) -> None:
        """Put the contacts of a step [s] into the `MjData`.

        A body that is hit may come as fast as what hits it, and so on in a row: looked for until no more are found.
        """
        d, sleep = self._d, self._sleep
        knock = np.zeros(len(self._reach))  # speed that a body may be given within the step
        body_margin, geom_margin = self._m.body_margin[1:], self._m.geom_margin[self._first :]
        moving = self._body_of_geom[self._first :]
        for _ in range(_LONGEST_ROW):
            awake = sleep.awake
            v, w = self._qvel[awake, :3], self._qvel[awake, 3:]
            speed = np.sqrt(np.einsum("ij,ij->i", v, v)) + self._reach[awake] * np.sqrt(np.einsum("ij,ij->i", w, w))
            body_margin[:] = 0.0
            body_margin[awake] = (speed + knock[awake] + self._gravity * h) * h + _LOOK_AHEAD
            geom_margin[:] = body_margin[moving]
            self._mj.mj_collision(self._m, d)
            if not d.ncon or not self._follow(h, knock):
                return

    def is_crowded(self) -> bool:
        """Whether, of what was found, bodies touch each other or rub on two planes at once."""
        contact = self._d.contact
        used = contact.exclude == 0
        pair = self._body_of_geom[contact.geom[used]]
        if not len(pair):
            return False
        if pair.min(axis=1).max() >= 0:
            return True
        rubs = np.nonzero(contact.dim[used] > 1)[0]
        normal = contact.frame[used][rubs, :3]
        _, first, which = np.unique(pair[rubs].max(axis=1), return_index=True, return_inverse=True)
        return bool((np.einsum("ij,ij->i", normal, normal[first][which]) < _PARALLEL).any())

    def _follow(self, h: float, knock: FloatArray) -> bool:
        """Pass hits on to who is hit; whether contacts must be looked for again."""
        contact, sleep = self._d.contact, self._sleep
        pair = self._body_of_geom[contact.geom]
        between = pair.min(axis=1) >= 0
        if sleep.fixed.any():
            still = np.append(sleep.asleep, True)[pair].all(axis=1)  # -1, the field, is the last
            contact.exclude[still] = 1
            between &= ~still
        some = np.nonzero(between)[0]
        if not len(some):
            return False
        pair = pair[some]
        normal, at = contact.frame[some, :3], contact.pos[some]
        closing = 1.5 * (self._approach(pair[:, 0], normal, at) - self._approach(pair[:, 1], normal, at))
        gap = contact.dist[some]
        lost = np.maximum(gap, 0.0) / h  # who is hit has only the rest of the step to move in
        is_new = False
        for _ in range(_LONGEST_ROW):
            passed_on = np.maximum(closing, knock[pair].max(axis=1))
            touched = gap <= passed_on * h
            passed_on -= lost
            hard = touched & (passed_on > _KNOCK)
            before = knock.copy()
            for side in (0, 1):
                np.maximum.at(knock, pair[hard, side], passed_on[hard])
            if not (knock > 1.05 * before + _KNOCK).any():
                break
            is_new = True
        sleeps = (sleep.asleep & ~sleep.fixed)[pair]
        contact.exclude[some[~touched & sleeps.any(axis=1)]] = 1
        woken = pair[touched][sleeps[touched]]
        if len(woken):
            sleep.asleep[woken] = False
            sleep.mark()
            sleep.write()
        return is_new or bool(len(woken))

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
