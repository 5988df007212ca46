"""State of balls and of the bodies that they push, as structs of arrays."""

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
    "Bodies",
    "Floor",
    "Memory",
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
    """All balls of a world, one row each."""

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
    """How long each has been supported and slow [s], shape (n,)."""
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
        """Some of them: of a slice in the same arrays, of a mask in arrays of their own."""
        columns: list[Any] = [column[rows] for column in self]
        return Balls(*columns)


class Memory(NamedTuple):
    """Contacts, by the ball that remembers each."""

    key: IntArray
    """What is touched, shape (n, 16)."""
    stamp: IntArray
    """Step in which it was touched last, shape (n, 16)."""
    spring: FloatArray
    """Stretch of the friction spring, field frame, and how deep the ball was put into what it touches, as far as that
    has not been pushed out [m], shape (n, 16, 4)."""
    clock: IntArray
    """Number of the step, shape (1,)."""

    def only(self, rows: npt.NDArray[np.bool_]) -> Memory:
        """Of some of the balls, in arrays of their own."""
        return Memory(self.key[rows], self.stamp[rows], self.spring[rows], self.clock)


class Bodies(NamedTuple):
    """Robots and other bodies of the engine, one row each: what it says of them, and how they move on in the loop."""

    is_active: npt.NDArray[np.uint8]
    """Whether a ball may touch it now, shape (n,)."""
    pose: FloatArray
    """Origin, field frame [m], and attitude x, y, z, w, shape (n, 7)."""
    twist: FloatArray
    """Velocity of its center of mass [m/s] and angular velocity [rad/s], field frame, shape (n, 6)."""
    yielding: FloatArray
    """Inverse mass along x and y [1/kg], and inverse moment of inertia about z [1/(kg m^2)], shape (n, 2); 0 of what
    keeps its velocity until the engine's next step: carpet holds robots up, and steps with other bodies are short."""
    middle: FloatArray
    """Center of mass in its frame, or pivot in that of the field [m], shape (n, 3)."""
    swings: npt.NDArray[np.uint8]
    """Whether it swings about a pivot, shape (n,)."""
    reach: FloatArray
    """Of the ball around its origin that holds it [m], shape (n,)."""
    solids: IntArray
    """Its first solid, and the one behind its last, shape (n, 2)."""
    mark: IntArray
    """Bit that it leaves in `Balls.bodies`, shape (n,)."""
    pos: FloatArray
    """Origin, field frame [m], shape (n, 3)."""
    axes: FloatArray
    """Its axes as columns, shape (n, 3, 3)."""
    center: FloatArray
    """Center of mass, or pivot, field frame [m], shape (n, 3)."""
    vel: FloatArray
    """Of the center [m/s], shape (n, 3)."""
    rate: FloatArray
    """Angular velocity, field frame [rad/s], shape (n, 3)."""
    impulse: FloatArray
    """What balls gave it: impulse [N s] and angular impulse about the center [N m s], shape (n, 6)."""
    lightness: FloatArray
    """Inverse mass [1/kg] and inverse principal moments of inertia [1/(kg m^2)], shape (n, 4)."""
    principal: FloatArray
    """Principal axes in its frame, as columns, shape (n, 3, 3)."""
    is_pushed: npt.NDArray[np.uint8]
    """Whether balls have changed its velocity, which is `twist` then, shape (n,)."""


class Floor(NamedTuple):
    """What is the same everywhere."""

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


@inlined
def speed(v, i):
    """Length of row i of an array of vectors."""
    return math.sqrt(v[i, 0] * v[i, 0] + v[i, 1] * v[i, 1] + v[i, 2] * v[i, 2])


@inlined
def sleeps(status, i):
    """Whether ball i is on the field and stands still."""
    return status[i] == ASLEEP or status[i] == PLACED


@inlined
def to_body(axes, b, x, y, z):
    """A vector of the field in the axes of a body."""
    return (
        axes[b, 0, 0] * x + axes[b, 1, 0] * y + axes[b, 2, 0] * z,
        axes[b, 0, 1] * x + axes[b, 1, 1] * y + axes[b, 2, 1] * z,
        axes[b, 0, 2] * x + axes[b, 1, 2] * y + axes[b, 2, 2] * z,
    )


@inlined
def to_field(axes, b, x, y, z):
    """A vector of a body in the axes of the field."""
    return (
        axes[b, 0, 0] * x + axes[b, 0, 1] * y + axes[b, 0, 2] * z,
        axes[b, 1, 0] * x + axes[b, 1, 1] * y + axes[b, 1, 2] * z,
        axes[b, 2, 0] * x + axes[b, 2, 1] * y + axes[b, 2, 2] * z,
    )
