"""State of balls as structs of arrays."""

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
"""Statuses of balls on the field (`simcore.pieces.pool.PieceStatus`); the loop ignores balls of all other statuses."""
NOBODY = -1
JUST_PUT = 2
REMEMBERED = 16
"""Largest number of contacts in the memory of a ball."""


class Balls(NamedTuple):
    """Balls of a world, one row per ball."""

    is_ball: npt.NDArray[np.uint8]
    """Whether the row is a ball, shape (n,); the loop skips other rows."""
    status: npt.NDArray[np.uint8]
    """`PieceStatus` of each ball, shape (n,)."""
    pos: FloatArray
    """Center, field frame [m], shape (n, 3)."""
    vel: FloatArray
    """Velocity of the center, field frame [m/s], shape (n, 3)."""
    spin: FloatArray
    """Angular velocity, field frame [rad/s], shape (n, 3)."""
    quat: FloatArray
    """Attitude quaternion (x, y, z, w), shape (n, 4)."""
    radius: FloatArray
    """Radius [m], shape (n,)."""
    mass: FloatArray
    """Mass [kg], shape (n,)."""
    foam: FloatArray
    """Parameters k1 [N/m], k3 [N/m^3], d0 [m] and k2 [N/m^2] of `foam_force`, shape (n, 4)."""
    surface: FloatArray
    """Friction [-], restitution [-] and rolling-resistance lever [m], shape (n, 3)."""
    air: FloatArray
    """Drag [1/m], lift [-], saturation of lift [m] and decay of spin [-], shape (n, 4)."""
    still: FloatArray
    """Time for which each ball has been supported and slow [s], shape (n,)."""
    calm: FloatArray
    """Speed of each ball at the start of `still` [m/s], shape (n,)."""
    load: FloatArray
    """Sum of the normal forces of bodies on each ball in the ball's last step awake [N], shape (n,)."""
    press: FloatArray
    """Largest normal force of another ball on each ball in the ball's last step awake [N], shape (n,)."""
    hold: FloatArray
    """Force that frees a lodged ball [N], 0 for balls that are not lodged, shape (n,)."""
    is_put: npt.NDArray[np.uint8]
    """`JUST_PUT` before the ball's first step, then 1 until the initial overlaps are gone, then 0, shape (n,)."""
    leaves: IntArray
    """Body that launched the ball, without contact until the ball is outside the body; -1 for none, shape (n,)."""
    contacts: IntArray
    """Number of contacts in the last step, shape (n,)."""
    is_touched: npt.NDArray[np.uint8]
    """Whether the ball has had a contact since the flag was last cleared, shape (n,)."""
    bodies: IntArray
    """Marks of the bodies that the ball has touched since the marks were last cleared, shape (n,)."""

    def only(self, rows: slice | npt.NDArray[np.bool_]) -> Balls:
        """Return the selected balls: views of the arrays for a slice, copies for a mask."""
        columns: list[Any] = [column[rows] for column in self]
        return Balls(*columns)


class Memory(NamedTuple):
    """Memory of the contacts of balls, one row per ball and 16 contacts per row."""

    key: IntArray
    """Key of the floor, solid or other ball in contact, shape (n, 16)."""
    stamp: IntArray
    """Number of the last step with this contact, shape (n, 16)."""
    spring: FloatArray
    """Stretch x, y, z of the friction spring, field frame [m]; remaining initial overlap [m]; memory of the foam [-];
    energy of the foam in the last step [J], shape (n, 16, 6)."""
    clock: IntArray
    """Number of the present step, shape (1,)."""

    def only(self, rows: npt.NDArray[np.bool_]) -> Memory:
        """Return copies of the selected rows, with the same `clock` array."""
        return Memory(self.key[rows], self.stamp[rows], self.spring[rows], self.clock)


class Floor(NamedTuple):
    """Properties of the floor, gravity, and contact between balls."""

    gravity: float
    """Gravitational acceleration, downward [m/s^2]."""
    is_there: bool
    """Whether there is a floor at z = 0."""
    friction: float
    """Coefficient of friction [-]."""
    restitution: float
    """Coefficient of restitution [-]."""
    rolling: float
    """Lever of the rolling resistance [m]."""
    with_pairs: bool
    """Whether balls collide with each other."""


def make_balls(status: npt.NDArray[np.uint8], pos: FloatArray, vel: FloatArray) -> Balls:
    """Make n balls with the given status, position and velocity, and defaults for all other arrays."""
    n = len(status)
    return Balls(
        is_ball=np.zeros(n, np.uint8), status=status, pos=pos, vel=vel, spin=np.zeros((n, 3)),
        quat=np.tile((0.0, 0.0, 0.0, 1.0), (n, 1)), radius=np.full(n, 0.1), mass=np.ones(n), foam=np.ones((n, 4)),
        surface=np.zeros((n, 3)), air=np.zeros((n, 4)), still=np.zeros(n), calm=np.zeros(n), load=np.zeros(n),
        press=np.zeros(n), hold=np.zeros(n), is_put=np.zeros(n, np.uint8), leaves=np.full(n, -1),
        contacts=np.zeros(n, np.int64), is_touched=np.zeros(n, np.uint8), bodies=np.zeros(n, np.int64),
    )  # fmt: skip


def make_memory(count: int) -> Memory:
    """Make an empty contact memory for `count` balls."""
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
    """Return whether ball i is on the field and frozen at rest: asleep or placed."""
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
