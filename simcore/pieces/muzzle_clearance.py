"""Whether a piece can leave a muzzle, and how far it flies before it meets something.

A piece that leaves is set into the engine at the end of the tick, where it has flown to by then. So what is in its way
until then is asked here, with rays that stand for the piece: a wall, the carpet under a robot that lies on its head,
another robot. Pieces are no obstacle; they give way.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.geometry.rotation import Vector
from simcore.physics.world import PhysicsWorld
from simcore.typing import FloatArray

__all__ = ["free_share", "free_shares", "muzzle_obstacle"]

_SQUEEZE = 0.9
"""Of its radius: a foam piece gives by the rest."""


def _surface() -> FloatArray:
    """Center of a unit ball, and 14 points around it: along the axes and along the diagonals, shape (15, 3)."""
    axes = np.vstack([np.eye(3), -np.eye(3)])
    corners = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, -1).T / math.sqrt(3.0)
    return np.vstack([np.zeros((1, 3)), axes, corners])


def _disk() -> FloatArray:
    """Center of a unit disk and points on three rings of it, shape (49, 2): a bar of a third of its radius is met."""
    rings = [np.zeros((1, 2))]
    for number in (1, 2, 3):
        turn = np.arange(8 * number) * math.tau / (8 * number)
        rings.append(np.column_stack([np.cos(turn), np.sin(turn)]) * number / 3.0)
    return np.vstack(rings)


_SURFACE, _DISK = _surface(), _disk()


def muzzle_obstacle(world: PhysicsWorld, inside: Vector, muzzle: Vector, radius: float, *, robot: int) -> int:
    """Row of what keeps a piece from being at a muzzle, -1 if it is free.

    A wall may be between robot and muzzle, or the muzzle in it. So nothing may be met on the ways from a place inside
    of the robot, where no wall can be, to the piece's center and to points around it.

    Args:
        world: What may be in the way.
        inside: A place in the robot's body, field frame [m].
        muzzle: Center of the piece, field frame [m].
        radius: Of the largest ball in the piece [m].
        robot: Row of the robot that shoots.
    """
    ends = np.array(muzzle) + _SQUEEZE * radius * _SURFACE
    _, rows = world.first_obstacles(np.repeat(np.array([inside]), len(ends), axis=0), ends, ignore=robot)
    return int(rows.max())


def free_share(world: PhysicsWorld, start: Vector, end: Vector, radius: float, *, robot: int) -> float:
    """Share of a straight way that a piece can go before it touches something, 0 to 1.

    Args:
        world: What may be in the way.
        start: Center of the piece, field frame [m]; the piece is free there.
        end: Where it goes [m].
        radius: Of the largest ball in the piece [m].
        robot: Row of the robot that shot it, which it does not touch.
    """
    return float(free_shares(world, np.array([start]), np.array([end]), radius, robot=robot)[0])


def free_shares(world: PhysicsWorld, start: FloatArray, end: FloatArray, radius: float, *, robot: int) -> FloatArray:
    """The same of n ways, (n, 3) each [m]; shape (n,)."""
    way = end - start
    length = np.maximum(np.linalg.norm(way, axis=1), 1e-9)
    ahead = way / length[:, None]
    across = np.cross(ahead, np.eye(3)[np.argmin(np.abs(ahead), axis=1)])
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-9)[:, None]
    disk = _DISK @ np.stack([across, np.cross(ahead, across)], axis=1)  # (n, 49, 3)
    rays = start[:, None, :] + _SQUEEZE * radius * disk
    # the ball's front, ahead of each of the points on its disk
    front = radius * np.sqrt(1.0 - (_SQUEEZE**2) * np.einsum("ij,ij->i", _DISK, _DISK))
    reach = length[:, None] + front
    ends = rays + reach[:, :, None] * ahead[:, None, :]
    fraction, rows = world.first_obstacles(rays.reshape(-1, 3), ends.reshape(-1, 3), ignore=robot)
    met = rows.reshape(reach.shape) >= 0
    free = np.where(met, fraction.reshape(reach.shape) * reach - front, length[:, None]).min(axis=1)
    shares: FloatArray = np.clip(free / length, 0.0, 1.0)
    return shares
