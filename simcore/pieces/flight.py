"""Simulated flights of many balls at once, with the same loop as in a match (`simcore.loop.balls`).

Balls collide with field elements, but not with other balls or moving objects. `fly_shots` simulates shots until all
shots have scored or missed. `muzzle_obstacle` finds an obstacle at the muzzle of a launch in a match.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simcore.loop.state import IN_FLIGHT, Balls, make_balls, make_memory
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.shot_opening import ShotOpening
from simcore.typing import BoolArray, FloatArray
from simcore.world.ball_dynamics import StandingField
from simcore.world.rotation import Vector
from simcore.world.world import PhysicsWorld
from simcore.world.zones import Zone

__all__ = [
    "FLIGHT_STEP",
    "LONGEST",
    "SQUEEZE",
    "ShotOutcomes",
    "cannot_rise",
    "fly_shots",
    "flying_balls",
    "muzzle_obstacle",
]

FLIGHT_STEP = 0.005
"""Time step between samples of a flight [s]; the loop divides this step into shorter steps."""
PER_TICK = 4
"""Number of flight steps per tick; `fly_shots` checks for scores at the end of each tick."""
LONGEST = 1200
"""Number of flight steps after which a shot counts as a miss; 6 s, the time of a flight up to a height of 40 m."""
SQUEEZE = 0.9
"""Fraction of a piece's radius that must be free at the muzzle [-]; the foam can be compressed by the rest."""
_LEFT = 0.75  # fraction of balls still in flight below which the arrays are compacted


def flying_balls(
    kind: GamePieceConfig, pos: FloatArray, vel: FloatArray, spin: FloatArray, *, mass: float | FloatArray = 1.0,
    diameter: float | FloatArray = 1.0, drag: float | FloatArray = 1.0,
) -> Balls:  # fmt: skip
    """Create the balls of n launches of a kind.

    For a shape other than a ball, the function uses the largest sphere inside the shape. As in a match, the diameter
    changes the aerodynamics of a ball, but not the collision radius.

    Args:
        kind: Kind of all balls.
        pos: Centers, field frame [m], shape (n, 3).
        vel: Velocities, field frame [m/s], shape (n, 3).
        spin: Angular velocities, field frame [rad/s], shape (n, 3).
        mass: Factor on the mass of the kind [-], one value or shape (n,).
        diameter: Factor on the diameter of the kind [-], one value or shape (n,).
        drag: Factor on the drag coefficient of the kind [-], one value or shape (n,).
    """
    balls, air = make_balls(np.full(len(pos), IN_FLIGHT, np.uint8), pos.copy(), vel.copy()), kind.air
    balls.is_ball[:], balls.spin[:], balls.radius[:], balls.foam[:] = 1, spin, kind.inner_radius, kind.foam
    balls.surface[:] = kind.friction, kind.restitution, kind.rolling
    balls.mass[:] = kind.mass * mass
    balls.air[:] = air
    balls.air[:, 0] *= drag * diameter**2 / mass
    balls.air[:, 1] *= diameter**3 / mass
    return balls


def cannot_rise(balls: Balls, height: float, gravity: float) -> BoolArray:
    """Return whether each ball has no contact and too little energy to reach a height [m], shape (n,).

    The energy includes the rotation of a solid ball.
    """
    vel, rim = balls.vel, balls.radius[:, None] * balls.spin
    energy = 0.5 * np.einsum("ij,ij->i", vel, vel) + 0.2 * np.einsum("ij,ij->i", rim, rim)  # of a solid ball
    spent: BoolArray = (energy + gravity * (balls.pos[:, 2] - height) < 0.0) & (balls.contacts == 0)
    return spent


@dataclass(slots=True, kw_only=True)
class ShotOutcomes:
    """Outcomes of n shots, one array element or row per shot."""

    goes_in: BoolArray
    """Whether each shot scored."""
    by_board: BoolArray
    """Whether each shot touched an object behind and above the opening before the passage through the opening."""
    by_rim: BoolArray
    """Whether each shot touched another object, such as the rim, before the passage through the opening."""
    time: FloatArray
    """Time from the muzzle to the first passage through the opening [s]; NaN without a passage."""
    place: FloatArray
    """Position at the first passage through the opening, field frame [m], shape (n, 3); NaN without a passage."""
    vel: FloatArray
    """Velocity at the first passage through the opening, field frame [m/s], shape (n, 3); NaN without a passage."""


def fly_shots(
    field: StandingField, balls: Balls, opening: ShotOpening, zone: Zone, *, downward: bool = True, clean: bool = False
) -> ShotOutcomes:
    """Simulate shots until each shot has scored or can no longer score, for at most 6 s.

    Args:
        field: Field elements that the shots can touch.
        balls: Balls at the muzzles; the function modifies the arrays.
        opening: Opening of the goal.
        zone: Zone in which balls score.
        downward: Whether only falling balls score.
        clean: Whether to end the simulation of shots that miss the opening, or touch the rim or an obstacle.

    Returns:
        Outcome of each shot, in the order of the balls.
    """
    n = len(balls.status)
    found = ShotOutcomes(
        goes_in=np.zeros(n, dtype=bool), by_board=np.zeros(n, dtype=bool), by_rim=np.zeros(n, dtype=bool),
        time=np.full(n, np.nan), place=np.full((n, 3), np.nan), vel=np.full((n, 3), np.nan),
    )  # fmt: skip
    middle, inward = opening.middle, opening.inward
    ahead = np.array([math.cos(opening.approach), math.sin(opening.approach), 0.0])
    row, memory = np.arange(n), make_memory(n)
    for number in range(LONGEST):
        if number % PER_TICK == 0:
            as_it_began, is_over = balls.pos.copy(), np.zeros(len(row), dtype=bool)
        before, depth_before = balls.pos.copy(), (balls.pos - middle) @ inward
        field.fly(balls, memory, FLIGHT_STEP)
        depth = (balls.pos - middle) @ inward
        is_early = (balls.is_touched > 0) & np.isnan(found.time[row])
        balls.is_touched[:] = 0
        is_behind = (depth < -balls.radius) & ((balls.pos - middle) @ ahead > 0.0)
        found.by_board[row[is_early & is_behind]] = True
        found.by_rim[row[is_early & ~is_behind]] = True
        passes = np.nonzero((depth_before < 0.0) & (depth >= 0.0))[0]
        if len(passes):
            share = depth_before[passes] / (depth_before - depth)[passes]
            place = before[passes] + share[:, None] * (balls.pos - before)[passes]
            within = opening.holds(place)
            first = within & np.isnan(found.time[row[passes]])  # False after a ball has bounced out of the opening
            there = row[passes[first]]
            found.place[there], found.vel[there] = place[first], balls.vel[passes[first]]
            found.time[there] = FLIGHT_STEP * (number + share[first])
            is_over[passes[~within]] = clean
        if (number + 1) % PER_TICK == 0:
            falls = balls.pos[:, 2] < as_it_began[:, 2]
            scores = zone.crossed(as_it_began, balls.pos) & (falls | (not downward)) & (balls.status > 0)
            found.goes_in[row[scores]] = True
            is_over |= scores | (found.by_rim[row] & clean) | cannot_rise(balls, zone.box[0][2], field.floor.gravity)
            balls.status[is_over] = 0
            left = balls.status > 0
            if not left.any():
                break
            if np.count_nonzero(left) < _LEFT * len(row):
                balls, memory, row = balls.only(left), memory.only(left), row[left]
    return found


# --- obstacles at a muzzle --------------------------------------------------------------------------------------------


def _ball() -> FloatArray:
    """Return the center of a unit sphere and 14 points on the surface, on axes and diagonals, shape (15, 3)."""
    corners = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, -1).T / math.sqrt(3.0)
    return np.vstack([np.zeros((1, 3)), np.eye(3), -np.eye(3), corners])


_BALL = _ball()


def muzzle_obstacle(world: PhysicsWorld, inside: Vector, muzzle: Vector, radius: float, *, robot: int) -> int:
    """Return the row of the field element or robot that blocks a piece at a muzzle, or -1 if the muzzle is free.

    A wall may be between the robot and the muzzle, or around the muzzle. The function therefore casts rays from a point
    inside the robot, where no wall can be, to the piece's center and to points on a sphere around the center.

    Args:
        world: World with the possible obstacles.
        inside: Point inside the robot's body, field frame [m].
        muzzle: Center of the piece at the muzzle, field frame [m].
        radius: Radius of the largest sphere inside the piece [m].
        robot: Row of the shooting robot.
    """
    ends = np.array(muzzle) + SQUEEZE * radius * _BALL
    _, rows = world.first_obstacles(np.repeat(np.array([inside]), len(ends), axis=0), ends, ignore=robot)
    return int(rows.max())
