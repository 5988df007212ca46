"""State of balls, as structs of arrays."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from simcore.loop.compiled import inlined
from simcore.typing import FloatArray, IntArray

__all__ = [
    "ASLEEP",
    "AWAKE",
    "IN_FLIGHT",
    "JUST_PUT",
    "NOBODY",
    "PLACED",
    "REMEMBERED",
    "Balls",
    "Floor",
    "Memory",
    "make_balls",
    "make_memory",
    "sleeps",
    "speed",
    "to_body",
    "to_field",
]

ASLEEP, AWAKE, IN_FLIGHT, PLACED = 2, 3, 5, 7
"""Statuses of balls that are on the field (`simcore.pieces.pool.PieceStatus`); of all others the loop knows nothing."""
NOBODY = -1
JUST_PUT = 2
REMEMBERED = 16
"""Contacts of a ball whose friction is remembered."""


class Balls(NamedTuple):
    """Balls of a world, one row each."""

    is_ball: npt.NDArray[np.uint8]
    """Rows that are no balls are left alone, shape (n,)."""
    status: npt.NDArray[np.uint8]
    """A `PieceStatus`, shape (n,)."""
    pos: FloatArray
    """Center, field frame [m], shape (n, 3)."""
    vel: FloatArray
    """[m/s], shape (n, 3)."""
    spin: FloatArray
    """Angular velocity, field frame [rad/s], shape (n, 3)."""
    quat: FloatArray
    """Attitude x, y, z, w, shape (n, 4)."""
    radius: FloatArray
    """[m], shape (n,)."""
    mass: FloatArray
    """[kg], shape (n,)."""
    foam: FloatArray
    """k1 [N/m], k3 [N/m^3], and from where [m] and how [N/m^2] it is dense, shape (n, 4); see `foam_force`."""
    surface: FloatArray
    """Friction [-], restitution [-] and rolling lever [m], shape (n, 3)."""
    air: FloatArray
    """Drag [1/m], lift [-], lift's saturation [m], and how spin fades [-], shape (n, 4)."""
    still: FloatArray
    """Time for which each has been supported and slow [s], shape (n,)."""
    calm: FloatArray
    """Speed of each as that began [m/s], shape (n,)."""
    load: FloatArray
    """Force of bodies of the engine on it, in its last step awake [N], shape (n,)."""
    press: FloatArray
    """Largest force of another ball on it, in its last step awake [N], shape (n,)."""
    hold: FloatArray
    """Force that a ball is wedged in with [N], 0: it is not, shape (n,)."""
    is_put: npt.NDArray[np.uint8]
    """`JUST_PUT` before its first step, 1 until it has come out of what it was put into, 0 after that, shape (n,)."""
    leaves: IntArray
    """Body that it was launched from and that it does not touch before it is out of it, -1: none, shape (n,)."""
    contacts: IntArray
    """Contacts in the last step, shape (n,)."""
    is_touched: npt.NDArray[np.uint8]
    """Whether it has touched anything since somebody cleared this, shape (n,)."""
    bodies: IntArray
    """Marks of the bodies that it has touched since somebody cleared this, shape (n,)."""

    def only(self, rows: slice | npt.NDArray[np.bool_]) -> Balls:
        """Return some of the balls: for a slice as views of these arrays, for a mask as copies."""
        columns: list[Any] = [column[rows] for column in self]
        return Balls(*columns)


class Memory(NamedTuple):
    """Contacts, by the ball that remembers each."""

    key: IntArray
    """Key of the thing that is touched, shape (n, 16)."""
    stamp: IntArray
    """Step in which it was touched last, shape (n, 16)."""
    spring: FloatArray
    """Stretch of the friction spring, field frame, and how deep the ball was put into what it touches, as far as that
    has not been pushed out [m]; memory of the foam [-] and its energy in the last step [J], shape (n, 16, 6)."""
    clock: IntArray
    """Number of the step, shape (1,)."""

    def only(self, rows: npt.NDArray[np.bool_]) -> Memory:
        """Return the memory of some of the balls, as copies."""
        return Memory(self.key[rows], self.stamp[rows], self.spring[rows], self.clock)


class Floor(NamedTuple):
    """Properties that are the same everywhere."""

    gravity: float
    """[m/s^2]"""
    is_there: bool
    """Whether there is a floor at z = 0."""
    friction: float
    restitution: float
    rolling: float
    """Lever [m]."""
    with_pairs: bool
    """Whether balls touch each other."""


def make_balls(status: npt.NDArray[np.uint8], pos: FloatArray, vel: FloatArray) -> Balls:
    """Make arrays of n balls, of which the first three are given."""
    n = len(status)
    return Balls(
        is_ball=np.zeros(n, np.uint8), status=status, pos=pos, vel=vel, spin=np.zeros((n, 3)),
        quat=np.tile((0.0, 0.0, 0.0, 1.0), (n, 1)), radius=np.full(n, 0.1), mass=np.ones(n), foam=np.ones((n, 4)),
        surface=np.zeros((n, 3)), air=np.zeros((n, 4)), still=np.zeros(n), calm=np.zeros(n), load=np.zeros(n),
        press=np.zeros(n), hold=np.zeros(n), is_put=np.zeros(n, np.uint8), leaves=np.full(n, -1),
        contacts=np.zeros(n, np.int64), is_touched=np.zeros(n, np.uint8), bodies=np.zeros(n, np.int64),
    )  # fmt: skip


def make_memory(count: int) -> Memory:
    """Make the memory of so many balls, that remember nothing."""
    return Memory(
        key=np.full((count, REMEMBERED), np.iinfo(np.int64).min), stamp=np.full((count, REMEMBERED), -2),
        spring=np.zeros((count, REMEMBERED, 6)), clock=np.zeros(1, np.int64),
    )  # fmt: skip


@inlined
def speed(v, i):
    """Return the length of row i of an array of vectors."""
    return math.sqrt(v[i, 0] * v[i, 0] + v[i, 1] * v[i, 1] + v[i, 2] * v[i, 2])


@inlined
def sleeps(status, i):
    """Return whether ball i is on the field and stands still."""
    return status[i] == ASLEEP or status[i] == PLACED


@inlined
def to_body(axes, b, x, y, z):
    """Transform a vector from the field frame to a body's frame."""
    return (
        axes[b, 0, 0] * x + axes[b, 1, 0] * y + axes[b, 2, 0] * z,
        axes[b, 0, 1] * x + axes[b, 1, 1] * y + axes[b, 2, 1] * z,
        axes[b, 0, 2] * x + axes[b, 1, 2] * y + axes[b, 2, 2] * z,
    )


@inlined
def to_field(axes, b, x, y, z):
    """Transform a vector from a body's frame to the field frame."""
    return (
        axes[b, 0, 0] * x + axes[b, 0, 1] * y + axes[b, 0, 2] * z,
        axes[b, 1, 0] * x + axes[b, 1, 1] * y + axes[b, 1, 2] * z,
        axes[b, 2, 0] * x + axes[b, 2, 1] * y + axes[b, 2, 2] * z,
    )
