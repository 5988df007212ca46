"""Flights of pieces through the air, outside of the engine, and what is in their way.

The equation of motion of a ball, with k and the lift's share from `simcore.pieces.aerodynamics`; its spin stays:

    dx/dt = v,   dv/dt = -g e_z - k |v| v + c (omega x v)

One step is the midpoint rule: second order, exact without air, and within 0.01 mm after 20 ms at k v^2 = 20 m/s^2
(0.5 mm after 3 s at 15 m/s, against `scipy.integrate.solve_ivp`). So a tick is step enough. A piece that leaves a
muzzle is in the match at the end of the tick, where it has flown to by then; what is in its way until then is asked
here, with rays that stand for the piece: a wall, the carpet under a robot that lies on its head, another robot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from simcore.geometry.rotation import Vector
from simcore.physics.world import PhysicsWorld
from simcore.pieces.aerodynamics import AirFactors, air_acceleration
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import GRAVITY, TICK

__all__ = ["SQUEEZE", "FlightState", "advance", "crossing", "free_shares", "muzzle_obstacle", "path"]

SQUEEZE = 0.9
"""Of a piece's radius that must be free where it leaves: a foam piece gives by the rest."""


def advance(
    pos: FloatArray, vel: FloatArray, spin: FloatArray, air: AirFactors, dt: float | FloatArray, *,
    gravity: float = GRAVITY,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Positions [m] and velocities [m/s] of pieces after one step of the midpoint rule, shape (n, 3) each.

    Args:
        pos: Of the centers [m], shape (n, 3).
        vel: Through the air, field frame [m/s], shape (n, 3).
        spin: Angular velocities, which stay [rad/s], shape (n, 3).
        air: Of all pieces, or of each.
        dt: How long [s], for all or, as shape (n, 1), for each.
        gravity: Along -z [m/s^2].
    """
    acc = air_acceleration(vel, spin, air)
    acc[:, 2] -= gravity
    middle = vel + 0.5 * dt * acc
    acc = air_acceleration(middle, spin, air)
    acc[:, 2] -= gravity
    return pos + dt * middle, vel + dt * acc


@dataclass(slots=True, kw_only=True)
class FlightState:
    """Balls in the air at one instant, one a row, field frame."""

    pos: FloatArray
    """Centers [m], shape (n, 3)."""
    vel: FloatArray
    """[m/s], shape (n, 3)."""
    spin: FloatArray
    """Angular velocity [rad/s], shape (n, 3)."""
    radius: FloatArray
    """[m], shape (n,)."""
    air: AirFactors
    """Of each."""

    def __len__(self) -> int:
        return len(self.pos)

    def only(self, rows: IntArray | BoolArray) -> FlightState:
        """Some of them, as arrays of their own."""
        return FlightState(
            pos=self.pos[rows], vel=self.vel[rows], spin=self.spin[rows], radius=self.radius[rows],
            air=AirFactors(*(np.asarray(one)[rows] for one in self.air)),
        )  # fmt: skip

    def advanced(self, dt: float | FloatArray, *, gravity: float = GRAVITY) -> FlightState:
        """The same balls after a time [s], one for all or shape (n, 1)."""
        pos, vel = advance(self.pos, self.vel, self.spin, self.air, dt, gravity=gravity)
        return replace(self, pos=pos, vel=vel)


def path(flights: FlightState, steps: int, *, dt: float = TICK, gravity: float = GRAVITY) -> FloatArray:
    """Centers after 0, 1 ... steps of dt [s] if nothing is in the way [m], shape (steps + 1, n, 3)."""
    points = np.empty((steps + 1, len(flights), 3))
    points[0] = flights.pos
    for step in range(steps):
        flights = flights.advanced(dt, gravity=gravity)
        points[step + 1] = flights.pos
    return points


def crossing(start: FloatArray, end: FloatArray, point: FloatArray, normal: FloatArray) -> FloatArray:
    """Share of straight ways at which they pass a plane in the direction of its normal, infinite where they do not.

    Args:
        start: Where they begin [m], shape (n, 3).
        end: Where they end [m], shape (n, 3).
        point: Of the plane [m], shape (3,).
        normal: Of the plane, shape (3,).
    """
    before, after = (start - point) @ normal, (end - point) @ normal
    passes = (before < 0.0) & (after >= 0.0)
    share: FloatArray = np.where(passes, before / np.where(passes, before - after, 1.0), np.inf)
    return share


# --- what is in the way ---------------------------------------------------------------------------------------------


def _ball() -> FloatArray:
    """Center of a unit ball, and 14 points around it: along the axes and along the diagonals, shape (15, 3)."""
    corners = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, -1).T / math.sqrt(3.0)
    return np.vstack([np.zeros((1, 3)), np.eye(3), -np.eye(3), corners])


def _disk() -> FloatArray:
    """Center of a unit disk and points on three rings of it, shape (49, 2): a bar of a third of its radius is met."""
    rings = [np.zeros((1, 2))]
    for number in (1, 2, 3):
        turn = np.arange(8 * number) * math.tau / (8 * number)
        rings.append(np.column_stack([np.cos(turn), np.sin(turn)]) * number / 3.0)
    return np.vstack(rings)


_BALL, _DISK = _ball(), _disk()


def muzzle_obstacle(world: PhysicsWorld, inside: Vector, muzzle: Vector, radius: float, *, robot: int) -> int:
    """Row of the part of the field or the robot that keeps a piece from being at a muzzle, -1 if it is free.

    A wall may be between robot and muzzle, or the muzzle in it. So nothing may be met on the ways from a place inside
    of the robot, where no wall can be, to the piece's center and to points around it.

    Args:
        world: What may be in the way.
        inside: A place in the robot's body, field frame [m].
        muzzle: Center of the piece, field frame [m].
        radius: Of the largest ball in the piece [m].
        robot: Row of the robot that shoots.
    """
    ends = np.array(muzzle) + SQUEEZE * radius * _BALL
    _, rows = world.first_obstacles(np.repeat(np.array([inside]), len(ends), axis=0), ends, ignore=robot)
    return int(rows.max())


def free_shares(world: PhysicsWorld, start: FloatArray, end: FloatArray, radius: float, *, robot: int) -> FloatArray:
    """Share of each of n straight ways that a piece can go before it touches something, 0 to 1, shape (n,).

    Args:
        world: What may be in the way.
        start: Centers of the piece, field frame [m], shape (n, 3); the piece is free there.
        end: Where it goes [m], shape (n, 3).
        radius: Of the largest ball in the piece [m].
        robot: Row of the robot that shot it, which it does not touch.
    """
    way = end - start
    length = np.maximum(np.linalg.norm(way, axis=1), 1e-9)
    ahead = way / length[:, None]
    across = np.cross(ahead, np.eye(3)[np.argmin(np.abs(ahead), axis=1)])
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-9)[:, None]
    disk = _DISK @ np.stack([across, np.cross(ahead, across)], axis=1)  # (n, 49, 3)
    rays = start[:, None, :] + SQUEEZE * radius * disk
    # the ball's front, ahead of each of the points on its disk
    front = radius * np.sqrt(1.0 - (SQUEEZE**2) * np.einsum("ij,ij->i", _DISK, _DISK))
    reach = length[:, None] + front
    ends = rays + reach[:, :, None] * ahead[:, None, :]
    fraction, rows = world.first_obstacles(rays.reshape(-1, 3), ends.reshape(-1, 3), ignore=robot)
    met = rows.reshape(reach.shape) >= 0
    free = np.where(met, fraction.reshape(reach.shape) * reach - front, length[:, None]).min(axis=1)
    shares: FloatArray = np.clip(free / length, 0.0, 1.0)
    return shares
