"""State of balls, memory of ball contacts, and floor properties, as structs of arrays."""

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
    """Whether each row is a ball, shape (n,); the loop skips rows that are not balls."""
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
    """Parameters k1 [N/m], k3 [N/m^3], d0 [m] and k2 [N/m^2] of `foam_force` for each ball, shape (n, 4)."""
    surface: FloatArray
    """Friction factor [-], restitution factor [-] and rolling-resistance lever [m] of each ball, shape (n, 3)."""
    air: FloatArray
    """Aerodynamic factors of each ball: drag [1/m], lift [-], lift saturation [m] and spin drag [-], shape (n, 4)."""
    still: FloatArray
    """Time for which each ball has been supported and slow [s], shape (n,)."""
    calm: FloatArray
    """Speed of each ball at the start of the time `still` [m/s], shape (n,)."""
    load: FloatArray
    """Sum of the normal forces of bodies on each ball in the ball's last step awake [N], shape (n,)."""
    press: FloatArray
    """Largest normal force of another ball on each ball in the ball's last step awake [N], shape (n,)."""
    hold: FloatArray
    """Force that frees a lodged ball [N], 0 for balls that are not lodged, shape (n,)."""
    is_put: npt.NDArray[np.uint8]
    """`JUST_PUT` before the ball's first step, then 1 until the initial overlaps are gone, then 0, shape (n,)."""
    leaves: IntArray
    """Index of the body that launched each ball, -1 for none, shape (n,); the ball does not collide with this body
    until the ball has left the body."""
    contacts: IntArray
    """Number of contacts in the last step, shape (n,)."""
    is_touched: npt.NDArray[np.uint8]
    """Whether the ball has had a contact since the flag was last cleared, shape (n,)."""
    bodies: IntArray
    """Bit mask of the bodies that the ball has touched since the mask was last cleared, shape (n,)."""

    def only(self, rows: slice | npt.NDArray[np.bool_]) -> Balls:
        """Return the selected balls: views of the arrays for a slice, copies for a mask."""
        columns: list[Any] = [column[rows] for column in self]
        return Balls(*columns)


class Memory(NamedTuple):
    """Memory of ball contacts between steps, one row per ball and up to 16 contacts per row."""

    key: IntArray
    """Key of the floor, solid or other ball in each contact, shape (n, 16)."""
    stamp: IntArray
    """Number of the last step with each contact, shape (n, 16)."""
    spring: FloatArray
    """Stretch x, y, z of the friction spring, field frame [m]; remaining initial overlap [m]; memory of the foam [-];
    energy of the foam in the last step [J], shape (n, 16, 6)."""
    clock: IntArray
    """Number of the present step, shape (1,)."""

    def only(self, rows: npt.NDArray[np.bool_]) -> Memory:
        """Return a memory with copies of the selected rows and the same `clock` array."""
        return Memory(self.key[rows], self.stamp[rows], self.spring[rows], self.clock)


class Floor(NamedTuple):
    """Properties of the floor, gravity, and whether balls collide with each other."""

    gravity: float
    """Gravitational acceleration, downward [m/s^2]."""
    is_there: bool
    """Whether there is a floor at z = 0."""
    friction: float
    """Friction factor of the floor [-]."""
    restitution: float
    """Restitution factor of the floor [-]."""
    rolling: float
    """Rolling-resistance lever of the floor [m]."""
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
    """Return the magnitude of the vector in row i of an array, shape (n, 3)."""
    return math.sqrt(v[i, 0] * v[i, 0] + v[i, 1] * v[i, 1] + v[i, 2] * v[i, 2])


@inlined
def sleeps(status, i):
    """Return whether ball i is on the field and does not move: asleep or placed."""
    return status[i] == ASLEEP or status[i] == PLACED


@inlined
def to_body(axes, b, x, y, z):
    """Transform a vector from field axes to the axes of body b."""
    return (
        axes[b, 0, 0] * x + axes[b, 1, 0] * y + axes[b, 2, 0] * z,
        axes[b, 0, 1] * x + axes[b, 1, 1] * y + axes[b, 2, 1] * z,
        axes[b, 0, 2] * x + axes[b, 1, 2] * y + axes[b, 2, 2] * z,
    )


@inlined
def to_field(axes, b, x, y, z):
    """Transform a vector from the axes of body b to field axes."""
    return (
        axes[b, 0, 0] * x + axes[b, 0, 1] * y + axes[b, 0, 2] * z,
        axes[b, 1, 0] * x + axes[b, 1, 1] * y + axes[b, 1, 2] * z,
        axes[b, 2, 0] * x + axes[b, 2, 1] * y + axes[b, 2, 2] * z,
    )
